//! The traced suns of a view, as light on its pixels and as discs.

use crate::error::Result;
use crate::glare::Disc;
use crate::kernels::glare::{Added, AddedLight, Additions};
use crate::kernels::sun_matrix::pixels::SeenDisc;
use crate::simulate::results::illuminance::luminous;
use crate::simulate::store::sun_pictures::SunPictures;

/// The suns' light in the pictures of a view, or at its eye.
pub(super) struct SunLight<'a> {
    pub pictures: SunPictures,
    pub hours: &'a [usize],
}

impl Additions for SunLight<'_> {
    fn of_hour(&self, hour: usize) -> Result<Added> {
        let lit = self.pictures.sun_picture_with_discs(self.hours[hour])?;
        let errors = lit.errors.iter().zip(&lit.shared_errors);
        let light = |(&(pixel, v), (&error, &shared_error)): (&(u32, [f32; 3]), (&f32, &f32))| AddedLight {
            pixel,
            luminance: luminous(&v) as f32,
            error,
            shared_error,
        };
        let disc = |d: &SeenDisc| Disc {
            direction: d.direction.map(f64::from),
            luminance: luminous(&d.radiance),
            solid_angle: f64::from(d.solid_angle),
            error: f64::from(d.error),
        };
        Ok(Added {
            pixels: lit.pixels.iter().zip(errors).map(light).collect(),
            discs: lit.discs.iter().map(disc).collect(),
            shared: lit.shared,
        })
    }
}

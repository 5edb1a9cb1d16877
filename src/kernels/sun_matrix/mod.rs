//! Sun matrix Cds: what each receiver gets from each sun through the windows.
//!
//! `C[receiver][sun]` is the irradiance per unit radiance of the sun's disc (sr): Ω·cos θ where
//! nothing is in the way, as `rcontrib -I+ -m solar` has it.
//!
//! | part | estimator | module |
//! |---|---|---|
//! | straight through openings, panes and between slats | low-discrepancy points of the disc, a ray each | [`geometry`] |
//! | suns in pictures: lit surfaces, lit slats, the disc itself | the same for the surface behind each pixel, of which those that may see a sun are listed first; rays to points of the disc | [`pixels`] |
//! | by way of flat mirror-like slats | the same for the sun's images in them | [`mirrors`] |
//! | scattered once by a BSDF pane | quadrature over the window | [`pane`] |
//! | scattered diffusely by slats and other surfaces | points on them that all receivers share, where these tell more | `shades` |
//! | the same for few suns or receivers, next to the surfaces, by rough or mirror-like ones, seen in panes | paths from the receiver, whose vertices serve *all* suns | [`geometry`] |

#[cfg(test)]
mod coverage;
pub mod geometry;
#[cfg(test)]
mod mirror_tests;
pub mod mirrors;
#[cfg(test)]
mod pair_tests;
mod pairs;
pub mod pane;
pub mod pixels;
#[cfg(test)]
pub(crate) mod reference;
mod shade_cells;
#[cfg(test)]
mod shade_tests;
mod shades;
#[cfg(test)]
mod tests;
mod tracer;

use crate::units::{SUN_DIAMETER_DEG, cap_solid_angle};
use glam::DVec3;

/// A sun: a disc of constant radiance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit vector towards its centre.
    pub direction: DVec3,
    /// Angular radius, radians; 0 for a point.
    pub radius: f64,
}

impl Sun {
    /// Angular radius of the real sun, radians.
    pub const RADIUS: f64 = SUN_DIAMETER_DEG / 2.0 * std::f64::consts::PI / 180.0;

    /// The real sun in this direction (of any length but zero).
    pub fn new(direction: DVec3) -> Self {
        Self { direction: direction.normalize(), radius: Self::RADIUS }
    }

    /// All of its light from its centre.
    #[must_use]
    pub fn as_point(self) -> Self {
        Self { radius: 0.0, ..self }
    }

    /// Solid angle it counts with, sr: its disc's, or for a point that of the real sun.
    pub fn solid_angle(&self) -> f64 {
        cap_solid_angle(if self.radius == 0.0 { Self::RADIUS } else { self.radius })
    }

    /// Length of the chord from the centre to the rim on the unit sphere.
    pub fn chord(&self) -> f64 {
        2.0 * (self.radius / 2.0).sin()
    }
}

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<crate::gpu::Shader> {
    let mut all = tracer::registered();
    all.extend(pixels::registered());
    all.extend(pane::registered());
    all.extend(shades::registered());
    all
}

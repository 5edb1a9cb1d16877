//! The sky's patches as gendaymtx sees them: centres, solid angles, and which lie near the sun.

use super::cie::CieMoment;
use super::perez::Distribution;
use crate::bins::ReinhartSky;
use glam::DVec3;
use std::f64::consts::PI;

/// Patches that share the sun among them.
const SUN_PATCHES: usize = 4;

/// Centres and solid angles of all bins, the ground (0) included.
pub(super) struct Patches {
    centres: Vec<DVec3>,
    solid_angles: Vec<f64>,
    /// First index and number of patches of each row from the horizon up, the zenith's last.
    rows: Vec<(usize, usize)>,
}

impl Patches {
    /// Angles are rounded to single precision, as gendaymtx keeps them: when the sun stands exactly
    /// between two patches, rounding decides which is nearer, and it must decide alike.
    pub(super) fn new(sky: ReinhartSky) -> Self {
        let rounded = |v: f64| f64::from(v as f32);
        let direction = |altitude: f64, azimuth: f64| {
            let (altitude, azimuth) = (rounded(altitude), rounded(azimuth));
            DVec3::new(altitude.cos() * azimuth.sin(), altitude.cos() * azimuth.cos(), altitude.sin())
        };
        let mut centres = vec![direction(-PI / 2.0, 0.0)];
        let mut rows: Vec<(usize, usize)> = Vec::new();
        for (index, (first, patches)) in sky.rows().enumerate() {
            let altitude = sky.row_height() * (index as f64 + 0.5);
            centres.extend((0..patches).map(|i| direction(altitude, 2.0 * PI * i as f64 / patches as f64)));
            rows.push((first, patches));
        }
        rows.push((centres.len(), 1));
        centres.push(direction(PI / 2.0, 0.0));
        assert_eq!(centres.len(), sky.len(), "rows, ground and zenith make up the sky");
        Self { centres, solid_angles: (0..sky.len()).map(|i| rounded(sky.solid_angle(i))).collect(), rows }
    }

    /// Direction towards the middle of a bin.
    pub(super) fn centre(&self, bin: usize) -> DVec3 {
        self.centres[bin]
    }

    /// Number of bins, the ground included.
    pub(super) fn len(&self) -> usize {
        self.centres.len()
    }

    /// Writes the relative luminance of every patch (without the ground: `sky[0]` is patch 1) and
    /// returns the relative horizontal illuminance of all.
    pub(super) fn relative_luminance(&self, distribution: &Distribution, sun: DVec3, sky: &mut [f32]) -> f64 {
        let mut horizontal = 0.0;
        for &(first, patches) in &self.rows {
            // One row has one height and one size.
            let sin_altitude = self.centres[first].z;
            let gradation = distribution.gradation(sin_altitude);
            let mut row_sum = 0.0;
            for (centre, l) in self.centres[first..first + patches].iter().zip(&mut sky[first - 1..]) {
                *l = (gradation * distribution.indicatrix(centre.dot(sun))).max(0.0) as f32;
                row_sum += f64::from(*l);
            }
            horizontal += row_sum * sin_altitude * self.solid_angles[first];
        }
        horizontal
    }

    /// The same of a CIE sky.
    pub(super) fn luminance_of(&self, moment: &CieMoment, sky: &mut [f32]) -> f64 {
        let mut horizontal = 0.0;
        for (patch, l) in sky.iter_mut().enumerate() {
            let centre = self.centres[patch + 1];
            *l = moment.radiance(centre).max(0.0) as f32;
            horizontal += f64::from(*l) * centre.z * self.solid_angles[patch + 1];
        }
        horizontal
    }

    /// Distributes direct normal irradiance over the nearest patches with weights
    /// 1/(1.002 − cos angle), or gives it to the nearest alone as the radiance of a disc of
    /// `disc` degrees.
    pub(super) fn sun(&self, sun: DVec3, direct: f64, disc: Option<f64>) -> SunPatches {
        let wanted = if disc.is_some() { 1 } else { SUN_PATCHES };
        let mut nearest = [(0usize, -1.0f64); SUN_PATCHES];
        let nearest = &mut nearest[..wanted];
        for (patch, centre) in self.centres.iter().enumerate().skip(1) {
            let cos = centre.dot(sun);
            if cos > nearest[wanted - 1].1 {
                let place = nearest.partition_point(|(_, other)| *other >= cos);
                nearest[place..].rotate_right(1);
                nearest[place] = (patch, cos);
            }
        }
        let weight = |cos: f64| 1.0 / (1.002 - cos);
        let total: f64 = nearest.iter().map(|(_, cos)| weight(*cos)).sum();
        let disc_solid_angle = disc.map(|angle| PI * (angle.to_radians() / 2.0).powi(2));
        let mut result = SunPatches::default();
        for (slot, (patch, cos)) in result.0.iter_mut().zip(nearest) {
            *slot = (*patch, direct * weight(*cos) / total / disc_solid_angle.unwrap_or(self.solid_angles[*patch]));
        }
        result
    }
}

/// Patches that hold the sun and the radiance it adds to each; patch 0 marks an empty place.
#[derive(Default, Clone, Copy)]
pub(super) struct SunPatches([(usize, f64); SUN_PATCHES]);

impl SunPatches {
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.0.iter().copied().filter(|(patch, _)| *patch != 0)
    }
}

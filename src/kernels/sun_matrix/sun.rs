//! A sun.

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
    pub(crate) const RADIUS: f64 = SUN_DIAMETER_DEG / 2.0 * std::f64::consts::PI / 180.0;

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

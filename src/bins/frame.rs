//! Local coordinate frames of windows and other directional surfaces.

use crate::error::{Error, Result};
use glam::DVec3;

/// Right-handed local frame of a surface: `z` its normal (into the room for windows), `y` its up
/// vector projected onto the surface, `x = y × z` (to the right for somebody inside who looks out).
/// The convention of Radiance's `SDcompXform`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Local x in world coordinates, unit length.
    pub x: DVec3,
    /// Local y (up) in world coordinates, unit length.
    pub y: DVec3,
    /// Local z (normal) in world coordinates, unit length.
    pub z: DVec3,
}

impl Frame {
    /// The frame of a surface with this normal and up vector (neither need have unit length).
    ///
    /// # Errors
    /// If a vector is zero or not finite, or up is parallel to the normal.
    pub fn new(normal: DVec3, up: DVec3) -> Result<Self> {
        let z = normal.try_normalize().ok_or_else(|| Error::new("the normal has no direction"))?;
        let x = up.try_normalize().map(|up| up.cross(z)).filter(|x| x.length() > 1e-6).and_then(DVec3::try_normalize).ok_or_else(|| {
            Error::new("the up vector is zero or parallel to the normal")
                .help("give another up vector: u=+Z for a wall, u=+Y for a skylight")
        })?;
        Ok(Self { x, y: z.cross(x), z })
    }

    /// The frame with rfluxmtx's default up vector: +Z, or +Y where the normal is within about 45°
    /// of vertical (|z| ≥ 0.7).
    ///
    /// # Errors
    /// If the normal is zero or not finite.
    pub(crate) fn with_default_up(normal: DVec3) -> Result<Self> {
        let n = normal.try_normalize().ok_or_else(|| Error::new("the normal has no direction"))?;
        Self::new(n, if n.z.abs() >= 0.7 { DVec3::Y } else { DVec3::Z })
    }

    /// World direction to local coordinates.
    pub(crate) fn to_local(self, world: DVec3) -> DVec3 {
        DVec3::new(world.dot(self.x), world.dot(self.y), world.dot(self.z))
    }

    /// Local direction to world coordinates.
    pub(crate) fn to_world(self, local: DVec3) -> DVec3 {
        self.x * local.x + self.y * local.y + self.z * local.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_south_window_seen_from_inside_has_west_on_its_right() {
        // The window is in the south wall; its normal points north, into the room.
        let f = Frame::new(DVec3::Y, DVec3::Z).unwrap();
        assert_eq!(f.x, -DVec3::X);
        assert_eq!(f.y, DVec3::Z);
        assert!((f.x.cross(f.y) - f.z).length() < 1e-15);
    }

    #[test]
    fn up_parallel_to_the_normal_is_refused_and_the_default_avoids_it() {
        assert!(Frame::new(DVec3::Z, DVec3::Z).is_err());
        assert!(Frame::new(DVec3::ZERO, DVec3::Z).is_err());
        assert_eq!(Frame::with_default_up(DVec3::NEG_Z).unwrap().y, DVec3::Y);
    }
}

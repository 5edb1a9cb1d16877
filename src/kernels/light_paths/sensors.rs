//! Sensors as receivers.

use crate::error::{Error, Result};
use crate::scene::points::Sensor;
use glam::Vec3;

/// Checks that sensors have a place and a direction.
///
/// # Errors
/// If one has not.
pub(crate) fn check_sensors(sensors: &[Sensor]) -> Result<()> {
    for (i, sensor) in sensors.iter().enumerate() {
        if !sensor.position.is_finite() || !sensor.direction.is_finite() || sensor.direction.length() < 1e-12 {
            return Err(Error::new(format!("sensor {} has no usable position and direction", i + 1))
                .help("each line of a points file needs x y z dx dy dz, the direction not zero"));
        }
    }
    Ok(())
}

/// A sensor that lies on a surface is moved a little to the side it faces (1e-5 of the windows'
/// size), or rounding would put it behind the surface.
pub(crate) fn beside_surface(position: Vec3, direction: Vec3) -> Vec3 {
    position + direction * (1e-5 * (position.abs().max_element() + 0.5))
}

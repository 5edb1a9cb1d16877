//! Units and conventions, stated once.
//!
//! World axes: +X east, +Y north, +Z up; lengths in metres (any unit works as long as a scene uses
//! one). Azimuth is measured from north, clockwise seen from above, unless a function says
//! otherwise. Radiometry inside: radiance in W/m²sr, irradiance in W/m²; luminance cd/m² and
//! illuminance lx only at the boundary.

/// Luminous efficacy by which Radiance turns radiance into luminance, lm/W
/// (`WHTEFFICACY` in Radiance's `color.h`).
pub const LUMINOUS_EFFICACY: f64 = 179.0;

/// Photopic weights of Radiance's RGB primaries; they sum to 1
/// (`CIE_rf`, `CIE_gf`, `CIE_bf` in Radiance's `color.h`).
pub const BRIGHTNESS_WEIGHTS: [f64; 3] = [0.265_074_126, 0.670_114_631, 0.064_811_243];

/// RGB (ir)radiance to (il)luminance: [`LUMINOUS_EFFICACY`] × [`BRIGHTNESS_WEIGHTS`], about
/// 47.448 119.951 11.601; what `rmtxop -c Y` applies.
pub const ILLUMINANCE_WEIGHTS: [f64; 3] =
    [LUMINOUS_EFFICACY * BRIGHTNESS_WEIGHTS[0], LUMINOUS_EFFICACY * BRIGHTNESS_WEIGHTS[1], LUMINOUS_EFFICACY * BRIGHTNESS_WEIGHTS[2]];

/// Extraterrestrial normal irradiance, W/m².
pub const SOLAR_CONSTANT: f64 = 1367.0;

/// Extraterrestrial normal illuminance, lx.
pub const SOLAR_CONSTANT_LUX: f64 = 127_500.0;

/// Angular diameter of the sun's disc, degrees.
pub const SUN_DIAMETER_DEG: f64 = 0.533;

/// Serializes hours, without a decimal point where they are whole.
///
/// # Errors
/// Those of the serializer.
pub fn whole_hours<S: serde::Serializer>(hours: &f64, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    if hours.fract() == 0.0 { serializer.serialize_u64(*hours as u64) } else { serializer.serialize_f64(*hours) }
}

/// Solid angle of a round cap of this angular radius (rad), sr.
pub fn cap_solid_angle(radius: f64) -> f64 {
    // 2π(1 − cos r) without loss of digits.
    4.0 * std::f64::consts::PI * (radius / 2.0).sin().powi(2)
}

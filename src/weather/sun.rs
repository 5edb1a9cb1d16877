//! Where the sun stands, as Radiance's sky generators have it (`gen/sun.c`).
//!
//! Declination and equation of time are short series of the day of the year alone: within 1.4° and
//! 0.9 minutes of Spencer's longer ones (a test holds them to it).

use crate::units::SUN_DIAMETER_DEG;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Position of the sun, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunPosition {
    /// Above the horizon; negative below.
    pub altitude: f64,
    /// From north, clockwise seen from above.
    pub azimuth: f64,
}

impl SunPosition {
    /// Unit vector towards the sun, world coordinates (+X east, +Y north, +Z up).
    pub fn direction(&self) -> DVec3 {
        let (sin_altitude, cos_altitude) = self.altitude.sin_cos();
        let (sin_azimuth, cos_azimuth) = self.azimuth.sin_cos();
        DVec3::new(cos_altitude * sin_azimuth, cos_altitude * cos_azimuth, sin_altitude)
    }

    /// Whether any of the sun's disc is above the (flat) horizon.
    pub fn is_up(&self) -> bool {
        self.altitude > -(SUN_DIAMETER_DEG / 2.0).to_radians()
    }
}

/// Declination of the sun on a day of the year (from 1), radians.
pub(crate) fn declination(day_of_year: u16) -> f64 {
    0.4093 * (TAU * (f64::from(day_of_year) - 81.0) / 365.0).sin()
}

/// Solar time minus local standard time, hours. `longitude` in degrees east, `time_zone` in hours
/// ahead of UTC.
pub(crate) fn solar_time_offset(day_of_year: u16, longitude: f64, time_zone: f64) -> f64 {
    let day = f64::from(day_of_year);
    let equation_of_time = 0.170 * (4.0 * PI * (day - 80.0) / 373.0).sin() - 0.129 * (TAU * (day - 8.0) / 355.0).sin();
    equation_of_time + (longitude - 15.0 * time_zone) / 15.0
}

/// The sun at a solar time (hours, 12 = the sun due south or north). `latitude` in degrees north.
pub(crate) fn position_at_solar_time(latitude: f64, day_of_year: u16, solar_time: f64) -> SunPosition {
    let (sin_declination, cos_declination) = declination(day_of_year).sin_cos();
    let (sin_latitude, cos_latitude) = latitude.to_radians().sin_cos();
    let (sin_hour, cos_hour) = (solar_time * PI / 12.0).sin_cos();
    let sin_altitude = sin_latitude * sin_declination - cos_latitude * cos_declination * cos_hour;
    let azimuth_from_south =
        -(cos_declination * sin_hour).atan2(-cos_latitude * sin_declination - sin_latitude * cos_declination * cos_hour);
    SunPosition { altitude: sin_altitude.clamp(-1.0, 1.0).asin(), azimuth: azimuth_from_south + PI }
}

/// The sun at a local standard time. `latitude` in degrees north, `longitude` in degrees east,
/// `time_zone` in hours ahead of UTC, `hour` 0…24.
pub fn position(latitude: f64, longitude: f64, time_zone: f64, day_of_year: u16, hour: f64) -> SunPosition {
    position_at_solar_time(latitude, day_of_year, hour + solar_time_offset(day_of_year, longitude, time_zone))
}

/// Half the length of the day, hours: solar noon to sunset. `None` in polar day and night.
pub(crate) fn half_day(latitude: f64, day_of_year: u16) -> Option<f64> {
    let cos_hour = -latitude.to_radians().tan() * declination(day_of_year).tan();
    (cos_hour.abs() <= 1.0).then(|| cos_hour.acos() * 12.0 / PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors written by `gendaymtx -D - -n` (Radiance 6.0a) for New York, 40.78° N 73.97° W,
    /// UTC−5, as printed (six decimals).
    #[test]
    fn directions_are_those_of_gendaymtx() {
        let cases = [
            (80, 9.5, [0.620046, -0.517758, 0.589466]),
            (80, 12.0, [0.014321, -0.658408, 0.752525]),
            (172, 12.0, [-0.010878, -0.297817, 0.954561]),
            (172, 7.0, [0.883264, 0.139409, 0.447672]),
            (355, 12.0, [-0.027366, -0.900287, 0.434436]),
            (264, 15.5, [-0.821331, -0.375255, 0.429651]),
        ];
        for (day, hour, expected) in cases {
            let d = position(40.78, -73.97, -5.0, day, hour).direction();
            assert!((d - DVec3::from_array(expected)).abs().max_element() < 6e-7, "{day} {hour}: {d}");
        }
    }

    /// Against the astronomy: Spencer's Fourier series (1971) for declination and equation of time,
    /// good to 0.04° and 0.5 minutes.
    #[test]
    fn the_sun_stays_close_to_a_better_almanac() {
        for day in 1..=365u16 {
            let b = TAU * f64::from(day - 1) / 365.0;
            let declination_spencer = 0.006918 - 0.399912 * b.cos() + 0.070257 * b.sin() - 0.006758 * (2.0 * b).cos()
                + 0.000907 * (2.0 * b).sin()
                - 0.002697 * (3.0 * b).cos()
                + 0.00148 * (3.0 * b).sin();
            let minutes_spencer =
                229.18 * (0.000075 + 0.001868 * b.cos() - 0.032077 * b.sin() - 0.014615 * (2.0 * b).cos() - 0.040849 * (2.0 * b).sin());
            assert!((declination(day) - declination_spencer).to_degrees().abs() < 1.4, "declination on day {day}");
            assert!((solar_time_offset(day, 0.0, 0.0) * 60.0 - minutes_spencer).abs() < 0.9, "equation of time on day {day}");
        }
    }

    #[test]
    fn noon_sun_is_south_in_the_north_and_north_in_the_south() {
        let noon = |latitude| position_at_solar_time(latitude, 81, 12.0);
        assert!((noon(50.0).altitude.to_degrees() - 40.0).abs() < 1e-9, "equinox");
        assert!(noon(50.0).direction().y < -0.7 && noon(-50.0).direction().y > 0.7);
        assert!(position_at_solar_time(50.0, 81, 9.0).direction().x > 0.5, "morning sun is in the east");
        for latitude in [-90.0, -66.0, 0.0, 66.0, 90.0] {
            for day in [1, 81, 172, 366] {
                for hour in 0..=24 {
                    let d = position_at_solar_time(latitude, day, f64::from(hour)).direction();
                    assert!((d.length() - 1.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn polar_day_and_night_have_no_sunset() {
        assert!(half_day(78.2, 172).is_none() && half_day(78.2, 355).is_none());
        assert!((half_day(0.0, 172).unwrap() - 6.0).abs() < 1e-12);
        let day: Vec<bool> = (0..24).map(|h| position(78.2, 15.6, 1.0, 172, f64::from(h)).is_up()).collect();
        let night: Vec<bool> = (0..24).map(|h| position(78.2, 15.6, 1.0, 355, f64::from(h)).is_up()).collect();
        assert!(day.iter().all(|up| *up) && night.iter().all(|up| !*up));
    }
}

//! IES LM-83-12: spatial daylight autonomy and annual sunlight exposure.
//!
//! sDA300/50%: share of the analysis points that reach 300 lx of daylight in at least 50 % of the 3650 hours from 8:00 to
//! 18:00, with blinds that are moved hour by hour ([`blinds`](super::blinds)). ASE1000,250h: share of the points that get
//! more than 1000 lx of direct sun, without any reflection and without blinds, in more than 250 of these hours.

use super::occupancy::{LM83_HOURS, Occupancy};
use super::{Year, share_of};
use glam::DVec3;

/// The edition that is followed.
pub const SOURCE: &str = "IES LM-83-12";
/// Name of the share in files where it is LM-83's own.
pub const SDA: &str = "sda_300_50";
/// What it is called then.
pub const SDA_TITLE: &str = "LM-83 sDA300/50%: sensors with 300 lx in half of the hours, with its blinds";
/// Illuminance of sDA, lx.
pub const SDA_LX: f64 = super::AUTONOMY_LX;
/// Share of the hours that sDA asks for.
pub const SDA_TIME: f64 = 0.5;
/// Direct sun that ASE counts and blinds close for, lx: more than this.
pub const SUN_LX: f64 = 1000.0;
/// Hours in the sun that ASE allows.
pub const ASE_HOURS: f64 = 250.0;
/// Share of the sensors that may be in the sun with the blinds open.
pub const MAY_BE_IN_SUN: f64 = 0.02;
/// Distance of analysis points, m: no more than two feet.
pub const SPACING: f64 = 0.6096;

/// The share of sensors whose autonomy (share of LM-83's hours with at least [`SDA_LX`]) is at least [`SDA_TIME`]:
/// sDA300/50% if blinds were moved, else the DA300 spatial share. Nothing of no sensor.
pub fn spatial_share(autonomy: &[f64]) -> Option<f64> {
    share_of(autonomy, |a| *a >= SDA_TIME)
}

/// ASE1000,250h from the hours, of LM-83's, in which each sensor has more than [`SUN_LX`] of direct sun.
pub fn exposed_share(hours: &[f64]) -> Option<f64> {
    share_of(hours, |h| *h > ASE_HOURS)
}

/// What was done about blinds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shading {
    /// Nothing: the façade stays as it is.
    Undeclared,
    /// They were moved by [`operate`](super::blinds::operate).
    Operated,
}

/// Why a share of sensors is not LM-83's; empty if it is. `positions` in metres.
pub fn doubts(year: &Year, time: &Occupancy, positions: &[DVec3], shading: Shading) -> Vec<String> {
    let mut doubts = Vec::new();
    if shading == Shading::Undeclared {
        doubts.push("LM-83's blinds are not moved: they close while more than 2 % of the sensors are in the sun".into());
    }
    if (time.hours - LM83_HOURS).abs() > 1e-6 || !year.is_whole() {
        doubts.push(format!("the weather has {} h of LM-83's {LM83_HOURS} h", time.hours));
    }
    match spacing(positions) {
        None => doubts.push(format!("{} sensor is no grid", positions.len())),
        // Files of points round.
        Some(s) if s > SPACING + 1e-3 => doubts.push(format!("sensors are {s:.2} m apart, LM-83 asks for 0.6 m at most")),
        Some(_) => {}
    }
    doubts
}

/// Beyond so many sensors the distance is measured at some of them.
const MEASURED: usize = 2000;

/// How far the sensors of a grid are apart: the largest distance of one to its nearest neighbour. Nothing of fewer than
/// two.
pub fn spacing(positions: &[DVec3]) -> Option<f64> {
    let nearest = |i: usize| {
        let others = positions.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, p)| p.distance_squared(positions[i])).fold(f64::INFINITY, f64::min).sqrt()
    };
    let stride = positions.len().div_ceil(MEASURED).max(1);
    (positions.len() > 1).then(|| (0..positions.len()).step_by(stride).map(nearest).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::super::Clock;
    use super::*;

    #[test]
    fn half_of_the_hours_is_enough_and_250_hours_in_the_sun_are_not_too_many() {
        let half = 1825.0 / 3650.0;
        assert_eq!(spatial_share(&[half, half - 1.0 / 3650.0, 1.0, 0.0]), Some(0.5));
        assert_eq!(exposed_share(&[250.0, 251.0, 0.0, 3650.0]), Some(0.5));
        assert_eq!((spatial_share(&[]), exposed_share(&[])), (None, None));
    }

    #[test]
    fn what_is_not_lm83_is_told_why() {
        let grid =
            |step: f64| -> Vec<DVec3> { (0..100).map(|i| DVec3::new((i % 10) as f64 * step, (i / 10) as f64 * step, 0.8)).collect() };
        let year = Year::common();
        let time = Occupancy::lm83(&year, Clock::Standard);
        assert!(doubts(&year, &time, &grid(0.6), Shading::Operated).is_empty());
        assert!(doubts(&year, &time, &grid(0.61), Shading::Operated).is_empty(), "two feet, rounded");
        assert!(doubts(&year, &time, &grid(0.6), Shading::Undeclared)[0].contains("blinds are not moved"));
        assert!(doubts(&year, &time, &grid(0.75), Shading::Operated)[0].contains("0.75 m apart"));
        assert!(doubts(&year, &time, &grid(0.6)[..1], Shading::Operated)[0].contains("no grid"));
        let mut part = Year::common();
        part.steps.truncate(24);
        assert!(doubts(&part, &Occupancy::lm83(&part, Clock::Standard), &grid(0.6), Shading::Operated)[0].contains("10 h of"));
        assert!((spacing(&grid(0.5)).unwrap() - 0.5).abs() < 1e-12);
        assert!((spacing(&[grid(0.5), vec![DVec3::new(9.0, 0.0, 0.8)]].concat()).unwrap() - 4.5).abs() < 1e-12, "one far off");
    }
}

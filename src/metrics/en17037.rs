//! EN 17037:2018, Daylight in buildings: daylight provision, exposure to sunlight, and the levels that all of its parts
//! share. Protection from glare is in [`glare`](super::glare), view out in [`view_out`](super::view_out).

use super::share_of;
use crate::error::{Error, Result};

/// The standard.
pub const SOURCE: &str = "EN 17037:2018";

/// Levels of recommendation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// None is reached.
    None,
    /// Minimum.
    Minimum,
    /// Medium.
    Medium,
    /// High.
    High,
}

impl Level {
    /// The level of so many steps reached, 0 to 3.
    pub(super) fn reached(steps: usize) -> Self {
        [Self::None, Self::Minimum, Self::Medium, Self::High][steps.min(3)]
    }

    /// The word for it, as files and tables use it.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Minimum => "minimum",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// Illuminances that half of the plane shall reach, lx, by level (table A.1).
pub const TARGET_LX: [f64; 3] = [300.0, 500.0, 750.0];
/// Illuminances that 95 % of the plane shall reach, lx, by level (table A.1).
pub const MINIMUM_LX: [f64; 3] = [100.0, 300.0, 500.0];
/// All of them, rising.
pub const LEVELS_LX: [f64; 4] = [100.0, 300.0, 500.0, 750.0];
/// Share of the plane that shall reach the target.
pub const TARGET_AREA: f64 = 0.5;
/// Share of the plane that shall reach the minimum; of openings in the roof the target (table A.2).
pub const MINIMUM_AREA: f64 = 0.95;
/// Share of the daylight hours.
pub const TIME: f64 = 0.5;

/// Where the daylight openings are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Openings {
    /// Vertical or inclined: table A.1, a target for half of the plane and a minimum for 95 %.
    #[default]
    Side,
    /// Horizontal: table A.2, the target for 95 % of the plane.
    Roof,
}

/// What a plane reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Provision {
    /// Of the target.
    pub target: Level,
    /// Of the minimum; of openings in the roof the same.
    pub minimum: Level,
}

impl Provision {
    /// The level of both.
    pub fn level(&self) -> Level {
        self.target.min(self.minimum)
    }

    /// By the shares of the plane, `[level of LEVELS_LX]`, that reach an illuminance.
    fn of(area: [f64; 4], openings: Openings) -> Self {
        let at = |lux: f64| area[LEVELS_LX.iter().position(|l| *l == lux).expect("one of the levels")];
        let reached = |levels: [f64; 3], wanted: f64| Level::reached(levels.iter().take_while(|lux| at(**lux) >= wanted).count());
        match openings {
            Openings::Side => Self { target: reached(TARGET_LX, TARGET_AREA), minimum: reached(MINIMUM_LX, MINIMUM_AREA) },
            Openings::Roof => {
                let level = reached(TARGET_LX, MINIMUM_AREA);
                Self { target: level, minimum: level }
            }
        }
    }

    /// Method 2: from the shares of the 4380 daylight hours in which each sensor has at least [`LEVELS_LX`], by level. A
    /// sensor reaches an illuminance if it has it in at least half of the hours. Nothing without sensors.
    pub fn by_illuminance(time: [&[f64]; 4], openings: Openings) -> Option<Self> {
        let mut area = [0.0; 4];
        for (area, time) in area.iter_mut().zip(time) {
            *area = share_of(time, |t| *t >= TIME)?;
        }
        Some(Self::of(area, openings))
    }

    /// Method 1: from each sensor's daylight factor (0…1) under the CIE's overcast sky and the median of the diffuse
    /// illuminance outdoors over the daylight hours, lx: a sensor reaches an illuminance if its factor times the median
    /// does. Nothing without sensors.
    pub fn by_factor(factors: &[f64], median: f64, openings: Openings) -> Option<Self> {
        let mut area = [0.0; 4];
        for (area, lux) in area.iter_mut().zip(LEVELS_LX) {
            *area = share_of(factors, |f| *f >= lux / median)?;
        }
        Some(Self::of(area, openings))
    }
}

/// Hours of sun that a room shall get on the chosen day, by level (table A.6).
pub const SUNLIGHT_HOURS: [f64; 3] = [1.5, 3.0, 4.0];

/// Exposure to sunlight: the level of so many hours of possible sun, under a cloudless sky, at the reference point on a day
/// between 1 February and 21 March.
///
/// # Errors
/// Another day.
pub fn exposure_to_sunlight(hours: f64, (month, day): (u8, u8)) -> Result<Level> {
    if !((2, 1)..=(3, 21)).contains(&(month, day)) {
        return Err(Error::new(format!("the sun is judged on a day between 1 February and 21 March, not on {day}.{month}."))
            .help("choose a day of these weeks"));
    }
    Ok(Level::reached(SUNLIGHT_HOURS.iter().take_while(|h| hours >= **h).count()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time shares of 20 sensors: so many of them reach each of the levels in exactly half of the hours.
    fn time(reach: [usize; 4]) -> [Vec<f64>; 4] {
        reach.map(|n| (0..20).map(|i| if i < n { 2190.0 / 4380.0 } else { 2189.0 / 4380.0 }).collect())
    }

    fn provision(reach: [usize; 4], openings: Openings) -> Provision {
        let time = time(reach);
        Provision::by_illuminance([&time[0], &time[1], &time[2], &time[3]], openings).unwrap()
    }

    #[test]
    fn target_and_minimum_are_reached_at_their_limits() {
        // 19 of 20 are 95 %, 10 of 20 are 50 %.
        for (reach, target, minimum, level) in [
            ([19, 10, 9, 0], Level::Minimum, Level::Minimum, Level::Minimum),
            ([18, 10, 0, 0], Level::Minimum, Level::None, Level::None),
            ([20, 9, 0, 0], Level::None, Level::Minimum, Level::None),
            ([20, 19, 10, 9], Level::Medium, Level::Medium, Level::Medium),
            ([20, 18, 18, 18], Level::High, Level::Minimum, Level::Minimum),
            ([20, 20, 19, 10], Level::High, Level::High, Level::High),
        ] {
            let found = provision(reach, Openings::Side);
            assert_eq!((found.target, found.minimum, found.level()), (target, minimum, level), "{reach:?}");
        }
        assert_eq!(provision([20, 18, 0, 0], Openings::Roof).level(), Level::None, "a roof light's target is for 95 %");
        assert_eq!(provision([20, 19, 19, 18], Openings::Roof).level(), Level::Medium);
        assert!(Provision::by_illuminance([&[], &[], &[], &[]], Openings::Side).is_none());
    }

    #[test]
    fn daylight_factors_reach_what_they_let_in_of_the_median_sky() {
        // 19,600 lx outdoors as in Madrid: a factor of 300 / 19,600 is a target's.
        let median = 19_600.0;
        let factors = |low: f64, high: f64| -> Vec<f64> { (0..20).map(|i| if i < 10 { high } else { low }).collect() };
        let level =
            |low: f64, high: f64| Provision::by_factor(&factors(low / median, high / median), median, Openings::Side).unwrap().level();
        assert_eq!(level(100.0, 300.0), Level::Minimum);
        assert_eq!(level(99.9, 300.0), Level::None);
        assert_eq!(level(300.0, 499.0), Level::Minimum);
        assert_eq!(level(500.0, 750.0), Level::High);
    }

    #[test]
    fn sunlight_is_judged_in_its_weeks() {
        let level = |hours: f64| exposure_to_sunlight(hours, (3, 21)).unwrap();
        assert_eq!([1.49, 1.5, 2.99, 3.0, 4.0].map(level), [Level::None, Level::Minimum, Level::Minimum, Level::Medium, Level::High]);
        assert!(exposure_to_sunlight(2.0, (2, 1)).is_ok());
        for day in [(1, 31), (3, 22), (6, 21)] {
            assert!(exposure_to_sunlight(2.0, day).is_err());
        }
    }
}

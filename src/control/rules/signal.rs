//! What rules look at.

use crate::control::Facade;

/// What a rule's comparison is made with, in its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Signal {
    /// On the outer side of a group's windows, W/m².
    Irradiance(usize),
    /// On the outer side of a group's windows, lx.
    Illuminance(usize),
    /// The sun's profile angle at a group's windows, degrees: its altitude in the plane that is normal to them; no number
    /// while it is down or behind.
    ProfileAngle(usize),
    /// The sun's altitude, degrees; negative below the horizon.
    Altitude,
    /// The sun's azimuth, degrees from north, clockwise.
    Azimuth,
    /// When the step begins, hours of standard time.
    Time,
    /// 1 to 12.
    Month,
    /// Direct sun on the sensors of a group (or all): the most of them, lx.
    Sun(Option<usize>),
    /// Share of these sensors with more than 1000 lx of direct sun, %.
    SunlitShare(Option<usize>),
    /// Illuminance of these sensors, lx.
    Sensors(Statistic, Option<usize>),
    /// Daylight glare probability of a view.
    Dgp(usize),
}

/// What is made of the illuminance of many sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Statistic {
    /// Their mean.
    Mean,
    /// The least.
    Least,
    /// The most.
    Most,
    /// A percentile: so many % of the sensors have no more.
    Percentile(u8),
}

impl Statistic {
    /// Of values; 0 of none.
    pub fn of(self, values: &[f64]) -> f64 {
        if values.is_empty() {
            return 0.0;
        }
        match self {
            Self::Mean => values.iter().sum::<f64>() / values.len() as f64,
            Self::Least => values.iter().copied().fold(f64::INFINITY, f64::min),
            Self::Most => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Self::Percentile(p) => {
                let mut sorted = values.to_vec();
                sorted.sort_unstable_by(f64::total_cmp);
                // The nearest rank.
                let rank = (f64::from(p) / 100.0 * sorted.len() as f64).ceil() as usize;
                sorted[rank.clamp(1, sorted.len()) - 1]
            }
        }
    }
}

/// A signal, and of which façade if it stands indoors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Reading {
    /// What is looked at.
    pub signal: Signal,
    /// Of signals indoors: whether with the rule's own group as it was set in the step before; else as if it were in its first
    /// state. Groups before it in the project are as decided for this step, those after it as in the step before.
    pub as_set: bool,
}

impl Signal {
    /// Whether it depends on the states of the façade.
    pub fn is_indoors(self) -> bool {
        matches!(self, Self::Sun(_) | Self::SunlitShare(_) | Self::Sensors(..) | Self::Dgp(_))
    }

    /// Its unit; empty of numbers.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Irradiance(_) => "W/m2",
            Self::Illuminance(_) | Self::Sun(_) | Self::Sensors(..) => "lx",
            Self::ProfileAngle(_) | Self::Altitude | Self::Azimuth => "deg",
            Self::SunlitShare(_) => "%",
            Self::Time => "h",
            Self::Month | Self::Dgp(_) => "",
        }
    }

    /// Values that it can have.
    pub(super) fn range(self) -> std::ops::RangeInclusive<f64> {
        match self {
            Self::Irradiance(_) => 0.0..=2000.0,
            Self::Illuminance(_) | Self::Sun(_) | Self::Sensors(..) => 0.0..=1e6,
            Self::ProfileAngle(_) => 0.0..=180.0,
            Self::Altitude => -90.0..=90.0,
            Self::Azimuth => 0.0..=360.0,
            Self::Time => 0.0..=24.0,
            Self::Month => 1.0..=12.0,
            Self::SunlitShare(_) => 0.0..=100.0,
            Self::Dgp(_) => 0.0..=1.0,
        }
    }

    /// Whether its values go round.
    pub(super) fn goes_round(self) -> bool {
        matches!(self, Self::Time | Self::Month | Self::Azimuth)
    }
}

/// What rules can name.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// Groups of windows and their states.
    pub facade: &'a Facade,
    /// Groups of sensors.
    pub sensors: &'a [String],
    /// Views.
    pub views: &'a [String],
}

//! The time steps of a result, as metrics see them.

use crate::weather::Weather;
use crate::weather::time::{Time, steps_per_day};

/// When a time step begins: local standard time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Month, 1…12.
    pub month: u8,
    /// Day of the month, from 1.
    pub day: u8,
    /// Hours from midnight.
    pub begins: f64,
}

/// All time steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Year {
    /// In the order of the results' columns.
    pub steps: Vec<Step>,
    /// Length of each, hours.
    pub length: f64,
}

/// Hours of a common year.
pub const HOURS: f64 = 8760.0;

impl Year {
    /// The steps of a weather file.
    pub fn of(weather: &Weather) -> Self {
        let all = weather.steps();
        let step = |(i, r): (usize, &crate::weather::Record)| {
            let place = all.place(i);
            Step { month: r.month, day: r.day, begins: (place.hour % 24) as f64 + place.minute as f64 / 60.0 }
        };
        Self { steps: weather.records.iter().enumerate().map(step).collect(), length: all.length }
    }

    /// Steps at these times (each somewhere in its step, or at its beginning), as many per day as a year of so many has.
    pub fn of_times(times: &[Time]) -> Self {
        let length = 24.0 / steps_per_day(times.len()) as f64;
        let step = |t: &Time| Step { month: t.month, day: t.day, begins: ((t.hour + 1e-6) / length).floor() * length };
        Self { steps: times.iter().map(step).collect(), length }
    }

    /// Hours of a common year from the first of January, 0 o'clock.
    pub fn common() -> Self {
        let month = |mut day: usize| {
            let days = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
            let mut month = 0;
            while day >= days[month] {
                day -= days[month];
                month += 1;
            }
            (month as u8 + 1, day as u8 + 1)
        };
        let step = |h: usize| {
            let (month, day) = month(h / 24);
            Step { month, day, begins: (h % 24) as f64 }
        };
        Self { steps: (0..8760).map(step).collect(), length: 1.0 }
    }

    /// How many hours so many steps are.
    pub fn hours(&self, steps: usize) -> f64 {
        steps as f64 * self.length
    }

    /// Whether there is a 29 February.
    pub fn is_leap(&self) -> bool {
        self.steps.iter().any(|s| (s.month, s.day) == (2, 29))
    }

    /// Hours that a year of this kind has.
    pub fn whole(&self) -> f64 {
        if self.is_leap() { HOURS + 24.0 } else { HOURS }
    }

    /// Whether the steps are one whole year: each place in it once.
    pub fn is_whole(&self) -> bool {
        let mut places: Vec<(usize, u32)> =
            self.steps.iter().map(|s| (self.hour_of(s), (s.begins.fract() * 60.0).round() as u32)).collect();
        places.sort_unstable();
        places.dedup();
        places.len() == self.steps.len() && (self.hours(self.steps.len()) - self.whole()).abs() < 1e-6
    }

    /// The hour of the year, from 0, that a step begins in.
    pub(crate) fn hour_of(&self, step: &Step) -> usize {
        let february = if self.is_leap() { 29 } else { 28 };
        let days = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
        let before: usize = days[..usize::from(step.month).saturating_sub(1).min(12)].iter().sum();
        (before + usize::from(step.day).saturating_sub(1)) * 24 + (step.begins + 1e-6).floor() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_year_knows_its_length() {
        let mut year = Year::common();
        assert!(year.is_whole() && !year.is_leap());
        assert_eq!((year.hour_of(&year.steps[0]), year.hour_of(&year.steps[8759])), (0, 8759));
        for hour in 0..24 {
            year.steps.push(Step { month: 2, day: 29, begins: f64::from(hour) });
        }
        assert!(year.is_whole() && year.is_leap(), "in any order");
        year.steps.pop();
        assert!(!year.is_whole());
        assert_eq!(Year::of_times(&Time::common_year(8760)), Year::common());
        let quarters = Year::of_times(&Time::common_year(35040));
        assert!(quarters.is_whole() && quarters.length == 0.25 && quarters.steps[5].begins == 1.25);
        let mut twice = Year::common();
        twice.steps[8759] = twice.steps[0];
        assert!(!twice.is_whole(), "as many hours, but one of them twice");
    }
}

//! Times of steps, and those of a common year where a file does not tell.

use super::Record;
use std::fmt;

const NAMES: [&str; 12] =
    ["January", "February", "March", "April", "May", "June", "July", "August", "September", "October", "November", "December"];
const MONTHS: [u8; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

/// Local standard time of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Time {
    /// Month, 1…12.
    pub month: u8,
    /// Day of the month, from 1.
    pub day: u8,
    /// Hours from midnight.
    pub hour: f64,
}

impl From<&Record> for Time {
    fn from(record: &Record) -> Self {
        Self { month: record.month, day: record.day, hour: record.hour }
    }
}

impl Time {
    /// Steps of a common year where a result does not tell its times: as many per day as fit 365 days.
    pub fn common_year(steps: usize) -> Vec<Self> {
        let per_day = steps_per_day(steps);
        (0..steps)
            .map(|i| {
                let (mut day, hour) = ((i / per_day) % 365, (i % per_day) as f64 + 0.5);
                let mut month = 0;
                while day >= usize::from(MONTHS[month]) {
                    day -= usize::from(MONTHS[month]);
                    month += 1;
                }
                Self { month: month as u8 + 1, day: day as u8 + 1, hour: hour * 24.0 / per_day as f64 }
            })
            .collect()
    }
}

impl Time {
    /// Name of the month.
    pub fn month_name(&self) -> &'static str {
        NAMES.get(usize::from(self.month).wrapping_sub(1)).unwrap_or(&"?")
    }
}

/// As `21 June, 12:30`.
impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let minutes = (self.hour * 60.0).round() as u32;
        write!(f, "{} {}, {:02}:{:02}", self.day, self.month_name(), minutes / 60, minutes % 60)
    }
}

/// Steps per day of a year of this many steps.
pub fn steps_per_day(steps: usize) -> usize {
    if steps.is_multiple_of(365) && steps >= 365 {
        steps / 365
    } else if steps.is_multiple_of(366) && steps >= 366 {
        steps / 366
    } else {
        24
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn years_have_their_days_and_times() {
        assert_eq!((steps_per_day(8760), steps_per_day(8784), steps_per_day(35040), steps_per_day(48)), (24, 24, 96, 24));
        let times = Time::common_year(8760);
        assert_eq!(times[24 * 31 + 12].to_string(), "1 February, 12:30");
        assert_eq!((times[8759].month, times[8759].day), (12, 31));
    }
}

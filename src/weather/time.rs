//! Times of steps, and those of a common year where a file does not tell.

use super::Record;
use crate::error::{Error, Result};
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
    /// A time as `03-21T12:00` writes it: month, day, local standard time.
    ///
    /// # Errors
    /// Anything else, and days that no month has.
    pub fn parse(text: &str) -> Result<Self> {
        let wrong = || Error::new(format!("'{text}' is not a date and time")).help("write month-day and standard time, as 03-21T12:00");
        let digits = |word: &str| word.chars().all(|c| c.is_ascii_digit()).then(|| word.parse::<u8>().ok()).flatten();
        let (date, clock) = text.split_once(['T', ' ']).ok_or_else(wrong)?;
        let ((month, day), (hour, minute)) = date.split_once('-').zip(clock.split_once(':')).ok_or_else(wrong)?;
        let [Some(month), Some(day), Some(hour), Some(minute)] = [month, day, hour, minute].map(digits) else { return Err(wrong()) };
        let days = *MONTHS.get(usize::from(month).wrapping_sub(1)).ok_or_else(wrong)?;
        if !(1..=days).contains(&day) || minute > 59 || f64::from(hour) + f64::from(minute) / 60.0 > 24.0 {
            return Err(wrong());
        }
        Ok(Self { month, day, hour: f64::from(hour) + f64::from(minute) / 60.0 })
    }

    /// Day of a common year, from 1.
    pub fn day_of_year(&self) -> u16 {
        let before = usize::from(self.month).saturating_sub(1).min(MONTHS.len());
        MONTHS[..before].iter().map(|d| u16::from(*d)).sum::<u16>() + u16::from(self.day)
    }

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

    #[test]
    fn dates_are_read_as_they_are_written() {
        let time = Time::parse("03-21T12:30").unwrap();
        assert_eq!((time, time.day_of_year()), (Time { month: 3, day: 21, hour: 12.5 }, 80));
        assert_eq!(Time::parse("12-31 24:00").unwrap().day_of_year(), 365);
        for bad in [
            "",
            "03-21",
            "3/21T12:00",
            "13-01T12:00",
            "00-01T12:00",
            "02-29T12:00",
            "03-00T12:00",
            "03-21T25:00",
            "03-21T24:01",
            "03-21T12:60",
            "03-21T-1:00",
            "03-+1T12:00",
            "é-1T1:1",
        ] {
            assert!(Time::parse(bad).unwrap_err().to_string().contains("as 03-21T12:00"), "{bad}");
        }
    }
}

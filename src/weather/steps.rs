//! The time steps of a weather file: how long one is, and where in the year it lies.
//!
//! Results are numbered by the hour of the year, 0 for the first of January from 0 to 1 o'clock, whatever
//! part of the year a file holds. A step shorter than an hour is told by its minute too.

use super::series::SLACK_HOURS;
use super::{Record, Weather};
use crate::error::{Error, Result};
use std::collections::BTreeMap;

/// Where in the year a step begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Hour of the year, from 0.
    pub hour: usize,
    /// Minute of the hour; 0 for steps of an hour.
    pub minute: usize,
}

/// All steps of a weather file.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    /// Length of a step, hours: at most 1.
    pub length: f64,
    /// Whether all steps that follow each other within an hour are as long.
    pub are_even: bool,
    /// Whether there is a 29 February among them.
    leap: bool,
    places: Vec<Place>,
    /// Of named moments their names.
    names: Vec<String>,
}

/// What all records of a file told about their steps before some were taken out or divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whole {
    /// Length of a step, hours.
    pub length: f64,
    /// Whether all steps that follow each other are as long.
    pub are_even: bool,
    /// Whether times name the ends of steps.
    pub ends: bool,
    /// Whether there was a 29 February.
    pub leap: bool,
}

/// What all records of a file tell about their steps.
pub(super) fn whole(records: &[Record]) -> Whole {
    let (length, are_even) = length(records);
    Whole {
        length,
        are_even,
        // Who writes 24 o'clock names the ends of steps.
        ends: records.iter().any(|r| r.hour > 24.0 - 1e-6),
        leap: records.iter().any(|r| (r.month, r.day) == (2, 29)),
    }
}

impl Weather {
    /// The time steps. A step is as long as most that follow each other within a day, an hour at most: hours
    /// that somebody chose are hours.
    pub fn steps(&self) -> Steps {
        let Whole { length, are_even, ends, leap } = self.whole.unwrap_or_else(|| whole(&self.records));
        let places = self.records.iter().map(|r| place(r, length, ends)).collect();
        Steps { length, are_even, leap, places, names: self.names.clone() }
    }
}

/// The commonest distance of neighbours within a day, as a part of an hour, and whether there is only one.
fn length(records: &[Record]) -> (f64, bool) {
    let mut counts: BTreeMap<u64, usize> = BTreeMap::new();
    for pair in records.windows(2) {
        let distance = pair[1].hour - pair[0].hour;
        if (pair[0].month, pair[0].day) == (pair[1].month, pair[1].day) && distance > 1e-6 && distance < 1.0 - SLACK_HOURS {
            // A minute is the finest that weather files have.
            *counts.entry((distance * 60.0).round().max(1.0) as u64).or_default() += 1;
        }
    }
    let within =
        |pair: &&[Record]| (pair[0].month, pair[0].day) == (pair[1].month, pair[1].day) && pair[1].hour - pair[0].hour < 1.0 + SLACK_HOURS;
    let pairs = records.windows(2).filter(within).count();
    match counts.iter().max_by_key(|(_, count)| **count) {
        // One pair of near times among whole hours is a slip, not a step.
        Some((minutes, count)) if 2 * count >= pairs => (*minutes as f64 / 60.0, counts.len() == 1 && *count == pairs),
        Some(_) => (1.0, false),
        None => (1.0, true),
    }
}

fn place(record: &Record, length: f64, ends: bool) -> Place {
    let slack = SLACK_HOURS.min(length / 4.0);
    let begin = if ends { record.hour - length } else { record.hour };
    let number = ((begin + slack) / length).floor().max(0.0);
    let minutes = (usize::from(record.day_of_year) - 1) * 24 * 60 + (number * length * 60.0).round() as usize;
    Place { hour: minutes / 60, minute: minutes % 60 }
}

impl Steps {
    /// Number of steps.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// How many hours this many steps are.
    pub fn hours(&self, steps: usize) -> f64 {
        steps as f64 * self.length
    }

    /// Where a step, by its number in the file, begins.
    pub fn place(&self, step: usize) -> Place {
        self.places[step]
    }

    /// Hour of the year as tables have it: `1164`, or `1164.25` for the second quarter of it; the name of a moment
    /// that has one.
    pub fn label(&self, step: usize) -> String {
        if let Some(name) = self.names.get(step) {
            return name.clone();
        }
        let Place { hour, minute } = self.places[step];
        if self.is_hourly() { hour.to_string() } else { format!("{:.4}", hour as f64 + minute as f64 / 60.0) }
    }

    /// Number of a step in names of files: the hour of the year, of shorter steps followed by two digits
    /// for the minute (116415). Of named moments their number from 1.
    pub fn number(&self, step: usize) -> usize {
        if !self.names.is_empty() {
            return step + 1;
        }
        let Place { hour, minute } = self.places[step];
        if self.is_hourly() { hour } else { hour * 100 + minute }
    }

    /// Whether there is a 29 February.
    pub(super) fn is_leap(&self) -> bool {
        self.leap
    }

    /// Whether steps are hours.
    pub(crate) fn is_hourly(&self) -> bool {
        self.length >= 1.0
    }

    /// Steps of these hours of the year, in the hours' order; of an hour all steps.
    ///
    /// # Errors
    /// Hours that the file does not have or has several times, and hours named twice.
    pub fn of_hours(&self, hours: &[usize]) -> Result<Vec<usize>> {
        let mut found: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (step, place) in self.places.iter().enumerate() {
            found.entry(place.hour).or_default().push(step);
        }
        let mut steps = Vec::new();
        for (i, hour) in hours.iter().enumerate() {
            if hours[..i].contains(hour) {
                return Err(Error::new(format!("hour {hour} is named twice")));
            }
            let Some(own) = found.get(hour) else {
                return Err(Error::new(format!("hour {hour} of the year ({}) is not in the weather file", date(*hour, self.leap)))
                    .help(self.extent()));
            };
            steps.extend(own);
        }
        self.check_unique(&steps)?;
        Ok(steps)
    }

    /// Refuses steps of the same time, whose results would have the same name.
    ///
    /// # Errors
    /// Names the time.
    pub(crate) fn check_unique(&self, steps: &[usize]) -> Result<()> {
        if !self.names.is_empty() {
            return Ok(());
        }
        let mut places: Vec<Place> = steps.iter().map(|s| self.places[*s]).collect();
        places.sort_unstable();
        match places.windows(2).find(|w| w[0] == w[1]) {
            None => Ok(()),
            Some(twice) => {
                Err(Error::new(format!("the weather file has hour {} ({}) several times", twice[0].hour, date(twice[0].hour, self.leap)))
                    .help("pictures are named after the hour: keep one year in the file"))
            }
        }
    }

    fn extent(&self) -> String {
        let (first, last) = (self.places.iter().min(), self.places.iter().max());
        match first.zip(last) {
            Some((first, last)) if self.is_whole_range() => {
                format!("hours are counted from 0 over the year; the file has hours {} to {}", first.hour, last.hour)
            }
            Some((first, last)) => {
                format!("hours are counted from 0 over the year; the file has some from {} to {}", first.hour, last.hour)
            }
            None => "the file has no time step".into(),
        }
    }

    fn is_whole_range(&self) -> bool {
        let mut hours: Vec<usize> = self.places.iter().map(|p| p.hour).collect();
        hours.sort_unstable();
        hours.dedup();
        hours.last().zip(hours.first()).is_some_and(|(last, first)| last - first + 1 == hours.len())
    }

    /// Values of the steps laid out over whole days, from the first day to the last, for a carpet: first
    /// day of the year (from 0), steps per day, and per place the number of the step. Nothing if a
    /// day has no whole number of steps, or two steps are at the same time.
    pub fn days(&self) -> Option<Days> {
        if !self.names.is_empty() {
            return None;
        }
        let per_day = (24.0 / self.length).round();
        if (per_day * self.length - 24.0).abs() > 1e-6 || self.check_unique(&(0..self.len()).collect::<Vec<_>>()).is_err() {
            return None;
        }
        let per_day = per_day as usize;
        let place = |p: &Place| (p.hour / 24, ((p.hour % 24 * 60 + p.minute) as f64 / 60.0 / self.length).round() as usize);
        let (first, last) = (self.places.iter().map(place).min()?, self.places.iter().map(place).max()?);
        let mut steps = vec![None; (last.0 - first.0 + 1) * per_day];
        for (step, p) in self.places.iter().enumerate() {
            let (day, number) = place(p);
            *steps.get_mut((day - first.0) * per_day + number)? = Some(step);
        }
        Some(Days { first: first.0, leap: self.leap, per_day, steps })
    }
}

/// Steps over whole days.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Days {
    /// First day of the year, from 0.
    pub first: usize,
    /// Whether there is a 29 February.
    pub leap: bool,
    /// Steps of a day.
    pub per_day: usize,
    /// `[day][step of the day]`: number of the step in the file.
    pub steps: Vec<Option<usize>>,
}

/// `18 February, 12 o'clock` of an hour of the year.
fn date(hour: usize, leap: bool) -> String {
    const MONTHS: [&str; 12] =
        ["January", "February", "March", "April", "May", "June", "July", "August", "September", "October", "November", "December"];
    let day = hour / 24;
    let before = |month: usize| usize::from(super::DAYS_BEFORE[month]) + usize::from(leap && month > 1);
    if day >= before(12) {
        return format!("the year has hours 0 to {}", before(12) * 24 - 1);
    }
    let month = (0..12).rev().find(|m| before(*m) <= day).unwrap_or(0);
    format!("{} {}, {} o'clock", day - before(month) + 1, MONTHS[month], hour % 24)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Warnings;

    fn weather(times: &[(u8, u8, f64)]) -> Weather {
        let mut text = String::from("place x\nlatitude 40\nlongitude 74\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n");
        for (month, day, hour) in times {
            text.push_str(&format!("{month} {day} {hour:.3} 0 0\n"));
        }
        Weather::from_bytes(text.as_bytes(), &mut Warnings::new()).unwrap()
    }

    fn day(month: u8, day: u8, per_hour: u32, offset: f64) -> Vec<(u8, u8, f64)> {
        (0..24 * per_hour).map(|i| (month, day, (f64::from(i) + offset) / f64::from(per_hour))).collect()
    }

    #[test]
    fn steps_are_as_long_as_they_are_and_numbered_by_the_hour_of_the_year() {
        // Offset of the time written within the step: beginning, middle, end.
        for per_hour in [1, 2, 3, 4, 6, 12, 60] {
            for offset in [0.0, 0.5, 1.0] {
                let steps = weather(&day(3, 1, per_hour, offset)).steps();
                assert!((steps.length - 1.0 / f64::from(per_hour)).abs() < 1e-9 && steps.are_even, "{per_hour} {offset}");
                assert!((steps.hours(steps.len()) - 24.0).abs() < 1e-9);
                for i in 0..steps.len() {
                    let per_hour = per_hour as usize;
                    let wanted = Place { hour: 59 * 24 + i / per_hour, minute: i % per_hour * 60 / per_hour };
                    assert_eq!(steps.place(i), wanted, "{per_hour} {offset} {i}");
                }
                let days = steps.days().unwrap();
                assert_eq!((days.first, days.per_day), (59, 24 * per_hour as usize));
                assert!(days.steps.iter().enumerate().all(|(i, s)| *s == Some(i)));
            }
        }
        let quarters = weather(&day(1, 1, 4, 1.0)).steps();
        assert_eq!((quarters.label(37), quarters.number(37)), ("9.2500".into(), 915));
        assert_eq!((weather(&day(1, 2, 1, 0.5)).steps().label(7), weather(&day(1, 2, 1, 0.5)).steps().number(7)), ("31".into(), 31));
    }

    #[test]
    fn chosen_hours_are_hours() {
        let chosen = weather(&[(6, 21, 9.0), (6, 21, 12.0), (6, 21, 15.0), (12, 21, 12.0)]).steps();
        assert_eq!((chosen.length, chosen.are_even), (1.0, true));
        assert_eq!(chosen.place(1), Place { hour: 171 * 24 + 12, minute: 0 });
        assert_eq!(chosen.of_hours(&[354 * 24 + 12, 171 * 24 + 9]).unwrap(), [3, 0]);
        let error = chosen.of_hours(&[300]).unwrap_err().to_string();
        assert!(
            error.contains("hour 300 of the year (13 January, 12 o'clock) is not in the weather file")
                && error.contains("some from 4113 to 8508"),
            "{error}"
        );
        assert!(chosen.of_hours(&[8784]).unwrap_err().to_string().contains("the year has hours 0 to 8759"));
        let leap = weather(&[(2, 29, 12.5), (3, 1, 12.5)]).steps();
        assert!((leap.place(0).hour, leap.place(1).hour) == (59 * 24 + 12, 60 * 24 + 12) && leap.days().unwrap().leap);
        assert!(leap.of_hours(&[8770]).unwrap_err().to_string().contains("31 December, 10 o'clock"));
        assert!(chosen.of_hours(&[4113, 4113]).unwrap_err().to_string().contains("twice"));
        assert_eq!(chosen.days().unwrap().steps.iter().flatten().count(), 4);
        let uneven = weather(&[(6, 21, 9.0), (6, 21, 9.5), (6, 21, 10.0), (6, 21, 10.25)]).steps();
        assert_eq!((uneven.length, uneven.are_even), (0.5, false));
        assert!(!weather(&[(6, 21, 9.0), (6, 21, 9.5), (6, 21, 10.5), (6, 21, 11.5), (6, 21, 12.5)]).steps().are_even);
    }

    #[test]
    fn an_hour_of_several_years_is_no_name() {
        let twice = weather(&[(6, 21, 12.0), (6, 22, 12.0), (6, 21, 12.0)]).steps();
        assert!(twice.of_hours(&[171 * 24 + 12]).unwrap_err().to_string().contains("several times"));
        assert!(twice.of_hours(&[172 * 24 + 12]).is_ok() && twice.days().is_none());
    }

    #[test]
    fn of_an_hour_all_its_steps_are_meant() {
        let steps = weather(&day(2, 18, 4, 0.5)).steps();
        assert_eq!(steps.of_hours(&[48 * 24 + 12]).unwrap(), [48, 49, 50, 51]);
        assert_eq!((steps.number(48), steps.number(51)), (116_400, 116_445));
        // Five minutes are 0.0833 h.
        assert_eq!(weather(&[(1, 1, 0.083), (1, 1, 0.167), (1, 1, 0.25), (1, 1, 0.333)]).steps().number(3), 20);
    }
}

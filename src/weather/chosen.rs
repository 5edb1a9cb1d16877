//! Some of a file's steps: a period of the year, or chosen hours. What the file as a whole told of its steps (their
//! length, whether their times are their ends, the mean dew points) is kept, so that a chosen hour is what it was
//! among all others.

use super::{DewPoints, Record, Weather, days_in};
use crate::error::{Error, Result};

/// A day of the year, month and day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Day {
    /// 1…12
    pub month: u8,
    /// From 1.
    pub day: u8,
}

impl Day {
    /// `03-21`: month and day.
    ///
    /// # Errors
    /// Anything else, and days that no month has.
    pub fn parse(text: &str) -> Result<Self> {
        let wrong = || Error::new(format!("'{text}' is no day of the year")).help("write month-day, as 03-21");
        let digits = |word: &str| word.chars().all(|c| c.is_ascii_digit()).then(|| word.parse::<u8>().ok()).flatten();
        let (month, day) = text.split_once('-').ok_or_else(wrong)?;
        let (Some(month @ 1..=12), Some(day)) = (digits(month), digits(day)) else { return Err(wrong()) };
        if !(1..=days_in(month)).contains(&day) {
            return Err(wrong());
        }
        Ok(Self { month, day })
    }
}

impl std::fmt::Display for Day {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:02}-{:02}", self.month, self.day)
    }
}

/// The values of a schedule, one for each hour of the year: the last column of a table, whose first lines may be names.
///
/// # Errors
/// Values that are no number or below 0, and any other number of them than the hours of a year.
pub fn read_schedule(text: &str) -> Result<Vec<f64>> {
    let mut values = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let word = line.rsplit([',', ';', '\t']).next().unwrap_or_default().trim();
        match word.parse::<f64>() {
            Ok(v) if v.is_finite() && v >= 0.0 => values.push(v),
            // Names of columns.
            Err(_) if values.is_empty() && i < 20 => {}
            _ => {
                return Err(Error::new(format!("'{word}' is no value of a schedule"))
                    .line(i + 1)
                    .help("the last column has a number for each hour of the year: 0, or more where the hour counts"));
            }
        }
    }
    if ![8760, 8784].contains(&values.len()) {
        return Err(Error::new(format!("the schedule has {} values", values.len()))
            .help("it needs one a line for each hour of the year: 8760, of a year with a 29 February 8784"));
    }
    Ok(values)
}

impl Weather {
    /// Notes what the file tells as a whole, before records are taken out or divided.
    pub(super) fn settle(&mut self) {
        if self.whole.is_some() {
            return;
        }
        self.whole = Some(super::steps::whole(&self.records));
        let mut dew_points = DewPoints::default();
        for record in &mut self.records {
            record.dew_point = Some(dew_points.mean(record));
        }
    }

    fn retain(&mut self, keep: impl Fn(usize, &Record) -> bool) {
        self.settle();
        let kept: Vec<usize> = (0..self.records.len()).filter(|i| keep(*i, &self.records[*i])).collect();
        fn of<T: Clone>(all: &mut Vec<T>, kept: &[usize]) {
            if !all.is_empty() {
                *all = kept.iter().map(|i| all[*i].clone()).collect();
            }
        }
        of(&mut self.records, &kept);
        of(&mut self.skies, &kept);
        of(&mut self.names, &kept);
        if let Some(given) = &mut self.given {
            *given = given.columns(&kept);
        }
    }

    /// Keeps the steps of a period, first and last day included; over New Year if the last comes before the first.
    ///
    /// # Errors
    /// A period that the file has no step of.
    pub fn keep_period(&mut self, [first, last]: [Day; 2]) -> Result<()> {
        self.retain(|_, r| {
            let day = Day { month: r.month, day: r.day };
            if first <= last { (first..=last).contains(&day) } else { day >= first || day <= last }
        });
        match self.records.is_empty() {
            false => Ok(()),
            true => Err(Error::new(format!("the weather has no time step from {first} to {last}"))),
        }
    }

    /// Keeps the steps of these hours of the year, from 0; of steps shorter than an hour all that lie in it.
    ///
    /// # Errors
    /// Hours that the weather does not have or has several times, or that are named twice.
    pub fn keep_hours(&mut self, hours: &[usize]) -> Result<()> {
        let steps = self.steps().of_hours(hours)?;
        let chosen: std::collections::HashSet<usize> = steps.into_iter().collect();
        self.retain(|i, _| chosen.contains(&i));
        Ok(())
    }

    /// Keeps the steps of the hours of the year whose value in a schedule is above 0.
    ///
    /// # Errors
    /// A schedule of another year's length, or one that leaves nothing.
    pub fn keep_scheduled(&mut self, values: &[f64]) -> Result<()> {
        let steps = self.steps();
        if steps.is_leap() && values.len() < 8784 {
            return Err(Error::new(format!("the weather has a 29 February, the schedule {} hours", values.len()))
                .help("give the schedule 8784 values, or take that day out of the weather file"));
        }
        if !steps.is_leap() && values.len() > 8760 {
            return Err(Error::new(format!("the schedule has {} hours, the weather no 29 February", values.len()))
                .help("give the schedule 8760 values"));
        }
        self.retain(|i, _| values.get(steps.place(i).hour).is_some_and(|v| *v > 0.0));
        match self.records.is_empty() {
            false => Ok(()),
            true => Err(Error::new("no hour of the weather counts in this schedule").help("its value is above 0 where an hour counts")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Warnings;

    fn weather(times: impl Iterator<Item = (u8, u8, f64)>) -> Weather {
        let mut text = String::from("place x\nlatitude 40\nlongitude 74\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n");
        times.for_each(|(month, day, hour)| text.push_str(&format!("{month} {day} {hour:.3} 0 0\n")));
        Weather::from_bytes(text.as_bytes(), &mut Warnings::new()).unwrap()
    }

    fn year(offset: f64) -> Weather {
        let days = (1..=12u8).flat_map(|m| (1..=days_in(m).min(if m == 2 { 28 } else { 31 })).map(move |d| (m, d)));
        weather(days.flat_map(move |(m, d)| (0..24).map(move |h| (m, d, f64::from(h) + offset))))
    }

    #[test]
    fn a_period_has_its_first_and_last_day_and_may_pass_new_year() {
        let day = |text: &str| Day::parse(text).unwrap();
        let mut spring = year(0.5);
        spring.keep_period([day("03-01"), day("05-31")]).unwrap();
        assert_eq!(spring.records.len(), 92 * 24);
        assert_eq!((spring.steps().place(0).hour, spring.steps().len()), (59 * 24, 92 * 24));
        let mut winter = year(0.5);
        winter.keep_period([day("12-21"), day("01-10")]).unwrap();
        assert_eq!(winter.records.len(), 21 * 24);
        assert_eq!(winter.records[0].month, 1, "the file's order stays");
        let error = spring.keep_period([day("06-01"), day("06-02")]).unwrap_err().to_string();
        assert!(error.contains("no time step from 06-01 to 06-02"), "{error}");
        for bad in ["", "3", "13-01", "02-30", "0-1", "a-b", "03-21T12:00"] {
            assert!(Day::parse(bad).unwrap_err().to_string().contains("as 03-21"), "{bad}");
        }
    }

    #[test]
    fn a_chosen_hour_is_the_hour_that_it_was_in_the_year() {
        // Times that name beginnings, middles and ends of hours; nothing in a chosen hour itself tells which.
        for offset in [0.0, 0.5, 1.0] {
            let whole = year(offset);
            let noon: Vec<usize> = whole.steps().of_hours(&[1164, 4000]).unwrap();
            let mut chosen = whole.clone();
            chosen.keep_hours(&[4000, 1164]).unwrap();
            let steps = chosen.steps();
            assert_eq!((steps.place(0).hour, steps.place(1).hour, steps.length), (1164, 4000, 1.0), "{offset}");
            assert_eq!(chosen.records[0].hour, whole.records[noon[0]].hour);
        }
        assert!(year(0.5).keep_hours(&[9000]).unwrap_err().to_string().contains("the year has hours 0 to 8759"));
    }

    #[test]
    fn a_schedule_keeps_the_hours_that_count() {
        let lines: String = (0..8760).map(|h| format!("{h},{}\n", if h % 24 == 12 { 0.5 } else { 0.0 })).collect();
        let values = read_schedule(&format!("# office\nhour,occupancy\n{lines}")).unwrap();
        let mut noons = year(0.5);
        noons.keep_scheduled(&values).unwrap();
        assert_eq!((noons.records.len(), noons.records[100].hour), (365, 12.5));
        assert!(read_schedule("1\n0\n").unwrap_err().to_string().contains("has 2 values"));
        assert!(read_schedule("1\n-1\n").unwrap_err().to_string().contains(":2") || read_schedule("1\n-1\n").is_err());
        assert!(year(0.5).keep_scheduled(&[0.0; 8760]).unwrap_err().to_string().contains("no hour of the weather counts"));
        assert!(year(0.5).keep_scheduled(&[1.0; 8784]).unwrap_err().to_string().contains("no 29 February"));
        let mut leap = weather([(2, 29, 12.5), (3, 1, 12.5)].into_iter());
        assert!(leap.clone().keep_scheduled(&values).unwrap_err().to_string().contains("has a 29 February"));
        let mut all = vec![0.0; 8784];
        all[60 * 24 + 12] = 1.0;
        leap.keep_scheduled(&all).unwrap();
        assert_eq!((leap.records.len(), leap.records[0].month), (1, 3));
    }

    #[test]
    fn dew_points_of_chosen_hours_are_means_with_the_hours_before_them() {
        let mut weather = weather((0..6).map(|h| (6, 21, f64::from(h) + 0.5)));
        weather.records.iter_mut().zip([1.0, 4.0, 10.0, 7.0, 13.0, 1.0]).for_each(|(r, dew)| r.dew_point = Some(dew));
        weather.keep_hours(&[171 * 24 + 4]).unwrap();
        assert_eq!(weather.records[0].dew_point, Some(10.0));
    }
}

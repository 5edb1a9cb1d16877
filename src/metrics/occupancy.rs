//! Which time steps count.

use super::year::{HOURS, Year};
use crate::error::{Error, Result};
use crate::text;
use std::path::Path;

/// Steps of the year that a metric counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Occupancy {
    /// What it is, in words.
    pub name: String,
    /// Numbers of the steps, rising.
    pub steps: Vec<usize>,
    /// What they are together, hours.
    pub hours: f64,
}

/// What the clocks on the wall show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Clock {
    /// Standard time all year.
    #[default]
    Standard,
    /// An hour ahead from one day (month, day) until before another; the first may be the later of the two, in the
    /// south.
    Saving {
        /// First day with the clock ahead.
        from: (u8, u8),
        /// First day without.
        until: (u8, u8),
    },
}

impl Clock {
    /// By how many hours clocks are ahead of standard time on a day.
    fn ahead(self, day: (u8, u8)) -> f64 {
        let Self::Saving { from, until } = self else { return 0.0 };
        let saving = if from <= until { (from..until).contains(&day) } else { day >= from || day < until };
        if saving { 1.0 } else { 0.0 }
    }
}

/// LM-83's day, clock time.
const DAY: std::ops::Range<f64> = 8.0..18.0;

/// Hours of LM-83's year.
pub(super) const LM83_HOURS: f64 = 3650.0;

/// EN 17037's daylight hours: half of a year.
pub const DAYLIGHT_HOURS: f64 = HOURS / 2.0;

impl Occupancy {
    fn of(name: impl Into<String>, year: &Year, counts: impl Fn(usize) -> bool) -> Self {
        let steps: Vec<usize> = (0..year.steps.len()).filter(|s| counts(*s)).collect();
        Self { name: name.into(), hours: year.hours(steps.len()), steps }
    }

    /// Every step, day and night.
    pub fn always(year: &Year) -> Self {
        Self::of("all hours", year, |_| true)
    }

    /// IES LM-83: 8:00 to 18:00 local clock time on all days of a year of 365, 3650 hours. A step counts by its
    /// beginning; 29 February does not count, so that a leap year has as many.
    pub fn lm83(year: &Year, clock: Clock) -> Self {
        let counts = |i: usize| {
            let s = &year.steps[i];
            let begins = s.begins + clock.ahead((s.month, s.day));
            (s.month, s.day) != (2, 29) && DAY.contains(&(begins + 1e-6))
        };
        let name = match clock {
            Clock::Standard => "LM-83 (8:00 to 18:00 standard time, every day)",
            Clock::Saving { .. } => "LM-83 (8:00 to 18:00 clock time, every day)",
        };
        Self::of(name, year, counts)
    }

    /// EN 17037: the 4380 hours of the year with most daylight, by diffuse horizontal illuminance outdoors
    /// (`diffuse`, one value per step, lx). Of equal steps the earlier count.
    ///
    /// # Errors
    /// Steps that are not one whole year: half of a part of it is another half.
    ///
    /// # Panics
    /// If there is not one value per step.
    pub fn en17037(year: &Year, diffuse: &[f64]) -> Result<Self> {
        assert_eq!(year.steps.len(), diffuse.len(), "a diffuse illuminance per step");
        if !year.is_whole() {
            let hours = year.hours(diffuse.len());
            return Err(Error::new(format!("EN 17037's daylight hours are half of a year, but the weather has {hours} h of it"))
                .help("give the weather of one whole year"));
        }
        let wanted = (DAYLIGHT_HOURS / year.length).round() as usize;
        let mut order: Vec<usize> = (0..diffuse.len()).collect();
        order.sort_by(|a, b| diffuse[*b].total_cmp(&diffuse[*a]));
        let mut steps = order[..wanted].to_vec();
        steps.sort_unstable();
        Ok(Self { name: "EN 17037 (the 4380 hours with most diffuse daylight)".into(), hours: year.hours(wanted), steps })
    }

    /// A schedule of one's own, CSV: a line with 0 or 1 (in its last column) per time step, or per hour of a whole
    /// year; a first line with names may stand above, lines that begin with # are skipped.
    ///
    /// # Errors
    /// With file and line: other values, lines that do not fit the year, a schedule that is never 1.
    pub fn read(path: &Path, year: &Year) -> Result<Self> {
        Self::parse(&text::read(path, "a schedule")?, year)
            .map(|o| Self { name: format!("schedule {}", path.display()), ..o })
            .map_err(|e| e.file(path))
    }

    /// As [`read`](Self::read), from the file's text.
    ///
    /// # Errors
    /// The same.
    pub fn parse(text: &str, year: &Year) -> Result<Self> {
        let mut values = Vec::new();
        let lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim()));
        for (line, content) in lines.filter(|(_, l)| !l.is_empty() && !l.starts_with('#')) {
            let word = content.rsplit([',', ';', '\t']).next().unwrap_or(content).trim();
            match word.parse::<f64>() {
                Ok(v) if v == 0.0 || v == 1.0 => values.push(v == 1.0),
                Err(_) if values.is_empty() && word.chars().any(char::is_alphabetic) => {}
                _ => {
                    return Err(Error::new(format!("'{word}' is neither 0 nor 1"))
                        .line(line)
                        .help("write 1 for a time that is occupied, 0 for one that is not, in the last column"));
                }
            }
        }
        let (lines, steps, whole) = (values.len(), year.steps.len(), year.whole() as usize);
        let occupied = if lines == whole {
            Self::of("", year, |i| values[year.hour_of(&year.steps[i])])
        } else if lines == steps {
            Self::of("", year, |i| values[i])
        } else {
            let leap = if year.is_leap() { " (it has a 29 February)" } else { "" };
            return Err(Error::new(format!("the schedule has {lines} values, the results have {steps} time steps"))
                .help(format!("give a value for each of the {steps} time steps, or {whole}, one for each hour of the year{leap}")));
        };
        if occupied.steps.is_empty() {
            return Err(Error::new("no time step is occupied by this schedule").help("write 1 for the times that count"));
        }
        Ok(occupied)
    }

    /// Whether each step counts.
    pub fn mask(&self, steps: usize) -> Vec<bool> {
        let mut mask = vec![false; steps];
        self.steps.iter().for_each(|s| mask[*s] = true);
        mask
    }

    /// The median of values of the steps that count.
    ///
    /// # Panics
    /// If a step has no value.
    pub fn median(&self, values: &[f64]) -> f64 {
        let mut own: Vec<f64> = self.steps.iter().map(|s| values[*s]).collect();
        own.sort_unstable_by(f64::total_cmp);
        match own.len() {
            0 => f64::NAN,
            n if n % 2 == 1 => own[n / 2],
            n => (own[n / 2 - 1] + own[n / 2]) / 2.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Step;
    use super::*;

    /// Steps of the whole year, leap or not.
    fn year(per_hour: usize, leap: bool) -> Year {
        let mut steps = Vec::new();
        for s in Year::common().steps {
            if leap && (s.month, s.day, s.begins) == (3, 1, 0.0) {
                steps.extend((0..24 * per_hour).map(|i| Step { month: 2, day: 29, begins: i as f64 / per_hour as f64 }));
            }
            steps.extend((0..per_hour).map(|i| Step { begins: s.begins + i as f64 / per_hour as f64, ..s }));
        }
        Year { steps, length: 1.0 / per_hour as f64 }
    }

    #[test]
    fn lm83_has_3650_hours_in_every_year_and_step() {
        for (per_hour, leap) in [(1, false), (1, true), (4, false), (6, true)] {
            let year = year(per_hour, leap);
            let occupied = Occupancy::lm83(&year, Clock::Standard);
            assert_eq!(occupied.hours, LM83_HOURS, "{per_hour} {leap}");
            assert_eq!(occupied.steps.len(), 3650 * per_hour);
            let begins: Vec<f64> = occupied.steps[..10 * per_hour].iter().map(|s| year.steps[*s].begins).collect();
            assert_eq!(begins[0], 8.0);
            assert!(begins[10 * per_hour - 1] < 18.0 && begins[10 * per_hour - 1] >= 17.0);
            assert!(occupied.steps.iter().all(|s| (year.steps[*s].month, year.steps[*s].day) != (2, 29)));
        }
    }

    #[test]
    fn clocks_ahead_move_the_day_by_an_hour() {
        let year = Year::common();
        let first = |o: &Occupancy, month: u8, day: u8| {
            let s = o.steps.iter().map(|s| year.steps[*s]).find(|s| (s.month, s.day) == (month, day)).unwrap();
            s.begins
        };
        let north = Occupancy::lm83(&year, Clock::Saving { from: (3, 29), until: (10, 25) });
        assert_eq!([(3, 28), (3, 29), (10, 24), (10, 25)].map(|(m, d)| first(&north, m, d)), [8.0, 7.0, 7.0, 8.0]);
        let south = Occupancy::lm83(&year, Clock::Saving { from: (10, 4), until: (4, 5) });
        assert_eq!([(1, 1), (4, 4), (4, 5), (10, 4)].map(|(m, d)| first(&south, m, d)), [7.0, 7.0, 8.0, 7.0]);
        assert_eq!((north.hours, south.hours), (LM83_HOURS, LM83_HOURS));
    }

    #[test]
    fn en17037_has_the_4380_hours_with_most_diffuse_light() {
        for (per_hour, leap) in [(1, false), (2, false), (1, true)] {
            let year = year(per_hour, leap);
            // More light the closer to noon, and a little more every day.
            let diffuse: Vec<f64> = year
                .steps
                .iter()
                .enumerate()
                .map(|(i, s)| (12.0 - s.begins.floor()).abs().mul_add(-1000.0, 20000.0) + i as f64 * 1e-3)
                .collect();
            let daylight = Occupancy::en17037(&year, &diffuse).unwrap();
            assert_eq!(daylight.hours, 4380.0);
            let mask = daylight.mask(year.steps.len());
            let least = daylight.steps.iter().map(|s| diffuse[*s]).fold(f64::INFINITY, f64::min);
            assert!((0..mask.len()).all(|s| mask[s] == (diffuse[s] >= least)));
            let median = daylight.median(&diffuse);
            let above = daylight.steps.iter().filter(|s| diffuse[**s] > median).count();
            assert_eq!(above * 2, daylight.steps.len());
        }
        let equal = Occupancy::en17037(&Year::common(), &[5000.0; 8760]).unwrap();
        assert_eq!((equal.steps.len(), equal.steps[4379]), (4380, 4379), "of equal hours the earlier");
        let mut part = Year::common();
        part.steps.truncate(4000);
        let error = Occupancy::en17037(&part, &[1.0; 4000]).unwrap_err().to_string();
        assert!(error.contains("4000 h"), "{error}");
    }

    #[test]
    fn a_schedule_of_one_s_own_fits_the_year_or_is_refused() {
        let text =
            |n: usize, header: &str| header.to_string() + &(0..n).map(|h| format!("{h},{}\n", u8::from(h % 24 == 9))).collect::<String>();
        let common = Year::common();
        let own = Occupancy::parse(&text(8760, "# office\nhour,occupied\n"), &common).unwrap();
        assert_eq!((own.hours, own.steps[0]), (365.0, 9));
        let quarters = Occupancy::parse(&text(8760, ""), &year(4, false)).unwrap();
        assert_eq!((quarters.hours, quarters.steps[..5].to_vec()), (365.0, vec![36, 37, 38, 39, 36 + 96]));
        let mut day = Year::common();
        day.steps = day.steps[48..72].to_vec();
        assert_eq!(Occupancy::parse(&text(24, ""), &day).unwrap().steps, [9]);
        // Of a whole year each step has its own hour.
        assert_eq!(Occupancy::parse(&text(8760, ""), &day).unwrap().steps, [9]);
        let refused = |text: &str, year: &Year| Occupancy::parse(text, year).unwrap_err().to_string();
        assert!(refused(&text(8760, ""), &year(1, true)).contains("8784"), "a leap year has a day more");
        assert!(refused(&text(8759, ""), &common).contains("8759 values"));
        let error = refused("occupied\n1\n0\n0.5\n", &common);
        assert!(error.contains("'0.5'") && error.contains('4'), "{error}");
        assert!(refused("1\nyes\n", &common).contains("'yes'"));
        assert!(refused(&"0\n".repeat(8760), &common).contains("no time step is occupied"));
    }
}

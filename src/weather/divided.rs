//! Steps of another length: an hour divided, with the sun where it stands in each part; or short steps as their mean.
//!
//! No sum changes. The parts of a step share its direct normal irradiance evenly among those with the sun up, and its
//! diffuse irradiance (and direct *horizontal* irradiance) as the sine of the sun's altitude, which is what a sky of the
//! same clearness does.

use super::series::SLACK_HOURS;
use super::steps::Whole;
use super::{Quantity, Record, Weather};
use crate::error::{Error, Result, Warnings};
use crate::units::{SOLAR_CONSTANT, SOLAR_CONSTANT_LUX};

/// The sun's largest irradiance over its mean, at perihelion.
const PERIHELION: f64 = 1.035;

impl Weather {
    /// The same weather in steps of so many minutes, a divisor of 60.
    ///
    /// # Errors
    /// Steps that are not even, whose times are not their middles, or that neither divide nor fill the new ones.
    pub fn with_step(mut self, minutes: u32, warnings: &mut Warnings) -> Result<Self> {
        let steps = self.steps();
        let own = (steps.length * 60.0).round() as u32;
        if own == minutes && steps.are_even {
            return Ok(self);
        }
        if !steps.are_even {
            return Err(
                Error::new("the weather's steps are of different lengths").help("give a file with even steps, or leave 'timestep' out")
            );
        }
        let slack = SLACK_HOURS.min(steps.length / 4.0);
        let off_middle = |r: &&Record| ((r.hour / steps.length).fract() - 0.5).abs() * steps.length > slack;
        if let Some(record) = self.records.iter().find(off_middle) {
            return Err(Error::new(format!(
                "steps are divided around their middles, but {:.2} h is no middle of a step of {own} minutes",
                record.hour
            ))
            .line(record.line)
            .help("write the middle of each step (0.5, 1.5, … for hours, as epw2wea does), or leave 'timestep' out"));
        }
        if !own.is_multiple_of(minutes) && !minutes.is_multiple_of(own) {
            return Err(Error::new(format!("steps of {own} minutes neither divide into nor fill steps of {minutes} minutes")));
        }
        self.settle();
        self.records = if own > minutes { self.divided(own / minutes, steps.length) } else { self.joined(f64::from(minutes) / 60.0)? };
        self.whole = self.whole.map(|w| Whole { length: f64::from(minutes) / 60.0, are_even: true, ends: false, ..w });
        self.warn_of_strong_suns(warnings);
        Ok(self)
    }

    fn divided(&self, parts: u32, length: f64) -> Vec<Record> {
        let n = f64::from(parts);
        let mut all = Vec::with_capacity(self.records.len() * parts as usize);
        for record in &self.records {
            let hour = |k: u32| record.hour - length / 2.0 + (f64::from(k) + 0.5) * length / n;
            let part = |k: u32| Record { hour: hour(k), ..*record };
            let sines: Vec<f64> = (0..parts).map(|k| self.sun(&part(k)).altitude.sin().max(0.0)).collect();
            let (sum, up) = (sines.iter().sum::<f64>(), sines.iter().filter(|s| **s > 0.0).count());
            // In the dark nothing tells one part from another.
            let by_sine = |k: usize| if sum > 0.0 { n * sines[k] / sum } else { 1.0 };
            let while_up = |k: usize| match up {
                0 => 1.0,
                _ if sines[k] > 0.0 => n / up as f64,
                _ => 0.0,
            };
            for k in 0..parts {
                let i = k as usize;
                let direct = if self.quantity == Quantity::HorizontalIrradiance { by_sine(i) } else { while_up(i) };
                all.push(Record { direct: record.direct * direct, diffuse: record.diffuse * by_sine(i), ..part(k) });
            }
        }
        all
    }

    fn joined(&self, length: f64) -> Result<Vec<Record>> {
        let whole = (length / self.steps().length).round() as usize;
        let block = |r: &Record| (r.month, r.day, (r.hour / length) as usize);
        self.records
            .chunk_by(|a, b| block(a) == block(b))
            .map(|parts| {
                let first = parts[0];
                if parts.len() != whole {
                    return Err(Error::new(format!(
                        "the step of {:.0} minutes at {}/{} {:.2} h has {} of its {whole} parts",
                        60.0 * length,
                        first.month,
                        first.day,
                        first.hour,
                        parts.len()
                    ))
                    .line(first.line)
                    .help("give a file without gaps, or leave 'timestep' out"));
                }
                let mean = |of: fn(&Record) -> f64| parts.iter().map(of).sum::<f64>() / whole as f64;
                let hour = ((first.hour / length).floor() + 0.5) * length;
                Ok(Record { hour, direct: mean(|r| r.direct), diffuse: mean(|r| r.diffuse), ..first })
            })
            .collect()
    }

    /// An hour's direct light in the one part of it with the sun up may be more than the sun has.
    fn warn_of_strong_suns(&self, warnings: &mut Warnings) {
        let most = match self.quantity {
            Quantity::Illuminance => SOLAR_CONSTANT_LUX,
            _ => SOLAR_CONSTANT,
        } * PERIHELION;
        let normal = |r: &Record| match self.quantity {
            Quantity::HorizontalIrradiance => r.direct / self.sun(r).altitude.sin().max(1e-6),
            _ => r.direct,
        };
        let strong = self.records.iter().filter(|r| r.direct > 0.0 && normal(r) > most).count();
        if strong > 0 {
            warnings.push(
                Error::new(format!(
                    "{strong} of the divided steps have a stronger sun than there is: their hour has its direct light in a part of it"
                ))
                .field("weather.timestep")
                .help("sums are those of the file; glare and pictures of these steps, at sunrise and sunset, are too bright"),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::weather::days_in;

    fn year(units: u8) -> Weather {
        let mut text = format!("place x\nlatitude 47\nlongitude -11\ntime_zone -15\nsite_elevation 0\nweather_data_file_units {units}\n");
        let site = |m: u8, d: u8, h: f64| {
            let day = super::super::DAYS_BEFORE[usize::from(m) - 1] + u16::from(d);
            super::super::sun::position(47.0, 11.0, 1.0, day, h).altitude.sin()
        };
        for month in 1..=12u8 {
            for day in 1..=days_in(month).min(if month == 2 { 28 } else { 31 }) {
                for hour in 0..24 {
                    let h = f64::from(hour) + 0.5;
                    let (mut direct, mut diffuse) = (0.0, 0.0);
                    if site(month, day, h) > 0.02 {
                        let height = site(month, day, h);
                        (direct, diffuse) = (if units == 2 { 600.0 * height } else { 600.0 }, 20.0 + 150.0 * height);
                    }
                    text.push_str(&format!("{month} {day} {h:.3} {direct:.3} {diffuse:.3}\n"));
                }
            }
        }
        Weather::from_bytes(text.as_bytes(), &mut Warnings::new()).unwrap()
    }

    #[test]
    fn divided_hours_keep_their_sums_and_have_the_sun_where_it_stands() {
        for units in [1, 2, 3] {
            let hourly = year(units);
            let quarters = hourly.clone().with_step(15, &mut Warnings::new()).unwrap();
            assert_eq!(quarters.records.len(), 4 * hourly.records.len());
            let steps = quarters.steps();
            assert!(steps.length == 0.25 && steps.are_even && steps.place(49).minute == 15 && steps.place(49).hour == 12);
            for (hour, parts) in hourly.records.iter().zip(quarters.records.chunks(4)) {
                let mean = |of: fn(&Record) -> f64| parts.iter().map(of).sum::<f64>() / 4.0;
                assert!((mean(|r| r.direct) - hour.direct).abs() < 1e-9 && (mean(|r| r.diffuse) - hour.diffuse).abs() < 1e-9);
                for (k, part) in parts.iter().enumerate() {
                    assert!((part.hour - (hour.hour - 0.375 + 0.25 * k as f64)).abs() < 1e-12);
                    assert!(part.direct == 0.0 || quarters.sun(part).altitude > 0.0, "{part:?}");
                    // Of a whole hour of sun each part has the normal irradiance of the hour.
                    if units != 2 && parts.iter().all(|p| quarters.sun(p).altitude > 0.0) {
                        assert!((part.direct - hour.direct).abs() < 1e-9);
                    }
                }
                if parts.iter().all(|p| quarters.sun(p).altitude > 0.0) && hour.diffuse > 0.0 {
                    let ratio = |a: f64, b: f64| a / b;
                    let [a, b] = [&parts[0], &parts[3]];
                    let sine = |r: &Record| quarters.sun(r).altitude.sin();
                    assert!((ratio(a.diffuse, b.diffuse) / ratio(sine(a), sine(b)) - 1.0).abs() < 1e-9);
                }
            }
            let back = quarters.with_step(60, &mut Warnings::new()).unwrap();
            for (a, b) in back.records.iter().zip(&hourly.records) {
                assert!((a.hour, a.day) == (b.hour, b.day) && (a.direct - b.direct).abs() < 1e-9 && (a.diffuse - b.diffuse).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn steps_that_cannot_be_divided_are_refused() {
        let head = "place x\nlatitude 47\nlongitude -11\ntime_zone -15\nsite_elevation 0\nweather_data_file_units 1\n";
        let read = |hours: &[f64]| {
            let lines: String = hours.iter().map(|h| format!("6 21 {h} 500 100\n")).collect();
            Weather::from_bytes(format!("{head}{lines}").as_bytes(), &mut Warnings::new()).unwrap()
        };
        let error = |hours: &[f64], minutes| read(hours).with_step(minutes, &mut Warnings::new()).unwrap_err().to_string();
        assert!(error(&[9.0, 10.0, 11.0], 30).contains("9.00 h is no middle of a step of 60 minutes"));
        assert!(error(&[9.1, 9.3, 9.5, 9.7, 9.9], 15).contains("neither divide into"));
        assert!(error(&[9.125, 9.375, 9.625], 60).contains("has 3 of its 4 parts"));
        assert!(error(&[9.0, 9.5, 10.25, 10.75, 11.0], 15).contains("different lengths"));
        // An hour of sunrise whose direct light is all in its last part.
        let mut warnings = Warnings::new();
        let low = format!("{head}6 21 4.5 900 30\n");
        let mut weather = Weather::from_bytes(low.as_bytes(), &mut Warnings::new()).unwrap();
        weather = weather.with_step(5, &mut warnings).unwrap();
        assert!((weather.records.iter().map(|r| r.direct).sum::<f64>() / 12.0 - 900.0).abs() < 1e-9);
        assert_eq!(warnings.iter().count(), 1);
    }
}

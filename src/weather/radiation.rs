//! Direct and diffuse radiation of one file: what its columns hold, what is no light, what is doubtful.

use super::{Quantity, Record, Weather, bounded, number, series};
use crate::{Error, Result, Warnings};

/// More than the sun sends: 1367 W/m² reach 1415 W/m² at perihelion; the rest is slack for
/// instruments. As illuminance, 127.5 klx per 1367 W/m².
const LIKELY_IRRADIANCE: f64 = 1500.0;

/// Values between this and what is likely come from a low sun (horizontal irradiance divided by a small sine);
/// higher ones from another unit.
const MAX_IRRADIANCE: f64 = 2.0 * LIKELY_IRRADIANCE;

/// Share of the steps with the sun up that may lack their radiation.
const MAX_GAPS: f64 = 0.05;

const FILL_GAPS: &str = "fill the gap, for instance from a neighbouring hour, or use another weather file";

/// Steps of which one thing is said once: the first with what stands there, and how many follow.
#[derive(Default)]
struct Noted {
    first: Option<(Record, String)>,
    more: usize,
}

impl Noted {
    fn add(&mut self, record: &Record, word: &str) {
        match self.first {
            None => self.first = Some((*record, if word.is_empty() { "nothing".into() } else { word.into() })),
            Some(_) => self.more += 1,
        }
    }

    fn count(&self) -> usize {
        usize::from(self.first.is_some()) + self.more
    }

    /// "-999 at 6/21 0.50 h, and 7 more steps", and the line of the first.
    fn told(&self) -> Option<(String, usize)> {
        let (first, word) = self.first.as_ref()?;
        let more = if self.more > 0 { format!(", and {} more steps", self.more) } else { String::new() };
        Some((format!("{word} at {}{more}", series::time(first)), first.line))
    }
}

/// Reads the radiation of each step, in the unit of the file, and says at the end what was unusual.
pub(super) struct Radiation {
    /// Names of direct and diffuse.
    names: [&'static str; 2],
    likely: f64,
    most: f64,
    /// The value of EPW files that means "not measured"; so do 99999 and so on.
    missing: f64,
    unit: &'static str,
    /// Steps of night taken as 0 although something else stands there.
    night: Noted,
    /// Steps with the sun up whose radiation is missing.
    gaps: Noted,
    /// The name of the value that is missing first.
    gap: &'static str,
    bright: Noted,
    daylit: usize,
}

impl Radiation {
    pub(super) fn new(quantity: Quantity) -> Self {
        let (names, missing, unit, scale) = match quantity {
            Quantity::NormalIrradiance => (["direct normal irradiance", "diffuse horizontal irradiance"], 9999.0, " W/m²", 1.0),
            Quantity::HorizontalIrradiance => (["direct horizontal irradiance", "diffuse horizontal irradiance"], 9999.0, " W/m²", 1.0),
            Quantity::Illuminance => {
                (["direct normal illuminance", "diffuse horizontal illuminance"], 999_999.0, " lx", 127_500.0 / 1367.0)
            }
        };
        Self {
            names,
            likely: scale * LIKELY_IRRADIANCE,
            most: scale * MAX_IRRADIANCE,
            missing,
            unit,
            night: Noted::default(),
            gaps: Noted::default(),
            gap: names[0],
            bright: Noted::default(),
            daylit: 0,
        }
    }

    /// Fills in direct and diffuse. A missing value is no light, and so is a negative one where the sun is down.
    pub(super) fn read(&mut self, words: [&str; 2], record: &mut Record, weather: &Weather) -> Result<()> {
        let is_night = weather.sun(record).altitude <= 0.0;
        self.daylit += usize::from(!is_night);
        // -999 and -9999 mean "not measured" too, and no instrument is 99 W/m² off.
        let nines = |v: f64| v == 10f64.powi((v + 1.0).log10().round() as i32) - 1.0;
        let is_missing = |v: f64| v <= -99.0 || (v >= self.missing && nines(v));
        let mut values = [0.0; 2];
        let mut dark = None;
        for (k, word) in words.map(str::trim).into_iter().enumerate() {
            let name = self.names[k];
            let v = if word.is_empty() { self.missing } else { number(word, name)? };
            // Radiance's gendaymtx takes -999 by day as dark and refuses 9999; so is it here.
            if is_missing(v) && v > 0.0 && !is_night {
                return Err(Error::new(format!("the value is missing ({})", if word.is_empty() { "empty" } else { word }))
                    .field(name)
                    .help(FILL_GAPS));
            }
            if is_missing(v) || (is_night && v < 0.0) {
                dark.get_or_insert((k, word));
                continue;
            }
            values[k] = bounded(word, name, 0.0, self.most, self.unit)?;
        }
        // One half of a gap says little of the other: both are dark.
        [record.direct, record.diffuse] = if dark.is_some() && !is_night { [0.0; 2] } else { values };
        match dark {
            Some((_, word)) if is_night => self.night.add(record, word),
            Some((k, word)) => {
                if self.gaps.count() == 0 {
                    self.gap = self.names[k];
                }
                self.gaps.add(record, word);
            }
            None if values[0] > self.likely || values[1] > self.likely => {
                self.bright.add(record, &format!("{:.0}{}", values[0].max(values[1]), self.unit));
            }
            None => {}
        }
        Ok(())
    }

    /// Says once what was taken as dark and what is brighter than the sun.
    ///
    /// # Errors
    /// Radiation missing in more than [`MAX_GAPS`] of the steps with the sun up.
    pub(super) fn finish(&self, warnings: &mut Warnings) -> Result<()> {
        if let Some((told, line)) = self.night.told() {
            warnings.push(Error::new(format!("negative or missing radiation while the sun is down ({told}): 0 is used")).line(line));
        }
        if let Some((told, line)) = self.gaps.told() {
            let (gaps, daylit) = (self.gaps.count(), self.daylit);
            let message = format!("the value is missing ({told}): {gaps} of {daylit} steps with the sun up");
            if gaps as f64 > MAX_GAPS * daylit as f64 {
                return Err(Error::new(message).line(line).field(self.gap).help(FILL_GAPS));
            }
            warnings.push(
                Error::new(format!("{message}: these are dark in the results, so sums and shares of the year come out too low"))
                    .line(line)
                    .field(self.gap)
                    .help(FILL_GAPS),
            );
        }
        if let Some((told, line)) = self.bright.told() {
            warnings.push(
                Error::new(format!("brighter than the sun outside the atmosphere ({told}): used as it stands"))
                    .line(line)
                    .help("a direct value that was divided by the sine of a low sun does this: check these steps"),
            );
        }
        Ok(())
    }
}

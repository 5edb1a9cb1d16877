//! Weather files: a year (or any list of hours) of direct and diffuse irradiance at a site.
//!
//! Two formats are read, told apart by their first word: EnergyPlus weather files (`epw`) and
//! Radiance's (`wea`). What is impossible (a month 13, a negative irradiance, a missing hour in a
//! year) is an error with its line; what is only suspicious becomes a warning.

pub mod chosen;
mod dew;
mod divided;
mod epw;
pub mod given;
mod radiation;
mod series;
mod steps;
pub mod sun;
pub mod time;
mod wea;

pub(crate) use dew::DewPoints;
pub use steps::{Days, Place, Steps, Whole};

use crate::error::{Error, Result, Warnings};
use std::path::Path;
use sun::SunPosition;

/// What the values of a weather file's records mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Direct normal and diffuse horizontal irradiance, W/m² (EPW, and WEA units 1).
    NormalIrradiance,
    /// Direct *horizontal* and diffuse horizontal irradiance, W/m² (WEA units 2).
    HorizontalIrradiance,
    /// Direct normal and diffuse horizontal illuminance, lx (WEA units 3).
    Illuminance,
}

/// One time step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Month, 1…12.
    pub month: u8,
    /// Day of the month, from 1.
    pub day: u8,
    /// Local standard time in hours, 0…24; the middle of the interval for hourly EPW files.
    pub hour: f64,
    /// Day of the year from 1, as gendaymtx counts: of a common year until the file has shown a
    /// 29 February (day 60), one more for every record after it.
    pub day_of_year: u16,
    /// Direct component; its meaning and unit are the file's [`Quantity`].
    pub direct: f64,
    /// Diffuse horizontal component, W/m² or lx.
    pub diffuse: f64,
    /// Dew point temperature in °C, where the file tells.
    pub dew_point: Option<f64>,
    /// Line in the file, from 1.
    pub line: usize,
}

/// A CIE sky's kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CieSky {
    /// Clear sky, with or without its sun.
    Clear,
    /// Between clear and overcast.
    Intermediate,
    /// Overcast: the zenith is three times as bright as the horizon, wherever the sun stands.
    Overcast,
    /// The same luminance everywhere.
    Uniform,
}

impl CieSky {
    /// All kinds and their words.
    pub const ALL: [(&'static str, Self); 4] =
        [("clear", Self::Clear), ("intermediate", Self::Intermediate), ("overcast", Self::Overcast), ("uniform", Self::Uniform)];

    /// Its word.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }

    /// Whether its formula knows where the sun stands.
    pub fn shows_sun(self) -> bool {
        matches!(self, Self::Clear | Self::Intermediate)
    }
}

/// A site and its weather.
#[derive(Debug, Clone, PartialEq)]
pub struct Weather {
    /// Name of the place, as the file writes it.
    pub place: String,
    /// Degrees, north positive.
    pub latitude: f64,
    /// Degrees, *east* positive (WEA files write it west positive).
    pub longitude: f64,
    /// Standard time minus UTC, hours (WEA files write degrees west: −15 × this).
    pub time_zone: f64,
    /// Metres above the sea.
    pub elevation: f64,
    /// What the records' values mean.
    pub quantity: Quantity,
    /// The time steps in the order of the file.
    pub records: Vec<Record>,
    /// Where north lies in the scene: so many degrees from +Y, counter-clockwise seen from above.
    pub north: f64,
    /// The sky of each record where it is one of the CIE's; empty for Perez' sky of the weather.
    pub skies: Vec<CieSky>,
    /// Names of moments, one per record; empty for those without.
    pub names: Vec<String>,
    /// What the file told as a whole, where records were taken out or divided: then their dew points are means too.
    pub whole: Option<Whole>,
    /// A sky made elsewhere, in place of one made from the records.
    pub given: Option<given::GivenSky>,
}

impl Weather {
    /// Weather without a place and without time steps.
    pub fn nowhere(quantity: Quantity) -> Self {
        Self {
            place: String::new(),
            latitude: 0.0,
            longitude: 0.0,
            time_zone: 0.0,
            elevation: 0.0,
            quantity,
            records: Vec::new(),
            north: 0.0,
            skies: Vec::new(),
            names: Vec::new(),
            whole: None,
            given: None,
        }
    }

    /// Reads a weather file, EPW or WEA.
    ///
    /// # Errors
    /// With file, line and field: a file that cannot be read or is neither format, a header that
    /// lacks the site, records that are short, missing, unreadable or impossible.
    pub fn read(path: &Path, warnings: &mut Warnings) -> Result<Self> {
        let mut own = Warnings::new();
        let result = Self::from_bytes(&crate::files::read(path)?, &mut own);
        for w in own.iter() {
            warnings.push(w.clone().file(path));
        }
        result.map_err(|e| e.file(path))
    }

    /// Reads the contents of a weather file, for instance from standard input.
    ///
    /// # Errors
    /// As [`read`](Self::read), without the file's name.
    pub fn from_bytes(bytes: &[u8], warnings: &mut Warnings) -> Result<Self> {
        let mut text = crate::text::decode(bytes, "a weather file")?;
        if text.trim_start().get(..9).is_some_and(|w| w.eq_ignore_ascii_case("location;")) {
            text = text.replace(',', ".").replace(';', ",").into();
            warnings.push(
                Error::new("a spreadsheet wrote this EPW file with semicolons: they are read as its commas, and commas as decimal points")
                    .help("compare some values with the original file"),
            );
        }
        let first = text.lines().find(|l| !l.trim().is_empty()).unwrap_or_default().trim_start();
        let starts_with = |word: &str| first.get(..word.len()).is_some_and(|w| w.eq_ignore_ascii_case(word));
        if first.is_empty() {
            return Err(Error::new("the file is empty").help("expected a weather file, EPW or WEA"));
        }
        let weather = if starts_with("place") {
            wea::parse(&text, warnings)?
        } else if starts_with("location,") {
            epw::parse(&text, warnings)?
        } else {
            return Err(Error::new("this is neither an EPW file (first word LOCATION) nor a WEA file (first word place)").line(1));
        };
        series::check_sun(&weather, warnings);
        Ok(weather)
    }

    /// Where the sun stands at a record's time.
    pub fn sun(&self, record: &Record) -> SunPosition {
        sun::position(self.latitude, self.longitude, self.time_zone, record.day_of_year, record.hour)
    }
}

/// Days before each month of a common year.
const DAYS_BEFORE: [u16; 13] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334, 365];

/// Days of a month (1…12); February has 29, since the files do not tell the year reliably.
fn days_in(month: u8) -> u8 {
    if month == 2 { 29 } else { (DAYS_BEFORE[usize::from(month)] - DAYS_BEFORE[usize::from(month) - 1]) as u8 }
}

/// Day of a common year (from 1).
pub(crate) fn day_of_year(month: u8, day: u8) -> u16 {
    DAYS_BEFORE[usize::from(month) - 1] + u16::from(day)
}

/// Counts days of the year along a file: see [`Record::day_of_year`].
#[derive(Default)]
struct Calendar {
    leap_day_seen: bool,
}

impl Calendar {
    fn day_of_year(&mut self, month: u8, day: u8) -> u16 {
        let common = day_of_year(month, day);
        if (month, day) == (2, 29) {
            self.leap_day_seen = true;
            common
        } else {
            common + u16::from(self.leap_day_seen)
        }
    }
}

/// A finite number, or an error that quotes what stands there.
fn number(text: &str, field: &str) -> Result<f64> {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => {
            let shown: String = text.chars().take(30).collect();
            Err(Error::new(format!("'{}' is not a number{}", shown.escape_debug(), crate::text::why_no_number(&shown))).field(field))
        }
    }
}

/// A number between two limits, or an error that says what is possible.
fn bounded(text: &str, field: &str, low: f64, high: f64, unit: &str) -> Result<f64> {
    let v = number(text, field)?;
    if !(low..=high).contains(&v) {
        return Err(Error::new(format!("{v} is impossible: it lies outside {low} … {high:.0}{unit}")).field(field));
    }
    Ok(v)
}

/// Month and day as numbers that exist.
fn date(month: &str, day: &str) -> Result<(u8, u8)> {
    let whole = |text: &str, field: &str, most: u8| {
        let v = bounded(text, field, 1.0, f64::from(most), "")?;
        if v.fract() == 0.0 { Ok(v as u8) } else { Err(Error::new(format!("{v} is not a whole number")).field(field)) }
    };
    let month = whole(month, "month", 12)?;
    Ok((month, whole(day, "day", days_in(month))?))
}

/// Refuses a site that is not on Earth, and doubts one whose clock does not fit its longitude.
fn check_site(weather: &Weather, warnings: &mut Warnings) {
    let off = (weather.longitude - 15.0 * weather.time_zone + 180.0).rem_euclid(360.0) - 180.0;
    // The widest real zone (China) reaches 45° from its meridian.
    if off.abs() > 50.0 {
        warnings.push(
            Error::new(format!(
                "the clock (UTC{:+}) is {:.0}° away from the longitude ({:.2}° east)",
                weather.time_zone,
                off.abs(),
                weather.longitude
            ))
            .help("check the signs: WEA files count longitude and time zone positive to the west, EPW files to the east"),
        );
    }
}

#[cfg(test)]
mod tests;

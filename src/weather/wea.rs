//! Radiance's weather files (`epw2wea`, `gendaymtx`):
//!
//! ```text
//! place New York City/Central_USA
//! latitude 40.78                  degrees north
//! longitude 73.96                 degrees WEST
//! time_zone 75                    degrees WEST
//! site_elevation 40.0             metres
//! weather_data_file_units 1       1, 2 or 3: see Quantity
//! 1 1 0.500 0 0                   month day hour direct diffuse [aerosol optical depth, cloud cover…]
//! ```

use super::radiation::Radiation;
use super::{Calendar, Quantity, Record, Weather, bounded, check_site, date, number, series};
use crate::error::{Error, Result, Warnings};
use crate::text;

const KEYS: [&str; 6] = ["place", "latitude", "longitude", "time_zone", "site_elevation", "weather_data_file_units"];

pub(super) fn parse(text: &str, warnings: &mut Warnings) -> Result<Weather> {
    let mut values: [Option<f64>; KEYS.len()] = [None; KEYS.len()];
    let mut place = String::new();
    let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).filter(|(_, l)| !l.is_empty()).peekable();
    let mut last_line = 1;
    while let Some(&(line, content)) = lines.peek() {
        let (word, value) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
        let Some(key) = KEYS.iter().position(|k| word.eq_ignore_ascii_case(k)) else { break };
        if key == 0 {
            place = value.trim().to_string();
        }
        let (low, high) = match KEYS[key] {
            "latitude" => (-90.0, 90.0),
            "longitude" => (-180.0, 180.0),
            // UTC+14 … UTC−12.
            "time_zone" => (-210.0, 180.0),
            "site_elevation" => (-1000.0, 9999.9),
            "weather_data_file_units" => (1.0, 3.0),
            _ => (0.0, 0.0),
        };
        let parsed = if key == 0 { Ok(0.0) } else { bounded(value, KEYS[key], low, high, "") };
        values[key] = Some(parsed.map_err(|e| e.line(line))?);
        last_line = line;
        lines.next();
    }
    let get = |key: &str| {
        let index = KEYS.iter().position(|k| *k == key).expect("a key of the table");
        values[index].ok_or_else(|| {
            Error::new(format!("the header has no '{key}'")).line(last_line + 1).help(format!("a WEA file begins with {}", KEYS.join(", ")))
        })
    };
    let quantity = match get("weather_data_file_units")? {
        1.0 => Quantity::NormalIrradiance,
        2.0 => Quantity::HorizontalIrradiance,
        3.0 => Quantity::Illuminance,
        other => {
            return Err(Error::new(format!("{other} is none of the known kinds of data"))
                .field("weather_data_file_units")
                .line(last_line)
                .help("1 = direct normal and diffuse horizontal irradiance, 2 = direct and diffuse horizontal irradiance, 3 = direct normal and diffuse horizontal illuminance"));
        }
    };
    let mut weather = Weather {
        place,
        latitude: get("latitude")?,
        longitude: -get("longitude")?,
        time_zone: -get("time_zone")? / 15.0,
        elevation: get("site_elevation").unwrap_or(0.0),
        ..Weather::nowhere(quantity)
    };
    check_site(&weather, warnings);
    let mut calendar = Calendar::default();
    let mut radiation = Radiation::new(quantity);
    for (line, content) in lines {
        let record = record(content, line, &weather, &mut radiation, &mut calendar).map_err(|e| e.line(line))?;
        weather.records.push(record);
        last_line = line;
    }
    if weather.records.is_empty() {
        return Err(Error::new("the file ends after its header: there is no time step").line(last_line));
    }
    radiation.finish(warnings)?;
    series::check_wea(&weather.records, warnings)?;
    Ok(weather)
}

fn record(content: &str, line: usize, weather: &Weather, radiation: &mut Radiation, calendar: &mut Calendar) -> Result<Record> {
    let words = text::words(content)?;
    let [month, day, hour, direct, diffuse, ..] = words.as_slice() else {
        // A header line out of place and a cut line are different mistakes.
        number(words.first().map_or("", |w| w), "month").map_err(|e| e.help("a record is: month day hour direct diffuse"))?;
        return Err(Error::new(format!("a record needs 5 columns, this line has {}", words.len())).help("month day hour direct diffuse"));
    };
    let (month, day) = date(month, day)?;
    let hour = bounded(hour, "hour", 0.0, 24.0, "")?;
    let day_of_year = calendar.day_of_year(month, day);
    let mut record = Record { month, day, hour, day_of_year, direct: 0.0, diffuse: 0.0, dew_point: None, line };
    radiation.read([direct, diffuse], &mut record, weather)?;
    Ok(record)
}

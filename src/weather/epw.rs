//! EnergyPlus weather files (EnergyPlus Auxiliary Programs, "EPW data dictionary"): eight header
//! lines of comma-separated words, then one line per time step. Only what daylight needs is read.

use super::radiation::Radiation;
use super::{Calendar, Quantity, Record, Weather, bounded, check_site, date, number, series};
use crate::error::{Error, Result, Warnings};
use series::Period;

/// Columns of a data line (from 0), and the values that mean "not measured".
const DEW_POINT: usize = 7;
const DIRECT_NORMAL: usize = 14;
const DIFFUSE_HORIZONTAL: usize = 15;
const MISSING_DEW_POINT: f64 = 99.9;

pub(super) fn parse(text: &str, warnings: &mut Warnings) -> Result<Weather> {
    let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).filter(|(_, l)| !l.is_empty());
    let (line, location) = lines.next().ok_or_else(|| Error::new("the file is empty"))?;
    let mut weather = site(location).map_err(|e| e.line(line))?;
    check_site(&weather, warnings);

    let mut last_line = line;
    let period = loop {
        let Some((line, content)) = lines.next() else {
            return Err(Error::new("the file ends inside its header")
                .line(last_line)
                .help("an EPW file has a line DATA PERIODS before its records"));
        };
        last_line = line;
        if content.get(..13).is_some_and(|w| w.eq_ignore_ascii_case("DATA PERIODS,")) {
            break data_periods(content, warnings).map_err(|e| e.line(line))?;
        }
        if content.starts_with(|c: char| c.is_ascii_digit()) {
            return Err(Error::new("records begin before the header's line DATA PERIODS").line(line));
        }
    };

    let mut calendar = Calendar::default();
    let mut columns = None;
    let mut radiation = Radiation::new(weather.quantity);
    for (line, content) in lines {
        let fields: Vec<&str> = content.split(',').collect();
        let wanted = *columns.get_or_insert(fields.len().max(DIFFUSE_HORIZONTAL + 1));
        if fields.len() < wanted {
            return Err(
                Error::new(format!("the record has {} fields where {wanted} are expected: it is cut short", fields.len())).line(line)
            );
        }
        let mut record = record(&fields, line, period.per_hour, &mut calendar).map_err(|e| e.line(line))?;
        radiation.read([fields[DIRECT_NORMAL], fields[DIFFUSE_HORIZONTAL]], &mut record, &weather).map_err(|e| e.line(line))?;
        weather.records.push(record);
        last_line = line;
    }
    if weather.records.is_empty() {
        return Err(Error::new("the file ends after its header: there is no time step").line(last_line));
    }
    radiation.finish(warnings)?;
    series::check_epw(&weather.records, &period, warnings)?;
    Ok(weather)
}

fn site(location: &str) -> Result<Weather> {
    let fields: Vec<&str> = location.split(',').map(str::trim).collect();
    let &[_, city, _state, country, _source, _wmo, latitude, longitude, time_zone, elevation, ..] = fields.as_slice() else {
        return Err(Error::new(format!("LOCATION has {} fields where 10 are expected", fields.len()))
            .help("LOCATION,city,state,country,source,WMO,latitude,longitude,time zone,elevation"));
    };
    Ok(Weather {
        place: format!("{city}_{country}"),
        latitude: bounded(latitude, "latitude", -90.0, 90.0, "°")?,
        longitude: bounded(longitude, "longitude", -180.0, 180.0, "°")?,
        time_zone: bounded(time_zone, "time zone", -12.0, 14.0, " h")?,
        elevation: bounded(elevation, "elevation", -1000.0, 9999.9, " m")?,
        ..Weather::nowhere(Quantity::NormalIrradiance)
    })
}

/// `DATA PERIODS,number of periods,records per hour,name,weekday,first date,last date`
fn data_periods(content: &str, warnings: &mut Warnings) -> Result<Period> {
    let fields: Vec<&str> = content.split(',').map(str::trim).collect();
    let field = |i: usize| fields.get(i).copied().unwrap_or_default();
    let per_hour = bounded(field(2), "records per hour", 1.0, 60.0, "")?;
    if per_hour.fract() != 0.0 {
        return Err(Error::new(format!("{per_hour} is not a whole number")).field("records per hour"));
    }
    let several = number(field(1), "number of data periods")? != 1.0;
    let dates = (epw_date(field(5)), epw_date(field(6)));
    let limits = match dates {
        (Some(first), Some(last)) if !several => Some([first, last]),
        _ => {
            let why = if several { "there are several data periods" } else { "the first and last date are not readable" };
            warnings.push(Error::new(format!("{why}: whether all records are there is not checked")).field("DATA PERIODS"));
            None
        }
    };
    Ok(Period { per_hour: per_hour as u32, limits })
}

/// `month/day` or `month/day/year`, with blanks.
fn epw_date(text: &str) -> Option<(u8, u8)> {
    let mut parts = text.split('/');
    date(parts.next()?, parts.next()?).ok()
}

/// A record without its radiation.
fn record(fields: &[&str], line: usize, per_hour: u32, calendar: &mut Calendar) -> Result<Record> {
    let (month, day) = date(fields[1], fields[2])?;
    let hour = bounded(fields[3], "hour", 1.0, 24.0, "")?;
    let minute = bounded(fields[4], "minute", 0.0, 60.0, "")?;
    // Hourly records stand for the hour that ends; finer ones for their instant (as gendaymtx).
    let hour = hour - 1.0 + if per_hour == 1 { 0.5 } else { minute / 60.0 };
    let dew_point = match fields[DEW_POINT].trim() {
        "" => None,
        text if (number(text, "dew point")? - MISSING_DEW_POINT).abs() < 1e-6 => None,
        text => Some(bounded(text, "dew point", -90.0, 70.0, " °C")?),
    };
    Ok(Record { month, day, hour, day_of_year: calendar.day_of_year(month, day), direct: 0.0, diffuse: 0.0, dew_point, line })
}

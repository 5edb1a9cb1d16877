//! Whether a file's time steps follow each other without gaps, and fit the sun.

use super::{Quantity, Record, Weather, days_in};
use crate::error::{Error, Result, Warnings};
use crate::units::LUMINOUS_EFFICACY;

/// What an EPW header promises.
pub(super) struct Period {
    /// Records per hour.
    pub per_hour: u32,
    /// First and last date (month, day), where readable.
    pub limits: Option<[(u8, u8); 2]>,
}

/// Slack for hours written with two or three decimals (five minutes are 0.0833 h).
const SLACK_HOURS: f64 = 0.011;

/// Hours from one record to the next; `None` if the next is neither on the same nor on the
/// following day. The 28 February may be followed by the 29th or by March, December by January.
fn hours_between(earlier: &Record, later: &Record) -> Option<f64> {
    let (month, day) = (earlier.month, earlier.day);
    let next_day = if day < days_in(month) { (month, day + 1) } else { (month % 12 + 1, 1) };
    let date = (later.month, later.day);
    let days = if date == (month, day) {
        0.0
    } else if date == next_day || ((month, day) == (2, 28) && date == (3, 1)) {
        1.0
    } else {
        return None;
    };
    Some(24.0 * days + later.hour - earlier.hour)
}

/// The first pair that is not `step` hours apart, as an error at the line of the second.
fn gap(records: &[Record], step: f64) -> Option<Error> {
    let pair = records.windows(2).find(|w| !hours_between(&w[0], &w[1]).is_some_and(|h| (h - step).abs() < SLACK_HOURS))?;
    let goes_back = hours_between(&pair[0], &pair[1]).map_or((pair[1].month, pair[1].day) < (pair[0].month, pair[0].day), |h| h <= 0.0);
    let what = if goes_back { "the series repeats or goes back in time" } else { "time steps are missing" };
    Some(Error::new(format!("{what}: {} is followed by {}", time(&pair[0]), time(&pair[1]))).line(pair[1].line).help(format!(
        "the series has one record every {}; fill the gap, or use another weather file",
        if (step - 1.0).abs() < SLACK_HOURS { "hour".to_string() } else { format!("{:.0} minutes", step * 60.0) }
    )))
}

fn time(r: &Record) -> String {
    format!("{}/{} {:.2} h", r.month, r.day, r.hour)
}

fn starts_its_day(first: &Record, step: f64) -> bool {
    first.hour < step + SLACK_HOURS
}

fn ends_its_day(last: &Record, step: f64) -> bool {
    last.hour > 24.0 - step - SLACK_HOURS
}

/// An EPW file must hold exactly the period that its header promises; less than a day is taken for
/// an excerpt made by hand.
pub(super) fn check_epw(records: &[Record], period: &Period) -> Result<()> {
    let step = 1.0 / f64::from(period.per_hour);
    let (Some([first_date, last_date]), Some(first), Some(last)) = (period.limits, records.first(), records.last()) else {
        return Ok(());
    };
    if records.len() < 24 * period.per_hour as usize {
        return Ok(());
    }
    if let Some(error) = gap(records, step) {
        return Err(error);
    }
    let missing = |r: &Record, what: &str, date: (u8, u8)| {
        Error::new(format!(
            "time steps are missing: the records {what} on {}, the header's DATA PERIODS says {}/{}",
            time(r),
            date.0,
            date.1
        ))
        .line(r.line)
        .help("get the complete file, or correct its DATA PERIODS if a part of the year is meant")
    };
    if (first.month, first.day) != first_date || !starts_its_day(first, step) {
        return Err(missing(first, "begin", first_date));
    }
    let leap_february = last_date == (2, 28) && (last.month, last.day) == (2, 29);
    if ((last.month, last.day) != last_date && !leap_february) || !ends_its_day(last, step) {
        return Err(missing(last, "end", last_date));
    }
    Ok(())
}

/// A WEA file may list any hours, in any order. One that spans the whole year from its first to
/// its last step must be complete; one that begins as a year and stops early is doubtful.
pub(super) fn check_wea(records: &[Record], warnings: &mut Warnings) -> Result<()> {
    let [first, second, .., last] = records else { return Ok(()) };
    let Some(step) = hours_between(first, second).filter(|h| *h > 0.0 && *h <= 1.0 + SLACK_HOURS) else { return Ok(()) };
    let from_new_year = (first.month, first.day) == (1, 1) && starts_its_day(first, step);
    if !from_new_year || records.len() < 28 * 24 {
        return Ok(());
    }
    let to_new_year = (last.month, last.day) == (12, 31) && ends_its_day(last, step);
    match gap(records, step) {
        // Fewer than half of the steps are a choice (say, of the hours with sun), not a loss.
        Some(error) if to_new_year && records.len() as f64 * step > 4380.0 => Err(error),
        Some(error) => {
            warnings.push(error);
            Ok(())
        }
        None => {
            if !to_new_year {
                warnings.push(
                    Error::new(format!("the series begins with the year but ends on {}", time(last)))
                        .line(last.line)
                        .help("if a full year is meant, the file was cut short"),
                );
            }
            Ok(())
        }
    }
}

/// Direct sun while the sun is below the horizon betrays a wrong site or clock (gendaymtx warns of
/// each such hour; here they are counted).
pub(super) fn check_sun(weather: &Weather, warnings: &mut Warnings) {
    let bright = if weather.quantity == Quantity::Illuminance { 20.0 * LUMINOUS_EFFICACY } else { 20.0 };
    let mut dark = weather.records.iter().filter(|r| r.direct > bright && !weather.sun(r).is_up());
    if let Some(first) = dark.next() {
        let others = dark.count();
        let more = if others > 0 { format!(", and {others} more like it") } else { String::new() };
        warnings.push(
            Error::new(format!("direct sun while the sun is below the horizon ({}{more})", time(first)))
                .line(first.line)
                .help("check latitude, longitude, time zone and their signs"),
        );
    }
}

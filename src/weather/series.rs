//! Whether a file's time steps follow each other without gaps, and fit the sun.

use super::{DAYS_BEFORE, Quantity, Record, Weather, days_in};
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
pub(super) const SLACK_HOURS: f64 = 0.011;

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

/// Date and hour of a record, for messages.
pub(super) fn time(r: &Record) -> String {
    format!("{}/{} {:.2} h", r.month, r.day, r.hour)
}

fn starts_its_day(first: &Record, step: f64) -> bool {
    first.hour < step + SLACK_HOURS
}

fn ends_its_day(last: &Record, step: f64) -> bool {
    last.hour > 24.0 - step - SLACK_HOURS
}

/// An EPW file may hold chosen hours or days of the period that its header promises, as a WEA file
/// may; a warning says so. One that spans the period must be complete: a gap is a loss where more
/// than half of the steps are there. Less than a day is taken for an excerpt made by hand.
pub(super) fn check_epw(records: &[Record], period: &Period, warnings: &mut Warnings) -> Result<()> {
    let step = 1.0 / f64::from(period.per_hour);
    let (Some([first_date, last_date]), Some(first), Some(last)) = (period.limits, records.first(), records.last()) else {
        return Ok(());
    };
    if records.len() < 24 * period.per_hour as usize {
        return Ok(());
    }
    let begins = (first.month, first.day) == first_date && starts_its_day(first, step);
    let leap_february = last_date == (2, 28) && (last.month, last.day) == (2, 29);
    let ends = ((last.month, last.day) == last_date || leap_february) && ends_its_day(last, step);
    let promised = days_from(first_date, last_date) * 24 * period.per_hour as usize;
    match gap(records, step) {
        Some(error) if begins && ends && 2 * records.len() > promised => return Err(error),
        None if begins && ends => return Ok(()),
        _ => {}
    }
    warnings.push(
        Error::new(format!(
            "the file has {} time steps, from {} to {}; its DATA PERIODS promises {promised}, from {}/{} to {}/{}: those that are there are used",
            records.len(),
            time(first),
            time(last),
            first_date.0,
            first_date.1,
            last_date.0,
            last_date.1
        ))
        .line(first.line)
        .help("if all of them are meant, get the complete file"),
    );
    Ok(())
}

/// Days from one date to another, both counted, in a common year; over New Year if the second comes
/// before the first.
fn days_from(first: (u8, u8), last: (u8, u8)) -> usize {
    let day = |(month, day): (u8, u8)| usize::from(DAYS_BEFORE[usize::from(month) - 1]) + usize::from(day);
    (day(last) + 365 - day(first)) % 365 + 1
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

/// Direct sun while the sun is below the horizon for the whole step betrays a wrong site or clock.
/// (gendaymtx looks at one instant of each step: it calls most hours of sunrise and sunset wrong.)
pub(super) fn check_sun(weather: &Weather, warnings: &mut Warnings) {
    let bright = if weather.quantity == Quantity::Illuminance { 20.0 * LUMINOUS_EFFICACY } else { 20.0 };
    let step = usual_step(&weather.records);
    // The middle of an hour stands for that hour; of other stamps nobody knows whether their step
    // begins, ends or has its middle there.
    let reach = |r: &Record| if (r.hour.fract() - 0.5).abs() < SLACK_HOURS && step > 1.0 - SLACK_HOURS { step / 2.0 } else { step };
    let is_dark =
        |r: &Record| [-1.0, -0.5, 0.0, 0.5, 1.0].iter().all(|k| !weather.sun(&Record { hour: r.hour + k * reach(r), ..*r }).is_up());
    let mut dark = weather.records.iter().filter(|r| r.direct > bright && is_dark(r));
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

/// Hours from one record to the next, where they follow each other most closely; at most one.
fn usual_step(records: &[Record]) -> f64 {
    let steps = records.windows(2).filter_map(|w| hours_between(&w[0], &w[1]));
    steps.filter(|h| *h > SLACK_HOURS).fold(1.0, f64::min)
}

//! `[metrics]`: what is made of the year, and which hours count.
//!
//! ```toml
//! [metrics]
//! occupancy = "lm-83"                 # of DA, cDA, UDI: "lm-83" | "en-17037" | "office.csv", a line with 0 or 1 per hour
//! metrics = ["lm-83", "en-17037"]     # left out: all of them, see Family
//! autonomy = 300                      # DA and cDA, lx
//! useful = [100, 300, 3000]           # limits of UDI's four bands, lx
//! daylight_saving = ["03-29", "10-25"]  # clocks are an hour ahead from the first day until before the second
//! openings = "side"                   # EN 17037: "side" (table A.1) | "roof" (horizontal, table A.2)
//! median_diffuse = 19600              # EN 17037 method 1: lx outdoors; left out: by the weather
//! sunlight_date = "03-21"             # EN 17037 exposure to sunlight: a day from 1 February to 21 March
//! sunlight_altitude = 10              # and the least altitude of the sun that counts, degrees
//! ```

use super::table::Table;
use crate::error::Result;
use crate::metrics::en17037::{Openings, exposure_to_sunlight};
use crate::metrics::{AUTONOMY_LX, Clock, EXCEEDED_LX, FELL_SHORT_LX};
use crate::weather::time::Time;
use std::path::PathBuf;

/// Whose hours count for daylight autonomy and useful daylight.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum OccupancyChoice {
    /// LM-83's.
    #[default]
    Lm83,
    /// EN 17037's daylight hours.
    En17037,
    /// A file's.
    File(PathBuf),
}

/// Metrics that belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// DA, cDA, UDI.
    Autonomy,
    /// Annual light exposure.
    Exposure,
    /// sDA (or the DA300 spatial share) and ASE.
    Lm83,
    /// LEED v4.1.
    Leed,
    /// EN 17037.
    En17037,
    /// Daylight factor.
    DaylightFactor,
    /// Vertical illuminance.
    Vertical,
    /// sGA and sDG.
    Glare,
}

impl Family {
    /// All of them, and their words.
    pub const NAMES: [(&'static str, Self); 8] = [
        ("autonomy", Self::Autonomy),
        ("exposure", Self::Exposure),
        ("lm-83", Self::Lm83),
        ("leed", Self::Leed),
        ("en-17037", Self::En17037),
        ("daylight-factor", Self::DaylightFactor),
        ("vertical", Self::Vertical),
        ("glare", Self::Glare),
    ];
}

/// `[metrics]`.
#[derive(Debug, Clone, PartialEq)]
pub struct MetricsSection {
    /// Hours of DA, cDA, UDI and vertical illuminance.
    pub occupancy: OccupancyChoice,
    /// What is wanted.
    pub families: Vec<Family>,
    /// Illuminance of DA and cDA, lx.
    pub autonomy: f64,
    /// Limits of UDI's bands, lx.
    pub useful: [f64; 3],
    /// Clock of LM-83.
    pub clock: Clock,
    /// Tables of EN 17037.
    pub openings: Openings,
    /// Median of the diffuse illuminance outdoors, lx.
    pub median_diffuse: Option<f64>,
    /// Day of EN 17037's exposure to sunlight: month and day.
    pub sunlight_date: (u8, u8),
    /// Altitude of the sun from which it counts there, degrees.
    pub sunlight_altitude: f64,
}

impl Default for MetricsSection {
    fn default() -> Self {
        Self {
            occupancy: OccupancyChoice::default(),
            families: Family::NAMES.map(|(_, f)| f).to_vec(),
            autonomy: AUTONOMY_LX,
            useful: [FELL_SHORT_LX, AUTONOMY_LX, EXCEEDED_LX],
            clock: Clock::default(),
            openings: Openings::default(),
            median_diffuse: None,
            sunlight_date: (3, 21),
            sunlight_altitude: 10.0,
        }
    }
}

impl MetricsSection {
    /// Whether a family is wanted.
    pub fn wants(&self, family: Family) -> bool {
        self.families.contains(&family)
    }

    pub(super) fn read(table: Option<Table<'_, '_>>) -> Result<Self> {
        let Some(mut table) = table else { return Ok(Self::default()) };
        let mut section = Self::default();
        let word = table.string("occupancy")?;
        section.occupancy = match word.as_deref() {
            None | Some("lm-83") => OccupancyChoice::Lm83,
            Some("en-17037") => OccupancyChoice::En17037,
            Some(text) if text.contains('.') => OccupancyChoice::File(table.path("occupancy")?.unwrap_or_default()),
            Some(text) => {
                return Err(table
                    .error("occupancy", format!("'{text}' is not known here"))
                    .help("choose \"lm-83\", \"en-17037\", or a file \"….csv\" with a line of 0 or 1 for each hour of the year"));
            }
        };
        if let Some(names) = table.strings("metrics", "[\"lm-83\", \"en-17037\"]")? {
            let of = |name: &String| {
                Family::NAMES.iter().find(|(n, _)| n == name).map(|(_, f)| *f).ok_or_else(|| {
                    let all = Family::NAMES.map(|(n, _)| format!("\"{n}\"")).join(", ");
                    table.error("metrics", format!("'{name}' is not known here")).help(format!("choose of {all}"))
                })
            };
            section.families = names.iter().map(of).collect::<Result<_>>()?;
        }
        section.autonomy = table.number("autonomy", 1.0..=1e6)?.unwrap_or(section.autonomy);
        if let Some(limits) = table.numbers("useful", 0.0..=1e6)? {
            section.useful = match limits[..] {
                [a, b, c] if a < b && b < c => [a, b, c],
                _ => {
                    return Err(table
                        .error("useful", "the limits of useful daylight are three rising numbers")
                        .help("write useful = [100, 300, 3000]: supplementary from the first, autonomous from the second, exceeded above the third"));
                }
            };
        }
        section.clock = clock(&mut table)?;
        section.openings = table.choice("openings", &[("side", Openings::Side), ("roof", Openings::Roof)])?.unwrap_or_default();
        section.median_diffuse = table.number("median_diffuse", 100.0..=1e6)?;
        if let Some(text) = table.string("sunlight_date")? {
            let date = day(&text).filter(|(month, day)| exposure_to_sunlight(0.0, (*month, *day)).is_ok());
            section.sunlight_date = date.ok_or_else(|| {
                table
                    .error("sunlight_date", format!("'{text}' is no day between 1 February and 21 March"))
                    .help("EN 17037 judges the sun on a day of these weeks: sunlight_date = \"03-21\"")
            })?;
        }
        section.sunlight_altitude = table.number("sunlight_altitude", 0.0..=60.0)?.unwrap_or(section.sunlight_altitude);
        table.finish()?;
        Ok(section)
    }
}

/// `03-21`: month and day.
fn day(text: &str) -> Option<(u8, u8)> {
    Time::parse(&format!("{text}T00:00")).map(|t| (t.month, t.day)).ok()
}

fn clock(table: &mut Table<'_, '_>) -> Result<Clock> {
    const HELP: &str = "write the first day of summer time and the first day without it, as [\"03-29\", \"10-25\"]";
    let Some(days) = table.strings("daylight_saving", "[\"03-29\", \"10-25\"]")? else { return Ok(Clock::Standard) };
    match days.iter().map(|text| day(text)).collect::<Option<Vec<_>>>().as_deref() {
        Some(&[from, until]) if from != until => Ok(Clock::Saving { from, until }),
        _ => Err(table.error("daylight_saving", "summer time needs two days").help(HELP)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::Project;

    fn section(keys: &[(&str, toml::Value)]) -> Result<MetricsSection> {
        let furnace = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/analytic/furnace");
        let room = Project::builder(furnace)
            .weather("../../office/weather/new_york.wea")
            .scene(&["room.rad"])
            .window("south", "window.rad", "../../bsdf/clear.xml")
            .sensors("desk", "points.txt")
            .begin("metrics");
        Ok(keys.iter().fold(room, |room, (key, value)| room.set("metrics", key, value)).build()?.metrics)
    }

    #[test]
    fn keys_are_read_and_slips_are_answered() {
        let text = |t: &str| toml::Value::from(t);
        let list = |t: &[&str]| toml::Value::from(t.to_vec());
        assert_eq!(section(&[]).unwrap(), MetricsSection::default());
        let read = section(&[
            ("occupancy", text("points.txt")),
            ("metrics", list(&["leed", "lm-83"])),
            ("autonomy", 500.into()),
            ("daylight_saving", list(&["10-04", "04-05"])),
            ("openings", text("roof")),
            ("sunlight_date", text("02-10")),
            ("sunlight_altitude", 11.into()),
        ])
        .unwrap();
        assert!(matches!(&read.occupancy, OccupancyChoice::File(f) if f.ends_with("points.txt")));
        assert_eq!((read.families.clone(), read.autonomy, read.openings), (vec![Family::Leed, Family::Lm83], 500.0, Openings::Roof));
        assert_eq!((read.sunlight_date, read.sunlight_altitude), ((2, 10), 11.0));
        assert!(read.wants(Family::Leed) && !read.wants(Family::En17037));
        assert_eq!(read.clock, Clock::Saving { from: (10, 4), until: (4, 5) });
        for (key, value, words) in [
            ("occupancy", text("office"), "'office' is not known"),
            ("occupancy", text("no.csv"), "there is no file"),
            ("metrics", list(&["sda"]), "'sda' is not known"),
            ("useful", toml::Value::from(vec![100, 3000, 300]), "three rising numbers"),
            ("daylight_saving", list(&["03-32", "10-25"]), "two days"),
            ("openings", text("skylight"), "choose"),
            ("sunlight_date", text("06-21"), "between 1 February and 21 March"),
            ("sunlight_altitude", 90.into(), "60"),
            ("autonom", 300.into(), "did you mean 'autonomy'?"),
        ] {
            let error = section(&[(key, value)]).unwrap_err().to_string();
            assert!(
                error.contains(words) && error.contains(&format!("metrics.{}", if key == "autonom" { "" } else { key }))
                    || error.contains("did you mean"),
                "{error}"
            );
        }
    }
}

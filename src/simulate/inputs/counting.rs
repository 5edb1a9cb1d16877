//! What metrics count: which hours, and which numbers of each sensor's year.

use crate::error::{Error, Result};
use crate::metrics::en17037::LEVELS_LX;
use crate::metrics::{Counted, Occupancy, Year, glare, lm83};
use crate::simulate::project::metrics::{Family, MetricsSection, OccupancyChoice};
use crate::sky::{cie, diffuse_illuminance};
use crate::weather::{CieSky, Weather};

/// Hours and columns of a project's metrics.
#[derive(Debug, Clone)]
pub struct Counting {
    /// `[metrics]`.
    pub section: MetricsSection,
    /// The time steps.
    pub year: Year,
    /// Diffuse horizontal illuminance outdoors by step, lx; empty where it is not known: of a sky made elsewhere.
    pub diffuse: Vec<f64>,
    /// All hours.
    pub all: Occupancy,
    /// Those of DA, cDA, UDI and vertical illuminance.
    pub occupied: Occupancy,
    /// LM-83's.
    pub lm83: Occupancy,
    /// EN 17037's; nothing of weather that is not one whole year.
    pub daylight: Option<Occupancy>,
    /// 9:00 and 15:00 of clear days at the equinoxes, for LEED's option 2; nothing where there is none.
    pub equinox: Option<[Occupancy; 2]>,
    /// Whether the weather is moments under a sky of the CIE, not a year.
    pub are_moments: bool,
    /// Numbers of each sensor.
    pub columns: Vec<Column>,
}

/// One number of each sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in tables.
    pub name: String,
    /// What is counted.
    pub counted: Counted,
    /// When.
    pub time: Time,
    /// Whether classes or points depend on it.
    pub is_judged: bool,
}

/// When a column counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Time {
    /// In all hours.
    All,
    /// In [`Counting::occupied`].
    Occupied,
    /// In LM-83's hours.
    Lm83,
    /// In EN 17037's.
    Daylight,
    /// At 9:00 of clear days at the equinoxes.
    Morning,
    /// At 15:00 of them.
    Afternoon,
    /// Under the overcast sky of the CIE, as a share of the illuminance outdoors.
    Overcast,
}

/// Name of the mean over all hours.
pub const MEAN: &str = "mean_lx";
/// Name of the annual light exposure.
pub const EXPOSURE: &str = "exposure_klxh";
/// Name of the daylight factor.
pub const FACTOR: &str = "daylight_factor";
/// Name of LM-83's autonomy.
pub const LM83: &str = "lm83_autonomy_300_lx";
/// Names of the illuminances of LEED's option 2.
pub const LEED: [&str; 2] = ["equinox_9_00_lx", "equinox_15_00_lx"];

/// Name of EN 17037's share of the daylight hours with so many lx.
pub fn daylight_share(lux: f64) -> String {
    format!("en17037_{lux}_lx")
}

/// Limits of vertical illuminance, lx: where the simplified DGPs is 0.35, 0.40 and 0.45.
pub fn vertical_limits() -> [f64; 3] {
    crate::glare::CLASS_LIMITS.map(|limit| glare::vertical_lux(limit).round())
}

/// Name of the share of the occupied hours with more vertical illuminance than this.
pub fn vertical_share(lux: f64) -> String {
    format!("above_{lux}_lx")
}

impl Counting {
    /// Of a project's weather; `vertical`: whether there are sensors that do not face up.
    ///
    /// # Errors
    /// A schedule that cannot be read or does not fit the year; EN 17037's hours of weather that is not one whole year.
    pub fn new(section: &MetricsSection, weather: &Weather, vertical: bool) -> Result<Self> {
        let (year, are_moments) = (Year::of(weather), !weather.skies.is_empty());
        // The records beside a sky made elsewhere tell the times alone.
        let (diffuse, equinox) = match (&weather.given, are_moments) {
            (Some(_), _) => (Vec::new(), None),
            (None, true) => (diffuse_illuminance(weather)?, moments(weather)),
            (None, false) => (diffuse_illuminance(weather)?, clear_days(weather, &year)),
        };
        let mut counting = Self::of_steps(section, year, diffuse, equinox, vertical)?;
        counting.are_moments = are_moments;
        counting.columns = counting.numbers(vertical);
        Ok(counting)
    }

    /// Of time steps, the diffuse illuminance outdoors in each, lx, and the steps of LEED's option 2.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_steps(
        section: &MetricsSection,
        year: Year,
        diffuse: Vec<f64>,
        equinox: Option<[Occupancy; 2]>,
        vertical: bool,
    ) -> Result<Self> {
        let lm83 = Occupancy::lm83(&year, section.clock);
        let daylight = match diffuse.is_empty() {
            true => {
                Err(Error::new("EN 17037's daylight hours need the diffuse illuminance outdoors, which a sky made elsewhere does not tell")
                    .help("choose another occupancy"))
            }
            false => Occupancy::en17037(&year, &diffuse),
        };
        let occupied = match &section.occupancy {
            OccupancyChoice::Lm83 => lm83.clone(),
            OccupancyChoice::En17037 => daylight.clone().map_err(|e| e.field("metrics.occupancy"))?,
            OccupancyChoice::File(file) => Occupancy::read(file, &year).map_err(|e| e.field("metrics.occupancy"))?,
        };
        let all = Occupancy::always(&year);
        let section = section.clone();
        let daylight = daylight.ok();
        let mut counting = Self { section, year, diffuse, all, occupied, lm83, daylight, equinox, are_moments: false, columns: Vec::new() };
        counting.columns = counting.numbers(vertical);
        Ok(counting)
    }

    /// The columns, in the order of the tables.
    fn numbers(&self, vertical: bool) -> Vec<Column> {
        let section = &self.section;
        let column = |name: &str, counted: Counted, time: Time| {
            let is_judged = matches!(time, Time::Lm83 | Time::Daylight | Time::Morning | Time::Afternoon | Time::Overcast);
            Column { name: name.into(), counted, time, is_judged }
        };
        let mut columns = vec![column(MEAN, Counted::Mean, Time::All)];
        let year = !self.are_moments;
        if year && section.wants(Family::Autonomy) {
            let (da, [low, enough, high]) = (section.autonomy, section.useful);
            columns.extend([
                column(&format!("autonomy_{da}_lx"), Counted::AtLeast(da), Time::Occupied),
                column(&format!("continuous_autonomy_{da}_lx"), Counted::Continuous(da), Time::Occupied),
                column(&format!("udi_below_{low}_lx"), Counted::Below(low), Time::Occupied),
                column(&format!("udi_{low}_{enough}_lx"), Counted::From(low, enough), Time::Occupied),
                column(&format!("udi_{enough}_{high}_lx"), Counted::Between(enough, high), Time::Occupied),
                column(&format!("useful_{low}_{high}_lx"), Counted::Between(low, high), Time::Occupied),
                column(&format!("udi_above_{high}_lx"), Counted::Above(high), Time::Occupied),
            ]);
        }
        if year && section.wants(Family::Exposure) {
            columns.push(column(EXPOSURE, Counted::Exposure, Time::All));
        }
        if year && vertical && section.wants(Family::Vertical) {
            columns.extend(vertical_limits().map(|lux| column(&vertical_share(lux), Counted::Above(lux), Time::Occupied)));
        }
        if year && (section.wants(Family::Lm83) || section.wants(Family::Leed)) {
            columns.push(column(LM83, Counted::AtLeast(lm83::SDA_LX), Time::Lm83));
        }
        if self.daylight.is_some() && section.wants(Family::En17037) {
            columns.extend(LEVELS_LX.map(|lux| column(&daylight_share(lux), Counted::AtLeast(lux), Time::Daylight)));
        }
        if self.equinox.is_some() && section.wants(Family::Leed) {
            let times = [Time::Morning, Time::Afternoon];
            columns.extend(LEED.into_iter().zip(times).map(|(name, time)| column(name, Counted::Mean, time)));
        }
        if section.wants(Family::DaylightFactor) || section.wants(Family::En17037) {
            columns.push(column(FACTOR, Counted::Mean, Time::Overcast));
        }
        columns
    }

    /// The mean alone, of irradiance.
    #[must_use]
    pub fn of_irradiance(mut self) -> Self {
        self.columns.truncate(1);
        self
    }

    /// The hours of a column.
    fn hours(&self, time: Time) -> &Occupancy {
        match (time, &self.daylight, &self.equinox) {
            (Time::Occupied, ..) => &self.occupied,
            (Time::Lm83, ..) => &self.lm83,
            (Time::Daylight, Some(daylight), _) => daylight,
            (Time::Morning, _, Some([morning, _])) => morning,
            (Time::Afternoon, _, Some([_, afternoon])) => afternoon,
            _ => &self.all,
        }
    }

    /// The number of a column for a sensor: its illuminances by step, and that under the overcast sky, lx.
    pub fn number(&self, column: &Column, row: &[f64], overcast: f64) -> f64 {
        match column.time {
            Time::Overcast => overcast / cie::OUTDOORS,
            time => column.counted.of(row, self.hours(time)),
        }
    }

    /// Place of a column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.name == name)
    }

    /// The median of the diffuse illuminance outdoors over EN 17037's daylight hours, lx.
    pub fn median_diffuse(&self) -> Option<f64> {
        self.section.median_diffuse.or_else(|| Some(self.daylight.as_ref()?.median(&self.diffuse)))
    }
}

/// Hours of the day that LEED asks for.
const HOURS: [f64; 2] = [9.0, 15.0];
/// Days of a common year: 21 March and 21 September.
const EQUINOXES: [u16; 2] = [80, 264];
/// Days on either side.
const DAYS: u16 = 15;

/// Steps of moments under the CIE's clear sky.
fn moments(weather: &Weather) -> Option<[Occupancy; 2]> {
    let near = |day: u16| EQUINOXES.iter().any(|e| day.abs_diff(*e) <= DAYS);
    let at = |hour: f64| -> Occupancy {
        let is = |(i, r): (usize, &crate::weather::Record)| {
            (weather.skies[i] == CieSky::Clear && near(r.day_of_year) && (r.hour - hour).abs() < 1e-6).then_some(i)
        };
        let steps: Vec<usize> = weather.records.iter().enumerate().filter_map(is).collect();
        Occupancy { name: "the CIE's clear sky at the equinox".into(), hours: steps.len() as f64, steps }
    };
    let both = HOURS.map(at);
    both.iter().all(|o| !o.steps.is_empty()).then_some(both)
}

/// Steps of a year: of the day with most direct sun at both hours within 15 days of each equinox. Steps that meet at the
/// hour stand for it together.
fn clear_days(weather: &Weather, year: &Year) -> Option<[Occupancy; 2]> {
    if !year.is_whole() {
        return None;
    }
    let around = |hour: f64, begins: f64| (begins - hour).abs() < 1e-6 || (begins + year.length - hour).abs() < 1e-6;
    let steps_of = |day: u16, hour: f64| -> Vec<usize> {
        let is = |i: &usize| weather.records[*i].day_of_year == day && around(hour, year.steps[*i].begins);
        (0..year.steps.len()).filter(is).collect()
    };
    let mut both = HOURS.map(|_| Vec::new());
    for equinox in EQUINOXES {
        let sun = |day: &u16| -> f64 { HOURS.iter().flat_map(|h| steps_of(*day, *h)).map(|s| weather.records[s].direct).sum() };
        let day = (equinox - DAYS..=equinox + DAYS).max_by(|a, b| sun(a).total_cmp(&sun(b)))?;
        if sun(&day) <= 0.0 {
            return None;
        }
        both.iter_mut().zip(HOURS).for_each(|(steps, hour)| steps.extend(steps_of(day, hour)));
    }
    Some(both.map(|steps| Occupancy { name: "the clearest days at the equinoxes".into(), hours: year.hours(steps.len()), steps }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Warnings;
    use std::path::Path;

    fn new_york() -> Weather {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office/weather/new_york.wea");
        Weather::read(&file, &mut Warnings::new()).unwrap()
    }

    #[test]
    fn a_year_has_its_hours_and_columns() {
        let weather = new_york();
        let counting = Counting::new(&MetricsSection::default(), &weather, false).unwrap();
        assert_eq!((counting.lm83.hours, counting.daylight.as_ref().unwrap().hours), (3650.0, 4380.0));
        let median = counting.median_diffuse().unwrap();
        // EN 17037, table A.3, has 14,000 to 20,000 lx for capitals between 38° and 48° north.
        assert!((12_000.0..24_000.0).contains(&median), "{median}");
        let [morning, afternoon] = counting.equinox.as_ref().unwrap();
        assert_eq!((morning.steps.len(), afternoon.steps.len()), (4, 4), "two days, two steps that meet at the hour");
        let begins = |o: &Occupancy| o.steps.iter().map(|s| counting.year.steps[*s].begins).collect::<Vec<_>>();
        assert_eq!((begins(morning), begins(afternoon)), (vec![8.0, 9.0, 8.0, 9.0], vec![14.0, 15.0, 14.0, 15.0]));
        for step in &morning.steps {
            assert!(weather.records[*step].direct > 300.0, "a clear day");
            let s = counting.year.steps[*step];
            assert!([3, 4, 9, 10].contains(&s.month), "{s:?}");
        }
        let names: Vec<&str> = counting.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names[0], "mean_lx");
        for name in ["autonomy_300_lx", "udi_100_300_lx", "useful_100_3000_lx", "lm83_autonomy_300_lx", "en17037_750_lx", "daylight_factor"]
        {
            assert!(names.contains(&name), "{names:?}");
        }
        // Less is counted where less is wanted, or the year is not whole.
        let few = MetricsSection { families: vec![Family::Lm83], ..MetricsSection::default() };
        assert_eq!(Counting::new(&few, &weather, true).unwrap().columns.len(), 2);
        let day = Weather { records: weather.records[79 * 24..80 * 24].to_vec(), ..weather };
        let counting = Counting::new(&MetricsSection::default(), &day, true).unwrap();
        assert!(counting.daylight.is_none() && counting.equinox.is_none() && counting.column("en17037_300_lx").is_none());
        assert!(counting.column("above_2669_lx").is_some());
        let daylight = MetricsSection { occupancy: OccupancyChoice::En17037, ..MetricsSection::default() };
        let error = Counting::new(&daylight, &day, true).unwrap_err().to_string();
        assert!(error.contains("metrics.occupancy") && error.contains("24 h"), "{error}");
    }

    #[test]
    fn moments_of_a_clear_sky_are_those_of_option_2() {
        let time = |month, day, hour| crate::weather::time::Time { month, day, hour };
        let times = [time(3, 21, 9.0), time(3, 21, 12.0), time(3, 21, 15.0)].map(|t| (CieSky::Clear, t));
        let weather = cie::weather(&times, Some([46.5, 11.35, 15.0]), &mut Warnings::new()).unwrap();
        let counting = Counting::new(&MetricsSection::default(), &weather, false).unwrap();
        let [morning, afternoon] = counting.equinox.as_ref().unwrap();
        assert_eq!((morning.steps.clone(), afternoon.steps.clone()), (vec![0], vec![2]));
        assert!(counting.column("autonomy_300_lx").is_none(), "moments are no year");
        let june = cie::weather(
            &[time(6, 21, 9.0), time(6, 21, 15.0)].map(|t| (CieSky::Clear, t)),
            Some([46.5, 11.35, 15.0]),
            &mut Warnings::new(),
        );
        assert!(Counting::new(&MetricsSection::default(), &june.unwrap(), false).unwrap().equinox.is_none());
    }
}

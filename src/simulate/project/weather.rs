//! `[weather]` and `[[moment]]`: the time steps, and the sky and sun of each.
//!
//! | keys | steps | sky and sun |
//! |---|---|---|
//! | `file` | the file's | Perez' sky of its radiation, the real sun |
//! | `sky`, `date`, `site`; or `[[moment]]` with its own | the dates | one of the CIE's, the sun of the site |
//! | `sky_matrix` and its companions | `file`'s or `date`'s, or a common year's | the matrices' columns |
//!
//! Of all of them `timestep` divides or joins steps, `period` and `hours` leave some out, in this order. A step that is
//! left out changes nothing of the others.

use super::names::name;
use super::table::{Place, Table};
use crate::error::{Error, Result, Warnings};
use crate::sky::cie::{self, CieSky};
use crate::sky::given::{self, Files, NoSun};
use crate::weather::chosen::{Day, read_schedule};
use crate::weather::time::Time;
use crate::weather::{Quantity, Record, Weather};
use std::path::PathBuf;

/// `[weather]`: where the hours come from.
#[derive(Debug, Clone, PartialEq)]
pub struct WeatherSection {
    /// Weather file, WEA or EPW; the project file where there is a sky in its place.
    pub file: PathBuf,
    /// `sky`, `date`, `site`, or `[[moment]]`: moments under a CIE sky in place of the file.
    pub moments: Option<Moments>,
    /// `sky_matrix`: a sky made elsewhere.
    pub given: Option<GivenFiles>,
    /// `timestep`: length of a step, minutes.
    pub timestep: Option<u32>,
    /// `period`: first and last day.
    pub period: Option<[Day; 2]>,
    /// `hours`: those of the year that count.
    pub hours: Option<ChosenHours>,
    /// Where north lies in the scene: so many degrees from +Y, counter-clockwise seen from above.
    pub north: f64,
    /// Reflectance of the ground outside, beyond what the scene has of it.
    pub ground_albedo: f64,
    /// Where the choice of steps stands.
    places: Places,
}

#[derive(Debug, Clone, PartialEq)]
struct Places {
    timestep: Place,
    period: Place,
    hours: Place,
    sky_matrix: Place,
}

/// Moments under the CIE's skies.
#[derive(Debug, Clone, PartialEq)]
pub struct Moments {
    /// Sky and time of each; without a time, noon of 21 March.
    pub skies: Vec<(CieSky, Time)>,
    /// Names of `[[moment]]`; empty for `date`.
    pub names: Vec<String>,
    /// Latitude, longitude and standard meridian, degrees north and east. Without it an overcast or uniform sky
    /// gives [`OUTDOORS`](crate::sky::cie::OUTDOORS) lx outdoors.
    pub site: Option<[f64; 3]>,
}

/// Matrices of a sky made elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenFiles {
    /// S.
    pub whole: PathBuf,
    /// Sds; `Err` for `"none"`.
    pub direct: Option<std::result::Result<PathBuf, NoSun>>,
    /// The suns of `gendaymtx -5 0.533 -d`.
    pub suns: Option<PathBuf>,
    /// Times of the columns; without them and without a weather file, a common year's.
    pub times: Vec<Time>,
    /// Whether a weather file tells the times.
    pub has_file: bool,
}

/// The hours of the year that count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ChosenHours {
    /// By number from 0.
    Listed(Vec<usize>),
    /// Those above 0 in a schedule.
    Schedule(PathBuf),
}

/// Reflectance of the ground that gendaymtx assumes.
const GROUND_ALBEDO: f64 = 0.2;

/// Lengths of steps, minutes.
const STEPS: [u64; 12] = [1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60];

impl WeatherSection {
    /// Whether it tells where the sun stands.
    pub(crate) fn has_site(&self) -> bool {
        self.given.is_none() && self.moments.as_ref().is_none_or(|m| m.site.is_some())
    }

    /// The weather: what the file holds, or the moments, with the steps that count.
    ///
    /// # Errors
    /// What is wrong in the file, moments at night, steps and hours that it does not have.
    pub fn load(&self, warnings: &mut Warnings) -> Result<Weather> {
        let mut weather = match (&self.moments, &self.given) {
            (Some(m), _) => {
                let weather = cie::weather(&m.skies, m.site, warnings).map_err(|e| e.file(&self.file).field("weather.date"));
                Weather { names: m.names.clone(), ..weather? }
            }
            (None, Some(given)) => self.under_given_sky(given, warnings)?,
            (None, None) => Weather::read(&self.file, warnings)?,
        };
        weather.north = self.north;
        if let Some(minutes) = self.timestep {
            weather = weather.with_step(minutes, warnings).map_err(|e| self.places.timestep.of(e))?;
        }
        if let Some(period) = self.period {
            weather.keep_period(period).map_err(|e| self.places.period.of(e))?;
        }
        match &self.hours {
            None => {}
            Some(ChosenHours::Listed(hours)) => weather.keep_hours(hours).map_err(|e| self.places.hours.of(e))?,
            Some(ChosenHours::Schedule(file)) => {
                let values = read_schedule(&crate::text::read(file, "a schedule")?).map_err(|e| e.file(file))?;
                weather.keep_scheduled(&values).map_err(|e| self.places.hours.of(e))?;
            }
        }
        Ok(weather)
    }

    /// The steps and what makes their light, in a line for people.
    pub fn describe(&self, weather: &Weather) -> String {
        let steps = weather.steps();
        let minutes = (60.0 * steps.length).round();
        let source = match (&self.moments, &self.given) {
            (Some(m), _) if m.names.is_empty() => "moments under a sky of the CIE".to_string(),
            (Some(m), _) => {
                let of = |(name, (sky, time)): (&String, &(CieSky, Time))| format!("{name} (cie {}, {time})", sky.name());
                format!("moments {}", m.names.iter().zip(&m.skies).map(of).collect::<Vec<_>>().join(", "))
            }
            (None, Some(given)) => format!("sky made elsewhere, {}", given.whole.display()),
            (None, None) => self.file.display().to_string(),
        };
        let mut text = format!("weather: {source}; {} time steps", steps.len());
        if self.moments.is_none() {
            text += &format!(" of {minutes} min");
        }
        if self.timestep.is_some() {
            text += " (divided or joined, as 'timestep' says)";
        }
        if let Some([first, last]) = self.period {
            text += &format!(", those from {first} to {last}");
        }
        match &self.hours {
            None => {}
            Some(ChosenHours::Listed(_)) => text += ", of the hours that 'hours' lists",
            Some(ChosenHours::Schedule(file)) => text += &format!(", of the hours that {} counts", file.display()),
        }
        text
    }

    fn under_given_sky(&self, given: &GivenFiles, warnings: &mut Warnings) -> Result<Weather> {
        let direct = given.direct.as_ref().map(|d| d.as_ref().map(PathBuf::as_path).map_err(|none| *none));
        let sky = given::read(Files { whole: &given.whole, direct, suns: given.suns.as_deref() }, warnings)?;
        let columns = sky.whole.cols();
        let mut weather = if given.has_file {
            Weather::read(&self.file, warnings)?
        } else {
            let times = if given.times.is_empty() { Time::common_year(columns) } else { given.times.clone() };
            Weather { records: times.iter().map(record_at).collect(), ..Weather::nowhere(Quantity::Illuminance) }
        };
        let fault = |text: String, help: &str| Err(self.places.sky_matrix.of(Error::new(text)).help(help));
        if !given.has_file && given.times.is_empty() && !columns.is_multiple_of(8760) {
            let text = format!("the sky has {columns} columns, and nothing tells their times");
            return fault(
                text,
                "give a weather 'file' whose steps they are, or a list 'date'; only 8760 columns, or a multiple, are a year",
            );
        }
        if weather.records.len() != columns {
            let text = format!("the sky has {columns} columns, but there are {} time steps", weather.records.len());
            return fault(text, "give the weather 'file' or the list 'date' of the steps that the sky was made for");
        }
        // The file told the times; the light is the matrices'.
        weather.quantity = Quantity::Illuminance;
        for (record, light) in weather.records.iter_mut().zip(given::outdoors(&sky)) {
            [record.direct, record.diffuse] = light;
        }
        weather.given = Some(sky);
        Ok(weather)
    }

    /// The section, and the sections of moments.
    pub(super) fn read(mut table: Table<'_, '_>, moments: Vec<Table<'_, '_>>) -> Result<Self> {
        let names = CieSky::ALL.map(|(name, kind)| (format!("cie {name}"), kind));
        let names = names.each_ref().map(|(name, kind)| (name.as_str(), *kind));
        let sky = table.choice("sky", &names)?;
        let dates = table.texts("date", "[\"03-21T09:00\", \"03-21T12:00\"]")?.unwrap_or_default();
        let site = table.numbers("site", -210.0..=210.0)?;
        let file = table.path("file")?;
        let matrix = table.path("sky_matrix")?;
        let direct = table.path_or_word("sky_matrix_direct", "none")?;
        let suns = table.path("sun_matrix")?;
        let mut section = Self {
            file: table.place("sky").file,
            moments: None,
            given: None,
            timestep: timestep(&mut table)?,
            period: period(&mut table)?,
            hours: hours(&mut table)?,
            north: table.number("north", -360.0..=360.0)?.unwrap_or(0.0),
            ground_albedo: table.number("ground_albedo", 0.0..=1.0)?.unwrap_or(GROUND_ALBEDO),
            places: Places {
                timestep: table.place("timestep"),
                period: table.place("period"),
                hours: table.place("hours"),
                sky_matrix: table.place("sky_matrix"),
            },
        };
        let given = |key: &'static str| table.has(key);
        let refuse = |keys: &[&'static str], why: &str, help: &str| match keys.iter().find(|key| given(key)) {
            Some(key) => Err(table.error(key, format!("'{key}' {why}")).help(help)),
            None => Ok(()),
        };
        let mut times = Vec::new();
        for date in &dates {
            times.push(Time::parse(date).map_err(|e| table.place("date").of(e))?);
        }
        if !moments.is_empty() {
            refuse(
                &["file", "sky", "date", "sky_matrix", "sky_matrix_direct", "sun_matrix", "timestep", "period", "hours"],
                "is not for [[moment]], each of which names its own sky and date",
                "take it out, or take the moments out",
            )?;
            let site = self::site(&table, site.as_deref())?;
            let (mut skies, mut all) = (Vec::new(), Vec::new());
            for moment in moments {
                let (name, sky) = self::moment(moment, &names, site.is_some())?;
                if all.contains(&name) {
                    return Err(table.error("moment", format!("two sections [[moment]] have the name '{name}'")).help("give each its own"));
                }
                all.push(name);
                skies.push(sky);
            }
            section.moments = Some(Moments { skies, names: all, site });
        } else if let Some(whole) = matrix {
            refuse(&["sky"], "is one of the CIE's, but 'sky_matrix' gives another", "take one of the two out")?;
            refuse(&["site"], "tells where the sun stands, which 'sun_matrix' does here", "take it out")?;
            refuse(
                &["north"],
                "turns skies that are made here; a matrix is turned already",
                "make the matrix with gendaymtx -r, and take it out",
            )?;
            refuse(&["ground_albedo"], "is that of skies made here; the first row of the matrix is its ground", "take it out")?;
            refuse(
                &["timestep"],
                "divides steps of a weather file; a matrix has its columns",
                "make the matrix in other steps, and take it out",
            )?;
            if file.is_some() && !times.is_empty() {
                return Err(table
                    .error("date", "the times of the columns come either from 'file' or from 'date'")
                    .help("take one of the two out"));
            }
            section.given = Some(GivenFiles { whole, direct, suns, times, has_file: file.is_some() });
            section.file = file.unwrap_or(section.file);
        } else {
            refuse(
                &["sky_matrix_direct", "sun_matrix"],
                "belongs to a 'sky_matrix', which is not given",
                "add sky_matrix = \"S.mtx\", or take it out",
            )?;
            match (sky, file) {
                (None, None) => {
                    let help =
                        "add file = \"….wea\" or \"….epw\", or a sky in its place: sky = \"cie overcast\", or sky_matrix = \"S.mtx\"";
                    return Err(table.missing_all(&["file", "sky", "sky_matrix"], "has no 'file'", help));
                }
                (Some(_), Some(_)) => {
                    return Err(table
                        .error("sky", "the sky comes either from a weather 'file' or is a 'sky' of the CIE")
                        .help("take one of the two out"));
                }
                (None, Some(file)) => {
                    let help = "add sky = \"cie clear\" or the like in place of 'file', or take this out";
                    refuse(&["date", "site"], "belongs to a 'sky', but the weather comes from a file", help)?;
                    section.file = file;
                }
                (Some(sky), None) => {
                    refuse(
                        &["timestep", "period", "hours"],
                        "chooses steps of a weather file, but 'date' lists the moments",
                        "take it out",
                    )?;
                    let site = self::site(&table, site.as_deref())?;
                    if site.is_none() && (sky.shows_sun() || !times.is_empty()) || site.is_some() && times.is_empty() {
                        return Err(table.error("sky", "a moment needs both its date and its site").help(
                            "add date = \"03-21T12:00\" and site = [46.5, 11.35, 15]; an overcast or uniform sky without both gives \
                             10,000 lx outdoors",
                        ));
                    }
                    if times.is_empty() {
                        times.push(EQUINOX);
                    }
                    section.moments = Some(Moments { skies: times.iter().map(|t| (sky, *t)).collect(), names: Vec::new(), site });
                }
            }
        }
        table.finish()?;
        Ok(section)
    }
}

/// The time of a sky that has none.
const EQUINOX: Time = Time { month: 3, day: 21, hour: 12.0 };

fn record_at(time: &Time) -> Record {
    Record {
        month: time.month,
        day: time.day,
        hour: time.hour,
        day_of_year: time.day_of_year(),
        direct: 0.0,
        diffuse: 0.0,
        dew_point: None,
        line: 0,
    }
}

/// One `[[moment]]`: its name, sky and time.
fn moment(mut table: Table<'_, '_>, skies: &[(&str, CieSky)], has_site: bool) -> Result<(String, (CieSky, Time))> {
    let name = name(&mut table, "add name = \"equinox noon\" or the like")?;
    let Some(sky) = table.choice("sky", skies)? else {
        return Err(table.missing_all(
            &["sky"],
            "has no 'sky'",
            "add sky = \"cie clear\", \"cie intermediate\", \"cie overcast\" or \"cie uniform\"",
        ));
    };
    let date = table.string("date")?.map(|text| Time::parse(&text).map_err(|e| table.place("date").of(e))).transpose()?;
    let needs = |what: &str| {
        table.error("date", format!("the moment '{name}' needs {what}")).help(
            "write date = \"03-21T12:00\" here and site = [46.5, 11.35, 15] in [weather]; overcast and uniform skies without both give \
             10,000 lx outdoors",
        )
    };
    let time = match (date, has_site) {
        (Some(time), true) => time,
        (None, true) => return Err(needs("its date")),
        (Some(_), false) => return Err(needs("a site")),
        (None, false) if sky.shows_sun() => return Err(needs("its date and a site")),
        (None, false) => EQUINOX,
    };
    table.finish()?;
    Ok((name, (sky, time)))
}

fn site(table: &Table<'_, '_>, numbers: Option<&[f64]>) -> Result<Option<[f64; 3]>> {
    match numbers {
        None => Ok(None),
        Some(&[latitude, longitude, meridian]) if latitude.abs() <= 90.0 && longitude.abs() <= 180.0 => {
            Ok(Some([latitude, longitude, meridian]))
        }
        Some(_) => Err(table
            .error("site", "this is no site")
            .help("write latitude, longitude and standard meridian in degrees north and east, as [46.5, 11.35, 15]")),
    }
}

fn timestep(table: &mut Table<'_, '_>) -> Result<Option<u32>> {
    let Some(minutes) = table.integer("timestep", 1..=60)? else { return Ok(None) };
    if !STEPS.contains(&minutes) {
        let all = STEPS.map(|s| s.to_string()).join(", ");
        return Err(table.error("timestep", format!("{minutes} minutes do not divide an hour")).help(format!("choose one of {all}")));
    }
    Ok(Some(minutes as u32))
}

fn period(table: &mut Table<'_, '_>) -> Result<Option<[Day; 2]>> {
    let Some(days) = table.texts("period", "[\"03-01\", \"05-31\"]")? else { return Ok(None) };
    let day = |text: &String| Day::parse(text).map_err(|e| table.place("period").of(e));
    match &days[..] {
        [only] => day(only).map(|d| Some([d, d])),
        [first, last] => Ok(Some([day(first)?, day(last)?])),
        _ => Err(table.error("period", "a period is a day, or its first and last day").help("write period = [\"03-01\", \"05-31\"]")),
    }
}

fn hours(table: &mut Table<'_, '_>) -> Result<Option<ChosenHours>> {
    Ok(match table.integers_or_path("hours", 0..=8783)? {
        None => None,
        Some(Ok(hours)) if hours.is_empty() => {
            return Err(table.error("hours", "this list is empty").help("write hours of the year from 0, or the name of a schedule"));
        }
        Some(Ok(hours)) => Some(ChosenHours::Listed(hours.into_iter().map(|h| h as usize).collect())),
        Some(Err(file)) => Some(ChosenHours::Schedule(file)),
    })
}

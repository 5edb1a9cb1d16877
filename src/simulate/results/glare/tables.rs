//! Files of annual glare: one table and carpet per view, a table of all views, and a matrix.

use super::carpet::carpet;
use crate::error::{Error, Result, Warnings};
use crate::files::write_atomically;
use crate::glare::annual::{AnnualGlare, GlareClass};
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::simulate::project::glare::GlareSection;
use crate::simulate::store::{Store, write_stored};
use crate::weather::{Days, Record, Steps};
use std::path::{Path, PathBuf};

/// Pixels per unit of a carpet.
const CARPET_SCALE: f64 = 2.0;

/// Glare of one hour, as the tables have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hour {
    /// DGP (or DGPs, eDGPs).
    pub dgp: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Vertical illuminance, lx.
    pub illuminance: f64,
    /// Number of sources.
    pub sources: usize,
}

impl Hour {
    /// The other class that the noise leaves possible, if there is one: within `confidence_95` standard
    /// errors to either side.
    fn other_class(&self, confidence_95: f64) -> Option<GlareClass> {
        let class = GlareClass::of(self.dgp);
        [-1.0, 1.0].into_iter().map(|side| GlareClass::of(self.dgp + side * confidence_95 * self.standard_error)).find(|&c| c != class)
    }
}

/// All time steps of a view in one state of the façade.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ViewYear {
    /// Name of the view.
    pub view: String,
    /// Name of the state; empty if there is only one.
    pub state: String,
    /// One per step of the weather file.
    pub hours: Vec<Hour>,
    /// Whether there is light in it.
    pub is_lit: Vec<bool>,
}

impl ViewYear {
    /// DGP of all steps, each moved by so many of its standard errors.
    pub fn dgp(&self, by: f64) -> Vec<f64> {
        self.hours.iter().map(|h| (h.dgp + if by == 0.0 { 0.0 } else { by * h.standard_error }).clamp(0.0, 1.0)).collect()
    }
}

/// The steps of the year that results belong to.
pub(super) struct Calendar<'a> {
    /// Times of day.
    pub records: &'a [Record],
    /// Their lengths and places in the year.
    pub steps: Steps,
    /// The factor of Student's distribution for 95 % confidence.
    pub confidence_95: f64,
}

/// Writes everything into `glare/`; results of states into a folder for each.
pub(super) fn write(
    store: &Store,
    section: &GlareSection,
    calendar: &Calendar<'_>,
    years: &[ViewYear],
    progress: &dyn Progress,
    warnings: &mut Warnings,
) -> Result<()> {
    let (records, steps) = (calendar.records, &calendar.steps);
    let occupied: Vec<bool> = records.iter().map(|r| (section.occupied[0]..section.occupied[1]).contains(&r.hour)).collect();
    let days = steps.days();
    if days.is_none() {
        warnings.push(Error::new("the weather file has a time twice, or steps that do not divide a day: no carpet plots are drawn"));
    }
    let mut folders: Vec<(&str, PathBuf)> = Vec::new();
    for (i, year) in years.iter().enumerate() {
        progress.update("writing glare", i as f64 / years.len() as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let folder = store.glare_folder(&year.state)?;
        write_hours(&folder.join(format!("{}.csv", year.view)), year, steps)?;
        if let Some(days) = &days {
            draw(&folder, year, section, days)?;
        }
        if !folders.iter().any(|(state, _)| *state == year.state) {
            folders.push((&year.state, folder));
        }
    }
    for (state, folder) in &folders {
        let rows: Vec<&ViewYear> = years.iter().filter(|y| y.state == *state).collect();
        let values = rows.iter().flat_map(|y| y.hours.iter().map(|h| h.dgp as f32)).collect();
        let matrix = Matrix::from_data(rows.len(), records.len(), 1, values)?;
        let names: Vec<&str> = rows.iter().map(|y| y.view.as_str()).collect();
        let about = format!("DGP, rows views ({}), columns time steps", names.join(", "));
        write_stored(&folder.join(format!("{}.dgp", section.method.name())), &matrix, &about)?;
    }
    let folder = store.glare_folder("")?;
    write_annual(&folder.join("annual.csv"), years, &occupied, calendar, warnings)?;
    write_undecided(&folder.join("undecided.csv"), years, &occupied, calendar)
}

/// Columns of the table of a view.
const HOUR_COLUMNS: &str = "hour,dgp,dgp_standard_error,ev_lux,sources,class";

fn write_hours(path: &Path, year: &ViewYear, steps: &Steps) -> Result<()> {
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        writeln!(out, "{HOUR_COLUMNS}").map_err(fault)?;
        for (step, h) in year.hours.iter().enumerate() {
            let (hour, class) = (steps.label(step), GlareClass::of(h.dgp).name());
            writeln!(out, "{hour},{:.6},{:.6},{:.2},{},{class}", h.dgp, h.standard_error, h.illuminance, h.sources).map_err(fault)?;
        }
        Ok(())
    })
}

/// Columns that tell which view (and state) a row is about.
fn labels(years: &[ViewYear]) -> (&'static str, fn(&ViewYear) -> String) {
    if years.iter().all(|y| y.state.is_empty()) {
        ("view", |y| y.view.clone())
    } else {
        ("view,state", |y| format!("{},{}", y.view, y.state))
    }
}

fn write_annual(path: &Path, years: &[ViewYear], occupied: &[bool], calendar: &Calendar<'_>, warnings: &mut Warnings) -> Result<()> {
    if !occupied.contains(&true) {
        warnings.push(Error::new("no hour of the weather file is occupied: there is no annual summary of glare").field("glare.occupied"));
    }
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        let (columns, label) = labels(years);
        let classes = "imperceptible_hours,perceptible_hours,disturbing_hours,intolerable_hours";
        writeln!(
            out,
            "{columns},occupied_hours,{classes},dgp_exceeded_5_percent,en17037_protection,glare_autonomy,mean_dgp,greatest_dgp,undecided_hours"
        )
        .map_err(fault)?;
        for year in years.iter().filter(|_| occupied.contains(&true)) {
            let dgp: Vec<f64> = year.hours.iter().map(|h| h.dgp).collect();
            let a = AnnualGlare::new(&dgp, occupied, calendar.steps.length)?;
            let open = |(h, o): &(&Hour, &bool)| **o && h.other_class(calendar.confidence_95).is_some();
            let undecided = calendar.steps.hours(year.hours.iter().zip(occupied).filter(open).count());
            let [i, p, d, t] = a.hours_in_class;
            writeln!(
                out,
                "{},{},{i},{p},{d},{t},{:.4},{},{:.4},{:.4},{:.4},{undecided}",
                label(year),
                a.hours,
                a.dgp_exceeded,
                a.protection.name(),
                a.glare_autonomy,
                a.mean_dgp,
                a.greatest_dgp
            )
            .map_err(fault)?;
        }
        Ok(())
    })
}

/// Occupied hours whose class the noise leaves open.
fn write_undecided(path: &Path, years: &[ViewYear], occupied: &[bool], calendar: &Calendar<'_>) -> Result<()> {
    write_atomically(path, |out| {
        let fault = |e: std::io::Error| Error::io(path, &e);
        let (columns, label) = labels(years);
        writeln!(out, "{columns},hour,dgp,dgp_standard_error,class,or").map_err(fault)?;
        for year in years {
            for (step, (h, _)) in year.hours.iter().zip(occupied).enumerate().filter(|(_, (_, o))| **o) {
                if let Some(other) = h.other_class(calendar.confidence_95) {
                    let (hour, class) = (calendar.steps.label(step), GlareClass::of(h.dgp).name());
                    writeln!(out, "{},{hour},{:.6},{:.6},{class},{}", label(year), h.dgp, h.standard_error, other.name()).map_err(fault)?;
                }
            }
        }
        Ok(())
    })
}

/// The carpet, as PNG and SVG.
fn draw(folder: &Path, year: &ViewYear, section: &GlareSection, days: &Days) -> Result<()> {
    let value = |step: usize| if year.is_lit[step] { year.hours[step].dgp } else { f64::NAN };
    let state = if year.state.is_empty() { String::new() } else { format!(", {}", year.state) };
    let drawing = carpet(days, &value, &format!("{}{state}", year.view), section.method.name())?;
    for extension in ["png", "svg"] {
        drawing.write(&folder.join(format!("{}.{extension}", year.view)), CARPET_SCALE)?;
    }
    Ok(())
}

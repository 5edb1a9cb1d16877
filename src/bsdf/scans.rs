//! Measurements of goniophotometers: one incident direction after the other, the scattered light at many outgoing
//! directions.
//!
//! # Files
//! **Text, one incident direction per file**, as Radiance's `pabopto2bsdf` reads it. A header of lines with `#`, then
//! rows `θ φ value` (degrees):
//!
//! | header | meaning |
//! |---|---|
//! | `#format: theta phi DSF` (or BSDF, BRDF, BTDF) | what the values are, must be there |
//! | `#incident_angle θ φ`, or `#intheta θ` and `#inphi φ` | from where the light comes, must be there |
//! | `#upphi φ` | azimuth of the sample's upper side, 0 if absent |
//! | `#sample_name "name"` | its name |
//! | `#colorimetry: CIE-Y` or `CIE-XYZ` | one value per row, or three of which Y is used |
//!
//! **CSV** with rows `θ_in, φ_in, θ_out, φ_out, value`: all incident directions in one file, in any order. The first row
//! names the columns; the name of the last is DSF, BSDF, BRDF or BTDF. There up lies at φ = 90°.
//!
//! # Angles and units
//! θ counts from the sample's front normal, which points **into the room**: below 90° is the room's side, above it the
//! outside. Both directions point **away from the sample**, that of the incident light to its source. A BSDF is in 1/sr;
//! a DSF is the BSDF times the cosine of the outgoing angle, so that its integral over solid angle is the share of the
//! light that is scattered.
//!
//! # Noise
//! Instruments report values below zero where there is no light. They stay in all sums, so that averages are unbiased;
//! [`Scan::negative`] says how many there are and what they add up to.

mod grid;
mod read;

pub(crate) use grid::{CELLS, SIDE, cell_direction, direction_of, square_of};
pub use grid::{Grid, Sums};

use super::Component;
use crate::error::{Error, Result, Warnings};
use crate::limits;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// What values are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// BSDF · |cos θ|, 1/sr.
    Dsf,
    /// BSDF, 1/sr.
    Bsdf,
}

impl Quantity {
    /// By its name in a header, in any case; BRDF and BTDF are BSDFs.
    pub fn by_name(name: &str) -> Option<Self> {
        match name.to_ascii_uppercase().as_str() {
            "DSF" => Some(Self::Dsf),
            "BSDF" | "BRDF" | "BTDF" => Some(Self::Bsdf),
            _ => None,
        }
    }
}

/// How measurements are read.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// The sample's front faces the outside, not the room (`pabopto2bsdf -t`).
    pub reversed: bool,
    /// Keeps only transmitted (`true`) or reflected light of instruments that measure both at once.
    pub transmitted: Option<bool>,
    /// Leaves out outgoing directions less than so many degrees above the sample's plane.
    pub grazing: f64,
}

/// The measurement of one incident direction, samples summed over a grid.
#[derive(Debug, Clone)]
pub struct Scan {
    /// Where the light travels, in the window's frame; z > 0, the component tells the side.
    pub incident: DVec3,
    /// From which side to which.
    pub component: Component,
    /// Samples, as DSF.
    pub grid: Grid,
    /// Number of samples.
    pub samples: usize,
    /// Number of negative samples, and the sum of their squares (1/sr²).
    pub negative: (usize, f64),
    /// The largest DSF, 1/sr, and how often it comes at different polar angles.
    pub largest: (f64, usize),
    /// Files it was read from.
    pub files: Vec<PathBuf>,
}

/// All measurements of one component of a sample.
#[derive(Debug, Clone)]
pub struct Scans {
    /// The sample's name, empty if unknown.
    pub name: String,
    /// From which side to which.
    pub component: Component,
    /// One per incident direction, by polar angle, then azimuth.
    pub scans: Vec<Scan>,
}

/// Incident directions closer than this are the same, degrees.
pub(crate) const SAME_INCIDENCE: f64 = 0.05;

impl Scan {
    pub(in crate::bsdf) fn new(incident: DVec3, component: Component, file: &Path) -> Self {
        Self {
            incident,
            component,
            grid: Grid::default(),
            samples: 0,
            negative: (0, 0.0),
            largest: (0.0, 0),
            files: vec![file.to_path_buf()],
        }
    }

    /// Polar angle of the incident light, degrees.
    pub fn theta(&self) -> f64 {
        self.incident.z.clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// Azimuth of where the light travels, degrees.
    pub fn phi(&self) -> f64 {
        self.incident.y.atan2(self.incident.x).to_degrees().rem_euclid(360.0)
    }

    /// Standard deviation of the instrument's noise where there is no light, 1/sr: that of a distribution around zero
    /// of which the negative half was seen. 0 if there are no negative values.
    pub fn noise(&self) -> f64 {
        if self.negative.0 == 0 { 0.0 } else { (self.negative.1 / self.negative.0 as f64).sqrt() }
    }

    pub(in crate::bsdf) fn add(&mut self, outgoing: DVec3, dsf: f64) {
        self.samples += 1;
        if dsf < 0.0 {
            self.negative = (self.negative.0 + 1, self.negative.1 + dsf * dsf);
        }
        if dsf > self.largest.0 {
            self.largest = (dsf, 1);
        } else if dsf == self.largest.0 {
            self.largest.1 += 1;
        }
        self.grid.add(outgoing, dsf);
    }

    /// Puts samples of another file to these.
    fn merge(&mut self, other: Scan) {
        self.samples += other.samples;
        self.negative = (self.negative.0 + other.negative.0, self.negative.1 + other.negative.1);
        if other.largest.0 > self.largest.0 {
            self.largest = other.largest;
        }
        self.files.extend(other.files);
        self.grid.merge(&other.grid);
    }

    fn check(&self, warnings: &mut Warnings) -> Result<()> {
        let file = &self.files[0];
        let at = format!("incident θ {:.1}°, φ {:.1}° (direction of travel)", self.theta(), self.phi());
        if self.samples == 0 {
            return Err(Error::new(format!("there is no sample for {at}")).file(file));
        }
        if self.largest.0 <= 0.0 {
            return Err(Error::new(format!("all values are zero or negative for {at}"))
                .file(file)
                .help("the scan was made in the dark, or belongs to an opaque sample: leave the file out"));
        }
        let share = self.grid.integral();
        if share > 1.05 {
            let other = self.grid.integral_as_bsdf();
            let help = if other <= 1.05 {
                format!("as BSDF values they would give {:.1} %: the header should say 'theta phi BSDF'", 100.0 * other)
            } else {
                "values are DSF or BSDF in 1/sr: check the calibration of the instrument".to_string()
            };
            return Err(Error::new(format!("{:.0} % of the light is scattered for {at}", 100.0 * share)).file(file).help(help));
        }
        if self.largest.1 >= 12 && self.largest.1 * 200 >= self.samples && self.grid.largest_is_cut(self.largest.0) {
            warnings.push(
                Error::new(format!("{} samples have the same largest value for {at}", self.largest.1))
                    .file(file)
                    .help("the detector may have been saturated: the peak is then too low"),
            );
        }
        Ok(())
    }
}

/// Reads the measurements of one component.
///
/// Files of the same incident direction are put together (a whole scan and a finer one of its peak).
///
/// # Errors
/// File and line of what is wrong: rows that are no numbers, values that are not finite, angles that look like radians,
/// no or several sides, more light than arrives (a DSF called BSDF or the other way around), scans without light; fewer
/// than two incident directions.
pub fn read(paths: &[PathBuf], options: &Options, warnings: &mut Warnings) -> Result<Scans> {
    if paths.len() > limits::GONIOPHOTOMETER_FILES {
        return Err(limits::exceeded("the measurement has", limits::GONIOPHOTOMETER_FILES, "files"));
    }
    let mut name = String::new();
    let mut all: Vec<Scan> = Vec::new();
    let mut cells = 0;
    for path in paths {
        let file = read::read(path, options, warnings).map_err(|e| e.file(path))?;
        if !file.name.is_empty() {
            name = file.name;
        }
        for scan in file.scans {
            if let Some(first) = all.first()
                && first.component != scan.component
            {
                return Err(Error::new(format!(
                    "this is {}, '{}' is {}",
                    words(scan.component),
                    first.files[0].display(),
                    words(first.component)
                ))
                .file(path)
                .help("give the files of one side and sense at a time, and put the results together with `lucarne bsdf convert`"));
            }
            cells += scan.grid.len();
            if cells > limits::GONIOPHOTOMETER_CELLS {
                return Err(limits::exceeded("the measurement has", limits::GONIOPHOTOMETER_CELLS, "different directions").file(path));
            }
            match all.iter_mut().find(|s| angle(s.incident, scan.incident) < SAME_INCIDENCE) {
                Some(same) => {
                    warnings.push(
                        Error::new(format!("has the incident direction of '{}' (θ {:.1}°)", same.files[0].display(), scan.theta()))
                            .file(path)
                            .help("their samples are put together; where both measured the same direction it is their mean"),
                    );
                    same.merge(scan);
                }
                None => all.push(scan),
            }
        }
    }
    for scan in &all {
        scan.check(warnings)?;
    }
    if all.len() < 2 {
        return Err(Error::new(format!("{} incident direction is measured; at least two are needed", all.len()))
            .help("give all files of the measurement, for instance scans/*.dat"));
    }
    if all.len() > limits::GONIOPHOTOMETER_FILES {
        return Err(limits::exceeded("the measurement has", limits::GONIOPHOTOMETER_FILES, "incident directions"));
    }
    all.sort_by(|a, b| (a.theta().round(), a.phi()).partial_cmp(&(b.theta().round(), b.phi())).unwrap_or(std::cmp::Ordering::Equal));
    Ok(Scans { name, component: all[0].component, scans: all })
}

/// The measurements of one file, as they are.
///
/// # Errors
/// File and line of what is wrong in its text.
pub fn read_one(path: &Path, options: &Options, warnings: &mut Warnings) -> Result<Vec<Scan>> {
    read::read(path, options, warnings).map(|file| file.scans).map_err(|e| e.file(path))
}

/// Whether a file looks like measurements that [`read`] takes: a header of `pabopto2bsdf`, or a CSV of five columns that
/// names its quantity.
pub fn is_scan(path: &Path) -> bool {
    read::looks_like_scan(path)
}

/// Degrees between two directions.
pub(crate) fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (0.5 * (a - b).length()).clamp(0.0, 1.0).asin().to_degrees()
}

fn words(component: Component) -> &'static str {
    match component {
        Component::TransmissionFront => "transmission from the outside into the room",
        Component::TransmissionBack => "transmission from the room to the outside",
        Component::ReflectionFront => "reflection outside",
        Component::ReflectionBack => "reflection into the room",
    }
}

#[cfg(test)]
mod tests;

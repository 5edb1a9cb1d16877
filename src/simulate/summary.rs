//! What a run did, for people and for programs: `summary.json`.

use super::context::{MatrixSummary, Seconds};
use super::results::control::ControlSummary;
use super::results::sensors::SensorSummary;
use super::results::views::ViewSummary;
use super::store::Store;
use crate::control::Group;
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::metrics::Metric;
use crate::simulate::inputs::division::Division;
use crate::simulate::inputs::suns::SunCensus;
use crate::simulate::inputs::{Differences, Inputs, ProjectWindow};
use crate::simulate::results::glare::GlareSummary;
use crate::simulate::results::uncertainty::EstimatedError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Contents of `summary.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Summary {
    /// `lucarne` and its version.
    pub program: String,
    /// Project file, relative to the folder of results where that is possible: whoever opens the
    /// results finds room and weather by it. Of a path that is no Unicode, as much as there is.
    #[serde(serialize_with = "as_text")]
    pub project: PathBuf,
    /// Where the kernels ran.
    pub device: DeviceSummary,
    /// Preset of `[quality]`.
    pub preset: String,
    /// What `[quality]` asked for, in words.
    pub quality: String,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Phases of the method.
    pub phases: u32,
    /// Method of the sensors, with its formula; pictures and glare have as many phases as `phases` says.
    pub sensors_method: String,
    /// Why.
    pub phases_because: String,
    /// `illuminance` or `irradiance`: what sensors tell, and the folder it is in.
    pub quantity: String,
    /// Suns that are traced; absent where none are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suns: Option<SunCensus>,
    /// Reinhart subdivision of the sky.
    pub sky_subdivision: usize,
    /// Limit of diffuse reflections; absent: none.
    pub bounces: Option<u32>,
    /// Where the time steps come from, which of them were taken, and what makes their sky, for people.
    pub weather: String,
    /// Hours that the time steps cover.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours: f64,
    /// Its time steps: columns of the results.
    pub time_steps: usize,
    /// Windows, in the order of the view matrices' columns.
    pub windows: Vec<WindowSummary>,
    /// Groups of windows that have states.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<GroupSummary>,
    /// Of groups whose states the run decided: how, and what came of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control: Option<ControlSummary>,
    /// Of a project that names no windows, the scene's glass that was not taken for windows, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub glass_left: Vec<String>,
    /// Whether V or D were made elsewhere, so that their direct parts can exceed them by noise.
    pub matrices_are_given: bool,
    /// Results per group of sensors.
    pub sensors: Vec<SensorSummary>,
    /// Metrics of all groups of sensors together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub metrics: Vec<Metric>,
    /// Pictures per view.
    pub views: Vec<ViewSummary>,
    /// Annual glare, if the project asks for it.
    pub glare: Option<GlareSummary>,
    /// The matrices.
    pub matrices: Vec<MatrixSummary>,
    /// What multiplied the matrices.
    pub product: String,
    /// Seconds per stage.
    pub seconds: Seconds,
    /// Paths traced in this run.
    pub paths: u64,
    /// Path segments and connections traced in this run, at least.
    pub rays: u64,
    /// `rays` per second of tracing; absent if nothing was traced.
    pub rays_per_second: Option<f64>,
    /// Relative standard errors of the illuminances; absent if it is always dark.
    pub estimated_error: Option<EstimatedError>,
    /// Everything suspicious that is not an error.
    pub warnings: Vec<String>,
}

/// One window.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WindowSummary {
    /// Its name, which its matrices `T_NAME` and `D_NAME` have.
    pub name: String,
    /// What it is made of, for people.
    pub glazing: String,
    /// m².
    pub area: f64,
    /// Where it faces: degrees clockwise from north (+y) of its outward normal, and its tilt from the horizon (90 looks up).
    pub faces: [f64; 2],
    /// Bins of all its parts: columns of the view matrices, rows of its D.
    pub bins: usize,
    /// The parts over which V and D are averaged.
    pub parts: Division,
    /// Whether suns are traced through it, in any state that it is ever in.
    pub sun_is_traced: bool,
    /// Group of windows that it moves with; absent of a window without states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Its states in which no sun is traced through it, though it is in others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states_without_sun: Vec<String>,
}

/// Windows that change their states together.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GroupSummary {
    /// Its name; `control/NAME.csv` has its state in every time step.
    pub name: String,
    /// Its windows.
    pub windows: Vec<String>,
    /// Its states, in the order of the project.
    pub states: Vec<StateSummary>,
    /// How often it is in another state than in the time step before.
    pub moves: usize,
}

/// A state of a group of windows.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StateSummary {
    /// Its name.
    pub name: String,
    /// What the windows are made of in it, for people.
    pub glazing: String,
    /// Whether suns are traced through it.
    pub sun_is_traced: bool,
    /// Hours that the group is in it.
    #[serde(serialize_with = "crate::units::whole_hours")]
    pub hours: f64,
}

impl GroupSummary {
    /// All groups of a run of so many phases.
    pub(super) fn of(inputs: &Inputs, phases: u32) -> Vec<Self> {
        let length = inputs.weather.steps().length;
        let of = |(number, group): (usize, &Group)| {
            let windows: Vec<&ProjectWindow> = inputs.windows_of_group(number).into_iter().map(|i| &inputs.windows[i]).collect();
            let hours = inputs.schedule.hours(number, group.states.len(), length, None);
            let state = |(i, (name, hours)): (usize, (&String, f64))| {
                let mut made_of: Vec<&str> = windows.iter().map(|w| w.states[i].made_of.as_str()).collect();
                made_of.dedup();
                let sun_is_traced = phases == 5 && windows.iter().any(|w| w.states[i].is_sunny());
                StateSummary { name: name.clone(), glazing: made_of.join("; "), sun_is_traced, hours }
            };
            Self {
                name: group.name.clone(),
                windows: windows.iter().map(|w| w.name.clone()).collect(),
                states: group.states.iter().zip(hours).enumerate().map(state).collect(),
                moves: inputs.schedule.moves(number),
            }
        };
        inputs.facade.groups().iter().enumerate().map(of).collect()
    }
}

/// The device that ran the kernels.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DeviceSummary {
    /// Name the driver gives.
    pub name: String,
    /// `discrete`, `integrated`, `other` or `CPU`.
    pub kind: String,
    /// Vulkan, Metal or Dx12.
    pub backend: String,
    /// Driver and version.
    pub driver: String,
}

impl DeviceSummary {
    /// Of an open device.
    pub fn of(device: &Device) -> Self {
        let s = device.summary();
        Self { name: s.name.clone(), kind: s.kind.to_string(), backend: s.backend.clone(), driver: s.driver.clone() }
    }
}

fn as_text<S: serde::Serializer>(path: &Path, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

impl Summary {
    /// The windows of a run of so many phases, and whether matrices were made elsewhere.
    pub(super) fn of_windows(inputs: &Inputs, phases: u32) -> (Vec<WindowSummary>, bool) {
        let of = |(i, w): (usize, &ProjectWindow)| WindowSummary {
            name: w.name.clone(),
            glazing: w.made_of.clone(),
            area: w.window.area(),
            faces: w.window.faces(),
            bins: w.bins(),
            parts: w.division.clone(),
            sun_is_traced: phases == 5 && inputs.is_sunny(i),
            states_without_sun: w.states.iter().filter(|s| phases == 5 && !s.is_sunny()).map(|s| s.name.clone()).collect(),
            group: w.group.map(|g| inputs.facade.groups()[g].name.clone()),
        };
        (inputs.windows.iter().enumerate().map(of).collect(), inputs.differences() == Differences::Noisy)
    }

    /// Reads the summary of a result folder; what an older version did not write has its default.
    ///
    /// # Errors
    /// A folder without results, or a file that is no summary.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(Store::SUMMARY);
        let bytes = crate::files::read(&path).map_err(|_| {
            Error::new("this folder holds no results: there is no summary.json")
                .file(folder)
                .help("open a folder that 'lucarne run PROJECT.toml -o FOLDER' has written")
        })?;
        let mut summary: Self =
            serde_json::from_slice(&bytes).map_err(|e| Error::new(e.to_string()).file(&path).help("run the project again"))?;
        if summary.windows.is_empty() {
            // Suns count as spread: which of them were traced is not told.
            let names = summary.matrices.iter().filter_map(|m| m.name.strip_prefix("D_"));
            summary.windows = names.map(|n| WindowSummary { name: n.to_string(), ..WindowSummary::default() }).collect();
        }
        Ok(summary)
    }

    /// Time steps; a year of hours if the file does not tell.
    pub(super) fn steps(&self) -> usize {
        match (self.time_steps, self.hours as usize) {
            (0, 0) => 8760,
            (0, hours) => hours,
            (steps, _) => steps,
        }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Failures of the file system with the path named.
    pub fn write(&self, path: &Path) -> Result<()> {
        crate::files::write_atomically(path, |out| {
            serde_json::to_writer_pretty(&mut *out, self).map_err(|e| Error::stream(&e.into()).file(path))?;
            writeln!(out).map_err(|e| Error::io(path, &e))
        })
    }
}

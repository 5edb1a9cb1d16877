//! What a run did, for people and for programs: `summary.json`.

use super::glare::GlareSummary;
use super::suns::SunCensus;
use super::uncertainty::EstimatedError;
use crate::error::{Error, Result};
use crate::gpu::Device;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Contents of `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// `lucarne` and its version.
    pub program: String,
    /// Project file, relative to the folder of results where that is possible: whoever opens the
    /// results finds room and weather by it.
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
    /// Why as many.
    pub phases_because: String,
    /// Suns of the five-phase method; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suns: Option<SunCensus>,
    /// Reinhart subdivision of the sky.
    pub sky_subdivision: usize,
    /// Limit of diffuse reflections; absent: none.
    pub bounces: Option<u32>,
    /// Hours that the weather file covers.
    #[serde(serialize_with = "whole")]
    pub hours: f64,
    /// Its time steps: columns of the results.
    pub time_steps: usize,
    /// Results per group of sensors.
    pub sensors: Vec<SensorSummary>,
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

/// The device that ran the kernels.
#[derive(Debug, Clone, Serialize)]
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

/// Hours without a decimal point where they are whole.
pub(super) fn whole<S: serde::Serializer>(hours: &f64, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    if hours.fract() == 0.0 { serializer.serialize_u64(*hours as u64) } else { serializer.serialize_f64(*hours) }
}

impl DeviceSummary {
    /// Of an open device.
    pub fn of(device: &Device) -> Self {
        let s = device.summary();
        Self { name: s.name.clone(), kind: s.kind.to_string(), backend: s.backend.clone(), driver: s.driver.clone() }
    }
}

/// One group of sensors.
#[derive(Debug, Clone, Serialize)]
pub struct SensorSummary {
    /// Its name.
    pub name: String,
    /// Number of sensors.
    pub count: usize,
    /// Those that no light reaches, with 0 lx.
    pub without_light: usize,
    /// Mean over sensors and hours, lux.
    pub mean_illuminance_lx: f64,
    /// Its standard error, lux.
    pub mean_illuminance_standard_error_lx: f64,
    /// sDA300/50 %: share of the sensors that have 300 lx in at least half of the hours from 8 to 18.
    pub spatial_autonomy: f64,
    /// Its standard error.
    pub spatial_autonomy_standard_error: f64,
}

/// One view.
#[derive(Debug, Clone, Serialize)]
pub struct ViewSummary {
    /// Its name.
    pub name: String,
    /// Pixels of its pictures.
    pub pixels: usize,
    /// Pictures written.
    pub pictures: usize,
    /// Relative standard error of a year's light at the eye, traced suns left out; absent for views
    /// without directions.
    pub eye_error: Option<f64>,
}

/// One matrix file.
#[derive(Debug, Clone, Serialize)]
pub struct MatrixSummary {
    /// Name of the file in `matrices/`, without `.mtx`; `suns_VIEW` for the suns' sparse pictures.
    pub name: String,
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Taken from an earlier run with the same inputs.
    pub reused: bool,
    /// Seconds it took (to compute or to read); of V and D those of all sensors and windows.
    pub seconds: f64,
    /// Rays counted for it in this run.
    pub rays: u64,
    /// Rounds of sampling; absent where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounds: Option<u32>,
}

/// Seconds of wall clock per stage.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Seconds {
    /// Sky matrix.
    pub sky: f64,
    /// View matrix.
    pub view: f64,
    /// Daylight matrices.
    pub daylight: f64,
    /// Sun matrix.
    pub suns: f64,
    /// Suns in pictures, a part of `write` or `glare`.
    pub sun_pictures: f64,
    /// Product of all matrices.
    pub product: f64,
    /// Propagation of the standard errors.
    pub error_estimate: f64,
    /// Writing results.
    pub write: f64,
    /// Annual glare, its own matrices included.
    pub glare: f64,
    /// All of it.
    pub total: f64,
}

impl Summary {
    /// Writes the file.
    ///
    /// # Errors
    /// Failures of the file system with the path named.
    pub fn write(&self, path: &Path) -> Result<()> {
        crate::files::write_atomically(path, |out| {
            serde_json::to_writer_pretty(&mut *out, self).map_err(|e| Error::new(e.to_string()).file(path))?;
            writeln!(out).map_err(|e| Error::io(path, &e))
        })
    }
}

//! What a run did, for people and for programs: `summary.json`.

use super::context::{MatrixSummary, Seconds};
use super::results::sensors::SensorSummary;
use super::results::views::ViewSummary;
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::simulate::inputs::suns::SunCensus;
use crate::simulate::results::glare::GlareSummary;
use crate::simulate::results::uncertainty::EstimatedError;
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
    #[serde(serialize_with = "crate::units::whole_hours")]
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

impl DeviceSummary {
    /// Of an open device.
    pub fn of(device: &Device) -> Self {
        let s = device.summary();
        Self { name: s.name.clone(), kind: s.kind.to_string(), backend: s.backend.clone(), driver: s.driver.clone() }
    }
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

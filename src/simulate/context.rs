//! What every phase of a run works with, and the ledger of what it did.

use super::inputs::Inputs;
use super::project::Project;
use super::project::method::Choice;
use super::store::Store;
use super::store::fingerprint::Fingerprint;
use crate::bins::ReinhartSky;
use crate::error::Result;
use crate::gpu::Device;
use crate::kernels::trace::TraceStatistics;
use crate::progress::{Progress, cancelled};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// What every phase of a run works with.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Device that traces and, if it is faster, multiplies.
    pub device: &'a Device,
    /// What is asked for.
    pub project: &'a Project,
    /// The number of phases, and why.
    pub choice: Choice,
    /// What its files hold.
    pub inputs: &'a Inputs,
    /// What the scene holds, hashed once for a run.
    pub scene: Fingerprint,
    /// Where results go.
    pub store: &'a Store,
    /// Progress.
    pub progress: &'a dyn Progress,
}

impl Context<'_> {
    /// Division of the sky.
    pub fn sky(&self) -> ReinhartSky {
        self.inputs.sky(self.project)
    }

    /// # Errors
    /// [`cancelled`] if a stop was requested.
    pub(crate) fn check_stop(&self) -> Result<()> {
        if self.progress.stop_requested() { Err(cancelled()) } else { Ok(()) }
    }

    /// What rays can meet.
    pub(crate) fn scene_fingerprint(&self, kind: &str) -> Fingerprint {
        let device = self.device.summary();
        *Fingerprint::new(kind).add_all_of(self.scene).add(&device.name).add(&device.driver)
    }

    /// The same with the windows that emit.
    pub(crate) fn view_fingerprint(&self, kind: &str) -> Fingerprint {
        let mut inputs = self.scene_fingerprint(kind);
        inputs.add(&"images of windows in pictures, half a hit more of light paths");
        for window in self.inputs.windows.iter().flat_map(|w| &w.parts) {
            inputs.add(&(&window.triangles, &window.frame, &window.basis));
        }
        inputs
    }
}

/// What tracing a matrix took.
#[derive(Debug, Clone, Copy, Default)]
pub struct Traced {
    /// Rounds of sampling, if it is sampled in rounds.
    pub rounds: u32,
    /// Rays.
    pub rays: u64,
}

/// What a run did so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ledger {
    /// Seconds per stage.
    pub seconds: Seconds,
    /// Paths and rays.
    pub statistics: TraceStatistics,
    /// Seconds of tracing.
    pub traced_seconds: f64,
    /// Matrices computed or reused.
    pub matrices: Vec<MatrixSummary>,
}

impl Ledger {
    /// Notes a matrix.
    pub fn note(&mut self, name: &str, [rows, columns]: [usize; 2], reused: bool, seconds: f64, traced: Traced) {
        let rays = if reused { 0 } else { traced.rays };
        let rounds = traced.rounds;
        let rounds = (rounds > 0).then_some(rounds);
        self.matrices.push(MatrixSummary { name: name.to_string(), rows, columns, reused, seconds, rays, rounds });
    }

    /// Counts what was traced since `clock`.
    pub fn count(&mut self, statistics: TraceStatistics, clock: Instant) {
        self.statistics.add(statistics);
        self.traced_seconds += clock.elapsed().as_secs_f64();
    }
}

/// One matrix file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
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
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
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

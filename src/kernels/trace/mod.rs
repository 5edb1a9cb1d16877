//! What all tracing kernels share: the scene, its windows and their tables on the device.

use crate::error::{Error, Result};
use crate::matrix::Matrix;

#[cfg(test)]
mod cie171;
#[cfg(test)]
pub(crate) mod comparison;
pub mod doubt;
#[cfg(test)]
mod extremes;
#[cfg(test)]
mod mutations;
mod normalization;
pub(crate) mod planes;
pub(crate) mod probes;
mod records;
#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
pub(crate) mod rooms;
mod tables;
mod unit;

pub(crate) use normalization::Normalization;
pub(crate) use records::Counters;
pub(crate) use records::{
    FAR_AWAY, FRESNEL_THRESHOLD, MATERIAL_GLASS, MATERIAL_MIRROR, MATERIAL_SURFACE, SMOOTH_ROUGHNESS2, shader, smooth_fresnel,
};
pub use records::{Material, Ring, Window};
pub use tables::WindowSurfaces;
pub(crate) use tables::{TraceScene, TraceTables};
pub(crate) use unit::{Values, unit};

/// Path weight below which Russian roulette decides, unless a caller says otherwise (Radiance's `-lw`).
pub const ROULETTE_WEIGHT: f32 = 0.05;

/// Fixed-point units that a dispatch may add to a cell; half the range, since area sampling of small
/// windows exceeds their mean solid angle a little.
pub(crate) const CELL_CAPACITY: f32 = (1u32 << 31) as f32;

/// What a computation did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TraceStatistics {
    /// Paths started, all of them finished.
    pub paths: u64,
    /// Path segments and connections, at least.
    pub segments: u64,
}

impl TraceStatistics {
    /// Adds the work of another computation.
    pub fn add(&mut self, other: Self) {
        self.paths += other.paths;
        self.segments += other.segments;
    }
}

/// One independent estimate of a matrix: all its entries come from the same rays, so their errors are
/// correlated in ways that only the whole batch shows.
#[derive(Debug, Clone, PartialEq)]
pub struct TracedBatch {
    /// The matrix.
    pub total: Matrix<f32>,
    /// Only what arrives directly.
    pub direct: Matrix<f32>,
    /// Of daylight coefficients: what arrives directly or in a way that light paths of suns have too.
    pub sunlit: Option<Matrix<f32>>,
}

/// A matrix, its part without diffuse reflections, and its standard error, all of one shape.
#[derive(Debug, Clone, PartialEq)]
pub struct TracedMatrix {
    /// The matrix.
    pub total: Matrix<f32>,
    /// Only what arrives directly, through openings and panes (Vd, Dd); never larger than `total`.
    pub direct: Matrix<f32>,
    /// Standard error of each entry of `total`.
    pub standard_error: Matrix<f32>,
    /// The independent batches that the three above come from, if they were asked for.
    pub batches: Vec<TracedBatch>,
    /// Work done.
    pub statistics: TraceStatistics,
}

/// Checks that every path started was finished: some drivers end long loops silently.
///
/// # Errors
/// If paths were lost.
pub(crate) fn check_finished(counters: &Counters, started: u64, what: &str) -> Result<()> {
    if u64::from(counters.finished) == started && counters.failed == 0 {
        return Ok(());
    }
    Err(Error::new(format!(
        "{what}: {started} paths were started but {} finished and {} were cut off by the device",
        counters.finished, counters.failed
    ))
    .help("the scene is too deep for this device's limit on loops; use another device, or simplify the geometry"))
}

/// A seed for one stream of random numbers: different for every seed, batch and purpose.
pub(crate) fn stream_seed(seed: u32, batch: u32, purpose: u32) -> u32 {
    let mut x = (u64::from(seed) << 32 | u64::from(batch)) ^ u64::from(purpose).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x ^ (x >> 31)) as u32
}

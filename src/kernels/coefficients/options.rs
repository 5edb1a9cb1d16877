//! How much of the daylight coefficients' light to sample.

use super::GlazedWindow;
use crate::error::{Error, Result};
use crate::gpu::DEFAULT_MEMORY;
use crate::kernels::trace::ROULETTE_WEIGHT;
use crate::kernels::view_matrix::{MOST_LIGHT_PATHS, MOST_VISIBILITY_RAYS};

/// How much to sample. Every number is per sensor or bin *and batch*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoefficientOptions {
    /// Radiance's `-ab` of `rcontrib -I+`: 1 is light that nothing scatters, n allows n − 1 diffuse reflections, outside
    /// and inside together; `None` does not truncate.
    pub bounces: Option<u32>,
    /// Samples of the windows per sensor.
    pub direct_samples: u32,
    /// Light paths from each directional bin of each window, which all sensors share; 0: the paths from the sensors find
    /// everything, which is slow and needs no windows.
    pub light_paths: u32,
    /// Light paths from each sun, which all sensors share, and paths from each sensor to surfaces in the sun, if suns have their own
    /// ([`compute_suns`](super::compute_suns)): batches then tell the part that these find.
    pub sun_paths: Option<u32>,
    /// Sets of surfaces that a sensor's own paths to suns meet. Suns take turns in using them, so that errors of a year of suns
    /// even out.
    pub sun_sets: u32,
    /// Rays from a sensor to the light paths' vertices, per bin and reflection; at most 32.
    pub visibility_rays: u32,
    /// Paths per sensor: for short connections and mirrors, and for light that comes by no window.
    pub near_samples: u32,
    /// Connections shorter than this multiple of the windows' size are left to `near_samples`, longer ones
    /// too if windows are small and far away.
    pub near_radius: f32,
    /// Independent repetitions; their spread gives the standard error. At least 2.
    pub batches: u32,
    /// Same seed, same device: same bits.
    pub seed: u32,
    /// Path weight below which Russian roulette decides (Radiance's `-lw`).
    pub roulette_weight: f32,
    /// Whether the batches themselves are handed back too.
    pub keep_batches: bool,
    /// Whether this is the first, or only, of the rounds that are averaged: it has the doubts (see
    /// [`doubt`](crate::kernels::trace::doubt)).
    pub first_round: bool,
    /// Device memory to use, bytes.
    pub memory: u64,
}

impl Default for CoefficientOptions {
    fn default() -> Self {
        Self {
            bounces: None,
            direct_samples: 512,
            light_paths: 256,
            sun_paths: None,
            sun_sets: 4,
            visibility_rays: 4,
            near_samples: 512,
            near_radius: 0.4,
            batches: 8,
            seed: 1,
            roulette_weight: ROULETTE_WEIGHT,
            keep_batches: false,
            first_round: true,
            memory: DEFAULT_MEMORY,
        }
    }
}

/// Samples per sensor and batch, at most: bounds the fixed-point sums.
const MOST_SAMPLES: u32 = 1 << 16;

/// Sets of surfaces, at most: bounds memory.
const MOST_SUN_SETS: u32 = 64;

/// Light paths per sun and batch, at least: some come straight from the sun, some by way of what stands outside.
pub(crate) const LEAST_SUN_PATHS: u32 = 2;

impl CoefficientOptions {
    /// Whether light that surfaces reflect comes by light paths from windows.
    pub(super) fn has_light_paths(&self, windows: &[GlazedWindow]) -> bool {
        !windows.is_empty() && self.light_paths > 0 && self.bounces.is_none_or(|b| b > 1)
    }

    pub(super) fn check(&self) -> Result<()> {
        if self.batches < 2 {
            return Err(Error::new("at least two batches are needed for a standard error"));
        }
        if !(1..=MOST_VISIBILITY_RAYS).contains(&self.visibility_rays) || self.light_paths > MOST_LIGHT_PATHS || !(self.near_radius > 0.0) {
            return Err(Error::new(format!(
                "{} light paths, {} visibility rays and a near radius of {} are outside what is possible",
                self.light_paths, self.visibility_rays, self.near_radius
            ))
            .help(format!(
                "light paths up to {MOST_LIGHT_PATHS}, visibility rays 1 to {MOST_VISIBILITY_RAYS}; use more batches for more samples"
            )));
        }
        if !(1..=MOST_SUN_SETS).contains(&self.sun_sets) {
            return Err(Error::new(format!("{} sets of surfaces for suns are outside 1 to {MOST_SUN_SETS}", self.sun_sets)));
        }
        if let Some(paths) = self.sun_paths
            && !(LEAST_SUN_PATHS..=MOST_LIGHT_PATHS).contains(&paths)
        {
            return Err(Error::new(format!("{paths} light paths per sun and batch are outside {LEAST_SUN_PATHS} to {MOST_LIGHT_PATHS}"))
                .help("use more batches for more paths"));
        }
        for (what, samples) in [("window samples", self.direct_samples), ("paths", self.near_samples)] {
            if !(1..=MOST_SAMPLES).contains(&samples) {
                return Err(Error::new(format!("{samples} {what} per sensor and batch are outside 1 to {MOST_SAMPLES}"))
                    .help("use more batches for more samples"));
            }
        }
        Ok(())
    }
}

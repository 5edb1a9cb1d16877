//! How much of a view matrix's light to sample.

use crate::gpu::DEFAULT_MEMORY;
use crate::kernels::trace::ROULETTE_WEIGHT;

/// How much to sample. Every number is per sensor or bin *and batch*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewOptions {
    /// Radiance's `-ab`: 1 is direct light only, n allows n − 1 diffuse reflections; `None` does
    /// not truncate.
    pub bounces: Option<u32>,
    /// Light paths per bin.
    pub light_paths: u32,
    /// Rays from a sensor to the light paths' vertices, per bin and reflection; at most 32.
    pub visibility_rays: u32,
    /// Samples of the windows per sensor.
    pub direct_samples: u32,
    /// Paths per sensor for short connections and mirrors.
    pub near_samples: u32,
    /// Independent repetitions; their spread gives the standard error. At least 2.
    pub batches: u32,
    /// Same seed, same device: same bits.
    pub seed: u32,
    /// Path weight below which Russian roulette decides (Radiance's `-lw`).
    pub roulette_weight: f32,
    /// Connections shorter than this multiple of the windows' size are left to `near_samples`, longer ones
    /// too if windows are small and far away.
    pub near_radius: f32,
    /// Whether the batches themselves are handed back too.
    pub keep_batches: bool,
    /// Whether this is the first, or only, of the rounds that are averaged: it has the doubts (see
    /// [`doubt`](crate::kernels::trace::doubt)).
    pub first_round: bool,
    /// Device memory to use, bytes.
    pub memory: u64,
}

/// Rays to light paths' vertices of a tile of sensors, about: bounds the time of a unit that a stop may lose.
const TILE_RAYS: usize = 1 << 24;
/// Diffuse vertices of light paths that matter.
const VERTICES: usize = 4;
/// For fewer sensors at once the light paths themselves would be most of the work.
const LEAST_TILE: usize = 256;

impl ViewOptions {
    /// Sensors of a tile, for so many bins.
    pub(crate) fn sensors_at_once(&self, bins: usize) -> usize {
        let rays = bins * self.batches as usize * self.visibility_rays as usize * VERTICES;
        (TILE_RAYS / rays.max(1)).max(LEAST_TILE)
    }
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self {
            bounces: None,
            light_paths: 256,
            visibility_rays: 4,
            direct_samples: 512,
            near_samples: 512,
            batches: 8,
            seed: 1,
            roulette_weight: ROULETTE_WEIGHT,
            near_radius: 0.4,
            keep_batches: false,
            first_round: true,
            memory: DEFAULT_MEMORY,
        }
    }
}

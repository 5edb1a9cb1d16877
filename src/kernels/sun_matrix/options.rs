//! How much to sample.

use crate::gpu::DEFAULT_MEMORY;
use crate::kernels::trace::ROULETTE_WEIGHT;

/// Slots of a path without a limit on reflections: after as many, slats of reflectance 0.5 have
/// lost all but 2⁻¹⁶ of the light.
const MOST_VERTICES: u32 = 16;

/// How light is found that surfaces scatter. All ways give the same but for noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScatteredBy {
    /// By points on the surfaces that receivers share, where these say more than paths of their own in no
    /// more time; else by paths.
    Automatic,
    /// By paths from every receiver.
    Paths,
    /// By points wherever they can stand for everything: where nothing scatters in preferred directions,
    /// and at receivers that are not next to the surfaces.
    Points,
}

/// How much to sample. Every number is per receiver *and batch*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunOptions {
    /// Points of a sun's disc.
    pub disc_samples: u32,
    /// Paths to scattering surfaces that a sun is seen from.
    pub paths: u32,
    /// Sets of so many paths, or of the points in their place. Suns take turns in using them (`number % path_sets`): paths cost little
    /// beside the rays from their vertices to the suns, and errors of a year of suns even out.
    pub path_sets: u32,
    /// Most diffuse (or rough) reflections of sunlight: 0 is direct light only, Radiance's `-ab`;
    /// `None` is 16.
    pub bounces: Option<u32>,
    /// How scattered light is found.
    pub scattered_by: ScatteredBy,
    /// Cells of all panes of scattering data together, about: each takes a ray to every receiver and every sun.
    pub cells: u32,
    /// Size of the parts of a cell, seen from the receiver, in each of which the scattering function is
    /// evaluated, radians.
    pub part_angle: f32,
    /// Independent repetitions; their spread gives the standard error. At least 2.
    pub batches: u32,
    /// Same seed, same device: same bits.
    pub seed: u32,
    /// Share of its first weight below which Russian roulette ends a path.
    pub roulette_weight: f32,
    /// Device memory to use, bytes.
    pub memory: u64,
}

impl Default for SunOptions {
    fn default() -> Self {
        Self {
            disc_samples: 16,
            paths: 32,
            path_sets: 4,
            bounces: None,
            scattered_by: ScatteredBy::Automatic,
            cells: 1024,
            part_angle: 0.05,
            batches: 4,
            seed: 1,
            roulette_weight: ROULETTE_WEIGHT,
            memory: DEFAULT_MEMORY,
        }
    }
}

impl SunOptions {
    /// Direct light only.
    #[must_use]
    pub fn direct(self) -> Self {
        Self { bounces: Some(0), ..self }
    }

    /// As many samples in batches of no more than so many points of a disc.
    #[must_use]
    pub(super) fn in_batches_of(self, points: u32) -> Self {
        let times = self.disc_samples.div_ceil(points).max(1);
        Self {
            disc_samples: self.disc_samples.div_ceil(times),
            paths: self.paths.div_ceil(times),
            batches: self.batches.saturating_mul(times),
            ..self
        }
    }

    pub(super) fn most_vertices(&self) -> u32 {
        self.bounces.unwrap_or(MOST_VERTICES).min(MOST_VERTICES)
    }

    /// Whether anything beyond direct light is asked for.
    pub(super) fn scatters(&self) -> bool {
        self.most_vertices() > 0 && self.paths > 0
    }
}

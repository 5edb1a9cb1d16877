//! Paths from receivers, for what light paths leave out: short connections and mirrors.

use super::{NUMBERS, Receiver, WORKGROUPS_PER_ROW, finish_dispatch};
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Device, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::trace::{self, Counters, TraceScene, TraceStatistics, TraceTables, stream_seed};

gpu_struct! {
    /// Parameters of `light_paths/near`.
    pub(crate) struct NearParams {
        pub seed: u32,
        pub sensors: u32,
        pub samples: u32,
        pub bins: u32,
        pub window_count: u32,
        pub unit: f32,
        pub batches: u32,
        /// Most diffuse reflections of a path.
        pub most_bounces: u32,
        pub near_radius: f32,
        pub roulette_weight: f32,
        /// Whether images of the windows in plane mirrors are left out.
        pub images: u32,
        /// Receivers from one batch to the next; 0 if all batches share them.
        pub batch_stride: u32,
    }
}

/// Bound on what one path of `light_paths/near` may add to one cell, sr.
const NEAR_BOUND: f64 = 64.0;

crate::gpu_constants! {
    pub(crate) const LOOKS = {
        /// Units of a weight in `looks` of `light_paths/near` and `image_matrix/receivers`.
        pub(crate) const LOOK_UNITS: f64 = 256.0;
    }
}

/// The kernel of [`near_paths`].
pub(crate) const NEAR: Shader = trace::shader("light_paths/near", &[LOOKS, NUMBERS, &[NearParams::DECLARED, Receiver::DECLARED]]);

/// How the paths from receivers are sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NearOptions {
    /// Paths per receiver and batch.
    pub samples: u32,
    /// Batches.
    pub batches: u32,
    /// Radiance's `-ab`.
    pub bounces: Option<u32>,
    /// Seed of the matrix.
    pub seed: u32,
    /// Connections shorter than this are theirs.
    pub near_radius: f32,
    /// Weight below which Russian roulette decides.
    pub roulette_weight: f32,
    /// Whether every batch has its own receivers.
    pub receivers_per_batch: bool,
    /// Whether the windows' images in plane mirrors have rays of their own.
    pub images: bool,
}

/// What paths from receivers found.
pub(crate) struct NearPaths {
    /// Irradiance coefficients that the light paths leave out, `[batch][receiver][bin][rgb]`, sr.
    pub sums: Vec<f32>,
    /// `[batch][receiver]`: rays that left a reflection, those of them that met a window, the sum of their
    /// weights.
    pub(super) looks: Vec<[u32; 3]>,
}

/// Paths from `count` receivers.
///
/// # Errors
/// If the device fails or loses paths.
pub(crate) fn near_paths(
    device: &Device,
    (tables, scene): (&TraceTables, &TraceScene),
    kernel: &Kernel,
    options: &NearOptions,
    (receivers, count): (&Buffer, usize),
    statistics: &mut TraceStatistics,
) -> Result<NearPaths> {
    let bins = tables.bins();
    let params = NearParams {
        seed: stream_seed(options.seed, 0, 0x6e65_6172),
        sensors: count as u32,
        samples: options.samples,
        bins: bins as u32,
        window_count: tables.windows.len() as u32,
        unit: (f64::from(u32::MAX) / (NEAR_BOUND * f64::from(options.samples))) as f32,
        batches: options.batches,
        most_bounces: options.bounces.map_or(u32::MAX, |b| b.saturating_sub(1)),
        near_radius: options.near_radius,
        roulette_weight: options.roulette_weight,
        images: u32::from(options.images),
        batch_stride: if options.receivers_per_batch { count as u32 } else { 0 },
    };
    let what = "short connections of the view matrix";
    let params = device.uniform(what, &params)?;
    let sums = device.zeros::<u32>(what, options.batches as usize * count * bins * 3)?;
    let counters = device.zeros::<Counters>("path counters", 1)?;
    let looks = device.zeros::<[u32; 3]>(what, options.batches as usize * count)?;
    let own = [("params", &params), ("sensors", receivers), ("sums", &sums), ("looks", &looks), ("counters", &counters)];
    let bind = kernel.bind(&scene.bindings(&own))?;
    let paths = u64::from(options.samples) * count as u64;
    let too_many = || Error::new(format!("{count} receivers with {} paths each are too many at once", options.samples));
    let groups = u32::try_from(paths).map_err(|_| too_many())?.div_ceil(64);
    device.dispatch(kernel, &bind, [groups.min(WORKGROUPS_PER_ROW), groups.div_ceil(WORKGROUPS_PER_ROW), options.batches])?;
    let started = paths * u64::from(options.batches);
    finish_dispatch(device, &counters, started, what, statistics)?;
    let scale = NEAR_BOUND / f64::from(u32::MAX);
    let sums = device.read::<u32>(&sums)?.into_iter().map(|units| (f64::from(units) * scale) as f32).collect();
    Ok(NearPaths { sums, looks: device.read(&looks)? })
}

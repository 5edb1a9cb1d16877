//! Daylight matrix D: how much of each sky patch each bin of a window sees.
//!
//! `D[bin][patch]` is the radiance that the window receives in a bin when the patch has radiance 1
//! (dimensionless; what `rfluxmtx` computes with the window as sender). Row sums are 1 when
//! nothing absorbs. Patch 0 is the ground below the horizon.

#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;
pub mod unobstructed;

use crate::bins::ReinhartSky;
use crate::error::{Error, Result};
use crate::gpu::{Device, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::trace::{
    self, CELL_CAPACITY, Counters, ROULETTE_WEIGHT, TraceStatistics, TraceTables, TracedBatch, TracedMatrix, WindowSurfaces,
    check_finished, doubt,
};
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::scene::{Scene, Window};

gpu_struct! {
    /// Parameters of `daylight_matrix/paths`.
    pub(crate) struct DaylightParams {
        seed: u32,
        /// First path index of this dispatch and paths per bin in it.
        first_path: u32,
        paths: u32,
        /// Bins of the window, and its index.
        bins: u32,
        window: u32,
        /// Sky patches with the ground.
        sky_bins: u32,
        sky_rows: u32,
        /// Most diffuse reflections of a path.
        most_bounces: u32,
        /// Fixed-point units of a whole path.
        unit: f32,
        /// Weight below which Russian roulette decides.
        roulette_weight: f32,
        row_height: f32,
        padding: u32,
    }
}

gpu_struct! {
    /// A row of sky patches, or the zenith cap (one patch). The last entry of the table is a sentinel
    /// whose lower limit is above the zenith.
    pub(crate) struct SkyRow {
        /// Sine of the lower altitude limit.
        sin_low: f32,
        first: u32,
        patches: u32,
        padding: u32,
    }
}

/// How much to sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DaylightOptions {
    /// Radiance's `-ab`: most diffuse reflections of a path; `None` does not truncate.
    pub bounces: Option<u32>,
    /// Paths per bin and batch (Radiance's `-c` is this times `batches`).
    pub paths: u32,
    /// Independent repetitions; their spread gives the standard error. At least 2.
    pub batches: u32,
    /// Same seed, same device: same bits.
    pub seed: u32,
    /// Path weight below which Russian roulette decides (Radiance's `-lw`).
    pub roulette_weight: f32,
    /// Whether the batches themselves are handed back too.
    pub keep_batches: bool,
    /// Whether this is the first, or only, of the rounds that are averaged: it has the doubts (see
    /// [`doubt`]).
    pub first_round: bool,
    /// What the window itself is to light that comes back to it from outside: it absorbs, or is a hole as the
    /// senders of rfluxmtx are, so that this light goes on in the room behind, as if there were no glazing.
    pub own_window: WindowSurfaces,
}

impl Default for DaylightOptions {
    fn default() -> Self {
        Self {
            bounces: None,
            paths: 2048,
            batches: 8,
            seed: 1,
            roulette_weight: ROULETTE_WEIGHT,
            keep_batches: false,
            first_round: true,
            own_window: WindowSurfaces::Absorb,
        }
    }
}

/// Paths per bin in one dispatch: bounds the fixed-point sums and the time of a dispatch.
const PATHS_PER_DISPATCH: u32 = 1 << 14;

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<Shader> {
    vec![PATHS]
}

const PATHS: Shader = trace::shader("daylight_matrix/paths", &[&[DaylightParams::DECLARED, SkyRow::DECLARED]]);

/// Rows of the sky for the shader: the Reinhart rows, the zenith cap, and a sentinel.
pub(crate) fn sky_rows(sky: ReinhartSky) -> Vec<SkyRow> {
    let height = sky.row_height();
    let mut rows: Vec<SkyRow> = sky
        .rows()
        .enumerate()
        .map(|(row, (first, patches))| SkyRow {
            sin_low: (row as f64 * height).sin() as f32,
            first: first as u32,
            patches: patches as u32,
            padding: 0,
        })
        .collect();
    let zenith = sky.len() as u32 - 1;
    rows.push(SkyRow { sin_low: (rows.len() as f64 * height).sin() as f32, first: zenith, patches: 1, padding: 0 });
    rows.push(SkyRow { sin_low: 2.0, first: zenith, patches: 1, padding: 0 });
    rows
}

/// Computes D for one window: rows the window's bins, columns the sky's bins with the ground
/// first, RGB. All windows of the scene absorb what meets them ([`scene::windows`](crate::scene::windows)), also
/// the window itself unless the options say otherwise; Radiance, whose senders are not part of the scene, has
/// holes there.
///
/// # Errors
/// If the window has no area, the device fails or loses paths, or when stopped by `progress`.
pub fn compute(
    device: &Device,
    scene: &Scene,
    window: &Window,
    sky: ReinhartSky,
    options: &DaylightOptions,
    progress: &dyn Progress,
) -> Result<TracedMatrix> {
    compute_in_dispatches(device, scene, std::slice::from_ref(window), sky, options, PATHS_PER_DISPATCH, progress)
}

/// D of the parts of one window, rows the bins of one part after the other. The options' paths are those of a
/// part's bins. All parts stop what meets them, as the window does.
///
/// # Errors
/// As [`compute`]; parts of different bases.
pub fn compute_of_parts(
    device: &Device,
    scene: &Scene,
    parts: &[Window],
    sky: ReinhartSky,
    options: &DaylightOptions,
    progress: &dyn Progress,
) -> Result<TracedMatrix> {
    compute_in_dispatches(device, scene, parts, sky, options, PATHS_PER_DISPATCH, progress)
}

/// As [`compute_of_parts`], with at most `paths_per_dispatch` paths per bin at a time, which changes nothing
/// in the result. At most [`PATHS_PER_DISPATCH`].
fn compute_in_dispatches(
    device: &Device,
    scene: &Scene,
    parts: &[Window],
    sky: ReinhartSky,
    options: &DaylightOptions,
    paths_per_dispatch: u32,
    progress: &dyn Progress,
) -> Result<TracedMatrix> {
    if options.batches < 2 || options.paths == 0 {
        return Err(Error::new("at least two batches of at least one path are needed"));
    }
    if parts.iter().any(|p| p.basis != parts[0].basis) {
        return Err(Error::new("the parts of a window have different bases"));
    }
    let tables = TraceTables::new(scene, parts, options.own_window)?;
    let trace_scene = tables.upload(device)?;
    let components: usize = if tables.features.grey { 1 } else { 3 };
    let kernel = Kernel::new(device, &PATHS, &[("COMPONENTS", components as f64)])?;
    let rows = device.upload("sky rows", &sky_rows(sky))?;
    // Rows of a part, and of all.
    let bins = parts[0].basis.len();
    let all_bins = parts.len() * bins;
    let cells = bins * sky.len() * components;
    let sums_buffer = device.zeros::<u32>("daylight sums", 2 * cells)?;
    let counters = device.zeros::<Counters>("path counters", 1)?;
    // Means of batches: sum and sum of squares of the total, sum of the direct part.
    let mut sum = vec![0.0f64; parts.len() * cells];
    let mut squares = vec![0.0f64; parts.len() * cells];
    let mut direct_sum = vec![0.0f64; parts.len() * cells];
    // Sums of a batch of a part, and the work so far.
    let mut state = (vec![0u64; 2 * cells], TraceStatistics::default());
    let mut batches = Vec::new();
    let fill = |to: &mut [f32], f: &dyn Fn(usize) -> f64| {
        for (element, out) in to.chunks_exact_mut(3).enumerate() {
            for (c, v) in out.iter_mut().enumerate() {
                *v = f(element * components + c.min(components - 1)) as f32;
            }
        }
    };
    let shape = |f: &dyn Fn(usize) -> f64| -> Matrix<f32> {
        let mut m = Matrix::zeros(all_bins, sky.len(), 3);
        fill(m.data_mut(), f);
        m
    };
    let unit = CELL_CAPACITY / PATHS_PER_DISPATCH.min(options.paths) as f32;
    let whole = f64::from(unit) * f64::from(options.paths);
    let work = f64::from(options.batches) * f64::from(options.paths) * parts.len() as f64;
    for (batch, part) in (0..options.batches).flat_map(|batch| (0..parts.len()).map(move |part| (batch, part))) {
        // Each part has random numbers of its own.
        let seed = options.seed.wrapping_add((part as u32).wrapping_mul(0x27d4_eb2f));
        let mut make = |(batch_cells, statistics): &mut (Vec<u64>, TraceStatistics)| {
            batch_cells.fill(0);
            for first_path in (0..options.paths).step_by(paths_per_dispatch as usize) {
                let before = f64::from(batch) * parts.len() as f64 + part as f64;
                progress.update("daylight matrix", (before * f64::from(options.paths) + f64::from(first_path)) / work);
                if progress.stop_requested() {
                    return Err(cancelled());
                }
                let paths = paths_per_dispatch.min(options.paths - first_path);
                let params = DaylightParams {
                    seed: crate::kernels::trace::stream_seed(seed, batch, 0x6461_796c),
                    first_path,
                    paths,
                    bins: bins as u32,
                    window: part as u32,
                    sky_bins: sky.len() as u32,
                    sky_rows: (sky.rows().count() + 1) as u32,
                    most_bounces: options.bounces.unwrap_or(u32::MAX),
                    unit,
                    roulette_weight: options.roulette_weight,
                    row_height: sky.row_height() as f32,
                    padding: 0,
                };
                let params = device.uniform("daylight parameters", &params)?;
                device.write(&counters, &[Counters::default()])?;
                device.write(&sums_buffer, &vec![0u32; 2 * cells])?;
                let bind = kernel.bind(&trace_scene.bindings(&[
                    ("params", &params),
                    ("sky_rows", &rows),
                    ("sums", &sums_buffer),
                    ("counters", &counters),
                ]))?;
                device.dispatch(&kernel, &bind, [paths.div_ceil(64), bins as u32, 1])?;
                let found = device.read::<Counters>(&counters)?[0];
                let started = u64::from(paths) * bins as u64;
                check_finished(&found, started, "daylight paths")?;
                statistics.paths += started;
                statistics.segments += u64::from(found.segments);
                for (cell, &units) in batch_cells.iter_mut().zip(&device.read::<u32>(&sums_buffer)?) {
                    *cell += u64::from(units);
                }
            }
            Ok(())
        };
        let unit_name = format!("batch {batch} of part {part}");
        trace::unit(progress, &unit_name, &mut state, &mut make, &|(cells, statistics), values| {
            values.pass(cells)?;
            values.pass_work(statistics)
        })?;
        let batch_cells = &state.0;
        let direct = |cell: usize| batch_cells[cell] as f64 / whole;
        let total = |cell: usize| direct(cell) + batch_cells[cells + cell] as f64 / whole;
        for (cell, at) in (part * cells..(part + 1) * cells).enumerate() {
            let total = total(cell);
            direct_sum[at] += direct(cell);
            sum[at] += total;
            squares[at] += total * total;
        }
        if options.keep_batches {
            if part == 0 {
                let none = || Matrix::zeros(all_bins, sky.len(), 3);
                batches.push(TracedBatch { total: none(), direct: none(), sunlit: None });
            }
            let values = bins * sky.len() * 3;
            let rows = part * values..(part + 1) * values;
            let kept: &mut TracedBatch = &mut batches[batch as usize];
            fill(&mut kept.total.data_mut()[rows.clone()], &total);
            fill(&mut kept.direct.data_mut()[rows], &direct);
        }
    }
    progress.update("daylight matrix", 1.0);
    let n = f64::from(options.batches);
    let paths = n * f64::from(options.paths);
    let row = |bin: usize| bin * sky.len() * components..(bin + 1) * sky.len() * components;
    let few = |bin: usize| {
        options.first_round && sum[row(bin)].iter().sum::<f64>() / components as f64 * f64::from(options.paths) < doubt::ENOUGH_HITS
    };
    let doubted: Vec<bool> = (0..all_bins).map(few).collect();
    // Half a path more to anywhere in the sky.
    let spread: Vec<f64> = (0..sky.len()).map(|p| doubt::half_a_hit(sky.solid_angle(p) / (4.0 * std::f64::consts::PI), paths)).collect();
    for bin in (0..all_bins).filter(|b| doubted[*b]) {
        for (batch, deviation) in batches.iter_mut().zip(doubt::pattern(doubt::Part::OTHERS + bin, options.batches as usize)) {
            for (patch, error) in spread.iter().enumerate() {
                batch.total.at_mut(bin, patch).iter_mut().for_each(|v| *v = (f64::from(*v) + error * deviation) as f32);
            }
        }
    }
    let doubt_of = |i: usize| {
        let element = i / components;
        if doubted[element / sky.len()] { spread[element % sky.len()] } else { 0.0 }
    };
    Ok(TracedMatrix {
        total: shape(&|i| sum[i] / n),
        direct: shape(&|i| direct_sum[i] / n),
        standard_error: shape(&|i| {
            let spread = (squares[i] / n - (sum[i] / n).powi(2)).max(0.0) / (n - 1.0);
            (spread + doubt_of(i).powi(2)).sqrt()
        }),
        batches,
        statistics: state.1,
    })
}

//! View matrix V: what each sensor receives from each bin of each window.
//!
//! `V[sensor][bin]` is the irradiance at the sensor when the windows emit radiance 1 into the
//! directions of that bin (sr; what `rfluxmtx -I+` computes). Four unbiased parts, each with the
//! estimator that suits it:
//!
//! | part | estimator | shader |
//! |---|---|---|
//! | direct from the window | quadrature, times the visible share found by rays | `view_matrix/direct` |
//! | reflected in the room | light paths from each bin, whose diffuse vertices serve *all* sensors (instant radiosity) | `light_paths/paths`, `view_matrix/gather` |
//! | the windows' images in plane smooth surfaces, by one reflection | quadrature from the sensor's image | `light_paths/images` |
//! | what these must leave out: very short connections, other mirrors seen by the sensor | paths from the sensor | `light_paths/near` |
//!
//! All of it is repeated in independently scrambled batches; their spread is the standard error.

mod doubts;
mod gathered;
#[cfg(test)]
mod image_tests;
mod options;
#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;
mod unobstructed;

use crate::error::{Error, Result};
use crate::gpu::{Buffer, Device, Kernel, Plan, Shader};
use crate::gpu_struct;
use crate::kernels::light_paths::images::{ReceiverPoint, WindowImages};
use crate::kernels::light_paths::{
    LightPathKernels, NEAR, NearOptions, Receiver, Rounds, VirtualLight, beside_surface, check_sensors, finish_dispatch, near_paths, reach,
};
use crate::kernels::trace::{
    self, CELL_CAPACITY, Counters, TraceScene, TraceStatistics, TraceTables, TracedBatch, TracedMatrix, WindowSurfaces, doubt,
};
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::scene::points::Sensor;
use crate::scene::{Scene, Window};
use glam::Vec3;
use rayon::prelude::*;

pub use options::ViewOptions;

gpu_struct! {
    /// Parameters of `view_matrix/gather`.
    pub(crate) struct GatherParams {
        seed: u32,
        sensors: u32,
        bins: u32,
        /// Lights per bin and batch.
        lights: u32,
        batches: u32,
        near_radius: f32,
        padding_number: u32,
        padding: u32,
    }
}

gpu_struct! {
    /// Parameters of `view_matrix/direct`.
    pub(crate) struct DirectParams {
        seed: u32,
        sensors: u32,
        samples: u32,
        bins: u32,
        window_count: u32,
        /// Fixed-point units per sample and full window.
        unit: f32,
        batches: u32,
        padding_number: u32,
    }
}

crate::gpu_constants! {
    pub(crate) const NUMBERS = {
        /// Most rays from a sensor to the vertices of one bin.
        pub(crate) const MOST_VISIBILITY_RAYS: u32 = 32;
    }
}

/// Rays to each image of the windows, at least.
const LEAST_IMAGE_RAYS: u32 = 16;
/// Bounds the loops of `view_matrix/gather`.
pub(crate) const MOST_LIGHT_PATHS: u32 = 1 << 13;

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<Shader> {
    vec![GATHER, DIRECT]
}

const GATHER: Shader =
    trace::shader("view_matrix/gather", &[NUMBERS, &[GatherParams::DECLARED, Receiver::DECLARED, VirtualLight::DECLARED]]);
const DIRECT: Shader = trace::shader("view_matrix/direct", &[&[DirectParams::DECLARED, Receiver::DECLARED]]);

/// Computes V for `sensors` and all `windows` in one pass: rows sensors, columns the windows' bins
/// one window after the other, RGB.
///
/// # Errors
/// If there is no window or a sensor has no direction, if the device fails or loses paths, or when
/// stopped by `progress`.
pub fn compute(
    device: &Device,
    scene: &Scene,
    windows: &[Window],
    sensors: &[Sensor],
    options: &ViewOptions,
    progress: &dyn Progress,
) -> Result<TracedMatrix> {
    check_sensors(sensors)?;
    if options.batches < 2 {
        return Err(Error::new("at least two batches are needed for a standard error"));
    }
    if !(1..=MOST_VISIBILITY_RAYS).contains(&options.visibility_rays) || !(1..=MOST_LIGHT_PATHS).contains(&options.light_paths) {
        return Err(Error::new(format!(
            "{} light paths and {} visibility rays per batch are outside what is possible",
            options.light_paths, options.visibility_rays
        ))
        .help(format!(
            "light paths 1 to {MOST_LIGHT_PATHS}, visibility rays 1 to {MOST_VISIBILITY_RAYS}; use more batches for more samples"
        )));
    }
    let tables = TraceTables::new(scene, windows, WindowSurfaces::Absorb)?;
    let tracer = ViewTracer::new(device, windows, tables, options)?;
    let bins = tracer.tables.bins();
    let (rows, batches) = (sensors.len(), options.batches as usize);
    let empty = TracedBatch { total: Matrix::zeros(rows, bins, 3), direct: Matrix::zeros(rows, bins, 3), sunlit: None };
    let mut result = TracedMatrix {
        total: Matrix::zeros(rows, bins, 3),
        direct: Matrix::zeros(rows, bins, 3),
        standard_error: Matrix::zeros(rows, bins, 3),
        batches: if options.keep_batches { vec![empty; batches] } else { Vec::new() },
        statistics: TraceStatistics::default(),
    };
    let bytes_per_sensor = (batches * bins * 12) as u64;
    let plan = Plan::new(
        device,
        options.memory,
        rows,
        &[bytes_per_sensor / 3 * 4, bytes_per_sensor, bytes_per_sensor / 3 * doubts::GATHERED as u64],
        &[],
        1,
    )?
    .at_most(options.sensors_at_once(bins));
    let mut done = 0;
    for chunk in plan.chunks() {
        let range = chunk.first..chunk.first + chunk.count;
        let stage = |part: f64| {
            progress.update("view matrix", (done as f64 + part * chunk.count as f64) / rows as f64);
            if progress.stop_requested() { Err(cancelled()) } else { Ok(()) }
        };
        let mut make = |result: &mut TracedMatrix| tracer.compute_tile(&sensors[range.clone()], range.start, result, &stage);
        trace::unit(progress, &format!("sensors {range:?}"), &mut result, &mut make, &|result, values| values.pass_traced(result, &range))?;
        done += chunk.count;
    }
    progress.update("view matrix", 1.0);
    Ok(result)
}

struct ViewTracer<'d> {
    device: &'d Device,
    tables: TraceTables,
    windows: &'d [Window],
    scene: TraceScene,
    options: ViewOptions,
    light_paths: LightPathKernels,
    rounds: Rounds,
    gather: Kernel,
    direct: Kernel,
    near: Kernel,
    /// Where there are plane mirrors.
    images: Option<WindowImages>,
    counters: Buffer,
}

impl<'d> ViewTracer<'d> {
    fn new(device: &'d Device, windows: &'d [Window], tables: TraceTables, options: &ViewOptions) -> Result<Self> {
        let scene = tables.upload(device)?;
        let glass = [("HAS_GLASS", f64::from(u8::from(tables.features.glass)))];
        Ok(Self {
            device,
            windows,
            scene,
            options: *options,
            light_paths: LightPathKernels::new(device)?,
            rounds: Rounds::of(device, &tables, options.batches, options.light_paths),
            gather: Kernel::new(device, &GATHER, &[glass[0], ("RAYS", f64::from(options.visibility_rays))])?,
            direct: Kernel::new(device, &DIRECT, &glass)?,
            near: Kernel::new(device, &NEAR, &glass)?,
            images: WindowImages::new(device, &tables, options.seed, options.direct_samples, LEAST_IMAGE_RAYS)?,
            counters: device.zeros::<Counters>("path counters", 1)?,
            tables,
        })
    }

    /// One tile of sensors; `first` is the number of its first sensor.
    fn compute_tile(&self, sensors: &[Sensor], first: usize, result: &mut TracedMatrix, stage: &dyn Fn(f64) -> Result<()>) -> Result<()> {
        let corners = || self.windows.iter().flat_map(|w| w.triangles.iter().flatten());
        let records: Vec<Receiver> = sensors
            .iter()
            .enumerate()
            .map(|(i, s)| Receiver {
                position: beside_surface(self.tables.normalization.point(s.position), s.direction.normalize().as_vec3()).to_array(),
                number: (first + i) as u32,
                normal: s.direction.normalize().as_vec3().to_array(),
                role: reach(
                    &self.tables,
                    corners(),
                    s.position,
                    (self.options.light_paths, self.options.batches),
                    self.options.near_radius,
                )
                .to_bits(),
            })
            .collect();
        let sensors_buffer = self.device.upload("sensors", &records)?;
        let bins = self.tables.bins();
        let batches = self.options.batches as usize;
        let cells = batches * records.len() * bins * doubts::GATHERED;
        stage(0.0)?;
        let direct = self.direct_part(&sensors_buffer, sensors, &mut result.statistics)?;
        stage(0.1)?;
        let reflected = self.options.bounces.is_none_or(|b| b > 1);
        let (gathered, near) = if reflected || self.tables.features.specular {
            let near_options = NearOptions {
                samples: self.options.near_samples,
                batches: self.options.batches,
                bounces: self.options.bounces,
                seed: self.options.seed,
                near_radius: self.options.near_radius,
                roulette_weight: self.options.roulette_weight,
                receivers_per_batch: false,
                images: self.images.is_some(),
            };
            let receivers = (&sensors_buffer, records.len());
            let mut near =
                near_paths(self.device, (&self.tables, &self.scene), &self.near, &near_options, receivers, &mut result.statistics)?;
            let mut open = vec![0.0; records.len()];
            if let Some(images) = &self.images {
                let receiver_point = |(row, (s, r)): (usize, (&Sensor, &Receiver))| ReceiverPoint {
                    row,
                    batches: 0..self.options.batches,
                    position: s.position,
                    normal: s.direction.normalize(),
                    start: Vec3::from_array(r.position),
                    number: r.number,
                };
                let receiver_points: Vec<ReceiverPoint> = sensors.iter().zip(&records).enumerate().map(receiver_point).collect();
                let sums = (&mut near.sums[..], records.len());
                open =
                    images.add(self.device, (&self.tables, &self.scene), self.windows, &receiver_points, sums, &mut result.statistics)?;
            }
            self.doubt_reflections(&mut near, &open);
            stage(0.2)?;
            let gathered =
                if reflected { Some(self.gathered_part(&sensors_buffer, &records, cells, &mut result.statistics, stage)?) } else { None };
            (gathered, Some(near.sums))
        } else {
            (None, None)
        };
        let mut values = vec![0.0f64; batches];
        let paths = f64::from(self.rounds.all());
        let pattern = doubt::pattern(doubt::Part::GATHERED, batches);
        for sensor in 0..records.len() {
            let open = gathered.as_ref().and_then(|g| self.doubt_of_gathered(g, sensor, records.len()));
            for bin in 0..bins {
                for c in 0..3 {
                    let mut sum_of_direct = 0.0;
                    for (batch, value) in values.iter_mut().enumerate() {
                        let cell = ((batch * records.len() + sensor) * bins + bin) * 3 + c;
                        let seen = direct[cell];
                        sum_of_direct += seen;
                        *value = seen;
                        if let Some(near) = &near {
                            *value += f64::from(near[cell]);
                        }
                        if let Some(gathered) = &gathered {
                            let cell = ((batch * bins + bin) * records.len() + sensor) * doubts::GATHERED + c;
                            *value += (f64::from(gathered[cell]) + open.as_ref().map_or(0.0, |o| o[bin] * pattern[batch])) / paths;
                        }
                        if let Some(kept) = result.batches.get_mut(batch) {
                            kept.total.at_mut(first + sensor, bin)[c] = *value as f32;
                            kept.direct.at_mut(first + sensor, bin)[c] = seen as f32;
                        }
                    }
                    let (mean, error) = mean_and_error(&values);
                    // Doubts alone: what their sum's rounding leaves is no light.
                    let cleaned = |value: f64| if value.abs() < 1e-12 * error { 0.0 } else { value };
                    let (mean, direct) = (cleaned(mean), cleaned(sum_of_direct / batches as f64));
                    result.total.at_mut(first + sensor, bin)[c] = mean as f32;
                    result.direct.at_mut(first + sensor, bin)[c] = (direct as f32).min(mean as f32);
                    result.standard_error.at_mut(first + sensor, bin)[c] = error as f32;
                }
            }
        }
        Ok(())
    }

    /// The direct part per batch, `[batch][sensor][bin][rgb]`: exact unobstructed values times the
    /// visible share.
    fn direct_part(&self, buffer: &Buffer, sensors: &[Sensor], statistics: &mut TraceStatistics) -> Result<Vec<f64>> {
        let o = &self.options;
        let bins = self.tables.bins();
        let params = DirectParams {
            seed: o.seed,
            sensors: sensors.len() as u32,
            samples: o.direct_samples,
            bins: bins as u32,
            window_count: self.tables.windows.len() as u32,
            unit: CELL_CAPACITY / o.direct_samples as f32,
            batches: o.batches,
            padding_number: 0,
        };
        let batches = o.batches as usize;
        let cells = batches * sensors.len() * bins * 4;
        let sums =
            self.sampled_part(&self.direct, &params, "direct view matrix", buffer, sensors.len(), o.direct_samples, cells, statistics)?;
        let exact: Vec<Vec<f64>> = sensors.par_iter().map(|s| self.unobstructed_row(s)).collect();
        let mut direct = vec![0.0; batches * sensors.len() * bins * 3];
        // A single window in an empty scene: its own triangles are all there is.
        let free = self.windows.len() == 1 && self.tables.triangles.len() <= self.windows[0].triangles.len();
        for (sensor, exact) in exact.iter().enumerate() {
            let row = doubts::DirectRow::new(&sums, (sensor, sensors.len()), batches, bins, &self.tables.windows, free);
            for (bin, &value) in exact.iter().enumerate().filter(|(_, value)| **value > 0.0) {
                for batch in 0..batches {
                    let cell = ((batch * sensors.len() + sensor) * bins + bin) * 3;
                    for c in 0..3 {
                        direct[cell + c] = value * row.share(batch, bin, c);
                    }
                }
            }
            if o.first_round {
                for (bin, deviations) in row.doubts(exact, f64::from(o.direct_samples)) {
                    for (batch, deviation) in deviations.into_iter().enumerate() {
                        let cell = ((batch * sensors.len() + sensor) * bins + bin) * 3;
                        direct[cell..cell + 3].iter_mut().for_each(|v| *v += deviation);
                    }
                }
            }
        }
        Ok(direct)
    }

    fn unobstructed_row(&self, sensor: &Sensor) -> Vec<f64> {
        let mut row = vec![0.0; self.tables.bins()];
        let normal = sensor.direction.normalize();
        for (window, record) in self.windows.iter().zip(&self.tables.windows) {
            let bins = record.first_bin as usize..(record.first_bin + record.bins) as usize;
            unobstructed::add_unobstructed_row(window, sensor.position, normal, &mut row[bins]);
        }
        row
    }

    /// Runs a kernel of one invocation per sample, sensor and batch, and reads its fixed-point sums.
    #[allow(clippy::too_many_arguments, reason = "private; each is a different thing")]
    fn sampled_part<P: bytemuck::NoUninit>(
        &self,
        kernel: &Kernel,
        params: &P,
        what: &str,
        sensors: &Buffer,
        count: usize,
        samples: u32,
        cells: usize,
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<u32>> {
        let params = self.device.uniform(what, params)?;
        let sums = self.device.zeros::<u32>(what, cells)?;
        self.device.write(&self.counters, &[Counters::default()])?;
        let own = [("params", &params), ("sensors", sensors), ("sums", &sums), ("counters", &self.counters)];
        let bind = kernel.bind(&self.scene.bindings(&own))?;
        self.device.dispatch(kernel, &bind, [samples.div_ceil(64), count as u32, self.options.batches])?;
        let started = u64::from(samples) * count as u64 * u64::from(self.options.batches);
        finish_dispatch(self.device, &self.counters, started, what, statistics)?;
        self.device.read(&sums)
    }
}

/// Mean of independent batches and the standard error of that mean.
pub(crate) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    (mean, (variance / n).sqrt())
}

//! Tracing of the coefficients, tile by tile.

use super::doubts::Looks;
use super::{CoefficientOptions, CoefficientParams, DIRECT, PATHS};
use crate::bins::ReinhartSky;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Device, Kernel};
use crate::kernels::daylight_matrix::sky_rows;
use crate::kernels::light_paths::{Receiver, WORKGROUPS_PER_ROW, finish_dispatch};
use crate::kernels::trace::{Counters, FAR_AWAY, TraceScene, TraceStatistics, TraceTables, TracedMatrix, stream_seed};
use crate::kernels::view_matrix::{beside_surface, mean_and_error};
use crate::scene::points::Sensor;

/// Bound on what one sample may add to a cell, sr.
const BOUND: f64 = 64.0;

pub(super) struct Tracer<'d> {
    device: &'d Device,
    tables: TraceTables,
    scene: TraceScene,
    options: CoefficientOptions,
    sky: ReinhartSky,
    windows: usize,
    direct: Kernel,
    paths: Kernel,
    rows: Buffer,
    counters: Buffer,
    components: usize,
}

/// A kernel of one invocation per sample, sensor and batch.
struct Pass<'k> {
    kernel: &'k Kernel,
    /// Of its random numbers.
    purpose: u32,
    /// Per sensor and batch.
    samples: u32,
    workgroups: [u32; 3],
}

/// Sums of one kernel for a tile, sr: `[direct or other][batch][sensor][patch][component]`.
struct Sums {
    units: Vec<u32>,
    /// sr per unit and sample.
    scale: f64,
}

impl<'d> Tracer<'d> {
    pub fn new(device: &'d Device, tables: TraceTables, windows: usize, sky: ReinhartSky, options: &CoefficientOptions) -> Result<Self> {
        let components = if tables.features.grey { 1 } else { 3 };
        let constants = [("HAS_GLASS", f64::from(u8::from(tables.features.glass))), ("COMPONENTS", components as f64)];
        Ok(Self {
            device,
            scene: tables.upload(device)?,
            options: *options,
            sky,
            windows,
            direct: Kernel::new(device, &DIRECT, &constants)?,
            paths: Kernel::new(device, &PATHS, &constants)?,
            rows: device.upload("sky rows", &sky_rows(sky))?,
            counters: device.zeros::<Counters>("path counters", 1)?,
            components,
            tables,
        })
    }

    /// Of the sums of one kernel.
    pub fn bytes_per_sensor(&self) -> u64 {
        2 * u64::from(self.options.batches) * (self.sky.len() * self.components * 4) as u64
    }

    /// One tile of sensors; `first` is the number of its first sensor.
    pub fn compute_tile(
        &self,
        sensors: &[Sensor],
        first: usize,
        result: &mut TracedMatrix,
        stage: &dyn Fn(f64) -> Result<()>,
    ) -> Result<Vec<Looks>> {
        let records: Vec<Receiver> = sensors
            .iter()
            .enumerate()
            .map(|(i, s)| Receiver {
                position: beside_surface(self.tables.normalization.point(s.position), s.direction.normalize().as_vec3()).to_array(),
                number: (first + i) as u32,
                normal: s.direction.normalize().as_vec3().to_array(),
                role: 0,
            })
            .collect();
        let (count, o) = (records.len(), &self.options);
        let receivers = self.device.upload("sensors", &records)?;
        let mut looks = vec![Looks::default(); count];
        let mut parts = Vec::new();
        stage(0.0)?;
        if self.windows > 0 {
            let of_windows = self.device.zeros::<[u32; 3]>("looks at the windows", count)?;
            let workgroups = [o.direct_samples.div_ceil(64), count as u32, o.batches];
            let pass = Pass { kernel: &self.direct, purpose: 0x7769_6e64, samples: o.direct_samples, workgroups };
            parts.push(self.sampled(&pass, (&receivers, count), &of_windows, &mut result.statistics)?);
            looks.iter_mut().zip(self.device.read::<[u32; 3]>(&of_windows)?).for_each(|(l, found)| l.straight = found);
        }
        stage(0.2)?;
        let of_paths = self.device.zeros::<[u32; 4]>("looks of paths", count)?;
        let paths = u64::from(o.near_samples) * count as u64;
        let too_many = || Error::new(format!("{count} sensors with {} paths each are too many at once", o.near_samples));
        let groups = u32::try_from(paths).map_err(|_| too_many())?.div_ceil(64);
        let workgroups = [groups.min(WORKGROUPS_PER_ROW), groups.div_ceil(WORKGROUPS_PER_ROW), o.batches];
        let pass = Pass { kernel: &self.paths, purpose: 0x7061_7468, samples: o.near_samples, workgroups };
        parts.push(self.sampled(&pass, (&receivers, count), &of_paths, &mut result.statistics)?);
        looks.iter_mut().zip(self.device.read::<[u32; 4]>(&of_paths)?).for_each(|(l, found)| l.by_paths = found);
        stage(0.95)?;
        self.collect(&parts, first, count, result);
        Ok(looks)
    }

    fn sampled(
        &self,
        pass: &Pass<'_>,
        (receivers, count): (&Buffer, usize),
        looks: &Buffer,
        statistics: &mut TraceStatistics,
    ) -> Result<Sums> {
        let samples = pass.samples;
        let o = &self.options;
        let unit = f64::from(u32::MAX) / (BOUND * f64::from(samples));
        let params = CoefficientParams {
            seed: stream_seed(o.seed, 0, pass.purpose),
            sensors: count as u32,
            samples,
            batches: o.batches,
            patches: self.sky.len() as u32,
            window_count: self.windows as u32,
            first_pane: self.tables.first_pane().unwrap_or(0),
            most_bounces: o.bounces.map_or(u32::MAX, |b| b.saturating_sub(1)),
            unit: unit as f32,
            near_radius: FAR_AWAY as f32,
            roulette_weight: o.roulette_weight,
            open: 1,
            sky_rows: (self.sky.rows().count() + 1) as u32,
            row_height: self.sky.row_height() as f32,
            padding0: 0,
            padding1: 0,
        };
        let what = "daylight coefficients";
        let params = self.device.uniform(what, &params)?;
        let sums = self.device.zeros::<u32>(what, 2 * o.batches as usize * count * self.sky.len() * self.components)?;
        self.device.write(&self.counters, &[Counters::default()])?;
        let own = [
            ("params", &params),
            ("sky_rows", &self.rows),
            ("sums", &sums),
            ("sensors", receivers),
            ("looks", looks),
            ("counters", &self.counters),
        ];
        let bind = pass.kernel.bind(&self.scene.bindings(&own))?;
        self.device.dispatch(pass.kernel, &bind, pass.workgroups)?;
        let started = u64::from(samples) * count as u64 * u64::from(o.batches);
        finish_dispatch(self.device, &self.counters, started, what, statistics)?;
        Ok(Sums { units: self.device.read(&sums)?, scale: 1.0 / (f64::from(unit as f32) * f64::from(samples)) })
    }

    /// Puts the sums of a tile's kernels into their place.
    fn collect(&self, parts: &[Sums], first: usize, count: usize, result: &mut TracedMatrix) {
        let (batches, patches, components) = (self.options.batches as usize, self.sky.len(), self.components);
        let sum = |part: usize, batch: usize, sensor: usize, patch: usize, c: usize| -> f64 {
            let cell = (((part * batches + batch) * count + sensor) * patches + patch) * components + c;
            parts.iter().map(|p| f64::from(p.units[cell]) * p.scale).sum()
        };
        let mut values = vec![0.0; batches];
        for sensor in 0..count {
            for patch in 0..patches {
                for c in 0..components {
                    let channels = if components == 1 { 0..3 } else { c..c + 1 };
                    let mut direct_sum = 0.0;
                    for (batch, value) in values.iter_mut().enumerate() {
                        let direct = sum(0, batch, sensor, patch, c);
                        *value = direct + sum(1, batch, sensor, patch, c);
                        direct_sum += direct;
                        if let Some(kept) = result.batches.get_mut(batch) {
                            kept.total.at_mut(first + sensor, patch)[channels.clone()].fill(*value as f32);
                            kept.direct.at_mut(first + sensor, patch)[channels.clone()].fill(direct as f32);
                        }
                    }
                    let (mean, error) = mean_and_error(&values);
                    let direct = ((direct_sum / batches as f64) as f32).min(mean as f32);
                    result.total.at_mut(first + sensor, patch)[channels.clone()].fill(mean as f32);
                    result.direct.at_mut(first + sensor, patch)[channels.clone()].fill(direct);
                    result.standard_error.at_mut(first + sensor, patch)[channels].fill(error as f32);
                }
            }
        }
    }
}

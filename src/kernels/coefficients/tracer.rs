//! Tracing of the coefficients, tile by tile.

use super::doubts::Looks;
use super::{CoefficientOptions, CoefficientParams, DIRECT, Gathered, GlazedWindow, PATHS};
use crate::bins::ReinhartSky;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Device, Kernel};
use crate::kernels::daylight_matrix::sky_rows;
use crate::kernels::light_paths::{Receiver, WORKGROUPS_PER_ROW, beside_surface, finish_dispatch, reach};
use crate::kernels::trace::{Counters, FAR_AWAY, TraceScene, TraceStatistics, TraceTables, TracedMatrix, stream_seed};
use crate::kernels::view_matrix::mean_and_error;
use crate::scene::points::Sensor;

/// Bound on what one sample may add to a cell, sr.
const BOUND: f64 = 64.0;

/// Fixed-point units per sr of one sample.
pub(super) fn unit(samples: u32) -> f32 {
    (f64::from(u32::MAX) / (BOUND * f64::from(samples))) as f32
}

/// sr per unit of a sum over so many samples.
pub(super) fn scale(samples: u32) -> f64 {
    1.0 / (f64::from(unit(samples)) * f64::from(samples))
}

/// Paths of all sensors together that look for light by no window before anything else; and those of each sensor and
/// batch, at least.
const SCOUTS: u32 = 1 << 16;
const LEAST_SCOUTS: u32 = 32;

pub(super) struct Tracer<'d> {
    pub(super) device: &'d Device,
    pub(super) tables: TraceTables,
    pub(super) scene: TraceScene,
    pub(super) options: CoefficientOptions,
    sky: ReinhartSky,
    pub(super) windows: &'d [GlazedWindow],
    direct: Kernel,
    paths: Kernel,
    pub(super) rows: Buffer,
    pub(super) counters: Buffer,
    pub(super) components: usize,
    /// Light paths, where there are any.
    pub(super) gathered: Option<Gathered>,
    /// Paths per sensor and batch that look for light by no window.
    scouts: u32,
    /// Whether light may come by no window.
    open: bool,
}

/// A kernel of one invocation per sample, sensor and batch.
struct Pass<'k> {
    kernel: &'k Kernel,
    params: CoefficientParams,
    workgroups: [u32; 3],
}

/// Direct light, other, and other that light paths of suns find as well.
const PARTS: usize = 3;

/// Sums of one kernel for a tile, sr: `[part][batch][sensor][patch][component]`.
struct Sums {
    units: Vec<u32>,
    /// sr per unit and sample.
    scale: f64,
}

impl<'d> Tracer<'d> {
    pub fn new(
        device: &'d Device,
        tables: TraceTables,
        windows: &'d [GlazedWindow],
        sensors: usize,
        sky: ReinhartSky,
        options: &CoefficientOptions,
    ) -> Result<Self> {
        let components = if tables.features.grey { 1 } else { 3 };
        let constants = [("HAS_GLASS", f64::from(u8::from(tables.features.glass))), ("COMPONENTS", components as f64)];
        let reflected = options.has_light_paths(windows);
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
            gathered: if reflected { Some(Gathered::new(device, &tables, options, constants)?) } else { None },
            scouts: (SCOUTS / (sensors as u32 * options.batches).max(1)).max(LEAST_SCOUTS).min(options.near_samples),
            open: !reflected,
            tables,
        })
    }

    /// Paths of each sensor, all batches together, that look for light by no window.
    pub fn paths_to_the_sky(&self) -> f64 {
        f64::from(if self.open { self.options.near_samples } else { self.scouts } * self.options.batches)
    }

    /// Follows a few paths of each sensor to their ends: if none of any sensor meets the sky by no window, later ones
    /// need not look for it.
    pub fn look_for_holes(&mut self, sensors: &[Sensor], first: usize, statistics: &mut TraceStatistics) -> Result<()> {
        if self.open {
            return Ok(());
        }
        let receivers = self.device.upload("sensors", &self.receivers(sensors, first))?;
        let looks = self.device.zeros::<[u32; 4]>("looks of paths", sensors.len())?;
        let params = CoefficientParams { open: 1, ..self.params(0x686f_6c65, self.scouts, sensors.len()) };
        let pass = Pass { kernel: &self.paths, params, workgroups: self.path_groups(self.scouts, sensors.len())? };
        self.sampled(&pass, &receivers, &looks, statistics)?;
        self.open = self.device.read::<[u32; 4]>(&looks)?.iter().any(|l| l[2] > 0);
        Ok(())
    }

    /// The constant of shaders that tells whether rays may pass panes.
    pub(super) fn has_glass(&self) -> f64 {
        f64::from(u8::from(self.tables.features.glass))
    }

    pub(super) fn receivers(&self, sensors: &[Sensor], first: usize) -> Vec<Receiver> {
        let o = &self.options;
        let corners = || self.windows.iter().flat_map(|w| w.window.triangles.iter().flatten());
        let reach = |s: &Sensor| match self.gathered {
            Some(_) => reach(&self.tables, corners(), s.position, (o.light_paths, o.batches), o.near_radius),
            None => 1.0,
        };
        let receiver = |(i, s): (usize, &Sensor)| Receiver {
            position: beside_surface(self.tables.normalization.point(s.position), s.direction.normalize().as_vec3()).to_array(),
            number: (first + i) as u32,
            normal: s.direction.normalize().as_vec3().to_array(),
            role: reach(s).to_bits(),
        };
        sensors.iter().enumerate().map(receiver).collect()
    }

    fn path_groups(&self, samples: u32, count: usize) -> Result<[u32; 3]> {
        let paths = u64::from(samples) * count as u64;
        let too_many = || Error::new(format!("{count} sensors with {samples} paths each are too many at once"));
        let groups = u32::try_from(paths).map_err(|_| too_many())?.div_ceil(64);
        Ok([groups.min(WORKGROUPS_PER_ROW), groups.div_ceil(WORKGROUPS_PER_ROW), self.options.batches])
    }

    /// Of the sums of one kernel.
    pub fn bytes_per_sensor(&self) -> u64 {
        PARTS as u64 * u64::from(self.options.batches) * (self.sky.len() * self.components * 4) as u64
    }

    /// One tile of sensors; `first` is the number of its first sensor.
    pub fn compute_tile(
        &self,
        sensors: &[Sensor],
        first: usize,
        result: &mut TracedMatrix,
        stage: &dyn Fn(f64) -> Result<()>,
    ) -> Result<Vec<Looks>> {
        let records = self.receivers(sensors, first);
        let (count, o) = (records.len(), &self.options);
        let receivers = self.device.upload("sensors", &records)?;
        let mut looks = vec![Looks::default(); count];
        let mut parts = Vec::new();
        stage(0.0)?;
        if !self.windows.is_empty() {
            let of_windows = self.device.zeros::<[u32; 3]>("looks at the windows", count)?;
            let params = self.params(0x7769_6e64, o.direct_samples, count);
            let pass = Pass { kernel: &self.direct, params, workgroups: [o.direct_samples.div_ceil(64), count as u32, o.batches] };
            parts.push(self.sampled(&pass, &receivers, &of_windows, &mut result.statistics)?);
            looks.iter_mut().zip(self.device.read::<[u32; 3]>(&of_windows)?).for_each(|(l, found)| l.at_windows = found);
        }
        stage(0.1)?;
        let of_paths = self.device.zeros::<[u32; 4]>("looks of paths", count)?;
        let params = self.params(0x7061_7468, o.near_samples, count);
        let pass = Pass { kernel: &self.paths, params, workgroups: self.path_groups(o.near_samples, count)? };
        parts.push(self.sampled(&pass, &receivers, &of_paths, &mut result.statistics)?);
        looks.iter_mut().zip(self.device.read::<[u32; 4]>(&of_paths)?).for_each(|(l, found)| l.by_paths = found);
        stage(0.3)?;
        if let Some(gathered) = &self.gathered {
            let sums = self.device.zeros::<u32>("gathered coefficients", self.cells(count))?;
            let stage = |part: f64| stage(0.3 + 0.7 * part);
            let doubts = gathered.add(self, (&receivers, &records), &sums, &mut result.statistics, &stage)?;
            looks.iter_mut().zip(doubts).for_each(|(l, doubt)| l.gathered = doubt);
            parts.push(Sums { units: self.device.read(&sums)?, scale: scale(gathered.paths()) });
        }
        self.collect(&parts, first, count, result);
        Ok(looks)
    }

    /// Cells of the sums of one kernel.
    fn cells(&self, count: usize) -> usize {
        PARTS * self.options.batches as usize * count * self.sky.len() * self.components
    }

    /// Parameters of a kernel whose random numbers are those of this purpose.
    pub(super) fn params(&self, purpose: u32, samples: u32, count: usize) -> CoefficientParams {
        let o = &self.options;
        CoefficientParams {
            seed: stream_seed(o.seed, 0, purpose),
            sensors: count as u32,
            samples,
            batches: o.batches,
            patches: self.sky.len() as u32,
            window_count: self.windows.len() as u32,
            first_pane: self.tables.first_pane().unwrap_or(0),
            most_bounces: o.bounces.map_or(u32::MAX, |b| b.saturating_sub(1)),
            unit: unit(samples),
            near_radius: if self.gathered.is_some() { o.near_radius } else { FAR_AWAY as f32 },
            roulette_weight: o.roulette_weight,
            open: u32::from(self.open),
            sky_rows: (self.sky.rows().count() + 1) as u32,
            row_height: self.sky.row_height() as f32,
            bins: self.tables.bins() as u32,
            first_list: 0,
            room: samples,
            sunlit: 2,
            straight: 0,
            sets: 1,
        }
    }

    /// Runs a kernel of so many invocations and checks that all came to their end.
    pub(super) fn run(
        &self,
        kernel: &Kernel,
        params: &CoefficientParams,
        own: &[(&str, &Buffer)],
        (workgroups, started): ([u32; 3], u64),
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let params = self.device.uniform("parameters of coefficients", params)?;
        self.device.write(&self.counters, &[Counters::default()])?;
        let all = [own, &[("params", &params), ("counters", &self.counters)]].concat();
        let bind = kernel.bind(&self.scene.bindings(&all))?;
        self.device.dispatch(kernel, &bind, workgroups)?;
        finish_dispatch(self.device, &self.counters, started, kernel.label(), statistics)?;
        Ok(())
    }

    /// Runs a kernel of one invocation per sample, sensor and batch.
    fn sampled(&self, pass: &Pass<'_>, receivers: &Buffer, looks: &Buffer, statistics: &mut TraceStatistics) -> Result<Sums> {
        let sums = self.device.zeros::<u32>("daylight coefficients", self.cells(pass.params.sensors as usize))?;
        let own = [("sky_rows", &self.rows), ("sums", &sums), ("sensors", receivers), ("looks", looks)];
        let started = u64::from(pass.params.samples) * u64::from(pass.params.sensors) * u64::from(pass.params.batches);
        self.run(pass.kernel, &pass.params, &own, (pass.workgroups, started), statistics)?;
        Ok(Sums { units: self.device.read(&sums)?, scale: scale(pass.params.samples) })
    }

    /// Puts the sums of a tile's kernels into their place.
    fn collect(&self, parts: &[Sums], first: usize, count: usize, result: &mut TracedMatrix) {
        let (batches, patches, components) = (self.options.batches as usize, self.sky.len(), self.components);
        let cell = |part: usize, batch: usize, sensor: usize, patch: usize, c: usize| {
            (((part * batches + batch) * count + sensor) * patches + patch) * components + c
        };
        let sum = |cells: &[usize]| -> f64 {
            let of = |p: &Sums| cells.iter().map(|cell| f64::from(p.units[*cell])).sum::<f64>() * p.scale;
            parts.iter().map(of).sum()
        };
        let mut values = vec![0.0; batches];
        for sensor in 0..count {
            for patch in 0..patches {
                for c in 0..components {
                    let channels = if components == 1 { 0..3 } else { c..c + 1 };
                    let mut direct_sum = 0.0;
                    for (batch, value) in values.iter_mut().enumerate() {
                        let [direct, other, sunlit] = [0, 1, 2].map(|part| cell(part, batch, sensor, patch, c));
                        let by_suns = sum(&[sunlit]);
                        let direct = sum(&[direct]);
                        *value = direct + sum(&[other, sunlit]);
                        direct_sum += direct;
                        if let Some(kept) = result.batches.get_mut(batch) {
                            kept.total.at_mut(first + sensor, patch)[channels.clone()].fill(*value as f32);
                            kept.direct.at_mut(first + sensor, patch)[channels.clone()].fill(direct as f32);
                            if let Some(kept) = &mut kept.sunlit {
                                kept.at_mut(first + sensor, patch)[channels.clone()].fill((direct + by_suns).min(*value) as f32);
                            }
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

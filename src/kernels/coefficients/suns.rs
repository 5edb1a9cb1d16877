//! Light of suns by light paths of their own.
//!
//! A light path starts on a pane, straight from the sun or by way of surfaces outside that reflect it diffusely, and its
//! diffuse vertices in the room serve all sensors. Every sun has random numbers of its own, so errors of different suns are
//! independent.

use super::gathered::{CHANCES, Gathered, add_chances, doubt};
use super::tracer::{Tracer, scale, unit};
use super::{CoefficientOptions, CoefficientParams, GlazedWindow, MOST_PAIRS, MOST_TILE_SENSORS, STRUCTS, surfaces};
use crate::bins::ReinhartSky;
use crate::error::Result;
use crate::gpu::{Buffer, Device, Kernel, Shader};
use crate::kernels::light_paths::doubts::Chances;
use crate::kernels::light_paths::{
    Gathering, LightPathOptions, LightPaths, MOST_LIGHT_BYTES, Receiver, Rounds, VirtualLight, check_sensors, follow,
};
use crate::kernels::sun_matrix::{Sun, SunMatrix, SunRecord};
use crate::kernels::trace::{self, TraceStatistics, TraceTables, stream_seed};
use crate::kernels::view_matrix::mean_and_error;
use crate::progress::{Progress, cancelled};
use crate::scene::Scene;
use crate::scene::points::Sensor;
use glam::DVec3;

pub(super) const STARTS: Shader = trace::shader("coefficients/sun_starts", &[STRUCTS]);

/// Vertices of the light paths whose lights rays are drawn from together.
const TOGETHER: u32 = 4;
/// Vertices before roulette begins: of a hundred paths that a dark floor meets, a fifth would be left for the ceiling.
const CERTAIN: u32 = 2;
/// Of a sun's paths one in so many comes by way of surfaces outside, if there are any.
const REFLECTED_OUTSIDE: u32 = 4;
/// Suns of a dispatch: what workgroups along an axis and labels of light paths have room for.
const MOST_SUNS: usize = (1 << 16) - 1;

/// What `sensors` get of each sun by its light paths and by surfaces that they meet themselves, sr: that part of the light which the
/// batches of [`compute`](super::compute) call `sunlit` and not direct. The result's direct part is 0.
///
/// Nothing without [`CoefficientOptions::sun_paths`] or reflections.
///
/// # Errors
/// As [`compute`](super::compute).
pub fn compute_suns(
    device: &Device,
    scene: &Scene,
    windows: &[GlazedWindow],
    sensors: &[Sensor],
    suns: &[Sun],
    options: &CoefficientOptions,
    progress: &dyn Progress,
) -> Result<SunMatrix> {
    check_sensors(sensors)?;
    options.check()?;
    let mut result = SunMatrix::zeros(sensors.len(), suns.len());
    let around: Vec<DVec3> = sensors.iter().map(|s| s.position).collect();
    let tables = TraceTables::with_panes(scene, windows, &around)?;
    // Patches of the sky have no part in it.
    if suns.is_empty() || options.sun_paths.is_none() {
        return Ok(result);
    }
    let mut tracer = Tracer::new(device, tables, windows, sensors.len(), ReinhartSky::new(1)?, options)?;
    for (tile, some) in sensors.chunks(MOST_TILE_SENSORS).enumerate() {
        tracer.look_for_holes(some, tile * MOST_TILE_SENSORS, &mut result.statistics)?;
    }
    let tracer = tracer;
    add_light_paths(&tracer, scene, sensors, suns, &mut result, progress)?;
    surfaces::add(&tracer, sensors, suns, &mut result, progress)?;
    progress.update("light of suns", 1.0);
    Ok(result)
}

/// Adds what light paths from the windows bring.
fn add_light_paths(
    tracer: &Tracer<'_>,
    scene: &Scene,
    sensors: &[Sensor],
    suns: &[Sun],
    result: &mut SunMatrix,
    progress: &dyn Progress,
) -> Result<()> {
    let (device, options) = (tracer.device, &tracer.options);
    let (Some(gathered), Some(paths)) = (&tracer.gathered, options.sun_paths) else { return Ok(()) };
    let from_suns =
        FromSuns { tracer, gathered, starts: Kernel::new(device, &STARTS, &[])?, paths, straight: straight(scene, tracer.windows, paths) };
    let batches = options.batches as usize;
    let lights = size_of::<VirtualLight>() * batches * (paths * TOGETHER) as usize;
    let most_lights = MOST_LIGHT_BYTES.min(device.limits().max_storage_buffer_binding_size) as usize / lights;
    for (tile, some) in sensors.chunks(MOST_TILE_SENSORS).enumerate() {
        let first = tile * MOST_TILE_SENSORS;
        let records = tracer.receivers(some, first);
        let receivers = device.upload("sensors", &records)?;
        let cell = batches * some.len() * 4 * (tracer.components + CHANCES);
        let in_memory = usize::try_from(options.memory).unwrap_or(usize::MAX) / cell;
        let most = most_lights.min(in_memory).min(MOST_PAIRS / (some.len() * batches)).clamp(1, MOST_SUNS);
        let mut make = |result: &mut SunMatrix| {
            for (chunk, lit_by) in suns.chunks(most).enumerate() {
                let part = (first as f64 + some.len() as f64 * (chunk * most) as f64 / suns.len() as f64) / sensors.len() as f64;
                progress.update("light of suns", part);
                if progress.stop_requested() {
                    return Err(cancelled());
                }
                from_suns.add((&receivers, &records), first, lit_by, chunk * most, result)?;
            }
            Ok(())
        };
        let range = first..first + some.len();
        trace::unit(progress, &format!("suns of sensors {range:?}"), &mut *result, &mut make, &|result, values| {
            values.pass_work(&mut result.statistics)?;
            values.pass_rows(&mut result.total, range.clone())?;
            values.pass_rows(&mut result.own_error, range.clone())
        })?;
    }
    Ok(())
}

/// Paths that come straight from a sun: all but some, unless nothing stands before any window.
fn straight(scene: &Scene, windows: &[GlazedWindow], paths: u32) -> u32 {
    let outside = |point: DVec3| {
        let before = |w: &GlazedWindow| w.window.triangles.first().is_some_and(|t| (point - t[0]).dot(w.window.frame.z) < -1e-9);
        windows.iter().any(before)
    };
    if scene.triangles.iter().any(|t| t.vertices.iter().any(|v| outside(*v))) { paths - (paths / REFLECTED_OUTSIDE).max(1) } else { paths }
}

struct FromSuns<'t> {
    tracer: &'t Tracer<'t>,
    gathered: &'t Gathered,
    starts: Kernel,
    /// Of each sun and batch, and those of them that come straight from it.
    paths: u32,
    straight: u32,
}

impl FromSuns<'_> {
    /// Adds the light of some suns, the first of which has a number, to a tile of sensors.
    fn add(
        &self,
        (receivers, records): (&Buffer, &[Receiver]),
        first_row: usize,
        suns: &[Sun],
        first_sun: usize,
        result: &mut SunMatrix,
    ) -> Result<()> {
        let (tracer, o, n) = (self.tracer, &self.tracer.options, self.tracer.components);
        let (device, count, batches) = (tracer.device, records.len(), o.batches as usize);
        let sun_records: Vec<SunRecord> = suns.iter().enumerate().map(|(i, s)| SunRecord::new(s, first_sun + i)).collect();
        let to_sensors = ToSensors {
            from: self,
            receivers,
            count,
            suns: device.upload("suns", &sun_records)?,
            sun_count: suns.len(),
            first_sun,
            sums: device.zeros::<u32>("light of suns", batches * count * suns.len() * n)?,
            chances: device.zeros::<f32>("chances of suns", batches * suns.len() * count * CHANCES)?,
        };
        let options = LightPathOptions {
            paths: self.paths,
            batches: o.batches,
            bounces: o.bounces,
            seed: stream_seed(o.seed, 0, 0x7375_6e70),
            room: self.paths * TOGETHER,
            started: true,
            lists: suns.len() as u32,
            first_list: first_sun as u32,
            certain: CERTAIN,
        };
        let rounds = Rounds { paths: self.paths, rounds: 1 };
        let scene = (&tracer.tables, &tracer.scene);
        let kernels = &self.gathered.light_paths;
        follow(device, scene, kernels, options, rounds, records, &to_sensors, &mut result.statistics, &|_| Ok(()))?;
        let units = device.read::<u32>(&to_sensors.sums)?;
        let chances = device.read_finite::<f32>(&to_sensors.chances)?;
        let mut values = vec![0.0; batches];
        for sensor in 0..count {
            for (i, sun) in suns.iter().enumerate() {
                let mut found = Chances::default();
                for batch in 0..batches {
                    add_chances(&mut found, &chances[((batch * suns.len() + i) * count + sensor) * CHANCES..][..CHANCES]);
                }
                let open = doubt(&found, o.batches, self.paths);
                let (row, column) = (first_row + sensor, first_sun + i);
                for c in 0..n {
                    for (batch, value) in values.iter_mut().enumerate() {
                        let cell = ((batch * count + sensor) * suns.len() + i) * n + c;
                        *value = f64::from(units[cell]) * scale(self.paths) * sun.solid_angle();
                    }
                    let (mean, error) = mean_and_error(&values);
                    let channels = if n == 1 { 0..3 } else { c..c + 1 };
                    result.total.at_mut(row, column)[channels.clone()].fill(mean as f32);
                    result.own_error.at_mut(row, column)[channels].fill(error.hypot(open * sun.solid_angle()) as f32);
                }
            }
        }
        Ok(())
    }
}

/// Lights of some suns connected to all sensors of a tile.
struct ToSensors<'t> {
    from: &'t FromSuns<'t>,
    receivers: &'t Buffer,
    count: usize,
    suns: Buffer,
    sun_count: usize,
    first_sun: usize,
    /// `[batch][sensor][sun][component]`, fixed point.
    sums: Buffer,
    chances: Buffer,
}

impl ToSensors<'_> {
    /// Suns stand for the windows' bins and for patches of the sky.
    fn params(&self, seed: u32) -> CoefficientParams {
        let from = self.from;
        CoefficientParams {
            seed,
            unit: unit(from.paths),
            bins: self.sun_count as u32,
            first_list: self.first_sun as u32,
            patches: self.sun_count as u32,
            room: from.paths * TOGETHER,
            sunlit: 0,
            straight: from.straight,
            ..from.tracer.params(0, from.paths, self.count)
        }
    }
}

impl Gathering for ToSensors<'_> {
    fn start(&self, paths: &LightPaths<'_>, seed: u32, statistics: &mut TraceStatistics) -> Result<()> {
        let params = self.params(stream_seed(seed, 0, 0x7374_6172));
        let workgroups = [params.samples.div_ceil(64), params.bins, params.batches];
        let started = u64::from(params.samples) * u64::from(params.bins * params.batches);
        self.from.tracer.run(
            &self.from.starts,
            &params,
            &[("paths", &paths.paths), ("suns", &self.suns), ("sky_rows", &self.from.tracer.rows)],
            (workgroups, started),
            statistics,
        )
    }

    fn gather(&self, paths: &LightPaths<'_>, seed: u32, statistics: &mut TraceStatistics) -> Result<()> {
        let params = self.params(seed);
        let workgroups = [(self.count as u32).div_ceil(64), params.bins, params.batches];
        let started = self.count as u64 * u64::from(params.bins * params.batches);
        let own = [
            ("sensors", self.receivers),
            ("lights", &paths.lights),
            ("light_counts", &paths.light_counts),
            ("sums", &self.sums),
            ("chances", &self.chances),
        ];
        let tracer = self.from.tracer;
        tracer.run(&self.from.gathered.gather, &params, &own, (workgroups, started), statistics)?;
        statistics.segments += started * u64::from(tracer.options.visibility_rays);
        Ok(())
    }
}

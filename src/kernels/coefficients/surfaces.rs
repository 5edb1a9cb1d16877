//! Light of suns by surfaces that sensors' own paths meet: seen through windows, next to the sensor, or in the open.
//!
//! The surfaces serve many suns, each of which a few rays from them are sent to. So what too few surfaces get wrong, suns have
//! in common; what too few rays do, each has for itself.

use super::tracer::Tracer;
use super::{CoefficientParams, MOST_PAIRS, MOST_TILE_SENSORS, STRUCTS};
use crate::error::Result;
use crate::gpu::{Buffer, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::light_paths::{MOST_LIGHT_BYTES, WORKGROUPS_PER_ROW};
use crate::kernels::sun_matrix::{Hits, Sun, SunMatrix, SunRecord};
use crate::kernels::trace;
use crate::kernels::view_matrix::mean_and_error;
use crate::progress::{Progress, cancelled};
use crate::scene::points::Sensor;

gpu_struct! {
    /// A surface that a sensor's path meets.
    pub(crate) struct SunSurface {
        pub position: [f32; 3],
        /// What it is drawn by; 0 if the path met none.
        pub strength: f32,
        /// Of the side that light comes from, unit length.
        pub normal: [f32; 3],
        /// Part of its light that counts if the sun comes to it through a window.
        pub through: f32,
        /// What it gives the sensor of irradiance 1, sr.
        pub flux: [f32; 3],
        /// The same as `through` if the sun comes to it by no window.
        pub beside: f32,
    }
}

pub(super) const SURFACES: Shader = trace::shader("coefficients/sun_surfaces", &[STRUCTS, crate::kernels::light_paths::NUMBERS]);
pub(super) const GATHER: Shader = trace::shader("coefficients/sun_gather", &[STRUCTS]);

/// Rays to a sun per sensor and batch.
pub(crate) const SURFACE_RAYS: u32 = 8;
/// Values of `found` per sensor, sun and batch.
const FOUND: usize = 8;

/// Adds this light of all suns to the sensors' rows. Of suns whose numbers differ by a multiple of
/// [`sun_sets`](super::CoefficientOptions::sun_sets) the surfaces are the same, and their errors `shared_error`.
///
/// # Errors
/// Failures of the device, or when stopped by `progress`.
pub(super) fn add(tracer: &Tracer<'_>, sensors: &[Sensor], suns: &[Sun], result: &mut SunMatrix, progress: &dyn Progress) -> Result<()> {
    let (device, o) = (tracer.device, &tracer.options);
    let Some(paths) = o.sun_paths.filter(|_| o.bounces.is_none_or(|b| b > 1)) else { return Ok(()) };
    let from_sensors = FromSensors {
        tracer,
        surfaces: Kernel::new(device, &SURFACES, &[("HAS_GLASS", tracer.has_glass())])?,
        gather: Kernel::new(device, &GATHER, &[("HAS_GLASS", tracer.has_glass()), ("RAYS", f64::from(SURFACE_RAYS))])?,
        samples: paths.max(SURFACE_RAYS),
    };
    let of_sensor = size_of::<SunSurface>() as u64 * u64::from(o.sun_sets * o.batches) * u64::from(from_sensors.samples);
    let room = MOST_LIGHT_BYTES.min(device.limits().max_storage_buffer_binding_size).min(o.memory / 2);
    let most = ((room / of_sensor).max(1) as usize).min(MOST_TILE_SENSORS);
    for (tile, some) in sensors.chunks(most).enumerate() {
        let first = tile * most;
        progress.update("surfaces in the sun", first as f64 / sensors.len() as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let range = first..first + some.len();
        let mut make = |result: &mut SunMatrix| from_sensors.add(some, first, suns, result, progress);
        trace::unit(progress, &format!("surfaces of sensors {range:?}"), &mut *result, &mut make, &|result, values| {
            values.pass_work(&mut result.statistics)?;
            values.pass_rows(&mut result.total, range.clone())?;
            values.pass_rows(&mut result.own_error, range.clone())?;
            values.pass_rows(&mut result.shared_error, range.clone())
        })?;
    }
    Ok(())
}

struct FromSensors<'t> {
    tracer: &'t Tracer<'t>,
    surfaces: Kernel,
    gather: Kernel,
    /// Paths per sensor, set and batch.
    samples: u32,
}

impl FromSensors<'_> {
    fn params(&self, purpose: u32, sensors: usize) -> CoefficientParams {
        let windows = !self.tracer.windows.is_empty();
        CoefficientParams {
            sets: self.tracer.options.sun_sets,
            straight: if windows { self.samples / 2 } else { 0 },
            ..self.tracer.params(purpose, self.samples, sensors)
        }
    }

    fn add(&self, sensors: &[Sensor], first: usize, suns: &[Sun], result: &mut SunMatrix, progress: &dyn Progress) -> Result<()> {
        let (tracer, o) = (self.tracer, &self.tracer.options);
        let (device, count, batches) = (tracer.device, sensors.len(), o.batches as usize);
        let records = tracer.receivers(sensors, first);
        let receivers = device.upload("sensors", &records)?;
        let paths = count * self.samples as usize;
        let surfaces = device.zeros::<SunSurface>("surfaces in the sun", paths * batches * o.sun_sets as usize)?;
        let groups = (paths as u32).div_ceil(64);
        let workgroups = [groups.min(WORKGROUPS_PER_ROW), groups.div_ceil(WORKGROUPS_PER_ROW), o.batches * o.sun_sets];
        let own = [("sky_rows", &tracer.rows), ("sensors", &receivers), ("surfaces", &surfaces)];
        let started = (paths * batches) as u64 * u64::from(o.sun_sets);
        let params = self.params(0x7375_7266, count);
        tracer.run(&self.surfaces, &params, &own, (workgroups, started), &mut result.statistics)?;
        // Of all suns, whose number tells what one of them may have.
        let mut hits = vec![Hits::default(); count * suns.len()];
        let together = (MOST_PAIRS / (count * batches)).clamp(1, 1 << 16);
        for (chunk, some) in suns.chunks(together).enumerate() {
            if progress.stop_requested() {
                return Err(cancelled());
            }
            let found = self.connect(&surfaces, (first, count), some, chunk * together, result)?;
            for (sensor, row) in found.chunks(some.len()).enumerate() {
                hits[sensor * suns.len() + chunk * together..][..some.len()].copy_from_slice(row);
            }
        }
        for (sensor, hits) in hits.chunks(suns.len()).enumerate() {
            let mut all = Hits::default();
            hits.iter().for_each(|of_sun| all.add(of_sun));
            for (column, (sun, hits)) in suns.iter().zip(hits).enumerate() {
                let scale = sun.solid_angle().powi(2);
                let [own, shared] = hits.doubts_among(&all, batches).map(|variance| variance * scale);
                add_variance(result.own_error.at_mut(first + sensor, column), [own; 3]);
                add_variance(result.shared_error.at_mut(first + sensor, column), [shared; 3]);
            }
        }
        Ok(())
    }

    /// Adds the light of some suns, the first of which has a number, and its spread. Returns what rays found,
    /// `[sensor][sun]`.
    fn connect(
        &self,
        surfaces: &Buffer,
        (first_row, count): (usize, usize),
        suns: &[Sun],
        first_sun: usize,
        result: &mut SunMatrix,
    ) -> Result<Vec<Hits>> {
        let (tracer, batches) = (self.tracer, self.tracer.options.batches as usize);
        let device = tracer.device;
        let records: Vec<SunRecord> = suns.iter().enumerate().map(|(i, s)| SunRecord::new(s, first_sun + i)).collect();
        let records = device.upload("suns", &records)?;
        let found = device.zeros::<[f32; FOUND]>("light of surfaces in the sun", batches * count * suns.len())?;
        let params = CoefficientParams { bins: suns.len() as u32, first_list: first_row as u32, ..self.params(0x7375_6e67, count) };
        let workgroups = [params.bins.div_ceil(64), count as u32, params.batches];
        let started = (batches * count * suns.len()) as u64;
        let own = [("surfaces", surfaces), ("suns", &records), ("found", &found)];
        tracer.run(&self.gather, &params, &own, (workgroups, started), &mut result.statistics)?;
        result.statistics.segments += started * u64::from(SURFACE_RAYS);
        let found = device.read_finite::<f32>(&found)?;
        let mut all = Vec::with_capacity(count * suns.len());
        let mut values = vec![0.0; batches];
        for sensor in 0..count {
            for (i, sun) in suns.iter().enumerate() {
                let of = |batch: usize, k: usize| f64::from(found[((batch * count + sensor) * suns.len() + i) * FOUND + k]);
                let sum = |k: usize| (0..batches).map(|batch| of(batch, k)).sum::<f64>();
                let [possible, squares, of_surfaces, found, looks] = [3, 4, 5, 6, 7].map(sum);
                let light = [0, 1, 2].map(sum).into_iter().fold(0.0, f64::max);
                // The mean of the channels.
                let unseen = if possible > 0.0 { squares / possible / 3.0 } else { 0.0 };
                all.push(Hits { found, looks, light, unseen });
                if squares <= 0.0 {
                    continue;
                }
                // Rays to all surfaces would leave this part of the variance.
                let shared = (of_surfaces / squares).min(1.0);
                let (row, column, scale) = (first_row + sensor, first_sun + i, sun.solid_angle());
                let mut variance = [0.0; 3];
                for c in 0..3 {
                    values.iter_mut().enumerate().for_each(|(batch, v)| *v = scale * of(batch, c));
                    let (mean, error) = mean_and_error(&values);
                    result.total.at_mut(row, column)[c] += mean as f32;
                    variance[c] = error * error;
                }
                add_variance(result.own_error.at_mut(row, column), variance.map(|v| v * (1.0 - shared)));
                add_variance(result.shared_error.at_mut(row, column), variance.map(|v| v * shared));
            }
        }
        Ok(all)
    }
}

fn add_variance(errors: &mut [f32], variance: [f64; 3]) {
    errors.iter_mut().zip(variance).for_each(|(error, v)| *error = f64::from(*error).hypot(v.sqrt()) as f32);
}

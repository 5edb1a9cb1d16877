//! What few hits leave open of the light that sensors get.

use super::CoefficientOptions;
use crate::bins::ReinhartSky;
use crate::error::Result;
use crate::kernels::light_paths::LOOK_UNITS;
use crate::kernels::trace::doubt::{ENOUGH_HITS, Part, half_a_hit, pattern};
use crate::kernels::trace::{TracedMatrix, Values};
use std::f64::consts::PI;

/// What the samples of one sensor, all batches together, found.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Looks {
    /// Rays to windows before the sensor, those that light came by, what they could have brought in units.
    pub at_windows: [u32; 3],
    /// Light that paths found of windows, its sum in units; of the sky by no window, its sum.
    pub by_paths: [u32; 4],
    /// Deviation by what light paths may have brought, of which few arrived, sr.
    pub gathered: f64,
}

impl Looks {
    /// # Errors
    /// See [`Values::pass`].
    pub fn pass(&mut self, values: &mut Values) -> Result<()> {
        values.pass(&mut self.at_windows)?;
        values.pass(&mut self.by_paths)?;
        values.pass(std::slice::from_mut(&mut self.gathered))
    }
}

/// Deviation of a contribution of which few hits were found among so many samples; `weight` is that of one hit.
fn of_hits(hits: f64, weight: f64, samples: f64) -> f64 {
    if hits < ENOUGH_HITS { half_a_hit(weight, samples) } else { 0.0 }
}

/// Puts half a hit more upon what sensors get in each way of which few samples found light: anywhere in the sky, by the
/// patches' solid angles. Sensors none of whose paths found light in some way are one sample of it all together: light
/// that none of all those paths met is not around the corner.
///
/// `to_the_sky`: paths of each sensor, all batches together, that looked for light by no window.
pub(super) fn add(result: &mut TracedMatrix, looks: &[Looks], sky: ReinhartSky, options: &CoefficientOptions, to_the_sky: f64) {
    let batches = options.batches as usize;
    let paths = f64::from(options.near_samples) * batches as f64;
    let samples = f64::from(options.direct_samples) * batches as f64;
    let unlit = looks.iter().filter(|l| l.by_paths[2] == 0).count() as f64;
    let shares: Vec<f64> = (0..sky.len()).map(|p| sky.solid_angle(p) / (4.0 * PI)).collect();
    for (sensor, look) in looks.iter().enumerate() {
        let [ahead, hits, possible] = look.at_windows.map(f64::from);
        // All that could be hidden is what stands before the sensor.
        let at_windows = if ahead > 0.0 && hits < ahead { of_hits(hits, possible / LOOK_UNITS / ahead, samples) } else { 0.0 };
        let [found, sum] = [look.by_paths[0], look.by_paths[1]].map(f64::from);
        // Without any, there may be no way at all, and half a hit is as much as was found of the rarest light.
        let near = if found > 0.0 { of_hits(found, sum / LOOK_UNITS / found, paths) } else { 0.0 };
        let [found, sum] = [look.by_paths[2], look.by_paths[3]].map(f64::from);
        let open = if found > 0.0 { of_hits(found, sum / LOOK_UNITS / found, paths) } else { of_hits(found, PI, to_the_sky * unlit) };
        let parts = [(Part::WINDOWS, at_windows), (Part::REFLECTIONS, near), (Part::GATHERED, look.gathered), (Part::OTHERS, open)];
        for (part, size) in parts {
            if size == 0.0 {
                continue;
            }
            let pattern = pattern(part, batches);
            for (patch, share) in shares.iter().enumerate() {
                for error in result.standard_error.at_mut(sensor, patch) {
                    *error = f64::from(*error).hypot(size * share) as f32;
                }
                for (batch, deviation) in result.batches.iter_mut().zip(&pattern) {
                    batch.total.at_mut(sensor, patch).iter_mut().for_each(|v| *v = (f64::from(*v) + size * share * deviation) as f32);
                }
            }
        }
    }
}

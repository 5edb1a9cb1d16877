//! Host half of `shaders/bsdf/paths.wgsl`.

use super::{GenerationParams, GenerationStatistics, Job, directions};
use crate::error::Result;
use crate::gpu::{Kernel, Shader};
use crate::kernels::trace::{self, Counters, check_finished, stream_seed};

pub(super) const PATHS: Shader = trace::shader("bsdf/paths", &[directions::NUMBERS, NUMBERS, &[GenerationParams::DECLARED]]);

/// Records of one dispatch: bounds its time and memory.
const MOST_RECORDS: usize = 1 << 19;

crate::gpu_constants! {
    const NUMBERS = {
        /// Number of a record whose light stayed inside.
        const NOWHERE: u32 = u32::MAX;
    }
}

/// Adds the BSDF by `samples` paths per incident cell to `batch`. With `diffuse`, paths are followed
/// through diffuse reflections; else they end there.
pub(super) fn add(
    job: &Job,
    number: u32,
    samples: u32,
    diffuse: bool,
    batch: &mut [f32],
    statistics: &mut GenerationStatistics,
    report: &dyn Fn(f64) -> Result<()>,
) -> Result<()> {
    let (device, directions) = (job.device, job.directions);
    let mut constants = job.constants();
    constants.push(("FOLLOW_DIFFUSE", f64::from(u8::from(diffuse))));
    let ways = if !diffuse && job.tables.features.specular { 2 } else { 1 };
    constants.push(("WAYS", ways as f64));
    let kernel = Kernel::new(device, &PATHS, &constants)?;
    let cells = 2 * directions.incident();
    let outgoing = 2 * directions.outgoing();
    let samples_once = (samples as usize).min(MOST_RECORDS / 64);
    let cells_once = (MOST_RECORDS / samples_once).clamp(1, cells.min(device.limits().max_compute_workgroups_per_dimension as usize));
    let records = device.zeros::<[u32; 2]>("path records", ways * samples_once * cells_once)?;
    let counters = device.zeros::<Counters>("path counters", 1)?;
    let projected = directions.outgoing_projected();
    let values: Vec<f64> = projected.iter().map(|l| 1.0 / (l * f64::from(samples))).collect();
    for first_cell in (0..cells).step_by(cells_once) {
        let count = cells_once.min(cells - first_cell);
        for first_sample in (0..samples as usize).step_by(samples_once) {
            report((first_cell as f64 + count as f64 * first_sample as f64 / f64::from(samples)) / cells as f64)?;
            let here = samples_once.min(samples as usize - first_sample);
            let mut params = job.params();
            params.seed = stream_seed(job.options.seed, number, 0x6273_6466);
            params.first_sample = first_sample as u32;
            params.samples = here as u32;
            params.first_cell = first_cell as u32;
            params.cells = count as u32;
            let params = device.uniform("generation parameters", &params)?;
            device.write(&counters, &[Counters::default()])?;
            let bind = kernel.bind(&job.scene.bindings(&[("params", &params), ("records", &records), ("counters", &counters)]))?;
            device.dispatch(&kernel, &bind, [(here as u32).div_ceil(64), count as u32, ways as u32])?;
            let found = device.read::<Counters>(&counters)?[0];
            let started = (ways * here * count) as u64;
            check_finished(&found, started, "BSDF paths")?;
            statistics.paths += started;
            statistics.segments += u64::from(found.segments);
            statistics.mirror_backs += u64::from(found.alive);
            let found = device.read::<[u32; 2]>(&records.part::<[u32; 2]>(0, ways * here * count)?)?;
            for (k, records) in found.chunks_exact(here).enumerate() {
                let row = &mut batch[(first_cell + k % count) * outgoing..][..outgoing];
                for &[out, weight] in records.iter().filter(|r| r[0] != NOWHERE) {
                    let out = out as usize;
                    row[out] += f32::from_bits(weight) * values[out % projected.len()] as f32;
                }
            }
        }
    }
    Ok(())
}

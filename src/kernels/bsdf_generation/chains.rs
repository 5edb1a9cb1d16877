//! Host half of the chains and fans (`shaders/bsdf/chain*.wgsl`, `fans.wgsl`).
//!
//! The diffuse part of entry (i, o) is `S/A · mean over chains of E_i · L_o`: E_i the irradiance of a
//! chain's first point by incident cell i (flux 1 per area A of the sample), L_o what leaves from all
//! its points into outgoing cell o, S the area of the surfaces times albedo. So two fans of rays per
//! chain serve all entries at once, and the sum over chains is a matrix product.

mod surfaces;

pub(super) use surfaces::Surfaces;

use super::{GenerationParams, GenerationStatistics, Job, directions};
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Declared, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::trace::{self, Counters, check_finished, stream_seed};
use crate::units::BRIGHTNESS_WEIGHTS;
use rayon::prelude::*;

gpu_struct! {
    /// A chain of diffuse reflections (`shaders/bsdf_generation/chain.wgsl`).
    pub struct Chain {
        /// The latest point.
        position: [f32; 3],
        /// Material there.
        material: u32,
        /// Unit normal of the side from which light leaves.
        leaving: [f32; 3],
        /// Diffuse reflections up to and at this point.
        bounces: u32,
        /// Unit normal of the side on which light arrives at the first point.
        arriving: [f32; 3],
        /// Entry of the table from which the first point came.
        entry: u32,
        /// Of light that leaves, relative to the irradiance of the first point.
        weight: [f32; 3],
        padding: u32,
    }
}

/// Shaders of this module, for the tests.
pub(super) fn registered() -> Vec<Shader> {
    vec![START, FANS, WALK]
}

const STRUCTS: &[Declared] = &[GenerationParams::DECLARED, Chain::DECLARED];
const START: Shader = trace::shader("bsdf_generation/chain_start", &[directions::NUMBERS, STRUCTS]);
const FANS: Shader = trace::shader("bsdf_generation/fans", &[directions::NUMBERS, STRUCTS]);
const WALK: Shader = trace::shader("bsdf_generation/chain_walk", &[directions::NUMBERS, STRUCTS]);

/// Rays of one dispatch: bounds its time.
const MOST_RAYS: usize = 1 << 20;
/// Bytes of one table of fans: bounds memory and stays below the bindings of small devices.
const MOST_BYTES: usize = 64 << 20;
/// Fixed-point units of 1: values are of order 1 and their sums stay below 4096.
const UNIT: f32 = (1u32 << 20) as f32;
/// A sum from here on may have run over.
const FULL: u32 = 1 << 31;
impl Surfaces {
    /// Distributes the chains so that the entries' variance becomes small: in proportion to strength
    /// times the root mean square of what chains from a group of alike sides add (found by a first
    /// round of chains), half of them by strength alone.
    pub(super) fn distribute(&mut self, job: &Job, samples: u32, statistics: &mut GenerationStatistics) -> Result<()> {
        let chains = (samples / 8).clamp(64, 2048);
        let tracer = Tracer::new(job, self, u32::MAX, chains)?;
        let (incident, outgoing) = (2 * job.directions.incident(), 2 * job.directions.outgoing());
        let mut squares = vec![0.0; self.groups];
        let mut counts = vec![0.0; self.groups];
        for first in (0..chains).step_by(tracer.capacity) {
            let count = (chains - first).min(tracer.capacity as u32) as usize;
            let fans = tracer.trace(first, count as u32, statistics, &|_| Ok(()))?;
            let (sent, left, capacity) = (&fans.sent, &fans.left, tracer.capacity);
            let square = |u: u32| f64::from(u) * f64::from(u);
            for chain in 0..count {
                let planes = 0..tracer.components;
                let from: f64 = planes
                    .clone()
                    .flat_map(|p| (0..incident).map(move |i| (p * incident + i) * capacity + chain))
                    .map(|k| square(sent[k]))
                    .sum();
                let to: f64 =
                    planes.flat_map(|p| (0..outgoing).map(move |o| (p * capacity + chain) * outgoing + o)).map(|k| square(left[k])).sum();
                let group = self.sides[fans.entries[chain] as usize].group;
                squares[group] += from * to;
                counts[group] += 1.0;
            }
        }
        let mean = squares.iter().sum::<f64>() / counts.iter().sum::<f64>().max(1.0);
        if !(mean > 0.0) {
            return Ok(());
        }
        // Groups seen rarely lean towards the mean of all.
        let expected: Vec<f64> = squares.iter().zip(&counts).map(|(s, c)| ((s + mean) / (c + 1.0)).sqrt()).collect();
        let wanted: Vec<f64> = self.sides.iter().map(|s| s.strength * expected[s.group]).collect();
        let sum: f64 = wanted.iter().sum();
        for (share, wanted) in self.shares.iter_mut().zip(wanted) {
            *share = 0.5 * *share + 0.5 * wanted / sum;
        }
        Ok(())
    }
}

/// Adds the diffuse part of the BSDF by `samples` chains to `batch`.
pub(super) fn add(
    job: &Job,
    surfaces: &Surfaces,
    number: u32,
    samples: u32,
    batch: &mut [f32],
    statistics: &mut GenerationStatistics,
    report: &dyn Fn(f64) -> Result<()>,
) -> Result<()> {
    let tracer = Tracer::new(job, surfaces, number, samples)?;
    let factors = surfaces.factors();
    let (incident, outgoing) = (2 * job.directions.incident(), 2 * job.directions.outgoing());
    let scale = 1.0 / (f64::from(samples) * f64::from(UNIT) * f64::from(UNIT));
    for first in (0..samples).step_by(tracer.capacity) {
        report(f64::from(first) / f64::from(samples))?;
        let chains = (samples - first).min(tracer.capacity as u32) as usize;
        let fans = tracer.trace(first, chains as u32, statistics, report)?;
        let capacity = tracer.capacity;
        for c in 0..tracer.components {
            let weight = if tracer.components == 1 { scale } else { scale * BRIGHTNESS_WEIGHTS[c] };
            let weights: Vec<f64> = fans.entries[..chains].iter().map(|&e| factors[e as usize] * weight).collect();
            let left: Vec<f32> = fans.left[c * capacity * outgoing..][..chains * outgoing].iter().map(|&u| u as f32).collect();
            let sent = &fans.sent[c * incident * capacity..][..incident * capacity];
            batch.par_chunks_exact_mut(outgoing).zip(sent.par_chunks_exact(capacity)).for_each(|(row, sent)| {
                for ((&sent, weight), left) in sent.iter().zip(&weights).zip(left.chunks_exact(outgoing)).filter(|((s, _), _)| **s > 0) {
                    let factor = (f64::from(sent) * weight) as f32;
                    for (entry, value) in row.iter_mut().zip(left) {
                        *entry += factor * value;
                    }
                }
            });
        }
    }
    Ok(())
}

/// What a round of chains found, fixed point.
struct Fans {
    /// `[component][incident cell][chain]`.
    sent: Vec<u32>,
    /// `[component][chain][outgoing cell]`.
    left: Vec<u32>,
    /// Side on which each chain began.
    entries: Vec<u32>,
}

/// Kernels and buffers of one batch.
struct Tracer<'a> {
    job: &'a Job<'a>,
    params: GenerationParams,
    capacity: usize,
    components: usize,
    start: Kernel,
    incoming: Kernel,
    outgoing: Kernel,
    walk: Kernel,
    triangles: Buffer,
    chains: Buffer,
    listed: Buffer,
    goes_on: Buffer,
    sent: Buffer,
    left: Buffer,
    counters: Buffer,
}

impl<'a> Tracer<'a> {
    fn new(job: &'a Job, surfaces: &Surfaces, number: u32, samples: u32) -> Result<Self> {
        let device = job.device;
        let components = if job.tables.features.grey { 1 } else { 3 };
        let (incident, outgoing) = (2 * job.directions.incident(), 2 * job.directions.outgoing());
        let cells = incident.max(outgoing);
        let capacity = (MOST_RAYS / cells)
            .min(MOST_BYTES / (4 * components * cells))
            .min(device.limits().max_compute_workgroups_per_dimension as usize)
            .clamp(1, samples as usize);
        let common = job.constants();
        let fan = |incoming: f64| {
            let mut constants = common.clone();
            let specular = f64::from(u8::from(job.tables.features.specular));
            constants.extend([("INCOMING", incoming), ("SPECULAR", specular), ("COMPONENTS", components as f64)]);
            Kernel::new(device, &FANS, &constants)
        };
        let mut params = job.params();
        params.seed = stream_seed(job.options.seed, number, 0x6661_6e73);
        params.unit = UNIT;
        params.capacity = capacity as u32;
        params.diffuse_count = surfaces.sides.len() as u32;
        Ok(Self {
            job,
            params,
            capacity,
            components,
            start: Kernel::new(device, &START, &common)?,
            incoming: fan(1.0)?,
            outgoing: fan(0.0)?,
            walk: Kernel::new(device, &WALK, &common)?,
            triangles: device.upload("diffuse triangles", &surfaces.table())?,
            chains: device.zeros::<Chain>("chains", capacity)?,
            listed: device.zeros::<u32>("listed chains", capacity)?,
            goes_on: device.zeros::<u32>("chains that go on", capacity)?,
            sent: device.zeros::<u32>("incoming fans", components * incident * capacity)?,
            left: device.zeros::<u32>("outgoing fans", components * outgoing * capacity)?,
            counters: device.zeros::<Counters>("path counters", 1)?,
        })
    }

    /// Incoming fans `[component][cell][chain]` and outgoing fans `[component][chain][cell]` of
    /// `chains` chains from number `first` on, fixed point.
    fn trace(&self, first: u32, chains: u32, statistics: &mut GenerationStatistics, report: &dyn Fn(f64) -> Result<()>) -> Result<Fans> {
        let device = self.job.device;
        let mut batch = device.batch("clear fans");
        batch.clear(&self.sent).clear(&self.left);
        batch.submit()?;
        let params = GenerationParams { first_sample: first, samples: chains, ..self.params };
        self.run(
            &self.start,
            params,
            &[("diffuse_triangles", &self.triangles)],
            [chains.div_ceil(64), 1, 1],
            u64::from(chains),
            statistics,
        )?;
        let mut listed: Vec<u32> = (0..chains).collect();
        device.write(&self.listed, &listed)?;
        let (incident, outgoing) = (2 * params.in_cells, 2 * params.out_cells);
        let fan = |kernel: &Kernel, cells: u32, fans: &Buffer, count: u32, statistics: &mut GenerationStatistics| {
            let rays = u64::from(cells) * u64::from(count);
            self.run(kernel, params, &[("listed", &self.listed), ("fans", fans)], [cells.div_ceil(64), count, 1], rays, statistics)
        };
        fan(&self.incoming, incident, &self.sent, chains, statistics)?;
        loop {
            report(f64::from(first) / f64::from(first + chains))?;
            fan(&self.outgoing, outgoing, &self.left, listed.len() as u32, statistics)?;
            let left = listed.len() as u32;
            let own = [("listed", &self.listed), ("goes_on", &self.goes_on)];
            let step = GenerationParams { samples: left, ..params };
            self.run(&self.walk, step, &own, [left.div_ceil(64), 1, 1], u64::from(left), statistics)?;
            let goes_on = device.read::<u32>(&self.goes_on.part::<u32>(0, listed.len())?)?;
            listed = listed.iter().zip(&goes_on).filter(|(_, g)| **g != 0).map(|(&l, _)| l).collect();
            if listed.is_empty() {
                break;
            }
            device.write(&self.listed.part::<u32>(0, listed.len())?, &listed)?;
        }
        let (sent, left) = (device.read::<u32>(&self.sent)?, device.read::<u32>(&self.left)?);
        if sent.iter().chain(&left).any(|&u| u >= FULL) {
            return Err(
                Error::new("the sums of one chain ran over").help("mirrors concentrate light on very few cells; use --method paths")
            );
        }
        let entries = device.read::<Chain>(&self.chains)?.iter().map(|c| c.entry).collect();
        Ok(Fans { sent, left, entries })
    }

    fn run(
        &self,
        kernel: &Kernel,
        params: GenerationParams,
        own: &[(&str, &Buffer)],
        groups: [u32; 3],
        started: u64,
        statistics: &mut GenerationStatistics,
    ) -> Result<()> {
        let device = self.job.device;
        let params = device.uniform("generation parameters", &params)?;
        device.write(&self.counters, &[Counters::default()])?;
        let mut buffers = vec![("params", &params), ("chains", &self.chains), ("counters", &self.counters)];
        buffers.extend_from_slice(own);
        let bind = kernel.bind(&self.job.scene.bindings(&buffers))?;
        device.dispatch(kernel, &bind, groups)?;
        let found = device.read::<Counters>(&self.counters)?[0];
        check_finished(&found, started, "rays of the BSDF")?;
        statistics.paths += started;
        statistics.segments += u64::from(found.segments);
        Ok(())
    }
}

//! Light paths from the windows, each with the sky patch that its light comes from, connected to all sensors.

use super::tracer::{Tracer, unit};
use super::{CoefficientOptions, CoefficientParams, GATHER, STARTS};
use crate::error::Result;
use crate::gpu::{Buffer, Device, Kernel};
use crate::kernels::light_paths::doubts::Chances;
use crate::kernels::light_paths::{Gathering, LightPathKernels, LightPathOptions, LightPaths, Receiver, Rounds, finish_dispatch, follow};
use crate::kernels::trace::doubt::ENOUGH_HITS;
use crate::kernels::trace::{Counters, TraceStatistics, TraceTables, stream_seed};

/// Values of `chances` per sensor, bin and batch.
const CHANCES: usize = 3;

pub(super) struct Gathered {
    light_paths: LightPathKernels,
    rounds: Rounds,
    starts: Kernel,
    gather: Kernel,
}

impl Gathered {
    pub fn new(device: &Device, tables: &TraceTables, options: &CoefficientOptions, constants: [(&str, f64); 2]) -> Result<Self> {
        let [glass, components] = constants;
        Ok(Self {
            light_paths: LightPathKernels::new(device)?,
            rounds: Rounds::of(device, tables, options.batches, options.light_paths),
            starts: Kernel::new(device, &STARTS, &[])?,
            gather: Kernel::new(device, &GATHER, &[glass, components, ("RAYS", f64::from(options.visibility_rays))])?,
        })
    }

    /// Light paths per bin and batch.
    pub fn paths(&self) -> u32 {
        self.rounds.all()
    }

    /// Adds what all light paths bring to a tile of sensors to `sums`, in the units of [`Self::paths`] samples. Returns the
    /// deviation of each sensor by what few hits leave open, sr.
    pub fn add(
        &self,
        tracer: &Tracer<'_>,
        (receivers, records): (&Buffer, &[Receiver]),
        sums: &Buffer,
        statistics: &mut TraceStatistics,
        stage: &dyn Fn(f64) -> Result<()>,
    ) -> Result<Vec<f64>> {
        let (o, count) = (&tracer.options, records.len());
        let chances = tracer.device.zeros::<f32>("chances of light paths", o.batches as usize * tracer.tables.bins() * count * CHANCES)?;
        let to_patches = ToPatches { gathered: self, tracer, receivers, count, sums, chances };
        let paths = self.rounds.paths;
        let options = LightPathOptions { paths, batches: o.batches, bounces: o.bounces, seed: o.seed, room: paths, started: true };
        let scene = (&tracer.tables, &tracer.scene);
        follow(tracer.device, scene, &self.light_paths, options, self.rounds, records, &to_patches, statistics, stage)?;
        let mut found = vec![Chances::default(); count];
        for (i, cell) in tracer.device.read_finite::<f32>(&to_patches.chances)?.chunks_exact(CHANCES).enumerate() {
            // The mean of the channels.
            let [arrived, possible, squares] = std::array::from_fn(|k| f64::from(cell[k]) / 3.0);
            let sum = &mut found[i % count];
            sum.arrived += arrived;
            sum.possible += possible;
            sum.squares += squares / 3.0;
        }
        // Also if all of them arrive: the ends of light paths are found by chance themselves.
        let doubt = |c: &Chances| if c.hits() < ENOUGH_HITS { c.half_a_hit(f64::from(o.batches)) / f64::from(self.paths()) } else { 0.0 };
        Ok(found.iter().map(doubt).collect())
    }
}

/// Lights connected to all sensors of a tile, each for its patch of the sky.
struct ToPatches<'t> {
    gathered: &'t Gathered,
    tracer: &'t Tracer<'t>,
    receivers: &'t Buffer,
    count: usize,
    sums: &'t Buffer,
    chances: Buffer,
}

impl ToPatches<'_> {
    fn run(
        &self,
        kernel: &Kernel,
        params: &CoefficientParams,
        own: &[(&str, &Buffer)],
        (workgroups, started): ([u32; 3], u64),
        statistics: &mut TraceStatistics,
    ) -> Result<()> {
        let device = self.tracer.device;
        let params = device.uniform("parameters of light paths", params)?;
        device.write(&self.tracer.counters, &[Counters::default()])?;
        let all = [own, &[("params", &params), ("counters", &self.tracer.counters)]].concat();
        let bind = kernel.bind(&self.tracer.scene.bindings(&all))?;
        device.dispatch(kernel, &bind, workgroups)?;
        finish_dispatch(device, &self.tracer.counters, started, kernel.label(), statistics)?;
        Ok(())
    }

    /// Lights are of one round, their light is divided among the paths of all.
    fn params(&self, seed: u32) -> CoefficientParams {
        CoefficientParams { seed, unit: unit(self.gathered.paths()), ..self.tracer.params(0, self.gathered.rounds.paths, self.count) }
    }
}

impl Gathering for ToPatches<'_> {
    fn start(&self, paths: &LightPaths<'_>, seed: u32, statistics: &mut TraceStatistics) -> Result<()> {
        let params = self.params(stream_seed(seed, 0, 0x7374_6172));
        let workgroups = [params.samples.div_ceil(64), params.bins, params.batches];
        let started = u64::from(params.samples) * u64::from(params.bins * params.batches);
        let own = [("paths", &paths.paths), ("sky_rows", &self.tracer.rows)];
        self.run(&self.gathered.starts, &params, &own, (workgroups, started), statistics)
    }

    fn gather(&self, paths: &LightPaths<'_>, seed: u32, statistics: &mut TraceStatistics) -> Result<()> {
        let params = self.params(seed);
        let workgroups = [(self.count as u32).div_ceil(64), params.bins, params.batches];
        let started = self.count as u64 * u64::from(params.bins * params.batches);
        let own = [
            ("sensors", self.receivers),
            ("lights", &paths.lights),
            ("light_counts", &paths.light_counts),
            ("sums", self.sums),
            ("chances", &self.chances),
        ];
        self.run(&self.gathered.gather, &params, &own, (workgroups, started), statistics)?;
        statistics.segments += started * u64::from(self.tracer.options.visibility_rays);
        Ok(())
    }
}

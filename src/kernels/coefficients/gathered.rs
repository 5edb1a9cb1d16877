//! Light paths from the windows, each with the sky patch that its light comes from, connected to all sensors.

use super::tracer::{Tracer, unit};
use super::{CoefficientOptions, CoefficientParams, GATHER, STARTS};
use crate::error::Result;
use crate::gpu::{Buffer, Device, Kernel};
use crate::kernels::light_paths::doubts::Chances;
use crate::kernels::light_paths::{Gathering, LightPathKernels, LightPathOptions, LightPaths, Receiver, Rounds, follow};
use crate::kernels::trace::doubt::ENOUGH_HITS;
use crate::kernels::trace::{TraceStatistics, TraceTables, stream_seed};

/// Values of `chances` per sensor, bin and batch.
pub(super) const CHANCES: usize = 3;

/// Adds a cell of `chances`.
pub(super) fn add_chances(sum: &mut Chances, cell: &[f32]) {
    // The mean of the channels.
    let [arrived, possible, squares] = std::array::from_fn(|k| f64::from(cell[k]) / 3.0);
    sum.arrived += arrived;
    sum.possible += possible;
    sum.squares += squares / 3.0;
}

/// Deviation by what few hits leave open. Also if all of them arrive: the ends of light paths are found by chance
/// themselves.
pub(super) fn doubt(chances: &Chances, batches: u32, paths: u32) -> f64 {
    if chances.hits() < ENOUGH_HITS { chances.half_a_hit(f64::from(batches)) / f64::from(paths) } else { 0.0 }
}

pub(super) struct Gathered {
    pub(super) light_paths: LightPathKernels,
    rounds: Rounds,
    starts: Kernel,
    pub(super) gather: Kernel,
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
        let options = LightPathOptions {
            paths,
            batches: o.batches,
            bounces: o.bounces,
            seed: o.seed,
            room: paths,
            started: true,
            lists: tracer.tables.bins() as u32,
            first_list: 0,
            certain: 0,
        };
        let scene = (&tracer.tables, &tracer.scene);
        follow(tracer.device, scene, &self.light_paths, options, self.rounds, records, &to_patches, statistics, stage)?;
        let mut found = vec![Chances::default(); count];
        for (i, cell) in tracer.device.read_finite::<f32>(&to_patches.chances)?.chunks_exact(CHANCES).enumerate() {
            add_chances(&mut found[i % count], cell);
        }
        Ok(found.iter().map(|c| doubt(c, o.batches, self.paths())).collect())
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
        self.tracer.run(&self.gathered.starts, &params, &own, (workgroups, started), statistics)
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
        self.tracer.run(&self.gathered.gather, &params, &own, (workgroups, started), statistics)?;
        statistics.segments += started * u64::from(self.tracer.options.visibility_rays);
        Ok(())
    }
}

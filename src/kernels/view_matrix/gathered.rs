//! What light paths from the windows bring to the sensors.

use super::{GatherParams, ViewTracer};
use crate::error::Result;
use crate::gpu::Buffer;
use crate::kernels::light_paths::{Gathering, LightPathOptions, LightPaths, Receiver, finish_dispatch, follow};
use crate::kernels::trace::{Counters, TraceStatistics};

/// Lights connected to all sensors of a tile.
struct ToSensors<'t> {
    tracer: &'t ViewTracer<'t>,
    sensors: &'t Buffer,
    count: usize,
    sums: Buffer,
}

impl Gathering for ToSensors<'_> {
    fn start(&self, _: &LightPaths<'_>, _: u32, _: &mut TraceStatistics) -> Result<()> {
        Ok(())
    }

    fn gather(&self, paths: &LightPaths<'_>, seed: u32, statistics: &mut TraceStatistics) -> Result<()> {
        let (tracer, o) = (self.tracer, &self.tracer.options);
        let bins = tracer.tables.bins() as u32;
        let params = GatherParams {
            seed,
            sensors: self.count as u32,
            bins,
            lights: tracer.rounds.paths,
            batches: o.batches,
            near_radius: o.near_radius,
            padding_number: 0,
            padding: 0,
        };
        let params = tracer.device.uniform("gathering parameters", &params)?;
        tracer.device.write(&tracer.counters, &[Counters::default()])?;
        let bind = tracer.gather.bind(&tracer.scene.bindings(&[
            ("params", &params),
            ("sensors", self.sensors),
            ("lights", &paths.lights),
            ("light_counts", &paths.light_counts),
            ("sums", &self.sums),
            ("counters", &tracer.counters),
        ]))?;
        tracer.device.dispatch(&tracer.gather, &bind, [(self.count as u32).div_ceil(64), bins, o.batches])?;
        let runs = self.count as u64 * u64::from(bins * o.batches);
        finish_dispatch(tracer.device, &tracer.counters, runs, "gathering", statistics)?;
        statistics.segments += runs * u64::from(o.visibility_rays);
        Ok(())
    }
}

impl ViewTracer<'_> {
    pub(super) fn gathered_part(
        &self,
        sensors: &Buffer,
        receivers: &[Receiver],
        cells: usize,
        statistics: &mut TraceStatistics,
        stage: &dyn Fn(f64) -> Result<()>,
    ) -> Result<Vec<f32>> {
        let o = &self.options;
        let sums = self.device.zeros::<f32>("gathered view matrix", cells)?;
        let gathering = ToSensors { tracer: self, sensors, count: receivers.len(), sums };
        let paths = self.rounds.paths;
        let options = LightPathOptions {
            paths,
            batches: o.batches,
            bounces: o.bounces,
            seed: o.seed,
            room: paths,
            started: false,
            lists: self.tables.bins() as u32,
            first_list: 0,
            certain: 0,
        };
        let scene = (&self.tables, &self.scene);
        let stage = |part: f64| stage(0.2 + 0.8 * part);
        follow(self.device, scene, &self.light_paths, options, self.rounds, receivers, &gathering, statistics, &stage)?;
        self.device.read_finite(&gathering.sums)
    }
}

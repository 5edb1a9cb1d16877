//! What light paths from the windows bring to the sensors.

use super::{GatherParams, MOST_LIGHT_BYTES, ViewTracer};
use crate::error::Result;
use crate::gpu::Buffer;
use crate::kernels::light_paths::{LightPathOptions, LightPaths, Receiver, VirtualLight, finish_dispatch};
use crate::kernels::trace::{Counters, TraceStatistics, stream_seed};
use glam::DVec3;

/// Lights that are wanted within a sensor's near radius, see `ViewTracer::reach`.
const LIGHTS_NEARBY: f64 = 60.0;

impl ViewTracer<'_> {
    /// Light paths per bin and batch that fit into one binding of the device.
    pub(super) fn paths_per_round(&self) -> u32 {
        let per_path = size_of::<VirtualLight>() as u64 * u64::from(self.options.batches) * self.tables.bins() as u64;
        let limit = self.device.limits().max_storage_buffer_binding_size.min(MOST_LIGHT_BYTES);
        ((limit / per_path).max(1) as u32).min(self.options.light_paths)
    }

    pub(super) fn rounds(&self) -> u32 {
        self.options.light_paths.div_ceil(self.paths_per_round())
    }

    pub(super) fn gathered_part(
        &self,
        sensors: &Buffer,
        receivers: &[Receiver],
        cells: usize,
        statistics: &mut TraceStatistics,
        stage: &dyn Fn(f64) -> Result<()>,
    ) -> Result<Vec<f32>> {
        let o = &self.options;
        let count = receivers.len();
        let bins = self.tables.bins() as u32;
        let sums = self.device.zeros::<f32>("gathered view matrix", cells)?;
        let rounds = self.rounds();
        for round in 0..rounds {
            // The first round has the seed itself, so that small scenes do not depend on rounds.
            let seed = if round == 0 { o.seed } else { stream_seed(o.seed, round, 0x726f_756e) };
            let path_options = LightPathOptions {
                paths: self.paths_per_round(),
                batches: o.batches,
                bounces: o.bounces,
                seed,
                room: self.paths_per_round(),
            };
            let paths = LightPaths::new(self.device, &self.tables, &self.scene, &self.light_paths, path_options, Some(receivers))?;
            for vertex in 0..paths.most_vertices() {
                paths.forget()?;
                let go_on = paths.advance(vertex, statistics)?;
                let params = GatherParams {
                    seed: stream_seed(seed, vertex, 0x6761_7468),
                    sensors: count as u32,
                    bins,
                    lights: self.paths_per_round(),
                    batches: o.batches,
                    near_radius: o.near_radius,
                    padding_number: 0,
                    padding: 0,
                };
                let params = self.device.uniform("gathering parameters", &params)?;
                self.device.write(&self.counters, &[Counters::default()])?;
                let bind = self.gather.bind(&self.scene.bindings(&[
                    ("params", &params),
                    ("sensors", sensors),
                    ("lights", &paths.lights),
                    ("light_counts", &paths.light_counts),
                    ("sums", &sums),
                    ("counters", &self.counters),
                ]))?;
                self.device.dispatch(&self.gather, &bind, [(count as u32).div_ceil(64), bins, o.batches])?;
                let runs = count as u64 * u64::from(bins * o.batches);
                finish_dispatch(self.device, &self.counters, runs, "gathering", statistics)?;
                statistics.segments += runs * u64::from(o.visibility_rays);
                // The first vertices carry most of the light and most of the work.
                let part = f64::from(round) + 1.0 - 0.5f64.powi(vertex as i32 + 1);
                stage(0.2 + 0.8 * part / f64::from(rounds))?;
                if !go_on {
                    break;
                }
            }
        }
        self.device.read_finite(&sums)
    }

    /// By what the near radius of a sensor is multiplied. Of a small window far away few light paths come near
    /// the sensor; its surroundings are then left to the sensor's own paths, so far out that
    /// [`LIGHTS_NEARBY`] can be expected within them: of N paths that the window sends to all sides,
    /// N r² / (π d²) meet a disc of radius r at the distance d.
    pub(super) fn reach(&self, position: DVec3) -> f32 {
        let scale = self.tables.normalization.scale;
        let corners = self.windows.iter().flat_map(|w| w.triangles.iter().flatten());
        let distance = corners.map(|c| c.distance(position)).fold(f64::INFINITY, f64::min) * scale;
        let paths = f64::from(self.options.light_paths * self.options.batches) * self.tables.bins() as f64;
        let radius = distance * (LIGHTS_NEARBY * std::f64::consts::PI / paths).sqrt();
        (radius / f64::from(self.options.near_radius)).max(1.0) as f32
    }
}

//! Light paths in rounds that fit the device, one diffuse vertex after the other.

use super::{LightPathKernels, LightPathOptions, LightPaths, Receiver, VirtualLight};
use crate::error::Result;
use crate::gpu::Device;
use crate::kernels::trace::{TraceScene, TraceStatistics, TraceTables, stream_seed};
use glam::DVec3;

/// Virtual lights of one round, at most, bytes.
pub(crate) const MOST_LIGHT_BYTES: u64 = 1 << 27;
/// Lights that are wanted within a sensor's near radius, see [`reach`].
const LIGHTS_NEARBY: f64 = 60.0;

/// Some light paths per bin and batch, cut into rounds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rounds {
    /// Paths per bin and batch of a round that fit into one binding of the device.
    pub paths: u32,
    /// Number of rounds.
    pub rounds: u32,
}

impl Rounds {
    pub fn of(device: &Device, tables: &TraceTables, batches: u32, light_paths: u32) -> Self {
        let per_path = size_of::<VirtualLight>() as u64 * u64::from(batches) * tables.bins() as u64;
        let limit = device.limits().max_storage_buffer_binding_size.min(MOST_LIGHT_BYTES);
        let paths = ((limit / per_path).max(1) as u32).min(light_paths);
        Self { paths, rounds: light_paths.div_ceil(paths) }
    }

    /// Paths per bin and batch of all rounds.
    pub fn all(&self) -> u32 {
        self.paths * self.rounds
    }
}

/// What the light paths of a matrix start from, and what becomes of their lights.
pub(crate) trait Gathering {
    /// Puts the starts of the paths in their place, if they do not start from the windows evenly.
    fn start(&self, paths: &LightPaths<'_>, seed: u32, statistics: &mut TraceStatistics) -> Result<()>;
    /// Connects the lights of the last vertices.
    fn gather(&self, paths: &LightPaths<'_>, seed: u32, statistics: &mut TraceStatistics) -> Result<()>;
}

/// Follows all rounds of light paths; `stage` is told the part done. Lights of as many vertices are connected together as
/// there is room for all paths of a round.
///
/// # Errors
/// If the device fails or loses paths, or `stage` stops.
#[allow(clippy::too_many_arguments, reason = "each is a different thing")]
pub(crate) fn follow(
    device: &Device,
    (tables, scene): (&TraceTables, &TraceScene),
    kernels: &LightPathKernels,
    options: LightPathOptions,
    rounds: Rounds,
    receivers: &[Receiver],
    gathering: &dyn Gathering,
    statistics: &mut TraceStatistics,
    stage: &dyn Fn(f64) -> Result<()>,
) -> Result<()> {
    let together = (options.room / options.paths).max(1);
    for round in 0..rounds.rounds {
        // The first round has the seed itself, so that small scenes do not depend on rounds.
        let seed = if round == 0 { options.seed } else { stream_seed(options.seed, round, 0x726f_756e) };
        let path_options = LightPathOptions { paths: rounds.paths, room: rounds.paths * together, seed, ..options };
        let paths = LightPaths::new(device, tables, scene, kernels, path_options, Some(receivers))?;
        gathering.start(&paths, seed, statistics)?;
        for vertex in 0..paths.most_vertices() {
            if vertex % together == 0 {
                paths.forget()?;
            }
            let go_on = paths.advance(vertex, statistics)?;
            // After so many vertices, whatever their lights: what is found of a list depends on no other.
            if !go_on || (vertex + 1) % together == 0 || vertex + 1 == paths.most_vertices() {
                gathering.gather(&paths, stream_seed(seed, vertex / together, 0x6761_7468), statistics)?;
            }
            // The first vertices carry most of the light and most of the work.
            let part = f64::from(round) + 1.0 - 0.5f64.powi(vertex as i32 + 1);
            stage(part / f64::from(rounds.rounds))?;
            if !go_on {
                break;
            }
        }
    }
    Ok(())
}

/// By what the near radius of a sensor is multiplied. Of a small window far away few light paths come near
/// the sensor; its surroundings are then left to the sensor's own paths, so far out that
/// [`LIGHTS_NEARBY`] can be expected within them: of N paths that the window sends to all sides,
/// N r² / (π d²) meet a disc of radius r at the distance d. `corners` are the windows' in the user's coordinates.
pub(crate) fn reach<'c>(
    tables: &TraceTables,
    corners: impl Iterator<Item = &'c DVec3>,
    position: DVec3,
    (light_paths, batches): (u32, u32),
    near_radius: f32,
) -> f32 {
    let distance = corners.map(|c| c.distance(position)).fold(f64::INFINITY, f64::min) * tables.normalization.scale;
    let paths = f64::from(light_paths * batches) * tables.bins() as f64;
    let radius = distance * (LIGHTS_NEARBY * std::f64::consts::PI / paths).sqrt();
    (radius / f64::from(near_radius)).max(1.0) as f32
}

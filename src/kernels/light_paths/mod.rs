//! Light paths from the windows into the room, and paths from receivers for what they cannot give:
//! the parts that the view matrices of sensors and of pictures have in common.

pub(crate) mod doubts;
pub(crate) mod images;
mod near;
mod rounds;
mod sensors;

use crate::error::Result;
use crate::gpu::{BindGroup, Buffer, Device, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::trace::{self, Counters, FAR_AWAY, TraceScene, TraceStatistics, TraceTables, check_finished};

pub(crate) use near::{LOOK_UNITS, LOOKS, NEAR, NearOptions, NearPaths, near_paths};
pub(crate) use rounds::{Gathering, MOST_LIGHT_BYTES, Rounds, follow, reach};
pub(crate) use sensors::{beside_surface, check_sensors};

gpu_struct! {
    /// Parameters of `light_paths/paths`.
    pub(crate) struct LightPathParams {
        pub seed: u32,
        /// Paths per bin and batch, a power of two.
        pub paths: u32,
        /// Bins of all windows.
        pub bins: u32,
        pub window_count: u32,
        /// Number of this vertex, from 0. Vertex 0 starts the paths.
        pub vertex: u32,
        /// Whether another vertex follows.
        pub last: u32,
        pub batches: u32,
        /// 1 if all receivers have the same normal.
        pub common_normal: u32,
        /// Box around the receivers, and their normal if they have it in common.
        pub receivers_low: [f32; 3],
        /// Whether the paths are given as they leave the windows.
        pub started: u32,
        pub receivers_high: [f32; 3],
        /// Most diffuse reflections, with those before a path was given.
        pub most_bounces: u32,
        /// Vertices before roulette begins.
        pub certain: u32,
        pub padding0: u32,
        pub padding1: u32,
        pub padding2: u32,
        pub normal: [f32; 3],
        /// Number of the first bin, which chooses its random numbers.
        pub first_list: u32,
    }
}

gpu_struct! {
    /// Parameters of `light_paths/compact`.
    pub(crate) struct CompactParams {
        pub bins: u32,
        /// Light paths per bin and batch.
        pub paths: u32,
        pub batches: u32,
        /// Room for lights per bin and batch.
        pub room: u32,
    }
}

gpu_struct! {
    /// State of a light path between dispatches.
    pub(crate) struct LightPath {
        pub position: [f32; 3],
        /// 0 when it has ended.
        pub alive: u32,
        pub direction: [f32; 3],
        /// Random pairs used so far.
        pub pairs: u32,
        pub flux: [f32; 3],
        /// Of given paths: the sky patch or sun that their light comes from, 2^16 times its reflections outside (up to 2^15 - 1),
        /// and 2^31 if light paths of suns come that way.
        pub label: u32,
    }
}

gpu_struct! {
    /// A diffuse vertex of a light path.
    pub(crate) struct VirtualLight {
        pub position: [f32; 3],
        /// Sum of the flux's components.
        pub strength: f32,
        /// Of the side that emits, unit length.
        pub normal: [f32; 3],
        /// Whether its path goes on to another vertex.
        pub goes_on: u32,
        /// Flux that leaves diffusely; 0 where there is no light.
        pub flux: [f32; 3],
        /// That of its path.
        pub label: u32,
    }
}

gpu_struct! {
    /// A receiver in the tracer's coordinates.
    pub(crate) struct Receiver {
        pub position: [f32; 3],
        /// Number of the sensor or pixel: chooses its random numbers, whatever tile it is in.
        pub number: u32,
        /// Unit length.
        pub normal: [f32; 3],
        /// Of sensors of the view matrix: bits of an f32, by which `near_radius` is multiplied if it is above 1.
        /// Of surface points before a camera: 1 if they lie on a shade, where light comes from everywhere. Else 0.
        pub role: u32,
    }
}

/// Rounds of light paths after which an untruncated computation stops. Roulette ends all paths
/// before, also between walls of reflectance 0.999 (a thousand rounds).
const MOST_VERTICES: u32 = 1 << 14;
crate::gpu_constants! {
    pub(crate) const NUMBERS = {
        /// Workgroups of `light_paths/near` and `light_paths/images` along x; devices allow 65535 along each axis.
        pub(crate) const WORKGROUPS_PER_ROW: u32 = 16384;
    }
}

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<Shader> {
    vec![PATHS, COMPACT, NEAR, images::IMAGES]
}

const PATHS: Shader = trace::shader("light_paths/paths", &[&[LightPathParams::DECLARED, LightPath::DECLARED, VirtualLight::DECLARED]]);
const COMPACT: Shader = trace::shader("light_paths/compact", &[&[CompactParams::DECLARED, VirtualLight::DECLARED]]);
/// How many light paths, and how long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LightPathOptions {
    /// Per bin and batch.
    pub paths: u32,
    /// Batches.
    pub batches: u32,
    /// Radiance's `-ab`.
    pub bounces: Option<u32>,
    /// Seed of the matrix.
    pub seed: u32,
    /// Lights per bin and batch that are kept until [`LightPaths::forget`]; at least `paths`.
    pub room: u32,
    /// Whether [`LightPaths::paths`] is given its starts, rather than paths that leave the windows evenly.
    pub started: bool,
    /// Lists of paths: bins of all windows, or suns.
    pub lists: u32,
    /// Number of the first of them.
    pub first_list: u32,
    /// Vertices before roulette begins.
    pub certain: u32,
}

/// Light paths of all bins and batches, advanced by one diffuse vertex at a time.
pub(crate) struct LightPaths<'a> {
    device: &'a Device,
    scene: &'a TraceScene,
    options: LightPathOptions,
    bins: u32,
    window_count: u32,
    culling: LightPathParams,
    kernel: &'a LightPathKernels,
    /// `[batch][bin][path]`
    pub paths: Buffer,
    compact: BindGroup,
    counters: Buffer,
    vertex_lights: Buffer,
    /// Paths that go on, `[batch][bin]`.
    going_on: Buffer,
    /// `[batch][bin][light]`, with room for [`LightPathOptions::room`] lights.
    pub lights: Buffer,
    /// `[batch][bin]`
    pub light_counts: Buffer,
}

/// Compiled once, used for every tile.
pub(crate) struct LightPathKernels {
    paths: Kernel,
    compact: Kernel,
}

impl LightPathKernels {
    pub fn new(device: &Device) -> Result<Self> {
        Ok(Self { paths: Kernel::new(device, &PATHS, &[])?, compact: Kernel::new(device, &COMPACT, &[])? })
    }
}

impl<'a> LightPaths<'a> {
    /// Prepares the paths; `receivers` are those that will be lit, `None` if they are anywhere.
    pub(crate) fn new(
        device: &'a Device,
        tables: &TraceTables,
        scene: &'a TraceScene,
        kernel: &'a LightPathKernels,
        options: LightPathOptions,
        receivers: Option<&[Receiver]>,
    ) -> Result<Self> {
        let bins = options.lists;
        let total = (options.batches * bins * options.paths) as usize;
        let vertex_lights = device.zeros::<VirtualLight>("virtual lights of a vertex", total)?;
        let lights = device.zeros::<VirtualLight>("virtual lights", (options.batches * bins * options.room) as usize)?;
        let light_counts = device.zeros::<u32>("lights per bin", (options.batches * bins) as usize)?;
        let going_on = device.zeros::<u32>("paths that go on, per bin", (options.batches * bins) as usize)?;
        let counters = device.zeros::<Counters>("path counters", 1)?;
        let params =
            device.uniform("compaction", &CompactParams { bins, paths: options.paths, batches: options.batches, room: options.room })?;
        let compact = kernel.compact.bind(&[
            ("params", &params),
            ("vertex_lights", &vertex_lights),
            ("lights", &lights),
            ("light_counts", &light_counts),
            ("going_on", &going_on),
            ("counters", &counters),
        ])?;
        Ok(Self {
            device,
            scene,
            options,
            bins,
            window_count: tables.windows.len() as u32,
            culling: receivers.map_or_else(no_culling, culling_of),
            kernel,
            paths: device.zeros::<LightPath>("light paths", total)?,
            compact,
            counters,
            vertex_lights,
            going_on,
            lights,
            light_counts,
        })
    }

    /// Most diffuse vertices a path may have.
    pub(crate) fn most_vertices(&self) -> u32 {
        self.options.bounces.map_or(MOST_VERTICES, |b| b.saturating_sub(1))
    }

    /// Empties `lights`.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn forget(&self) -> Result<()> {
        self.device.write(&self.light_counts, &vec![0u32; (self.options.batches * self.bins) as usize])
    }

    /// Whether the lights of another vertex have room beside those that are kept.
    ///
    /// # Errors
    /// If the device fails.
    pub(crate) fn has_room(&self) -> Result<bool> {
        let kept = self.device.read::<u32>(&self.light_counts)?;
        let more = self.device.read::<u32>(&self.going_on)?;
        Ok(kept.iter().zip(&more).all(|(kept, more)| kept + more <= self.options.room))
    }

    /// Goes on to vertex number `vertex` (from 0) and adds its virtual lights to `lights`, which
    /// must have room for them. Returns whether paths are left that go on.
    ///
    /// # Errors
    /// If the device fails or loses paths.
    pub(crate) fn advance(&self, vertex: u32, statistics: &mut TraceStatistics) -> Result<bool> {
        let o = &self.options;
        let params = LightPathParams {
            seed: o.seed ^ 0x6c69_6768,
            paths: o.paths,
            bins: self.bins,
            window_count: self.window_count,
            vertex,
            last: u32::from(vertex + 1 == self.most_vertices()),
            batches: o.batches,
            first_list: o.first_list,
            certain: o.certain,
            started: u32::from(o.started),
            most_bounces: if o.started { o.bounces.map_or(u32::MAX, |b| b.saturating_sub(1)) } else { u32::MAX },
            ..self.culling
        };
        let params = self.device.uniform("light path parameters", &params)?;
        self.device.write(&self.counters, &[Counters::default()])?;
        let bind = self.kernel.paths.bind(&self.scene.bindings(&[
            ("params", &params),
            ("paths", &self.paths),
            ("lights", &self.vertex_lights),
            ("counters", &self.counters),
        ]))?;
        self.device.dispatch(&self.kernel.paths, &bind, [o.paths.div_ceil(64), self.bins, o.batches])?;
        let started = u64::from(o.paths) * u64::from(self.bins * o.batches);
        let alive = finish_dispatch(self.device, &self.counters, started, "light paths", statistics)?.alive;
        self.device.write(&self.counters, &[Counters::default()])?;
        self.device.dispatch(&self.kernel.compact, &self.compact, [self.bins.div_ceil(64), o.batches, 1])?;
        let mut ignored = TraceStatistics::default();
        finish_dispatch(self.device, &self.counters, u64::from(self.bins * o.batches), "compaction of lights", &mut ignored)?;
        Ok(alive > 0)
    }
}

/// Checks that all paths of the last dispatch finished and counts them.
pub(crate) fn finish_dispatch(
    device: &Device,
    counters: &Buffer,
    started: u64,
    what: &str,
    statistics: &mut TraceStatistics,
) -> Result<Counters> {
    let found = device.read::<Counters>(counters)?[0];
    check_finished(&found, started, what)?;
    statistics.paths += started;
    statistics.segments += u64::from(found.segments);
    Ok(found)
}

/// What `light_paths/paths` may leave out: lights that face away from all receivers, or lie behind all of
/// them.
fn culling_of(receivers: &[Receiver]) -> LightPathParams {
    let fold =
        |f: fn(f32, f32) -> f32, start: f32| receivers.iter().fold([start; 3], |a, r| std::array::from_fn(|i| f(a[i], r.position[i])));
    let normal = receivers.first().map_or([0.0; 3], |r| r.normal);
    LightPathParams {
        receivers_low: fold(f32::min, f32::INFINITY),
        receivers_high: fold(f32::max, f32::NEG_INFINITY),
        common_normal: u32::from(receivers.iter().all(|r| r.normal == normal)),
        normal,
        ..LightPathParams::default()
    }
}

fn no_culling() -> LightPathParams {
    LightPathParams { receivers_low: [-FAR_AWAY as f32; 3], receivers_high: [FAR_AWAY as f32; 3], ..LightPathParams::default() }
}

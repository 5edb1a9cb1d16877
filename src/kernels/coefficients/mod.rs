//! Daylight coefficients C: what each sensor receives from each patch of the sky through windows of clear glass.
//!
//! `C[sensor][patch]` is the irradiance at the sensor when the patch has radiance 1 (sr; what two-phase `rcontrib`
//! computes with the panes as `glass` in the scene). No directions are taken together at the windows, as the view
//! and daylight matrices do. All light counts, that which comes by no window too: of sensors in the open, of rooms
//! with holes. Patch 0 is the ground below the horizon.
//!
//! A path of light that crosses windows into rooms is cut where it does so first. Outside that point it is followed
//! as for the daylight matrix; inside, panes are glass among all other surfaces: they reflect into the room and
//! let light out, which may come back.
//!
//! | part | estimator | shader |
//! |---|---|---|
//! | straight from the windows' outer sides | windows sampled evenly in solid angle, a path outside each | `coefficients/direct` |
//! | reflected in the room | light paths from the windows, each after a path outside that tells its patch of the sky; their diffuse vertices serve *all* sensors | `coefficients/starts`, `light_paths/paths`, `coefficients/gather` |
//! | what these must leave out: very short connections, mirrors seen by the sensor; light by no window | paths from the sensor; at each diffuse vertex a ray to a window and a path outside | `coefficients/paths` |
//!
//! A sun lights few patches at a time, and few of all those paths come from them. So suns have samples of their own
//! ([`compute_suns`]), and each batch of C tells which part of it they replace (`sunlit`). Every path of light is in one of
//! these, told by what it meets after it left the sky, panes aside:
//!
//! | path | C's estimator | part of C | a sun's own |
//! |---|---|---|---|
//! | nothing but the sensor | `direct`; `paths` by no window | direct | [`sun_matrix`](crate::kernels::sun_matrix) |
//! | to a window, straight or last by a diffuse surface outside; in the room to a diffuse surface in sight of the sensor | `starts` and `gather`, short connections weighted down | sunlit | light paths, `coefficients/sun_starts` |
//! | last by a diffuse surface outside, then through a window to the sensor | `direct` | sunlit | surfaces that the sensor's rays through windows meet, `coefficients/sun_surfaces` |
//! | to a diffuse surface that a path from the sensor meets: what short connections lack, what lies behind mirrors or in the open, what these surfaces see through windows | `paths` | sunlit | the same of the sensor's own paths |
//! | last by a mirror or gloss outside, or in the room where no light path from a window stands for it | all of them | the rest | none: it stays in the sky's patches |
//!
//! The surfaces of a sensor serve all suns: to each some rays are sent (`coefficients/sun_gather`).
//!
//! All of it is repeated in independently scrambled batches; their spread is the standard error, with what few or no
//! hits leave open (see [`doubt`](crate::kernels::trace::doubt)).

mod doubts;
mod gathered;
mod options;
#[cfg(test)]
mod radiance_tests;
#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod sun_tests;
mod suns;
mod surfaces;
#[cfg(test)]
mod tests;
mod tracer;

use crate::bins::ReinhartSky;
use crate::error::Result;
use crate::gpu::{Declared, Device, Plan, Shader};
use crate::gpu_struct;
use crate::kernels::daylight_matrix::SkyRow;
use crate::kernels::light_paths::{LOOKS, LightPath, NUMBERS, Receiver, VirtualLight, check_sensors};
use crate::kernels::sun_matrix::SunRecord;
use crate::kernels::trace::{self, TraceStatistics, TraceTables, TracedBatch, TracedMatrix};
use crate::kernels::view_matrix::NUMBERS as RAY_NUMBERS;
use crate::matrix::Matrix;
use crate::progress::{Progress, cancelled};
use crate::scene::Scene;
use crate::scene::points::Sensor;
use doubts::Looks;
use gathered::Gathered;
use surfaces::SunSurface;
use tracer::Tracer;

pub use crate::scene::{GlazedWindow, Pane};
pub use options::CoefficientOptions;
pub(crate) use options::LEAST_SUN_PATHS;
pub use suns::compute_suns;
pub(crate) use surfaces::SURFACE_RAYS;

gpu_struct! {
    /// Parameters of this module's kernels.
    pub(crate) struct CoefficientParams {
        seed: u32,
        sensors: u32,
        /// Per sensor and batch; light paths per bin and batch.
        samples: u32,
        batches: u32,
        /// Sky patches with the ground.
        patches: u32,
        window_count: u32,
        /// Index of the material of the first window's pane.
        first_pane: u32,
        /// Most diffuse reflections of a path, outside and inside together.
        most_bounces: u32,
        /// Fixed-point units per sr.
        unit: f32,
        near_radius: f32,
        roulette_weight: f32,
        /// Whether light may come by no window.
        open: u32,
        sky_rows: u32,
        row_height: f32,
        /// Of all windows; in place of them suns, where light paths start from these.
        bins: u32,
        /// Number of the first of them; of the first sensor, where suns are connected to surfaces.
        first_list: u32,
        /// Lights of each of them that there is room for.
        room: u32,
        /// The part of the sums that light in ways which light paths of suns have belongs to.
        sunlit: u32,
        /// Paths of each sun that come straight from it; of a sensor that go through its windows.
        straight: u32,
        /// Sets of surfaces that suns take turns in using.
        sets: u32,
    }
}

/// Sensors of a tile, at most: bounds the time of a dispatch.
const MOST_TILE_SENSORS: usize = 1024;
/// Sensors times suns times batches of one dispatch: bounds its time.
const MOST_PAIRS: usize = 1 << 20;

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<Shader> {
    vec![DIRECT, PATHS, STARTS, GATHER, suns::STARTS, surfaces::SURFACES, surfaces::GATHER]
}

const STRUCTS: &[Declared] = &[
    CoefficientParams::DECLARED,
    Receiver::DECLARED,
    SkyRow::DECLARED,
    LightPath::DECLARED,
    VirtualLight::DECLARED,
    SunRecord::DECLARED,
    SunSurface::DECLARED,
];
const DIRECT: Shader = trace::shader("coefficients/direct", &[LOOKS, STRUCTS]);
const PATHS: Shader = trace::shader("coefficients/paths", &[LOOKS, NUMBERS, STRUCTS]);
const STARTS: Shader = trace::shader("coefficients/starts", &[STRUCTS]);
const GATHER: Shader = trace::shader("coefficients/gather", &[RAY_NUMBERS, STRUCTS]);

/// Computes C for `sensors`: rows sensors, columns the sky's patches with the ground first, RGB. `windows` may be empty.
/// Their panes are surfaces of the scene; all other windows that the scene knows absorb
/// ([`scene::windows`](crate::scene::windows)). The direct part has been reflected nowhere (Cd of five phases, panes included).
///
/// # Errors
/// If a sensor has no direction or a window no area, if the device fails or loses paths, or when stopped by
/// `progress`.
pub fn compute(
    device: &Device,
    scene: &Scene,
    windows: &[GlazedWindow],
    sensors: &[Sensor],
    sky: ReinhartSky,
    options: &CoefficientOptions,
    progress: &dyn Progress,
) -> Result<TracedMatrix> {
    check_sensors(sensors)?;
    options.check()?;
    let around: Vec<glam::DVec3> = sensors.iter().map(|s| s.position).collect();
    let tables = TraceTables::with_panes(scene, windows, &around)?;
    let (rows, patches, batches) = (sensors.len(), sky.len(), options.batches as usize);
    let mut tracer = Tracer::new(device, tables, windows, rows, sky, options)?;
    let zeros = || Matrix::zeros(rows, patches, 3);
    let empty = TracedBatch { total: zeros(), direct: zeros(), sunlit: options.sun_paths.map(|_| zeros()) };
    let mut result = TracedMatrix {
        total: Matrix::zeros(rows, patches, 3),
        direct: Matrix::zeros(rows, patches, 3),
        standard_error: Matrix::zeros(rows, patches, 3),
        batches: if options.keep_batches { vec![empty; batches] } else { Vec::new() },
        statistics: TraceStatistics::default(),
    };
    let mut looks = Vec::with_capacity(rows);
    let plan = Plan::new(device, options.memory, rows, &[tracer.bytes_per_sensor(), tracer.bytes_per_sensor()], &[], 1)?
        .at_most(MOST_TILE_SENSORS);
    for chunk in plan.chunks() {
        tracer.look_for_holes(&sensors[chunk.first..chunk.first + chunk.count], chunk.first, &mut result.statistics)?;
    }
    let mut state = (result, Vec::new());
    for chunk in plan.chunks() {
        let stage = |part: f64| {
            progress.update("daylight coefficients", (chunk.first as f64 + part * chunk.count as f64) / rows as f64);
            if progress.stop_requested() { Err(cancelled()) } else { Ok(()) }
        };
        let tile = &sensors[chunk.first..chunk.first + chunk.count];
        let mut make = |state: &mut (TracedMatrix, Vec<Looks>)| {
            state.1 = tracer.compute_tile(tile, chunk.first, &mut state.0, &stage)?;
            Ok(())
        };
        let range = chunk.first..chunk.first + chunk.count;
        state.1 = vec![Looks::default(); chunk.count];
        trace::unit(progress, &format!("sensors {range:?}"), &mut state, &mut make, &|(result, looks), values| {
            values.pass_traced(result, &range)?;
            looks.iter_mut().try_for_each(|look| look.pass(values))
        })?;
        looks.append(&mut state.1);
    }
    let (mut result, _) = state;
    if options.first_round {
        doubts::add(&mut result, &looks, sky, options, tracer.paths_to_the_sky());
    }
    progress.update("daylight coefficients", 1.0);
    Ok(result)
}

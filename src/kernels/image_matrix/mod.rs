//! View matrix of a picture: one row per pixel.
//!
//! `V[pixel][bin]` is the radiance that the pixel shows when the windows emit radiance 1 into the
//! directions of that bin (dimensionless). Windows seen directly are counted exactly on a fixed
//! grid of rays in each pixel; behind every pixel lies, per batch, one point of a diffuse surface
//! whose irradiance is found as for sensors (see [`view_matrix`](super::view_matrix)), with few
//! rays per pixel for all bins together:
//!
//! | step | shader |
//! |---|---|
//! | windows seen directly; the surface point behind each pixel | `image_matrix/receivers` |
//! | direct irradiance from the windows | `image_matrix/direct` |
//! | light paths shared by all pixels | `light_paths/paths`, `image_matrix/gather` |
//! | short connections, mirrors | `light_paths/near` |
//! | the windows' images in plane smooth surfaces, by one reflection | `light_paths/images` |
//!
//! The share of light that arrives in a bin is estimated from that bin's rays and, where it has
//! few, from those of the whole pixel: exact where nothing is in the way. All bins together have what the rays
//! found, so that a pixel's brightness under an even window has no bias. What few rays leave open
//! is part of the stated errors.

pub mod doubts;
#[cfg(test)]
mod image_tests;
#[cfg(test)]
mod tests;
mod tracer;

use crate::camera::{PixelSamples, Raster};
use crate::error::{Error, Result};
use crate::gpu::{DEFAULT_MEMORY, Declared, Device, Plan, Shader};
use crate::gpu_struct;
use crate::kernels::light_paths::{LOOKS, Receiver, VirtualLight};
use crate::kernels::trace::{self, ROULETTE_WEIGHT, TraceStatistics, TraceTables, WindowSurfaces};
use crate::progress::{Progress, cancelled};
use crate::scene::{Scene, Window};
use tracer::{ImageTracer, TracedTile};

gpu_struct! {
    /// Parameters of the tile's kernels (`shared/pixel.wgsl`).
    pub(crate) struct TileParams {
        seed: u32,
        /// Pixels of this tile.
        pixels: u32,
        /// Light paths per bin and batch, all of which are summed.
        paths: u32,
        batches: u32,
        bins: u32,
        window_count: u32,
        /// Rays per pixel through which the directly seen windows are found.
        subpixels: u32,
        /// Window samples per surface point, and every how many one is traced.
        window_samples: u32,
        traced_every: u32,
        /// Room for lights per bin and batch.
        lights: u32,
        near_radius: f32,
        /// Fixed-point units of a whole pixel.
        unit: f32,
    }
}

gpu_struct! {
    /// A camera ray in the tracer's coordinates (`image_matrix/receivers.wgsl`).
    pub(crate) struct PixelRay {
        origin: [f32; 3],
        /// How far it goes; 0 for pixels outside the view.
        length: f32,
        direction: [f32; 3],
        /// Number of the pixel in the picture.
        number: u32,
    }
}

gpu_struct! {
    /// A pixel's surface point in a batch, and what few hits leave open of its irradiance, sr.
    pub(crate) struct PixelPoint {
        /// Radiance that the pixel shows per irradiance of the point; 0 where there is none.
        weight: [f32; 3],
        /// Direct light of the windows: with nothing in the way; how many rays, and how many of them arrived.
        direct: f32,
        rays: f32,
        hits: f32,
        /// By light paths: sum of what the rays stand for, of its squares, and of those that arrived.
        gathered: f32,
        gathered_squares: f32,
        gathered_hits: f32,
        padding0: f32,
        padding1: f32,
        padding2: f32,
    }
}

gpu_struct! {
    /// Per bin while a row is built: unobstructed light, and of the traced part how much was sent and
    /// how much arrived.
    pub(crate) struct BinShare {
        unobstructed: [f32; 3],
        traced: f32,
        arrived: [f32; 3],
        padding: u32,
    }
}

impl PixelRay {
    /// A ray of some length (0: none) from pixel number `number`.
    pub(crate) fn new(origin: [f32; 3], length: f32, direction: [f32; 3], number: u32) -> Self {
        Self { origin, length, direction, number }
    }
}

/// How much to sample. Every number is per pixel or bin *and batch*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageOptions {
    /// Radiance's `-ab`: 0 shows only the windows, 1 adds what they light directly; `None` does not
    /// truncate.
    pub bounces: Option<u32>,
    /// Independent repetitions, each with its own surface point in every pixel. At least 2.
    pub batches: u32,
    /// Rays per pixel for directly seen windows; at least `batches`.
    pub subpixels: u32,
    /// Samples of the windows per surface point.
    pub window_samples: u32,
    /// Every how many of them a ray is traced.
    pub traced_every: u32,
    /// Light paths per bin.
    pub light_paths: u32,
    /// Rays per pixel and reflection to the light paths' vertices; at most 64.
    pub visibility_rays: u32,
    /// Paths per pixel for short connections and mirrors.
    pub near_samples: u32,
    /// Connections shorter than this multiple of the windows' size are left to `near_samples`.
    pub near_radius: f32,
    /// Path weight below which Russian roulette decides.
    pub roulette_weight: f32,
    /// Part of the pixel over which samples are spread (`vwrays -pj`).
    pub jitter: f64,
    /// Same seed, same device: same bits.
    pub seed: u32,
    /// Whether the direct part is kept too (Vd).
    pub direct: bool,
    /// Device memory to use, bytes.
    pub memory: u64,
}

impl Default for ImageOptions {
    fn default() -> Self {
        Self {
            bounces: None,
            batches: 4,
            subpixels: 16,
            window_samples: 64,
            traced_every: 4,
            light_paths: 16,
            visibility_rays: 8,
            near_samples: 16,
            near_radius: 0.15,
            roulette_weight: ROULETTE_WEIGHT,
            jitter: 1.0,
            seed: 1,
            direct: false,
            memory: DEFAULT_MEMORY,
        }
    }
}

crate::gpu_constants! {
    const NUMBERS = {
        /// Most rays from a surface point to the vertices of one bin.
        const MOST_VISIBILITY_RAYS: u32 = 64;
    }
}

/// Rays to each image of the windows, at least.
const LEAST_IMAGE_RAYS: u32 = 4;
/// Lights of all bins that an invocation of `image_matrix/gather` goes through, at most.
const MOST_LIGHTS: u32 = 1 << 14;
/// Vertices of light paths whose lights are connected together, at least.
const VERTICES_KEPT: u32 = 4;
/// Pixels of a tile, at most: bounds the time of a dispatch.
const MOST_TILE_PIXELS: usize = 8192;

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<Shader> {
    vec![RECEIVERS, DIRECT, GATHER]
}

const STRUCTS: &[Declared] =
    &[TileParams::DECLARED, PixelRay::DECLARED, PixelPoint::DECLARED, BinShare::DECLARED, Receiver::DECLARED, VirtualLight::DECLARED];
const RECEIVERS: Shader = trace::shader("image_matrix/receivers", &[LOOKS, STRUCTS]);
const DIRECT: Shader = trace::shader("image_matrix/direct", &[STRUCTS]);
const GATHER: Shader = trace::shader("image_matrix/gather", &[NUMBERS, STRUCTS]);

/// Rows of some consecutive pixels (row-major from the top left).
#[derive(Debug, Clone, PartialEq)]
pub struct PixelRows {
    /// Number of the first pixel.
    pub first: usize,
    /// Number of pixels.
    pub pixels: usize,
    /// `[pixel][bin][rgb]`
    pub values: Vec<f32>,
    /// Standard error of each value: the spread of the batches, and the doubts.
    pub standard_error: Vec<f32>,
    /// What few rays leave open, which the batches do not know of.
    pub doubts: doubts::PixelDoubts,
    /// The part seen without any diffuse reflection: the windows themselves.
    pub direct_view: Vec<f32>,
    /// The independent estimates that `values` is the mean of: `[pixel][batch][bin][rgb]`.
    pub batches: Vec<f32>,
    /// The part of `values` that comes directly from the windows: they themselves, and surfaces that
    /// they light directly; never larger. Empty unless asked for.
    pub direct: Vec<f32>,
}

/// What is known of a picture before it is computed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct KnownPixels {
    /// So many of the first pixels.
    pub count: usize,
    /// Whether light reaches any of them.
    pub lit: bool,
}

/// Computes the view matrix of a picture and hands it over tile by tile, in order of the pixels, so
/// that it never has to be in memory as a whole. Pixels outside the view are zero and cost
/// nothing.
///
/// # Errors
/// If there is no window, the options make no sense, no light reaches the picture, the device
/// fails or loses paths, `sink` fails, or when stopped by `progress`.
pub fn compute(
    device: &Device,
    scene: &Scene,
    windows: &[Window],
    raster: &Raster,
    options: &ImageOptions,
    progress: &dyn Progress,
    sink: &mut dyn FnMut(PixelRows) -> Result<()>,
) -> Result<TraceStatistics> {
    go_on(device, scene, windows, raster, options, KnownPixels::default(), progress, sink)
}

/// The same without the first pixels, which are known; the others are what they would be with them.
///
/// # Errors
/// As [`compute`].
#[allow(clippy::too_many_arguments, reason = "each is a different thing")]
pub fn go_on(
    device: &Device,
    scene: &Scene,
    windows: &[Window],
    raster: &Raster,
    options: &ImageOptions,
    known: KnownPixels,
    progress: &dyn Progress,
    sink: &mut dyn FnMut(PixelRows) -> Result<()>,
) -> Result<TraceStatistics> {
    let o = options;
    if o.batches < 2 || o.subpixels < o.batches || o.window_samples == 0 || o.traced_every == 0 || o.light_paths == 0 {
        return Err(Error::new("a picture needs at least two batches, as many subpixels, and samples of everything"));
    }
    if !(1..=MOST_VISIBILITY_RAYS).contains(&o.visibility_rays) {
        return Err(Error::new(format!("{} visibility rays are outside 1 to {MOST_VISIBILITY_RAYS}", o.visibility_rays)));
    }
    let tables = TraceTables::new(scene, windows, WindowSurfaces::Absorb)?;
    let tracer = ImageTracer::new(device, windows, tables, o)?;
    let mut statistics = TraceStatistics::default();
    let bins = tracer.tables.bins() as u64;
    let batches = u64::from(o.batches);
    let per_pixel = [batches * bins * 32, batches * bins * 12, batches * bins * 12, batches * bins * 12, u64::from(o.subpixels) * 32];
    let open = raster.len() - known.count;
    let plan = Plan::new(device, o.memory, open, &per_pixel, &[], 1)?.at_most(MOST_TILE_PIXELS);
    let samples = PixelSamples::new(o.subpixels as usize, o.jitter, u64::from(o.seed))?;
    let mut lit = known.lit;
    for chunk in plan.chunks() {
        let first = known.count + chunk.first;
        progress.update("view matrix of the picture", first as f64 / raster.len() as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let rows = tracer.tile(raster, &samples, first, chunk.count, &mut statistics)?;
        lit |= rows.values.iter().any(|v| *v != 0.0);
        sink(rows)?;
    }
    // With few bounces a camera may look where none of the light goes.
    if !lit && o.bounces.is_none_or(|b| b > 2) {
        return Err(Error::new("no light of any window reaches the picture")
            .help("is the camera inside a wall or a piece of furniture, or outside the room? Move it"));
    }
    progress.update("view matrix of the picture", 1.0);
    Ok(statistics)
}

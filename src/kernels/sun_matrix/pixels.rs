//! Suns in pictures: what each pixel shows of each sun.
//!
//! `C[pixel][sun]` is the radiance that the pixel shows per unit radiance of the sun's disc. Two
//! parts: surfaces of the room and slats that the sun lights (irradiance at the point behind the
//! pixel × ρ/π, as the tutorial's irradiance picture × material map), and the disc itself where it is
//! seen through the shade. The disc's energy is laid on the pixels it covers, point by point, so that
//! a sun smaller than a pixel shows as bright as it is at the eye, never missed and never doubled.
//! Entries are sparse, sun by sun.

use super::Sun;
use super::geometry::{Gate, Openings, SunOptions, SunTracer};
use crate::camera::{PixelSamples, Raster};
use crate::error::Result;
use crate::gpu::{Device, Kernel};
use crate::gpu_struct;
use crate::kernels::image_matrix::PixelRay;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{TraceStatistics, TraceTables, WindowSurfaces, stream_seed};
use crate::progress::{Progress, cancelled};
use crate::scene::{Scene, Window};
use crate::units::ILLUMINANCE_WEIGHTS;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

gpu_struct! {
    /// Parameters of `trace/sun_pixels`.
    pub(crate) struct SunPixelParams {
        seed: u32,
        pixels: u32,
        batches: u32,
        window_count: u32,
        first_shade: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

gpu_struct! {
    /// A ray to a point of a sun's disc.
    pub(crate) struct SunRay {
        origin: [f32; 3],
        padding0: u32,
        direction: [f32; 3],
        padding1: u32,
    }
}

gpu_struct! {
    /// Parameters of `trace/sun_rays`.
    pub(crate) struct SunRayParams {
        rays: u32,
        gates: u32,
        padding0: u32,
        padding1: u32,
    }
}

/// Points of a disc whose rays are traced from the eye.
const DISC_POINTS: usize = 256;
/// Rays of one dispatch.
const MOST_RAYS: usize = 1 << 20;
/// Most pixels of a tile.
const MOST_TILE: usize = 4096;

/// Shaders of this module, for the tests.
pub(super) fn registered() -> Vec<crate::gpu::Registered> {
    use crate::gpu::Registered;
    vec![
        Registered::new("trace/sun_pixels").with::<SunPixelParams>().with::<PixelRay>().with::<Receiver>(),
        Registered::new("trace/sun_rays").with::<SunRayParams>().with::<SunRay>().with::<Gate>(),
    ]
}

/// Pixels in rising order and their values.
pub type SparsePicture = Vec<(u32, [f32; 3])>;

/// What one sun puts into a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct SunPicture {
    /// Radiance per radiance of the disc.
    pub pixels: SparsePicture,
    /// Standard error of each pixel's luminance, cd/m² per W/m²sr of the disc, from the spread of the
    /// batches. Every pixel has surface points, points of the disc and paths of its own, so that
    /// errors of pixels are independent. Pixels of the disc itself have none.
    pub errors: Vec<f32>,
}

/// The scene twice: as it looks, and black but for the shades, for what the sun does in it.
pub struct Models<'a> {
    /// Scene and shades with all their materials.
    pub lit: &'a Scene,
    /// The black model.
    pub black: &'a Scene,
    /// Materials of the shades in both begin here.
    pub first_shade: u32,
    /// Windows with the corners of their shades.
    pub shaded: &'a [(Window, Vec<DVec3>)],
}

/// Pictures of a group of suns, in their order. The memory for all of them is the caller's concern:
/// hand over as many suns at once as it holds pictures.
///
/// # Errors
/// As [`geometry::compute`](super::geometry::compute).
pub fn compute(
    device: &Device,
    models: &Models<'_>,
    raster: &Raster,
    suns: &[Sun],
    options: &SunOptions,
    progress: &dyn Progress,
    statistics: &mut TraceStatistics,
) -> Result<Vec<SunPicture>> {
    let mut pictures: Vec<Pixels> = vec![BTreeMap::new(); suns.len()];
    if suns.is_empty() {
        return Ok(Vec::new());
    }
    let openings = Openings::Shaded(models.shaded);
    let tracer = SunTracer::new(device, models.black, openings, &[], suns, options)?;
    surfaces(device, models, raster, &tracer, options, progress, statistics, &mut pictures)?;
    discs(device, raster, &tracer, suns, statistics, &mut pictures)?;
    let whole = |p: Pixels| {
        let errors = p.values().map(|(_, error)| *error).collect();
        SunPicture { pixels: p.into_iter().map(|(pixel, (value, _))| (pixel, value)).collect(), errors }
    };
    Ok(pictures.into_iter().map(whole).collect())
}

/// Value and error by pixel.
type Pixels = BTreeMap<u32, ([f32; 3], f32)>;

/// Surfaces that suns light.
#[allow(clippy::too_many_arguments, reason = "private; each is a different thing")]
fn surfaces(
    device: &Device,
    models: &Models<'_>,
    raster: &Raster,
    tracer: &SunTracer<'_>,
    options: &SunOptions,
    progress: &dyn Progress,
    statistics: &mut TraceStatistics,
    pictures: &mut [Pixels],
) -> Result<()> {
    let windows: Vec<Window> = models.shaded.iter().map(|(w, _)| w.clone()).collect();
    let tables = TraceTables::new(models.lit, &windows, WindowSurfaces::Open)?;
    let scene = tables.upload(device)?;
    let kernel = Kernel::new(device, "trace/sun_pixels", &[], &[])?;
    let batches = options.batches as usize;
    let samples = PixelSamples::new(batches, 1.0, u64::from(options.seed))?;
    let inside: Vec<usize> = (0..raster.len()).filter(|&p| raster.is_seen(p % raster.width(), p / raster.width())).collect();
    for chunk in tracer.plan(inside.len())?.at_most(MOST_TILE).chunks() {
        progress.update("suns in the picture", chunk.first as f64 / inside.len() as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let tile = &inside[chunk.first..chunk.first + chunk.count];
        let rays: Vec<PixelRay> = (0..batches)
            .flat_map(|batch| tile.iter().map(move |&pixel| (batch, pixel)))
            .map(|(batch, pixel)| pixel_ray(&tables, raster, &samples, pixel, batch))
            .collect();
        let count = tile.len();
        let params = SunPixelParams {
            seed: stream_seed(options.seed, 0, 0x7375_6e78),
            pixels: count as u32,
            batches: options.batches,
            window_count: windows.len() as u32,
            first_shade: models.first_shade,
            ..SunPixelParams::default()
        };
        let params = device.uniform("pixels that see suns' light", &params)?;
        let rays = device.upload("camera rays", &rays)?;
        let receivers = device.zeros::<Receiver>("receivers of the pixels", batches * count)?;
        let weights = device.zeros::<[f32; 4]>("weights of the receivers", batches * count)?;
        let own = [("params", &params), ("rays", &rays), ("receivers", &receivers), ("receiver_weights", &weights)];
        let groups = [(count as u32).div_ceil(64), options.batches, 1];
        tracer.run_in(&scene, &kernel, &own, groups, (count * batches) as u64, statistics)?;
        let sums = tracer.trace(&receivers, count, count as u32, statistics)?;
        let weights = device.read::<[f32; 4]>(&weights)?;
        let n = pictures.len();
        pictures.par_iter_mut().enumerate().for_each(|(sun, picture)| {
            let mut luminance = vec![0.0f64; batches];
            for (i, &pixel) in tile.iter().enumerate() {
                let mut value = [0.0f32; 3];
                for (batch, luminance) in luminance.iter_mut().enumerate() {
                    let cell = &sums[((batch * count + i) * n + sun) * 6..][..6];
                    *luminance = 0.0;
                    for c in 0..3 {
                        let shown = (cell[c] + cell[c + 3]) * weights[batch * count + i][c];
                        value[c] += shown / batches as f32;
                        *luminance += ILLUMINANCE_WEIGHTS[c] * f64::from(shown);
                    }
                }
                if value.iter().any(|v| *v > 0.0) {
                    picture.insert(pixel as u32, (value, standard_error_of_mean(&luminance) as f32));
                }
            }
        });
    }
    Ok(())
}

/// Standard error of the mean of independent values; 0 of less than two.
fn standard_error_of_mean(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    if n < 2.0 { 0.0 } else { (squares / (n * (n - 1.0))).sqrt() }
}

fn pixel_ray(tables: &TraceTables, raster: &Raster, samples: &PixelSamples, pixel: usize, sample: usize) -> PixelRay {
    let (column, row) = (pixel % raster.width(), pixel / raster.width());
    // At the rim a sample may fall outside the view although the centre is inside.
    let ray = raster.sample(column, row, samples.offset(pixel, sample)).or_else(|| raster.ray(column, row));
    ray.map_or_else(
        || PixelRay::new([0.0; 3], 0.0, [0.0, 0.0, 1.0], pixel as u32),
        |r| {
            let length = if r.length > 0.0 { (r.length * tables.normalization.scale) as f32 } else { 1e30 };
            PixelRay::new(tables.normalization.point(r.origin).to_array(), length, r.direction.as_vec3().to_array(), pixel as u32)
        },
    )
}

/// Discs seen through shades, each point of a disc laid on the pixel it falls into.
fn discs(
    device: &Device,
    raster: &Raster,
    tracer: &SunTracer<'_>,
    suns: &[Sun],
    statistics: &mut TraceStatistics,
    pictures: &mut [Pixels],
) -> Result<()> {
    let solid_angles = raster.solid_angles();
    // Rays with the sun and the pixel they belong to, and what they add there.
    let mut rays: Vec<SunRay> = Vec::new();
    let mut places: Vec<(usize, u32, f32)> = Vec::new();
    for (number, sun) in suns.iter().enumerate() {
        let points = if sun.radius == 0.0 { 1 } else { DISC_POINTS };
        for direction in disc(sun, points) {
            let Some((column, row)) = raster.pixel_of(direction) else { continue };
            if !raster.is_seen(column, row) {
                continue;
            }
            let pixel = row * raster.width() + column;
            let omega = if solid_angles[pixel] > 0.0 { solid_angles[pixel] } else { raster.plain_solid_angle(column, row) };
            let Some(eye) = raster.ray(column, row) else { continue };
            if omega <= 0.0 {
                continue;
            }
            rays.push(SunRay {
                origin: tracer.point(eye.origin).to_array(),
                direction: direction.as_vec3().normalize().to_array(),
                ..SunRay::default()
            });
            places.push((number, pixel as u32, (sun.solid_angle() / points as f64 / omega) as f32));
        }
    }
    for (rays, places) in rays.chunks(MOST_RAYS).zip(places.chunks(MOST_RAYS)) {
        let passed = transmitted(device, tracer, rays, statistics)?;
        for ((sun, pixel, share), passed) in places.iter().zip(passed) {
            if passed[0] + passed[1] + passed[2] > 0.0 {
                let (value, _) = pictures[*sun].entry(*pixel).or_default();
                for c in 0..3 {
                    value[c] += passed[c] * share;
                }
            }
        }
    }
    Ok(())
}

fn transmitted(device: &Device, tracer: &SunTracer<'_>, rays: &[SunRay], statistics: &mut TraceStatistics) -> Result<Vec<[f32; 4]>> {
    let params = SunRayParams { rays: rays.len() as u32, gates: tracer.gates().1, padding0: 0, padding1: 0 };
    let params = device.uniform("rays to suns", &params)?;
    let buffer = device.upload("rays to suns", rays)?;
    let passed = device.zeros::<[f32; 4]>("light of suns", rays.len())?;
    let kernel = Kernel::new(device, "trace/sun_rays", &[], &tracer.panes())?;
    let own = [("params", &params), ("rays", &buffer), ("passed", &passed), ("gates", tracer.gates().0)];
    let groups = device.grid((rays.len() as u64).div_ceil(64))?;
    tracer.run_in(tracer.scene(), &kernel, &own, groups, rays.len() as u64, statistics)?;
    device.read(&passed)
}

/// Points of a disc, evenly spread (golden spiral), uniform in solid angle.
fn disc(sun: &Sun, points: usize) -> impl Iterator<Item = DVec3> {
    let x = sun.direction.any_orthonormal_vector();
    let y = sun.direction.cross(x);
    let (direction, whole) = (sun.direction, sun.chord());
    (0..points).map(move |i| {
        let chord = whole * ((i as f64 + 0.5) / points as f64).sqrt();
        let sine = chord * (1.0 - chord * chord / 4.0).sqrt();
        let phi = TAU * 0.618_033_988_749_895 * i as f64;
        (x * (phi.cos() * sine) + y * (phi.sin() * sine) + direction * (1.0 - chord * chord / 2.0)).normalize()
    })
}

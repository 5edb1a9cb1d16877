//! Discs of suns seen through slats and panes, each point of a disc laid on the pixel it falls into so
//! that the eye gets its illuminance: Ω·cosθ of the point over Ω·cosθ of the pixel, whose centre may
//! be a degree away. The sun's images in mirror-like slats are discs as well, where the image stands.

use super::super::Sun;
use super::super::geometry::{Gate, SunTracer};
use super::Pixels;
use crate::camera::Raster;
use crate::error::Result;
use crate::glare::PixelGeometry;
use crate::gpu::{Device, Kernel};
use crate::gpu_struct;
use crate::kernels::trace::TraceStatistics;
use glam::{DVec3, Mat3};
use std::f64::consts::TAU;

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
        image_x: [f32; 3],
        padding2: u32,
        image_y: [f32; 3],
        padding3: u32,
        image_z: [f32; 3],
        padding4: u32,
    }
}

/// Points of a disc whose rays are traced from the eye.
const DISC_POINTS: usize = 1024;
/// Cosine with the direction of view below which a disc is at the rim (85°).
const RIM: f64 = 0.087;
/// Rays of one dispatch.
const MOST_RAYS: usize = 1 << 20;

/// Shaders of this module, for the tests.
pub(super) fn registered() -> crate::gpu::Registered {
    crate::gpu::Registered::new("trace/sun_rays").with::<SunRayParams>().with::<SunRay>().with::<Gate>()
}

/// What stands between the eye and discs.
pub(super) struct Way<'a> {
    /// The geometry.
    pub tracer: &'a SunTracer<'a>,
    /// What beside it passes the window along a ray (origin, direction).
    pub filter: &'a dyn Fn(DVec3, DVec3) -> [f64; 3],
    /// Whether mirrors are met: behind panes of scattering data none are.
    pub images: bool,
}

/// Adds what the eye sees of the discs.
pub(super) fn add(
    device: &Device,
    raster: &Raster,
    way: &Way<'_>,
    suns: &[Sun],
    statistics: &mut TraceStatistics,
    pictures: &mut [Pixels],
) -> Result<()> {
    let pixels = PixelSizes {
        raster,
        solid_angles: raster.solid_angles(),
        projected: PixelGeometry::new(raster).map(|g| g.projected_solid_angles).unwrap_or_default(),
    };
    let images = if way.images { way.tracer.images() } else { &[] };
    let [panes, may_enter] = way.tracer.constants();
    let kernel = |mirrored: f64| Kernel::new(device, "trace/sun_rays", &[], &[panes, may_enter, ("MIRRORED", mirrored)]);
    let (straight, mirrored) = (kernel(0.0)?, if images.is_empty() { None } else { Some(kernel(1.0)?) });
    for image in std::iter::once(None).chain(images.iter().map(Some)) {
        let kernel = mirrored.as_ref().filter(|_| image.is_some()).unwrap_or(&straight);
        for (first, suns) in (0..).step_by(MOST_RAYS / DISC_POINTS).zip(suns.chunks(MOST_RAYS / DISC_POINTS)) {
            let (rays, places) = rays(&pixels, way, suns, image);
            if rays.is_empty() {
                continue;
            }
            let passed = transmitted(device, way.tracer, kernel, &rays, image, statistics)?;
            for ((sun, pixel, share), passed) in places.iter().zip(passed) {
                if passed[0] + passed[1] + passed[2] > 0.0 {
                    let value = &mut pictures[first + sun].entry(*pixel).or_default().value;
                    for c in 0..3 {
                        value[c] += passed[c] * share[c];
                    }
                }
            }
        }
    }
    Ok(())
}

struct PixelSizes<'a> {
    raster: &'a Raster,
    solid_angles: Vec<f64>,
    projected: Vec<f64>,
}

/// Number of the sun, pixel, and what light adds there.
type Place = (usize, u32, [f32; 3]);

/// Rays to the points of discs, or of their images, that pixels show.
fn rays(pixels: &PixelSizes<'_>, way: &Way<'_>, suns: &[Sun], image: Option<&Mat3>) -> (Vec<SunRay>, Vec<Place>) {
    let PixelSizes { raster, solid_angles, projected } = pixels;
    let ahead = raster.camera().direction;
    let mut rays: Vec<SunRay> = Vec::new();
    let mut places: Vec<Place> = Vec::new();
    for (number, sun) in suns.iter().enumerate() {
        let points = if sun.radius == 0.0 { 1 } else { DISC_POINTS };
        for direction in disc(sun, points) {
            let direction = image.map_or(direction, |image| (image.as_dmat3() * direction).normalize());
            let Some((column, row)) = raster.pixel_of(direction) else { continue };
            if !raster.is_seen(column, row) {
                continue;
            }
            let pixel = row * raster.width() + column;
            let omega = if solid_angles[pixel] > 0.0 { solid_angles[pixel] } else { raster.plain_solid_angle(column, row) };
            let Some(eye) = raster.ray(column, row) else { continue };
            let filter = (way.filter)(eye.origin, direction);
            if omega <= 0.0 || filter == [0.0; 3] {
                continue;
            }
            rays.push(SunRay {
                origin: way.tracer.point(eye.origin).to_array(),
                direction: direction.as_vec3().normalize().to_array(),
                ..SunRay::default()
            });
            let (cosine, of_pixel) = (direction.dot(ahead), projected.get(pixel).copied().unwrap_or(0.0));
            // At the rim a pixel's cosine is no measure any more: there the energy is kept.
            let seen = if cosine > RIM && of_pixel > RIM * omega { cosine / of_pixel } else { 1.0 / omega };
            let share = sun.solid_angle() / points as f64 * seen;
            places.push((number, pixel as u32, filter.map(|f| (f * share) as f32)));
        }
    }
    (rays, places)
}

fn transmitted(
    device: &Device,
    tracer: &SunTracer<'_>,
    kernel: &Kernel,
    rays: &[SunRay],
    image: Option<&Mat3>,
    statistics: &mut TraceStatistics,
) -> Result<Vec<[f32; 4]>> {
    let [image_x, image_y, image_z] = image.copied().unwrap_or_default().to_cols_array_2d();
    let params = SunRayParams { rays: rays.len() as u32, gates: tracer.gates().1, image_x, image_y, image_z, ..SunRayParams::default() };
    let params = device.uniform("rays to suns", &params)?;
    let buffer = device.upload("rays to suns", rays)?;
    let passed = device.zeros::<[f32; 4]>("light of suns", rays.len())?;
    let own = [("params", &params), ("rays", &buffer), ("passed", &passed), ("gates", tracer.gates().0)];
    let groups = device.grid((rays.len() as u64).div_ceil(64))?;
    tracer.run_in(tracer.scene(), kernel, &own, groups, rays.len() as u64, statistics)?;
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

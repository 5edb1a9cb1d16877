//! Discs of suns seen through slats and panes, each point of a disc laid on the pixel it falls into so
//! that the eye gets its illuminance: Ω·cosθ of the point over Ω·cosθ of the pixel, whose centre may
//! be a degree away.

use super::super::Sun;
use super::super::geometry::{Gate, SunTracer};
use super::Pixels;
use crate::camera::Raster;
use crate::error::Result;
use crate::glare::PixelGeometry;
use crate::gpu::{Device, Kernel};
use crate::gpu_struct;
use crate::kernels::trace::TraceStatistics;
use glam::DVec3;
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

/// Adds what the eye sees of the discs. `filter` is what passes the window along a ray (origin,
/// direction) beside the geometry that the tracer knows.
pub(super) fn add(
    device: &Device,
    raster: &Raster,
    tracer: &SunTracer<'_>,
    suns: &[Sun],
    filter: &dyn Fn(DVec3, DVec3) -> [f64; 3],
    statistics: &mut TraceStatistics,
    pictures: &mut [Pixels],
) -> Result<()> {
    let solid_angles = raster.solid_angles();
    let projected = PixelGeometry::new(raster).map(|g| g.projected_solid_angles).unwrap_or_default();
    let ahead = raster.camera().direction;
    // Rays with the sun and the pixel they belong to, and what they add there.
    let mut rays: Vec<SunRay> = Vec::new();
    let mut places: Vec<(usize, u32, [f32; 3])> = Vec::new();
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
            let filter = filter(eye.origin, direction);
            if omega <= 0.0 || filter == [0.0; 3] {
                continue;
            }
            rays.push(SunRay {
                origin: tracer.point(eye.origin).to_array(),
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
    for (rays, places) in rays.chunks(MOST_RAYS).zip(places.chunks(MOST_RAYS)) {
        let passed = transmitted(device, tracer, rays, statistics)?;
        for ((sun, pixel, share), passed) in places.iter().zip(passed) {
            if passed[0] + passed[1] + passed[2] > 0.0 {
                let value = &mut pictures[*sun].entry(*pixel).or_default().value;
                for c in 0..3 {
                    value[c] += passed[c] * share[c];
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

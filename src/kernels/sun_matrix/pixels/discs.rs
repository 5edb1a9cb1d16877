//! Discs of suns seen through slats and panes: what an eye sees of each, and each point of a disc laid on
//! the pixel it falls into so that the eye gets its illuminance: Ω·cosθ of the point over Ω·cosθ of the
//! pixel, whose centre may be a degree away. The sun's images in mirror-like slats are discs as well,
//! where the image stands.

use super::{Pixels, SeenDisc, SunPicture};
use crate::camera::{Camera, Raster};
use crate::error::Result;
use crate::glare::PixelGeometry;
use crate::kernels::sun_matrix::direct::{EyeRay, at_rays};
use crate::kernels::sun_matrix::sun::Sun;
use crate::kernels::sun_matrix::tracer::SunTracer;
use crate::kernels::trace::{TraceStatistics, stream_seed};
use crate::scene::Window;
use crate::units::ILLUMINANCE_WEIGHTS;
use glam::{DVec3, Mat3};
use std::f64::consts::TAU;

/// Independent sets of points of a disc; their spread tells how well the share that is seen is known.
const BATCHES: usize = 8;
/// Points of a set. A ray is traced to each from the eye.
const POINTS: usize = 128;
/// Cosine with the direction of view below which a disc is at the rim (85°).
const RIM: f64 = 0.087;
/// Rays of one dispatch.
const MOST_RAYS: usize = 1 << 20;

/// What stands between the eye and discs.
pub(super) struct Obstructions<'a> {
    /// The geometry.
    pub tracer: &'a SunTracer<'a>,
    /// What beside it passes the window along a ray (origin, direction).
    pub filter: &'a dyn Fn(DVec3, DVec3) -> [f64; 3],
    /// Windows with what else belongs to them, through whose boxes suns are seen.
    pub openings: &'a [(Window, Vec<DVec3>)],
    /// Whether mirrors are met: behind panes of scattering data none are.
    pub images: bool,
}

/// Who looks.
#[derive(Clone, Copy)]
pub(super) enum Eye<'a> {
    /// A picture: discs as far as they are in it and before the eye, and on its pixels.
    Picture(&'a Raster),
    /// Everything before the eye.
    Hemisphere(&'a Camera),
}

/// What the eye sees of suns.
pub(super) struct Seen {
    /// By sun.
    discs: Vec<Vec<SeenDisc>>,
    /// Points of the discs on pixels, by sun.
    pixels: Vec<Pixels>,
}

impl Seen {
    /// Nothing of so many suns.
    pub fn of(suns: usize) -> Self {
        Self { discs: vec![Vec::new(); suns], pixels: vec![Pixels::new(); suns] }
    }

    /// A picture of each sun that holds its discs alone.
    pub fn pictures(self) -> Vec<SunPicture> {
        let on_pixels = |p: Pixels| p.into_iter().map(|(pixel, e)| (pixel, e.value)).collect();
        let all = self.pixels.into_iter().zip(self.discs);
        all.map(|(p, discs)| SunPicture { discs, disc_pixels: on_pixels(p), ..SunPicture::default() }).collect()
    }
}

/// Adds what the eye sees of the discs.
pub(super) fn add(
    eye: Eye<'_>,
    way: &Obstructions<'_>,
    suns: &[Sun],
    seed: u32,
    statistics: &mut TraceStatistics,
    seen: &mut Seen,
) -> Result<()> {
    let scene = View::new(eye, way, seed);
    let images = if way.images { &way.tracer.images[..] } else { &[] };
    for image in std::iter::once(None).chain(images.iter().map(Some)) {
        for (first, suns) in (0..).step_by(MOST_RAYS / (BATCHES * POINTS)).zip(suns.chunks(MOST_RAYS / (BATCHES * POINTS))) {
            let (rays, places) = scene.rays(suns, image);
            if rays.is_empty() {
                continue;
            }
            let passed = at_rays(way.tracer, &rays, image, statistics)?;
            let lit = places.iter().zip(&rays).zip(&passed);
            let lit: Vec<_> = lit
                .filter(|(_, passed)| passed[0] + passed[1] + passed[2] > 0.0)
                .map(|((place, ray), passed)| (place, ray, passed))
                .collect();
            for (place, _, passed) in &lit {
                let Some((pixel, share)) = place.pixel else { continue };
                let value = &mut seen.pixels[first + place.sun].entry(pixel).or_default().value;
                (0..3).for_each(|c| value[c] += passed[c] * place.passes[c] * share);
            }
            for of_sun in lit.chunk_by(|a, b| a.0.sun == b.0.sun) {
                let number = of_sun[0].0.sun;
                let mut sum = DiscSum::default();
                of_sun.iter().filter(|(place, ..)| place.is_before).for_each(|(place, ray, passed)| sum.add(place, ray, passed));
                seen.discs[first + number].extend(sum.disc(&suns[number]));
            }
        }
    }
    Ok(())
}

/// Sums over the points of a disc that are seen.
#[derive(Default)]
struct DiscSum {
    points: usize,
    light: [f64; 3],
    direction: DVec3,
    batches: [f64; BATCHES],
}

impl DiscSum {
    fn add(&mut self, place: &Place, ray: &EyeRay, passed: &[f32; 3]) {
        let light: [f64; 3] = std::array::from_fn(|c| f64::from(passed[c] * place.passes[c]));
        let luminance: f64 = (0..3).map(|c| light[c] * ILLUMINANCE_WEIGHTS[c]).sum();
        self.points += 1;
        (0..3).for_each(|c| self.light[c] += light[c]);
        self.direction += luminance * ray.direction.as_dvec3();
        self.batches[place.batch] += luminance;
    }

    fn disc(&self, sun: &Sun) -> Option<SeenDisc> {
        let direction = self.direction.try_normalize()?;
        let sets = if sun.radius == 0.0 { 1 } else { BATCHES };
        let points = (sets * points_of(sun)) as f64;
        let mean = self.batches.iter().sum::<f64>() / sets as f64;
        let squares: f64 = self.batches[..sets].iter().map(|b| (b - mean).powi(2)).sum();
        let error = if sets > 1 { (squares / (sets * (sets - 1)) as f64).sqrt() / mean } else { 0.0 };
        Some(SeenDisc {
            direction: direction.as_vec3().to_array(),
            solid_angle: (sun.solid_angle() * self.points as f64 / points) as f32,
            radiance: self.light.map(|l| (l / self.points as f64) as f32),
            error: error as f32,
        })
    }
}

/// Where the light of a ray goes.
struct Place {
    sun: usize,
    batch: usize,
    /// What passes the window.
    passes: [f32; 3],
    /// Whether the point is before the eye, and in the picture.
    is_before: bool,
    /// Pixel, and what light adds to its radiance.
    pixel: Option<(u32, f32)>,
}

struct View<'a> {
    eye: Eye<'a>,
    camera: &'a Camera,
    way: &'a Obstructions<'a>,
    /// Shift of each set of points.
    shifts: [[f64; 2]; BATCHES],
    solid_angles: Vec<f64>,
    projected: Vec<f64>,
}

impl<'a> View<'a> {
    fn new(eye: Eye<'a>, way: &'a Obstructions<'a>, seed: u32) -> Self {
        let (camera, solid_angles, projected) = match eye {
            Eye::Hemisphere(camera) => (camera, Vec::new(), Vec::new()),
            Eye::Picture(raster) => {
                (raster.camera(), raster.solid_angles(), PixelGeometry::new(raster).map(|g| g.projected_solid_angles).unwrap_or_default())
            }
        };
        let number = |set: usize, purpose: u32| f64::from(stream_seed(seed, set as u32, purpose)) / 2f64.powi(32);
        let shifts = std::array::from_fn(|set| [number(set, 0x6469_7363), number(set, 0x6469_7364)]);
        Self { eye, camera, way, shifts, solid_angles, projected }
    }

    /// Rays to the points of discs, or of their images, that the eye sees if nothing is in the way.
    fn rays(&self, suns: &[Sun], image: Option<&Mat3>) -> (Vec<EyeRay>, Vec<Place>) {
        let mut rays: Vec<EyeRay> = Vec::new();
        let mut places: Vec<Place> = Vec::new();
        for (number, sun) in suns.iter().enumerate() {
            // Mirrors may stand anywhere; without them the sun is seen through the openings.
            if image.is_none() && !self.may_be_seen(sun) {
                continue;
            }
            let sets = if sun.radius == 0.0 { 1 } else { BATCHES };
            for (batch, of_sun) in (0..sets).flat_map(|set| disc(sun, self.shifts[set]).map(move |d| (set, d))) {
                let direction = image.map_or(of_sun, |image| (image.as_dmat3() * of_sun).normalize());
                let Some((origin, is_before, pixel)) = self.place(direction) else { continue };
                let filter = (self.way.filter)(origin, direction);
                if filter == [0.0; 3] {
                    continue;
                }
                rays.push(EyeRay {
                    origin: self.way.tracer.point(origin).to_array(),
                    sun: of_sun.as_vec3().normalize(),
                    direction: direction.as_vec3().normalize(),
                });
                let of_point = sun.solid_angle() / (sets * points_of(sun)) as f64;
                let pixel = pixel.map(|(pixel, share)| (pixel, (share * of_point) as f32));
                places.push(Place { sun: number, batch, passes: filter.map(|f| f as f32), is_before, pixel });
            }
        }
        (rays, places)
    }

    /// Where rays to a point begin, whether it is before the eye, and the pixel that shows it with its share
    /// of light there; nothing if it is not seen at all.
    #[allow(clippy::type_complexity, reason = "private, taken apart at once")]
    fn place(&self, direction: DVec3) -> Option<(DVec3, bool, Option<(u32, f64)>)> {
        let cosine = direction.dot(self.camera.direction);
        let Eye::Picture(raster) = self.eye else {
            return (cosine > 0.0).then_some((self.camera.view().point, true, None));
        };
        let at = self.camera.locate(direction).filter(|at| at.min_element() >= 0.0 && at.max_element() < 1.0)?;
        let origin = self.camera.ray(at.x, at.y)?.origin;
        let pixel = raster.pixel_of(direction).filter(|&(column, row)| raster.is_seen(column, row)).and_then(|(column, row)| {
            let pixel = row * raster.width() + column;
            let omega = if self.solid_angles[pixel] > 0.0 { self.solid_angles[pixel] } else { raster.plain_solid_angle(column, row) };
            let of_pixel = self.projected.get(pixel).copied().unwrap_or(0.0);
            // At the rim a pixel's cosine is no measure any more: there the energy is kept.
            let share = if cosine > RIM && of_pixel > RIM * omega { cosine / of_pixel } else { 1.0 / omega };
            (omega > 0.0).then_some((pixel as u32, share))
        });
        (cosine > 0.0 || pixel.is_some()).then_some((origin, cosine > 0.0, pixel))
    }

    /// Whether a part of the disc may be seen through an opening: whether the ray to its middle meets a box
    /// that is as much larger as the disc is wide there.
    fn may_be_seen(&self, sun: &Sun) -> bool {
        let origin = self.camera.view().point;
        self.way.openings.iter().any(|(window, corners)| {
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for corner in window.triangles.iter().flatten().chain(corners) {
                let p = window.frame.to_local(*corner - origin);
                (low, high) = (low.min(p), high.max(p));
            }
            let distance = low.abs().max(high.abs()).length();
            // Clipping (-vo) moves the beginning of rays.
            let margin = distance * (1e-3 + sun.radius * 1.01) + self.camera.view().fore.abs();
            let along = window.frame.to_local(sun.direction);
            let (mut from, mut to) = (0.0f64, f64::INFINITY);
            for axis in 0..3 {
                let [a, b] = [low[axis] - margin, high[axis] + margin].map(|v| v / along[axis]);
                if along[axis].abs() < 1e-12 {
                    if low[axis] - margin > 0.0 || high[axis] + margin < 0.0 {
                        return false;
                    }
                } else {
                    (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
                }
            }
            from <= to
        })
    }
}

/// Points of a set.
fn points_of(sun: &Sun) -> usize {
    if sun.radius == 0.0 { 1 } else { POINTS }
}

/// Points of a disc, evenly spread (golden spiral), uniform in solid angle. Sets with other shifts are
/// independent.
fn disc(sun: &Sun, [along, around]: [f64; 2]) -> impl Iterator<Item = DVec3> {
    let x = sun.direction.any_orthonormal_vector();
    let y = sun.direction.cross(x);
    let (direction, whole, points) = (sun.direction, sun.chord(), points_of(sun));
    (0..points).map(move |i| {
        let chord = whole * ((i as f64 + along) / points as f64).sqrt();
        let sine = chord * (1.0 - chord * chord / 4.0).sqrt();
        let phi = TAU * (0.618_033_988_749_895 * i as f64 + around);
        (x * (phi.cos() * sine) + y * (phi.sin() * sine) + direction * (1.0 - chord * chord / 2.0)).normalize()
    })
}

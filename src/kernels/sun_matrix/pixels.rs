//! Suns in pictures: what each pixel shows of each sun.
//!
//! `C[pixel][sun]` is the radiance that the pixel shows per unit radiance of the sun's disc. Three
//! parts: surfaces of the room and slats that the sun lights (irradiance at the point behind the
//! pixel × ρ/π, as the tutorial's irradiance picture × material map), the radiance of panes of
//! scattering data, and the disc itself where it is seen between slats or through the peak of a pane.
//! The disc's energy is laid on the pixels it covers, point by point, so that a sun smaller than a
//! pixel shows as bright as it is at the eye, never missed and never doubled.
//! Entries are sparse, sun by sun.

pub(super) mod behind;
mod discs;
mod panes;

use super::openings::Openings;
use super::options::SunOptions;
use super::pane::PaneBsdf;
use super::result::Hits;
use super::sun::Sun;
use super::tracer::{SunTracer, Tile};
use super::{direct, paths};
use crate::camera::{Camera, Raster};
use crate::error::Result;
use crate::gpu::Device;
use crate::kernels::glare::{PixelWeights, SharedNoise, SharedSums};
use crate::kernels::trace::TraceStatistics;
use crate::kernels::view_matrix::mean_and_error;
use crate::progress::{Progress, cancelled};
use crate::scene::{Scene, Window};
use crate::units::ILLUMINANCE_WEIGHTS;
use behind::PixelSurfaces;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Most pixels of a tile.
const MOST_TILE: usize = 4096;

/// Pixels in rising order and their values.
pub type SparsePicture = Vec<(u32, [f32; 3])>;

/// The sun's disc, or an image of it, as far as an eye sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenDisc {
    /// Unit vector from the eye to the middle of its light.
    pub direction: [f32; 3],
    /// Solid angle that is seen, sr.
    pub solid_angle: f32,
    /// Mean radiance of what is seen per radiance of the sun's disc.
    pub radiance: [f32; 3],
    /// Standard error of the share that is seen, relative to it.
    pub error: f32,
}

/// What one sun puts into a picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SunPicture {
    /// Radiance per radiance of the disc, without the disc.
    pub pixels: SparsePicture,
    /// The disc and its images as sources of their own, as far as they are in the picture and before the eye;
    /// parts that are seen through slats and through panes each for itself.
    pub discs: Vec<SeenDisc>,
    /// The same discs on pixels.
    pub disc_pixels: SparsePicture,
    /// Standard error of each pixel's luminance, cd/m² per W/m²sr of the disc, from the spread of the
    /// batches and what few hits among them leave open. Every pixel has surface points, points of the disc and paths of its own, so that
    /// these errors are independent.
    pub errors: Vec<f32>,
    /// The same for light that panes scatter onto surfaces, whose errors go together: all pixels see the
    /// same few points of the panes.
    pub shared_errors: Vec<f32>,
    /// What these do to the light at the eye and in parts of the view, per W/m²sr of the disc; empty
    /// for views in which no glare can be judged.
    pub shared: SharedNoise,
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
    /// Windows with panes of scattering data.
    pub panes: &'a [(Window, PaneBsdf)],
}

/// How much to sample. Both have the same batches: a surface point of every pixel in each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelOptions {
    /// Suns between slats.
    pub slats: SunOptions,
    /// Suns through panes.
    pub panes: SunOptions,
}

/// Pictures of a group of suns, in their order. The memory for all of them is the caller's concern:
/// hand over as many suns at once as it holds pictures.
///
/// # Errors
/// As [`compute`](super::compute).
pub fn compute(
    device: &Device,
    models: &Models<'_>,
    raster: &Raster,
    suns: &[Sun],
    options: &PixelOptions,
    progress: &dyn Progress,
    statistics: &mut TraceStatistics,
) -> Result<Vec<SunPicture>> {
    let mut pictures: Vec<Pixels> = vec![BTreeMap::new(); suns.len()];
    let mut shared = vec![SharedNoise::default(); suns.len()];
    let mut seen = discs::Seen::of(suns.len());
    if suns.is_empty() {
        return Ok(Vec::new());
    }
    let eye = discs::Eye::Picture(raster);
    if !models.shaded.is_empty() {
        let tracer = SunTracer::new(device, models.black, Openings::Shaded(models.shaded), &[], suns, &options.slats)?;
        between_slats(device, models, raster, &tracer, progress, statistics, &mut pictures)?;
        discs::add(eye, &between(models, &tracer), suns, options.slats.seed, statistics, &mut seen)?;
    }
    if !models.panes.is_empty() {
        shared = panes::add(device, models, raster, suns, &options.panes, progress, statistics, &mut pictures)?;
        panes::discs(device, models, eye, suns, &options.panes, statistics, &mut seen)?;
    }
    let whole = |((p, shared), discs): ((Pixels, SharedNoise), SunPicture)| SunPicture {
        errors: p.values().map(|e| e.error).collect(),
        shared_errors: p.values().map(|e| e.shared_error).collect(),
        pixels: p.into_iter().map(|(pixel, e)| (pixel, e.value)).collect(),
        shared,
        ..discs
    };
    Ok(pictures.into_iter().zip(shared).zip(seen.pictures()).map(whole).collect())
}

/// What an eye sees of the discs of suns, in their order, and nothing else: all that is before it.
///
/// # Errors
/// As [`compute`].
pub(crate) fn discs_at_eye(
    device: &Device,
    models: &Models<'_>,
    camera: &Camera,
    suns: &[Sun],
    options: &PixelOptions,
    statistics: &mut TraceStatistics,
) -> Result<Vec<SunPicture>> {
    let eye = discs::Eye::Hemisphere(camera);
    let mut seen = discs::Seen::of(suns.len());
    if !models.shaded.is_empty() && !suns.is_empty() {
        let tracer = SunTracer::new(device, models.black, Openings::Shaded(models.shaded), &[], suns, &options.slats)?;
        discs::add(eye, &between(models, &tracer), suns, options.slats.seed, statistics, &mut seen)?;
    }
    if !models.panes.is_empty() && !suns.is_empty() {
        panes::discs(device, models, eye, suns, &options.panes, statistics, &mut seen)?;
    }
    Ok(seen.pictures())
}

/// The way to suns between slats.
fn between<'a>(models: &Models<'a>, tracer: &'a SunTracer<'a>) -> discs::Obstructions<'a> {
    discs::Obstructions { tracer, filter: &|_, _| [1.0; 3], openings: models.shaded, images: true }
}

impl SunPicture {
    /// All of the sun's light on pixels, as written pictures have it.
    pub fn with_disc(self) -> SparsePicture {
        if self.disc_pixels.is_empty() {
            return self.pixels;
        }
        let mut all: BTreeMap<u32, [f32; 3]> = self.pixels.into_iter().collect();
        for (pixel, value) in self.disc_pixels {
            let sum = all.entry(pixel).or_default();
            (0..3).for_each(|c| sum[c] += value[c]);
        }
        all.into_iter().collect()
    }
}

/// What is known of a pixel.
#[derive(Debug, Clone, Copy, Default)]
struct Entry {
    value: [f32; 3],
    error: f32,
    shared_error: f32,
}

/// Entries by pixel.
type Pixels = BTreeMap<u32, Entry>;

/// Surfaces that suns light between slats.
#[allow(clippy::too_many_arguments, reason = "private; each is a different thing")]
fn between_slats(
    device: &Device,
    models: &Models<'_>,
    raster: &Raster,
    tracer: &SunTracer<'_>,
    progress: &dyn Progress,
    statistics: &mut TraceStatistics,
    pictures: &mut [Pixels],
) -> Result<()> {
    let (windows, options): (Vec<Window>, _) = (models.shaded.iter().map(|(w, _)| w.clone()).collect(), &tracer.options);
    let behind = PixelSurfaces::new(device, models.lit, &windows, raster, [options.batches, options.seed])?;
    let batches = options.batches as usize;
    for chunk in tracer.plan(behind.inside.len())?.at_most(MOST_TILE).chunks() {
        progress.update("suns in the picture", chunk.first as f64 / behind.inside.len() as f64);
        if progress.stop_requested() {
            return Err(cancelled());
        }
        let tile = &behind.inside[chunk.first..chunk.first + chunk.count];
        let count = tile.len();
        let found = behind.find(tile, models.first_shade, false, statistics)?;
        let numbers: Vec<u32> = tile.iter().map(|p| *p as u32).collect();
        let receivers = Tile { receivers: &found.receivers, numbers: &numbers, batch_stride: count as u32 };
        let light = direct::light(tracer, &receivers, statistics)?;
        let scattered = if tracer.scatters() { Some(paths::light(tracer, &receivers, statistics)?) } else { None };
        let n = pictures.len();
        let shown = |sun: usize, batch: usize, i: usize| {
            let cell = (batch * count + i) * n + sun;
            let (weight, scattered) = (found.weights[batch * count + i], scattered.as_ref().map_or([0.0; 3], |s| s.light[cell]));
            std::array::from_fn(|c| (light[cell][c] + scattered[c]) * weight[c])
        };
        // What few of its paths leave open.
        let weight = |i: usize| (0..batches).flat_map(|b| found.weights[b * count + i]).fold(0.0, f32::max);
        let doubt = |sun: usize, i: usize| {
            let hits = scattered.as_ref().map_or(Hits::default(), |s| s.hits[i * n + sun]);
            hits.doubts(batches).iter().sum::<f64>().sqrt() * f64::from(weight(i))
        };
        add(tile, [batches, batches], pictures, Errors::Own(&doubt), &shown);
    }
    Ok(())
}

/// How the errors of pixels go together.
enum Errors<'a> {
    /// Not at all. What few samples leave open adds to them: the radiance by sun and number in the tile.
    Own(&'a (dyn Fn(usize, usize) -> f64 + Sync)),
    /// They share them; sums of each picture, for views that have weights.
    Shared(Option<&'a PixelWeights>, &'a mut [SharedSums]),
}

/// Puts the light of a tile into the pictures, the mean over the rays of each pixel: `shown(sun, ray,
/// number in the tile)`. The batches, whose spread is the error, are runs of rays: samples of a pixel that
/// follow each other are spread evenly over it, every fourth ones are not.
fn add(
    tile: &[usize],
    [batches, rays]: [usize; 2],
    pictures: &mut [Pixels],
    errors: Errors<'_>,
    shown: &(dyn Fn(usize, usize, usize) -> [f32; 3] + Sync),
) {
    type Shared<'s> = Option<(Option<&'s PixelWeights>, &'s mut SharedSums)>;
    let white: f64 = ILLUMINANCE_WEIGHTS.iter().sum();
    let one = |sun: usize, picture: &mut Pixels, doubt: &dyn Fn(usize, usize) -> f64, mut shared: Shared<'_>| {
        let mut luminance = vec![0.0f64; batches];
        for (i, &pixel) in tile.iter().enumerate() {
            let mut value = [0.0f32; 3];
            luminance.fill(0.0);
            for ray in 0..rays {
                let shown = shown(sun, ray, i);
                for c in 0..3 {
                    value[c] += shown[c] / rays as f32;
                    luminance[ray * batches / rays] += ILLUMINANCE_WEIGHTS[c] * f64::from(shown[c]) * (batches as f64 / rays as f64);
                }
            }
            if value.iter().any(|v| *v > 0.0) {
                let entry = picture.entry(pixel as u32).or_default();
                // Where a shadow's edge crosses a pane's cells, an estimate may be a little below nothing.
                (0..3).for_each(|c| entry.value[c] += value[c].max(0.0));
                let error = mean_and_error(&luminance).1 as f32;
                match &mut shared {
                    None => entry.error = entry.error.hypot(error).hypot((white * doubt(sun, i)) as f32),
                    Some((weights, sums)) => {
                        entry.shared_error = entry.shared_error.hypot(error);
                        weights.iter().for_each(|w| sums.add(w, pixel, &luminance));
                    }
                }
            }
        }
    };
    match errors {
        Errors::Own(doubt) => pictures.par_iter_mut().enumerate().for_each(|(sun, picture)| one(sun, picture, doubt, None)),
        Errors::Shared(weights, sums) => pictures
            .par_iter_mut()
            .zip(sums)
            .enumerate()
            .for_each(|(sun, (picture, sums))| one(sun, picture, &|_, _| 0.0, Some((weights, sums)))),
    }
}

#[cfg(test)]
mod tests;

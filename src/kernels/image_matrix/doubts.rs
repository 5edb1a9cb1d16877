//! What few rays leave open in a pixel: which part of the windows, and of the light paths, is seen from its
//! surface points, and what further reflections show that none of its rays found.

use super::{ImageTracer, PixelPoint, TracedTile};
use crate::kernels::light_paths::LOOK_UNITS;
use crate::kernels::light_paths::doubts::{BinShares, Chances, are_enough};
use crate::kernels::trace::doubt::{ENOUGH_HITS, Part, half_a_hit, pattern};
use std::f64::consts::FRAC_1_SQRT_2;

/// Standard deviations of what few rays leave open, of pixels that are independent of each other.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelDoubts {
    bins: BinShares,
    /// Of a pixel's light from all bins together.
    pixels: Vec<[f64; 3]>,
}

impl PixelDoubts {
    pub(super) fn none(bins: BinShares, pixels: usize) -> Self {
        Self { bins, pixels: vec![[0.0; 3]; pixels] }
    }

    pub(super) fn set(&mut self, pixel: usize, doubt: [f64; 3]) {
        self.pixels[pixel] = doubt;
    }

    /// Of a channel in a bin.
    pub fn of(&self, pixel: usize, bin: usize, c: usize) -> f64 {
        self.pixels[pixel][c] * self.bins.of_bin(bin)
    }

    /// The deviation of a pixel's row `[bin][rgb]` in one of several batches by what is left open, times a factor;
    /// those of all batches add up to nothing. `number` is that of the pixel in the picture. False if there is none.
    pub fn fill(&self, (pixel, number): (usize, usize), (batch, batches): (usize, usize), factor: f64, row: &mut [f32]) -> bool {
        if self.pixels[pixel] == [0.0; 3] {
            return false;
        }
        let deviation = factor * pattern(Part::OTHERS + number, batches)[batch];
        for (bin, values) in row.chunks_exact_mut(3).enumerate() {
            values.iter_mut().enumerate().for_each(|(c, v)| *v = (deviation * self.of(pixel, bin, c)) as f32);
        }
        true
    }
}

/// Of direct light of the windows, irradiance.
fn of_direct(points: &[PixelPoint]) -> f64 {
    let sum = |f: fn(&PixelPoint) -> f32| points.iter().map(|c| f64::from(f(c))).sum::<f64>();
    let (whole, rays, hits) = (sum(|c| c.direct) / points.len() as f64, sum(|c| c.rays), sum(|c| c.hits));
    match rays {
        // No ray went where a window might be seen: it is, or is not.
        0.0 => 0.5 * whole,
        _ if are_enough(hits, rays) => 0.0,
        _ => half_a_hit(whole, rays),
    }
}

/// Of light by light paths, irradiance.
fn of_gathered(points: &[PixelPoint]) -> f64 {
    let sum = |f: fn(&PixelPoint) -> f32| points.iter().map(|c| f64::from(f(c))).sum::<f64>();
    let all = Chances { possible: sum(|c| c.gathered), squares: sum(|c| c.gathered_squares), arrived: sum(|c| c.gathered_hits) };
    all.doubt(points.len() as f64)
}

impl ImageTracer<'_> {
    /// What is left open in a pixel, of light from all bins together.
    pub(super) fn doubts(&self, tile: &TracedTile, pixel: usize, pixels: usize) -> [f64; 3] {
        let o = &self.options;
        let batches = f64::from(o.batches);
        let points: Vec<PixelPoint> = tile.points.iter().skip(pixel).step_by(pixels).copied().collect();
        let other = self.tables.has_other_reflections();
        let near = tile.near.as_ref().filter(|_| other);
        let near = near.map_or(0.0, |n| n.doubt(pixel, pixels, f64::from(o.near_samples) * batches));
        let images = tile.images.get(pixel).copied().unwrap_or(0.0);
        let irradiance = of_direct(&points).hypot(of_gathered(&points)).hypot(near).hypot(images);
        // By its own rays a pixel looks into reflections.
        let [looks, hits, weights, possible] = tile.looks[pixel].map(f64::from);
        // If there was no look, half of one might have been.
        let weight = if looks > 0.0 { weights / LOOK_UNITS / looks } else { FRAC_1_SQRT_2 };
        let doubted = (looks > 0.0 || possible > 0.0) && hits < ENOUGH_HITS;
        let seen = if doubted { half_a_hit(weight, f64::from(o.subpixels)) } else { 0.0 };
        let weight = |c: usize| tile.points.iter().skip(pixel).step_by(pixels).map(|p| f64::from(p.weight[c])).sum::<f64>() / batches;
        std::array::from_fn(|c| (irradiance * weight(c)).hypot(seen))
    }
}

//! Glare pixels on the processor.

use super::band::{SLOTS, TILE_HEIGHT};
use super::{Band, Bands, Detector, GlarePixels, Loaded, Pass};
use crate::error::{Error, Result};
use crate::kernels::product::{Strides, product_on_this_thread};
use rayon::prelude::*;

/// Finds glare pixels by products on the processor's vector units, on all cores.
#[derive(Debug, Clone, Copy, Default)]
pub struct Native;

/// Hours of a tile's product are filled up to a multiple of this, so that the product never takes
/// the way for single columns, which sums differently.
const COLUMNS: usize = 4;

impl Detector for Native {
    fn description(&self) -> String {
        format!("native glare on {} threads", rayon::current_num_threads())
    }

    fn load<'b>(&'b self, bands: Bands<'b>) -> Result<Box<dyn Loaded + 'b>> {
        Ok(Box::new(bands))
    }
}

impl Loaded for Bands<'_> {
    fn detect(&self, pass: &Pass) -> Result<Vec<GlarePixels>> {
        let negative = pass.coefficients.iter().any(|&c| c < 0.0);
        let part = |sign: f32| -> Vec<f32> { pass.coefficients.iter().map(|&c| (sign * c).max(0.0)).collect() };
        let split = negative.then(|| [part(1.0), part(-1.0)]);
        self.bands.par_iter().map(|band| one_band(band, self.width, self.terms, pass, split.as_ref())).collect()
    }
}

/// A glare pixel on its way.
#[derive(Clone, Copy)]
struct Found {
    hour: u32,
    pixel: u32,
    luminance: f32,
}

fn one_band(band: &Band, width: usize, terms: usize, pass: &Pass, split: Option<&[Vec<f32>; 2]>) -> Result<GlarePixels> {
    let additions = AddedLight::new(band, width, pass);
    let bounds = if pass.skip { upper_bounds(band, terms, pass, split) } else { Vec::new() };
    let mut found = Vec::new();
    let mut active: Vec<u32> = Vec::new();
    let mut columns: Vec<f32> = Vec::new();
    let mut luminance: Vec<f32> = Vec::new();
    for (number, tile) in band.tiles.iter().enumerate() {
        active.clear();
        active.extend((0..pass.hours() as u32).filter(|&hour| {
            let h = hour as usize;
            !pass.skip || f64::from(bounds[number * pass.hours() + h]) + pass.margins[h] + additions.most(number, h) > pass.thresholds[h]
        }));
        if active.is_empty() {
            continue;
        }
        let padded = active.len().next_multiple_of(COLUMNS);
        columns.clear();
        for &hour in &active {
            columns.extend_from_slice(&pass.coefficients[hour as usize * terms..][..terms]);
        }
        columns.resize(padded * terms, 0.0);
        luminance.clear();
        luminance.resize(padded * SLOTS, 0.0);
        let values = &band.values[number * terms * SLOTS..][..terms * SLOTS];
        let strides = Strides { left: [1, SLOTS], right: [1, terms], product: [1, SLOTS] };
        product_on_this_thread([SLOTS, terms, padded], values, &columns, &mut luminance, &strides);
        for (&hour, values) in active.iter().zip(luminance.chunks_exact_mut(SLOTS)) {
            additions.add(number, hour as usize, values);
            let threshold = pass.thresholds[hour as usize];
            for (&pixel, &l) in tile.pixels().iter().zip(&*values) {
                if f64::from(l) > threshold {
                    found.push(Found { hour, pixel, luminance: l });
                } else if !l.is_finite() {
                    return Err(not_finite(pixel, width));
                }
            }
        }
    }
    Ok(sorted(&found, band.first_line, width, pass.hours()))
}

fn not_finite(pixel: u32, width: usize) -> Error {
    Error::new(format!("the luminance of pixel {} in line {} is not finite", pixel as usize % width, pixel as usize / width))
        .help("look for infinite or extreme values in the input; if there are none, please report this")
}

/// Upper bounds of the luminance, `[tile][hour]`, but for rounding: the greatest values with the
/// positive coefficients, less the least values with the others.
fn upper_bounds(band: &Band, terms: usize, pass: &Pass, split: Option<&[Vec<f32>; 2]>) -> Vec<f32> {
    let (tiles, hours) = (band.tiles.len(), pass.hours());
    let product = |values: &[f32], coefficients: &[f32]| {
        let mut out = vec![0.0f32; tiles * hours];
        let strides = Strides { left: [terms, 1], right: [1, terms], product: [hours, 1] };
        product_on_this_thread([tiles, terms, hours], values, coefficients, &mut out, &strides);
        out
    };
    match split {
        None => product(&band.greatest, &pass.coefficients),
        Some([positive, negative]) => {
            let mut bounds = product(&band.greatest, positive);
            let less = product(&band.least, negative);
            bounds.iter_mut().zip(&less).for_each(|(b, l)| *b -= l);
            bounds
        }
    }
}

/// The additional light in one band, by tile and hour.
struct AddedLight {
    /// Where those of a tile and hour begin in `added`, `[tile][hour]`, and the end; empty without any.
    offsets: Vec<u32>,
    /// Slot of the tile, luminance.
    added: Vec<(u8, f32)>,
    hours: usize,
}

impl AddedLight {
    fn new(band: &Band, width: usize, pass: &Pass) -> Self {
        let hours = pass.hours();
        let (from, to) = (band.first_line * width, (band.first_line + TILE_HEIGHT) * width);
        let lists = || {
            pass.additions.iter().map(|all| {
                let place = |pixel: usize| all.partition_point(|&(p, _)| (p as usize) < pixel);
                &all[place(from)..place(to)]
            })
        };
        if lists().all(<[_]>::is_empty) {
            return Self { offsets: Vec::new(), added: Vec::new(), hours };
        }
        let mut places = vec![None; TILE_HEIGHT * width];
        for (number, tile) in band.tiles.iter().enumerate() {
            for (slot, &pixel) in tile.pixels().iter().enumerate() {
                places[pixel as usize - from] = Some((number, slot as u8));
            }
        }
        let all = || {
            let of_hour = |(hour, list)| std::iter::repeat(hour).zip(list);
            lists().enumerate().flat_map(of_hour).filter_map(|(hour, &(pixel, l)): (usize, &(u32, f32))| {
                let (tile, slot) = places[pixel as usize - from]?;
                Some((tile * hours + hour, slot, l))
            })
        };
        let mut offsets = vec![0u32; band.tiles.len() * hours + 1];
        all().for_each(|(cell, _, _)| offsets[cell + 1] += 1);
        for i in 1..offsets.len() {
            offsets[i] += offsets[i - 1];
        }
        let mut next = offsets.clone();
        let mut added = vec![(0, 0.0); *offsets.last().unwrap_or(&0) as usize];
        for (cell, slot, l) in all() {
            added[next[cell] as usize] = (slot, l);
            next[cell] += 1;
        }
        Self { offsets, added, hours }
    }

    fn of(&self, tile: usize, hour: usize) -> &[(u8, f32)] {
        let cell = tile * self.hours + hour;
        match self.offsets.get(cell..cell + 2) {
            Some([from, to]) => &self.added[*from as usize..*to as usize],
            _ => &[],
        }
    }

    /// The greatest addition.
    fn most(&self, tile: usize, hour: usize) -> f64 {
        f64::from(self.of(tile, hour).iter().fold(0.0, |most, &(_, l)| l.max(most)))
    }

    fn add(&self, tile: usize, hour: usize, luminance: &mut [f32]) {
        self.of(tile, hour).iter().for_each(|&(slot, l)| luminance[usize::from(slot)] += l);
    }
}

/// By hour and pixel. Within a line the tiles follow each other from the left, so that sorting by
/// line is enough.
fn sorted(found: &[Found], first_line: usize, width: usize, hours: usize) -> GlarePixels {
    let key = |f: &Found| f.hour as usize * TILE_HEIGHT + f.pixel as usize / width - first_line;
    let mut from = vec![0usize; hours * TILE_HEIGHT + 1];
    found.iter().for_each(|f| from[key(f) + 1] += 1);
    for i in 1..from.len() {
        from[i] += from[i - 1];
    }
    let offsets = (0..=hours).map(|h| from[h * TILE_HEIGHT]).collect();
    let (mut pixels, mut luminance) = (vec![0; found.len()], vec![0.0; found.len()]);
    for f in found {
        let place = &mut from[key(f)];
        pixels[*place] = f.pixel;
        luminance[*place] = f.luminance;
        *place += 1;
    }
    GlarePixels { offsets, pixels, luminance }
}

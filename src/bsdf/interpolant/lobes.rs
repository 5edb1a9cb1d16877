//! Lobes from the samples of one incident direction.
//!
//! Samples lie in cells of a grid. Squares of cells are divided until their samples lie on a plane, or differ by so
//! little light that it does not matter; each becomes a lobe, no narrower than the samples lie apart. Then masses change
//! until the sum of lobes meets the samples (Richardson-Lucy): lobes overlap, so the first guess is blurred.

use super::{CUT, Lobe, upper};
use crate::bsdf::scans::{CELLS, Grid, SIDE, cell_direction, direction_of, square_of};
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;

/// Radius of a lobe in widths of the square it stands for; it is no less than the distance of samples.
const RADIUS: f64 = 0.7;
/// Samples of one lobe differ from their mean by no more than this share.
const STEEP: f64 = 0.5;
/// Share of the light that may be in the wrong place within the square of a lobe, at least; more where there would be
/// too many lobes.
const NEGLIGIBLE: f64 = 3e-6;
/// Fewest samples that a plane is laid through; fewer are compared with their mean.
const LEAST: usize = 4;
/// Largest square of one lobe, in cells.
const LARGEST: usize = 32;
/// Exponent of the factors of an iteration: above 1 it gets there sooner, from 2 it would not.
const OVERRELAXED: f64 = 1.7;
/// Iterations that sharpen the first guess.
const ITERATIONS: usize = 60;
/// Width of a cell, radians.
const CELL: f64 = 2.506_628_274_631_000_5 / SIDE as f64; // √(2π)

/// A cell with samples.
struct Datum {
    direction: DVec3,
    value: f64,
    /// Solid angle that it stands for, sr.
    weight: f64,
}

/// A square of cells that becomes a lobe.
struct Leaf {
    direction: DVec3,
    /// Cells on its side.
    side: usize,
    mean: f64,
    /// Distance between the samples here, cells.
    spacing: f64,
}

/// The lobes of the samples of one incident direction, about as many as asked for at most. Samples that lie on a plane
/// to within the share `tolerance` of their mean, or to within the noise (1/sr), are one lobe.
pub(super) fn lobes(grid: &Grid, noise: f64, tolerance: f64, most: usize) -> Vec<Lobe> {
    let cells = grid.sorted();
    let mut index = vec![u32::MAX; CELLS];
    let mut data: Vec<Datum> = Vec::with_capacity(cells.len());
    for (k, (cell, sums)) in cells.iter().enumerate() {
        index[*cell as usize] = k as u32;
        let direction = sums.direction.normalize_or(cell_direction(*cell as usize, SIDE));
        data.push(Datum { direction, value: sums.value / f64::from(sums.count), weight: 0.0 });
    }
    let mut negligible = NEGLIGIBLE * grid.integral().max(0.0);
    let mut leaves = Vec::new();
    for _ in 0..30 {
        leaves.clear();
        data.iter_mut().for_each(|d| d.weight = 0.0);
        let mut squares = Squares { index: &index, data: &mut data, leaves: &mut leaves, tolerance, noise, negligible };
        if squares.divide(0, 0, SIDE) {
            squares.leaf(0, 0, SIDE);
        }
        if leaves.len() <= most {
            break;
        }
        negligible *= 1.6;
    }
    sharpen(&leaves, &data, &index)
}

struct Squares<'a> {
    index: &'a [u32],
    data: &'a mut [Datum],
    leaves: &'a mut Vec<Leaf>,
    tolerance: f64,
    noise: f64,
    /// Light that may be in the wrong place within a square.
    negligible: f64,
}

impl Squares<'_> {
    /// Samples of a square.
    fn inside(&self, x: usize, y: usize, side: usize) -> Vec<usize> {
        let row = |i: usize| &self.index[i * SIDE + y..i * SIDE + y + side];
        (x..x + side).flat_map(|i| row(i).iter().filter(|k| **k != u32::MAX).map(|k| *k as usize)).collect()
    }

    /// Divides a square; `true` if it is to be one leaf.
    fn divide(&mut self, x: usize, y: usize, side: usize) -> bool {
        let samples = self.inside(x, y, side);
        if side == 1 || samples.len() < 2 {
            return true;
        }
        let half = side / 2;
        let quarters = [(x, y), (x + half, y), (x, y + half), (x + half, y + half)];
        if side <= LARGEST && self.smooth(&samples, TAU * (side * side) as f64 / CELLS as f64) {
            return true;
        }
        for (a, b) in quarters {
            if self.divide(a, b, half) {
                self.leaf(a, b, half);
            }
        }
        false
    }

    /// Whether samples lie on a plane that is not steep, or what they differ is negligible over the area (sr).
    fn smooth(&self, samples: &[usize], area: f64) -> bool {
        let n = samples.len() as f64;
        let at = |k: usize| {
            let [u, v] = square_of(self.data[k].direction);
            DVec3::new(u - 0.5, v - 0.5, 1.0)
        };
        let (mut matrix, mut right, mut sum, mut largest) = (DMat3::ZERO, DVec3::ZERO, 0.0, 0.0f64);
        for &k in samples {
            let (p, z) = (at(k), self.data[k].value);
            matrix += DMat3::from_cols(p * p.x, p * p.y, p);
            right += p * z;
            sum += z;
            largest = largest.max(z.abs());
        }
        let plane = if samples.len() >= LEAST && matrix.determinant().abs() > 1e-9 * n {
            matrix.inverse() * right
        } else {
            DVec3::new(0.0, 0.0, sum / n)
        };
        let error: f64 = samples.iter().map(|&k| (plane.dot(at(k)) - self.data[k].value).powi(2)).sum::<f64>() / n;
        let mean = sum.abs() / n;
        let spread = (samples.iter().map(|&k| (self.data[k].value - sum / n).powi(2)).sum::<f64>() / n).sqrt();
        if spread * area <= self.negligible {
            return true;
        }
        // Steep planes are not one lobe, however flat.
        let steep = samples.iter().any(|&k| (self.data[k].value - mean).abs() > STEEP * mean + self.noise);
        error.sqrt() <= (self.tolerance * mean).max(self.noise) && (!steep || largest <= 3.0 * self.noise)
    }

    /// Makes a lobe of a square; one without samples takes the value of the nearest.
    fn leaf(&mut self, x: usize, y: usize, side: usize) {
        let centre = direction_of((x as f64 + 0.5 * side as f64) / SIDE as f64, (y as f64 + 0.5 * side as f64) / SIDE as f64);
        let mut samples = self.inside(x, y, side);
        let empty = samples.is_empty();
        if empty {
            // The parent has some.
            let (px, py) = (x / (2 * side) * 2 * side, y / (2 * side) * 2 * side);
            let around = self.inside(px, py, 2 * side);
            let distance = |k: &usize| (self.data[*k].direction - centre).length_squared();
            samples.extend(around.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))));
        }
        if samples.is_empty() {
            return;
        }
        let spacing = self.spacing(x + side / 2, y + side / 2);
        if empty && side as f64 <= spacing {
            // The lobes around it reach as far.
            return;
        }
        let n = samples.len() as f64;
        let area = TAU * (side * side) as f64 / CELLS as f64;
        let mean = samples.iter().map(|&k| self.data[k].value).sum::<f64>() / n;
        let weighted: DVec3 = samples.iter().map(|&k| self.data[k].value.max(0.0) * self.data[k].direction).sum();
        samples.iter().for_each(|&k| self.data[k].weight += area / n);
        // A square that is covered keeps its middle; in one with few samples these say where the light is.
        let direction = if empty || n >= 0.5 * (side * side) as f64 && side > 1 { centre } else { weighted.normalize_or(centre) };
        self.leaves.push(Leaf { direction, side, mean, spacing });
    }

    /// Distance between the samples around a cell, cells.
    fn spacing(&self, x: usize, y: usize) -> f64 {
        let mut half = 1;
        loop {
            let range = |c: usize| c.saturating_sub(half)..(c + half + 1).min(SIDE);
            let count = range(x)
                .map(|i| self.index[i * SIDE + range(y).start..i * SIDE + range(y).end].iter().filter(|k| **k != u32::MAX).count())
                .sum::<usize>();
            if count >= 6 || half >= SIDE {
                return ((range(x).len() * range(y).len()) as f64 / count.max(1) as f64).sqrt();
            }
            half += half.div_ceil(2);
        }
    }
}

/// Changes the masses of lobes until their sum meets the samples.
fn sharpen(leaves: &[Leaf], data: &[Datum], index: &[u32]) -> Vec<Lobe> {
    let unit = |leaf: &Leaf| Lobe {
        direction: upper(leaf.direction),
        radius: (RADIUS * leaf.side as f64).max(leaf.spacing.min(LARGEST as f64)) * CELL,
        mass: 1.0,
    };
    let mut lobes: Vec<Lobe> = leaves.iter().map(unit).collect();
    // Per lobe the samples in its reach, with its DSF there.
    let reach: Vec<Vec<(u32, f32)>> = lobes.iter().map(|l| reach(l, data, index)).collect();
    for (lobe, leaf) in lobes.iter_mut().zip(leaves) {
        lobe.mass = (leaf.mean * TAU * (leaf.side * leaf.side) as f64 / CELLS as f64).max(0.0);
    }
    let mut model = vec![0.0f64; data.len()];
    for _ in 0..ITERATIONS {
        model.fill(0.0);
        for (lobe, reach) in lobes.iter().zip(&reach) {
            reach.iter().for_each(|(k, f)| model[*k as usize] += lobe.mass * f64::from(*f));
        }
        for (lobe, reach) in lobes.iter_mut().zip(&reach) {
            let (mut up, mut down) = (0.0, 0.0);
            for (k, f) in reach {
                let (d, m) = (&data[*k as usize], model[*k as usize]);
                let w = d.weight * f64::from(*f);
                down += w;
                up += if m > 0.0 { w * d.value.max(0.0) / m } else { 0.0 };
            }
            if down > 0.0 {
                lobe.mass *= (up / down).powf(OVERRELAXED);
            }
        }
    }
    // The integral: that of the lobes, and of what they leave of the samples. So averages keep what is below zero, and
    // a peak between samples is that of the lobes, not of a sum over samples.
    model.fill(0.0);
    for (lobe, reach) in lobes.iter().zip(&reach) {
        reach.iter().for_each(|(k, f)| model[*k as usize] += lobe.mass * f64::from(*f));
    }
    let total: f64 = lobes.iter().map(|l| l.mass).sum();
    let left: f64 = data.iter().zip(&model).map(|(d, m)| d.weight * (d.value - m)).sum();
    let measured = total + left;
    if !(measured > 0.0 && total > 0.0) {
        return Vec::new();
    }
    lobes.iter_mut().for_each(|l| l.mass *= measured / total);
    lobes.retain(|l| l.mass > 1e-9 * measured);
    lobes
}

fn reach(lobe: &Lobe, data: &[Datum], index: &[u32]) -> Vec<(u32, f32)> {
    let [u, v] = square_of(lobe.direction);
    let window = 0.81 * CUT * lobe.radius + 1.0 / SIDE as f64;
    let range = |c: f64| {
        let low = ((c - window) * SIDE as f64).max(0.0) as usize;
        low..(((c + window) * SIDE as f64).max(0.0) as usize + 1).min(SIDE)
    };
    let (amplitude, inverse) = (lobe.amplitude(), 1.0 / (lobe.radius * lobe.radius));
    let mut found = Vec::new();
    for x in range(u) {
        for y in range(v) {
            let k = index[x * SIDE + y];
            if k != u32::MAX {
                let exponent = (lobe.direction.dot(data[k as usize].direction) - 1.0) * inverse;
                if exponent > -0.5 * CUT * CUT {
                    found.push((k, (amplitude * exponent.exp()) as f32));
                }
            }
        }
    }
    found
}

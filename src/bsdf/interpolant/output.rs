//! Tensor trees and matrices of an interpolant.
//!
//! The lobes of an incident direction are summed on squares of equal solid angle, wide ones on a coarse grid, and what
//! each scatters above the plane stays exactly as it is. A cell or bin of the result is the mean of many samples of
//! that sum; the whole is then scaled so that its hemispherical value is that of the lobes.

use super::{CUT, Interpolant, LEAST_COSINE, Lobe};
use crate::bins::AngleBasis;
use crate::bins::shirley_chiu::disk_from_square;
use crate::bsdf::scans::{direction_of, square_of};
use crate::bsdf::{KlemsMatrix, TensorTree, projected_solid_angles};
use crate::error::{Error, Result};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

/// Grids by their cells per side, coarse to fine.
const SIDES: [usize; 4] = [32, 64, 128, 256];
const FINEST: usize = SIDES[3];
/// Least radius of a lobe in widths of a grid's cells, but for the finest.
const LEAST_RADIUS: f64 = 1.6;
/// Finest trees of each rank.
const FINEST_TREE: [u32; 2] = [7, 6];

fn directions(level: usize) -> &'static [[f32; 3]] {
    static TABLES: [OnceLock<Vec<[f32; 3]>>; 4] = [const { OnceLock::new() }; 4];
    TABLES[level].get_or_init(|| {
        let side = SIDES[level];
        let at = |k: usize| (k as f64 + 0.5) / side as f64;
        (0..side * side).map(|c| direction_of(at(c / side), at(c % side)).as_vec3().to_array()).collect()
    })
}

/// The DSF of lobes on the finest grid, 1/sr.
fn raster(lobes: &[Lobe]) -> Vec<f32> {
    let mut sum: Vec<f32> = Vec::new();
    let mut weights: Vec<f32> = Vec::new();
    for (level, side) in SIDES.into_iter().enumerate() {
        sum = if level == 0 { vec![0.0; side * side] } else { finer(&sum, side) };
        let cell = TAU.sqrt() / side as f64;
        let finest = side == FINEST;
        let is_here = |l: &&Lobe| (finest || l.radius >= LEAST_RADIUS * cell) && (level == 0 || l.radius < LEAST_RADIUS * 2.0 * cell);
        for lobe in lobes.iter().filter(is_here) {
            splat(lobe, level, &mut sum, &mut weights);
        }
    }
    sum
}

/// Adds a lobe, scaled so that the sum over cells is its mass.
fn splat(lobe: &Lobe, level: usize, sum: &mut [f32], weights: &mut Vec<f32>) {
    let side = SIDES[level];
    let table = directions(level);
    let [u, v] = square_of(lobe.direction);
    let reach = 0.81 * CUT * lobe.radius;
    let range = |c: f64| (((c - reach) * side as f64).max(0.0) as usize, (((c + reach) * side as f64) as usize + 1).min(side));
    let ((x0, x1), (y0, y1)) = (range(u), range(v));
    let d = lobe.direction.as_vec3();
    let inverse = (1.0 / (lobe.radius * lobe.radius)) as f32;
    let cut = (-0.5 * CUT * CUT) as f32;
    weights.clear();
    let mut total = 0.0f64;
    for x in x0..x1 {
        let mut row = 0.0f32;
        for c in &table[x * side + y0..x * side + y1] {
            let exponent = (d.x * c[0] + d.y * c[1] + d.z * c[2] - 1.0) * inverse;
            let weight = if exponent < cut { 0.0 } else { exponent.exp() };
            row += weight;
            weights.push(weight);
        }
        total += f64::from(row);
    }
    let area = TAU / (side * side) as f64;
    if total < 1e-6 {
        // Narrower than a cell.
        sum[(u * side as f64) as usize * side + (v * side as f64) as usize] += (lobe.mass / area) as f32;
        return;
    }
    let scale = (lobe.mass / (total * area)) as f32;
    for (x, weights) in (x0..x1).zip(weights.chunks_exact(y1 - y0)) {
        for (s, w) in sum[x * side + y0..x * side + y1].iter_mut().zip(weights) {
            *s += w * scale;
        }
    }
}

/// Onto a grid twice as fine, linear between the middles of cells; the sum stays.
fn finer(coarse: &[f32], side: usize) -> Vec<f32> {
    let half = side / 2;
    let near = |k: usize| {
        let c = k / 2;
        (c, if k.is_multiple_of(2) { c.saturating_sub(1) } else { (c + 1).min(half - 1) })
    };
    let mut fine = vec![0.0; side * side];
    for x in 0..side {
        let (a, b) = near(x);
        for (y, value) in fine[x * side..(x + 1) * side].iter_mut().enumerate() {
            let (c, d) = near(y);
            let row = |r: usize| 0.75 * coarse[r * half + c] + 0.25 * coarse[r * half + d];
            *value = 0.75 * row(a) + 0.25 * row(b);
        }
    }
    fine
}

/// Where bins of a target look into the finest grid.
struct Sampler {
    per_bin: usize,
    /// Corner, fractions to the next row and column, 1 / cosine.
    samples: Vec<(u32, f32, f32, f32)>,
    /// Projected solid angles of the bins, sr.
    bins: Vec<f64>,
}

impl Sampler {
    fn new(bins: Vec<f64>, per_bin: usize, direction: impl Fn(usize, usize) -> DVec3) -> Self {
        let sample = |k: usize| {
            let d = direction(k / per_bin, k % per_bin);
            let [u, v] = square_of(d).map(|c| (c * FINEST as f64 - 0.5).clamp(0.0, FINEST as f64 - 1.001));
            ((u as usize * FINEST + v as usize) as u32, u.fract() as f32, v.fract() as f32, (1.0 / d.z.abs().max(LEAST_COSINE)) as f32)
        };
        Self { per_bin, samples: (0..bins.len() * per_bin).map(sample).collect(), bins }
    }

    /// For cells of a tree, n per side.
    fn cells(n: usize) -> Self {
        let per_side = (256 / n).clamp(4, 8);
        Self::new(vec![PI / (n * n) as f64; n * n], per_side * per_side, |cell, k| {
            let at = |place: usize, part: usize| (place as f64 + (part as f64 + 0.5) / per_side as f64) / n as f64;
            let [x, y] = disk_from_square(at(cell / n, k / per_side), at(cell % n, k % per_side));
            DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
        })
    }

    fn basis(basis: &AngleBasis) -> Self {
        const PER_SIDE: usize = 24;
        let at = |k: usize| (k as f64 + 0.5) / PER_SIDE as f64;
        Self::new(projected_solid_angles(basis), PER_SIDE * PER_SIDE, |bin, k| basis.direction(bin, at(k / PER_SIDE), at(k % PER_SIDE)))
    }

    /// Means of the BSDF over the bins, 1/sr.
    fn means(&self, lobes: &[Lobe]) -> Vec<f64> {
        let grid = raster(lobes);
        let mut means: Vec<f64> = self
            .samples
            .chunks_exact(self.per_bin)
            .map(|samples| {
                let sum: f32 = samples
                    .iter()
                    .map(|&(k, u, v, inverse)| {
                        let k = k as usize;
                        let row = |k: usize| grid[k] + v * (grid[k + 1] - grid[k]);
                        (row(k) + u * (row(k + FINEST) - row(k))) * inverse
                    })
                    .sum();
                f64::from(sum) / self.per_bin as f64
            })
            .collect();
        let sampled: f64 = means.iter().zip(&self.bins).map(|(f, l)| f * l).sum();
        let mass: f64 = lobes.iter().map(|l| l.mass).sum();
        if sampled > 0.0 {
            means.iter_mut().for_each(|f| *f *= mass / sampled);
        }
        means
    }
}

/// The interpolant as a matrix over angle bases: means over both bins.
pub fn to_klems(interpolant: &Interpolant, incident: &AngleBasis, outgoing: &AngleBasis) -> KlemsMatrix {
    const PER_SIDE: usize = 4;
    let sampler = Sampler::basis(outgoing);
    let at = |k: usize| (k as f64 + 0.5) / PER_SIDE as f64;
    let columns: Vec<Vec<f64>> = (0..incident.len())
        .into_par_iter()
        .map(|bin| {
            let mut column = vec![0.0; outgoing.len()];
            for k in 0..PER_SIDE * PER_SIDE {
                let light = incident.direction(bin, at(k / PER_SIDE), at(k % PER_SIDE));
                let means = sampler.means(&interpolant.at(light));
                column.iter_mut().zip(means).for_each(|(c, m)| *c += m / (PER_SIDE * PER_SIDE) as f64);
            }
            column
        })
        .collect();
    let values = (0..outgoing.len()).flat_map(|o| columns.iter().map(move |c| c[o])).collect();
    KlemsMatrix::new(incident.clone(), outgoing.clone(), values).expect("as many values as bins")
}

/// The interpolant as a tensor tree of rank 3 or 4 with up to 2^log2 cells per side, of which `reduce` percent are joined
/// where they differ least.
///
/// Incident light is that of the middle of each cell; at rank 3 of its plane φ = 0, or the mean over all azimuths if the
/// sample is not isotropic.
///
/// # Errors
/// If rank, resolution or reduction is not supported.
pub fn to_tree(interpolant: &Interpolant, rank: usize, log2: u32, reduce: f64) -> Result<TensorTree> {
    if !(rank == 3 || rank == 4) || !(2..=FINEST_TREE[rank - 3]).contains(&log2) {
        return Err(Error::new(format!("a tensor tree of rank {rank} with 2^{log2} cells per side cannot be made"))
            .help(format!("t3:2 to t3:{}, t4:2 to t4:{}", FINEST_TREE[0], FINEST_TREE[1])));
    }
    if !(0.0..100.0).contains(&reduce) {
        return Err(Error::new(format!("{reduce} % is not within 0…100 %")).field("--reduce"));
    }
    let n = 1usize << log2;
    let sampler = Sampler::cells(n);
    let mut grid = vec![0f32; n.pow(rank as u32)];
    let incident = if rank == 4 { n * n } else { n / 2 };
    grid.par_chunks_mut(n * n).take(incident).enumerate().for_each(|(cell, slice)| {
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        let lobes = if rank == 4 {
            let [x, y] = disk_from_square(at(cell / n), at(cell % n));
            interpolant.at(DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()))
        } else {
            around(interpolant, 1.0 - 2.0 * at(cell))
        };
        slice.iter_mut().zip(sampler.means(&lobes)).for_each(|(s, m)| *s = m as f32);
    });
    Ok(reduced(rank, log2, &grid, reduce))
}

/// The lobes of light at sin θ, turned so that it travels along +x.
fn around(interpolant: &Interpolant, sin: f64) -> Vec<Lobe> {
    let cos = (1.0 - sin * sin).max(0.0).sqrt();
    if interpolant.mesh.is_chain() {
        return interpolant.at(DVec3::new(sin, 0.0, cos));
    }
    const AZIMUTHS: usize = 24;
    let turned = |k: usize| {
        let (s, c) = (TAU * k as f64 / AZIMUTHS as f64).sin_cos();
        let back = move |d: DVec3| DVec3::new(c * d.x + s * d.y, c * d.y - s * d.x, d.z);
        let lobes = interpolant.at(DVec3::new(sin * c, sin * s, cos));
        lobes.into_iter().map(move |l| Lobe { direction: back(l.direction), mass: l.mass / AZIMUTHS as f64, ..l })
    };
    (0..AZIMUTHS).flat_map(turned).collect()
}

/// The tree over a grid that holds at most the given share of its values.
fn reduced(rank: usize, log2: u32, grid: &[f32], percent: f64) -> TensorTree {
    let used = if rank == 4 { grid.len() } else { grid.len() / 2 };
    let wanted = ((1.0 - percent / 100.0) * used as f64).max(1.0) as usize;
    let exact = TensorTree::from_grid(rank, log2, grid, 0.0);
    if percent == 0.0 || exact.len() <= wanted {
        return exact;
    }
    let (mut low, mut high) = (0.0, 1.0);
    let mut best = TensorTree::from_grid(rank, log2, grid, high);
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        let tree = TensorTree::from_grid(rank, log2, grid, middle);
        if tree.len() > wanted {
            low = middle;
        } else {
            (high, best) = (middle, tree);
        }
    }
    best
}

/// The brightest part of a distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Where it is.
    pub direction: DVec3,
    /// Largest DSF, 1/sr.
    pub value: f64,
    /// Full width at half of it, degrees: of a disc of the solid angle that is at least half as bright.
    pub width: f64,
}

/// The brightest part of what is scattered of light that travels along `incident`.
pub fn peak(interpolant: &Interpolant, incident: DVec3) -> Peak {
    let grid = raster(&interpolant.at(incident));
    let largest = grid.iter().copied().fold(0.0, f32::max);
    let table = directions(SIDES.len() - 1);
    let (mut sum, mut count) = (DVec3::ZERO, 0usize);
    for (value, d) in grid.iter().zip(table).filter(|(v, _)| **v >= 0.5 * largest && largest > 0.0) {
        sum += f64::from(*value) * DVec3::from(d.map(f64::from));
        count += 1;
    }
    let solid = TAU * count as f64 / (FINEST * FINEST) as f64;
    Peak { direction: sum.normalize_or(DVec3::Z), value: f64::from(largest), width: 2.0 * (1.0 - solid / TAU).acos().to_degrees() }
}

//! Changing the basis of scattering data without losing energy.
//!
//! Every value of the new data is the mean of the old function over the new bin or cell, weighted
//! by projected solid angle on both sides. So hemispherical values stay, and the new function is
//! the orthogonal projection of the old one: the mean square error is the difference of the two
//! mean squares.

use super::overlap::{Overlaps, basis_with_basis, grid_with_basis};
use super::{Block, KlemsMatrix, TensorTree, projected_solid_angles};
use crate::bins::AngleBasis;
use crate::error::{Error, Result};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// The block over other angle bases.
///
/// Exact, but for trees of rank 3, whose turning outgoing directions are sampled (the
/// direct-hemispherical values are exact all the same).
pub fn to_klems(block: &Block, incident: &AngleBasis, outgoing: &AngleBasis) -> KlemsMatrix {
    match block {
        Block::Klems(m) if m.incident() == incident && m.outgoing() == outgoing => m.clone(),
        Block::Klems(m) => {
            let (by_in, by_out) = (basis_with_basis(incident, m.incident()), basis_with_basis(outgoing, m.outgoing()));
            averaged(incident, outgoing, &by_in, &by_out, |o, i| m.at(o, i))
        }
        Block::Tree(t) if t.rank() == 4 => tree4_to_klems(t, incident, outgoing),
        Block::Tree(t) => tree3_to_klems(t, incident, outgoing),
    }
}

/// Means over new bins from the overlaps of each new bin with old ones.
fn averaged(
    incident: &AngleBasis,
    outgoing: &AngleBasis,
    by_in: &Overlaps,
    by_out: &Overlaps,
    value: impl Fn(usize, usize) -> f64,
) -> KlemsMatrix {
    let mut values = Vec::with_capacity(incident.len() * outgoing.len());
    let (lambda_in, lambda_out) = (projected_solid_angles(incident), projected_solid_angles(outgoing));
    for (o, out_parts) in by_out.iter().enumerate() {
        for (i, in_parts) in by_in.iter().enumerate() {
            let mut sum = 0.0;
            for (oo, a) in out_parts {
                sum += a * in_parts.iter().map(|(ii, b)| b * value(*oo, *ii)).sum::<f64>();
            }
            values.push(sum / (lambda_out[o] * lambda_in[i]));
        }
    }
    KlemsMatrix::new(incident.clone(), outgoing.clone(), values).expect("as many values as bins")
}

fn tree4_to_klems(tree: &TensorTree, incident: &AngleBasis, outgoing: &AngleBasis) -> KlemsMatrix {
    let mut grids: HashMap<usize, (Overlaps, Overlaps)> = HashMap::new();
    let n_in = incident.len();
    let mut sums = vec![0.0; n_in * outgoing.len()];
    tree.for_each_cell(|cell| {
        if cell.value == 0.0 {
            return;
        }
        let n = (1.0 / cell.side).round() as usize;
        let (on_in, on_out) = grids.entry(n).or_insert_with(|| (grid_with_basis(n, incident), grid_with_basis(n, outgoing)));
        let index = |a: f64, b: f64| (a * n as f64).round() as usize * n + (b * n as f64).round() as usize;
        let [a, b, c, d] = cell.corner;
        for (o, area_out) in &on_out[index(c, d)] {
            for (i, area_in) in &on_in[index(a, b)] {
                sums[o * n_in + i] += cell.value * area_out * area_in;
            }
        }
    });
    let (lambda_in, lambda_out) = (projected_solid_angles(incident), projected_solid_angles(outgoing));
    for (k, sum) in sums.iter_mut().enumerate() {
        *sum /= lambda_out[k / n_in] * lambda_in[k % n_in];
    }
    KlemsMatrix::new(incident.clone(), outgoing.clone(), sums).expect("as many values as bins")
}

/// Samples per side of an outgoing bin, and of an incident bin, for rank 3.
const SAMPLES_OUT: usize = 4;
const SAMPLES_IN: usize = 4;

fn tree3_to_klems(tree: &TensorTree, incident: &AngleBasis, outgoing: &AngleBasis) -> KlemsMatrix {
    let stratum = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let lambda_out = projected_solid_angles(outgoing);
    let columns: Vec<Vec<f64>> = (0..incident.len())
        .into_par_iter()
        .map(|i| {
            let mut column = vec![0.0; outgoing.len()];
            let mut exact = 0.0;
            for s in 0..SAMPLES_IN * SAMPLES_IN {
                let light = incident.direction(i, stratum(s / SAMPLES_IN, SAMPLES_IN), stratum(s % SAMPLES_IN, SAMPLES_IN));
                exact += tree.direct_hemispherical(light);
                for (o, sum) in column.iter_mut().enumerate() {
                    for k in 0..SAMPLES_OUT * SAMPLES_OUT {
                        *sum += tree.evaluate(
                            outgoing.direction(o, stratum(k / SAMPLES_OUT, SAMPLES_OUT), stratum(k % SAMPLES_OUT, SAMPLES_OUT)),
                            light,
                        );
                    }
                }
            }
            let sampled: f64 = column.iter().zip(&lambda_out).map(|(f, l)| f * l).sum::<f64>() / (SAMPLES_OUT * SAMPLES_OUT) as f64;
            let scale = if sampled > 0.0 { exact / sampled } else { 1.0 } / (SAMPLES_IN * SAMPLES_IN * SAMPLES_OUT * SAMPLES_OUT) as f64;
            column.iter().map(|f| f * scale).collect()
        })
        .collect();
    let values = (0..outgoing.len()).flat_map(|o| columns.iter().map(move |c| c[o])).collect();
    KlemsMatrix::new(incident.clone(), outgoing.clone(), values).expect("as many values as bins")
}

/// Finest tree that is made: 2^6 cells per side are 16.8 million values at rank 4.
pub const FINEST_TREE: u32 = 6;

/// The block as a tensor tree of rank 3 or 4 with up to 2^log2 cells per side. Cells of equal value
/// (to `tolerance` times the larger one) are joined.
///
/// # Errors
/// If rank or resolution is not supported.
pub fn to_tree(block: &Block, rank: usize, log2: u32, tolerance: f64) -> Result<TensorTree> {
    if !(rank == 3 || rank == 4) || !(1..=FINEST_TREE).contains(&log2) {
        return Err(Error::new(format!("a tensor tree of rank {rank} with 2^{log2} cells per side cannot be made"))
            .help(format!("rank 3 or 4, 2^1 to 2^{FINEST_TREE} cells per side")));
    }
    let n = 1usize << log2;
    if rank == 3 {
        let grid = match block {
            Block::Tree(t) if t.rank() == 3 => t.to_grid(log2),
            _ => isotropic_grid(block, n),
        };
        return Ok(TensorTree::from_grid(3, log2, &grid, tolerance));
    }
    let grid = match block {
        Block::Klems(m) => klems_to_grid(m, n),
        Block::Tree(t) if t.rank() == 3 => {
            return Err(Error::new("an isotropic tree (rank 3) is not turned into rank 4").help("keep rank 3, or convert to a Klems basis"));
        }
        Block::Tree(t) => t.to_grid(log2),
    };
    Ok(TensorTree::from_grid(4, log2, &grid, tolerance))
}

/// Means over the cells of an n⁴ grid, last dimension fastest.
fn klems_to_grid(m: &KlemsMatrix, n: usize) -> Vec<f32> {
    let (on_in, on_out) = (grid_with_basis(n, m.incident()), grid_with_basis(n, m.outgoing()));
    let cell = PI / (n * n) as f64;
    let mut grid = vec![0f32; n.pow(4)];
    grid.par_chunks_mut(n * n).zip(&on_in).for_each(|(slice, in_parts)| {
        let mut column = vec![0.0; m.outgoing().len()];
        for (o, value) in column.iter_mut().enumerate() {
            *value = in_parts.iter().map(|(i, a)| a * m.at(o, *i)).sum::<f64>() / cell;
        }
        for (value, out_parts) in slice.iter_mut().zip(&on_out) {
            *value = (out_parts.iter().map(|(o, a)| a * column[*o]).sum::<f64>() / cell) as f32;
        }
    });
    grid
}

/// Azimuths over which an anisotropic function is averaged into an isotropic one.
const AZIMUTHS: usize = 48;

/// Means over the cells of an n³ grid after averaging over azimuth. The outgoing side is sampled;
/// each slice is then scaled to its exact mean direct-hemispherical value.
fn isotropic_grid(block: &Block, n: usize) -> Vec<f32> {
    const SUB: usize = 3;
    let stratum = |k: usize| (k as f64 + 0.5) / SUB as f64;
    let half = n / 2;
    let slices: Vec<Vec<f32>> = (0..half.max(1))
        .into_par_iter()
        .map(|slice| {
            let mut sums = vec![0f64; n * n];
            let mut weight = 0.0;
            for s in 0..SUB {
                // sin θ = 1 − 2 x; weight of diffuse light ∝ sin θ.
                let sin: f64 = (1.0 - 2.0 * (slice as f64 + stratum(s)) / n as f64).clamp(0.0, 1.0);
                for k in 0..AZIMUTHS {
                    let phi = TAU * (k as f64 + 0.5) / AZIMUTHS as f64;
                    let light = DVec3::new(sin * phi.cos(), sin * phi.sin(), (1.0 - sin * sin).sqrt());
                    weight += sin;
                    for (cell, sum) in sums.iter_mut().enumerate() {
                        for q in 0..SUB * SUB {
                            let u = ((cell / n) as f64 + stratum(q / SUB)) / n as f64;
                            let v = ((cell % n) as f64 + stratum(q % SUB)) / n as f64;
                            let [x, y] = crate::bins::shirley_chiu::disk_from_square(u, v);
                            let (x, y) = (x * phi.cos() - y * phi.sin(), x * phi.sin() + y * phi.cos());
                            let out = DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
                            *sum += sin * block.evaluate(out, light);
                        }
                    }
                }
            }
            let cell = PI / (n * n) as f64;
            let sampled: f64 = sums.iter().sum::<f64>() * cell / (SUB * SUB) as f64;
            let exact = mean_direct_hemispherical(block, 1.0 - 2.0 * (slice + 1) as f64 / n as f64, 1.0 - 2.0 * slice as f64 / n as f64);
            let scale = if sampled > 0.0 { exact * weight / sampled } else { 1.0 } / (weight * (SUB * SUB) as f64);
            sums.iter().map(|v| (v * scale) as f32).collect()
        })
        .collect();
    let mut grid = vec![0f32; n.pow(3)];
    for (slice, values) in slices.iter().enumerate() {
        grid[slice * n * n..(slice + 1) * n * n].copy_from_slice(values);
    }
    grid
}

/// Mean direct-hemispherical value of light whose sin θ lies between two limits, uniform in
/// projected solid angle.
fn mean_direct_hemispherical(block: &Block, sin_min: f64, sin_max: f64) -> f64 {
    let (low, high) = (sin_min.max(0.0).powi(2), sin_max.min(1.0).powi(2));
    match block {
        Block::Klems(m) => {
            let sums = m.all_direct_hemispherical();
            let sin2 = |deg: f64| if deg >= 90.0 { 1.0 } else { deg.to_radians().sin().powi(2) };
            let ring_mean = |ring: &crate::bins::Ring| {
                let share = (high.min(sin2(ring.theta_max)) - low.max(sin2(ring.theta_min))).max(0.0) / (high - low);
                share * sums[ring.first..ring.first + ring.bins].iter().sum::<f64>() / ring.bins as f64
            };
            m.incident().rings().iter().map(ring_mean).sum()
        }
        Block::Tree(_) => {
            const STEPS: usize = 8;
            let sample = |k: usize| {
                let sin = (low + (high - low) * ((k / AZIMUTHS) as f64 + 0.5) / STEPS as f64).sqrt();
                let phi = TAU * ((k % AZIMUTHS) as f64 + 0.5) / AZIMUTHS as f64;
                block.direct_hemispherical(DVec3::new(sin * phi.cos(), sin * phi.sin(), (1.0 - sin * sin).max(0.0).sqrt()))
            };
            (0..STEPS * AZIMUTHS).map(sample).sum::<f64>() / (STEPS * AZIMUTHS) as f64
        }
    }
}

/// What changing the basis costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loss {
    /// New hemispherical-hemispherical value minus the old one.
    pub hemispherical: f64,
    /// New largest value / old largest value.
    pub peak: f64,
    /// Root of the mean square difference over both hemispheres, in projected solid angle, 1/sr.
    pub rms: f64,
    /// The root mean square of the old values, for comparison, 1/sr.
    pub rms_of_source: f64,
}

/// Compares a block with its projection onto another basis (see the [module](self)).
pub fn loss(source: &Block, projected: &Block) -> Loss {
    let (square, largest) = mean_square(source);
    let (new_square, new_largest) = mean_square(projected);
    Loss {
        hemispherical: projected.hemispherical() - source.hemispherical(),
        peak: if largest > 0.0 { new_largest / largest } else { 1.0 },
        rms: (square - new_square).max(0.0).sqrt(),
        rms_of_source: square.sqrt(),
    }
}

/// Mean of the squared values over both hemispheres, and the largest value.
fn mean_square(block: &Block) -> (f64, f64) {
    let (mut sum, mut largest) = (0.0, 0.0f64);
    match block {
        Block::Klems(m) => {
            let (lambda_in, lambda_out) = (projected_solid_angles(m.incident()), projected_solid_angles(m.outgoing()));
            for (k, f) in m.values().iter().enumerate() {
                sum += f * f * lambda_out[k / lambda_in.len()] * lambda_in[k % lambda_in.len()] / (PI * PI);
                largest = largest.max(*f);
            }
        }
        Block::Tree(t) => t.for_each_cell(|c| {
            let incident = if t.rank() == 4 { c.side * c.side } else { TensorTree::diffuse_share(&c) };
            sum += c.value * c.value * c.side * c.side * incident;
            largest = largest.max(c.value);
        }),
    }
    (sum, largest)
}

#[cfg(test)]
mod tests;

//! From the table of sums to BSDF blocks: matrices, or trees reduced where they are even.

use super::{Directions, Table};
use crate::bins::AngleBasis;
use crate::bsdf::{Block, Component, KlemsMatrix, TensorTree};
use rayon::prelude::*;

/// Bins of the histogram from which the threshold of [`reduce`] comes, and its range
/// (Radiance's `rttree_reduce`).
const HISTOGRAM_BINS: usize = 300;
const HISTOGRAM_END: f64 = 4.0;

impl Table {
    /// The block of a component. Of trees, cubes of cells are joined to their mean where they vary
    /// little: `cull` per cent of the finest ones (Radiance's `rttree_reduce -t`; 0 keeps all).
    pub fn block(&self, component: Component, cull: f64) -> Block {
        match self.directions() {
            Directions::Klems(basis) => {
                let basis = AngleBasis::from(basis);
                Block::Klems(KlemsMatrix::from_fn(&basis, |o, i| self.mean(component, o, i)))
            }
            Directions::Tree4(log2) => {
                let n = self.directions().outgoing();
                let mut grid: Vec<f32> = (0..n * n).into_par_iter().map(|k| self.mean(component, k % n, k / n) as f32).collect();
                reduce(&mut grid, 4, log2, cull);
                Block::Tree(TensorTree::from_grid(4, log2, &grid, 0.0))
            }
            Directions::Tree3(log2) => {
                let n = self.directions().outgoing();
                // The upper half of the first dimension is not used.
                let used = self.directions().incident() * n;
                let mut grid: Vec<f32> =
                    (0..2 * used).map(|k| if k < used { self.mean(component, k % n, k / n) as f32 } else { 0.0 }).collect();
                reduce(&mut grid, 3, log2, cull);
                Block::Tree(TensorTree::from_grid(3, log2, &grid, 0.0))
            }
        }
    }
}

/// Least, largest and sum of the values in a cube.
#[derive(Clone, Copy)]
struct Spread {
    least: f32,
    largest: f32,
    sum: f64,
}

impl Spread {
    /// Variation by which cubes are compared, over the mean of `cells` values.
    fn variation(&self, cells: f64) -> f64 {
        let mean = (self.sum / cells).max(0.0);
        (f64::from(self.largest - self.least) / (mean.sqrt() + 0.03)).sqrt()
    }
}

/// Sets cubes that vary no more than a threshold to their mean: the threshold is exceeded by all but
/// `cull` per cent of the cubes of 2^rank cells. The last dimension of `grid` runs fastest. Means, so
/// integrals over whole cubes, are kept.
fn reduce(grid: &mut [f32], rank: usize, log2: u32, cull: f64) {
    if cull <= 0.0 || log2 == 0 {
        return;
    }
    let n = 1usize << log2;
    let mut histogram = vec![0usize; HISTOGRAM_BINS];
    let half = n / 2;
    for cube in 0..half.pow(rank as u32) {
        let corner = unravel(cube, half, rank).map(|c| 2 * c);
        let variation = spread(grid, rank, n, corner, 2).variation((1 << rank) as f64);
        histogram[((variation / HISTOGRAM_END * HISTOGRAM_BINS as f64) as usize).min(HISTOGRAM_BINS - 1)] += 1;
    }
    let wanted = (half.pow(rank as u32) as f64 * cull.min(100.0) / 100.0) as usize;
    let mut counted = 0;
    let mut threshold = HISTOGRAM_END;
    for (bin, count) in histogram.into_iter().enumerate() {
        counted += count;
        if counted >= wanted {
            threshold = (bin + 1) as f64 * HISTOGRAM_END / HISTOGRAM_BINS as f64;
            break;
        }
    }
    join(grid, rank, n, [0; 4], n, threshold);
}

/// Joins the cube of `side` cells at `corner`, or else what it consists of.
fn join(grid: &mut [f32], rank: usize, n: usize, corner: [usize; 4], side: usize, threshold: f64) {
    if side < 2 {
        return;
    }
    let cells = side.pow(rank as u32);
    let found = spread(grid, rank, n, corner, side);
    if found.variation(cells as f64) <= threshold {
        let mean = (found.sum / cells as f64) as f32;
        for_each_row(rank, n, corner, side, |row| grid[row].fill(mean));
        return;
    }
    let half = side / 2;
    for child in 0..1usize << rank {
        let part = std::array::from_fn(|d| corner[d] + if d < rank && child >> d & 1 == 1 { half } else { 0 });
        join(grid, rank, n, part, half, threshold);
    }
}

fn spread(grid: &[f32], rank: usize, n: usize, corner: [usize; 4], side: usize) -> Spread {
    let mut all = Spread { least: f32::MAX, largest: f32::MIN, sum: 0.0 };
    for_each_row(rank, n, corner, side, |row| {
        for &v in &grid[row] {
            all.least = all.least.min(v);
            all.largest = all.largest.max(v);
            all.sum += f64::from(v);
        }
    });
    all
}

/// Calls `f` with the ranges of a cube's cells that lie together in memory.
fn for_each_row(rank: usize, n: usize, corner: [usize; 4], side: usize, mut f: impl FnMut(std::ops::Range<usize>)) {
    for row in 0..side.pow(rank as u32 - 1) {
        let offsets = unravel(row, side, rank - 1);
        let mut start = 0;
        for d in 0..rank {
            start = start * n + corner[d] + if d + 1 < rank { offsets[d] } else { 0 };
        }
        f(start..start + side);
    }
}

/// Digits of `index` to the base `n`, the last of `digits` running fastest.
fn unravel(mut index: usize, n: usize, digits: usize) -> [usize; 4] {
    let mut all = [0; 4];
    for d in (0..digits).rev() {
        all[d] = index % n;
        index /= n;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_parts_are_joined_and_the_integral_is_kept() {
        let n = 8usize;
        for rank in [3usize, 4] {
            let mut grid: Vec<f32> = (0..n.pow(rank as u32)).map(|k| 0.3 + 1e-4 * (k % 7) as f32).collect();
            // A peak in one corner.
            grid[0] = 50.0;
            let before: f64 = grid.iter().map(|&v| f64::from(v)).sum();
            reduce(&mut grid, rank, 3, 90.0);
            let after: f64 = grid.iter().map(|&v| f64::from(v)).sum();
            assert!((before - after).abs() < 1e-5 * before);
            assert_eq!(grid[0], 50.0, "the peak stays sharp");
            let tree = TensorTree::from_grid(rank, 3, &grid, 0.0);
            assert!(tree.len() < 100, "rank {rank}: {}", tree.len());
            assert!((tree.lookup([0.01; 4]) - 50.0).abs() < 1e-6);
        }
        let mut grid: Vec<f32> = (0..64).map(|k| k as f32).collect();
        let kept = grid.clone();
        reduce(&mut grid, 3, 2, 0.0);
        assert_eq!(grid, kept);
    }
}

//! Samples summed over cells of equal solid angle: memory depends on the directions, not on the number of samples.

use crate::bins::shirley_chiu::{disk_from_square, square_from_disk};
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Cells per side of the square that the hemisphere is mapped to; a cell is 0.56° wide.
pub(crate) const SIDE: usize = 256;
/// All cells.
pub(crate) const CELLS: usize = SIDE * SIDE;

/// What fell into a cell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums {
    /// Sum of DSF values, 1/sr.
    pub value: f64,
    /// Sum of directions.
    pub direction: DVec3,
    /// Number of samples.
    pub count: u32,
}

/// Sums per cell of a hemisphere, of those cells that have samples.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    cells: HashMap<u32, Sums>,
}

/// Index of the cell of a direction (z is not looked at); equal cells are equal solid angles (Lambert's equal-area
/// projection, then Shirley and Chiu's square).
pub(crate) fn cell_of(direction: DVec3, side: usize) -> usize {
    let [u, v] = square_of(direction);
    (u * side as f64) as usize * side + (v * side as f64) as usize
}

/// The point of the unit square of a direction.
pub(crate) fn square_of(direction: DVec3) -> [f64; 2] {
    let scale = 1.0 / (1.0 + direction.z.abs()).sqrt();
    square_from_disk(direction.x * scale, direction.y * scale)
}

/// The direction of a point of the unit square; z ≥ 0.
pub(crate) fn direction_of(u: f64, v: f64) -> DVec3 {
    let [x, y] = disk_from_square(u, v);
    let r2 = (x * x + y * y).min(1.0);
    let scale = (2.0 - r2).sqrt();
    DVec3::new(x * scale, y * scale, 1.0 - r2)
}

/// The middle of a cell.
pub(crate) fn cell_direction(cell: usize, side: usize) -> DVec3 {
    direction_of(((cell / side) as f64 + 0.5) / side as f64, ((cell % side) as f64 + 0.5) / side as f64)
}

impl Grid {
    pub(super) fn add(&mut self, direction: DVec3, value: f64) {
        let sums = self.cells.entry(cell_of(direction, SIDE) as u32).or_default();
        sums.value += value;
        sums.direction += direction;
        sums.count = sums.count.saturating_add(1);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (cell, from) in other.sorted() {
            let sums = self.cells.entry(cell).or_default();
            sums.value += from.value;
            sums.direction += from.direction;
            sums.count = sums.count.saturating_add(from.count);
        }
    }

    /// Number of cells with samples.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// All cells with samples by index, `row · 256 + column`.
    pub fn sorted(&self) -> Vec<(u32, Sums)> {
        let mut cells: Vec<(u32, Sums)> = self.cells.iter().map(|(c, s)| (*c, *s)).collect();
        cells.sort_unstable_by_key(|(c, _)| *c);
        cells
    }

    /// An estimate of the integral over the hemisphere: 1 is all the light. Within 2 % where values are smooth, rough
    /// where a peak is as narrow as the distance of its samples; that of the fitted lobes is better.
    pub fn integral(&self) -> f64 {
        self.integral_of(|s| s.value / f64::from(s.count))
    }

    /// The integral if the values were a BSDF in place of a DSF.
    pub(super) fn integral_as_bsdf(&self) -> f64 {
        self.integral_of(|s| s.value * s.direction.z.abs() / f64::from(s.count).powi(2))
    }

    /// Cells without samples take the value of the smallest square around them that has some.
    fn integral_of(&self, value: impl Fn(&Sums) -> f64) -> f64 {
        let mut level: HashMap<u32, (f64, f64)> = self.cells.iter().map(|(c, s)| (*c, (value(s), 1.0))).collect();
        let mut side = SIDE as u32;
        while side > 1 {
            let mut next: HashMap<u32, (f64, f64)> = HashMap::new();
            for (cell, (mean, _)) in sorted(&level) {
                let entry = next.entry(cell / side / 2 * (side / 2) + cell % side / 2).or_default();
                entry.0 += mean;
                entry.1 += 1.0;
            }
            next.values_mut().for_each(|(sum, count)| *sum /= *count);
            level = next;
            side /= 2;
        }
        level.values().map(|(mean, _)| mean * TAU).sum()
    }

    /// Whether cells that hold nothing but the largest value lie side by side: a flat top.
    pub(super) fn largest_is_cut(&self, largest: f64) -> bool {
        let flat = |cell: u32| self.cells.get(&cell).is_some_and(|s| s.value == largest * f64::from(s.count));
        let side = SIDE as u32;
        self.cells.keys().any(|&c| c % side + 1 < side && flat(c) && flat(c + 1) && flat(c + side) && flat(c + side + 1))
            && self.cells.values().filter(|s| s.value < 0.5 * largest * f64::from(s.count)).count() * 2 > self.cells.len()
    }
}

/// In a fixed order, so that sums are the same bits every time.
fn sorted(level: &HashMap<u32, (f64, f64)>) -> Vec<(u32, (f64, f64))> {
    let mut all: Vec<_> = level.iter().map(|(c, v)| (*c, *v)).collect();
    all.sort_unstable_by_key(|(c, _)| *c);
    all
}

//! What few paths leave open of the light that receivers get by reflections and by light paths.

use super::near::{LOOK_UNITS, NearPaths};
use crate::kernels::trace::TraceTables;
use crate::kernels::trace::doubt::{ENOUGH_HITS, half_a_hit};
use crate::scene::Window;
use std::f64::consts::PI;

/// What rays would bring that do not all stand for as much, and what those of them bring that arrive.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Chances {
    pub possible: f64,
    /// Sum of the rays' squares.
    pub squares: f64,
    pub arrived: f64,
}

impl Chances {
    /// Adds a ray.
    pub fn add(&mut self, weight: f64, arrives: bool) {
        self.possible += weight;
        self.squares += weight * weight;
        self.arrived += if arrives { weight } else { 0.0 };
    }

    /// Rays of equal weight that would tell as much as these.
    fn rays(&self) -> f64 {
        if self.possible > 0.0 { self.possible * self.possible / self.squares } else { 0.0 }
    }

    /// How many of them arrive.
    pub fn hits(&self) -> f64 {
        if self.possible > 0.0 { self.arrived * self.possible / self.squares } else { 0.0 }
    }

    /// Standard deviation of half a hit more in the mean of so many batches, which add up what their rays bring.
    pub(crate) fn half_a_hit(&self, batches: f64) -> f64 {
        if self.possible > 0.0 { half_a_hit(self.squares / self.possible, batches) } else { 0.0 }
    }

    /// The same; 0 if their spread tells enough.
    pub fn doubt(&self, batches: f64) -> f64 {
        if are_enough(self.hits(), self.rays()) { 0.0 } else { self.half_a_hit(batches) }
    }
}

/// Whether the spread of rays tells enough: so many arrive, and so many do not, or all do. (Few rays that are spread
/// evenly agree among batches even if half of them arrive.)
pub(crate) fn are_enough(hits: f64, rays: f64) -> bool {
    hits >= rays || hits.min(rays - hits) >= ENOUGH_HITS
}

impl NearPaths {
    /// Standard deviation of half a hit more by reflections that have no rays of their own, sr; 0 where enough of
    /// a receiver's paths, so many in all batches, found a window in them.
    pub fn doubt(&self, receiver: usize, count: usize, paths: f64) -> f64 {
        let sum = |i: usize| self.looks.iter().skip(receiver).step_by(count).map(|l| f64::from(l[i])).sum::<f64>();
        let (looks, hits) = (sum(0), sum(1));
        if hits >= ENOUGH_HITS {
            return 0.0;
        }
        let weight = if looks > 0.0 { sum(2) / LOOK_UNITS / looks } else { PI };
        // If there was no look either, half of one might have been.
        half_a_hit(weight, paths) * ((looks + 0.5) / (looks + 1.0)).sqrt()
    }
}

/// Parts of the bins in light whose origin is not known: as windows that emit evenly light the room.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BinShares(Vec<f64>);

impl BinShares {
    pub fn of(tables: &TraceTables, windows: &[Window]) -> Self {
        let area: f64 = tables.windows.iter().map(|w| f64::from(w.area)).sum();
        let of_window = |w: &Window, own: f64| (0..w.basis.len()).map(|b| own / area * w.basis.projected_solid_angle(b) / PI).collect();
        let shares = windows.iter().zip(&tables.windows).flat_map(|(w, record)| -> Vec<f64> { of_window(w, f64::from(record.area)) });
        Self(shares.collect())
    }

    pub(crate) fn of_bin(&self, bin: usize) -> f64 {
        self.0[bin]
    }

    pub fn iter(&self) -> impl Iterator<Item = f64> {
        self.0.iter().copied()
    }
}

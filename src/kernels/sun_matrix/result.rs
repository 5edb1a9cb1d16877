//! What suns bring to receivers, and how sure it is.

use crate::error::Result;
use crate::kernels::trace::doubt::{ENOUGH_HITS, half_a_hit};
use crate::kernels::trace::{TraceStatistics, Values};
use crate::matrix::Matrix;

/// Sun matrix of some receivers. All matrices are `[receiver][sun]`, RGB, sr.
#[derive(Debug, Clone, PartialEq)]
pub struct SunMatrix {
    /// Direct and scattered.
    pub total: Matrix<f32>,
    /// Directly from the sun, by way of flat mirrors, or through a pane's peak.
    pub direct: Matrix<f32>,
    /// Standard error of what is each entry's own, independent from sun to sun: of `direct`, and where few samples
    /// found scattered light because something hides the sun.
    pub own_error: Matrix<f32>,
    /// Standard error of what entries share in the scattered part. Suns of one [set](super::SunOptions::path_sets) share
    /// paths or points, so their errors at one receiver go together, with points those of neighbouring
    /// receivers too, and through panes those of all suns.
    pub shared_error: Matrix<f32>,
    /// Work done.
    pub statistics: TraceStatistics,
}

impl SunMatrix {
    /// No light at all.
    pub fn zeros(receivers: usize, suns: usize) -> Self {
        let shape = || Matrix::zeros(receivers, suns, 3);
        let statistics = TraceStatistics::default();
        Self { total: shape(), direct: shape(), own_error: shape(), shared_error: shape(), statistics }
    }

    /// Adds independent light of the same receivers and suns.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn add(&mut self, other: &Self) {
        assert_eq!((self.total.rows(), self.total.cols()), (other.total.rows(), other.total.cols()), "the same receivers and suns");
        let each = |own: &mut Matrix<f32>, other: &Matrix<f32>, add: fn(f32, f32) -> f32| {
            own.data_mut().iter_mut().zip(other.data()).for_each(|(a, b)| *a = add(*a, *b));
        };
        each(&mut self.total, &other.total, |a, b| a + b);
        each(&mut self.direct, &other.direct, |a, b| a + b);
        each(&mut self.own_error, &other.own_error, f32::hypot);
        each(&mut self.shared_error, &other.shared_error, f32::hypot);
        self.statistics.paths += other.statistics.paths;
        self.statistics.segments += other.statistics.segments;
    }

    /// What a unit of work leaves behind, of these rows.
    pub(super) fn pass(&mut self, rows: &[usize], values: &mut Values) -> Result<()> {
        for matrix in [&mut self.total, &mut self.direct, &mut self.own_error, &mut self.shared_error] {
            rows.iter().try_for_each(|&row| values.pass_rows(matrix, row..row + 1))?;
        }
        Ok(())
    }

    /// Standard error of `total`.
    pub fn standard_error(&self) -> Matrix<f32> {
        let data = self.own_error.data().iter().zip(self.shared_error.data()).map(|(a, b)| a.hypot(*b)).collect();
        Matrix::from_data(self.total.rows(), self.total.cols(), 3, data).expect("the same shape")
    }

    /// Sets the direct part of an entry.
    pub(super) fn set_direct(&mut self, row: usize, sun: usize, c: usize, [mean, variance]: [f64; 2]) {
        self.direct.at_mut(row, sun)[c] = mean as f32;
        self.total.at_mut(row, sun)[c] = mean as f32;
        self.own_error.at_mut(row, sun)[c] = variance.sqrt() as f32;
    }

    /// Adds the scattered part to an entry whose direct part is set, with its own and its shared variance.
    pub(super) fn add_scattered(&mut self, row: usize, sun: usize, c: usize, mean: f64, [own, shared]: [f64; 2]) {
        let total = &mut self.total.at_mut(row, sun)[c];
        *total = (f64::from(*total) + mean) as f32;
        let error = &mut self.own_error.at_mut(row, sun)[c];
        *error = f64::from(*error).hypot(own.sqrt()) as f32;
        self.shared_error.at_mut(row, sun)[c] = shared.sqrt() as f32;
    }
}

/// Mean of independent values and its variance.
pub(super) fn mean_and_variance(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    [mean, values.map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))]
}

/// Variance of a mean by its spread and by what the points seen allow. Few batches often agree by
/// chance, above all where an edge hides a sliver of the disc; the second then counts as much as three
/// further batches would.
pub(super) fn with_doubt(spread: f64, batches: usize, doubt: f64) -> f64 {
    const WEIGHT: f64 = 3.0;
    let degrees = (batches - 1) as f64;
    if doubt > 0.0 { (degrees * spread + WEIGHT * doubt) / (degrees + WEIGHT) } else { spread }
}

/// Samples of a sun's scattered light, of all batches together.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Hits {
    /// Samples that found light, and those that would if nothing hid the sun.
    pub found: f64,
    pub looks: f64,
    /// What the samples brought to their batches.
    pub light: f64,
    /// What one would have if none did.
    pub unseen: f64,
}

impl Hits {
    /// Variances of the mean over so many batches by what few hits leave open, which their spread does not know: half
    /// a hit more. A surface that was met once too seldom was so for all suns; a sun that was hidden once too
    /// often was so by itself: own variance, and shared one.
    pub fn doubts(&self, batches: usize) -> [f64; 2] {
        if self.found >= ENOUGH_HITS {
            return [0.0; 2];
        }
        let weight = if self.found > 0.0 { self.light / self.found } else { self.unseen };
        let all = half_a_hit(weight, batches as f64).powi(2);
        // By the half hit's share in relative variances of as many hits and looks.
        let shared = ((self.found + 0.5) / (self.looks + 0.5)).min(1.0).powi(2);
        [all * (1.0 - shared), all * shared]
    }

    /// The same of one of many suns that a receiver sees by the same surfaces. If no sample of it found light, it may still have
    /// as much as is likely by what they found of `all` suns: hits of a sun that go by a gamma distribution of shape ½, whose
    /// mean is theirs, are after none at all ½·s more with a variance of ½·s², s = mean / (mean + ½).
    pub fn doubts_among(&self, all: &Self, batches: usize) -> [f64; 2] {
        if self.found > 0.0 {
            return self.doubts(batches);
        }
        let mean = self.looks * (all.found + 0.5) / all.looks.max(self.looks).max(1.0);
        let likely = mean / (mean + 0.5);
        let unseen = if all.found > 0.0 { all.light / all.found } else { self.unseen };
        // In units of the variance of half a hit: (½·s)² + ½·s².
        Self { unseen, ..*self }.doubts(batches).map(|variance| variance * (1.5 * likely * likely).min(1.0))
    }

    /// Adds samples of another sun, or batch.
    pub fn add(&mut self, other: &Self) {
        self.found += other.found;
        self.looks += other.looks;
        self.light += other.light;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_hits_of_a_sun_leave_as_much_open_as_is_likely_by_those_of_all() {
        let (batches, one) = (8, Hits { looks: 64.0, unseen: 3.0, ..Hits::default() });
        let sum = |[own, shared]: [f64; 2]| own + shared;
        for found in [0.0, 20.0, 900.0] {
            let all = Hits { found, looks: 640.0, light: 2.0 * found, unseen: 3.0 };
            let mean: f64 = 64.0 * (found + 0.5) / 640.0;
            // ∫ λ² of a gamma distribution and of no hit, λ = u².
            let weighted = |power: i32| -> f64 {
                (0..200_000).map(|i| (f64::from(i) + 0.5) * 1e-4).map(|u| u.powi(2 * power) * (-u * u * (0.5 / mean + 1.0)).exp()).sum()
            };
            let wanted = weighted(2) / weighted(0) * if found > 0.0 { 4.0 } else { 9.0 } / 64.0;
            let variance = sum(one.doubts_among(&all, batches));
            let half_a_hit = 0.5 * if found > 0.0 { 4.0 } else { 9.0 } / 64.0;
            assert!((variance - wanted.min(half_a_hit)).abs() < 1e-3 * wanted, "{found}: {variance} {wanted}");
        }
        let some = Hits { found: 1.0, light: 5.0, ..one };
        assert_eq!(some.doubts_among(&some, batches), some.doubts(batches));
    }
}

//! A sampled matrix as its independent replicates, which rounds of sampling make better.
//!
//! All entries of a matrix come from the same rays, so their errors are correlated. Replicates keep
//! that: whatever is linear in the matrix has as many independent values as there are replicates.

use crate::error::Result;
use crate::kernels::trace::{TracedBatch, TracedMatrix};
use crate::matrix::Matrix;
use crate::simulate::inputs::import::Imported;
use crate::statistics::variance_of_mean;

/// The replicates of a matrix: batches of its kernel, each averaged over all rounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Independent estimates of the matrix; a single one if it is exact.
    pub replicates: Vec<Matrix<f32>>,
    /// The same of its direct part where they are needed, else their mean alone.
    pub direct: Vec<Matrix<f32>>,
    /// The same of what traced suns stand for, where that is more than the direct part.
    pub sunlit: Vec<Matrix<f32>>,
    /// Rounds so far.
    pub rounds: u32,
    /// Rays so far.
    pub rays: u64,
    /// How the values that are asked for spread within rounds; nothing unless sampling is adaptive.
    pub spread: Spread,
}

/// How values that are computed from a matrix differ among the batches of each round. Every round adds to
/// what is known of the error, while the number of replicates stays what it is: a decision to stop that
/// only looked at these would be taken, time and again, when they happen to agree.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spread {
    /// Of each value, the squares of the batches' deviations from the mean of their round, summed over batches
    /// and rounds.
    pub squares: Vec<f32>,
    /// Rounds that they come from.
    pub rounds: u32,
    /// Batches of a round.
    pub batches: usize,
}

impl Spread {
    /// Adds a round. Rounded to f32 each time, so that one read back from its file goes on to the same bits.
    pub fn add(&mut self, squares: &[f64], batches: usize) {
        self.squares.resize(squares.len(), 0.0);
        self.squares.iter_mut().zip(squares).for_each(|(sum, new)| *sum = (f64::from(*sum) + new) as f32);
        self.rounds += 1;
        self.batches = batches;
    }

    /// Degrees of freedom.
    pub fn degrees(&self) -> f64 {
        f64::from(self.rounds) * (self.batches.max(1) - 1) as f64
    }

    /// Variance of the mean of all batches of all rounds; `None` if there is none.
    pub fn variance(&self, value: usize) -> Option<f64> {
        let squares = f64::from(*self.squares.get(value)?);
        (self.rounds > 0).then(|| squares / (self.degrees() * self.batches as f64 * f64::from(self.rounds)))
    }
}

impl From<Imported> for Estimate {
    /// Taken for exact; without direct part where no phase asks for it.
    fn from(given: Imported) -> Self {
        let none = || Matrix::zeros(given.total.rows(), given.total.cols(), 3);
        let direct = given.direct.clone().unwrap_or_else(none);
        Estimate::exact(given.total, direct)
    }
}

impl Estimate {
    /// Nothing yet.
    pub fn none() -> Self {
        Self { replicates: Vec::new(), direct: Vec::new(), sunlit: Vec::new(), rounds: 0, rays: 0, spread: Spread::default() }
    }

    /// A matrix that was not sampled, and its direct part.
    pub fn exact(total: Matrix<f32>, direct: Matrix<f32>) -> Self {
        Self { replicates: vec![total], direct: vec![direct], ..Self::none() }
    }

    /// One round.
    pub(crate) fn of_round(traced: TracedMatrix, keep_direct: bool) -> Self {
        let mut sunlit = Vec::new();
        let keep = |b: TracedBatch| {
            sunlit.extend(b.sunlit);
            (b.total, b.direct)
        };
        let (replicates, direct): (Vec<_>, Vec<_>) = traced.batches.into_iter().map(keep).unzip();
        let direct = if keep_direct { direct } else { vec![mean_of(&direct)] };
        Self { replicates, direct, sunlit, rounds: 1, rays: traced.statistics.segments, spread: Spread::default() }
    }

    /// Adds a round. Means are rounded to f32 after each, so that one read back from its file goes on
    /// to the same bits.
    pub fn add(&mut self, round: Self) {
        if self.rounds == 0 {
            *self = round;
            return;
        }
        let n = f64::from(self.rounds);
        let pairs = self.replicates.iter_mut().zip(&round.replicates).chain(self.direct.iter_mut().zip(&round.direct));
        let pairs = pairs.chain(self.sunlit.iter_mut().zip(&round.sunlit));
        for (mean, new) in pairs {
            for (m, &v) in mean.data_mut().iter_mut().zip(new.data()) {
                *m = ((f64::from(*m) * n + f64::from(v)) / (n + 1.0)) as f32;
            }
        }
        self.rounds += 1;
        self.rays += round.rays;
    }

    /// The matrix.
    pub fn total(&self) -> Matrix<f32> {
        mean_of(&self.replicates)
    }

    /// What arrives direct, never more than the whole; as it was given if it was not sampled.
    pub fn direct(&self) -> Matrix<f32> {
        self.part(&self.direct)
    }

    /// Estimates of the part that traced suns stand for: the direct part, or more.
    pub fn replaced(&self) -> &[Matrix<f32>] {
        if self.sunlit.is_empty() { &self.direct } else { &self.sunlit }
    }

    /// Their mean, never more than the whole.
    pub fn mean_replaced(&self) -> Matrix<f32> {
        self.part(self.replaced())
    }

    fn part(&self, estimates: &[Matrix<f32>]) -> Matrix<f32> {
        let mut part = mean_of(estimates);
        if self.rounds > 0 {
            part.data_mut().iter_mut().zip(self.total().data()).for_each(|(p, t)| *p = p.min(*t));
        }
        part
    }

    /// Standard error of each entry.
    pub fn standard_error(&self) -> Matrix<f32> {
        let values = |i: usize| self.replicates.iter().map(move |m| f64::from(m.data()[i]));
        let first = &self.replicates[0];
        let data = (0..first.data().len()).map(|i| variance_of_mean(values(i)).sqrt() as f32).collect();
        Matrix::from_data(first.rows(), first.cols(), first.components(), data).expect("the shape of the replicates")
    }

    /// Everything in one matrix, for a file: replicates, the direct part, what suns stand for, one below the other.
    pub(crate) fn stacked(&self) -> Result<Matrix<f32>> {
        let first = &self.replicates[0];
        let all = self.replicates.iter().chain(&self.direct).chain(&self.sunlit);
        let data: Vec<f32> = all.flat_map(|m| m.data()).copied().collect();
        Matrix::from_data(
            first.rows() * (self.replicates.len() + self.direct.len() + self.sunlit.len()),
            first.cols(),
            first.components(),
            data,
        )
    }

    /// The inverse of [`stacked`](Self::stacked) for matrices of so many `rows`, `direct` of them
    /// the direct part and `sunlit` what suns stand for.
    pub(crate) fn unstacked(stacked: &Matrix<f32>, rows: usize, [direct, sunlit]: [usize; 2], rounds: u32, rays: u64) -> Result<Self> {
        let values = rows * stacked.cols() * stacked.components();
        let mut parts = stacked
            .data()
            .chunks_exact(values.max(1))
            .map(|part| Matrix::from_data(rows, stacked.cols(), stacked.components(), part.to_vec()))
            .collect::<Result<Vec<_>>>()?;
        let sunlit = parts.split_off(parts.len().saturating_sub(sunlit));
        let direct = parts.split_off(parts.len().saturating_sub(direct));
        Ok(Self { replicates: parts, direct, sunlit, rounds, rays, spread: Spread::default() })
    }
}

/// The mean of some matrices of one shape, summed in f64.
///
/// # Panics
/// Without any.
pub(crate) fn mean_of(matrices: &[Matrix<f32>]) -> Matrix<f32> {
    let first = &matrices[0];
    if matrices.len() == 1 {
        return first.clone();
    }
    let n = matrices.len() as f64;
    let mean = |i: usize| {
        let (sum, size) = matrices.iter().map(|m| f64::from(m.data()[i])).fold((0.0, 0.0), |(sum, size), v| (sum + v, size + v.abs()));
        // What few hits leave open deviates to either side: the rounding of its sum is no light.
        if sum.abs() < 1e-6 * size { 0.0 } else { (sum / n) as f32 }
    };
    let data = (0..first.data().len()).map(mean).collect();
    Matrix::from_data(first.rows(), first.cols(), first.components(), data).expect("the shape of the replicates")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::trace::TraceStatistics;

    #[test]
    fn deviations_that_cancel_leave_no_light() {
        let of = |values: [f32; 3]| mean_of(&values.map(|v| Matrix::from_data(1, 1, 1, vec![v]).unwrap())).at(0, 0)[0];
        assert_eq!(of([0.3, 0.1, -0.4]), 0.0);
        assert_eq!(of([0.0, 3e-7, 0.0]), 1e-7);
        assert!((of([0.3, 0.1, -0.39]) - 0.01 / 3.0).abs() < 1e-7);
    }

    fn traced(totals: [f32; 2], direct: [f32; 2]) -> TracedMatrix {
        let one = |v: f32| Matrix::from_data(1, 1, 1, vec![v]).unwrap();
        let batches = totals.iter().zip(direct).map(|(&t, d)| TracedBatch { total: one(t), direct: one(d), sunlit: None }).collect();
        let statistics = TraceStatistics { paths: 10, segments: 20 };
        TracedMatrix { total: one(0.0), direct: one(0.0), standard_error: one(0.0), batches, statistics }
    }

    #[test]
    fn replicates_average_over_rounds_and_their_spread_is_the_error() {
        let mut e = Estimate::none();
        e.add(Estimate::of_round(traced([1.0, 3.0], [0.5, 0.7]), true));
        assert_eq!((e.total().data(), e.standard_error().data()), (&[2.0][..], &[1.0][..]));
        e.add(Estimate::of_round(traced([5.0, 1.0], [0.5, 0.1]), true));
        // Replicates 3 and 2.
        assert_eq!((e.total().data(), e.standard_error().data()), (&[2.5][..], &[0.5][..]));
        assert_eq!((e.direct().data(), e.rounds, e.rays), (&[0.45][..], 2, 40));
        let back = Estimate::unstacked(&e.stacked().unwrap(), 1, [2, 0], 2, 40).unwrap();
        assert_eq!(back, e);
        let mut mean_only = Estimate::none();
        mean_only.add(Estimate::of_round(traced([1.0, 3.0], [0.5, 0.7]), false));
        assert_eq!((mean_only.direct.len(), mean_only.direct().data()), (1, &[0.6][..]));
    }

    #[test]
    fn what_is_exact_has_no_error() {
        let m = Matrix::from_data(1, 2, 1, vec![1.0, 2.0]).unwrap();
        assert_eq!(Estimate::exact(m.clone(), m).standard_error().data(), [0.0, 0.0]);
    }

    #[test]
    fn the_spread_within_rounds_gives_the_error_of_their_mean() {
        // Two rounds of two batches: 1, 3 and 4, 8. Squares 2 and 8, two degrees of freedom, four batches.
        let mut spread = Spread::default();
        assert_eq!(spread.variance(0), None);
        spread.add(&[2.0], 2);
        assert_eq!(spread.variance(0), Some(1.0));
        spread.add(&[8.0], 2);
        assert_eq!((spread.variance(0), spread.degrees()), (Some(10.0 / 2.0 / 4.0), 2.0));
    }
}

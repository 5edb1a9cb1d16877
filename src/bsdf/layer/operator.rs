//! Matrices that map radiance per bin: full, or diagonal as those of panes are.

use crate::error::{Error, Result};

/// A square matrix of f Λ.
#[derive(Debug, Clone)]
pub(super) enum Operator {
    /// Light stays in its bin.
    Diagonal(Vec<f64>),
    /// Row by row, `[outgoing][incident]`.
    Full { n: usize, data: Vec<f64> },
}

use Operator::{Diagonal, Full};

impl Operator {
    pub(super) fn uniform(n: usize, value: f64) -> Self {
        Diagonal(vec![value; n])
    }

    fn n(&self) -> usize {
        match self {
            Diagonal(d) => d.len(),
            Full { n, .. } => *n,
        }
    }

    fn full(&self) -> Vec<f64> {
        match self {
            Diagonal(d) => {
                let n = d.len();
                (0..n * n).map(|k| if k / n == k % n { d[k / n] } else { 0.0 }).collect()
            }
            Full { data, .. } => data.clone(),
        }
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let n = self.n();
        match (self, other) {
            (Diagonal(a), Diagonal(b)) => Diagonal(a.iter().zip(b).map(|(a, b)| a * b).collect()),
            (Diagonal(a), Full { data, .. }) => {
                Full { n, data: data.chunks_exact(n).zip(a).flat_map(|(row, a)| row.iter().map(move |b| a * b)).collect() }
            }
            (Full { data, .. }, Diagonal(b)) => {
                Full { n, data: data.chunks_exact(n).flat_map(|row| row.iter().zip(b).map(|(a, b)| a * b)).collect() }
            }
            (Full { data: a, .. }, Full { data: b, .. }) => {
                let mut data = vec![0.0; n * n];
                for (row, out) in a.chunks_exact(n).zip(data.chunks_exact_mut(n)) {
                    for (a, from) in row.iter().zip(b.chunks_exact(n)).filter(|(a, _)| **a != 0.0) {
                        out.iter_mut().zip(from).for_each(|(o, b)| *o += a * b);
                    }
                }
                Full { n, data }
            }
        }
    }

    pub(super) fn plus(mut self, other: &Self) -> Self {
        match (&mut self, other) {
            (Diagonal(a), Diagonal(b)) => a.iter_mut().zip(b).for_each(|(a, b)| *a += b),
            (Full { data, .. }, other) => other.add_to(1.0, data),
            (Diagonal(_), Full { n, data }) => {
                let mut sum = data.clone();
                self.add_to(1.0, &mut sum);
                return Full { n: *n, data: sum };
            }
        }
        self
    }

    /// Adds this matrix times `factor` to a full one.
    pub(super) fn add_to(&self, factor: f64, sum: &mut [f64]) {
        match self {
            Diagonal(d) => d.iter().enumerate().for_each(|(k, v)| sum[k * (d.len() + 1)] += factor * v),
            Full { data, .. } => sum.iter_mut().zip(data).for_each(|(s, v)| *s += factor * v),
        }
    }

    /// Σ over rows of weight times row.
    pub(super) fn weighted_rows(&self, weights: &[f64]) -> Vec<f64> {
        match self {
            Diagonal(d) => d.iter().zip(weights).map(|(v, w)| v * w).collect(),
            Full { n, data } => {
                let mut sum = vec![0.0; *n];
                for (row, w) in data.chunks_exact(*n).zip(weights) {
                    sum.iter_mut().zip(row).for_each(|(s, v)| *s += w * v);
                }
                sum
            }
        }
    }

    /// (I − self)⁻¹ · right, by elimination with row pivots.
    pub(super) fn resolve(&self, right: &Self) -> Result<Self> {
        let trapped =
            || Error::new("light between two layers never gets out: their reflectances leave nothing to be absorbed or transmitted");
        let Full { n, data } = self else {
            let Diagonal(d) = self else { unreachable!("either full or diagonal") };
            if d.iter().any(|v| (1.0 - v).abs() < 1e-12) {
                return Err(trapped());
            }
            return Ok(Diagonal(d.iter().map(|v| 1.0 / (1.0 - v)).collect()).times(right));
        };
        let n = *n;
        let mut a: Vec<f64> = data.iter().enumerate().map(|(k, v)| f64::from(k / n == k % n) - v).collect();
        let mut b = right.full();
        for column in 0..n {
            let pivot = (column..n).max_by(|x, y| a[x * n + column].abs().total_cmp(&a[y * n + column].abs())).expect("rows remain");
            if a[pivot * n + column].abs() < 1e-12 {
                return Err(trapped());
            }
            if pivot != column {
                for k in 0..n {
                    a.swap(pivot * n + k, column * n + k);
                    b.swap(pivot * n + k, column * n + k);
                }
            }
            let inverse = 1.0 / a[column * n + column];
            a[column * n + column..(column + 1) * n].iter_mut().for_each(|v| *v *= inverse);
            b[column * n..(column + 1) * n].iter_mut().for_each(|v| *v *= inverse);
            let (pivot_a, pivot_b) = (a[column * n + column..(column + 1) * n].to_vec(), b[column * n..(column + 1) * n].to_vec());
            for row in (0..n).filter(|r| *r != column) {
                let factor = a[row * n + column];
                if factor != 0.0 {
                    a[row * n + column..(row + 1) * n].iter_mut().zip(&pivot_a).for_each(|(v, p)| *v -= factor * p);
                    b[row * n..(row + 1) * n].iter_mut().zip(&pivot_b).for_each(|(v, p)| *v -= factor * p);
                }
            }
        }
        Ok(Full { n, data: b })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagonal_matrices_are_what_full_ones_with_the_same_values_are() {
        let n = 5;
        let full = Full { n, data: (0..n * n).map(|k| (k as f64 * 0.618_034).fract() * 0.15).collect() };
        let diagonal = Diagonal((0..n).map(|k| 0.1 * k as f64).collect());
        let spread = |o: &Operator| Full { n, data: o.full() };
        let same = |a: &Operator, b: &Operator| {
            let (a, b) = (a.full(), b.full());
            assert!(a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-14), "{a:?} {b:?}");
        };
        for (a, b) in [(&full, &diagonal), (&diagonal, &full), (&diagonal, &diagonal), (&full, &full)] {
            same(&a.times(b), &spread(a).times(&spread(b)));
            same(&a.clone().plus(b), &spread(a).plus(&spread(b)));
            same(&a.resolve(b).unwrap(), &spread(a).resolve(&spread(b)).unwrap());
            // (I − a) x = b
            let x = a.resolve(b).unwrap();
            same(&b.clone().plus(&a.times(&x)), &x);
        }
        let weights = [0.3, 0.1, 0.5, 0.9, 0.2];
        let (x, y) = (diagonal.weighted_rows(&weights), spread(&diagonal).weighted_rows(&weights));
        assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-15));
        assert!(Operator::uniform(n, 1.0).resolve(&full).is_err());
    }
}

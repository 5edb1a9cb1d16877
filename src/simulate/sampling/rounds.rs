//! Tracing a matrix several times and averaging.

use crate::error::Result;
use crate::kernels::trace::{TraceStatistics, TracedMatrix};
use crate::matrix::Matrix;
use crate::progress::Progress;

/// The mean of `count` independent matrices and its standard error, `√(Σσ²) / count`.
///
/// # Errors
/// The first error of `trace`.
pub(crate) fn average(
    count: u32,
    progress: &dyn Progress,
    mut trace: impl FnMut(u32, &dyn Progress) -> Result<TracedMatrix>,
) -> Result<TracedMatrix> {
    let part = |round: u32| Part::of(progress, round as usize, count as usize);
    let first = trace(0, &part(0))?;
    if count <= 1 {
        return Ok(first);
    }
    // In f64 and always in the same order, so that total ≥ direct survives the rounding.
    let wide = |m: &Matrix<f32>| m.map(f64::from).into_data();
    let (mut total, mut direct) = (wide(&first.total), wide(&first.direct));
    let mut variance: Vec<f64> = wide(&first.standard_error).into_iter().map(|e| e * e).collect();
    let mut statistics = first.statistics;
    for round in 1..count {
        let traced = trace(round, &part(round))?;
        add(&mut total, traced.total.data(), |v| v);
        add(&mut direct, traced.direct.data(), |v| v);
        add(&mut variance, traced.standard_error.data(), |e| e * e);
        statistics = TraceStatistics {
            paths: statistics.paths + traced.statistics.paths,
            segments: statistics.segments + traced.statistics.segments,
        };
    }
    let n = f64::from(count);
    let shaped = |values: Vec<f64>, f: fn(f64, f64) -> f64| {
        let data = values.into_iter().map(|v| f(v, n) as f32).collect();
        Matrix::from_data(first.total.rows(), first.total.cols(), first.total.components(), data)
    };
    Ok(TracedMatrix {
        total: shaped(total, |sum, n| sum / n)?,
        direct: shaped(direct, |sum, n| sum / n)?,
        standard_error: shaped(variance, |sum, n| sum.sqrt() / n)?,
        batches: Vec::new(),
        statistics,
    })
}

fn add(sum: &mut [f64], values: &[f32], f: impl Fn(f64) -> f64) {
    for (s, &v) in sum.iter_mut().zip(values) {
        *s += f(f64::from(v));
    }
}

/// A part of a stage.
pub(crate) struct Part<'a> {
    whole: &'a dyn Progress,
    first: f64,
    width: f64,
}

impl<'a> Part<'a> {
    /// The part `number` (from 0) of `count` equal ones.
    pub(crate) fn of(whole: &'a dyn Progress, number: usize, count: usize) -> Self {
        Self { whole, first: number as f64 / count as f64, width: 1.0 / count as f64 }
    }
}

impl Progress for Part<'_> {
    fn update(&self, stage: &str, fraction: f64) {
        self.whole.update(stage, self.first + self.width * fraction);
    }

    fn stop_requested(&self) -> bool {
        self.whole.stop_requested()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    fn traced(total: f32, direct: f32, error: f32) -> TracedMatrix {
        let one = |v| Matrix::from_data(1, 1, 1, vec![v]).unwrap();
        let statistics = TraceStatistics { paths: 10, segments: 20 };
        TracedMatrix { total: one(total), direct: one(direct), standard_error: one(error), batches: Vec::new(), statistics }
    }

    #[test]
    fn values_average_and_errors_fall_with_the_root() {
        let values = [traced(1.0, 0.5, 0.3), traced(2.0, 0.5, 0.4), traced(3.0, 0.8, 0.0), traced(6.0, 1.0, 0.0)];
        let mean = average(4, &Silent, |round, _| Ok(values[round as usize].clone())).unwrap();
        assert_eq!(mean.total.data(), [3.0]);
        assert_eq!(mean.direct.data(), [0.7]);
        assert_eq!(mean.standard_error.data(), [0.125]);
        assert_eq!((mean.statistics.paths, mean.statistics.segments), (40, 80));
    }

    #[test]
    fn one_round_is_left_as_it_is() {
        assert_eq!(average(1, &Silent, |_, _| Ok(traced(0.1, 0.1, 0.1))).unwrap(), traced(0.1, 0.1, 0.1));
    }

    #[test]
    fn parts_of_a_stage_follow_each_other() {
        struct Last(std::sync::Mutex<Vec<f64>>);
        impl Progress for Last {
            fn update(&self, _: &str, fraction: f64) {
                self.0.lock().unwrap().push(fraction);
            }
        }
        let last = Last(std::sync::Mutex::new(Vec::new()));
        average(4, &last, |_, progress| {
            progress.update("x", 0.5);
            Ok(traced(1.0, 1.0, 1.0))
        })
        .unwrap();
        assert_eq!(*last.0.lock().unwrap(), [0.125, 0.375, 0.625, 0.875]);
    }
}

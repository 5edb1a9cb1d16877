//! What the noise of V, D and Cds does to illuminance.
//!
//! The product is linear in each matrix, so to first order its error is the sum of what each matrix'
//! error does, `δE = δV·T·D·S + V·T·δD·S (− the same of the straight parts, five phases)`. Every
//! matrix comes as independent replicates ([`Estimate`]). Replicate by replicate, all entries changing
//! together as their common rays have it, they give as many independent values of each illuminance:
//! their mean is the result, their spread its standard error, and with R of them
//! `(mean − truth) / error` follows Student's distribution with R − 1 degrees of freedom.

use super::estimate::{Estimate, student_95, upper_variance, variance_of_mean};
use super::inputs::{Inputs, ProjectWindow};
use super::results::{illuminance, multiply, transmitted_daylight};
use super::sampling::Judgement;
use crate::error::Result;
use crate::kernels::product::{Multiplier, chain};
use crate::matrix::Matrix;
use crate::units::ILLUMINANCE_WEIGHTS;
use rayon::prelude::*;
use serde::Serialize;

/// Standard errors relative to the values, as fractions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EstimatedError {
    /// Of a sensor's sum over all hours: median over the sensors. Where the mean is below 0.1 lx, in relation
    /// to that.
    pub annual_median: f64,
    /// The largest of them.
    pub annual_largest: f64,
    /// Of a single daylight hour at one sensor: median.
    pub hourly_median: f64,
    /// Exceeded by one in twenty.
    pub hourly_95th_percentile: f64,
    /// Sensors.
    pub sensors: usize,
    /// Daylight hours.
    pub hours: usize,
    /// Multiply a standard error by this for the interval that holds the converged value in 95 % of
    /// cases.
    pub confidence_95: f64,
    /// What `annual_largest` should be at most: asked for, or meant by the preset.
    pub target: Option<f64>,
    /// Whether it is.
    pub target_met: Option<bool>,
}

/// A mean illuminance below this, lx, is dark: its error counts in relation to this. A room's dark corner, or
/// what is behind a closed door, must not ask for a thousand times as many samples.
pub const DARK: f64 = 0.1;

/// The standard error of a mean illuminance in relation to it; nothing where there is no light.
pub fn relative_error(mean: f64, standard_error: f64) -> Option<f64> {
    (mean > 0.0).then(|| standard_error / mean.max(DARK))
}

/// The matrices that illuminance is the product of.
pub struct Chain<'m> {
    /// Windows with their T.
    pub inputs: &'m Inputs,
    /// V of all sensors.
    pub view: &'m Estimate,
    /// D of each window.
    pub daylight: &'m [Estimate],
    /// S.
    pub sky: &'m Matrix<f32>,
    /// Sds, the sun's share of S: five phases take it out of what comes straight through windows whose
    /// sun is traced.
    pub sun: Option<&'m Matrix<f32>>,
}

/// The sum over all hours at one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct AnnualSum {
    /// lx·h, without the sun matrix.
    pub value: f64,
    /// Its variance.
    pub variance: f64,
    /// The part of V in it, then that of each window's D.
    pub by_source: Vec<f64>,
    /// What it and its parts would be by the replicates' spread alone; the same unless sampling was adaptive.
    pub by_replicates: f64,
    /// See `by_replicates`.
    pub by_replicates_of_source: Vec<f64>,
    /// Degrees of freedom of the variance.
    pub degrees: f64,
}

impl AnnualSum {
    /// By what the replicates' deviations are to be multiplied to spread as the variance says.
    pub fn spread_of_replicates(&self) -> f64 {
        if self.by_replicates > 0.0 { (self.variance / self.by_replicates).sqrt() } else { 1.0 }
    }
}

type Light = Vec<[f64; 3]>;

/// What illuminates one window's inner side over the year, per replicate of its D.
struct YearAtWindow {
    whole: Vec<Light>,
    /// What comes straight from the sun, where it is taken out; else empty.
    straight: Vec<Light>,
}

impl Chain<'_> {
    /// Replicates of whatever is sampled; 1 if nothing is.
    fn replicates(&self) -> usize {
        self.daylight.iter().map(|d| d.replicates.len()).max().unwrap_or(1).max(self.view.replicates.len())
    }

    /// The factor for 95 % confidence, for these sums or any of them.
    pub fn confidence_95(&self, sums: &[AnnualSum]) -> f64 {
        let degrees = sums.iter().map(|s| s.degrees).fold(f64::INFINITY, f64::min);
        student_95(if degrees.is_finite() { degrees as usize } else { self.replicates() - 1 })
    }

    fn sources(&self) -> impl Iterator<Item = &Estimate> {
        std::iter::once(self.view).chain(self.daylight)
    }

    fn is_sunny(&self, window: &ProjectWindow) -> bool {
        self.sun.is_some() && (window.shade.is_some() || window.pane.is_some())
    }

    /// The sums over all hours and their errors, exactly and for all sensors: a few products of
    /// matrices with one column.
    pub fn annual(&self) -> Vec<AnnualSum> {
        let year = sums_of_hours(self.sky);
        let sun = self.sun.map(sums_of_hours);
        let at_windows: Vec<YearAtWindow> = self
            .inputs
            .windows
            .par_iter()
            .zip(self.daylight)
            .map(|(window, d)| {
                let through =
                    |all: &[Matrix<f32>], column: &Light| all.iter().map(|d| transmitted(&window.transmission, d, column)).collect();
                let straight = match &sun {
                    Some(sun) if self.is_sunny(window) => through(&d.straight, sun),
                    _ => Vec::new(),
                };
                YearAtWindow { whole: through(&d.replicates, &year), straight }
            })
            .collect();
        let rows = self.view.replicates.first().map_or(0, Matrix::rows);
        (0..rows).into_par_iter().map(|sensor| self.annual_sum(sensor, &at_windows)).collect()
    }

    fn annual_sum(&self, sensor: usize, windows: &[YearAtWindow]) -> AnnualSum {
        let mean_row = |all: &[Matrix<f32>]| -> Light {
            let n = all.len() as f64;
            let bin = |b: usize| std::array::from_fn(|c| all.iter().map(|m| f64::from(m.at(sensor, b)[c])).sum::<f64>() / n);
            (0..all[0].cols()).map(bin).collect()
        };
        let row = |m: &Matrix<f32>| -> Light { m.row(sensor).as_chunks::<3>().0.iter().map(|v| v.map(f64::from)).collect() };
        let view = mean_row(&self.view.replicates);
        let view_straight = if self.sun.is_some() { mean_row(&self.view.straight) } else { Vec::new() };
        // Values of the illuminance by replicates of V, then by those of each D.
        let mut by_view = vec![0.0; self.view.replicates.len()];
        let mut by_daylight = Vec::new();
        let mut first = 0;
        for (window, section) in windows.iter().zip(&self.inputs.windows) {
            let bins = first..first + section.window.basis.len();
            first = bins.end;
            let mut values: Vec<f64> = window.whole.iter().map(|light| lux(&view[bins.clone()], light)).collect();
            for (value, light) in values.iter_mut().zip(&window.straight) {
                *value -= lux(&view_straight[bins.clone()], light);
            }
            let (light, straight) = (mean_light(&window.whole), mean_light(&window.straight));
            for (r, value) in by_view.iter_mut().enumerate() {
                *value += lux(&row(&self.view.replicates[r])[bins.clone()], &light);
                if !straight.is_empty() {
                    *value -= lux(&row(&self.view.straight[r])[bins.clone()], &straight);
                }
            }
            by_daylight.push(values);
        }
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
        let value = mean(&by_view);
        // One replicate of everything at a time.
        let together: Vec<f64> = (0..self.replicates())
            .map(|r| std::iter::once(&by_view).chain(&by_daylight).map(|all| all.get(r).map_or(0.0, |v| v - mean(all))).sum())
            .collect();
        let spread = |v: &[f64]| variance_of_mean(v.iter().copied());
        let by_replicates_of_source: Vec<f64> = std::iter::once(&by_view).chain(&by_daylight).map(|v| spread(v)).collect();
        let by_replicates = spread(&together);
        let few = (self.replicates().max(2) - 1) as f64;
        let pooled = self.sources().any(|e| e.spread.rounds > 0);
        let (mut by_source, mut variance, mut degrees) = (by_replicates_of_source.clone(), by_replicates, few);
        if pooled {
            let mut shares = 0.0;
            for (own, source) in by_source.iter_mut().zip(self.sources()) {
                *own = source.spread.variance(sensor).unwrap_or(*own);
                let freedom = if source.spread.rounds > 0 { source.spread.degrees() } else { few };
                shares += own.powi(2) / freedom;
            }
            variance = by_source.iter().sum();
            // Satterthwaite 1946.
            degrees = if shares > 0.0 { variance.powi(2) / shares } else { few };
        }
        AnnualSum { value, variance, by_source, by_replicates, by_replicates_of_source, degrees }
    }

    /// Of each sensor's sum, the squares of the deviations that the replicates of a source (0: V, then each D)
    /// make.
    pub fn squares(&self, source: usize) -> Vec<f64> {
        let replicates = self.sources().nth(source).map_or(1, |e| e.replicates.len());
        let scale = (replicates * (replicates - 1)) as f64;
        self.annual().iter().map(|a| a.by_replicates_of_source[source] * scale).collect()
    }

    /// How good the year's sums are at the worst sensor.
    pub fn judge(&self) -> Judgement {
        let none = Judgement { error: 0.0, at_most: 0.0, variances: vec![0.0; self.daylight.len() + 1] };
        let hours = self.sky.cols() as f64;
        let relative = |a: &AnnualSum| relative_error(a.value / hours, a.variance.sqrt() / hours).unwrap_or(0.0);
        let at_most = |a: &AnnualSum| relative(a) * upper_variance(a.degrees).sqrt();
        let worst = self.annual().into_iter().max_by(|a, b| at_most(a).total_cmp(&at_most(b)));
        worst.map_or(none, |a| Judgement { error: relative(&a), at_most: at_most(&a), variances: a.by_source })
    }

    /// Deviations of some sensors' illuminances, `[replicate][sensor][hour]` in one matrix with the
    /// replicates' rows one below the other, lx: what each replicate differs from their mean by.
    /// Nothing if all matrices are exact.
    ///
    /// # Errors
    /// Failures of the multiplier's device.
    pub fn deviations(&self, multiplier: &dyn Multiplier, sensors: std::ops::Range<usize>, parts: &Parts) -> Result<Option<Matrix<f32>>> {
        let replicates = self.replicates();
        if replicates < 2 || sensors.is_empty() {
            return Ok(None);
        }
        let whole =
            self.coefficient_deviations(multiplier, sensors.clone(), &parts.whole, &self.view.replicates, &|d| &d.replicates, &|_| true)?;
        let mut lux = illuminance(multiplier, whole, self.sky)?;
        if let (Some(sun), Some(straight)) = (self.sun, &parts.straight) {
            let taken =
                self.coefficient_deviations(multiplier, sensors, straight, &self.view.straight, &|d| &d.straight, &|w| self.is_sunny(w))?;
            let taken = illuminance(multiplier, taken, sun)?;
            lux.data_mut().par_iter_mut().zip(taken.data()).for_each(|(v, t)| *v -= t);
        }
        Ok(Some(lux))
    }

    /// Deviations of the daylight coefficients, `[replicate · sensor][patch]`, from the replicates of
    /// V and of the windows' D that count.
    fn coefficient_deviations(
        &self,
        multiplier: &dyn Multiplier,
        sensors: std::ops::Range<usize>,
        mean: &MeanPart,
        view: &[Matrix<f32>],
        daylight: &dyn Fn(&Estimate) -> &[Matrix<f32>],
        counts: &dyn Fn(&ProjectWindow) -> bool,
    ) -> Result<Matrix<f64>> {
        let (replicates, bins, n) = (self.replicates(), self.inputs.bins(), sensors.len());
        let rows = |m: &Matrix<f32>| m.data()[sensors.start * bins * 3..sensors.end * bins * 3].to_vec();
        let mean_rows = rows(&mean.view);
        let mut changes: Vec<f32> = Vec::with_capacity(replicates * mean_rows.len());
        for r in 0..replicates {
            match view.get(r).filter(|_| view.len() > 1) {
                Some(m) => changes.extend(rows(m).iter().zip(&mean_rows).map(|(v, mean)| v - mean)),
                None => changes.resize(changes.len() + mean_rows.len(), 0.0),
            }
        }
        let changes = Matrix::from_data(replicates * n, bins, 3, changes)?;
        let mut coefficients = chain(multiplier, &[&changes, &mean.transmitted])?;
        let values = n * coefficients.cols() * 3;
        let mut first = 0;
        for ((window, d), mean_d) in self.inputs.windows.iter().zip(self.daylight).zip(&mean.daylight) {
            let own = window.window.basis.len();
            let part = first..first + own;
            first = part.end;
            let all = daylight(d);
            if all.len() < 2 || !counts(window) {
                continue;
            }
            let seen: Vec<f32> = mean_rows.chunks_exact(bins * 3).flat_map(|row| &row[part.start * 3..part.end * 3]).copied().collect();
            let seen = multiply(&Matrix::from_data(n, own, 3, seen)?, &window.transmission).map(|v| v as f32);
            for (r, m) in all.iter().enumerate() {
                let change: Vec<f32> = m.data().iter().zip(mean_d.data()).map(|(v, mean)| v - mean).collect();
                let change = chain(multiplier, &[&seen, &Matrix::from_data(m.rows(), m.cols(), 3, change)?])?;
                for (sum, v) in coefficients.data_mut()[r * values..(r + 1) * values].iter_mut().zip(change.data()) {
                    *sum += v;
                }
            }
        }
        Ok(coefficients.map(f64::from))
    }

    /// Means that all sensors share.
    pub fn parts(&self) -> Parts {
        let part = |view: Matrix<f32>, daylight: Vec<Matrix<f32>>, counts: &dyn Fn(&ProjectWindow) -> bool| {
            let counted: Vec<Matrix<f32>> = self
                .inputs
                .windows
                .iter()
                .zip(&daylight)
                .map(|(w, d)| if counts(w) { d.clone() } else { Matrix::zeros(d.rows(), d.cols(), d.components()) })
                .collect();
            MeanPart { view, transmitted: transmitted_daylight(self.inputs, &counted).map(|v| v as f32), daylight }
        };
        let whole = part(self.view.total(), self.daylight.iter().map(Estimate::total).collect(), &|_| true);
        let straight =
            self.sun.map(|_| part(self.view.direct(), self.daylight.iter().map(Estimate::direct).collect(), &|w| self.is_sunny(w)));
        Parts { whole, straight }
    }
}

/// Means of the replicates, and T times that of D.
pub struct Parts {
    whole: MeanPart,
    straight: Option<MeanPart>,
}

struct MeanPart {
    view: Matrix<f32>,
    transmitted: Matrix<f32>,
    daylight: Vec<Matrix<f32>>,
}

fn sums_of_hours(sky: &Matrix<f32>) -> Light {
    let patch = |p: usize| {
        let mut sum = [0.0; 3];
        for hour in sky.row(p).as_chunks::<3>().0 {
            for c in 0..3 {
                sum[c] += f64::from(hour[c]);
            }
        }
        sum
    };
    (0..sky.rows()).into_par_iter().map(patch).collect()
}

/// T·D times one column of S.
fn transmitted(transmission: &Matrix<f64>, daylight: &Matrix<f32>, column: &Light) -> Light {
    let incident: Light = (0..daylight.rows()).map(|bin| times(daylight.row(bin), column)).collect();
    (0..transmission.rows()).map(|bin| times(transmission.row(bin), &incident)).collect()
}

fn times<T: Copy + Into<f64>>(row: &[T], column: &Light) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (values, light) in row.chunks_exact(3).zip(column) {
        for c in 0..3 {
            sum[c] += values[c].into() * light[c];
        }
    }
    sum
}

fn mean_light(all: &[Light]) -> Light {
    let n = all.len() as f64;
    let bins = all.first().map_or(0, Vec::len);
    (0..bins).map(|b| std::array::from_fn(|c| all.iter().map(|l| l[b][c]).sum::<f64>() / n)).collect()
}

fn lux(view: &[[f64; 3]], light: &[[f64; 3]]) -> f64 {
    view.iter().zip(light).map(|(v, l)| (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * v[c] * l[c]).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests;

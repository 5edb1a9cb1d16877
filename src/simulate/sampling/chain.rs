//! The chain V·T·D·S with its noise: the sum over the year at each sensor, and what each matrix' noise
//! adds to its error.

use super::Judgement;
use super::estimate::Estimate;
use crate::matrix::Matrix;
use crate::simulate::inputs::states::WindowUse;
use crate::simulate::inputs::{Inputs, ProjectWindow};
use crate::statistics::{student_95, upper_variance, variance_of_mean};
use crate::units::ILLUMINANCE_WEIGHTS;
use rayon::prelude::*;

/// The matrices that illuminance is the product of.
pub struct Chain<'m> {
    /// What the project's files hold.
    pub inputs: &'m Inputs,
    /// V of all sensors; C if they see the sky itself.
    pub view: &'m Estimate,
    /// D of each window; nothing of C.
    pub daylight: &'m [Estimate],
    /// Whether `view` is C, whose bins are the patches of the sky.
    pub sees_sky: bool,
    /// S.
    pub sky: &'m Matrix<f32>,
    /// Sds, the sun's share of S: five phases take it out of what comes directly through windows whose
    /// sun is traced.
    pub sun: Option<&'m Matrix<f32>>,
}

/// The sum over all hours at one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct AnnualSum {
    /// lx, summed over all time steps, without the sun matrix.
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
    pub(crate) fn spread_of_replicates(&self) -> f64 {
        if self.by_replicates > 0.0 { (self.variance / self.by_replicates).sqrt() } else { 1.0 }
    }
}

/// A mean illuminance below this, lx, is dark: its error counts in relation to this. A room's dark corner, or
/// what is behind a closed door, must not ask for a thousand times as many samples.
pub(crate) const DARK: f64 = 0.1;

/// The standard error of a mean illuminance in relation to it; nothing where there is no light.
pub(crate) fn relative_error(mean: f64, standard_error: f64) -> Option<f64> {
    (mean > 0.0).then(|| standard_error / mean.max(DARK))
}

type Light = Vec<[f64; 3]>;

impl<'m> Chain<'m> {
    /// Replicates of whatever is sampled; 1 if nothing is.
    pub fn replicates(&self) -> usize {
        self.daylight.iter().map(|d| d.replicates.len()).max().unwrap_or(1).max(self.view.replicates.len())
    }

    /// The factor for 95 % confidence, for these sums or any of them.
    pub(crate) fn confidence_95(&self, sums: &[AnnualSum]) -> f64 {
        let degrees = sums.iter().map(|s| s.degrees).fold(f64::INFINITY, f64::min);
        student_95(if degrees.is_finite() { degrees as usize } else { self.replicates() - 1 })
    }

    /// Windows whose bins the columns of `view` are; none of C, whose columns are patches of the sky.
    pub fn windows(&self) -> &'m [ProjectWindow] {
        if self.sees_sky { &[] } else { &self.inputs.windows }
    }

    fn sources(&self) -> impl Iterator<Item = &Estimate> {
        std::iter::once(self.view).chain(self.daylight)
    }

    /// The sums over all hours and their errors, exactly and for all sensors: the formula
    /// ([`light`](crate::simulate::light)) for a sky that is the sum of all hours', per replicate.
    pub fn annual(&self) -> Vec<AnnualSum> {
        let year = sums_of_hours(self.sky, None);
        let sun = self.sun.map(|sun| sums_of_hours(sun, None));
        // Per window and replicate of its D.
        let mut at_windows: Vec<Vec<Light>> = self
            .windows()
            .par_iter()
            .enumerate()
            .zip(self.daylight)
            .map(|((number, _), d)| {
                // Each state with the light of its own hours.
                let uses = self.inputs.uses(number);
                let sums = |sky: &Matrix<f32>, used: &WindowUse<'_>| sums_of_hours(sky, used.steps.as_deref());
                let skies: Vec<(Light, Option<Light>)> =
                    uses.iter().map(|u| (sums(self.sky, u), self.sun.map(|sun| sums(sun, u)))).collect();
                let of_use = |r: usize, used: &WindowUse<'_>, (year, sun): &(Light, Option<Light>)| {
                    let t = used.transmission;
                    let mut light = transmitted(t, &d.replicates[r], year);
                    if let Some(sun) = sun {
                        let direct = d.direct.get(r).or(d.direct.last()).filter(|_| used.is_sunny);
                        let taken = direct.map_or_else(|| vec![[0.0; 3]; light.len()], |d| transmitted(t, d, sun));
                        let rest: Light = light.iter().zip(&taken).map(|(all, sun)| less(*all, *sun)).collect();
                        light.extend(rest);
                    }
                    light
                };
                let of = |r: usize| {
                    let all = uses.iter().zip(&skies).map(|(used, sky)| of_use(r, used, sky));
                    all.reduce(|a, b| a.iter().zip(&b).map(|(a, b)| std::array::from_fn(|c| a[c] + b[c])).collect()).unwrap_or_default()
                };
                (0..d.replicates.len()).map(of).collect()
            })
            .collect();
        let mut bins: Vec<usize> = self.windows().iter().map(ProjectWindow::bins).collect();
        if self.sees_sky {
            let rest = sun.iter().flat_map(|sun| year.iter().zip(sun).map(|(all, sun)| less(*all, *sun)));
            bins.push(year.len());
            at_windows.push(vec![year.iter().copied().chain(rest).collect()]);
        }
        let rows = self.view.replicates.first().map_or(0, Matrix::rows);
        (0..rows).into_par_iter().map(|sensor| self.annual_sum(sensor, &at_windows, &bins)).collect()
    }

    /// The columns of one window in a sensor's row of the formula's left factor, by one replicate of V.
    fn row(&self, replicate: usize, sensor: usize, bins: std::ops::Range<usize>) -> Light {
        let of = |m: &Matrix<f32>| -> Light { bins.clone().map(|b| std::array::from_fn(|c| f64::from(m.at(sensor, b)[c]))).collect() };
        let whole = of(&self.view.replicates[replicate]);
        if self.sun.is_none() {
            return whole;
        }
        let replaced = self.view.replaced();
        let direct = of(&replaced[replicate.min(replaced.len() - 1)]);
        whole.iter().zip(&direct).map(|(all, direct)| less(*all, *direct)).chain(direct.iter().copied()).collect()
    }

    fn annual_sum(&self, sensor: usize, windows: &[Vec<Light>], bins: &[usize]) -> AnnualSum {
        let replicates = self.view.replicates.len();
        // Values of the illuminance by replicates of V, then by those of each D.
        let mut by_view = vec![0.0; replicates];
        let mut by_daylight = Vec::new();
        let mut first = 0;
        for (lights, count) in windows.iter().zip(bins) {
            let bins = first..first + count;
            first = bins.end;
            let rows: Vec<Light> = (0..replicates).map(|r| self.row(r, sensor, bins.clone())).collect();
            let (row, light) = (mean_light(&rows), mean_light(lights));
            by_view.iter_mut().zip(&rows).for_each(|(value, row)| *value += lux(row, &light));
            // The sky is not sampled.
            if self.sees_sky {
                continue;
            }
            by_daylight.push(lights.iter().map(|light| lux(&row, light)).collect::<Vec<f64>>());
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
}

/// Sums over all hours, or over those that count.
fn sums_of_hours(sky: &Matrix<f32>, counts: Option<&[bool]>) -> Light {
    let patch = |p: usize| {
        let mut sum = [0.0; 3];
        for (step, hour) in sky.row(p).as_chunks::<3>().0.iter().enumerate() {
            if counts.is_some_and(|counts| !counts[step]) {
                continue;
            }
            for c in 0..3 {
                sum[c] += f64::from(hour[c]);
            }
        }
        sum
    };
    (0..sky.rows()).into_par_iter().map(patch).collect()
}

/// T·D times one column of S, of each part of a window.
fn transmitted(transmission: &Matrix<f64>, daylight: &Matrix<f32>, column: &Light) -> Light {
    let incident: Light = (0..daylight.rows()).map(|bin| times(daylight.row(bin), column)).collect();
    let behind = |part: &[[f64; 3]]| -> Light { (0..transmission.rows()).map(|bin| times(transmission.row(bin), part)).collect() };
    incident.chunks(transmission.cols().max(1)).flat_map(behind).collect()
}

fn times<T: Copy + Into<f64>>(row: &[T], column: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (values, light) in row.chunks_exact(3).zip(column) {
        for c in 0..3 {
            sum[c] += values[c].into() * light[c];
        }
    }
    sum
}

fn less(all: [f64; 3], part: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| all[c] - part[c])
}

fn mean_light(all: &[Light]) -> Light {
    let n = all.len() as f64;
    let bins = all.first().map_or(0, Vec::len);
    (0..bins).map(|b| std::array::from_fn(|c| all.iter().map(|l| l[b][c]).sum::<f64>() / n)).collect()
}

fn lux(view: &[[f64; 3]], light: &[[f64; 3]]) -> f64 {
    view.iter().zip(light).map(|(v, l)| (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * v[c] * l[c]).sum::<f64>()).sum()
}

//! Standard errors of the hours, and the numbers of each sensor's year with theirs.

use super::metrics::{Row, Samples, SensorSample};
use super::uncertainty::{Deviations, EstimatedError};
use crate::error::Result;
use crate::kernels::product::Multiplier;
use crate::matrix::Matrix;
use crate::metrics::{Estimated, Noise};
use crate::simulate::inputs::counting::{Counting, MEAN};
use crate::simulate::light::Light;
use crate::simulate::results::illuminance::illuminance;
use crate::simulate::sampling::chain::{Chain, relative_error};
use crate::weather::Steps;
use rayon::prelude::*;

/// Errors of all hours, and the numbers of the year.
#[derive(Debug, Clone, PartialEq)]
pub struct YearErrors {
    /// Of each sensor and hour, lx.
    pub standard_error: Matrix<f32>,
    /// Of all sensors in the order of their groups.
    pub samples: Vec<SensorSample>,
    /// What could be made of them.
    pub noise: Noise,
    /// Independent replicates; fewer than 2 if nothing is sampled.
    pub replicates: usize,
    /// For the summary; nothing if it is always dark.
    pub estimated: Option<EstimatedError>,
}

/// Variance that the suns' own noise adds to a sensor's illuminance in an hour, lx², or to its sum over the year.
pub type SunVariance<'a> = dyn Fn(usize, Option<usize>) -> f64 + Sync + 'a;

/// What the errors of a year are estimated from.
pub struct YearJob<'a> {
    /// V, T, D and S.
    pub chain: &'a Chain<'a>,
    /// What metrics count.
    pub counting: &'a Counting,
    /// Multiplies.
    pub multiplier: &'a dyn Multiplier,
    /// What the mean of V is multiplied with.
    pub light: &'a Light,
    /// Noise of the suns.
    pub suns: Option<&'a SunVariance<'a>>,
    /// The same chain and light with the CIE's overcast sky in place of the year's, for daylight factors.
    pub overcast: Option<(&'a Chain<'a>, &'a Light)>,
    /// Relative standard error that was asked for.
    pub target: Option<f64>,
}

/// Memory for the deviations of a tile of sensors, bytes.
const TILE_MEMORY: usize = 1 << 27;

/// Standard errors of the illuminance `lux` `[sensor][hour]`, and what metrics count, with theirs.
///
/// # Errors
/// Failures of the multiplier's device and of `stage`.
pub fn estimate(job: &YearJob<'_>, lux: &Matrix<f32>, stage: &dyn Fn(f64) -> Result<()>) -> Result<YearErrors> {
    let (chain, suns, counting) = (job.chain, job.suns, job.counting);
    let (count, hours) = (lux.rows(), lux.cols());
    let deviations = Deviations::new(chain, job.light);
    let overcast = job.overcast.map(|(chain, light)| (chain, light, Deviations::new(chain, light)));
    let sums = chain.annual();
    let confidence_95 = chain.confidence_95(&sums);
    let noise = Noise::new(chain.replicates(), suns.is_some(), confidence_95);
    let mut standard_error = Matrix::zeros(count, hours, 1);
    let mut samples: Vec<SensorSample> = Vec::with_capacity(count);
    let tile = (TILE_MEMORY / (hours.max(1) * 4 * 8)).max(1);
    for first in (0..count).step_by(tile) {
        stage(first as f64 / count as f64)?;
        let range = first..(first + tile).min(count);
        let n = range.len();
        // All rounds know more of the year's spread than the replicates do.
        let spread = |found: Option<Matrix<f32>>| {
            found.map(|mut found| {
                let columns = found.cols().max(1);
                for (row, values) in found.data_mut().chunks_exact_mut(columns).enumerate() {
                    let scale = sums[first + row % n].spread_of_replicates() as f32;
                    if scale != 1.0 {
                        values.iter_mut().for_each(|v| *v *= scale);
                    }
                }
                found
            })
        };
        let own = spread(deviations.of(job.multiplier, range.clone())?);
        let replicates = own.as_ref().map_or(0, |d| d.rows() / n);
        let rows = |of: &Option<Matrix<f32>>, i: usize| -> Vec<Vec<f32>> {
            of.as_ref().map_or_else(Vec::new, |d| (0..replicates).map(|r| d.row(r * n + i).to_vec()).collect())
        };
        let row = |r: usize, i: usize| own.as_ref().map_or(&[][..], |d| d.row(r * n + i));
        let scale = 1.0 / (replicates.max(2) as f64 * (replicates.max(2) - 1) as f64);
        standard_error.data_mut()[first * hours..range.end * hours].par_chunks_mut(hours.max(1)).enumerate().for_each(|(i, errors)| {
            for (hour, error) in errors.iter_mut().enumerate() {
                let squares: f64 = (0..replicates).map(|r| f64::from(row(r, i)[hour]).powi(2)).sum();
                let added = suns.map_or(0.0, |variance| variance(first + i, Some(hour)));
                *error = (squares * scale + added).sqrt() as f32;
            }
        });
        let (sky, sky_deviations) = match &overcast {
            None => (None, None),
            Some((chain, light, deviations)) => {
                (Some(under(chain, light, job.multiplier, range.clone())?), spread(deviations.of(job.multiplier, range.clone())?))
            }
        };
        let found: Vec<SensorSample> = range
            .into_par_iter()
            .map(|sensor| {
                let i = sensor - first;
                let by_suns: Option<Vec<f32>> = suns.map(|v| (0..hours).map(|h| v(sensor, Some(h)).sqrt() as f32).collect());
                let sky_rows = rows(&sky_deviations, i);
                let year = Row {
                    lux: lux.row(sensor).iter().map(|v| f64::from(*v)).collect(),
                    directions: (0..replicates).map(|r| row(r, i)).chain(by_suns.as_deref()).collect(),
                };
                let sky = Row {
                    lux: sky.iter().map(|s| f64::from(s.at(i, 0)[0])).collect(),
                    directions: sky_rows.iter().map(Vec::as_slice).collect(),
                };
                let sun = suns.map_or(0.0, |variance| variance(sensor, None).sqrt() / hours.max(1) as f64);
                SensorSample { sun, ..SensorSample::new(counting, &noise, &year, &sky) }
            })
            .collect();
        samples.extend(found);
    }
    let replicates = if chain.replicates() < 2 { 0 } else { chain.replicates() };
    let all = Samples { counting, noise: &noise, replicates };
    let mean = counting.column(MEAN).expect("the mean is always counted");
    let means: Vec<Estimated> = samples.iter().map(|s| all.of(&[s], mean, |v| v[0])).collect();
    let estimated = summarize(&chain.inputs.weather.steps(), confidence_95, lux, &standard_error, &means, job.target);
    Ok(YearErrors { standard_error, samples, noise, replicates, estimated })
}

/// Illuminance of some sensors under the one sky of a chain, lx `[sensor][1]`.
fn under(chain: &Chain<'_>, light: &Light, multiplier: &dyn Multiplier, sensors: std::ops::Range<usize>) -> Result<Matrix<f32>> {
    let total = chain.view.total();
    let width = total.cols() * 3;
    let rows = Matrix::from_data(sensors.len(), total.cols(), 3, total.data()[sensors.start * width..sensors.end * width].to_vec())?;
    Ok(light.over_the_year(&illuminance(multiplier, &rows, &light.right)?))
}

fn summarize(
    steps: &Steps,
    confidence_95: f64,
    lux: &Matrix<f32>,
    standard_error: &Matrix<f32>,
    means: &[Estimated],
    target: Option<f64>,
) -> Option<EstimatedError> {
    let mut annual: Vec<f64> = means.iter().filter_map(|m| relative_error(m.value, m.standard_error)).collect();
    let mut hourly: Vec<f32> = lux.data().iter().zip(standard_error.data()).filter(|(v, _)| **v > 0.0).map(|(v, e)| e / v).collect();
    let lit = (0..lux.cols()).into_par_iter().filter(|&h| (0..lux.rows()).any(|s| lux.at(s, h)[0] > 0.0)).count();
    if annual.is_empty() || hourly.is_empty() {
        return None;
    }
    annual.sort_by(f64::total_cmp);
    let place = |n: usize, fraction: f64| ((n as f64 - 1.0) * fraction).round() as usize;
    let mut at = |fraction: f64| {
        let k = place(hourly.len(), fraction);
        f64::from(*hourly.select_nth_unstable_by(k, f32::total_cmp).1)
    };
    let (hourly_median, hourly_95th_percentile) = (at(0.5), at(0.95));
    let annual_largest = *annual.last()?;
    Some(EstimatedError {
        annual_median: annual[place(annual.len(), 0.5)],
        annual_largest,
        hourly_median,
        hourly_95th_percentile,
        sensors: lux.rows(),
        hours: steps.hours(lit),
        confidence_95,
        target,
        target_met: target.map(|t| annual_largest <= t),
    })
}

//! Illuminance from the matrices: coefficients, hours, files and the error that the sampling leaves.

use super::inputs::{Inputs, SensorGroup};
use super::store::{Store, software};
use crate::error::{Error, Result};
use crate::kernels::product::{Arrangement, Multiplier};
use crate::matrix::Matrix;
use crate::matrix::file::{Format, write_matrix};
use crate::units::ILLUMINANCE_WEIGHTS;
use crate::weather::Record;
use rayon::prelude::*;
use serde::Serialize;

/// Product of two matrices of equal components, component by component, summed in f64.
///
/// # Panics
/// If the shapes do not fit.
pub fn multiply<A: Copy + Default + Into<f64> + Sync, B: Copy + Default + Into<f64> + Sync>(a: &Matrix<A>, b: &Matrix<B>) -> Matrix<f64> {
    assert_eq!((a.cols(), a.components()), (b.rows(), b.components()), "matrices that do not fit");
    let components = a.components();
    let mut product = Matrix::<f64>::zeros(a.rows(), b.cols(), components);
    let width = b.cols() * components;
    if width == 0 {
        return product;
    }
    product.data_mut().par_chunks_mut(width).enumerate().for_each(|(i, row)| {
        for k in 0..a.cols() {
            let factors = a.at(i, k);
            if factors.iter().all(|&f| f.into() == 0.0) {
                continue;
            }
            for (to, from) in row.chunks_exact_mut(components).zip(b.row(k).chunks_exact(components)) {
                for c in 0..components {
                    to[c] += factors[c].into() * from[c].into();
                }
            }
        }
    });
    product
}

/// Illuminance in lux from daylight coefficients `[sensor][patch]` and S `[patch][hour]`, both RGB.
///
/// The three channels are added by their photometric weights anyway, so they are taken as three
/// times as many terms of one sum: a third of the memory of an RGB product.
///
/// # Errors
/// Failures of the multiplier's device.
pub fn illuminance(multiplier: &dyn Multiplier, coefficients: Matrix<f64>, sky: &Matrix<f32>) -> Result<Matrix<f32>> {
    let (sensors, patches, hours) = (coefficients.rows(), sky.rows(), sky.cols());
    let weighted: Vec<f32> = coefficients.data().iter().enumerate().map(|(i, v)| (v * ILLUMINANCE_WEIGHTS[i % 3]) as f32).collect();
    let mut channels = vec![0.0f32; 3 * patches * hours];
    for patch in 0..patches {
        for (hour, radiance) in sky.row(patch).chunks_exact(3).enumerate() {
            for c in 0..3 {
                channels[(3 * patch + c) * hours + hour] = radiance[c];
            }
        }
    }
    let left = multiplier.left(sensors, 3 * patches, 1, weighted.into())?;
    let right = multiplier.right(3 * patches, hours, 1, channels.into())?;
    let mut lux = Matrix::zeros(sensors, hours, 1);
    multiplier.multiply(&left, &right, 0, hours, Arrangement::Rows, lux.data_mut())?;
    Ok(lux)
}

/// T·D of all windows, one below the other: rows as V's columns, columns the sky's bins.
pub fn transmitted_daylight(inputs: &Inputs, daylight: &[Matrix<f32>]) -> Matrix<f64> {
    let cols = daylight.first().map_or(0, Matrix::cols);
    let mut data = Vec::new();
    for (window, d) in inputs.windows.iter().zip(daylight) {
        data.extend(multiply(&window.transmission, d).into_data());
    }
    Matrix::from_data(inputs.bins(), cols, 3, data).expect("each window adds its bins")
}

/// Relative standard errors, as fractions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EstimatedError {
    /// Of a sensor's sum over all hours: median over the sensors.
    pub annual_median: f64,
    /// The largest of them.
    pub annual_largest: f64,
    /// Of a single daylight hour at one sensor: median.
    pub hourly_median: f64,
    /// Exceeded by one in twenty.
    pub hourly_95th_percentile: f64,
    /// Sensors looked at, evenly chosen.
    pub sensors: usize,
    /// Daylight hours looked at, evenly chosen.
    pub hours: usize,
}

/// What else adds to the illuminance of a sensor (index) in an hour, or over the whole year: value and
/// variance of its error, lx and lx².
pub type Addition<'m> = dyn Fn(usize, Option<usize>) -> (f64, f64) + Sync + 'm;

/// Matrices and their standard errors, as far as illuminance depends on them.
pub struct Sampled<'m> {
    /// V of all sensors.
    pub view: &'m Matrix<f32>,
    /// Standard error of each of its entries.
    pub view_error: &'m Matrix<f32>,
    /// Standard error of each entry of the windows' D.
    pub daylight_error: &'m [Matrix<f32>],
    /// T·D, see [`transmitted_daylight`].
    pub transmitted: &'m Matrix<f64>,
    /// S.
    pub sky: &'m Matrix<f32>,
    /// Further terms than `V·T·D·S`.
    pub addition: Option<&'m Addition<'m>>,
}

/// Most multiplications that the error estimate may take.
const ERROR_WORK: usize = 1 << 30;
const MOST_SENSORS: usize = 64;
const MOST_HOURS: usize = 48;

/// Propagates the standard errors of V and D, taken as independent, to the illuminance `V·T·D·S`:
/// `σ² = Σ_b (σV·TDS)² + Σ_bp (VT·σD·S)²`. The three channels of an entry come from the same
/// paths, so their errors are added, not their squares.
pub fn estimate_error(inputs: &Inputs, sampled: &Sampled<'_>, progress: &dyn Fn(f64) -> Result<()>) -> Result<Option<EstimatedError>> {
    let sky = sampled.sky;
    let patches = sky.rows();
    let bins = inputs.bins();
    let bright = |hour: usize| (0..patches).any(|p| sky.at(p, hour).iter().any(|&v| v > 0.0));
    let bright_hours: Vec<usize> = (0..sky.cols()).filter(|&h| bright(h)).collect();
    let work = (bins * patches * 3).max(1);
    let budget = (ERROR_WORK / work).max(4);
    let sensors = evenly(&(0..sampled.view.rows()).collect::<Vec<_>>(), MOST_SENSORS.min((budget as f64).sqrt().ceil() as usize));
    let hours = evenly(&bright_hours, MOST_HOURS.min(budget / sensors.len().max(1)).max(1));
    if sensors.is_empty() || hours.is_empty() {
        return Ok(None);
    }
    // The year's sum first, then single hours.
    let mut columns = vec![(0..patches).map(|p| sum_of_hours(sky, p)).collect::<Vec<_>>()];
    columns.extend(hours.iter().map(|&h| (0..patches).map(|p| std::array::from_fn(|c| f64::from(sky.at(p, h)[c]))).collect()));
    let (mut annual, mut hourly) = (Vec::new(), Vec::new());
    for (i, column) in columns.iter().enumerate() {
        progress(i as f64 / columns.len() as f64)?;
        let window_light = light_at_windows(sampled.transmitted, column);
        let hour = i.checked_sub(1).map(|h| hours[h]);
        let error = |&s: &usize| {
            let added = sampled.addition.map_or((0.0, 0.0), |a| a(s, hour));
            relative_error(inputs, sampled, s, column, &window_light, added)
        };
        let errors: Vec<f64> = sensors.par_iter().filter_map(error).collect();
        if i == 0 { annual = errors } else { hourly.extend(errors) }
    }
    annual.sort_by(f64::total_cmp);
    hourly.sort_by(f64::total_cmp);
    let at = |sorted: &[f64], fraction: f64| sorted.get(((sorted.len() as f64 - 1.0) * fraction).round() as usize).copied();
    let (Some(annual_median), Some(annual_largest)) = (at(&annual, 0.5), annual.last().copied()) else { return Ok(None) };
    let (Some(hourly_median), Some(hourly_95th_percentile)) = (at(&hourly, 0.5), at(&hourly, 0.95)) else { return Ok(None) };
    Ok(Some(EstimatedError {
        annual_median,
        annual_largest,
        hourly_median,
        hourly_95th_percentile,
        sensors: sensors.len(),
        hours: hours.len(),
    }))
}

fn evenly(all: &[usize], most: usize) -> Vec<usize> {
    let n = most.min(all.len());
    (0..n).map(|i| all[(2 * i + 1) * all.len() / (2 * n)]).collect()
}

fn sum_of_hours(sky: &Matrix<f32>, patch: usize) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for hour in sky.row(patch).chunks_exact(3) {
        for c in 0..3 {
            sum[c] += f64::from(hour[c]);
        }
    }
    sum
}

/// T·D times one column of S.
fn light_at_windows(transmitted: &Matrix<f64>, column: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let row = |b: usize| {
        let mut sum = [0.0; 3];
        for (p, sky) in column.iter().enumerate() {
            for c in 0..3 {
                sum[c] += transmitted.at(b, p)[c] * sky[c];
            }
        }
        sum
    };
    (0..transmitted.rows()).into_par_iter().map(row).collect()
}

/// Standard error over value for one sensor and one column of S; nothing where it is dark.
fn relative_error(
    inputs: &Inputs,
    sampled: &Sampled<'_>,
    sensor: usize,
    column: &[[f64; 3]],
    window_light: &[[f64; 3]],
    added: (f64, f64),
) -> Option<f64> {
    let weights = ILLUMINANCE_WEIGHTS;
    let (mut value, mut variance) = added;
    for (b, light) in window_light.iter().enumerate() {
        let (v, e) = (sampled.view.at(sensor, b), sampled.view_error.at(sensor, b));
        value += (0..3).map(|c| weights[c] * f64::from(v[c]) * light[c]).sum::<f64>();
        variance += (0..3).map(|c| weights[c] * f64::from(e[c]) * light[c]).sum::<f64>().powi(2);
    }
    let mut first = 0;
    for (window, error) in inputs.windows.iter().zip(sampled.daylight_error) {
        let t = &window.transmission;
        for incident in 0..t.cols() {
            let mut seen = [0.0; 3];
            for outgoing in 0..t.rows() {
                let v = sampled.view.at(sensor, first + outgoing);
                for c in 0..3 {
                    seen[c] += f64::from(v[c]) * t.at(outgoing, incident)[c];
                }
            }
            for (p, sky) in column.iter().enumerate() {
                let e = error.at(incident, p);
                variance += (0..3).map(|c| weights[c] * seen[c] * f64::from(e[c]) * sky[c]).sum::<f64>().powi(2);
            }
        }
        first += t.rows();
    }
    (value > 0.0).then(|| variance.sqrt() / value)
}

/// Writes one group's illuminance: a Radiance matrix, and a table for people.
pub fn write_illuminance(store: &Store, group: &SensorGroup, records: &[Record], lux: &Matrix<f32>) -> Result<()> {
    let header = [software(), format!("CONTENT=illuminance of {} in lux, rows sensors, columns hours", group.name)];
    write_matrix(Some(&store.illuminance_path(&group.name, "mtx")), lux, Format::Float, &header)?;
    let path = store.illuminance_path(&group.name, "csv");
    crate::files::write_atomically(&path, |out| {
        let fault = |e: std::io::Error| Error::io(&path, &e);
        let labels: Vec<String> = group
            .sensors
            .iter()
            .enumerate()
            .map(|(i, s)| format!("{} ({} {} {})", i + 1, s.position.x, s.position.y, s.position.z))
            .collect();
        writeln!(out, "month,day,hour,{}", labels.join(",")).map_err(fault)?;
        for (hour, record) in records.iter().enumerate() {
            write!(out, "{},{},{:.3}", record.month, record.day, record.hour).map_err(fault)?;
            for sensor in 0..lux.rows() {
                write!(out, ",{:.1}", lux.at(sensor, hour)[0]).map_err(fault)?;
            }
            writeln!(out).map_err(fault)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_sums_of_products_per_component() {
        let a = Matrix::from_data(2, 2, 3, vec![1., 10., 100., 2., 20., 200., 0., 0., 0., 3., 30., 300.]).unwrap();
        let b = Matrix::<f32>::from_data(2, 1, 3, vec![5., 5., 5., 7., 7., 7.]).unwrap();
        let p: Matrix<f64> = multiply::<f64, f32>(&a, &b);
        assert_eq!(p.data(), [19., 190., 1900., 21., 210., 2100.]);
    }

    #[test]
    fn illuminance_weighs_the_channels() {
        let coefficients = Matrix::from_data(1, 2, 3, vec![1.0, 0.0, 0.0, 0.5, 2.0, 4.0]).unwrap();
        let sky = Matrix::<f32>::from_data(2, 2, 3, vec![3., 5., 7., 0., 0., 0., 1., 10., 100., 0., 0., 2.]).unwrap();
        let lux = illuminance(&crate::kernels::product::Native, coefficients, &sky).unwrap();
        let [r, g, b] = ILLUMINANCE_WEIGHTS;
        let wanted = [r * 3.0 + r * 0.5 + g * 20.0 + b * 400.0, b * 8.0];
        assert_eq!((lux.rows(), lux.cols(), lux.components()), (1, 2, 1));
        for (found, wanted) in lux.data().iter().zip(wanted) {
            assert!((f64::from(*found) / wanted - 1.0).abs() < 1e-6, "{found} {wanted}");
        }
    }

    #[test]
    fn an_even_choice_covers_the_whole_list() {
        assert_eq!(evenly(&[1, 2, 3], 5), [1, 2, 3]);
        assert_eq!(evenly(&(0..100).collect::<Vec<_>>(), 4), [12, 37, 62, 87]);
        assert!(evenly(&[], 4).is_empty());
    }
}

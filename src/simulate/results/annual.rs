//! Standard errors of the hours, and annual metrics with theirs.

use super::uncertainty::{Deviations, EstimatedError};
use crate::error::{Error, Result};
use crate::kernels::product::Multiplier;
use crate::matrix::Matrix;
use crate::simulate::inputs::SensorGroup;
use crate::simulate::light::Light;
use crate::simulate::sampling::chain::{Chain, relative_error};
use crate::simulate::store::Store;
use crate::weather::Steps;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use std::path::Path;

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// The value.
    pub value: f64,
    /// In its unit.
    pub standard_error: f64,
}

/// Metrics of one sensor over the year.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorYear {
    /// Mean over all hours, lx.
    pub mean: Estimated,
    /// Daylight autonomy: share of occupied time with at least 300 lx.
    pub autonomy: Estimated,
    /// Useful daylight: share of occupied time between 100 and 3000 lx.
    pub useful: Estimated,
}

/// Metrics of a group of sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupYear {
    /// Its sensors.
    pub sensors: Vec<SensorYear>,
    /// Mean over sensors and hours, lx.
    pub mean: Estimated,
    /// Of the sensors that face up, the share with an autonomy of at least a half; `None` if none
    /// faces up. The façade stays as computed: LM-83's sDA300/50 % moves blinds and is lower or equal.
    pub spatial_autonomy: Option<Estimated>,
    /// Number of the sensors that face up.
    pub facing_up: usize,
}

/// Errors of all hours, and the metrics of the year.
#[derive(Debug, Clone, PartialEq)]
pub struct YearErrors {
    /// Of each sensor and hour, lx.
    pub standard_error: Matrix<f32>,
    /// Metrics per group.
    pub groups: Vec<GroupYear>,
    /// For the summary; nothing if it is always dark.
    pub estimated: Option<EstimatedError>,
}

/// Variance that the suns' own noise adds to a sensor's illuminance in an hour, lx², or to its sum over the year.
pub type SunVariance<'a> = dyn Fn(usize, Option<usize>) -> f64 + Sync + 'a;

/// Memory for the deviations of a tile of sensors, bytes.
const TILE_MEMORY: usize = 1 << 27;

/// Illuminance of daylight autonomy, lx.
pub const AUTONOMY_LX: f64 = 300.0;
/// Useful daylight illuminance, lx.
pub const USEFUL_LX: RangeInclusive<f64> = 100.0..=3000.0;

/// Occupied hours of LM-83: 8:00 to 18:00 local standard time, every day.
pub fn is_occupied(hour: f64) -> bool {
    (8.0..18.0).contains(&hour)
}

/// Metrics of a row of illuminances: mean, autonomy, useful.
fn metrics(row: impl Iterator<Item = f64>, occupied: &[bool]) -> [f64; 3] {
    let (mut sum, mut autonomy, mut useful, mut count, mut all) = (0.0, 0.0, 0.0, 0.0f64, 0.0f64);
    for (lux, &occupied) in row.zip(occupied) {
        sum += lux;
        all += 1.0;
        if occupied {
            count += 1.0;
            autonomy += f64::from(u8::from(lux >= AUTONOMY_LX));
            useful += f64::from(u8::from(USEFUL_LX.contains(&lux)));
        }
    }
    [sum / all.max(1.0), autonomy / count.max(1.0), useful / count.max(1.0)]
}

/// Metrics of one sensor: of the result, and with each replicate's error put upon it.
struct Sensor {
    metrics: [f64; 3],
    perturbed: Vec<[f64; 3]>,
    /// Standard error that the sun matrix adds to the mean, lx.
    sun: f64,
}

/// Standard errors of the illuminance `lux` `[sensor][hour]`, and annual metrics with theirs. A
/// deviation of a replicate, divided by √(R − 1), is an error as large as that of the mean; the
/// metrics' own errors are the spread of what they become with it, so that steps (hours above a
/// threshold) count as they are.
///
/// # Errors
/// Failures of the multiplier's device and of `stage`.
pub fn estimate(
    chain: &Chain<'_>,
    multiplier: &dyn Multiplier,
    light: &Light,
    lux: &Matrix<f32>,
    suns: Option<&SunVariance<'_>>,
    target: Option<f64>,
    stage: &dyn Fn(f64) -> Result<()>,
) -> Result<YearErrors> {
    let records = &chain.inputs.weather.records;
    let occupied: Vec<bool> = records.iter().map(|r| is_occupied(r.hour)).collect();
    let (count, hours) = (lux.rows(), lux.cols());
    let noise = Deviations::new(chain, light);
    let sums = chain.annual();
    let mut standard_error = Matrix::zeros(count, hours, 1);
    let mut sensors: Vec<Sensor> = Vec::with_capacity(count);
    let tile = (TILE_MEMORY / (hours.max(1) * 4 * 8)).max(1);
    for first in (0..count).step_by(tile) {
        stage(first as f64 / count as f64)?;
        let range = first..(first + tile).min(count);
        let n = range.len();
        let mut deviations = noise.of(multiplier, range.clone())?;
        if let Some(deviations) = &mut deviations {
            // All rounds know more of the year's spread than the replicates do.
            for (row, values) in deviations.data_mut().chunks_exact_mut(hours.max(1)).enumerate() {
                let scale = sums[first + row % n].spread_of_replicates() as f32;
                if scale != 1.0 {
                    values.iter_mut().for_each(|v| *v *= scale);
                }
            }
        }
        let replicates = deviations.as_ref().map_or(0, |d| d.rows() / n);
        let row = |r: usize, i: usize| deviations.as_ref().map_or(&[][..], |d| d.row(r * n + i));
        let scale = 1.0 / (replicates.max(2) as f64 * (replicates.max(2) - 1) as f64);
        standard_error.data_mut()[first * hours..range.end * hours].par_chunks_mut(hours.max(1)).enumerate().for_each(|(i, errors)| {
            for (hour, error) in errors.iter_mut().enumerate() {
                let squares: f64 = (0..replicates).map(|r| f64::from(row(r, i)[hour]).powi(2)).sum();
                let added = suns.map_or(0.0, |variance| variance(first + i, Some(hour)));
                *error = (squares * scale + added).sqrt() as f32;
            }
        });
        let step = 1.0 / ((replicates.max(2) - 1) as f64).sqrt();
        let found: Vec<Sensor> = range
            .into_par_iter()
            .map(|sensor| {
                let values = || lux.row(sensor).iter().map(|v| f64::from(*v));
                let shifted = |r: usize| values().zip(row(r, sensor - first)).map(|(v, d)| v + step * f64::from(*d));
                Sensor {
                    metrics: metrics(values(), &occupied),
                    perturbed: (0..replicates).map(|r| metrics(shifted(r), &occupied)).collect(),
                    sun: suns.map_or(0.0, |variance| variance(sensor, None).sqrt() / hours.max(1) as f64),
                }
            })
            .collect();
        sensors.extend(found);
    }
    let mut first = 0;
    let groups = chain
        .inputs
        .sensors
        .iter()
        .map(|group| {
            let own = &sensors[first..first + group.sensors.len()];
            first += own.len();
            let faces_up: Vec<bool> = group.sensors.iter().map(crate::scene::points::Sensor::faces_up).collect();
            group_year(own, &faces_up)
        })
        .collect::<Vec<_>>();
    let estimated = summarize(&chain.inputs.weather.steps(), chain.confidence_95(&sums), lux, &standard_error, &groups, target);
    Ok(YearErrors { standard_error, groups, estimated })
}

/// A value, and the root mean square of what the perturbed ones differ from it by.
fn with_spread(value: f64, perturbed: impl Iterator<Item = f64>) -> Estimated {
    let (mut squares, mut n) = (0.0, 0.0f64);
    for p in perturbed {
        squares += (p - value).powi(2);
        n += 1.0;
    }
    Estimated { value, standard_error: (squares / n.max(1.0)).sqrt() }
}

/// Metrics of a group. An eye's vertical sensor among desks has no part in the plan's share.
fn group_year(sensors: &[Sensor], faces_up: &[bool]) -> GroupYear {
    let n = sensors.len().max(1) as f64;
    let replicates = sensors.first().map_or(0, |s| s.perturbed.len());
    let over = |of: &[&Sensor], f: &dyn Fn(&[f64; 3]) -> f64| {
        let all = |pick: &dyn Fn(&Sensor) -> [f64; 3]| of.iter().map(|s| f(&pick(s))).sum::<f64>() / of.len().max(1) as f64;
        with_spread(all(&|s| s.metrics), (0..replicates).map(|r| all(&|s| s.perturbed[r])))
    };
    let everyone: Vec<&Sensor> = sensors.iter().collect();
    let plan: Vec<&Sensor> = sensors.iter().zip(faces_up).filter(|(_, up)| **up).map(|(s, _)| s).collect();
    let sensor = |s: &Sensor| {
        let metric = |i: usize| with_spread(s.metrics[i], s.perturbed.iter().map(|p| p[i]));
        let mean = metric(0);
        SensorYear { mean: Estimated { standard_error: mean.standard_error.hypot(s.sun), ..mean }, autonomy: metric(1), useful: metric(2) }
    };
    let mean = over(&everyone, &|m| m[0]);
    // As if the suns' errors were the same at all sensors: no less than they are.
    let sun = sensors.iter().map(|s| s.sun).sum::<f64>() / n;
    GroupYear {
        sensors: sensors.iter().map(sensor).collect(),
        mean: Estimated { standard_error: mean.standard_error.hypot(sun), ..mean },
        spatial_autonomy: (!plan.is_empty()).then(|| over(&plan, &|m| f64::from(u8::from(m[1] >= 0.5)))),
        facing_up: plan.len(),
    }
}

fn summarize(
    steps: &Steps,
    confidence_95: f64,
    lux: &Matrix<f32>,
    standard_error: &Matrix<f32>,
    groups: &[GroupYear],
    target: Option<f64>,
) -> Option<EstimatedError> {
    let relative = |s: &SensorYear| relative_error(s.mean.value, s.mean.standard_error);
    let mut annual: Vec<f64> = groups.iter().flat_map(|g| &g.sensors).filter_map(relative).collect();
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

/// An illuminance with three decimals, or three digits where that would leave fewer: an error is never
/// written as 0 unless it is.
fn lux(value: f64) -> String {
    if value == 0.0 || value.abs() >= 0.1 { format!("{value:.3}") } else { format!("{value:.2e}") }
}

/// Columns of the table of metrics.
const COLUMNS: &str = "sensor,x,y,z,mean_lx,mean_lx_standard_error,autonomy_300_lx,autonomy_300_lx_standard_error,\
                       useful_100_3000_lx,useful_100_3000_lx_standard_error,note";

/// Writes `illuminance/GROUP_annual.csv`: a sensor per line, every metric followed by its standard
/// error, and `no light` where none arrives.
///
/// # Errors
/// Failures of the file system.
pub fn write(store: &Store, (group, dark): (&SensorGroup, &[bool]), year: &GroupYear) -> Result<()> {
    let path = store.results_path(&format!("{}_annual", group.name), "csv");
    crate::files::write_atomically(&path, |out| {
        let fault = |e: std::io::Error| Error::io(&path, &e);
        writeln!(out, "{COLUMNS}").map_err(fault)?;
        for (i, (sensor, y)) in group.sensors.iter().zip(&year.sensors).enumerate() {
            let p = sensor.position;
            write!(out, "{},{},{},{},{},{}", i + 1, p.x, p.y, p.z, lux(y.mean.value), lux(y.mean.standard_error)).map_err(fault)?;
            for share in [y.autonomy, y.useful] {
                write!(out, ",{:.5},{:.5}", share.value, share.standard_error).map_err(fault)?;
            }
            writeln!(out, ",{}", if dark[i] { "no light" } else { "" }).map_err(fault)?;
        }
        Ok(())
    })
}

/// The metrics of a table that [`write`](fn@write) wrote; nothing if there is no such file, or it is of another kind.
pub fn read(path: &Path) -> Option<Vec<SensorYear>> {
    let text = std::fs::read_to_string(path).ok()?;
    let mut lines = text.lines();
    if lines.next()? != COLUMNS {
        return None;
    }
    let sensor = |line: &str| {
        let values: Vec<f64> = line.split(',').skip(4).map_while(|v| v.parse().ok()).collect();
        let [mean, mean_error, autonomy, autonomy_error, useful, useful_error] = values[..] else { return None };
        let estimated = |value, standard_error| Estimated { value, standard_error };
        Some(SensorYear {
            mean: estimated(mean, mean_error),
            autonomy: estimated(autonomy, autonomy_error),
            useful: estimated(useful, useful_error),
        })
    };
    lines.map(sensor).collect()
}

/// The same of irradiance: mean, and the sum over so many hours.
///
/// # Errors
/// Failures of the file system.
pub fn write_irradiance(store: &Store, (group, dark): (&SensorGroup, &[bool]), year: &GroupYear, hours: f64) -> Result<()> {
    let path = store.results_path(&format!("{}_annual", group.name), "csv");
    crate::files::write_atomically(&path, |out| {
        let fault = |e: std::io::Error| Error::io(&path, &e);
        writeln!(out, "sensor,x,y,z,mean_w_m2,mean_w_m2_standard_error,sum_kwh_m2,sum_kwh_m2_standard_error,note").map_err(fault)?;
        for (i, (sensor, y)) in group.sensors.iter().zip(&year.sensors).enumerate() {
            let (p, sum) = (sensor.position, hours / 1000.0);
            let values = [y.mean.value, y.mean.standard_error, sum * y.mean.value, sum * y.mean.standard_error].map(lux).join(",");
            writeln!(out, "{},{},{},{},{values},{}", i + 1, p.x, p.y, p.z, if dark[i] { "no light" } else { "" }).map_err(fault)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertical_sensor_has_no_part_in_the_plan_s_share() {
        // 15 desks, 12 of them with 300 lx in half of the hours; the eye beside them has it, too.
        let sensor = |autonomy: f64| Sensor { metrics: [400.0, autonomy, 0.5], perturbed: vec![[400.0, autonomy, 0.5]; 8], sun: 0.0 };
        let sensors: Vec<Sensor> = (0..16).map(|i| sensor(if (12..15).contains(&i) { 0.49 } else { 0.5 })).collect();
        let mut faces_up = [true; 16];
        faces_up[15] = false;
        let year = group_year(&sensors, &faces_up);
        assert_eq!((year.facing_up, year.spatial_autonomy.unwrap().value), (15, 0.8));
        assert_eq!((year.sensors.len(), year.mean.value), (16, 400.0), "the eye keeps its own metrics");
        let eyes = group_year(&sensors, &[false; 16]);
        assert_eq!((eyes.facing_up, eyes.spatial_autonomy), (0, None), "eyes alone have no plan");
    }
}

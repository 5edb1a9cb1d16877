//! Metrics of a result folder, again: with another occupancy, without tracing anything.

use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::metrics::lm83::Shading;
use crate::metrics::{Metric, Noise};
use crate::simulate::inputs::counting::{Counting, EXPOSURE, FACTOR, MEAN};
use crate::simulate::project::Quantity;
use crate::simulate::project::metrics::MetricsSection;
use crate::simulate::results::metrics::{self as tables, GroupFacts, Hours, Row, SUN_HOURS, Samples, SensorSample, SensorTable};
use crate::simulate::store::read_stored;
use crate::simulate::summary::Summary;
use crate::statistics::student_95;
use rayon::prelude::*;
use std::path::Path;

/// All metrics of a folder that a run has written: of each group, then of all. What depends on no occupancy and was not
/// kept by the hour (daylight factor, ASE) is taken from the run's tables. Errors are those of the hours, as if all hours
/// and sensors erred the same way: no less than they are.
///
/// # Errors
/// A folder without results, of irradiance, of moments or of an older version; a schedule that does not fit the year.
pub fn judge_folder(folder: &Path, section: &MetricsSection) -> Result<Vec<Metric>> {
    let summary = Summary::read(folder)?;
    if summary.quantity == Quantity::Irradiance.name() {
        return Err(Error::new("these results are irradiance: metrics are of illuminance").file(folder));
    }
    let file = |name: String, extension: &str| folder.join("illuminance").join(format!("{name}.{extension}"));
    let table = |name: &str| folder.join("metrics").join(format!("{name}.csv"));
    let steps = summary.time_steps.max(1) as f64;
    let Hours { year, diffuse, equinox } = tables::read_hours(&table("hours"), summary.hours / steps)?;
    let confidence_95 = summary.estimated_error.map_or(student_95(1_000_000), |e| e.confidence_95);
    let not_bare = summary.sensors.iter().flat_map(|s| &s.metrics).find(|m| m.name == "ase_1000_250");
    let not_bare = not_bare.and_then(|m| {
        m.notes.iter().find(|n| n.contains("LM-83 wants them without blinds") || n.contains("with their blinds open")).cloned()
    });
    let operated = summary.control.as_ref().is_some_and(|c| c.lm83_blinds);
    let shading = if operated { Shading::Operated } else { Shading::Undeclared };
    let mut groups = Vec::new();
    for group in &summary.sensors {
        let lux = read_stored(&file(group.name.clone(), "mtx"))?.matrix;
        let errors = read_stored(&file(format!("{}_standard_error", group.name), "mtx"))?.matrix;
        if (errors.rows(), errors.cols()) != (lux.rows(), lux.cols()) || lux.cols() != year.steps.len() {
            return Err(Error::new(format!("the tables of '{}' do not belong together", group.name))
                .file(folder)
                .help("run the project again"));
        }
        let kept = tables::read_sensors(&file(format!("{}_annual", group.name), "csv")).unwrap_or_default();
        let places = tables::read_directions(&table(&format!("{}_sensors", group.name))).unwrap_or_default();
        if places.len() != lux.rows() {
            return Err(Error::new(format!("it is not known where the sensors of '{}' are", group.name))
                .file(folder)
                .help("run the project again"));
        }
        let facts = GroupFacts {
            name: group.name.clone(),
            positions: places.iter().map(|p| p[0]).collect(),
            faces_up: places.iter().map(|p| crate::scene::points::faces_up(p[1])).collect(),
            not_bare: not_bare.clone(),
            // Geometry is not kept; what it decided is.
            outlook: group.metrics.iter().filter(|m| tables::outlook::NAMES.contains(&m.name.as_str())).cloned().collect(),
            shading,
            hours_in_sun: summary.control.as_ref().and_then(|c| c.lm83_hours_above).unwrap_or(0.0),
        };
        groups.push((facts, lux, errors, kept));
    }
    let vertical = groups.iter().any(|(f, ..)| f.faces_up.contains(&false));
    let counting = Counting::of_steps(section, year, diffuse, equinox, vertical)?;
    let noise = Noise::new(0, true, confidence_95);
    let samples = Samples { counting: &counting, noise: &noise, replicates: 0 };
    let counted: Vec<(GroupFacts, Vec<SensorSample>)> =
        groups.into_iter().map(|(facts, lux, errors, kept)| (facts, count(&counting, &noise, &lux, &errors, &kept))).collect();
    let mut metrics: Vec<Metric> = counted.iter().flat_map(|(facts, own)| tables::judge(&samples, facts, own)).collect();
    let parts: Vec<(&GroupFacts, &[SensorSample])> = counted.iter().map(|(f, s)| (f, &s[..])).collect();
    metrics.extend(tables::judge_all(&samples, &parts));
    Ok(metrics)
}

/// Numbers of all sensors, from their illuminances and standard errors, and what the run kept of them.
fn count(counting: &Counting, noise: &Noise, lux: &Matrix<f32>, errors: &Matrix<f32>, kept: &SensorTable) -> Vec<SensorSample> {
    let sensor = |s: usize| {
        let lux: Vec<f64> = lux.row(s).iter().map(|v| f64::from(*v)).collect();
        let factor = kept.get(s, FACTOR).filter(|f| f.value.is_finite());
        let outdoors = crate::sky::cie::OUTDOORS;
        let error = factor.map(|f| (f.standard_error * outdoors) as f32);
        let sky =
            Row { lux: factor.iter().map(|f| f.value * outdoors).collect(), directions: error.iter().map(std::slice::from_ref).collect() };
        let mut sample = SensorSample::new(counting, noise, &Row { lux, directions: vec![errors.row(s)] }, &sky);
        let around = |e: crate::metrics::Estimated| [e.value, e.value - e.standard_error, e.value + e.standard_error];
        sample.sun_hours = kept.get(s, SUN_HOURS).map(around);
        // The run knows the errors of sums better than the hours do.
        for name in [MEAN, EXPOSURE] {
            if let (Some(column), Some(known)) = (counting.column(name), kept.get(s, name)) {
                let value = sample.values[column];
                sample.probed.iter_mut().zip([-1.0, 1.0]).for_each(|(p, side)| p[column] = value + side * known.standard_error);
            }
        }
        sample
    };
    (0..lux.rows()).into_par_iter().map(sensor).collect()
}

/// Writes metrics as a table.
///
/// # Errors
/// Failures of the file system.
pub fn write(path: &Path, metrics: &[Metric]) -> Result<()> {
    tables::write_metrics(path, &metrics.iter().collect::<Vec<_>>())
}

//! Illuminance from the matrices: coefficients, hours, files and the error that the sampling leaves.

use crate::error::{Error, Result};
use crate::kernels::product::{Arrangement, Multiplier};
use crate::matrix::Matrix;
use crate::simulate::inputs::SensorGroup;
use crate::simulate::project::Quantity;
use crate::simulate::store::{Store, write_stored};
use crate::units::ILLUMINANCE_WEIGHTS;
use crate::weather::Record;
use crate::weather::time::Time;
use glam::DVec3;
use std::io::BufRead;
use std::path::Path;

/// Luminous value of an RGB value: lm/m² (or cd/m²) of W/m² (W/m²sr).
pub(crate) fn luminous(v: &[f32]) -> f64 {
    v.iter().zip(ILLUMINANCE_WEIGHTS).map(|(v, w)| f64::from(*v) * w).sum()
}

/// Illuminance in lux from the left and the right factor of the formula, `[sensor][bin]` and
/// `[bin][hour]` (or daylight coefficients `[sensor][patch]` and S), both RGB.
///
/// The three channels are added by their photometric weights anyway, so they are taken as three
/// times as many terms of one sum: a third of the memory of an RGB product.
///
/// # Errors
/// Failures of the multiplier's device.
pub(crate) fn illuminance<T: Copy + Default + Into<f64>>(
    multiplier: &dyn Multiplier,
    left: &Matrix<T>,
    right: &Matrix<f32>,
) -> Result<Matrix<f32>> {
    assert_eq!(left.cols(), right.rows(), "factors that fit");
    let (sensors, terms, hours) = (left.rows(), right.rows(), right.cols());
    let mut lux = Matrix::zeros(sensors, hours, 1);
    if sensors == 0 || hours == 0 {
        return Ok(lux);
    }
    let weighted: Vec<f32> = left.data().iter().enumerate().map(|(i, &v)| (v.into() * ILLUMINANCE_WEIGHTS[i % 3]) as f32).collect();
    let mut channels = vec![0.0f32; 3 * terms * hours];
    for term in 0..terms {
        for (hour, value) in right.row(term).as_chunks::<3>().0.iter().enumerate() {
            for (c, value) in value.iter().enumerate() {
                channels[(3 * term + c) * hours + hour] = *value;
            }
        }
    }
    let left = multiplier.left(sensors, 3 * terms, 1, weighted.into())?;
    let right = multiplier.right(3 * terms, hours, 1, channels.into())?;
    multiplier.multiply(&left, &right, 0, hours, Arrangement::Rows, lux.data_mut())?;
    Ok(lux)
}

/// What a file of illuminances holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Content {
    /// The illuminance.
    Illuminance,
    /// Its standard error.
    StandardError,
}

/// Writes one group's illuminance or its standard error: a Radiance matrix, and a table for people, which
/// marks the sensors that are `dark`.
///
/// # Errors
/// Failures of the file system.
pub(crate) fn write_illuminance(
    store: &Store,
    group: &SensorGroup,
    dark: &[bool],
    records: &[Record],
    lux: &Matrix<f32>,
    content: Content,
    quantity: Quantity,
) -> Result<()> {
    let what = quantity.name();
    let (name, about) = match content {
        Content::Illuminance => (group.name.clone(), what.to_string()),
        Content::StandardError => (format!("{}_standard_error", group.name), format!("standard error of the {what}")),
    };
    let about = format!("{about} of {} in {}, rows sensors, columns time steps", group.name, quantity.unit());
    write_stored(&store.results_path(&name, "mtx"), lux, &about)?;
    let path = store.results_path(&name, "csv");
    crate::files::write_atomically(&path, |out| {
        let fault = |e: std::io::Error| Error::io(&path, &e);
        let labels: Vec<String> = group
            .sensors
            .iter()
            .zip(dark)
            .enumerate()
            .map(|(i, (s, dark))| {
                let mark = if *dark { "no light " } else { "" };
                format!("{} {mark}({} {} {})", i + 1, s.position.x, s.position.y, s.position.z)
            })
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

/// Positions and times of a table that [`write_illuminance`] wrote: `month,day,hour,1 (x y z),2 (x y z),…`.
/// No positions if a column does not tell its own; nothing if there is no such file.
pub(crate) fn read_table(path: &Path) -> Option<(Vec<DVec3>, Vec<Time>)> {
    let mut lines = std::io::BufReader::new(std::fs::File::open(path).ok()?).lines();
    let head = lines.next()?.ok()?;
    let position = |label: &str| {
        let inside = label.split_once('(')?.1.strip_suffix(')')?;
        let n: Vec<f64> = inside.split_whitespace().filter_map(|v| v.parse().ok()).collect();
        (n.len() == 3).then(|| DVec3::new(n[0], n[1], n[2]))
    };
    let positions: Option<Vec<DVec3>> = head.split(',').skip(3).map(position).collect();
    let times = lines.map_while(|line| {
        let line = line.ok()?;
        let mut words = line.splitn(4, ',');
        Some(Time { month: words.next()?.parse().ok()?, day: words.next()?.parse().ok()?, hour: words.next()?.parse().ok()? })
    });
    Some((positions.unwrap_or_default(), times.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn illuminance_weighs_the_channels() {
        let coefficients = Matrix::from_data(1, 2, 3, vec![1.0, 0.0, 0.0, 0.5, 2.0, 4.0]).unwrap();
        let sky = Matrix::<f32>::from_data(2, 2, 3, vec![3., 5., 7., 0., 0., 0., 1., 10., 100., 0., 0., 2.]).unwrap();
        let lux = illuminance(&crate::kernels::product::Native, &coefficients, &sky).unwrap();
        let [r, g, b] = ILLUMINANCE_WEIGHTS;
        let wanted = [r * 3.0 + r * 0.5 + g * 20.0 + b * 400.0, b * 8.0];
        assert_eq!((lux.rows(), lux.cols(), lux.components()), (1, 2, 1));
        for (found, wanted) in lux.data().iter().zip(wanted) {
            assert!((f64::from(*found) / wanted - 1.0).abs() < 1e-6, "{found} {wanted}");
        }
    }
}

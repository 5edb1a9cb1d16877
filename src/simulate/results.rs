//! Illuminance from the matrices: coefficients, hours, files and the error that the sampling leaves.

use super::inputs::{Inputs, SensorGroup};
use super::multiply::lit_columns;
use super::store::{Store, software};
use crate::error::{Error, Result};
use crate::kernels::product::{Arrangement, Multiplier};
use crate::matrix::Matrix;
use crate::matrix::file::{Format, write_matrix};
use crate::units::ILLUMINANCE_WEIGHTS;
use crate::weather::Record;
use rayon::prelude::*;

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
/// times as many terms of one sum: a third of the memory of an RGB product. Hours with a black sky
/// cost nothing.
///
/// # Errors
/// Failures of the multiplier's device.
pub fn illuminance(multiplier: &dyn Multiplier, coefficients: Matrix<f64>, sky: &Matrix<f32>) -> Result<Matrix<f32>> {
    let (sensors, patches) = (coefficients.rows(), sky.rows());
    let lit = lit_columns(sky);
    let weighted: Vec<f32> = coefficients.data().iter().enumerate().map(|(i, v)| (v * ILLUMINANCE_WEIGHTS[i % 3]) as f32).collect();
    let hours = lit.len();
    let mut lux = Matrix::zeros(sensors, sky.cols(), 1);
    if sensors == 0 || hours == 0 {
        return Ok(lux);
    }
    let mut channels = vec![0.0f32; 3 * patches * hours];
    for patch in 0..patches {
        for (place, &hour) in lit.iter().enumerate() {
            for (c, value) in sky.at(patch, hour).iter().enumerate() {
                channels[(3 * patch + c) * hours + place] = *value;
            }
        }
    }
    let left = multiplier.left(sensors, 3 * patches, 1, weighted.into())?;
    let right = multiplier.right(3 * patches, hours, 1, channels.into())?;
    let mut dense = vec![0.0; sensors * hours];
    multiplier.multiply(&left, &right, 0, hours, Arrangement::Rows, &mut dense)?;
    for (row, values) in dense.chunks_exact(hours).enumerate() {
        for (&hour, value) in lit.iter().zip(values) {
            lux.at_mut(row, hour)[0] = *value;
        }
    }
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

/// What else adds to the illuminance of a sensor (index) in an hour, or over the whole year: value and
/// variance of its error, lx and lx².
pub type Addition<'m> = dyn Fn(usize, Option<usize>) -> (f64, f64) + Sync + 'm;

/// What a file of illuminances holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// The illuminance.
    Illuminance,
    /// Its standard error.
    StandardError,
}

/// Writes one group's illuminance or its standard error: a Radiance matrix, and a table for people, which
/// marks the sensors that are `dark`.
pub fn write_illuminance(
    store: &Store,
    (group, dark): (&SensorGroup, &[bool]),
    records: &[Record],
    lux: &Matrix<f32>,
    content: Content,
) -> Result<()> {
    let (name, about) = match content {
        Content::Illuminance => (group.name.clone(), "illuminance"),
        Content::StandardError => (format!("{}_standard_error", group.name), "standard error of the illuminance"),
    };
    let header = [software(), format!("CONTENT={about} of {} in lux, rows sensors, columns time steps", group.name)];
    write_matrix(Some(&store.illuminance_path(&name, "mtx")), lux, Format::Float, &header)?;
    let path = store.illuminance_path(&name, "csv");
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
}

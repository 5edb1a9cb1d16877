//! The product V·T·D·S of named matrices: which columns are computed, and what is said when shapes
//! do not fit.

use crate::error::{Error, Result};
use crate::kernels::product::{Multiplier, chain};
use crate::matrix::Matrix;
use std::collections::BTreeSet;
use std::ops::Range;

/// A matrix with the name it has in messages.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    /// File name.
    pub name: String,
    /// Values.
    pub matrix: Matrix<f32>,
}

/// Checks that each factor has as many columns as the next has rows. `shapes` holds name, rows,
/// columns and components of each.
///
/// # Errors
/// Names the two files that do not fit.
pub fn check_shapes(shapes: &[(&str, usize, usize, usize)]) -> Result<()> {
    for pair in shapes.windows(2) {
        let [(left, _, columns, _), (right, rows, _, _)] = pair else { continue };
        if columns != rows {
            return Err(Error::new(format!("'{left}' has {columns} columns, but '{right}' has {rows} rows"))
                .help("V's columns, T's rows and columns and D's rows count the bins of the window's basis; D's columns and S's rows the patches of the sky"));
        }
    }
    let most = shapes.iter().map(|s| s.3).max().unwrap_or(1);
    match shapes.iter().find(|s| s.3 != most && s.3 != 1) {
        None => Ok(()),
        Some((name, _, _, components)) => {
            let (other, ..) = shapes.iter().find(|s| s.3 == most).expect("the maximum belongs to one of them");
            Err(Error::new(format!("'{name}' has {components} components, but '{other}' has {most}")).field("NCOMP"))
        }
    }
}

/// The columns of a sky matrix that are not black.
pub fn lit_columns(sky: &Matrix<f32>) -> Vec<usize> {
    let components = sky.components();
    let mut lit = vec![false; sky.cols()];
    for row in 0..sky.rows() {
        for (flag, value) in lit.iter_mut().zip(sky.row(row).chunks_exact(components)) {
            *flag |= value.iter().any(|v| *v != 0.0);
        }
    }
    (0..sky.cols()).filter(|&column| lit[column]).collect()
}

/// These columns of a matrix, in this order.
///
/// # Panics
/// If one does not exist.
pub fn select_columns(matrix: &Matrix<f32>, columns: &[usize]) -> Matrix<f32> {
    let mut data = Vec::with_capacity(matrix.rows() * columns.len() * matrix.components());
    for row in 0..matrix.rows() {
        for &column in columns {
            data.extend_from_slice(matrix.at(row, column));
        }
    }
    Matrix::from_data(matrix.rows(), columns.len(), matrix.components(), data).expect("one entry per row and column")
}

/// Puts some rows of a matrix into another, from its row `first` on, each column to the one of this number: what
/// [`select_columns`] took apart, together again.
///
/// # Panics
/// If a row or column does not exist, or the components differ.
pub fn put_columns(to: &mut Matrix<f32>, first: usize, columns: &[usize], from: &Matrix<f32>, rows: Range<usize>) {
    assert_eq!(columns.len(), from.cols(), "a place for each column");
    for (row, own) in (first..).zip(rows) {
        for (own_column, &column) in columns.iter().enumerate() {
            to.at_mut(row, column).copy_from_slice(from.at(own, own_column));
        }
    }
}

/// Checks a list of hours against the columns of the sky matrix.
///
/// # Errors
/// Hours beyond the matrix or named twice.
pub fn check_hours(hours: &[usize], sky: &str, columns: usize) -> Result<()> {
    let fail = |message: String| Err(Error::new(message));
    if let Some(hour) = hours.iter().find(|&&h| h >= columns) {
        return fail(format!("'{sky}' has no hour {hour}: its {columns} columns are hours 0 to {}", columns.saturating_sub(1)));
    }
    let mut seen = BTreeSet::new();
    match hours.iter().find(|&&h| !seen.insert(h)) {
        Some(hour) => fail(format!("hour {hour} is named twice")),
        None => Ok(()),
    }
}

/// Where V and D are those of a window in parts, T passes the light of each part: T and D become their product.
fn pass_parts(multiplier: &dyn Multiplier, factors: &mut Vec<Factor>) -> Result<()> {
    let fits = |f: &[Factor]| {
        let [v, t, d] = [0, 1, 2].map(|i| &f[i].matrix);
        let (bins, all) = (t.rows(), d.rows());
        bins > 0 && t.cols() == bins && all > bins && all.is_multiple_of(bins) && v.cols() == all
    };
    let Some(first) = factors.windows(3).position(fits) else { return Ok(()) };
    let (t, d) = (&factors[first + 1], &factors[first + 2]);
    let (bins, cols, components) = (t.matrix.rows(), d.matrix.cols(), d.matrix.components());
    let mut data = Vec::with_capacity(d.matrix.data().len());
    for part in d.matrix.data().chunks(bins * cols * components) {
        let part = Matrix::from_data(bins, cols, components, part.to_vec())?;
        data.extend(chain(multiplier, &[&t.matrix, &part])?.into_data());
    }
    let components = data.len() / (d.matrix.rows() * cols).max(1);
    let passed = Factor { name: format!("{}·{}", t.name, d.name), matrix: Matrix::from_data(d.matrix.rows(), cols, components, data)? };
    factors.splice(first + 1..first + 3, [passed]);
    Ok(())
}

/// The product of all factors for the columns `hours` of the last one (all, if absent), evaluated
/// from the right. Only columns that are not black are computed; the others are zeros.
///
/// # Errors
/// Shapes that do not fit, hours that do not exist, failures of the device.
pub fn product(multiplier: &dyn Multiplier, mut factors: Vec<Factor>, hours: Option<&[usize]>) -> Result<Matrix<f32>> {
    pass_parts(multiplier, &mut factors)?;
    let shapes: Vec<_> = factors.iter().map(|f| (&*f.name, f.matrix.rows(), f.matrix.cols(), f.matrix.components())).collect();
    check_shapes(&shapes)?;
    let Some(sky) = factors.last_mut() else {
        return Err(Error::new("a product needs at least one matrix"));
    };
    if let Some(hours) = hours {
        check_hours(hours, &sky.name, sky.matrix.cols()).map_err(|e| e.field("--hours"))?;
        sky.matrix = select_columns(&sky.matrix, hours);
    }
    let columns = sky.matrix.cols();
    let lit = lit_columns(&sky.matrix);
    if lit.len() < columns {
        sky.matrix = select_columns(&sky.matrix, &lit);
    }
    let matrices: Vec<&Matrix<f32>> = factors.iter().map(|f| &f.matrix).collect();
    let dense = chain(multiplier, &matrices)?;
    if lit.len() == columns {
        return Ok(dense);
    }
    let mut all = Matrix::zeros(dense.rows(), columns, dense.components());
    for row in 0..dense.rows() {
        for (i, &column) in lit.iter().enumerate() {
            all.at_mut(row, column).copy_from_slice(dense.at(row, i));
        }
    }
    Ok(all)
}

/// The weighted sum of the three components: RGB (ir)radiance to (il)luminance.
///
/// # Errors
/// If the matrix has not three components.
pub fn weighted(matrix: &Matrix<f32>, weights: [f64; 3]) -> Result<Matrix<f32>> {
    if matrix.components() != 3 {
        return Err(Error::new(format!("the product has {} component(s); weights apply to three (RGB)", matrix.components())).field("-c"));
    }
    let sum = |v: &[f32]| v.iter().zip(weights).map(|(v, w)| f64::from(*v) * w).sum::<f64>() as f32;
    Matrix::from_data(matrix.rows(), matrix.cols(), 1, matrix.data().chunks_exact(3).map(sum).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::product::Native;

    fn factor(name: &str, rows: usize, cols: usize, components: usize) -> Factor {
        let data = (0..rows * cols * components).map(|i| (i % 13) as f32 - 4.0).collect();
        Factor { name: name.into(), matrix: Matrix::from_data(rows, cols, components, data).unwrap() }
    }

    #[test]
    fn black_columns_stay_black_and_hours_are_picked_in_their_order() {
        let (dc, mut sky) = (factor("DC.mtx", 3, 5, 3), factor("S.mtx", 5, 8, 3));
        for row in 0..5 {
            for column in [0, 3, 7] {
                sky.matrix.at_mut(row, column).fill(0.0);
            }
        }
        assert_eq!(lit_columns(&sky.matrix), [1, 2, 4, 5, 6]);
        let full = chain(&Native, &[&dc.matrix, &sky.matrix]).unwrap();
        assert_eq!(product(&Native, vec![dc.clone(), sky.clone()], None).unwrap(), full);
        let some = product(&Native, vec![dc.clone(), sky.clone()], Some(&[6, 3, 1])).unwrap();
        assert_eq!(some, select_columns(&full, &[6, 3, 1]));
        for (hours, text) in [(&[8][..], "hours 0 to 7"), (&[1, 1], "twice")] {
            let error = product(&Native, vec![dc.clone(), sky.clone()], Some(hours)).unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        }
    }

    #[test]
    fn one_transmission_passes_the_light_of_each_part_of_a_window() {
        let (v, t, d, s) = (factor("V.mtx", 2, 6, 3), factor("T.xml", 3, 3, 1), factor("D.mtx", 6, 4, 3), factor("S.mtx", 4, 5, 3));
        let found = product(&Native, vec![v.clone(), t.clone(), d.clone(), s.clone()], None).unwrap();
        let half = |part: usize| {
            let columns: Vec<usize> = (part * 3..part * 3 + 3).collect();
            let d = Matrix::from_data(3, 4, 3, d.matrix.data()[part * 36..part * 36 + 36].to_vec()).unwrap();
            chain(&Native, &[&select_columns(&v.matrix, &columns), &t.matrix, &d, &s.matrix]).unwrap()
        };
        for (found, (a, b)) in found.data().iter().zip(half(0).data().iter().zip(half(1).data())) {
            assert!((found - (a + b)).abs() < 1e-3 * found.abs().max(1.0), "{found} is {a} + {b}");
        }
        // Rows that are no multiple of T's, and V of fewer parts, do not fit.
        assert!(product(&Native, vec![v, t.clone(), factor("D.mtx", 7, 4, 3), s.clone()], None).is_err());
        assert!(product(&Native, vec![factor("V.mtx", 2, 3, 3), t, d, s], None).is_err());
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let error = product(&Native, vec![factor("V.mtx", 2, 145, 3), factor("half.xml", 77, 77, 1), factor("D.mtx", 77, 3, 3)], None);
        let error = error.unwrap_err().to_string();
        assert!(error.contains("'V.mtx' has 145 columns, but 'half.xml' has 77 rows"), "{error}");
        let error = product(&Native, vec![factor("a", 2, 2, 2), factor("b", 2, 2, 3)], None).unwrap_err().to_string();
        assert!(error.contains("'a' has 2 components, but 'b' has 3"), "{error}");
    }

    #[test]
    fn weights_make_one_component() {
        let rgb = Matrix::from_data(1, 2, 3, vec![1.0f32, 2.0, 3.0, 0.0, 0.0, 10.0]).unwrap();
        assert_eq!(weighted(&rgb, [47.4, 119.9, 11.6]).unwrap().data(), [(47.4f64 + 239.8 + 34.8) as f32, 116.0]);
        assert!(weighted(&Matrix::<f32>::zeros(1, 1, 1), [1.0; 3]).is_err());
    }
}

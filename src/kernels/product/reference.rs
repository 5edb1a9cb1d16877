//! The product by its definition, in f64.

use crate::matrix::Matrix;

/// A·B and |A|·|B|, component by component. The second bounds the rounding error of the first.
///
/// # Panics
/// If the shapes do not fit.
pub fn product(left: &Matrix<f64>, right: &Matrix<f64>) -> (Matrix<f64>, Matrix<f64>) {
    assert_eq!((left.cols(), left.components()), (right.rows(), right.components()));
    let mut sums = Matrix::zeros(left.rows(), right.cols(), left.components());
    let mut magnitudes = sums.clone();
    for row in 0..left.rows() {
        for column in 0..right.cols() {
            for component in 0..left.components() {
                for term in 0..left.cols() {
                    let value = left.at(row, term)[component] * right.at(term, column)[component];
                    sums.at_mut(row, column)[component] += value;
                    magnitudes.at_mut(row, column)[component] += value.abs();
                }
            }
        }
    }
    (sums, magnitudes)
}

/// γ_k: relative rounding error of a sum of `terms` products in f32, in any order (Higham 2002,
/// section 3.1).
pub fn gamma(terms: usize) -> f64 {
    let u = f64::from(f32::EPSILON) / 2.0;
    terms as f64 * u / (1.0 - terms as f64 * u)
}

//! Luminance pictures by their definition, in f64.

use crate::matrix::Matrix;
use crate::units::ILLUMINANCE_WEIGHTS;

/// Luminance of every pixel in every hour, `[hour][pixel]`, cd/m²: the sum of the products of all
/// terms (RGB radiance), weighted.
///
/// # Panics
/// If the shapes do not fit.
pub fn luminance(terms: &[(&Matrix<f32>, &Matrix<f32>)]) -> Vec<Vec<f64>> {
    let (pixels, hours) = (terms[0].0.rows(), terms[0].1.cols());
    let mut pictures = vec![vec![0.0; pixels]; hours];
    for (left, right) in terms {
        assert_eq!((left.rows(), right.cols(), left.cols()), (pixels, hours, right.rows()));
        for (hour, picture) in pictures.iter_mut().enumerate() {
            for (pixel, l) in picture.iter_mut().enumerate() {
                for bin in 0..left.cols() {
                    for c in 0..3 {
                        *l += ILLUMINANCE_WEIGHTS[c] * f64::from(left.at(pixel, bin)[c]) * f64::from(right.at(bin, hour)[c]);
                    }
                }
            }
        }
    }
    pictures
}

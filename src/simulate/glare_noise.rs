//! Noise of the daylight matrices, and of the eyes' view matrix, in the glare of an hour.

use super::inputs::Inputs;
use crate::kernels::glare::HourNoise;
use crate::matrix::Matrix;
use crate::units::ILLUMINANCE_WEIGHTS;

/// Standard errors that make an hour's DGP uncertain, but for those of the picture's view matrix.
pub struct MatrixNoise<'m> {
    windows: Vec<WindowNoise<'m>>,
    sky: &'m Matrix<f32>,
    /// T·D·S, `[bin][hour]`.
    coefficients: &'m Matrix<f32>,
    eye: Option<Eye<'m>>,
}

/// The row of the sensors' view matrix that gives the vertical illuminance.
#[derive(Clone, Copy)]
pub struct Eye<'m> {
    /// `[bin][rgb]`
    pub values: &'m [f32],
    /// Its standard errors.
    pub standard_error: &'m [f32],
}

struct WindowNoise<'m> {
    transmission: &'m Matrix<f64>,
    error: &'m Matrix<f32>,
    /// Squares of the standard errors, if all channels have the same and T is grey: then one sum does.
    grey_squares: Option<Vec<f32>>,
}

impl<'m> MatrixNoise<'m> {
    /// Noise with the transmissions of one state of the façade.
    pub fn new(
        inputs: &Inputs,
        transmissions: &[&'m Matrix<f64>],
        daylight_error: &'m [Matrix<f32>],
        sky: &'m Matrix<f32>,
        coefficients: &'m Matrix<f32>,
        eye: Option<Eye<'m>>,
    ) -> Self {
        assert_eq!(inputs.windows.len(), transmissions.len());
        let grey = |m: &Matrix<f32>| m.data().as_chunks::<3>().0.iter().all(|v| v[0] == v[1] && v[1] == v[2]);
        let grey_f64 = |m: &Matrix<f64>| m.data().as_chunks::<3>().0.iter().all(|v| v[0] == v[1] && v[1] == v[2]);
        let windows = transmissions
            .iter()
            .zip(daylight_error)
            .map(|(&transmission, error)| WindowNoise {
                transmission,
                error,
                grey_squares: (grey(error) && grey_f64(transmission))
                    .then(|| error.data().as_chunks::<3>().0.iter().map(|e| e[0] * e[0]).collect()),
            })
            .collect();
        Self { windows, sky, coefficients, eye }
    }
}

impl HourNoise for MatrixNoise<'_> {
    fn variance(&self, hour: usize, gradient: &[f64], by_given_illuminance: f64) -> f64 {
        let weights = ILLUMINANCE_WEIGHTS;
        let mut gradient = gradient.to_vec();
        let mut variance = 0.0;
        if let Some(eye) = &self.eye {
            for (bin, g) in gradient.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let light = self.coefficients.at(bin, hour);
                let mut error = 0.0;
                for c in 0..3 {
                    g[c] += by_given_illuminance * weights[c] * f64::from(eye.values[bin * 3 + c]);
                    error += by_given_illuminance * weights[c] * f64::from(eye.standard_error[bin * 3 + c]) * f64::from(light[c]);
                }
                variance += error * error;
            }
        }
        let sky: Vec<[f64; 3]> = (0..self.sky.rows())
            .map(|p| {
                let radiance = self.sky.at(p, hour);
                [0, 1, 2].map(|c| f64::from(radiance[c]))
            })
            .collect();
        let mut first = 0;
        for window in &self.windows {
            let bins = window.transmission.rows();
            variance += window.variance(&gradient[first * 3..(first + bins) * 3], &sky);
            first += bins;
        }
        variance
    }
}

impl WindowNoise<'_> {
    /// Σ over D's entries of (gradient · T · standard error · sky)².
    fn variance(&self, gradient: &[f64], sky: &[[f64; 3]]) -> f64 {
        let t = self.transmission;
        let (bins, patches) = (t.cols(), sky.len());
        // Gradient by the light on the window's outer side, `[incident bin][rgb]`.
        let mut outside = vec![[0.0f64; 3]; bins];
        for (g, row) in gradient.as_chunks::<3>().0.iter().zip(t.data().chunks_exact(bins * 3)) {
            if g.iter().any(|&g| g != 0.0) {
                for (sum, t) in outside.iter_mut().zip(row.as_chunks::<3>().0) {
                    for c in 0..3 {
                        sum[c] += g[c] * t[c];
                    }
                }
            }
        }
        // Where gradients are in the ratio of the photometric weights, one number stands for three.
        let ratio = |v: &[f64; 3]| v[0] / ILLUMINANCE_WEIGHTS[0];
        let photometric = |v: &[f64; 3]| (0..3).all(|c| (v[c] - ILLUMINANCE_WEIGHTS[c] * ratio(v)).abs() <= 1e-9 * v[c].abs());
        if let Some(squares) = &self.grey_squares
            && outside.iter().all(photometric)
        {
            let light: Vec<f32> = sky
                .iter()
                .map(|s| {
                    let l: f64 = (0..3).map(|c| ILLUMINANCE_WEIGHTS[c] * s[c]).sum();
                    (l * l) as f32
                })
                .collect();
            let row = |(v, squares): (&[f64; 3], &[f32])| ratio(v).powi(2) * f64::from(dot(squares, &light));
            return outside.iter().zip(squares.chunks_exact(patches)).map(row).sum();
        }
        let mut variance = 0.0;
        for (v, errors) in outside.iter().zip(self.error.data().chunks_exact(patches * 3)) {
            for (e, s) in errors.as_chunks::<3>().0.iter().zip(sky) {
                let change: f64 = (0..3).map(|c| v[c] * f64::from(e[c]) * s[c]).sum();
                variance += change * change;
            }
        }
        variance
    }
}

/// Sum of products, in lanes, so that it runs on vector units.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    const LANES: usize = 16;
    let mut sums = [0.0f32; LANES];
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for i in 0..LANES {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f32>() + rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum::<f32>()
}

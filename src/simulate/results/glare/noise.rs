//! Noise of the daylight matrices, and of the eyes' view matrix, in the glare of an hour.

use crate::kernels::glare::HourNoise;
use crate::matrix::Matrix;
use crate::simulate::inputs::Inputs;
use crate::simulate::inputs::states::WindowUse;
use crate::simulate::light::Light;
use crate::simulate::results::glare::eyes::Eye;
use crate::units::ILLUMINANCE_WEIGHTS;

/// Standard errors that make an hour's DGP uncertain, but for those of the picture's view matrix.
pub(super) struct MatrixNoise<'m> {
    windows: Vec<Window<'m>>,
    sky: &'m Matrix<f32>,
    /// T·D·S in its first rows.
    light: &'m Light,
    /// The sensor that gives the vertical illuminance.
    eye: Option<Eye<'m>>,
    suns: Option<SunNoise<'m>>,
}

/// What five phases change: direct light of the sun's patches is taken away, and with it its error.
#[derive(Clone, Copy)]
pub(super) struct SunNoise<'m> {
    /// Sds of the hours.
    pub patches: &'m Matrix<f32>,
    /// Numbers of the hours in the year.
    pub hours: &'m [usize],
    /// D of each window.
    pub daylight: &'m [Matrix<f32>],
    /// Dd of each window.
    pub daylight_direct: &'m [Matrix<f32>],
}

/// A window in the states that it is ever in.
struct Window<'m> {
    uses: Vec<WindowNoise<'m>>,
    /// Of each hour that is computed the number of its state among them; empty if there is one.
    of_hour: Vec<usize>,
}

struct WindowNoise<'m> {
    transmission: &'m Matrix<f64>,
    error: &'m Matrix<f32>,
    /// Whether its sun is traced.
    is_traced: bool,
    /// Squares of the standard errors, if all channels have the same and T is grey: then one sum does.
    grey_squares: Option<Vec<f32>>,
}

impl<'m> MatrixNoise<'m> {
    /// Noise of a façade through the year; `sky` are the hours that are computed, beside their numbers.
    pub(super) fn new(
        inputs: &'m Inputs,
        daylight_error: &'m [Matrix<f32>],
        (sky, hours): (&'m Matrix<f32>, &[usize]),
        light: &'m Light,
        eye: Option<Eye<'m>>,
        suns: Option<SunNoise<'m>>,
    ) -> Self {
        let grey = |m: &Matrix<f32>| m.data().as_chunks::<3>().0.iter().all(|v| v[0] == v[1] && v[1] == v[2]);
        let grey_f64 = |m: &Matrix<f64>| m.data().as_chunks::<3>().0.iter().all(|v| v[0] == v[1] && v[1] == v[2]);
        let window = |(number, error): (usize, &'m Matrix<f32>)| {
            let uses = inputs.uses(number);
            let of_hour = match uses.len() {
                1 => Vec::new(),
                _ => hours.iter().map(|hour| uses.iter().position(|u| u.holds(*hour)).unwrap_or(0)).collect(),
            };
            let noise = |used: WindowUse<'m>| WindowNoise {
                transmission: used.transmission,
                error,
                is_traced: used.is_sunny,
                grey_squares: (grey(error) && grey_f64(used.transmission))
                    .then(|| error.data().as_chunks::<3>().0.iter().map(|e| e[0] * e[0]).collect()),
            };
            Window { uses: uses.into_iter().map(noise).collect(), of_hour }
        };
        let windows = daylight_error.iter().enumerate().map(window).collect();
        Self { windows, sky, light, eye, suns }
    }
}

impl HourNoise for MatrixNoise<'_> {
    fn variance(&self, hour: usize, gradient: &[f64], by_given_illuminance: f64) -> f64 {
        let weights = ILLUMINANCE_WEIGHTS;
        // Beside V − Vd stands Vd: their changes by an entry of D add up.
        let values = self.light.bins * 3;
        let mut all = gradient[..values].to_vec();
        let mut direct = gradient[values..].to_vec();
        direct.resize(values, 0.0);
        all.iter_mut().zip(&direct).for_each(|(a, s)| *a += s);
        let mut by_eye = vec![0.0; values];
        let mut variance = 0.0;
        if let Some(eye) = &self.eye {
            for bin in 0..values / 3 {
                let light = self.light.right.at(bin, hour);
                let mut error = 0.0;
                for c in 0..3 {
                    let (i, by) = (bin * 3 + c, by_given_illuminance * weights[c]);
                    all[i] += by * f64::from(eye.total[i]);
                    by_eye[i] = by * f64::from(eye.direct[i]);
                    error += by * f64::from(eye.standard_error[i]) * f64::from(light[c]);
                }
                variance += error * error;
            }
            let sun = self.suns.and_then(|suns| eye.sun(suns.hours[hour]));
            variance += by_given_illuminance.powi(2) * sun.map_or(0.0, |s| s.variance);
        }
        let column = |m: &Matrix<f32>| -> Vec<[f64; 3]> { (0..m.rows()).map(|p| [0, 1, 2].map(|c| f64::from(m.at(p, hour)[c]))).collect() };
        let sky = column(self.sky);
        let mut first = 0;
        for (number, window) in self.windows.iter().enumerate() {
            let window = &window.uses[window.of_hour.get(hour).copied().unwrap_or(0)];
            let range = first * 3..(first + window.error.rows()) * 3;
            first += window.error.rows();
            let outside = window.outside(&all[range.clone()]);
            let mut of_window = window.variance(&outside, &sky);
            if let Some(suns) = self.suns
                && window.is_traced
            {
                let parts = direct[range.clone()].iter().zip(&by_eye[range]);
                let direct: Vec<f64> = parts.map(|(s, e)| s + e).collect();
                let daylight = [&suns.daylight[number], &suns.daylight_direct[number]];
                of_window -= window.without_sun(&outside, &window.outside(&direct), &sky, &column(suns.patches), daylight);
            }
            variance += of_window.max(0.0);
        }
        variance
    }
}

impl WindowNoise<'_> {
    /// Gradient by the light on the outer side of the window's parts, `[incident bin][rgb]`, one part after the other.
    fn outside(&self, gradient: &[f64]) -> Vec<[f64; 3]> {
        gradient.chunks(self.transmission.rows() * 3).flat_map(|part| self.outside_of_part(part)).collect()
    }

    fn outside_of_part(&self, gradient: &[f64]) -> Vec<[f64; 3]> {
        let t = self.transmission;
        let bins = t.cols();
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
        outside
    }

    /// How much smaller the variance is without the sun's patches seen directly (with the gradient `seen`).
    /// The errors of D and of its part Dd come from the same paths: they are taken to be in the ratio
    /// of the values.
    fn without_sun(
        &self,
        outside: &[[f64; 3]],
        seen: &[[f64; 3]],
        sky: &[[f64; 3]],
        suns: &[[f64; 3]],
        [daylight, direct]: [&Matrix<f32>; 2],
    ) -> f64 {
        let mut less = 0.0;
        for (patch, sun) in suns.iter().enumerate().filter(|(_, s)| s.iter().any(|&s| s > 0.0)) {
            for (bin, (v, w)) in outside.iter().zip(seen).enumerate() {
                let (error, all, direct) = (self.error.at(bin, patch), daylight.at(bin, patch), direct.at(bin, patch));
                let (mut with, mut away) = (0.0, 0.0);
                for c in 0..3 {
                    let share = if all[c] > 0.0 { f64::from(direct[c] / all[c]).min(1.0) } else { 0.0 };
                    with += v[c] * f64::from(error[c]) * sky[patch][c];
                    away += w[c] * f64::from(error[c]) * share * sun[c];
                }
                less += with * with - (with - away).powi(2);
            }
        }
        less
    }

    /// Σ over D's entries of (gradient by the light outside · standard error · sky)².
    fn variance(&self, outside: &[[f64; 3]], sky: &[[f64; 3]]) -> f64 {
        let patches = sky.len();
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

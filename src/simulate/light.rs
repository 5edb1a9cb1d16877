//! The one formula of the matrix methods, for sensors, eyes, pixels and every state of the façade:
//!
//! ```text
//! I = [V − Vd | Vd] · [X ; X − Xsun] + Cds·Ssun      X = T·D·S,  Xsun = T·Dd·Sds
//! ```
//!
//! X is the light that the windows send into the room, `[bin][hour]`. In three phases Xsun and Cds are
//! zero, and V·X is all. In five, of windows whose sun is traced, Xsun is what comes directly from the
//! sun's patches of the sky: seen directly (Vd) it is taken away, and the traced suns stand in its place.
//! Vd and Dd come from the same rays as V and D and are never larger, so nothing cancels and nothing is
//! negative. Windows whose sun is not traced have no Xsun: they stay as in three phases.
//!
//! Where sensors see the sky through clear glass, or by no window at all, there are no bins between: C and Cd, the
//! coefficients from patches of the sky to the sensor, stand for V and Vd, and X = S, Xsun = Sds ([`Light::of_sky`]).
//! There Cd is more than what comes directly: also what diffuse surfaces in the sun send on, for which suns have paths
//! of their own ([`kernels::coefficients`](crate::kernels::coefficients)), and Cds has the same.
//!
//! Sources: Radiance's tutorial of the five-phase method (McNeil 2013), whose
//! `V·T·D·S − Vd·T·Dd·Sds + Cds·Ssun` this equals.

use super::inputs::{Differences, Inputs, ProjectWindow};
use super::multiply::{Factor, lit_columns, product, put_columns, select_columns};
use crate::error::Result;
use crate::kernels::product::Multiplier;
use crate::matrix::Matrix;
use rayon::prelude::*;

/// Skies of the year, columns hours.
#[derive(Debug, Clone)]
pub struct Skies {
    /// S.
    pub whole: Matrix<f32>,
    /// Sds, the sun's share of S, if suns are traced and there is any.
    pub sun: Option<Matrix<f32>>,
}

/// D and Dd of every window, in the order of V's columns.
#[derive(Clone, Copy)]
pub struct Daylight<'a> {
    /// D.
    pub total: &'a [Matrix<f32>],
    /// Dd.
    pub direct: &'a [Matrix<f32>],
}

/// What turns the light before a window into light behind it: T, and D or Dd. Rows of D are the bins of the window's
/// parts, one part after the other; each passes the same T.
pub type Passage<'a> = (&'a Matrix<f64>, &'a Matrix<f32>);

/// A window as the formula has it, in one state of the façade or between two.
#[derive(Clone, Copy)]
pub struct WindowLight<'a> {
    /// T and D.
    pub all: Passage<'a>,
    /// T and Dd of what lets traced suns through; nothing where the sun stays in the sky's patches. Between
    /// two states T is the share of the state whose sun is traced.
    pub sun: Option<Passage<'a>>,
}

impl<'a> WindowLight<'a> {
    /// The windows of a project in one state of the façade.
    pub fn of(inputs: &Inputs, transmissions: &[&'a Matrix<f64>], daylight: Daylight<'a>) -> Vec<Self> {
        let of = |(i, window): (usize, &ProjectWindow)| Self {
            all: (transmissions[i], &daylight.total[i]),
            sun: window.is_sunny().then(|| (transmissions[i], &daylight.direct[i])),
        };
        inputs.windows.iter().enumerate().map(of).collect()
    }

    fn bins(&self) -> usize {
        self.all.1.rows()
    }
}

/// What the windows send into the room: the right factor of the formula.
#[derive(Debug, Clone)]
pub struct Light {
    /// X, and below it X − Xsun where suns are traced: `[bin][hour]`, RGB, columns the lit hours.
    pub right: Matrix<f32>,
    /// Bins of all windows.
    pub bins: usize,
    /// Numbers of the lit hours in the year, rising.
    pub hours: Vec<usize>,
    /// Hours of the year, dark ones too.
    pub all_hours: usize,
}

impl Light {
    /// Light of all lit hours, `(T·D)·S`.
    ///
    /// # Errors
    /// Matrices of different skies, and failures of the multiplier's device.
    pub fn new(windows: &[WindowLight<'_>], multiplier: &dyn Multiplier, skies: &Skies, differences: Differences) -> Result<Self> {
        let hours = lit_columns(&skies.whole);
        let through = |parts: &[Option<Passage<'_>>], sky: &Matrix<f32>| {
            let transmitted = transmitted(windows, parts)?.map(|v| v as f32);
            let sky = Factor { name: "S".into(), matrix: select_columns(sky, &hours) };
            product(multiplier, vec![Factor { name: "T·D".into(), matrix: transmitted }, sky], None)
        };
        Self::behind(windows, skies, differences, hours.clone(), &through)
    }

    /// Light of all lit hours of a façade through the year, each window in the state that it is in.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_facade(inputs: &Inputs, daylight: Daylight<'_>, multiplier: &dyn Multiplier, skies: &Skies) -> Result<Self> {
        let differences = inputs.differences();
        if !inputs.moves() {
            return Self::new(&WindowLight::of(inputs, &inputs.transmissions(), daylight), multiplier, skies, differences);
        }
        let hours = lit_columns(&skies.whole);
        let bins = inputs.bins();
        let has_suns = skies.sun.is_some() && (0..inputs.windows.len()).any(|w| inputs.is_sunny(w));
        let mut right = Matrix::zeros(if has_suns { 2 * bins } else { bins }, hours.len(), 3);
        let mut first = 0;
        for (number, window) in inputs.windows.iter().enumerate() {
            for used in inputs.uses(number) {
                // Columns of the result, and the steps of the year that they are.
                let columns: Vec<usize> = (0..hours.len()).filter(|column| used.holds(hours[*column])).collect();
                let steps: Vec<usize> = columns.iter().map(|column| hours[*column]).collect();
                let of = |sky: &Matrix<f32>| select_columns(sky, &steps);
                let own = Skies { whole: of(&skies.whole), sun: skies.sun.as_ref().filter(|_| used.is_sunny).map(of) };
                let total = &daylight.total[number];
                let light = WindowLight {
                    all: (used.transmission, total),
                    sun: used.is_sunny.then(|| (used.transmission, &daylight.direct[number])),
                };
                let mut part = Self::new(&[light], multiplier, &own, differences)?;
                put_columns(&mut right, first, &columns, &part.right, 0..part.bins);
                if has_suns {
                    part.split();
                    put_columns(&mut right, bins + first, &columns, &part.right, part.bins..2 * part.bins);
                }
            }
            first += window.bins();
        }
        Ok(Self { right, bins, hours, all_hours: skies.whole.cols() })
    }

    /// Light of all lit hours from the sky itself: bins are its patches.
    pub fn of_sky(skies: &Skies, differences: Differences) -> Self {
        let hours = lit_columns(&skies.whole);
        let all = select_columns(&skies.whole, &hours);
        let bins = all.rows();
        let right = match &skies.sun {
            None => all,
            Some(sun) => without_sun(all, &select_columns(sun, &hours), differences),
        };
        Self { right, bins, hours, all_hours: skies.whole.cols() }
    }

    /// Hours alone, without light.
    pub fn hours_of(skies: &Skies) -> Self {
        Self { right: Matrix::zeros(0, 0, 3), bins: 0, hours: lit_columns(&skies.whole), all_hours: skies.whole.cols() }
    }

    /// Light of one hour, dark or not, `T·(D·S)`: what follows a pointer through the year.
    ///
    /// # Errors
    /// Matrices of different skies.
    ///
    /// # Panics
    /// If the skies have no such hour.
    pub fn of_hour(windows: &[WindowLight<'_>], hour: usize, skies: &Skies, differences: Differences) -> Result<Self> {
        let through = |parts: &[Option<Passage<'_>>], sky: &Matrix<f32>| {
            let sky = select_columns(sky, &[hour]);
            each(windows, parts, 1, &|(t, d)| pass(t, &multiply(d, &sky))).map(|m| m.map(|v| v as f32))
        };
        Self::behind(windows, skies, differences, vec![hour], &through)
    }

    /// `[X ; X − Xsun]` of these hours; `through` takes a sky through all windows.
    fn behind(
        windows: &[WindowLight<'_>],
        skies: &Skies,
        differences: Differences,
        hours: Vec<usize>,
        through: &dyn Fn(&[Option<Passage<'_>>], &Matrix<f32>) -> Result<Matrix<f32>>,
    ) -> Result<Self> {
        let all = through(&windows.iter().map(|w| Some(w.all)).collect::<Vec<_>>(), &skies.whole)?;
        let bins = all.rows();
        let suns: Vec<Option<Passage<'_>>> = windows.iter().map(|w| w.sun).collect();
        let right = match skies.sun.as_ref().filter(|_| suns.iter().any(Option::is_some)) {
            None => all,
            Some(sky) => without_sun(all, &through(&suns, sky)?, differences),
        };
        Ok(Self { right, bins, hours, all_hours: skies.whole.cols() })
    }

    /// Whether the sun's patches are taken out: then it belongs to `[V − Vd | Vd]`, else to V.
    pub fn is_split(&self) -> bool {
        self.right.rows() == 2 * self.bins
    }

    /// Makes it one that belongs to `[V − Vd | Vd]`, also where no sun is taken out.
    pub fn split(&mut self) {
        if !self.is_split() {
            let (rows, cols) = (self.right.rows(), self.right.cols());
            self.right = Matrix::from_data(2 * rows, cols, 3, self.right.data().repeat(2)).expect("twice the rows");
        }
    }

    /// The same with the sun in the patches of the sky, as three phases have it.
    #[must_use]
    pub fn with_sun_in_patches(&self) -> Self {
        let mut same = self.clone();
        if self.is_split() {
            let (x, rest) = same.right.data_mut().split_at_mut(self.right.data().len() / 2);
            rest.copy_from_slice(x);
        }
        same
    }

    /// The right factor of these hours of the year, dark ones too.
    pub fn of_hours(&self, hours: &[usize]) -> Matrix<f32> {
        let mut all = Matrix::zeros(self.right.rows(), hours.len(), 3);
        for (column, hour) in hours.iter().enumerate() {
            if let Ok(lit) = self.hours.binary_search(hour) {
                for row in 0..self.right.rows() {
                    all.at_mut(row, column).copy_from_slice(self.right.at(row, lit));
                }
            }
        }
        all
    }

    /// Values of the lit hours as those of all hours, dark ones 0.
    pub fn over_the_year(&self, lit: &Matrix<f32>) -> Matrix<f32> {
        let mut all = Matrix::zeros(lit.rows(), self.all_hours, lit.components());
        for row in 0..lit.rows() {
            for (column, &hour) in self.hours.iter().enumerate() {
                all.at_mut(row, hour).copy_from_slice(lit.at(row, column));
            }
        }
        all
    }

    /// The left factor that belongs to it: `[V − Vd | Vd]`, or V.
    pub fn receivers(&self, total: &Matrix<f32>, direct: &Matrix<f32>, differences: Differences) -> Matrix<f32> {
        if self.is_split() { split_rows(total, direct, differences) } else { total.clone() }
    }
}

/// `[X ; X − Xsun]`.
///
/// # Panics
/// If their shapes differ.
pub fn without_sun(all: Matrix<f32>, sun: &Matrix<f32>, differences: Differences) -> Matrix<f32> {
    assert_eq!((all.rows(), all.cols()), (sun.rows(), sun.cols()), "light of the same bins and hours");
    let (rows, cols) = (all.rows(), all.cols());
    let mut data = all.into_data();
    let rest: Vec<f32> = data.par_iter().zip(sun.data()).map(|(all, sun)| differences.of(*all, *sun)).collect();
    data.extend(rest);
    Matrix::from_data(2 * rows, cols, 3, data).expect("twice the rows")
}

/// `[V − Vd | Vd]`.
///
/// # Panics
/// If their shapes differ.
pub fn split_rows(total: &Matrix<f32>, direct: &Matrix<f32>, differences: Differences) -> Matrix<f32> {
    assert_eq!((total.rows(), total.cols()), (direct.rows(), direct.cols()), "view matrices of the same receivers");
    let mut data = Vec::with_capacity(2 * total.data().len());
    for row in 0..total.rows() {
        data.extend(total.row(row).iter().zip(direct.row(row)).map(|(t, d)| differences.of(*t, *d)));
        data.extend_from_slice(direct.row(row));
    }
    Matrix::from_data(total.rows(), 2 * total.cols(), 3, data).expect("twice the columns")
}

/// T·D of what each window has of `parts`, zeros where it has nothing: rows as V's columns, columns patches.
///
/// # Errors
/// Matrices of different skies.
///
/// # Panics
/// If there are not as many parts as windows.
pub fn transmitted(windows: &[WindowLight<'_>], parts: &[Option<Passage<'_>>]) -> Result<Matrix<f64>> {
    each(windows, parts, windows.first().map_or(0, |w| w.all.1.cols()), &|(t, d)| pass(t, d))
}

/// Light before the parts of a window, one below the other, as it is behind them: T times each part's.
///
/// # Panics
/// If the rows are not those of parts of a window with this T.
pub(crate) fn pass<B: Copy + Default + Into<f64> + Sync>(transmission: &Matrix<f64>, before: &Matrix<B>) -> Matrix<f64> {
    if before.rows() == transmission.cols() {
        return multiply(transmission, before);
    }
    let (cols, components) = (before.cols(), before.components());
    let parts = before.data().chunks(transmission.cols() * cols * components);
    let part = |p: &[B]| Matrix::from_data(transmission.cols(), cols, components, p.to_vec()).expect("rows of whole parts");
    let data: Vec<f64> = parts.flat_map(|p| multiply(transmission, &part(p)).into_data()).collect();
    Matrix::from_data(before.rows(), cols, components, data).expect("as many rows behind as before")
}

/// What each window has, one below the other.
fn each(
    windows: &[WindowLight<'_>],
    parts: &[Option<Passage<'_>>],
    columns: usize,
    of: &dyn Fn(Passage<'_>) -> Matrix<f64>,
) -> Result<Matrix<f64>> {
    assert_eq!(windows.len(), parts.len(), "a part of every window");
    let mut data = Vec::new();
    for (window, part) in windows.iter().zip(parts) {
        match part {
            Some(part) => data.extend(of(*part).into_data()),
            None => data.resize(data.len() + window.bins() * columns * 3, 0.0),
        }
    }
    Matrix::from_data(windows.iter().map(WindowLight::bins).sum(), columns, 3, data)
}

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
    fn each_part_of_a_window_passes_the_same_transmission() {
        let m = |rows, cols, v: &[f64]| Matrix::from_data(rows, cols, 1, v.to_vec()).unwrap();
        let t = m(2, 2, &[1.0, 2.0, 0.0, 3.0]);
        assert_eq!(pass(&t, &m(2, 1, &[5.0, 7.0])).data(), [19.0, 21.0]);
        assert_eq!(pass(&t, &m(4, 1, &[5.0, 7.0, 1.0, 10.0])).data(), [19.0, 21.0, 21.0, 30.0]);
    }

    #[test]
    fn split_factors_give_the_formula() {
        let m = |rows, cols, v: &[f32]| Matrix::from_data(rows, cols, 3, v.iter().flat_map(|v| [*v; 3]).collect()).unwrap();
        let (v, vd) = (m(1, 2, &[3.0, 5.0]), m(1, 2, &[1.0, 2.0]));
        let (x, xsun) = (m(2, 1, &[10.0, 20.0]), m(2, 1, &[4.0, 0.0]));
        let left = split_rows(&v, &vd, Differences::NeverNegative);
        let right = without_sun(x, &xsun, Differences::NeverNegative);
        // V·X − Vd·Xsun
        assert_eq!(multiply(&left, &right).data(), [3.0 * 10.0 + 5.0 * 20.0 - 4.0; 3]);
        // Noise of matrices made apart is kept, so that its mean is right.
        let (less, none) = (m(1, 1, &[1.0]), m(1, 1, &[0.0]));
        assert_eq!(split_rows(&none, &less, Differences::Noisy).at(0, 0), [-1.0; 3]);
        assert_eq!(split_rows(&none, &less, Differences::NeverNegative).at(0, 0), [0.0; 3]);
    }
}

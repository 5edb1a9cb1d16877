//! Dense matrices with interleaved components, and Radiance's files of them.

pub mod file;
pub mod rows;

use crate::error::{Error, Result};

/// A dense row-major matrix whose elements have `components` interleaved values (3 = RGB,
/// 1 = luminance or illuminance): `data[(row * cols + col) * components + component]`.
///
/// Shapes in this program: V `[sensor or pixel][window bin]`, T `[outgoing bin][incident bin]`,
/// D `[window bin][sky patch]`, S `[sky patch][hour]`, results `[sensor][hour]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix<T = f32> {
    rows: usize,
    cols: usize,
    components: usize,
    data: Vec<T>,
}

impl<T: Copy + Default> Matrix<T> {
    /// A matrix of zeros.
    ///
    /// # Panics
    /// If the number of values overflows `usize`.
    pub fn zeros(rows: usize, cols: usize, components: usize) -> Self {
        let len = rows.checked_mul(cols).and_then(|n| n.checked_mul(components)).expect("matrix size overflows");
        Self { rows, cols, components, data: vec![T::default(); len] }
    }

    /// A matrix around existing values.
    ///
    /// # Errors
    /// If `data` does not hold `rows * cols * components` values.
    pub fn from_data(rows: usize, cols: usize, components: usize, data: Vec<T>) -> Result<Self> {
        let wanted = rows.checked_mul(cols).and_then(|n| n.checked_mul(components));
        if wanted != Some(data.len()) {
            return Err(Error::new(format!("{} values do not fill a matrix of {rows} × {cols} × {components}", data.len())));
        }
        Ok(Self { rows, cols, components, data })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Values per element: 3 for RGB, 1 for a single channel.
    pub fn components(&self) -> usize {
        self.components
    }

    /// All values, row-major, components interleaved.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// All values, for changing them in place.
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// Gives up the values.
    pub fn into_data(self) -> Vec<T> {
        self.data
    }

    /// The components of one element.
    pub fn at(&self, row: usize, col: usize) -> &[T] {
        let start = (row * self.cols + col) * self.components;
        &self.data[start..start + self.components]
    }

    /// The components of one element, for changing them.
    pub fn at_mut(&mut self, row: usize, col: usize) -> &mut [T] {
        let start = (row * self.cols + col) * self.components;
        &mut self.data[start..start + self.components]
    }

    /// One row: `cols * components` values.
    pub fn row(&self, row: usize) -> &[T] {
        let n = self.cols * self.components;
        &self.data[row * n..(row + 1) * n]
    }

    /// The same matrix with every value converted.
    pub fn map<U: Copy + Default>(&self, f: impl Fn(T) -> U) -> Matrix<U> {
        Matrix { rows: self.rows, cols: self.cols, components: self.components, data: self.data.iter().map(|&v| f(v)).collect() }
    }
}

impl Matrix<f32> {
    /// Entry by entry less another matrix.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn less(&self, other: &Self) -> Self {
        assert_eq!((self.rows, self.cols, self.components), (other.rows, other.cols, other.components), "matrices of one shape");
        Self { data: self.data.iter().zip(&other.data).map(|(a, b)| a - b).collect(), ..*self }
    }
}

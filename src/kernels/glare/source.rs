//! Where the rows of a view matrix come from.

use crate::error::Result;
use crate::matrix::Matrix;

/// Channels of a view matrix.
pub(super) const RGB: usize = 3;

/// A view matrix that is read from the top: one row per pixel, from the top left, row by row.
pub trait PixelSource: Send {
    /// Columns.
    fn bins(&self) -> usize;

    /// Goes back to the first pixel.
    ///
    /// # Errors
    /// Failures of the file system.
    fn rewind(&mut self) -> Result<()>;

    /// The next `lines` lines of `width` pixels into `values`, `[pixel][bin][rgb]`; its former
    /// contents go.
    ///
    /// # Errors
    /// Failures of the file system, faulty files.
    fn read(&mut self, lines: usize, width: usize, values: &mut Vec<f32>) -> Result<()>;
}

/// A view matrix in memory, RGB.
pub struct InMemory<'m> {
    matrix: &'m Matrix<f32>,
    next: usize,
}

impl<'m> InMemory<'m> {
    /// A source of the rows of `matrix`.
    ///
    /// # Panics
    /// If it has not three components.
    pub fn new(matrix: &'m Matrix<f32>) -> Self {
        assert_eq!(matrix.components(), RGB, "a view matrix of pictures is RGB");
        Self { matrix, next: 0 }
    }
}

impl PixelSource for InMemory<'_> {
    fn bins(&self) -> usize {
        self.matrix.cols()
    }

    fn rewind(&mut self) -> Result<()> {
        self.next = 0;
        Ok(())
    }

    fn read(&mut self, lines: usize, width: usize, values: &mut Vec<f32>) -> Result<()> {
        let row = self.matrix.cols() * RGB;
        let end = (self.next + lines * width).min(self.matrix.rows());
        values.clear();
        values.extend_from_slice(&self.matrix.data()[self.next * row..end * row]);
        self.next = end;
        Ok(())
    }
}

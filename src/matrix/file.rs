//! Radiance matrix files: a text header, then values as `ascii`, `float` or `double`.
//!
//! ```text
//! #?RADIANCE
//! (any lines; kept)
//! NROWS=145
//! NCOLS=146
//! NCOMP=3
//! BigEndian=0
//! FORMAT=float          (spaces may follow, so that the values start on a multiple of 4 or 8 bytes)
//! (one empty line)
//! values, row by row, components interleaved
//! ```
//!
//! Read as `rmtxop` reads them: NROWS may be missing (then the data decide), a missing NCOMP means
//! 3, a missing FORMAT means `ascii`, EXPOSURE and COLORCORR are undone. Unlike Radiance, NROWS
//! that does not fit the data and values that are not finite are errors.

mod header;
mod values;
mod write;

pub(super) use header::Header;
pub use write::{write_float_header, write_matrix, write_matrix_to};

use super::Matrix;
use crate::error::{Error, Result};
use std::fmt::LowerExp;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use std::str::FromStr;
use values::Values;

/// How the values of a matrix file are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Numbers as text: exact when written here, 7 digits or fewer in files of Radiance's programs.
    Ascii,
    /// 32-bit IEEE.
    Float,
    /// 64-bit IEEE.
    Double,
}

impl Format {
    /// The word after `FORMAT=`.
    pub fn name(self) -> &'static str {
        match self {
            Format::Ascii => "ascii",
            Format::Float => "float",
            Format::Double => "double",
        }
    }

    /// The format of Radiance's option letter, as in `-fa`, `-ff`, `-fd`.
    pub fn from_letter(letter: char) -> Option<Self> {
        match letter {
            'a' => Some(Format::Ascii),
            'f' => Some(Format::Float),
            'd' => Some(Format::Double),
            _ => None,
        }
    }

    /// Bytes per value; `None` for text.
    pub(super) fn width(self) -> Option<usize> {
        match self {
            Format::Ascii => None,
            Format::Float => Some(4),
            Format::Double => Some(8),
        }
    }
}

/// A matrix with the header lines of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct MatrixFile<T = f32> {
    /// The values, EXPOSURE and COLORCORR undone.
    pub matrix: Matrix<T>,
    /// Header lines without line ends and in their order, except those that describe size and
    /// storage (`#?RADIANCE`, NROWS, NCOLS, NCOMP, BigEndian, FORMAT, EXPOSURE, COLORCORR).
    pub header: Vec<String>,
}

impl<T> MatrixFile<T> {
    /// The value of the last header line `key=value`, trimmed.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.header.iter().rev().find_map(|l| l.strip_prefix(key)?.strip_prefix('=')).map(str::trim)
    }
}

/// A value that matrix files can hold: `f32` or `f64`.
pub trait Scalar: Copy + Default + Into<f64> + FromStr + LowerExp {
    /// From a file's number; infinite if out of range.
    fn from_f64(value: f64) -> Self;

    /// To a file's number.
    fn to_f64(self) -> f64 {
        self.into()
    }
}

impl Scalar for f32 {
    fn from_f64(value: f64) -> Self {
        value as f32
    }
}

impl Scalar for f64 {
    fn from_f64(value: f64) -> Self {
        value
    }
}

/// Reads a matrix into 32-bit values; `-` is standard input.
///
/// # Errors
/// What is wrong with the file and where, see the module.
pub fn read_matrix(path: &Path) -> Result<MatrixFile<f32>> {
    read(path)
}

/// Reads a matrix into 64-bit values; `-` is standard input.
///
/// # Errors
/// As [`read_matrix`].
pub fn read_matrix_f64(path: &Path) -> Result<MatrixFile<f64>> {
    read(path)
}

fn read<T: Scalar>(path: &Path) -> Result<MatrixFile<T>> {
    if path == Path::new("-") {
        return read_matrix_from(std::io::stdin().lock()).map_err(|e| e.file("standard input"));
    }
    let file = File::open(path).map_err(|e| Error::io(path, &e))?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err(Error::new("this is a folder, not a matrix file").file(path));
    }
    read_matrix_from(file).map_err(|e| e.file(path))
}

/// Reads a matrix from a stream up to its end. Memory: the matrix itself, grown as data arrive
/// whatever the header promises, and a buffer of 1 MiB.
///
/// # Errors
/// As [`read_matrix`], without the file's name.
pub fn read_matrix_from<T: Scalar>(stream: impl Read) -> Result<MatrixFile<T>> {
    let mut stream = BufReader::with_capacity(1 << 20, stream);
    let (header, lines_read) = Header::read(&mut stream)?;
    let cols = header.cols.ok_or_else(|| {
        Error::new("the header has no NCOLS").field("NCOLS").help("add the line NCOLS=… for the number of columns before FORMAT")
    })?;
    let components = header.components;
    let row_len = cols.checked_mul(components).ok_or_else(|| Error::new("rows of this length do not fit into memory").field("NCOLS"))?;
    let expected = match header.rows {
        Some(rows) => Some(rows.checked_mul(row_len).ok_or_else(|| Error::new("this many rows do not fit into memory").field("NROWS"))?),
        None => None,
    };
    let mut values = Values::new(row_len, components, expected);
    match header.format.width() {
        None => values.read_text(&mut stream, lines_read)?,
        Some(width) => values.read_binary(&mut stream, width, header.big_endian)?,
    }
    let rows = values.check_count(header.rows)?;
    header.undo_exposure(&mut values.data);
    let matrix = Matrix::from_data(rows, cols, components, values.data)?;
    Ok(MatrixFile { matrix, header: header.kept })
}

#[cfg(test)]
mod tests;

//! Writing matrix files.

use super::header::header_text;
use super::{Format, Scalar};
use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::matrix::Matrix;
use std::io::Write;
use std::path::Path;

/// Writes a matrix to a file (atomically), or to standard output where `path` is absent or `-`.
///
/// `header` holds further header lines without line ends (the program's own line, LATLONG=, …);
/// lines about size and storage among them are left out, this function writes its own.
///
/// # Errors
/// A header line that would end the header, a value that overflows the format, and failures of the
/// file system with the path named.
pub fn write_matrix<T: Scalar>(path: Option<&Path>, matrix: &Matrix<T>, format: Format, header: &[String]) -> Result<()> {
    match path {
        Some(path) if path != Path::new("-") => {
            write_atomically(path, |out| write_matrix_to(out, matrix, format, header).map_err(|e| e.file(path)))
        }
        _ => {
            let mut out = std::io::BufWriter::with_capacity(1 << 20, std::io::stdout().lock());
            write_matrix_to(&mut out, matrix, format, header)
                .and_then(|()| out.flush().map_err(|e| Error::stream(&e)))
                .map_err(|e| e.file("standard output"))
        }
    }
}

/// Writes a matrix to a stream. Binary values are little-endian and start on a multiple of their
/// size, as Radiance's own files do, so that its programs can map them into memory.
///
/// # Errors
/// As [`write_matrix`], without the file's name.
pub fn write_matrix_to<T: Scalar>(out: &mut dyn Write, matrix: &Matrix<T>, format: Format, header: &[String]) -> Result<()> {
    let failed = |e: std::io::Error| Error::stream(&e);
    let shape = [matrix.rows(), matrix.cols(), matrix.components()];
    out.write_all(header_text(shape, format, header)?.as_bytes()).map_err(failed)?;
    let row_len = matrix.cols() * matrix.components();
    let mut bytes = Vec::new();
    for row in 0..matrix.rows() {
        bytes.clear();
        for (i, &value) in matrix.row(row).iter().enumerate() {
            match format {
                Format::Double => bytes.extend_from_slice(&value.to_f64().to_le_bytes()),
                Format::Float => {
                    let single = value.to_f64() as f32;
                    if single.is_infinite() && value.to_f64().is_finite() {
                        return Err(Error::new(format!("the value {:e} in row {} is too large for format float", value.to_f64(), row + 1))
                            .help("write format double or ascii"));
                    }
                    bytes.extend_from_slice(&single.to_le_bytes());
                }
                Format::Ascii => {
                    // The shortest text that reads back to the same value.
                    write!(bytes, "{value:e}").map_err(failed)?;
                    bytes.push(match i + 1 {
                        n if n == row_len => b'\n',
                        n if n % matrix.components() == 0 => b'\t',
                        _ => b' ',
                    });
                }
            }
        }
        out.write_all(&bytes).map_err(failed)?;
    }
    Ok(())
}

/// Writes the header of a float matrix whose rows follow piece by piece, each value little-endian:
/// for matrices that are never in memory as a whole.
///
/// # Errors
/// As [`write_matrix_to`].
pub fn write_float_header(out: &mut dyn Write, [rows, cols, components]: [usize; 3], header: &[String]) -> Result<()> {
    let text = header_text([rows, cols, components], Format::Float, header)?;
    out.write_all(text.as_bytes()).map_err(|e| Error::stream(&e))
}

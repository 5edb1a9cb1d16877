//! Matrix files read a few rows at a time, for matrices larger than memory.

use super::file::{Format, Header};
use crate::error::{Error, Result};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// A binary matrix file of which only the wanted rows are in memory. Text files have to be read
/// whole, see [`super::file::read_matrix`].
#[derive(Debug)]
pub struct MatrixRows {
    path: PathBuf,
    stream: BufReader<File>,
    header: Header,
    rows: usize,
    cols: usize,
    width: usize,
    start: u64,
    next: usize,
}

impl MatrixRows {
    /// Opens a file of format `float` or `double`; `None` if its format is `ascii`.
    ///
    /// # Errors
    /// A file that cannot be read or is no matrix, or whose size is not that of its rows.
    pub fn open(path: &Path) -> Result<Option<Self>> {
        let file = File::open(path).map_err(|e| Error::io(path, &e))?;
        let length = file.metadata().map_err(|e| Error::io(path, &e))?.len();
        let mut stream = BufReader::with_capacity(1 << 20, file);
        let (header, _) = Header::read(&mut stream).map_err(|e| e.file(path))?;
        let Some(width) = header.format.width() else { return Ok(None) };
        let start = stream.stream_position().map_err(|e| Error::io(path, &e))?;
        let fail = |message: String| Error::new(message).file(path);
        let cols = header.cols.ok_or_else(|| fail("the header has no NCOLS".into()).field("NCOLS"))?;
        let row = (cols as u64)
            .checked_mul(header.components as u64)
            .and_then(|n| n.checked_mul(width as u64))
            .ok_or_else(|| fail("rows of this length do not fit into memory".into()).field("NCOLS"))?;
        let data = length.saturating_sub(start);
        let rows = header.rows.unwrap_or((data / row) as usize);
        if (rows as u64).checked_mul(row) != Some(data) {
            return Err(fail(format!("{rows} rows of {row} bytes should follow the header, there are {data} bytes"))
                .field("NROWS")
                .help("the file was cut off or its header is wrong; make it again"));
        }
        Ok(Some(Self { path: path.to_path_buf(), stream, header, rows, cols, width, start, next: 0 }))
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Values per entry.
    pub fn components(&self) -> usize {
        self.header.components
    }

    /// Header lines, as in [`super::file::MatrixFile`].
    pub fn header(&self) -> &[String] {
        &self.header.kept
    }

    /// Goes back to the first row.
    ///
    /// # Errors
    /// Failures of the file system.
    pub(crate) fn rewind(&mut self) -> Result<()> {
        self.go_to(0)
    }

    /// Goes to a row, or behind the last.
    ///
    /// # Errors
    /// Failures of the file system.
    pub fn go_to(&mut self, row: usize) -> Result<()> {
        self.next = row.min(self.rows);
        let bytes = (self.cols * self.header.components * self.width) as u64;
        self.stream.seek(SeekFrom::Start(self.start + self.next as u64 * bytes)).map_err(|e| Error::io(&self.path, &e))?;
        Ok(())
    }

    /// Reads the next `count` rows (fewer at the end) into `out`, whose former contents go; gives
    /// their number, 0 after the last.
    ///
    /// # Errors
    /// Failures of the file system, and values that are not finite (with row and column).
    pub fn read(&mut self, count: usize, out: &mut Vec<f32>) -> Result<usize> {
        let count = count.min(self.rows - self.next);
        let row = self.cols * self.header.components;
        out.clear();
        // A file without rows may state any length of them.
        if count == 0 {
            return Ok(0);
        }
        out.reserve(count * row);
        let mut bytes = vec![0; row * self.width];
        for _ in 0..count {
            self.stream.read_exact(&mut bytes).map_err(|e| Error::io(&self.path, &e).field(format!("row {}", self.next + 1)))?;
            let before = out.len();
            let big = self.header.big_endian;
            match self.header.format {
                Format::Double => out.extend(bytes.as_chunks().0.iter().map(|b| {
                    let value = if big { f64::from_be_bytes(*b) } else { f64::from_le_bytes(*b) };
                    value as f32
                })),
                _ => out.extend(bytes.as_chunks().0.iter().map(|b| if big { f32::from_be_bytes(*b) } else { f32::from_le_bytes(*b) })),
            }
            if let Some(at) = out[before..].iter().position(|v| !v.is_finite()) {
                let place = format!("row {}, column {}", self.next + 1, at / self.header.components + 1);
                return Err(Error::new(format!("the value of {place} is not finite"))
                    .file(&self.path)
                    .help("something went wrong where this matrix was made; make it again"));
            }
            self.next += 1;
        }
        self.header.undo_exposure(out);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::Matrix;
    use crate::matrix::file::{read_matrix, write_matrix};

    #[test]
    fn rows_are_those_of_the_whole_matrix() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.mtx");
        let matrix = Matrix::from_data(7, 3, 2, (0..42).map(|i| i as f32 * 0.37 - 3.0).collect()).unwrap();
        for format in [Format::Float, Format::Double] {
            write_matrix(Some(&path), &matrix, format, &["VIEW= -vta".into()]).unwrap();
            let mut rows = MatrixRows::open(&path).unwrap().unwrap();
            assert_eq!((rows.rows(), rows.cols(), rows.components()), (7, 3, 2));
            assert_eq!(rows.header(), ["VIEW= -vta"]);
            for count in [1, 3, 7, 100] {
                rows.rewind().unwrap();
                let (mut all, mut part) = (Vec::new(), Vec::new());
                while rows.read(count, &mut part).unwrap() > 0 {
                    all.extend_from_slice(&part);
                }
                assert_eq!(all, read_matrix(&path).unwrap().matrix.into_data());
            }
            let mut part = Vec::new();
            for row in [5, 0, 6, 3] {
                rows.go_to(row).unwrap();
                assert_eq!((rows.read(1, &mut part).unwrap(), &*part), (1, matrix.row(row)));
            }
            rows.go_to(9).unwrap();
            assert_eq!(rows.read(1, &mut part).unwrap(), 0);
        }
        write_matrix(Some(&path), &matrix, Format::Ascii, &[]).unwrap();
        assert!(MatrixRows::open(&path).unwrap().is_none());
    }

    #[test]
    fn short_files_and_bad_values_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.mtx");
        write_matrix(Some(&path), &Matrix::<f32>::zeros(5, 4, 3), Format::Float, &[]).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 5]).unwrap();
        assert!(MatrixRows::open(&path).unwrap_err().to_string().contains("NROWS"));
        let mut bad = bytes.clone();
        let at = bytes.len() - 4;
        bad[at..].copy_from_slice(&f32::NAN.to_le_bytes());
        std::fs::write(&path, &bad).unwrap();
        let error = MatrixRows::open(&path).unwrap().unwrap().read(5, &mut Vec::new()).unwrap_err().to_string();
        assert!(error.contains("row 5, column 4"), "{error}");
        assert!(MatrixRows::open(&folder.path().join("none")).is_err());
        // No values fill no rows of any length: found by fuzzing.
        std::fs::write(&path, "NCOLS=2\nNCOMP=9223372036854770\nFORMAT=double\n\n").unwrap();
        assert_eq!(MatrixRows::open(&path).unwrap().unwrap().read(16, &mut Vec::new()).unwrap(), 0);
    }
}

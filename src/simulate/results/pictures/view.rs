//! View matrices of pictures: files, component pictures, or a matrix beside its direct part.

use crate::error::{Error, Result};
use crate::image::hdr::Exposure;
use crate::image::series::{Pattern, PictureSet, SetRows};
use crate::kernels::glare::PixelSource;
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::matrix::rows::MatrixRows;
use std::path::Path;

const RGB: usize = 3;

/// A view matrix with one row per pixel, from the top left, row by row.
pub struct PictureView {
    /// Name in messages.
    name: String,
    source: Source,
    /// Where a [`PixelSource`] goes on in a matrix in memory.
    next_row: usize,
    /// Pixels per row.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// Columns: bins of the window.
    pub bins: usize,
    /// View as Radiance options, if the files tell.
    pub view: Option<String>,
}

enum Source {
    Matrix(Matrix<f32>),
    Rows(MatrixRows),
    Pictures(PictureSet),
    /// V and its direct part Vd: rows V − Vd, then Vd.
    Split(Box<[MatrixRows; 2]>),
}

impl PictureView {
    /// Opens a view matrix: a pattern of component pictures (`v%03d.hdr`), whose EXPOSURE is undone,
    /// or a matrix file, whose header says `RESOLUTION=-Y height +X width` and perhaps `VIEW=`.
    /// `size` (width, height) is for matrices whose header has no resolution.
    ///
    /// # Errors
    /// Files that cannot be read, gaps and different sizes among the pictures, a missing resolution
    /// or one that does not fit the number of rows.
    pub fn open(name: &str, size: Option<[usize; 2]>) -> Result<Self> {
        if Pattern::is_pattern(name) {
            let set = PictureSet::open(&Pattern::parse(name)?, None, Exposure::Undo)?;
            let (width, height, bins, view) = (set.width(), set.height(), set.len(), set.view().map(str::to_string));
            return Ok(Self { name: name.into(), source: Source::Pictures(set), next_row: 0, width, height, bins, view });
        }
        Self::open_matrix(Path::new(name), size)
    }

    /// Opens a matrix file, whatever its name or that of a folder looks like.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub(crate) fn open_matrix(path: &Path, size: Option<[usize; 2]>) -> Result<Self> {
        let rows = if path == Path::new("-") { None } else { MatrixRows::open(path)? };
        let (source, header, rows, bins, components) = match rows {
            Some(r) => {
                let (header, rows, cols, components) = (r.header().to_vec(), r.rows(), r.cols(), r.components());
                (Source::Rows(r), header, rows, cols, components)
            }
            None => {
                let file = read_matrix(path)?;
                let (rows, cols, components) = (file.matrix.rows(), file.matrix.cols(), file.matrix.components());
                (Source::Matrix(file.matrix), file.header, rows, cols, components)
            }
        };
        if components != RGB {
            return Err(Error::new(format!("a view matrix of pictures has 3 components, this one has {components}"))
                .file(path)
                .field("NCOMP"));
        }
        let value = |key: &str| header.iter().rev().find_map(|l| l.strip_prefix(key)?.strip_prefix('=')).map(str::trim);
        let stated = value("RESOLUTION").map(|text| resolution(text).map_err(|e| e.file(path))).transpose()?;
        let [width, height] = stated.or(size).ok_or_else(|| {
            Error::new("the header does not tell the size of the pictures")
                .file(path)
                .field("RESOLUTION")
                .help("make V with 'lucarne matrix view --view', or give the size with -x and -y")
        })?;
        if width.checked_mul(height) != Some(rows) {
            return Err(Error::new(format!("pictures of {width} × {height} pixels need as many rows, there are {rows}"))
                .file(path)
                .field(if stated.is_some() { "RESOLUTION" } else { "-x, -y" }));
        }
        let view = value("VIEW").map(str::to_string);
        Ok(Self { name: path.display().to_string(), source, next_row: 0, width, height, bins, view })
    }

    /// Opens a view matrix and its direct part, both files of this program with the same shape: a
    /// matrix of twice the columns, V − Vd and Vd.
    ///
    /// # Errors
    /// As [`open`](Self::open), and files of different shapes.
    pub(crate) fn open_split(total: &Path, direct: &Path) -> Result<Self> {
        let Self { name, source, width, height, bins, view, .. } = Self::open_matrix(total, None)?;
        let rows = MatrixRows::open(direct)?.filter(|r| (r.rows(), r.cols(), r.components()) == (width * height, bins, RGB));
        let (Source::Rows(total), Some(direct)) = (source, rows) else {
            return Err(Error::new("the direct part of a view matrix has not the shape of the whole").file(direct));
        };
        Ok(Self { name, source: Source::Split(Box::new([total, direct])), next_row: 0, width, height, bins: 2 * bins, view })
    }

    /// Opens a matrix file, beside its direct part if that is given.
    ///
    /// # Errors
    /// As `open_matrix` and `open_split`.
    pub fn open_parts(total: &Path, direct: Option<&Path>) -> Result<Self> {
        direct.map_or_else(|| Self::open_matrix(total, None), |direct| Self::open_split(total, direct))
    }

    /// Goes on with this line of pixels, counted from the top, in files of this program.
    ///
    /// # Errors
    /// A file that cannot be read there.
    ///
    /// # Panics
    /// If there is no such line.
    pub fn go_to(&mut self, line: usize) -> Result<()> {
        let row = line * self.width;
        match &mut self.source {
            Source::Matrix(_) => self.next_row = row,
            Source::Rows(rows) => rows.go_to(row)?,
            Source::Split(both) => both.iter_mut().try_for_each(|rows| rows.go_to(row))?,
            Source::Pictures(_) => return Err(Error::new("component pictures are read from the top only").file(&self.name)),
        }
        Ok(())
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// Name in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn reader(&mut self) -> Result<Reader<'_>> {
        Ok(match &mut self.source {
            Source::Matrix(matrix) => Reader::Matrix(matrix, 0),
            Source::Rows(rows) => {
                rows.rewind()?;
                Reader::Rows(rows)
            }
            Source::Pictures(set) => Reader::Pictures(set.rows()),
            Source::Split(both) => {
                both.iter_mut().try_for_each(MatrixRows::rewind)?;
                Reader::Split(both)
            }
        })
    }
}

impl PixelSource for PictureView {
    fn bins(&self) -> usize {
        self.bins
    }

    fn rewind(&mut self) -> Result<()> {
        self.next_row = 0;
        match &mut self.source {
            Source::Rows(rows) => rows.rewind(),
            Source::Split(both) => both.iter_mut().try_for_each(MatrixRows::rewind),
            Source::Matrix(_) | Source::Pictures(_) => Ok(()),
        }
    }

    fn read(&mut self, lines: usize, width: usize, values: &mut Vec<f32>) -> Result<()> {
        match &mut self.source {
            Source::Matrix(matrix) => {
                let row = matrix.cols() * RGB;
                let end = (self.next_row + lines * width).min(matrix.rows());
                values.clear();
                values.extend_from_slice(&matrix.data()[self.next_row * row..end * row]);
                self.next_row = end;
            }
            Source::Rows(rows) => {
                rows.read(lines * width, values)?;
            }
            Source::Split(both) => read_split(both, lines * width, values)?,
            Source::Pictures(_) => {
                return Err(Error::new("glare is not computed from component pictures").file(&self.name));
            }
        }
        Ok(())
    }
}

/// `-Y height +X width`, the only order of pixels a matrix may have.
pub(super) fn resolution(text: &str) -> Result<[usize; 2]> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let size = match words[..] {
        ["-Y", height, "+X", width] => width.parse().ok().zip(height.parse().ok()).filter(|(w, h)| *w > 0 && *h > 0),
        _ => None,
    };
    size.map(|(width, height)| [width, height]).ok_or_else(|| {
        Error::new(format!("'{text}' is no resolution")).field("RESOLUTION").help("write for instance RESOLUTION=-Y 256 +X 256")
    })
}

/// Reads V from the top.
pub(super) enum Reader<'a> {
    Matrix(&'a Matrix<f32>, usize),
    Rows(&'a mut MatrixRows),
    Pictures(SetRows<'a>),
    Split(&'a mut [MatrixRows; 2]),
}

impl Reader<'_> {
    /// The next `lines` rows of pixels, `[pixel][bin][rgb]`.
    pub(super) fn read(&mut self, lines: usize, width: usize) -> Result<Vec<f32>> {
        let mut values = Vec::new();
        match self {
            Reader::Matrix(matrix, next) => {
                let row = matrix.cols() * RGB;
                let count = (lines * width).min(matrix.rows() - *next);
                values.extend_from_slice(&matrix.data()[*next * row..(*next + count) * row]);
                *next += count;
            }
            Reader::Rows(rows) => {
                rows.read(lines * width, &mut values)?;
            }
            Reader::Pictures(rows) => {
                rows.read(lines, &mut values)?;
            }
            Reader::Split(both) => read_split(both, lines * width, &mut values)?,
        }
        Ok(values)
    }
}

/// The next rows of V − Vd and Vd, side by side.
fn read_split([total, direct]: &mut [MatrixRows; 2], count: usize, values: &mut Vec<f32>) -> Result<()> {
    let (mut all, mut seen_directly) = (Vec::new(), Vec::new());
    total.read(count, &mut all)?;
    direct.read(count, &mut seen_directly)?;
    let row = total.cols() * RGB;
    values.clear();
    values.reserve(2 * all.len());
    for (all, direct) in all.chunks_exact(row).zip(seen_directly.chunks_exact(row)) {
        values.extend(all.iter().zip(direct).map(|(a, s)| (a - s).max(0.0)));
        values.extend_from_slice(direct);
    }
    Ok(())
}

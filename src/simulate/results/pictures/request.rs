//! What pictures are wanted, and where they go.

use crate::error::{Error, Result};
use crate::image::exr;
use crate::image::series::Pattern;
use crate::matrix::Matrix;
use std::path::{Path, PathBuf};

/// Where the pictures go.
#[derive(Debug, Clone)]
pub enum Output {
    /// Radiance pictures, one per hour.
    Hdr(Pattern),
    /// OpenEXR pictures, one per hour.
    Exr(Pattern, exr::Options),
    /// One OpenEXR file with a part `hour_‹number›` per hour.
    ExrParts(PathBuf, exr::Options),
}

impl Output {
    /// The output that a file name means: a pattern or file ending in `.exr`, or a pattern for
    /// Radiance pictures of any other ending.
    ///
    /// # Errors
    /// A name without a place for the hour that is no `.exr` file.
    pub fn parse(name: &str, options: exr::Options) -> Result<Self> {
        let is_exr = Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        match (Pattern::is_pattern(name), is_exr) {
            (true, true) => Ok(Output::Exr(Pattern::parse(name)?, options)),
            (true, false) => Ok(Output::Hdr(Pattern::parse(name)?)),
            (false, true) => Ok(Output::ExrParts(name.into(), options)),
            (false, false) => {
                Err(Error::new(format!("'{name}' has no place for the hour")).field("-o").help("write for instance -o img_%04d.hdr"))
            }
        }
    }

    /// Whether whole pictures have to be in memory until they are written.
    pub(super) fn needs_whole_pictures(&self) -> bool {
        !matches!(self, Output::Hdr(_))
    }
}

/// What to make of a view matrix.
pub struct Request<'a> {
    /// T·D·S or DC·S: `[bin][hour]`, RGB.
    pub coefficients: &'a Matrix<f32>,
    /// Number of each column, for file names.
    pub hours: &'a [usize],
    /// Where the pictures go.
    pub output: &'a Output,
    /// Header lines of all pictures.
    pub header: &'a [String],
    /// Memory for matrices and pictures, bytes.
    pub memory: u64,
    /// What comes on top of the product.
    pub addition: Option<&'a Addition<'a>>,
    /// Is told the numbers of pictures that are complete, some at a time.
    pub finished: Option<&'a dyn Fn(&[usize]) -> Result<()>>,
}

/// A sparse picture for an hour, by its number: pixels in rising order, and RGB radiance.
pub type Addition<'a> = dyn Fn(usize) -> Result<Vec<(u32, [f32; 3])>> + Sync + 'a;

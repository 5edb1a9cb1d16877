//! Pictures: RGBE, EXR, PNG and falsecolour.

pub(crate) mod canvas;
pub mod carpet;
pub(crate) mod drawing;
pub mod exr;
pub mod falsecolor;
pub(crate) mod font;
pub mod hdr;
pub mod hemisphere;
pub(crate) mod legend;
pub mod palette;
pub(crate) mod scatter;
pub mod series;

use crate::error::{Error, Result};
use crate::units::ILLUMINANCE_WEIGHTS;

/// An RGB picture of radiance, W/m²sr: `pixels[y * width + x]`, row 0 on top, column 0 on the left.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// RGB radiance, exposure already undone.
    pub pixels: Vec<[f32; 3]>,
    /// The view it shows as Radiance options (`-vta -vp …`), if the file tells.
    pub view: Option<String>,
    /// Other header lines, kept for writing, without line ends.
    pub header: Vec<String>,
}

impl Picture {
    /// A picture from its pixels.
    ///
    /// # Errors
    /// If the number of pixels does not fit.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Result<Self> {
        if width == 0 || height == 0 || width.checked_mul(height) != Some(pixels.len()) {
            return Err(Error::new(format!("{} pixels do not fill a picture of {width} × {height}", pixels.len())));
        }
        Ok(Self { width, height, pixels, view: None, header: Vec::new() })
    }

    /// Luminance of every pixel, cd/m²: 179 times the weighted sum of its components.
    pub fn luminance(&self) -> Vec<f32> {
        self.pixels.iter().map(|&p| luminance(p)).collect()
    }
}

/// Reads a picture in any format known here: EXR if the name ends in `.exr`, else Radiance's.
///
/// # Errors
/// As [`exr::read`] and [`hdr::read`].
pub fn read(path: &std::path::Path) -> Result<Picture> {
    if is_exr(path) { exr::read(path) } else { hdr::read(path) }
}

/// Whether a name ends in `.exr`.
pub fn is_exr(path: &std::path::Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// Luminance of a colour, cd/m² ([`ILLUMINANCE_WEIGHTS`]).
pub fn luminance(color: [f32; 3]) -> f32 {
    color.iter().zip(ILLUMINANCE_WEIGHTS).map(|(&c, w)| f64::from(c) * w).sum::<f64>() as f32
}

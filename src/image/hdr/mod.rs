//! Radiance pictures (`.hdr`, `.pic`): RGBE and XYZE.
//!
//! The format is that of Radiance's `header.c`, `color.c` and `resolu.c`. Reading understands headers
//! with and without magic number and FORMAT, views in lines of programs, flat, old and
//! new run-length coding, all eight orders of scanlines, EXPOSURE and COLORCORR (undone unless
//! asked otherwise) and XYZE (turned into Radiance's RGB); writing gives the bytes Radiance would
//! write for the same pixels. Round trip: a value comes back within −0.4 … +0.4 % of the largest
//! component, and decoded pixels are encoded to the same bytes again.

mod header;
mod input;
mod scanline;
mod stream;

pub use header::PixelFormat;
pub(crate) use header::{Header, Orientation};
pub use scanline::from_rgbe;
pub use scanline::to_rgbe;
pub(crate) use stream::{Pause, ScanlineReader, ScanlineWriter};

use super::Picture;
use crate::error::Result;
use crate::files;
use crate::units::LUMINOUS_EFFICACY;
use glam::{DMat3, DVec3};
use std::io::Read;
use std::path::Path;

/// What to do with the EXPOSURE and COLORCORR lines of a header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exposure {
    /// Divide the pixels by them and drop the lines: radiance comes out (`pvalue -o`).
    Undo,
    /// Leave pixels and lines as they are.
    Keep,
}

/// Reads a picture, exposure undone.
///
/// # Errors
/// If the file cannot be read, is no picture, or is truncated or damaged (with scanline and byte).
pub fn read(path: &Path) -> Result<Picture> {
    read_with(path, Exposure::Undo)
}

/// Reads a picture with a choice of what to do with its exposure.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: &Path, exposure: Exposure) -> Result<Picture> {
    collect(ScanlineReader::open(path, exposure)?)
}

/// Decodes a picture in memory; otherwise as [`read_with`].
///
/// # Errors
/// As [`read`].
pub fn decode(bytes: &[u8], exposure: Exposure) -> Result<Picture> {
    collect(ScanlineReader::new(bytes, Path::new(""), exposure)?)
}

fn collect(mut reader: ScanlineReader<impl Read>) -> Result<Picture> {
    let Header { width, height, orientation, .. } = *reader.header();
    let (count, length) = reader.header().scanlines();
    let mut row = vec![[0.0; 3]; length];
    // The memory grows with what the file holds, not with what its resolution promises.
    let mut pixels = Vec::new();
    for _ in 0..count {
        reader.read(&mut row)?;
        pixels.extend_from_slice(&row);
    }
    if orientation == Orientation::STANDARD {
        pixels.shrink_to_fit();
    } else {
        let stored = std::mem::replace(&mut pixels, vec![[0.0; 3]; width * height]);
        for (at, pixel) in stored.into_iter().enumerate() {
            let (x, y) = orientation.place(at / length, at % length, width, height);
            pixels[y * width + x] = pixel;
        }
    }
    let mut picture = Picture::new(width, height, pixels)?;
    picture.view.clone_from(&reader.header().view);
    picture.header = reader.kept_lines();
    Ok(picture)
}

impl<R: Read> ScanlineReader<R> {
    /// Header lines that belong to the pixels as they are read: without EXPOSURE and COLORCORR if
    /// those are undone.
    pub(crate) fn kept_lines(&self) -> Vec<String> {
        let keep = self.exposure() == Exposure::Keep;
        self.header().lines.iter().filter(|line| keep || !header::is_exposure(line)).cloned().collect()
    }
}

/// Writes a picture, run-length encoded, complete or not at all.
///
/// # Errors
/// If writing fails or a pixel is not finite.
pub fn write(path: &Path, picture: &Picture) -> Result<()> {
    files::write_atomically(path, |out| write_to(out, path, picture))
}

/// A picture file that is written row by row, and that appears under its name only when complete:
/// call `ScanlineWriter::finish`, then [`files::AtomicFile::commit`] on what it gives back.
///
/// # Errors
/// As `ScanlineWriter::new`, and failures of the file system.
pub fn create(path: &Path, width: usize, height: usize, view: Option<&str>, lines: &[String]) -> Result<ScanlineWriter<files::AtomicFile>> {
    ScanlineWriter::new(files::AtomicFile::create(path, 1 << 16)?, path, width, height, view, lines)
}

/// Encodes a picture in memory.
///
/// # Errors
/// If a pixel is not finite.
#[cfg(test)]
pub(crate) fn encode(picture: &Picture) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_to(&mut bytes, Path::new("picture"), picture)?;
    Ok(bytes)
}

fn write_to(out: impl std::io::Write, path: &Path, picture: &Picture) -> Result<()> {
    let mut writer = ScanlineWriter::new(out, path, picture.width, picture.height, picture.view.as_deref(), &picture.header)?;
    for row in picture.pixels.chunks_exact(picture.width) {
        writer.write(row)?;
    }
    writer.finish()?;
    Ok(())
}

/// Chromaticities of Radiance's red, green, blue primaries (`STDPRIMS` in `color.h`).
pub(super) const PRIMARIES: [[f64; 2]; 3] = [[0.640, 0.330], [0.290, 0.600], [0.150, 0.060]];

/// Chromaticity of its white, the equal-energy point to four digits.
pub(super) const WHITE: [f64; 2] = [0.3333, 0.3333];

/// Radiance's RGB to XYZ with Y(1, 1, 1) = 1; its second row is
/// [`crate::units::BRIGHTNESS_WEIGHTS`].
fn rgb_to_xyz_matrix() -> DMat3 {
    let of_unit_luminance = |[x, y]: [f64; 2]| DVec3::new(x, y, 1.0 - x - y) / y;
    let columns = PRIMARIES.map(of_unit_luminance);
    let unscaled = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let scale = unscaled.inverse() * of_unit_luminance(WHITE);
    unscaled * DMat3::from_diagonal(scale)
}

/// XYZ in cd/m² to RGB radiance. Colours outside Radiance's gamut keep their negative component
/// (`ra_xyze -r` greys them), so that luminance is exact.
fn xyz_to_rgb(pixels: &mut [[f32; 3]]) {
    let matrix = rgb_to_xyz_matrix().inverse() * (1.0 / LUMINOUS_EFFICACY);
    for pixel in pixels {
        let rgb = matrix * DVec3::from(pixel.map(f64::from));
        *pixel = rgb.to_array().map(|v| v as f32);
    }
}

#[cfg(test)]
mod tests;

//! Numbered pictures `name%03d.hdr`: view matrices as component pictures, and one picture per hour.
//!
//! As a matrix, a set has one row per pixel (from the top left, row by row) and one column per
//! picture, as Radiance's `dctimestep` takes it: column 0 is picture 0.

mod pattern;

pub use pattern::Pattern;

use super::hdr::{self, Exposure, Pause, ScanlineReader};
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::path::PathBuf;

/// A complete set of component pictures 0, 1, … of one size.
#[derive(Debug, Clone)]
pub(crate) struct PictureSet {
    paths: Vec<PathBuf>,
    starts: Vec<Pause>,
    width: usize,
    height: usize,
    view: Option<String>,
}

impl PictureSet {
    /// Reads the headers of all pictures of a pattern. With `count`, exactly as many must be there.
    ///
    /// # Errors
    /// No picture, a gap in the numbers, another number of pictures than wanted, different sizes,
    /// scanlines in an unusual order, or a file that is no picture.
    pub fn open(pattern: &Pattern, count: Option<usize>, exposure: Exposure) -> Result<Self> {
        let numbers = pattern.existing()?;
        let Some(&last) = numbers.last() else {
            return Err(Error::new(format!("there are no pictures {pattern}, the first should be {}", pattern.path(0).display())));
        };
        if let Some(gap) = (0..=last).zip(&numbers).find_map(|(wanted, &found)| (wanted != found).then_some(wanted)) {
            return Err(Error::new(format!("{} is missing, but there is {}", pattern.path(gap).display(), pattern.path(last).display()))
                .help("the pictures of a set are numbered from 0 without gaps"));
        }
        if let Some(count) = count.filter(|&c| c != numbers.len()) {
            return Err(Error::new(format!("{pattern} has {} pictures instead of {count}", numbers.len()))
                .help("a view matrix has one picture per direction of the window's basis, 145 for Klems full"));
        }
        let paths: Vec<PathBuf> = numbers.iter().map(|&n| pattern.path(n)).collect();
        let starts: Vec<Pause> =
            paths.iter().map(|p| ScanlineReader::open(p, exposure).map(ScanlineReader::pause)).collect::<Result<_>>()?;
        let first = starts[0].header();
        let (width, height, view) = (first.width, first.height, first.view.clone());
        for (path, start) in paths.iter().zip(&starts) {
            let header = start.header();
            if (header.width, header.height) != (width, height) {
                return Err(Error::new(format!(
                    "it has {} × {} pixels, but {} has {width} × {height}",
                    header.width,
                    header.height,
                    paths[0].display()
                ))
                .file(path));
            }
            if header.orientation != hdr::Orientation::STANDARD {
                return Err(Error::new("its scanlines are not in the order -Y +X")
                    .file(path)
                    .help("turn it with Radiance's pflip or protate"));
            }
        }
        Ok(Self { paths, starts, width, height, view })
    }

    /// Number of pictures.
    pub fn len(&self) -> usize {
        self.paths.len()
    }

    /// Pixels per row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// View of the first picture as Radiance options.
    pub fn view(&self) -> Option<&str> {
        self.view.as_deref()
    }

    /// Starts reading from the top.
    pub fn rows(&self) -> SetRows<'_> {
        SetRows { set: self, places: self.starts.clone(), next: 0 }
    }
}

/// Reads a [`PictureSet`] a few rows of pixels at a time, so that no matrix is in memory as a whole.
#[derive(Debug)]
pub(crate) struct SetRows<'a> {
    set: &'a PictureSet,
    places: Vec<Pause>,
    next: usize,
}

impl SetRows<'_> {
    /// Reads the next `rows` rows of pixels (fewer at the end) as rows of a matrix:
    /// `out[(pixel * pictures + picture) * 3 + component]`. Gives the number of rows of pixels
    /// read; 0 after the last.
    ///
    /// # Errors
    /// If a file is truncated, damaged or gone.
    pub fn read(&mut self, rows: usize, out: &mut Vec<f32>) -> Result<usize> {
        let rows = rows.min(self.set.height - self.next);
        let (width, count) = (self.set.width, self.set.len());
        let pixels = rows * width;
        out.clear();
        out.resize(pixels * count * 3, 0.0);
        if rows == 0 {
            return Ok(0);
        }
        // A bounded number of pictures at a time: their rows are decoded in parallel, then laid
        // into the matrix.
        let group = (16 * rayon::current_num_threads()).min(count);
        for first in (0..count).step_by(group) {
            let last = (first + group).min(count);
            let decoded: Vec<Vec<[f32; 3]>> = self.places[first..last]
                .par_iter_mut()
                .zip(&self.set.paths[first..last])
                .map(|(place, path)| {
                    let mut reader = place.resume(path)?;
                    let mut buffer = vec![[0f32; 3]; pixels];
                    buffer.chunks_exact_mut(width).try_for_each(|row| reader.read(row))?;
                    *place = reader.pause();
                    Ok(buffer)
                })
                .collect::<Result<_>>()?;
            out.par_chunks_exact_mut(count * 3).enumerate().for_each(|(pixel, row)| {
                for (target, picture) in row[first * 3..last * 3].chunks_exact_mut(3).zip(&decoded) {
                    target.copy_from_slice(&picture[pixel]);
                }
            });
        }
        self.next += rows;
        Ok(rows)
    }
}

/// Writes a matrix of pixels × pictures, given a few rows of pixels at a time, as numbered
/// pictures. All files appear at the end, or none.
pub struct SetWriter {
    writers: Vec<hdr::ScanlineWriter<crate::files::AtomicFile>>,
    width: usize,
}

impl SetWriter {
    /// Creates `count` pictures numbered from 0; `lines` gives the header lines of each.
    ///
    /// # Errors
    /// Failures of the file system, among them too many open files.
    pub fn create(
        pattern: &Pattern,
        count: usize,
        [width, height]: [usize; 2],
        view: Option<&str>,
        lines: impl Fn(usize) -> Vec<String>,
    ) -> Result<Self> {
        let writers = (0..count).map(|n| hdr::create(&pattern.path(n), width, height, view, &lines(n))).collect::<Result<_>>()?;
        Ok(Self { writers, width })
    }

    /// Writes rows of pixels: `values[(pixel * pictures + picture) * 3 + component]`.
    ///
    /// # Errors
    /// If a value is not finite or writing fails.
    ///
    /// # Panics
    /// If the values are not whole rows.
    pub fn write(&mut self, values: &[f32]) -> Result<()> {
        let (count, width) = (self.writers.len(), self.width);
        assert_eq!(values.len() % (width * count * 3), 0, "whole rows of pixels");
        self.writers.par_iter_mut().enumerate().try_for_each(|(picture, writer)| {
            let mut row = vec![[0f32; 3]; width];
            for line in values.chunks_exact(width * count * 3) {
                for (pixel, all) in row.iter_mut().zip(line.chunks_exact(count * 3)) {
                    pixel.copy_from_slice(&all[picture * 3..][..3]);
                }
                writer.write(&row)?;
            }
            Ok(())
        })
    }

    /// Completes all pictures.
    ///
    /// # Errors
    /// If rows are missing or the file system fails.
    pub fn finish(self) -> Result<()> {
        let files = self.writers.into_iter().map(hdr::ScanlineWriter::finish).collect::<Result<Vec<_>>>()?;
        files.into_iter().try_for_each(crate::files::AtomicFile::commit)
    }
}

#[cfg(test)]
mod tests;

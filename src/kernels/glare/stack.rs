//! View matrices of one view made ready for a year of glare: the pixels that can be glare in tiles,
//! and everything that is linear in the picture as one row per quantity.

use super::band::{Band, TILE_HEIGHT, TILE_WIDTH};
use super::blocks::{BlockSums, Blocks};
use super::source::{PixelSource, RGB};
use crate::error::{Error, Result};
use crate::glare::Analyser;
use crate::gpu::allowed;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Values read from all sources at once.
const READ_VALUES: usize = 1 << 23;

/// How a [`Stack`] is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StackOptions {
    /// Memory for the pixels, bytes; what does not fit is read anew for every pass over the hours.
    pub memory: u64,
    /// Whether pixels that see no window can show light all the same, because pictures are added
    /// ([`super::Additions`]).
    pub dark_pixels: bool,
    /// Full width at half maximum (degrees) of the Gaussian that spreads the light of pixels of at
    /// least the peak limit; `None` leaves them as they are.
    pub veil: Option<f64>,
}

impl Default for StackOptions {
    fn default() -> Self {
        Self { memory: 1 << 31, dark_pixels: false, veil: None }
    }
}

/// Rows that turn coefficients into sums over the picture.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    /// Vertical illuminance.
    pub illuminance: Vec<f64>,
    /// Luminance times solid angle.
    pub flux: Vec<f64>,
    /// Mean luminance of the task area; empty without one.
    pub task: Vec<f64>,
    /// Greatest value of any pixel, by size.
    pub greatest: Vec<f64>,
}

/// Sums of matrices V₁·X₁ + V₂·X₂ + … are pictures: the left factors of such a sum for one view.
/// The right ones may change (façade states, hours); see [`super::year`].
pub struct Stack<'s> {
    pub(super) analyser: Arc<Analyser>,
    pub(super) options: StackOptions,
    pub(super) rows: Rows,
    pub(super) blocks: Blocks,
    sources: Mutex<Vec<&'s mut dyn PixelSource>>,
    bins: Vec<usize>,
    grey: bool,
    /// All bands, if they fit the memory.
    bands: Option<Vec<Band>>,
    candidates: usize,
}

impl<'s> Stack<'s> {
    /// Reads the left factors once. Where all three channels of all of them are equal, one channel
    /// is kept.
    ///
    /// # Errors
    /// Failures of the sources; a task area without pixels.
    pub fn new(analyser: Arc<Analyser>, sources: Vec<&'s mut dyn PixelSource>, options: StackOptions) -> Result<Self> {
        let bins: Vec<usize> = sources.iter().map(|s| s.bins()).collect();
        if bins.iter().sum::<usize>() == 0 {
            return Err(Error::new("a picture needs at least one matrix with columns"));
        }
        let blocks = Blocks::new(analyser.geometry());
        let mut stack = Self {
            analyser,
            options,
            rows: Rows::default(),
            blocks,
            sources: Mutex::new(sources),
            bins,
            grey: true,
            bands: None,
            candidates: 0,
        };
        if !stack.fill()? {
            stack.grey = false;
            stack.fill()?;
        }
        Ok(stack)
    }

    /// Terms of the sum that is one pixel.
    pub fn terms(&self) -> usize {
        self.bins.iter().sum::<usize>() * if self.grey { 1 } else { RGB }
    }

    /// Columns of each left factor.
    pub fn bins(&self) -> &[usize] {
        &self.bins
    }

    /// Whether one channel stands for all.
    pub fn is_grey(&self) -> bool {
        self.grey
    }

    /// Pixels that can be glare.
    pub fn candidates(&self) -> usize {
        self.candidates
    }

    /// What pictures are judged by.
    pub fn analyser(&self) -> &Analyser {
        &self.analyser
    }

    /// Packs all pixels as the present `grey` says. False if that says grey and a pixel is coloured.
    fn fill(&mut self) -> Result<bool> {
        let terms = self.terms();
        let task = !self.analyser.task_pixels().is_empty();
        self.rows = Rows {
            illuminance: vec![0.0; terms],
            flux: vec![0.0; terms],
            task: if task { vec![0.0; terms] } else { Vec::new() },
            greatest: vec![0.0; terms],
        };
        self.blocks.clear(terms);
        self.candidates = 0;
        let mut kept = Some(Vec::new());
        let mut bytes = 0;
        let mut coloured = false;
        let grey = self.grey;
        let mut read = BandReader::new(self)?;
        while let Some(packed) = read.next(self)? {
            for one in packed {
                if grey && one.coloured {
                    coloured = true;
                    break;
                }
                add(&mut self.rows.illuminance, &one.illuminance);
                add(&mut self.rows.task, &one.task);
                self.blocks.add(&one.blocks);
                self.rows.greatest.iter_mut().zip(&one.greatest).for_each(|(a, &b)| *a = a.max(f64::from(b)));
                self.candidates += one.band.tiles.iter().map(|t| t.used).sum::<usize>();
                bytes += one.band.bytes();
                if bytes > allowed(self.options.memory) {
                    kept = None;
                }
                if let Some(kept) = &mut kept {
                    kept.push(one.band);
                }
            }
            if coloured {
                return Ok(false);
            }
        }
        self.rows.flux = self.blocks.total();
        self.bands = kept;
        Ok(true)
    }

    fn sources(&self) -> MutexGuard<'_, Vec<&'s mut dyn PixelSource>> {
        self.sources.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands over all bands, in groups.
    pub(super) fn for_each_group(&self, f: &mut dyn FnMut(&[Band]) -> Result<()>) -> Result<()> {
        if let Some(bands) = &self.bands {
            return f(bands);
        }
        let mut read = BandReader::new(self)?;
        while let Some(packed) = read.next(self)? {
            let bands: Vec<Band> = packed.into_iter().map(|p| p.band).collect();
            f(&bands)?;
        }
        Ok(())
    }

    /// Bands of this stack, for a detector.
    pub(super) fn bands_of<'b>(&self, bands: &'b [Band]) -> super::Bands<'b> {
        super::Bands { bands, terms: self.terms(), width: self.analyser.geometry().width }
    }

    /// All bands, if they are in memory.
    pub(super) fn resident(&self) -> Option<&[Band]> {
        self.bands.as_deref()
    }

    /// The terms of a pixel from its values in all factors; true if a channel differs from another
    /// although only one is kept.
    fn fill_row(&self, values: &[&[f32]], row: &mut [f32]) -> bool {
        let mut coloured = false;
        let mut first = 0;
        for v in values {
            if self.grey {
                for (term, rgb) in row[first..].iter_mut().zip(v.as_chunks::<RGB>().0) {
                    coloured |= rgb[0] != rgb[1] || rgb[1] != rgb[2];
                    *term = rgb[0];
                }
                first += v.len() / RGB;
            } else {
                row[first..first + v.len()].copy_from_slice(v);
                first += v.len();
            }
        }
        coloured
    }

    /// One band from its lines of all factors.
    fn pack(&self, first_line: usize, parts: &[&[f32]]) -> Packed {
        let geometry = self.analyser.geometry();
        let (width, terms) = (geometry.width, self.terms());
        let lines = parts[0].len() / (self.bins[0] * RGB * width);
        let mut out = Packed {
            band: Band::new(first_line),
            illuminance: vec![0.0; terms],
            task: vec![0.0; self.rows.task.len()],
            greatest: vec![0.0; terms],
            blocks: self.blocks.sums(first_line, lines, terms),
            coloured: false,
        };
        let task = self.analyser.task_pixels();
        let task_solid_angle = crate::glare::disc::task_solid_angle(geometry, task);
        let mut row = vec![0.0f32; terms];
        let mut values: Vec<&[f32]> = Vec::with_capacity(parts.len());
        for left in (0..width).step_by(TILE_WIDTH) {
            out.band.begin_tile();
            for place in (0..lines).flat_map(|line| (left..(left + TILE_WIDTH).min(width)).map(move |x| line * width + x)) {
                let pixel = first_line * width + place;
                if !geometry.is_inside(pixel) {
                    continue;
                }
                values.clear();
                values.extend(parts.iter().zip(&self.bins).map(|(p, &b)| &p[place * b * RGB..][..b * RGB]));
                let lit = values.iter().any(|v| v.iter().any(|&x| x != 0.0));
                if lit {
                    out.coloured |= self.fill_row(&values, &mut row);
                    add_scaled(&mut out.illuminance, &row, geometry.projected_solid_angles[pixel]);
                    out.blocks.add_pixel(&self.blocks, pixel, &row, geometry.solid_angles[pixel]);
                    if !task.is_empty() && task.binary_search(&(pixel as u32)).is_ok() {
                        add_scaled(&mut out.task, &row, geometry.solid_angles[pixel] / task_solid_angle);
                    }
                    out.greatest.iter_mut().zip(&row).for_each(|(a, &b)| *a = a.max(b.abs()));
                }
                let seen = self.options.veil.is_some() || self.analyser.searched()[pixel];
                if seen && (lit || self.options.dark_pixels) {
                    if !lit {
                        row.fill(0.0);
                    }
                    out.band.put(pixel, &row);
                }
            }
            out.band.end_tile();
        }
        out
    }
}

/// A band and its part of all sums.
struct Packed {
    band: Band,
    illuminance: Vec<f64>,
    task: Vec<f64>,
    greatest: Vec<f32>,
    blocks: BlockSums,
    coloured: bool,
}

/// Reads several bands at a time and packs them side by side.
struct BandReader {
    line: usize,
    lines_at_once: usize,
    buffers: Vec<Vec<f32>>,
}

impl BandReader {
    fn new(stack: &Stack<'_>) -> Result<Self> {
        for source in stack.sources().iter_mut() {
            source.rewind()?;
        }
        let per_line = stack.bins.iter().sum::<usize>() * RGB * stack.analyser.geometry().width;
        let lines = (READ_VALUES / per_line.max(1)).next_multiple_of(TILE_HEIGHT).max(TILE_HEIGHT);
        Ok(Self { line: 0, lines_at_once: lines, buffers: vec![Vec::new(); stack.bins.len()] })
    }

    fn next(&mut self, stack: &Stack<'_>) -> Result<Option<Vec<Packed>>> {
        let (width, height) = (stack.analyser.geometry().width, stack.analyser.geometry().height);
        let lines = self.lines_at_once.min(height - self.line);
        if lines == 0 {
            return Ok(None);
        }
        for ((source, buffer), &bins) in stack.sources().iter_mut().zip(&mut self.buffers).zip(&stack.bins) {
            source.read(lines, width, buffer)?;
            if buffer.len() != lines * width * bins * RGB {
                return Err(Error::new(format!(
                    "line {} of the view's {height}: the view matrix has fewer rows than the {width} × {height} pixels",
                    self.line + 1
                )));
            }
        }
        let first = self.line;
        let packed = (0..lines.div_ceil(TILE_HEIGHT))
            .into_par_iter()
            .map(|band| {
                let from = band * TILE_HEIGHT;
                let to = (from + TILE_HEIGHT).min(lines);
                let parts: Vec<&[f32]> =
                    self.buffers.iter().zip(&stack.bins).map(|(b, &bins)| &b[from * width * bins * RGB..to * width * bins * RGB]).collect();
                stack.pack(first + from, &parts)
            })
            .collect();
        self.line += lines;
        Ok(Some(packed))
    }
}

fn add(sum: &mut [f64], values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(s, v)| *s += v);
}

fn add_scaled(sum: &mut [f64], values: &[f32], factor: f64) {
    sum.iter_mut().zip(values).for_each(|(s, &v)| *s += factor * f64::from(v));
}

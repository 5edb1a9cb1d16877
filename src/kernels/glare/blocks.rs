//! The view in a coarse grid of blocks: what the noise of many pixels does to the light of a source
//! is measured on means over blocks.

use crate::glare::PixelGeometry;

/// Blocks along each side of the picture.
const GRID: usize = 32;

/// Rows of V summed over blocks, weighted by solid angle.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    width: usize,
    height: usize,
    solid_angles: Vec<f64>,
    terms: usize,
    /// `[block][term]`
    sums: Vec<f64>,
}

impl Blocks {
    /// The blocks of a view.
    pub(super) fn new(geometry: &PixelGeometry) -> Self {
        let mut blocks =
            Self { width: geometry.width, height: geometry.height, solid_angles: vec![0.0; GRID * GRID], terms: 0, sums: Vec::new() };
        for pixel in 0..geometry.pixel_count() {
            let block = blocks.of(pixel);
            blocks.solid_angles[block] += geometry.solid_angles[pixel];
        }
        blocks
    }

    /// Number of blocks, empty ones included.
    pub(super) fn count(&self) -> usize {
        GRID * GRID
    }

    /// The block of a pixel.
    pub(super) fn of(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.width, pixel / self.width);
        (y * GRID / self.height) * GRID + x * GRID / self.width
    }

    /// Solid angle of a block's pixels, sr.
    pub(super) fn solid_angle(&self, block: usize) -> f64 {
        self.solid_angles[block]
    }

    pub(super) fn clear(&mut self, terms: usize) {
        self.terms = terms;
        self.sums = vec![0.0; self.count() * terms];
    }

    /// Sums for some lines of pixels, to be added later.
    pub(super) fn sums(&self, first_line: usize, lines: usize, terms: usize) -> BlockSums {
        let first = first_line * GRID / self.height;
        let last = (first_line + lines - 1) * GRID / self.height;
        BlockSums { first: first * GRID, terms, sums: vec![0.0; (last - first + 1) * GRID * terms] }
    }

    pub(super) fn add(&mut self, part: &BlockSums) {
        let at = part.first * self.terms;
        self.sums[at..at + part.sums.len()].iter_mut().zip(&part.sums).for_each(|(s, v)| *s += v);
    }

    /// Sum of a block, one value per term.
    pub(super) fn of_block(&self, block: usize) -> &[f64] {
        &self.sums[block * self.terms..(block + 1) * self.terms]
    }

    /// Sum of all blocks.
    pub(super) fn total(&self) -> Vec<f64> {
        let mut total = vec![0.0; self.terms];
        for block in self.sums.chunks_exact(self.terms.max(1)) {
            total.iter_mut().zip(block).for_each(|(t, v)| *t += v);
        }
        total
    }
}

/// A part of [`Blocks`]' sums.
pub(super) struct BlockSums {
    first: usize,
    terms: usize,
    sums: Vec<f64>,
}

impl BlockSums {
    pub(super) fn add_pixel(&mut self, blocks: &Blocks, pixel: usize, row: &[f32], solid_angle: f64) {
        let at = (blocks.of(pixel) - self.first) * self.terms;
        self.sums[at..at + self.terms].iter_mut().zip(row).for_each(|(s, &v)| *s += solid_angle * f64::from(v));
    }
}

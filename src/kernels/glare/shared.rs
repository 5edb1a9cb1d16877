//! Noise that the pixels of added light share, such as that of the few points of a pane that all of them
//! see: by how much independent batches differ, at the eye and block by block.

use super::blocks::Blocks;
use crate::glare::PixelGeometry;

/// Deviations of independent batches from their mean. Their sums need only pixels of one picture, while a
/// table of all pairs of pixels that go together would never fit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SharedNoise {
    /// Number of batches; 0 without noise.
    pub batches: usize,
    /// Ascending numbers of rows, and the deviation of each batch: row 0 is the light at the eye (lx), row
    /// 1 + n the luminance of block n times its pixels' solid angles (cd·sr/m²).
    pub rows: Vec<(u32, Vec<f32>)>,
}

impl SharedNoise {
    /// Variance of what changes by so much per lx at the eye, and by so much per cd/m² of the mean luminance
    /// of blocks.
    pub(super) fn variance(&self, by_illuminance: f64, by_block: &[(usize, f64)], blocks: &Blocks) -> f64 {
        if self.batches < 2 {
            return 0.0;
        }
        let mut changes = vec![0.0; self.batches];
        let mut add = |row: usize, factor: f64| {
            let Ok(at) = self.rows.binary_search_by_key(&row, |(number, _)| *number as usize) else { return };
            changes.iter_mut().zip(&self.rows[at].1).for_each(|(sum, v)| *sum += factor * f64::from(*v));
        };
        add(0, by_illuminance);
        for &(block, weight) in by_block {
            add(1 + block, weight / blocks.solid_angle(block));
        }
        changes.iter().map(|c| c * c).sum::<f64>() / (self.batches * (self.batches - 1)) as f64
    }

    /// The noise of light so many times as strong.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        self.rows.iter_mut().flat_map(|(_, row)| row).for_each(|v| *v = (f64::from(*v) * factor) as f32);
        self
    }
}

/// Adds up the batches of single pixels.
#[derive(Debug, Clone)]
pub(crate) struct SharedSums {
    batches: usize,
    /// `[row][batch]`
    sums: Vec<f64>,
}

/// Where pixels are and how much they count.
pub(crate) struct PixelWeights {
    geometry: PixelGeometry,
    blocks: Blocks,
}

impl PixelWeights {
    /// Those of a view.
    pub fn new(geometry: PixelGeometry) -> Self {
        let blocks = Blocks::new(&geometry);
        Self { geometry, blocks }
    }
}

impl SharedSums {
    /// Nothing added yet; without weights nothing ever will be.
    pub fn new(weights: Option<&PixelWeights>, batches: usize) -> Self {
        Self { batches, sums: vec![0.0; weights.map_or(0, |w| 1 + w.blocks.count()) * batches] }
    }

    /// Adds a pixel's luminance in each batch, cd/m².
    ///
    /// # Panics
    /// If there are more or fewer batches, or no such pixel.
    pub fn add(&mut self, weights: &PixelWeights, pixel: usize, luminance: &[f64]) {
        assert_eq!(luminance.len(), self.batches);
        let mean = luminance.iter().sum::<f64>() / self.batches as f64;
        let of_eye = weights.geometry.projected_solid_angles[pixel];
        let of_block = weights.geometry.solid_angles[pixel];
        let row = (1 + weights.blocks.of(pixel)) * self.batches;
        for (batch, luminance) in luminance.iter().enumerate() {
            self.sums[batch] += of_eye * (luminance - mean);
            self.sums[row + batch] += of_block * (luminance - mean);
        }
    }

    /// The noise of all that was added.
    pub fn noise(&self) -> SharedNoise {
        let rows = self.sums.chunks_exact(self.batches.max(1)).map(|row| row.iter().map(|v| *v as f32).collect::<Vec<f32>>());
        let rows: Vec<_> = (0u32..).zip(rows).filter(|(_, row)| row.iter().any(|v| *v != 0.0)).collect();
        SharedNoise { batches: if rows.is_empty() { 0 } else { self.batches }, rows }
    }
}

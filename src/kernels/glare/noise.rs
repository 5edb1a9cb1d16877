//! What the noise of the matrices leaves uncertain in DGP.
//!
//! First order: DGP's change is a sum over the terms, gradient × change of coefficient, where the
//! gradient holds Ev's row and, for each source, the mean row of its pixels (taken from the means
//! over blocks of the view). So everything that is correlated (one noisy entry of D lights Ev and
//! all sources; the light paths of V are shared by all pixels) stays correlated.

use super::blocks::Blocks;
use super::stack::Stack;
use super::year::Year;
use crate::error::{Error, Result};
use crate::glare::Glare;
use crate::glare::index::DgpModel;
use crate::matrix::Matrix;
use crate::units::ILLUMINANCE_WEIGHTS;

/// Noise of all that is not V.
pub trait HourNoise: Sync {
    /// Variance of DGP in the `hour`-th column of the coefficients.
    ///
    /// `gradient` `[bin][rgb]`, for the bins of all right factors in turn: change of DGP by a change
    /// of that coefficient (radiance). `by_given_illuminance`: change of DGP per lx of a vertical
    /// illuminance given from outside; 0 if the picture's own is used.
    fn variance(&self, hour: usize, gradient: &[f64], by_given_illuminance: f64) -> f64;
}

/// Independent estimates of the first columns of the first left factor, reduced to what noise is
/// measured on.
#[derive(Debug, Clone, PartialEq)]
pub struct Batches {
    /// Deviation from the mean, per batch: Ev's row `[term]`.
    illuminance: Vec<Vec<f64>>,
    /// Per batch: sums over blocks `[block][term]`.
    blocks: Vec<Vec<f64>>,
}

/// Adds up rows of pixels of one batch as they are traced.
#[derive(Debug, Clone)]
pub struct BatchSums {
    blocks: Blocks,
    bins: usize,
    /// `[row][bin][rgb]`: row 0 is Ev's, then one per block.
    sums: Vec<f64>,
}

impl BatchSums {
    /// Nothing added yet.
    pub fn new(geometry: &crate::glare::PixelGeometry, bins: usize) -> Self {
        let blocks = Blocks::new(geometry);
        let sums = vec![0.0; (1 + blocks.count()) * bins * 3];
        Self { blocks, bins, sums }
    }

    /// Adds the row `[bin][rgb]` of a pixel.
    ///
    /// # Panics
    /// If the row has another length.
    pub fn add(&mut self, geometry: &crate::glare::PixelGeometry, pixel: usize, row: &[f32]) {
        let width = self.bins * 3;
        assert_eq!(row.len(), width);
        if !geometry.is_inside(pixel) {
            return;
        }
        let block = 1 + self.blocks.of(pixel);
        let (cosine, solid_angle) = (geometry.projected_solid_angles[pixel], geometry.solid_angles[pixel]);
        for (k, &v) in row.iter().enumerate() {
            self.sums[k] += cosine * f64::from(v);
            self.sums[block * width + k] += solid_angle * f64::from(v);
        }
    }

    /// Rows of sums.
    pub fn rows(&self) -> usize {
        1 + self.blocks.count()
    }

    /// The sums, `[row][bin][rgb]`.
    pub fn sums(&self) -> &[f64] {
        &self.sums
    }
}

impl Batches {
    /// From the sums of all batches, one below the other (see [`BatchSums`]).
    ///
    /// # Errors
    /// If the shape is not that of at least two batches of columns that the stack's first factor begins with.
    pub fn new(stack: &Stack<'_>, matrix: &Matrix<f32>) -> Result<Self> {
        let rows = 1 + stack.blocks.count();
        let batches = matrix.rows() / rows;
        let fits = matrix.rows() == rows * batches && matrix.components() == 3 && matrix.cols() <= stack.bins()[0];
        if !fits || batches < 2 {
            return Err(Error::new("the batches of the view matrix do not fit it").help("delete the output folder's matrices"));
        }
        let channels: &[usize] = if stack.is_grey() { &[0] } else { &[0, 1, 2] };
        let terms = matrix.cols() * channels.len();
        // [row][term] of a batch.
        let of = |batch: usize| -> Vec<f64> {
            let values = (0..rows).flat_map(|r| matrix.row(batch * rows + r).as_chunks::<3>().0);
            values.flat_map(|rgb| channels.iter().map(|&c| f64::from(rgb[c]))).collect()
        };
        let mut all: Vec<Vec<f64>> = (0..batches).map(of).collect();
        for i in 0..rows * terms {
            let mean = all.iter().map(|b| b[i]).sum::<f64>() / batches as f64;
            all.iter_mut().for_each(|b| b[i] -= mean);
        }
        Ok(Self {
            blocks: all.iter().map(|b| b[terms..].to_vec()).collect(),
            illuminance: all
                .into_iter()
                .map(|mut b| {
                    b.truncate(terms);
                    b
                })
                .collect(),
        })
    }
}

/// How DGP depends on the light of an hour.
pub(super) struct Slopes {
    /// Change of DGP per lx at the eye.
    by_illuminance: f64,
    /// Block and its part: change of DGP per cd/m² of the block's mean luminance.
    by_block: Vec<(usize, f64)>,
}

impl Slopes {
    pub fn new(glare: &Glare, illuminance: f64, model: &DgpModel, stack: &Stack<'_>) -> Self {
        let contrast = |s: &crate::glare::Source| model.contrast_of((s.luminance, s.solid_angle, s.position_index));
        let sum: f64 = glare.sources.iter().map(contrast).sum();
        let [by_illuminance, by_contrast] = model.slopes(illuminance, sum);
        let mut weights = std::collections::BTreeMap::<usize, f64>::new();
        let solid_angles = &stack.analyser().geometry().solid_angles;
        for source in &glare.sources {
            let by_luminance = by_contrast * model.exponents[0] * contrast(source) / source.luminance;
            for &pixel in &source.pixels {
                *weights.entry(stack.blocks.of(pixel as usize)).or_default() +=
                    by_luminance * solid_angles[pixel as usize] / source.solid_angle;
            }
        }
        Self { by_illuminance, by_block: weights.into_iter().collect() }
    }

    /// The variance of DGP in an hour, whose coefficients are `[term]`.
    pub fn variance(&self, stack: &Stack<'_>, (hour, coefficients): (usize, &[f32]), is_given: bool, request: &Year<'_>) -> f64 {
        let own = if is_given { 0.0 } else { self.by_illuminance };
        let (batches, noise) = (request.batches, request.noise);
        let mut variance = own * own * request.additions.map_or(0.0, |a| a.illuminance_variance(hour));
        if let Some(noise) = noise {
            let mut gradient: Vec<f64> = stack.rows.illuminance.iter().map(|r| own * r).collect();
            for &(block, weight) in &self.by_block {
                let factor = weight / stack.blocks.solid_angle(block);
                gradient.iter_mut().zip(stack.blocks.of_block(block)).for_each(|(g, s)| *g += factor * s);
            }
            let weights = ILLUMINANCE_WEIGHTS;
            let rgb: Vec<f64> = if stack.is_grey() {
                gradient.iter().flat_map(|g| weights.map(|w| w * g)).collect()
            } else {
                gradient.iter().enumerate().map(|(k, g)| weights[k % 3] * g).collect()
            };
            variance += noise.variance(hour, &rgb, if is_given { self.by_illuminance } else { 0.0 });
        }
        if let Some(batches) = batches {
            let count = batches.illuminance.len();
            let terms = batches.illuminance[0].len();
            let times = |row: &[f64]| -> f64 { row.iter().zip(coefficients).map(|(r, &c)| r * f64::from(c)).sum() };
            let mut squares = 0.0;
            for (ev, blocks) in batches.illuminance.iter().zip(&batches.blocks) {
                let mut change = own * times(ev);
                for &(block, weight) in &self.by_block {
                    change += weight / stack.blocks.solid_angle(block) * times(&blocks[block * terms..(block + 1) * terms]);
                }
                squares += change * change;
            }
            variance += squares / (count * (count - 1)) as f64;
        }
        variance
    }
}

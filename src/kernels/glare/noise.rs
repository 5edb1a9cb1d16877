//! What the noise of the matrices leaves uncertain in DGP.
//!
//! First order: DGP's change is a sum over the terms, gradient × change of coefficient, where the
//! gradient holds Ev's row and, for each source, the mean row of its pixels (taken from the means
//! over blocks of the view). So everything that is correlated (one noisy entry of D lights Ev and
//! all sources; the light paths of V are shared by all pixels) stays correlated.

use super::blocks::Blocks;
use super::stack::Stack;
use super::{Added, AddedLight};
use crate::error::{Error, Result};
use crate::glare::{Glare, GlarePixels as Found};
use crate::matrix::Matrix;
use crate::units::ILLUMINANCE_WEIGHTS;
use std::collections::BTreeMap;

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
pub(crate) struct BatchSums {
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

    /// The same, to be set to what they were.
    pub fn sums_mut(&mut self) -> &mut [f64] {
        &mut self.sums
    }
}

impl Batches {
    /// From the sums of all batches, one below the other (see `BatchSums`).
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
    /// Variance of DGP for what it changes per lx at the eye, and per cd/m² of the mean luminance of blocks.
    fn variance(&self, by_illuminance: f64, by_block: &[(usize, f64)], blocks: &Blocks, coefficients: &[f32]) -> f64 {
        let count = self.illuminance.len();
        let terms = self.illuminance[0].len();
        let times = |row: &[f64]| -> f64 { row.iter().zip(coefficients).map(|(r, &c)| r * f64::from(c)).sum() };
        let mut squares = 0.0;
        for (ev, sums) in self.illuminance.iter().zip(&self.blocks) {
            let mut change = by_illuminance * times(ev);
            for &(block, weight) in by_block {
                change += weight / blocks.solid_angle(block) * times(&sums[block * terms..(block + 1) * terms]);
            }
            squares += change * change;
        }
        squares / (count * (count - 1)) as f64
    }
}

/// Where the light of an hour comes from.
#[derive(Clone, Copy)]
pub(super) struct Light<'a> {
    /// Column of the right factors.
    pub hour: usize,
    /// `[term]`
    pub coefficients: &'a [f32],
    /// What is added.
    pub added: &'a Added,
}

/// How DGP depends on the light of an hour.
pub(super) struct Slopes {
    /// Change of DGP per lx of the picture's own vertical illuminance; 0 where another one is given.
    by_own_illuminance: f64,
    /// Change of DGP per lx of the given vertical illuminance; 0 where none is.
    by_given_illuminance: f64,
    /// Change of DGP per unit of its contrast sum.
    by_contrast: f64,
    /// Block and its part: change of DGP per cd/m² of the block's mean luminance.
    by_block: Vec<(usize, f64)>,
    /// Pixels of sources: change of DGP per cd/m² of the pixel's luminance.
    by_pixel: BTreeMap<u32, f64>,
    /// Variance of DGP because the noise of added light takes pixels over the threshold.
    crossing: f64,
}

/// What one standard error more of a disc changes.
pub(super) struct DiscChange {
    /// Light at the eye, lx.
    pub illuminance: f64,
    /// DGP's contrast sum.
    pub contrast: f64,
}

impl Slopes {
    /// Slopes for what was found in an hour with some light; DGP is made from the `given` vertical illuminance
    /// (lx), or else from the picture's own.
    pub fn new(glare: &Glare, given: Option<f64>, stack: &Stack<'_>, added: &[AddedLight], found: Found<'_>) -> Self {
        let model = &stack.analyser().settings().dgp;
        let illuminance = given.unwrap_or(glare.vertical_illuminance);
        let contrast = |s: &crate::glare::Source| model.contrast_of((s.luminance, s.solid_angle, s.position_index));
        let sum: f64 = glare.sources.iter().map(contrast).sum();
        let [by_illuminance, by_contrast] = model.slopes(illuminance, sum);
        let mut weights = BTreeMap::<usize, f64>::new();
        let mut by_pixel = BTreeMap::new();
        let solid_angles = &stack.analyser().geometry().solid_angles;
        let mut crossing = 0.0;
        let all = model.dgp(illuminance, sum);
        for source in &glare.sources {
            let by_luminance = by_contrast * model.exponents[0] * contrast(source) / source.luminance;
            for &pixel in &source.pixels {
                let by_pixel_luminance = by_luminance * solid_angles[pixel as usize] / source.solid_angle;
                *weights.entry(stack.blocks.of(pixel as usize)).or_default() += by_pixel_luminance;
                by_pixel.insert(pixel, by_pixel_luminance);
                let error_of = |a: &AddedLight| f64::from(a.error).hypot(f64::from(a.shared_error));
                let error = added.binary_search_by_key(&pixel, |a| a.pixel).map_or(0.0, |at| error_of(&added[at]));
                let Ok(at) = found.pixels.binary_search(&pixel) else { continue };
                let luminance = f64::from(found.luminance[at]);
                let distance = (luminance - glare.threshold) / error;
                // Farther away than this, hardly any pixel crosses.
                const FAR: f64 = 5.0;
                if !(distance < FAR) {
                    continue;
                }
                let rest = source.solid_angle - solid_angles[pixel as usize];
                let without = if source.pixels.len() > 1 && rest > 0.0 {
                    let luminance = (source.luminance * source.solid_angle - luminance * solid_angles[pixel as usize]) / rest;
                    model.contrast_of((luminance.max(0.0), rest, source.position_index))
                } else {
                    0.0
                };
                let change = all - model.dgp(illuminance, (sum - contrast(source) + without).max(0.0));
                let below = normal_tail(distance);
                // Once for this pixel, once for those that are as far below the threshold.
                crossing += 2.0 * below * (1.0 - below) * change * change;
            }
        }
        let [by_own_illuminance, by_given_illuminance] = if given.is_some() { [0.0, by_illuminance] } else { [by_illuminance, 0.0] };
        Self { by_own_illuminance, by_given_illuminance, by_contrast, by_block: weights.into_iter().collect(), by_pixel, crossing }
    }

    /// The variance of DGP in an hour, by its added light, its discs and the noise of the matrices.
    pub fn variance(
        &self,
        stack: &Stack<'_>,
        light: &Light<'_>,
        discs: &[DiscChange],
        batches: Option<&Batches>,
        noise: Option<&dyn HourNoise>,
    ) -> f64 {
        let own = self.by_own_illuminance;
        let Light { hour, coefficients, added } = *light;
        // A pixel lights the eye and belongs to a source: its two effects go together, pixels do not.
        let cosines = &stack.analyser().geometry().projected_solid_angles;
        let by_added = |a: &AddedLight| {
            let slope = own * cosines[a.pixel as usize] + self.by_pixel.get(&a.pixel).copied().unwrap_or(0.0);
            (slope * f64::from(a.error)).powi(2)
        };
        let mut variance = self.crossing + added.pixels.iter().filter(|a| a.error > 0.0).map(by_added).sum::<f64>();
        variance += added.shared.variance(own, &self.by_block, &stack.blocks);
        // A disc, too, lights the eye and is a source at once.
        variance += discs.iter().map(|d| (own * d.illuminance + self.by_contrast * d.contrast).powi(2)).sum::<f64>();
        if let Some(noise) = noise {
            variance += noise.variance(hour, &self.gradient(stack), self.by_given_illuminance);
        }
        if let Some(batches) = batches {
            variance += batches.variance(own, &self.by_block, &stack.blocks, coefficients);
        }
        variance
    }

    /// Change of DGP by a change of each coefficient, `[bin][rgb]`.
    fn gradient(&self, stack: &Stack<'_>) -> Vec<f64> {
        let mut gradient: Vec<f64> = stack.rows.illuminance.iter().map(|r| self.by_own_illuminance * r).collect();
        for &(block, weight) in &self.by_block {
            let factor = weight / stack.blocks.solid_angle(block);
            gradient.iter_mut().zip(stack.blocks.of_block(block)).for_each(|(g, s)| *g += factor * s);
        }
        let weights = ILLUMINANCE_WEIGHTS;
        if stack.is_grey() {
            gradient.iter().flat_map(|g| weights.map(|w| w * g)).collect()
        } else {
            gradient.iter().enumerate().map(|(k, g)| weights[k % 3] * g).collect()
        }
    }
}

/// Share of a normal distribution beyond `x` standard deviations.
fn normal_tail(x: f64) -> f64 {
    0.5 * libm::erfc(x / std::f64::consts::SQRT_2)
}

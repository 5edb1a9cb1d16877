//! Luminance statistics of parts of a picture: zones around a pixel and the horizontal band, as
//! evalglare's `-l`, `-L` and `-B` define them. They change nothing in the glare.

use super::detect::TaskArea;
use super::geometry::{PixelGeometry, dot};
use crate::error::{Error, Result};

/// A part of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// A round zone.
    Zone(TaskArea),
    /// What is outside a zone of this full opening angle (rad), but inside the larger one.
    Ring(f64, TaskArea),
    /// Pixels no farther than this angle (rad) from the middle row, column by column.
    Band(f64),
}

/// Luminances of a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Its pixels.
    pub pixels: usize,
    /// Their solid angle, sr.
    pub solid_angle: f64,
    /// Mean weighted by solid angle, cd/m².
    pub average: f64,
    /// Standard deviation of the pixels, cd/m².
    pub standard_deviation: f64,
    /// Least, median, 75 and 95 % percentiles, and greatest luminance of the pixels, cd/m².
    pub quantiles: [f64; 5],
    /// Illuminance that it gives at the eye, lx.
    pub illuminance: f64,
}

impl Part {
    /// Its pixels inside the view, ascending.
    ///
    /// # Errors
    /// A centre outside the view, or angles that are none.
    pub fn pixels(&self, geometry: &PixelGeometry) -> Result<Vec<u32>> {
        match *self {
            Self::Zone(area) => area.pixels(geometry),
            Self::Ring(inner, outer) => {
                if inner >= outer.opening_angle {
                    return Err(Error::new(format!(
                        "the outer zone of {} rad is not larger than the inner of {inner} rad",
                        outer.opening_angle
                    ))
                    .help("give the inner opening angle first"));
                }
                let inner = TaskArea { opening_angle: inner, ..outer }.pixels(geometry)?;
                Ok(outer.pixels(geometry)?.into_iter().filter(|p| inner.binary_search(p).is_err()).collect())
            }
            Self::Band(angle) => {
                if !(angle > 0.0 && angle <= std::f64::consts::PI) {
                    return Err(Error::new(format!("{angle} is not an angle between 0 and π rad")).field("band"));
                }
                let (width, height) = (geometry.width, geometry.height);
                let middle = height - 1 - (height - 1) / 2;
                let near = |i: &usize| {
                    let at_middle = middle * width + i % width;
                    *i == at_middle
                        || (geometry.is_inside(at_middle) && dot(geometry.directions[at_middle], geometry.directions[*i]) >= angle.cos())
                };
                Ok((0..geometry.pixel_count()).filter(|&i| geometry.is_inside(i)).filter(near).map(|i| i as u32).collect())
            }
        }
    }

    /// Statistics of a luminance image, cd/m²; nothing of a part without pixels.
    ///
    /// # Errors
    /// As [`pixels`](Self::pixels).
    pub fn statistics(&self, geometry: &PixelGeometry, luminance: &[f32]) -> Result<Option<Statistics>> {
        let pixels = self.pixels(geometry)?;
        let mut values: Vec<f64> = pixels.iter().map(|&p| f64::from(luminance[p as usize])).collect();
        if values.is_empty() {
            return Ok(None);
        }
        let weighted = |weights: &[f64]| pixels.iter().zip(&values).map(|(&p, v)| weights[p as usize] * v).sum::<f64>();
        let solid_angle: f64 = pixels.iter().map(|&p| geometry.solid_angles[p as usize]).sum();
        let (average, illuminance) = (weighted(&geometry.solid_angles) / solid_angle, weighted(&geometry.projected_solid_angles));
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let standard_deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        values.sort_by(f64::total_cmp);
        let last = values.len() - 1;
        // As evalglare: the median, and at percentiles the mean of the values on either side.
        let between = |share: f64| {
            let above = (n * share) as usize;
            0.5 * (values[above.saturating_sub(1)] + values[above.min(last)])
        };
        let median = 0.5 * (values[last / 2] + values[values.len() / 2]);
        let [three_quarters, most] = [0.75, 0.95].map(between);
        let quantiles = [values[0], median, three_quarters, most, values[last]];
        Ok(Some(Statistics { pixels: values.len(), solid_angle, average, standard_deviation, quantiles, illuminance }))
    }
}

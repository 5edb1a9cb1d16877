//! A year of glare without a picture: V·X is multiplied tile by tile, and of each hour only the
//! pixels above the threshold are kept, grouped into sources as if the picture were whole
//! ([`glare::sources`](crate::glare::sources)), and judged.
//!
//! ```text
//! V ──▶ Stack: tiles of 16 × 4 pixels, rows for everything linear (Ev, means)
//! X = T·D·S ──▶ luminance coefficients [hour][term] ──▶ Detector ──▶ glare pixels per hour ──▶ judge
//! ```
//!
//! - Luminance is one sum: V's channels times coefficients that hold the photometric weights. Where
//!   V is grey its one channel meets the weighted sum of the coefficients' three.
//! - A tile is computed only for the hours in which the sum of the greatest value of its pixels, term
//!   by term, could exceed the threshold: an upper bound with room for rounding, so nothing is lost.
//! - Ev, mean luminance and the task's luminance are rows times coefficients, in f64.
//!
//! Two ways behind one trait, [`Detector`]: [`Native`] and [`OnDevice`]. The same input gives the
//! same bits for any number of hours in a pass and any memory.

mod band;
mod blocks;
mod device;
mod native;
mod noise;
pub mod reference;
mod shared;
mod source;
mod stack;
mod year;

pub use device::OnDevice;
pub use native::Native;
pub(crate) use noise::BatchSums;
pub use noise::Batches;
pub use noise::HourNoise;
pub use shared::SharedNoise;
pub(crate) use shared::{PixelWeights, SharedSums};
pub use source::{InMemory, PixelSource};
pub use stack::{Stack, StackOptions};
pub use year::{HourGlare, ReadyView, Year, year};

use crate::error::Result;
use crate::glare::Disc;
use crate::gpu::{Device, DeviceKind, Shader};
use crate::matrix::Matrix;
use crate::units::ILLUMINANCE_WEIGHTS;
use band::Band;

/// Shader variants of this module.
pub fn registered() -> Vec<Shader> {
    device::registered()
}

/// Light that is added to the pictures of some hours, such as that of the sun itself.
pub trait Additions: Sync {
    /// What is added in the `hour`-th column of the coefficients.
    ///
    /// # Errors
    /// Whatever prevents it.
    fn of_hour(&self, hour: usize) -> Result<Added>;
}

/// Light that is added to a picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Added {
    /// Pixels with additional light, ascending.
    pub pixels: Vec<AddedLight>,
    /// By how much they err together.
    pub shared: SharedNoise,
    /// Discs of the sun, which are sources of their own: their light is not in `pixels`.
    pub discs: Vec<Disc>,
}

/// Additional light in a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AddedLight {
    /// Number of the pixel.
    pub pixel: u32,
    /// Luminance from 0, cd/m².
    pub luminance: f32,
    /// Standard error of it, independent of other pixels' and of everything else's; 0 if not known.
    pub error: f32,
    /// Standard error by what pixels share ([`SharedNoise`]), cd/m².
    pub shared_error: f32,
}

/// Hours that are computed together.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    terms: usize,
    /// `[hour][term]`
    coefficients: Vec<f32>,
    /// Luminance above which a pixel is glare, per hour, cd/m².
    thresholds: Vec<f64>,
    /// Rounding errors of a pixel's luminance, at most, per hour.
    margins: Vec<f64>,
    /// Pixels with additional light, per hour.
    additions: Vec<Vec<(u32, f32)>>,
    /// Whether tiles without glare may be left out.
    skip: bool,
}

impl Pass {
    fn hours(&self) -> usize {
        self.thresholds.len()
    }
}

/// Pixels above the threshold of each hour, ascending.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GlarePixels {
    /// Where each hour begins, and the end.
    offsets: Vec<usize>,
    pixels: Vec<u32>,
    luminance: Vec<f32>,
}

impl GlarePixels {
    fn of_hour(&self, hour: usize) -> (&[u32], &[f32]) {
        let range = self.offsets[hour]..self.offsets[hour + 1];
        (&self.pixels[range.clone()], &self.luminance[range])
    }
}

/// Finds the pixels above the threshold.
pub trait Detector: Send + Sync {
    /// What does the work, for messages and summaries.
    fn description(&self) -> String;

    /// Makes some lines of a view ready.
    ///
    /// # Errors
    /// Memory and other failures of a device.
    fn load<'b>(&'b self, bands: Bands<'b>) -> Result<Box<dyn Loaded + 'b>>;
}

/// Consecutive lines of a [`Stack`].
#[derive(Clone, Copy)]
pub struct Bands<'b> {
    bands: &'b [Band],
    terms: usize,
    width: usize,
}

/// Lines of a view, ready for any hours.
pub trait Loaded: Sync {
    /// The glare pixels of these lines, in parts that follow each other from the top.
    ///
    /// # Errors
    /// Failures of a device.
    fn detect(&self, pass: &Pass) -> Result<Vec<GlarePixels>>;
}

/// The faster detector where `device` is already open: itself, or [`Native`] if it is software on
/// the CPU.
///
/// # Errors
/// Refusal of the kernels by the driver.
pub fn for_device(device: &Device) -> Result<Box<dyn Detector>> {
    if device.summary().kind == DeviceKind::Cpu { Ok(Box::new(Native)) } else { Ok(Box::new(OnDevice::new(device)?)) }
}

/// Luminance coefficients `[hour][term]` of some columns of the right factors, in the order of the
/// stack's terms: the factors' channels with their photometric weights, or their weighted sum for a
/// grey stack.
fn coefficients(stack: &Stack<'_>, rights: &[&Matrix<f32>], hours: std::ops::Range<usize>) -> Vec<f32> {
    let terms = stack.terms();
    let mut all = vec![0.0f32; terms * hours.len()];
    let mut first = 0;
    for right in rights {
        for bin in 0..right.rows() {
            for (hour, column) in hours.clone().enumerate() {
                let rgb = right.at(bin, column);
                let weighted = |c: usize| ILLUMINANCE_WEIGHTS[c] * f64::from(rgb[c]);
                if stack.is_grey() {
                    all[hour * terms + first] = (weighted(0) + weighted(1) + weighted(2)) as f32;
                } else {
                    for c in 0..3 {
                        all[hour * terms + first + c] = weighted(c) as f32;
                    }
                }
            }
            first += if stack.is_grey() { 1 } else { 3 };
        }
    }
    all
}

#[cfg(test)]
mod extremes;
#[cfg(test)]
mod tests;

//! Glare pixels on the GPU: the product stays there, only the pixels above the threshold come back.

use super::band::SLOTS;
use super::{Bands, Detector, GlarePixels, Loaded, Pass};
use crate::error::Result;
use crate::gpu::{Device, Kernel, Shader, check_finite};
use crate::kernels::product::{self, Factor, Multiplier, TileOnDevice};
use rayon::prelude::*;

crate::gpu_struct! {
    /// Parameters of `glare/count` and `glare/list`.
    pub(crate) struct CompactParams {
        /// Pixels of an hour.
        pub pixels: u32,
        /// Distance between hours.
        pub stride: u32,
        /// The first hour's threshold in the list.
        pub first_hour: u32,
        /// Runs of pixels per hour.
        pub runs: u32,
    }
}

crate::gpu_struct! {
    /// Parameters of `glare/add`.
    pub(super) struct AddParams {
        /// Number of additions.
        pub count: u32,
    }
}

crate::gpu_constants! {
    const NUMBERS = {
        /// Invocations per workgroup of `glare/count` and `glare/list`.
        const COMPACT_WORKGROUP: u32 = 256;
        /// Pixels that each of them takes.
        const PIXELS_EACH: u32 = 8;
        /// Invocations per workgroup of `glare/add`.
        const ADD_WORKGROUP: u32 = 64;
    }
}

/// Pixels of a run: what a workgroup takes.
const RUN: usize = (COMPACT_WORKGROUP * PIXELS_EACH) as usize;

const COUNT: Shader = Shader::new("glare/count", &[NUMBERS, &[CompactParams::DECLARED]]);
const LIST: Shader = Shader::new("glare/list", &[NUMBERS, &[CompactParams::DECLARED]]);
const ADD: Shader = Shader::new("glare/add", &[NUMBERS, &[AddParams::DECLARED]]);

pub(super) fn registered() -> Vec<Shader> {
    vec![COUNT, LIST, ADD]
}

/// Finds glare pixels on a GPU device.
pub struct OnDevice {
    device: Device,
    product: product::OnDevice,
    count: Kernel,
    list: Kernel,
    add: Kernel,
}

impl OnDevice {
    /// The detector with the product kernel that suits the device.
    ///
    /// # Errors
    /// Refusal by the driver.
    pub fn new(device: &Device) -> Result<Self> {
        Self::with_product(device, product::OnDevice::new(device)?)
    }

    /// The detector with a chosen product kernel.
    ///
    /// # Errors
    /// Refusal by the driver.
    pub(crate) fn with_product(device: &Device, product: product::OnDevice) -> Result<Self> {
        let kernel = |shader: &Shader| Kernel::new(device, shader, &[]);
        Ok(Self { device: device.clone(), product, count: kernel(&COUNT)?, list: kernel(&LIST)?, add: kernel(&ADD)? })
    }
}

/// Pixels of a view on the device.
struct LoadedOnDevice<'d> {
    detector: &'d OnDevice,
    /// Ascending.
    pixels: Vec<u32>,
    values: Factor<'d>,
    terms: usize,
}

impl Detector for OnDevice {
    fn description(&self) -> String {
        format!("glare behind the {}", self.product.description())
    }

    fn load<'b>(&'b self, bands: Bands<'b>) -> Result<Box<dyn Loaded + 'b>> {
        let Bands { bands, terms, .. } = bands;
        // Pixel, and where its values are: band, tile, slot.
        let mut places: Vec<(u32, u32, u32, u32)> = Vec::new();
        for (b, band) in bands.iter().enumerate() {
            for (t, tile) in band.tiles.iter().enumerate() {
                places.extend(tile.pixels().iter().zip(0..).map(|(&pixel, slot)| (pixel, b as u32, t as u32, slot)));
            }
        }
        places.sort_unstable();
        let mut values = vec![0.0f32; places.len() * terms];
        values.par_chunks_exact_mut(terms).zip(&places).for_each(|(row, &(_, band, tile, slot))| {
            let tile = &bands[band as usize].values[tile as usize * terms * SLOTS..];
            row.iter_mut().enumerate().for_each(|(k, v)| *v = tile[k * SLOTS + slot as usize]);
        });
        let values = self.product.left(places.len(), terms, 1, values.into())?;
        Ok(Box::new(LoadedOnDevice { detector: self, pixels: places.into_iter().map(|p| p.0).collect(), values, terms }))
    }
}

impl Loaded for LoadedOnDevice<'_> {
    fn detect(&self, pass: &Pass) -> Result<Vec<GlarePixels>> {
        let OnDevice { device, product, .. } = self.detector;
        let (hours, terms) = (pass.hours(), self.terms);
        if self.pixels.is_empty() || hours == 0 {
            return Ok(Vec::new());
        }
        let mut by_term = vec![0.0f32; terms * hours];
        for (hour, row) in pass.coefficients.chunks_exact(terms).enumerate() {
            row.iter().enumerate().for_each(|(k, &c)| by_term[k * hours + hour] = c);
        }
        let right = product.right(terms, hours, 1, by_term.into())?;
        // A luminance exceeds a threshold if it exceeds the next f32 below.
        let thresholds: Vec<f32> = pass.thresholds.iter().map(|&t| floor_f32(t)).collect();
        let thresholds = device.upload("glare thresholds", &thresholds)?;
        let mut parts: Vec<GlarePixels> = Vec::new();
        let mut first_row = None;
        product.for_each_tile(&self.values, &right, &mut |tile| {
            if first_row != Some(tile.rows.first) {
                first_row = Some(tile.rows.first);
                parts.push(GlarePixels { offsets: vec![0], ..GlarePixels::default() });
            }
            self.add(&tile, pass)?;
            let part = parts.last_mut().expect("pushed above");
            self.compact(&tile, &thresholds, part)
        })?;
        Ok(parts)
    }
}

impl LoadedOnDevice<'_> {
    /// Adds the additional light of the tile's hours and pixels.
    fn add(&self, tile: &TileOnDevice, pass: &Pass) -> Result<()> {
        let rows = &self.pixels[tile.rows.first..tile.rows.first + tile.rows.count];
        let mut additions: Vec<[u32; 2]> = Vec::new();
        for hour in 0..tile.columns.count {
            for &(pixel, l) in &pass.additions[tile.columns.first + hour] {
                if let Ok(row) = rows.binary_search(&pixel) {
                    additions.push([(hour * tile.stride + row) as u32, l.to_bits()]);
                }
            }
        }
        if additions.is_empty() {
            return Ok(());
        }
        let OnDevice { device, add, .. } = self.detector;
        let params = device.uniform("additions' parameters", &AddParams { count: additions.len() as u32 })?;
        let list = device.upload("additional light", &additions)?;
        let bindings = add.bind(&[("params", &params), ("additions", &list), ("luminance", &tile.values)])?;
        device.dispatch(add, &bindings, device.grid((additions.len() as u64).div_ceil(u64::from(ADD_WORKGROUP)))?)
    }

    /// Appends the tile's glare pixels, hour by hour.
    fn compact(&self, tile: &TileOnDevice, thresholds: &crate::gpu::Buffer, part: &mut GlarePixels) -> Result<()> {
        let OnDevice { device, count, list, .. } = self.detector;
        let (pixels, hours) = (tile.rows.count, tile.columns.count);
        let runs = pixels.div_ceil(RUN);
        let params =
            CompactParams { pixels: pixels as u32, stride: tile.stride as u32, first_hour: tile.columns.first as u32, runs: runs as u32 };
        let params = device.uniform("parameters of glare pixels", &params)?;
        let counts = device.zeros::<u32>("numbers of glare pixels", runs * hours)?;
        let common = [("params", &params), ("luminance", &tile.values), ("thresholds", thresholds)];
        let grid = [runs as u32, hours as u32, 1];
        device.dispatch(count, &count.bind(&[&common[..], &[("counts", &counts)]].concat())?, grid)?;
        let counts = device.read::<u32>(&counts)?;
        let mut total = 0u32;
        let mut places = Vec::with_capacity(counts.len());
        for of_hour in counts.chunks_exact(runs) {
            for &count in of_hour {
                places.push(total);
                total += count;
            }
            part.offsets.push(part.pixels.len() + total as usize);
        }
        if total == 0 {
            return Ok(());
        }
        let places = device.upload("places of glare pixels", &places)?;
        let found = device.zeros::<[u32; 2]>("glare pixels", total as usize)?;
        device.dispatch(list, &list.bind(&[&common[..], &[("places", &places), ("found", &found)]].concat())?, grid)?;
        let found = device.read::<[u32; 2]>(&found)?;
        let numbers = &self.pixels[tile.rows.first..];
        let from = part.luminance.len();
        part.luminance.extend(found.iter().map(|f| f32::from_bits(f[0])));
        part.pixels.extend(found.iter().map(|f| numbers[f[1] as usize]));
        check_finite(&part.luminance[from..], "luminance")
    }
}

/// The greatest f32 that is not above `value`.
fn floor_f32(value: f64) -> f32 {
    let near = value as f32;
    if f64::from(near) > value { near.next_down() } else { near }
}

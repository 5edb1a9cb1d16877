//! What is behind pixels: surfaces that suns light, and points of panes.

use crate::camera::{PixelSamples, Raster};
use crate::error::Result;
use crate::gpu::{Buffer, Device, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::image_matrix::PixelRay;
use crate::kernels::light_paths::{Receiver, finish_dispatch};
use crate::kernels::sun_matrix::pane::light::PanePoint;
use crate::kernels::sun_matrix::tracer::STRUCTS;
use crate::kernels::trace::{self, Counters, FAR_AWAY, TraceScene, TraceStatistics, TraceTables, WindowSurfaces, stream_seed};
use crate::scene::{Scene, Window};

gpu_struct! {
    /// Parameters of `sun_matrix/pixels`.
    pub(crate) struct SunPixelParams {
        seed: u32,
        pixels: u32,
        batches: u32,
        window_count: u32,
        /// Materials from here on are those of shades.
        first_shade: u32,
        /// Whether the windows are panes, where a ray ends.
        panes: u32,
        padding0: u32,
        padding1: u32,
    }
}

pub(in super::super) const PIXELS: Shader =
    trace::shader("sun_matrix/pixels", &[STRUCTS, &[SunPixelParams::DECLARED, PixelRay::DECLARED, PanePoint::DECLARED]]);

/// Finds what is behind pixels.
pub(super) struct PixelSurfaces<'a> {
    device: &'a Device,
    raster: &'a Raster,
    tables: TraceTables,
    scene: TraceScene,
    kernel: Kernel,
    counters: Buffer,
    samples: PixelSamples,
    windows: usize,
    batches: u32,
    seed: u32,
    /// Pixels that show something.
    pub inside: Vec<usize>,
}

/// What is behind the pixels of a tile, `[batch][pixel]`.
pub(super) struct Found {
    pub receivers: Buffer,
    /// Radiance shown per irradiance of the receiver, or per radiance of the point of a pane if the last is 1.
    pub weights: Vec<[f32; 4]>,
    pub facade: Buffer,
}

impl<'a> PixelSurfaces<'a> {
    pub fn new(device: &'a Device, lit: &Scene, windows: &[Window], raster: &'a Raster, [batches, seed]: [u32; 2]) -> Result<Self> {
        let tables = TraceTables::new(lit, windows, WindowSurfaces::Open)?;
        Ok(Self {
            device,
            raster,
            scene: tables.upload(device)?,
            tables,
            kernel: Kernel::new(device, &PIXELS, &[])?,
            counters: device.zeros::<Counters>("path counters", 1)?,
            samples: PixelSamples::new(batches as usize, 1.0, u64::from(seed))?,
            windows: windows.len(),
            batches,
            seed,
            inside: (0..raster.len()).filter(|&p| raster.is_seen(p % raster.width(), p / raster.width())).collect(),
        })
    }

    /// Materials from `first_shade` on are those of slats; the windows are panes, where rays end, or holes.
    pub fn find(&self, tile: &[usize], first_shade: u32, panes: bool, statistics: &mut TraceStatistics) -> Result<Found> {
        let (device, count) = (self.device, tile.len());
        let all = self.batches as usize * count;
        let rays: Vec<PixelRay> = (0..self.batches as usize)
            .flat_map(|batch| tile.iter().map(move |&pixel| (batch, pixel)))
            .map(|(batch, pixel)| pixel_ray(&self.tables, self.raster, &self.samples, pixel, batch))
            .collect();
        let params = SunPixelParams {
            seed: stream_seed(self.seed, 0, 0x7375_6e78),
            pixels: count as u32,
            batches: self.batches,
            window_count: self.windows as u32,
            first_shade,
            panes: u32::from(panes),
            ..SunPixelParams::default()
        };
        let params = device.uniform("pixels that see suns' light", &params)?;
        let rays = device.upload("camera rays", &rays)?;
        let receivers = device.zeros::<Receiver>("receivers of the pixels", all)?;
        let weights = device.zeros::<[f32; 4]>("weights of the receivers", all)?;
        let facade = device.zeros::<PanePoint>("points of panes", all)?;
        let own = [
            ("params", &params),
            ("rays", &rays),
            ("receivers", &receivers),
            ("receiver_weights", &weights),
            ("facade", &facade),
            ("counters", &self.counters),
        ];
        device.write(&self.counters, &[Counters::default()])?;
        let bind = self.kernel.bind(&self.scene.bindings(&own))?;
        device.dispatch(&self.kernel, &bind, [(count as u32).div_ceil(64), self.batches, 1])?;
        finish_dispatch(device, &self.counters, all as u64, self.kernel.label(), statistics)?;
        Ok(Found { receivers, weights: device.read::<[f32; 4]>(&weights)?, facade })
    }
}

fn pixel_ray(tables: &TraceTables, raster: &Raster, samples: &PixelSamples, pixel: usize, sample: usize) -> PixelRay {
    let (column, row) = (pixel % raster.width(), pixel / raster.width());
    // At the rim a sample may fall outside the view although the centre is inside.
    let ray = raster.sample(column, row, samples.offset(pixel, sample)).or_else(|| raster.ray(column, row));
    ray.map_or_else(
        || PixelRay::new([0.0; 3], 0.0, [0.0, 0.0, 1.0], pixel as u32),
        |r| {
            let length = if r.length > 0.0 { (r.length * tables.normalization.scale) as f32 } else { FAR_AWAY as f32 };
            PixelRay::new(tables.normalization.point(r.origin).to_array(), length, r.direction.as_vec3().to_array(), pixel as u32)
        },
    )
}

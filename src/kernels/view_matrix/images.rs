//! Images of the windows in plane smooth surfaces: which sensors may see which, and what arrives of them
//! (`view_matrix/images`).

use super::{ViewTracer, beside_surface};
use crate::error::Result;
use crate::gpu::Shader;
use crate::gpu_struct;
use crate::kernels::light_paths::finish_dispatch;
use crate::kernels::trace::planes::SmoothPlane;
use crate::kernels::trace::{self, CELL_CAPACITY, Counters, TraceStatistics, stream_seed};
use crate::scene::Window;
use crate::scene::points::Sensor;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

gpu_struct! {
    /// A sensor's image in a mirror (`view_matrix/images.wgsl`).
    pub(crate) struct ImageView {
        /// Image of the sensor.
        eye: [f32; 3],
        /// Of the sensor: chooses the random numbers.
        number: u32,
        /// The image's, unit length.
        normal: [f32; 3],
        /// Number of the mirror's plane.
        plane: u32,
        /// Of the sensor itself.
        position: [f32; 3],
        /// Distance of the image from the plane.
        depth: f32,
        /// Unit normal of the plane, towards the sensor.
        mirror: [f32; 3],
        padding: u32,
    }
}

gpu_struct! {
    /// Parameters of `view_matrix/images`.
    pub(crate) struct ImageParams {
        seed: u32,
        views: u32,
        samples: u32,
        bins: u32,
        window_count: u32,
        /// Fixed-point units per sample and full window.
        unit: f32,
        batches: u32,
        padding: u32,
    }
}

pub(super) const IMAGES: Shader = trace::shader("view_matrix/images", &[&[ImageParams::DECLARED, ImageView::DECLARED]]);

/// Rays to an image per ray to the windows themselves: polished surfaces show little of the light.
const RAYS_PER_DIRECT_RAY: f64 = 0.25;
/// Memory for the sums of a dispatch, bytes.
const MOST_BYTES: usize = 1 << 26;

/// Whether an image of one of the windows may show in a mirror's surfaces.
fn may_show(plane: &SmoothPlane, windows: &[Window], eye: DVec3, normal: DVec3) -> bool {
    let depth = plane.height(eye);
    let mirror = plane.normal * -depth.signum();
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for window in windows.iter().filter(|w| (eye - w.triangles[0][0]).dot(w.frame.z) > 0.0) {
        for triangle in &window.triangles {
            // In front of the mirror and above the horizon; then, as if shone through the plane.
            let part = cut(cut(triangle.to_vec(), |p| plane.height(p) * -depth.signum()), |p| (p - eye).dot(normal));
            for p in part {
                let height = (p - plane.point).dot(mirror).max(0.0);
                let flat = plane.flat(eye + (p - eye) * (depth.abs() / (depth.abs() + height)));
                (low, high) = (low.min(flat), high.max(flat));
            }
        }
    }
    let margin = 1e-6 * (plane.high - plane.low).max_element();
    low.cmple(plane.high + margin).all() && high.cmpge(plane.low - margin).all()
}

/// The part of a polygon where `inside` is not below 0; it must be linear.
fn cut(corners: Vec<DVec3>, inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (at_a, at_b) = (inside(a), inside(b));
        if at_a >= 0.0 {
            kept.push(a);
        }
        if (at_a >= 0.0) != (at_b >= 0.0) {
            kept.push(a + (b - a) * (at_a / (at_a - at_b)));
        }
    }
    kept
}

impl ViewTracer<'_> {
    /// Images that the sensors may see, in their order, with the sensors' places.
    fn image_views(&self, sensors: &[Sensor], first: usize) -> Vec<(usize, ImageView)> {
        let normalization = &self.tables.normalization;
        let views_of = |(i, sensor): (usize, &Sensor)| {
            let normal = sensor.direction.normalize();
            let mut views = Vec::new();
            for (number, plane) in self.tables.planes.iter().enumerate() {
                let height = plane.height(sensor.position);
                // A sensor on the mirror itself sees nothing in it.
                if height.abs() * normalization.scale < 1e-5 {
                    continue;
                }
                let eye = sensor.position - plane.normal * (2.0 * height);
                let mirrored = normal - plane.normal * (2.0 * normal.dot(plane.normal));
                if may_show(plane, self.windows, eye, mirrored) {
                    views.push((
                        i,
                        ImageView {
                            eye: normalization.point(eye).to_array(),
                            number: (first + i) as u32,
                            normal: mirrored.as_vec3().to_array(),
                            plane: number as u32 + 1,
                            position: beside_surface(normalization.point(sensor.position), normal.as_vec3()).to_array(),
                            depth: (height.abs() * normalization.scale) as f32,
                            mirror: (plane.normal * height.signum()).as_vec3().to_array(),
                            padding: 0,
                        },
                    ));
                }
            }
            views
        };
        sensors.par_iter().enumerate().flat_map_iter(views_of).collect()
    }

    /// Adds what the sensors see of the windows' images to `sums`, `[batch][sensor][bin][rgb]`, sr.
    pub(super) fn add_images(&self, sensors: &[Sensor], first: usize, sums: &mut [f32], statistics: &mut TraceStatistics) -> Result<()> {
        let (o, device, bins) = (&self.options, self.device, self.tables.bins());
        let batches = o.batches as usize;
        let samples = ((f64::from(o.direct_samples) * RAYS_PER_DIRECT_RAY) as u32).max(16);
        let unit = CELL_CAPACITY / samples as f32;
        let views = self.image_views(sensors, first);
        let Some(kernel) = &self.images else { return Ok(()) };
        for views in views.chunks((MOST_BYTES / (batches * bins * 12)).max(1)) {
            let params = ImageParams {
                seed: stream_seed(o.seed, 0, 0x696d_6167),
                views: views.len() as u32,
                samples,
                bins: bins as u32,
                window_count: self.windows.len() as u32,
                unit,
                batches: o.batches,
                padding: 0,
            };
            let records: Vec<ImageView> = views.iter().map(|v| v.1).collect();
            let what = "images of windows";
            let params = device.uniform(what, &params)?;
            let records = device.upload(what, &records)?;
            let shares = device.zeros::<u32>(what, batches * views.len() * bins * 3)?;
            let solid_angles = device.zeros::<f32>(what, views.len())?;
            device.write(&self.counters, &[Counters::default()])?;
            let bind = kernel.bind(&self.scene.bindings(&[
                ("params", &params),
                ("views", &records),
                ("sums", &shares),
                ("solid_angles", &solid_angles),
                ("counters", &self.counters),
            ]))?;
            device.dispatch(kernel, &bind, [samples.div_ceil(64), views.len() as u32, o.batches])?;
            let started = u64::from(samples) * views.len() as u64 * batches as u64;
            finish_dispatch(device, &self.counters, started, what, statistics)?;
            let shares: Vec<u32> = device.read(&shares)?;
            let solid_angles: Vec<f32> = device.read_finite(&solid_angles)?;
            for (place, row) in shares.chunks_exact(bins * 3).enumerate() {
                let (batch, view) = (place / views.len(), place % views.len());
                let scale = solid_angles[view] / (unit * samples as f32);
                let own = (batch * sensors.len() + views[view].0) * bins * 3;
                sums[own..own + bins * 3].iter_mut().zip(row).for_each(|(sum, &share)| *sum += share as f32 * scale);
            }
        }
        Ok(())
    }
}

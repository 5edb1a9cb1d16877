//! Images of the windows in plane smooth surfaces: from where which may be seen, and what arrives of them
//! (`light_paths/images`).

use super::doubts::Chances;
use super::{NUMBERS, WORKGROUPS_PER_ROW, finish_dispatch};
use crate::error::Result;
use crate::gpu::{Device, Kernel, Shader};
use crate::gpu_struct;
use crate::kernels::trace::planes::SmoothPlane;
use crate::kernels::trace::{self, Counters, TraceScene, TraceStatistics, TraceTables, stream_seed};
use crate::scene::Window;
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

gpu_struct! {
    /// The image of a point in a mirror (`light_paths/images.wgsl`).
    pub(crate) struct ImageView {
        /// Image of the point.
        eye: [f32; 3],
        /// Of the sensor or pixel: chooses the random numbers.
        number: u32,
        /// The image's, unit length.
        normal: [f32; 3],
        /// Number of the mirror's plane.
        plane: u32,
        /// Of the point itself, and where its rays start.
        position: [f32; 3],
        /// Distance of the image from the plane.
        depth: f32,
        /// Unit normal of the plane, towards the point.
        mirror: [f32; 3],
        /// Batch that it belongs to.
        batch: u32,
        /// Of the mirror.
        material: u32,
        padding0: u32,
        padding1: u32,
        padding2: u32,
    }
}

gpu_struct! {
    /// Parameters of `light_paths/images`.
    pub(crate) struct ImageParams {
        seed: u32,
        views: u32,
        samples: u32,
        window_count: u32,
    }
}

gpu_struct! {
    /// What arrives by one sample, sr, and in which bin; if that is `MISSED`, nothing did, and it is what might have.
    pub(crate) struct ImageLight {
        light: [f32; 3],
        bin: u32,
    }
}

crate::gpu_constants! {
    const MISSES = {
        /// No bin.
        const MISSED: u32 = u32::MAX;
    }
}

pub(super) const IMAGES: Shader =
    trace::shader("light_paths/images", &[NUMBERS, MISSES, &[ImageParams::DECLARED, ImageView::DECLARED, ImageLight::DECLARED]]);

/// Rays to an image per ray to the windows themselves: polished surfaces show little of the light.
const RAYS_PER_DIRECT_RAY: f64 = 0.25;
/// Memory for the samples of a dispatch, bytes.
const MOST_BYTES: usize = 1 << 26;

/// A point whose irradiance is asked for: a sensor, or what a pixel shows.
pub(crate) struct ReceiverPoint {
    /// Its row in the tile.
    pub row: usize,
    /// Batches that it is part of.
    pub batches: Range<u32>,
    /// In the user's coordinates.
    pub position: DVec3,
    /// Unit length.
    pub normal: DVec3,
    /// Where its rays start, in the tracer's coordinates.
    pub start: Vec3,
    /// Chooses the random numbers.
    pub number: u32,
}

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

/// Whether some of a mirror's rectangle lies above a point's horizon.
fn rises(plane: &SmoothPlane, position: DVec3, normal: DVec3) -> bool {
    let [x, y] = plane.axes;
    let corner = |u: f64, v: f64| (plane.point + x * u + y * v - position).dot(normal) > 0.0;
    [plane.low.x, plane.high.x].into_iter().any(|u| corner(u, plane.low.y) || corner(u, plane.high.y))
}

/// Views of images, with the row of the point.
fn views_of(tables: &TraceTables, windows: &[Window], from: &ReceiverPoint) -> Vec<(usize, ImageView)> {
    let normalization = &tables.normalization;
    let mut views = Vec::new();
    for (number, plane) in tables.planes.iter().enumerate().filter(|(_, plane)| rises(plane, from.position, from.normal)) {
        let height = plane.height(from.position);
        // On the mirror itself nothing is seen in it.
        if height.abs() * normalization.scale < 1e-5 {
            continue;
        }
        let eye = from.position - plane.normal * (2.0 * height);
        let mirrored = from.normal - plane.normal * (2.0 * from.normal.dot(plane.normal));
        if !may_show(plane, windows, eye, mirrored) {
            continue;
        }
        let view = |batch| ImageView {
            eye: normalization.point(eye).to_array(),
            number: from.number,
            normal: mirrored.as_vec3().to_array(),
            plane: number as u32 + 1,
            position: from.start.to_array(),
            depth: (height.abs() * normalization.scale) as f32,
            mirror: (plane.normal * height.signum()).as_vec3().to_array(),
            batch,
            material: plane.material,
            padding0: 0,
            padding1: 0,
            padding2: 0,
        };
        views.extend(from.batches.clone().map(|batch| (from.row, view(batch))));
    }
    views
}

/// Rays aimed at images.
pub(crate) struct WindowImages {
    kernel: Kernel,
    samples: u32,
    seed: u32,
}

impl WindowImages {
    /// Nothing if no plane mirrors. `direct_samples` rays go to the windows themselves, `least` at least to an
    /// image.
    ///
    /// # Errors
    /// If the device fails.
    pub fn new(device: &Device, tables: &TraceTables, seed: u32, direct_samples: u32, least: u32) -> Result<Option<Self>> {
        if tables.planes.is_empty() {
            return Ok(None);
        }
        let glass = ("HAS_GLASS", f64::from(u8::from(tables.features.glass)));
        let samples = ((f64::from(direct_samples) * RAYS_PER_DIRECT_RAY) as u32).max(least);
        let kernel = Kernel::new(device, &IMAGES, &[glass])?;
        Ok(Some(Self { kernel, samples, seed: stream_seed(seed, 0, 0x696d_6167) }))
    }

    /// Adds what is seen of the windows' images to `sums`, `[batch][row][bin][rgb]`, sr, of so many rows. Returns for
    /// each row the standard deviation of what few hits leave open in the mean of all batches, sr.
    ///
    /// # Errors
    /// If the device fails or loses rays.
    pub fn add(
        &self,
        device: &Device,
        (tables, scene): (&TraceTables, &TraceScene),
        windows: &[Window],
        receiver_points: &[ReceiverPoint],
        (sums, rows): (&mut [f32], usize),
        statistics: &mut TraceStatistics,
    ) -> Result<Vec<f64>> {
        let what = "images of windows";
        let (bins, samples) = (tables.bins(), self.samples as usize);
        let views: Vec<(usize, ImageView)> = receiver_points.par_iter().flat_map_iter(|b| views_of(tables, windows, b)).collect();
        let counters = device.zeros::<Counters>("path counters", 1)?;
        let planes = tables.planes.len();
        let mut chances = vec![Chances::default(); rows * planes];
        for views in views.chunks((MOST_BYTES / (samples * size_of::<ImageLight>())).max(1)) {
            let params = ImageParams {
                seed: self.seed,
                views: views.len() as u32,
                samples: self.samples,
                window_count: tables.windows.len() as u32,
            };
            let records: Vec<ImageView> = views.iter().map(|v| v.1).collect();
            let params = device.uniform(what, &params)?;
            let records = device.upload(what, &records)?;
            let found = device.zeros::<ImageLight>(what, views.len() * samples)?;
            device.write(&counters, &[Counters::default()])?;
            let own = [("params", &params), ("views", &records), ("found", &found), ("counters", &counters)];
            let bind = self.kernel.bind(&scene.bindings(&own))?;
            let groups = (views.len() * samples).div_ceil(64) as u32;
            device.dispatch(&self.kernel, &bind, [groups.min(WORKGROUPS_PER_ROW), groups.div_ceil(WORKGROUPS_PER_ROW), 1])?;
            finish_dispatch(device, &counters, (views.len() * samples) as u64, what, statistics)?;
            let found: Vec<ImageLight> = device.read(&found)?;
            for ((row, view), lights) in views.iter().zip(found.chunks_exact(samples)) {
                let own = (view.batch as usize * rows + row) * bins * 3;
                let chance = &mut chances[row * planes + view.plane as usize - 1];
                for l in lights {
                    chance.add(f64::from(l.light.into_iter().fold(0.0, f32::max)), l.bin != MISSED);
                    if l.bin == MISSED {
                        continue;
                    }
                    let cell = own + l.bin as usize * 3;
                    sums[cell..cell + 3].iter_mut().zip(l.light).for_each(|(sum, light)| *sum += light);
                }
            }
        }
        let batches = (sums.len() / (rows * bins * 3)) as f64;
        let doubt = |own: &[Chances]| own.iter().map(|c| c.doubt(batches)).fold(0.0, f64::hypot);
        Ok(chances.chunks_exact(planes).map(doubt).collect())
    }
}

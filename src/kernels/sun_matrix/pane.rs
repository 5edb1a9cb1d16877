//! The sun through a pane that scatters: BSDF, aBSDF, glass and trans.
//!
//! `C[receiver][sun] = ∫_pane f(ω_sun → ω) cosθ_sun Ω_sun · visible outside · visible inside · G dA`,
//! the irradiance per unit radiance of the sun's disc (sr). Only light that the pane scatters once,
//! straight to the receiver, counts: five-phase's Cds is a direct part.
//!
//! The panes are cut into small triangles. A ray from a random point of each to every receiver and to
//! every sun tells what is visible – rays grow with cells × (receivers + suns). Only the scattering
//! function and G are evaluated for every pair of receiver and sun: at that point, and as a control
//! variate at as many more as the cell's size seen from the receiver asks for. Several batches with
//! other random points give the standard error.
//!
//! What passes straight through – the peak of an aBSDF, glass, the specular part of trans – is the
//! clear disc seen through the window: Ω cosθ · transmittance · visibility.
//!
//! # Why Radiance's coefficients through a Klems BSDF lie above the three-phase direct part
//! For eight single suns in a side-lit room, `rcontrib` through a Klems pane gives 16 % more than
//! Vd·T·Dd of the suns' patches (and 14 % more than the real slats). Two causes; a test holds the
//! first, the second is an estimate:
//! * *One sun, one bin* (13 %). A sun falls into a single incident bin of 10–15° and meets its mean
//!   value; the patch of a three-phase product, 12° wide, spreads it over all bins that it overlaps.
//!   For one sun the two differ by up to a factor of 4 in either direction. This module finds the same
//!   excess for the same suns; over suns that fill the patches evenly it comes within 2 % of Vd·T·Dd.
//!   What is left then is the deep reveal: V and D each average over the window, while an oblique sun
//!   lights a strip of it only, and a sensor near the wall sees that strip well or not at all. With V and
//!   D sampled for parts of the window, single patches come within 10 % by 2 columns of parts, 7 % by 8,
//!   3 % by 16, and 1 % (all together 0.4 %) by 32; more rows, more suns in a patch, or discs for points
//!   change nothing. Neither is wrong: the data do not tell more.
//! * *The other block* (3 %). Radiance's material follows light backwards and takes Transmission Back;
//!   `dctimestep` and this program take Transmission Front. Traced data are not exactly reciprocal.
//!
//! Radiance also moves the direction to the eye at random by up to half a bin (`-ss`), which smooths
//! single receivers.

mod kinds;
mod tables;
pub(super) mod tracer;

pub use kinds::PaneBsdf;

use super::Sun;
use crate::error::{Error, Result};
use crate::gpu::{DEFAULT_MEMORY, Declared, Device, Shader};
use crate::gpu_struct;
use crate::kernels::bsdf_scattering;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{self, TraceStatistics};
use crate::matrix::Matrix;
use crate::progress::Progress;
use crate::scene::points::Sensor;
use crate::scene::{Scene, Window};
use glam::DVec3;
use tracer::PaneTracer;

gpu_struct! {
    /// Parameters of the pane kernels (`shared/pane.wgsl`).
    pub(crate) struct PaneParams {
        seed: u32,
        receivers: u32,
        suns: u32,
        /// Cells of the panes per batch.
        cells: u32,
        batches: u32,
        panes: u32,
        /// Directions to a sun's disc per batch, where the disc itself is seen.
        disc_samples: u32,
        /// Cells that one dispatch takes: of each batch where light is gathered, of all where ways are traced.
        first_cell: u32,
        end_cell: u32,
        /// Receivers from one batch to the next; 0 if all batches share them.
        batch_stride: u32,
        /// Size of a part of a cell seen from the receiver, radians.
        part_angle: f32,
        padding0: u32,
    }
}

gpu_struct! {
    /// A pane: its frame, and where its data begin.
    pub(crate) struct Pane {
        x: [f32; 3],
        /// First word of its scattering function; NO_SCATTERING if it only transmits straight through.
        words: u32,
        y: [f32; 3],
        first_triangle: u32,
        /// Into the room.
        z: [f32; 3],
        triangles: u32,
        /// Factor on the scattering function.
        tint: [f32; 3],
        padding: u32,
    }
}

gpu_struct! {
    /// A sun seen through a pane.
    pub(crate) struct PaneSunRecord {
        /// Towards its centre.
        direction: [f32; 3],
        /// Angular radius as a chord.
        chord: f32,
        /// Transmittance of the straight way.
        clear: [f32; 3],
        /// Solid angle, sr.
        solid_angle: f32,
        /// Squared radius within which scattered light meets the surround of a through-peak; 0: no peak.
        guard: f32,
        /// Scattering function there, 1/sr.
        surround: f32,
        /// Factor on the scattering function.
        scale: f32,
        padding: u32,
    }
}

gpu_struct! {
    /// A triangle of a pane's area: all points corner + u edge1 + v edge2 with u + v < 1.
    pub(crate) struct PaneCell {
        corner: [f32; 3],
        pane: u32,
        edge1: [f32; 3],
        area: f32,
        edge2: [f32; 3],
        padding0: u32,
        /// A random point inside, where light is followed.
        position: [f32; 3],
        padding1: u32,
    }
}

gpu_struct! {
    /// A point of the façade that an eye sees.
    pub(crate) struct FacadePoint {
        position: [f32; 3],
        /// NO_PANE if there is none.
        pane: u32,
        /// Towards the eye, unit length.
        outgoing: [f32; 3],
        number: u32,
    }
}

gpu_struct! {
    /// A sun as a cell sees it.
    pub(crate) struct PaneEnd {
        /// What evaluation needs to know of the incident direction.
        key: [f32; 2],
        /// x and y of the direction of travel in the pane's frame.
        direction: [f32; 2],
        /// Cosine times solid angle times transmittance of the way; 0 if nothing arrives.
        strength: [f32; 3],
        padding: u32,
    }
}

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<Shader> {
    vec![SUNS, RECEIVERS, GATHER, CLEAR, FACADE]
}

crate::gpu_constants! {
    pub(super) const NUMBERS = {
        /// In place of the first word of a scattering function, where there is none.
        const NO_SCATTERING: u32 = u32::MAX;
        /// In place of the number of a pane.
        const NO_PANE: u32 = u32::MAX;
        /// Suns that one invocation of `pane_gather` takes.
        const GATHERED_SUNS: u32 = 4;
    }
}

/// What all of them know, and who looks at panes.
pub(super) const STRUCTS: &[Declared] = &[
    PaneParams::DECLARED,
    Pane::DECLARED,
    PaneSunRecord::DECLARED,
    PaneCell::DECLARED,
    PaneEnd::DECLARED,
    FacadePoint::DECLARED,
    Receiver::DECLARED,
];
const SUNS: Shader = trace::shader("trace/pane_suns", &[bsdf_scattering::NUMBERS, NUMBERS, STRUCTS]);
const RECEIVERS: Shader = trace::shader("trace/pane_receivers", &[bsdf_scattering::NUMBERS, NUMBERS, STRUCTS]);
const GATHER: Shader = trace::shader("trace/pane_gather", &[bsdf_scattering::NUMBERS, NUMBERS, STRUCTS]);
const CLEAR: Shader = trace::shader("trace/pane_clear", &[bsdf_scattering::NUMBERS, NUMBERS, STRUCTS]);
const FACADE: Shader = trace::shader("trace/pane_facade", &[bsdf_scattering::NUMBERS, NUMBERS, STRUCTS]);

/// How much to sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaneOptions {
    /// Cells of all panes together, about, per batch: rays of each receiver and each sun.
    pub cells: u32,
    /// Directions to a sun's disc per batch where it is seen clearly, and from points of the façade.
    pub disc_samples: u32,
    /// Size of the parts of a cell, seen from the receiver, in each of which the scattering function is
    /// evaluated, radians.
    pub part_angle: f32,
    /// Independent repetitions; their spread gives the standard error. At least 2.
    pub batches: u32,
    /// Same seed, same device: same bits.
    pub seed: u32,
    /// Device memory to use, bytes.
    pub memory: u64,
}

impl Default for PaneOptions {
    fn default() -> Self {
        Self { cells: 1024, disc_samples: 16, part_angle: 0.05, batches: 4, seed: 1, memory: DEFAULT_MEMORY }
    }
}

/// Coefficients of receivers (rows) and suns (columns), RGB.
#[derive(Debug, Clone, PartialEq)]
pub struct PaneSun {
    /// Scattered and clear light together.
    pub total: Matrix<f32>,
    /// Only what passes straight through.
    pub clear: Matrix<f32>,
    /// Standard error of each entry of `total`.
    pub standard_error: Matrix<f32>,
    /// Work done.
    pub statistics: TraceStatistics,
}

/// A point of a window that an eye sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacadeView {
    /// Point on the window, in the scene's coordinates.
    pub position: DVec3,
    /// Index of the window.
    pub window: usize,
    /// Direction towards the eye.
    pub towards_eye: DVec3,
}

/// What each sensor receives from each sun through the windows' panes: irradiance (W/m²) per unit
/// radiance of the sun's disc (W/m²sr), that is sr. A point sun counts with the solid angle of the
/// real disc. A receiver of a picture is a sensor like any other.
///
/// `scene` holds what stands inside and outside, without the windows themselves.
///
/// # Errors
/// If there is no window or no usable sensor, if the data are too large, if the device fails, or when
/// stopped by `progress`.
pub fn compute(
    device: &Device,
    scene: &Scene,
    windows: &[(Window, PaneBsdf)],
    sensors: &[Sensor],
    suns: &[Sun],
    options: &PaneOptions,
    progress: &dyn Progress,
) -> Result<PaneSun> {
    for (i, sensor) in sensors.iter().enumerate() {
        if !sensor.position.is_finite() || !sensor.direction.is_finite() || sensor.direction.length() < 1e-12 {
            return Err(Error::new(format!("sensor {} has no usable position and direction", i + 1))
                .help("each line of a points file needs x y z dx dy dz, the direction not zero"));
        }
    }
    let tracer = PaneTracer::new(device, scene, windows, suns, options)?;
    let mut result = tracer.empty(sensors.len(), suns.len());
    let records: Vec<Receiver> = sensors.iter().enumerate().map(|(i, s)| tracer.receiver(i, s)).collect();
    tracer.run(&records, &mut result, progress)?;
    Ok(result)
}

/// The façade as an eye sees it: radiance of points of the windows towards the eye per unit radiance
/// of each sun's disc (rows points, columns suns). The disc itself, seen clearly through a peak or
/// glass, is not part of it.
///
/// # Errors
/// As [`compute`].
pub fn facade(
    device: &Device,
    scene: &Scene,
    windows: &[(Window, PaneBsdf)],
    points: &[FacadeView],
    suns: &[Sun],
    options: &PaneOptions,
    progress: &dyn Progress,
) -> Result<PaneSun> {
    let tracer = PaneTracer::new(device, scene, windows, suns, options)?;
    let mut records = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        let outgoing = p.towards_eye.try_normalize().filter(|_| p.position.is_finite() && p.window < windows.len());
        let Some(outgoing) = outgoing else {
            return Err(Error::new(format!("point {} of the façade has no usable position, window and direction", i + 1)));
        };
        records.push(FacadePoint {
            position: tracer.tables.normalization.point(p.position).to_array(),
            pane: p.window as u32,
            outgoing: outgoing.as_vec3().to_array(),
            number: i as u32,
        });
    }
    let mut result = tracer.empty(points.len(), suns.len());
    tracer.run_facade(&records, &mut result, progress)?;
    Ok(result)
}

#[cfg(test)]
pub(crate) mod tests;

//! Panes, their cells, and the suns as they see them: tables for the device.

use super::kinds::PaneBsdf;
use crate::bsdf::Component;
use crate::error::{Error, Result};
use crate::gpu_struct;
use crate::kernels::bsdf_scattering::{PackedBsdfs, Tables};
use crate::kernels::sun_matrix::options::SunOptions;
use crate::kernels::sun_matrix::sun::Sun;
use crate::kernels::trace::{TraceTables, stream_seed};
use crate::scene::Window;
use glam::DVec3;
use std::f64::consts::PI;

gpu_struct! {
    /// A pane (`sun_matrix/pane.wgsl`).
    pub(crate) struct Pane {
        x: [f32; 3],
        /// First word of its scattering function; NO_SCATTERING if it only lets light through directly.
        words: u32,
        y: [f32; 3],
        first_triangle: u32,
        /// Into the room.
        pub z: [f32; 3],
        triangles: u32,
        /// Factor on the scattering function.
        tint: [f32; 3],
        padding: u32,
    }
}

gpu_struct! {
    /// A sun seen through a pane.
    pub(crate) struct PaneSun {
        /// Transmittance of the direct way.
        clear: [f32; 3],
        /// Squared radius within which scattered light meets the surround of a through-peak; 0: no peak.
        guard: f32,
        /// Scattering function there, 1/sr.
        surround: f32,
        /// Factor on the scattering function.
        scale: f32,
        padding0: u32,
        padding1: u32,
    }
}

gpu_struct! {
    /// A triangle of a pane's area.
    pub(crate) struct PaneCell {
        pub corner: [f32; 3],
        pub pane: u32,
        pub edge1: [f32; 3],
        area: f32,
        pub edge2: [f32; 3],
        padding0: u32,
        /// A random point inside, where light is followed.
        pub position: [f32; 3],
        padding1: u32,
    }
}

crate::gpu_constants! {
    pub(super) const NUMBERS = {
        /// In place of the first word of a scattering function, where there is none.
        const NO_SCATTERING: u32 = u32::MAX;
        /// Suns that one invocation of `sun_matrix/pane_gather` takes.
        pub(super) const GATHERED_SUNS: u32 = 4;
    }
}

/// Panes in the openings, and what they are to the suns.
pub(in super::super) struct PaneTables {
    pub panes: Vec<Pane>,
    /// `[batch][cell]`
    pub cells: Vec<PaneCell>,
    pub words: PackedBsdfs,
    /// `[sun][pane]`
    pub suns: Vec<PaneSun>,
    /// Suns that can reach a pane.
    pub active: Vec<usize>,
    /// Whether a pane lets the disc of a sun be seen.
    pub is_clear: bool,
}

impl PaneTables {
    /// Tables of the windows that `tables` holds.
    ///
    /// # Errors
    /// If the data are too large.
    pub fn new(tables: &TraceTables, windows: &[(Window, PaneBsdf)], suns: &[Sun], options: &SunOptions) -> Result<Self> {
        let mut words = PackedBsdfs::new();
        let mut panes = Vec::new();
        for ((window, bsdf), record) in windows.iter().zip(&tables.windows) {
            let at = |e: Error| e.file(&window.origin.file).line(window.origin.line);
            let first = bsdf.scattering().map(|s| words.push(s, Tables::Evaluate)).transpose().map_err(at)?;
            panes.push(Pane {
                x: record.x,
                words: first.unwrap_or(NO_SCATTERING),
                y: record.y,
                first_triangle: record.first_triangle,
                z: record.z,
                triangles: record.triangles,
                tint: bsdf.tint().map(|v| v as f32),
                padding: 0,
            });
        }
        let reaches = |sun: &Sun| windows.iter().any(|(w, _)| sun.direction.dot(w.frame.z) < 0.0);
        let records: Vec<PaneSun> = suns.iter().flat_map(|sun| windows.iter().map(|(w, bsdf)| sun_record(sun, w, bsdf))).collect();
        Ok(Self {
            panes,
            cells: pane_cells(windows, tables, options),
            words,
            active: (0..suns.len()).filter(|i| reaches(&suns[*i])).collect(),
            is_clear: records.iter().any(|r| r.clear != [0.0; 3]),
            suns: records,
        })
    }
}

/// A sun as one pane sees it.
fn sun_record(sun: &Sun, window: &Window, bsdf: &PaneBsdf) -> PaneSun {
    let incident = -window.frame.to_local(sun.direction.normalize());
    let peak = match bsdf {
        PaneBsdf::PeakBsdf(s) if incident.z > 0.0 => s.peak(incident),
        _ => None,
    };
    let lambertian = bsdf.scattering().and_then(|s| s.lobe(Component::TransmissionFront)).map_or(0.0, |l| l.lambertian / PI);
    PaneSun {
        clear: bsdf.clear(incident).map(|v| v as f32),
        guard: peak.map_or(0.0, |p| p.guard_radius_squared(sun.solid_angle() * incident.z) as f32),
        surround: peak.map_or(0.0, |p| (p.surround + lambertian) as f32),
        scale: bsdf.scale(incident) as f32,
        ..PaneSun::default()
    }
}

/// Cells of the panes that scatter, `[batch][cell]`: every triangle of a window cut into equal ones, each with a
/// random point of its own in every batch.
fn pane_cells(windows: &[(Window, PaneBsdf)], tables: &TraceTables, options: &SunOptions) -> Vec<PaneCell> {
    let scale = tables.normalization.scale;
    let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0;
    let scatters = |(_, (_, bsdf)): &(usize, &(Window, PaneBsdf))| bsdf.scattering().is_some();
    let windows: Vec<(usize, &Window)> = windows.iter().enumerate().filter(scatters).map(|(i, (w, _))| (i, w)).collect();
    let total: f64 = windows.iter().map(|(_, w)| w.area()).sum();
    let mut cells = Vec::new();
    for batch in 0..options.batches {
        for &(pane, window) in &windows {
            for t in window.triangles.iter().filter(|t| area(t) > 0.0) {
                let side = (f64::from(options.cells.max(1)) * area(t) / total).sqrt().round().max(1.0) as usize;
                for k in 0..side * side {
                    let bits = stream_seed(options.seed, batch, cells.len() as u32);
                    let random = [f64::from(bits & 0xffff) / 65536.0, f64::from(bits >> 16) / 65536.0];
                    let [corner, edge1, edge2] = part_of(t, k, side);
                    let [u, v] = if random[0] + random[1] > 1.0 { random.map(|r| 1.0 - r) } else { random };
                    let in_tracer = |p: DVec3| tables.normalization.point(p).to_array();
                    cells.push(PaneCell {
                        corner: in_tracer(corner),
                        pane: pane as u32,
                        edge1: (edge1 * scale).as_vec3().to_array(),
                        area: (area(t) * scale * scale / (side * side) as f64) as f32,
                        edge2: (edge2 * scale).as_vec3().to_array(),
                        padding0: 0,
                        position: in_tracer(corner + edge1 * u + edge2 * v),
                        padding1: 0,
                    });
                }
            }
        }
    }
    cells
}

/// Corner and edges of part `index` of a triangle cut into `side`² equal ones.
fn part_of(t: &[DVec3; 3], index: usize, side: usize) -> [DVec3; 3] {
    let edges = [t[1] - t[0], t[2] - t[0]].map(|e| e / side as f64);
    let row = index.isqrt();
    let (place, column) = (index - row * row, (index - row * row) / 2);
    let corner = |u: usize, v: usize| t[0] + edges[0] * u as f64 + edges[1] * v as f64;
    if place % 2 == 0 {
        [corner(row - column, column), edges[0], edges[1]]
    } else {
        [corner(row - column, column + 1), -edges[0], -edges[1]]
    }
}

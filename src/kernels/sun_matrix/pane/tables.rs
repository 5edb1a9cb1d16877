//! Tables of suns and panes for the device.

use super::{PaneBsdf, PaneCell, PaneOptions, PaneSunRecord, Sun};
use crate::kernels::trace::{TraceTables, stream_seed};
use crate::scene::Window;
use glam::DVec3;
use std::f64::consts::PI;

/// A sun as one pane sees it.
pub(super) fn sun_record(sun: &Sun, window: &Window, bsdf: &PaneBsdf) -> PaneSunRecord {
    let direction = sun.direction.normalize();
    let incident = -window.frame.to_local(direction);
    let peak = match bsdf {
        PaneBsdf::PeakBsdf(s) if incident.z > 0.0 => s.peak(incident),
        _ => None,
    };
    let lambertian = bsdf.scattering().and_then(|s| s.lobe(crate::bsdf::Component::TransmissionFront)).map_or(0.0, |l| l.lambertian / PI);
    PaneSunRecord {
        direction: direction.as_vec3().to_array(),
        chord: sun.chord() as f32,
        clear: bsdf.clear(incident).map(|v| v as f32),
        solid_angle: sun.solid_angle() as f32,
        guard: peak.map_or(0.0, |p| p.guard_radius_squared(sun.solid_angle() * incident.z) as f32),
        surround: peak.map_or(0.0, |p| (p.surround + lambertian) as f32),
        scale: bsdf.scale(incident) as f32,
        padding: 0,
    }
}

/// Cells of the panes, `[batch][cell]`: every triangle of a window cut into equal ones, each with a
/// random point of its own in every batch.
pub(super) fn pane_cells(windows: &[Window], tables: &TraceTables, options: &PaneOptions) -> Vec<PaneCell> {
    let scale = tables.normalization.scale;
    let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0;
    let total: f64 = windows.iter().map(Window::area).sum();
    let mut cells = Vec::new();
    for batch in 0..options.batches {
        for (pane, window) in windows.iter().enumerate() {
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

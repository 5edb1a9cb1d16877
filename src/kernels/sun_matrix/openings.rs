//! Where sunlight comes in.

use super::pane::PaneBsdf;
use crate::gpu_struct;
use crate::kernels::trace::Normalization;
use crate::scene::Window;
use glam::{DVec3, Vec3};

gpu_struct! {
    /// A box that light must pass (`sun_matrix/gates.wgsl`).
    pub(crate) struct Gate {
        x: [f32; 3],
        padding0: u32,
        y: [f32; 3],
        padding1: u32,
        z: [f32; 3],
        padding2: u32,
        low: [f32; 3],
        padding3: u32,
        high: [f32; 3],
        padding4: u32,
    }
}

/// Where sunlight comes in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Openings<'a> {
    /// Wherever the scene leaves it in.
    Anywhere,
    /// Through the polygons of these windows, which are holes for light that comes into their room. They, and
    /// all other windows of the scene, absorb what comes to them from elsewhere.
    Windows(&'a [Window]),
    /// Through the boxes around these windows and the shades before and behind them (corners of their
    /// geometry): slats may let light pass beside the window's own polygon.
    Shaded(&'a [(Window, Vec<DVec3>)]),
    /// Through these windows, which are filled by panes of scattering data.
    Panes(&'a [(Window, PaneBsdf)]),
}

impl Openings<'_> {
    pub(super) fn windows(&self) -> Vec<Window> {
        match self {
            Self::Anywhere => Vec::new(),
            Self::Windows(windows) => windows.to_vec(),
            Self::Shaded(shaded) => shaded.iter().map(|(w, _)| w.clone()).collect(),
            Self::Panes(panes) => panes.iter().map(|(w, _)| w.clone()).collect(),
        }
    }

    pub(super) fn gates(&self, normalization: &Normalization) -> Vec<Gate> {
        let Self::Shaded(shaded) = self else { return Vec::new() };
        let gate = |(window, corners): &(Window, Vec<DVec3>)| {
            let frame = &window.frame;
            // Rounding must not shut out what grazes the box.
            const MARGIN: f32 = 1e-4;
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for corner in window.triangles.iter().flatten().chain(corners) {
                let p = (*corner - normalization.origin) * normalization.scale;
                let local = Vec3::new(p.dot(frame.x) as f32, p.dot(frame.y) as f32, p.dot(frame.z) as f32);
                (low, high) = (low.min(local), high.max(local));
            }
            Gate {
                x: frame.x.as_vec3().to_array(),
                y: frame.y.as_vec3().to_array(),
                z: frame.z.as_vec3().to_array(),
                low: (low - MARGIN).to_array(),
                high: (high + MARGIN).to_array(),
                ..Gate::default()
            }
        };
        shaded.iter().map(gate).collect()
    }
}

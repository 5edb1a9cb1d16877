//! The tracer's coordinates.

use crate::scene;
use glam::{DVec3, Vec3};

/// From the user's coordinates to the tracer's: the origin in the middle of the windows, lengths
/// in units of their size, so that f32 keeps its digits where they matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Normalization {
    /// The tracer's origin in the user's coordinates.
    pub origin: DVec3,
    /// Tracer's units per user's unit.
    pub scale: f64,
}

impl Normalization {
    /// The normalisation for these windows.
    pub fn of(windows: &[scene::Window]) -> Self {
        let area: f64 = windows.iter().map(scene::Window::area).sum();
        let corners = || windows.iter().flat_map(|w| w.triangles.iter().flatten());
        let low = corners().fold(DVec3::INFINITY, |a, &b| a.min(b));
        let high = corners().fold(DVec3::NEG_INFINITY, |a, &b| a.max(b));
        Self { origin: (low + high) / 2.0, scale: 1.0 / (area / windows.len().max(1) as f64).sqrt().max(1e-12) }
    }

    /// The normalisation for a scene without windows that is looked at from these points.
    pub fn around(points: &[DVec3]) -> Self {
        let low = points.iter().fold(DVec3::INFINITY, |a, &b| a.min(b));
        let high = points.iter().fold(DVec3::NEG_INFINITY, |a, &b| a.max(b));
        if points.is_empty() {
            return Self { origin: DVec3::ZERO, scale: 1.0 };
        }
        // Half the diagonal: a room is about as large as the grid of its sensors, a unit at least.
        Self { origin: (low + high) / 2.0, scale: 1.0 / ((high - low).length() / 2.0).max(1.0) }
    }

    /// A point in the tracer's coordinates.
    pub fn point(&self, p: DVec3) -> Vec3 {
        ((p - self.origin) * self.scale).as_vec3()
    }

    /// A point of the tracer's in the user's coordinates.
    pub fn back(&self, p: Vec3) -> DVec3 {
        self.origin + p.as_dvec3() / self.scale
    }
}

//! Points of a window, evenly over its area.

use crate::scene::Window;
use glam::DVec3;

/// Points of a window.
pub(super) struct Opening {
    /// The window.
    pub window: Window,
    /// Shares of the area up to each triangle's end.
    shares: Vec<f64>,
    /// m².
    pub area: f64,
}

impl Opening {
    /// Of a window.
    pub fn new(window: &Window) -> Self {
        let area = window.area();
        let share = |sum: &mut f64, t: &[DVec3; 3]| {
            *sum += (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0 / area;
            Some(*sum)
        };
        let shares = window.triangles.iter().scan(0.0, share).collect();
        Self { window: window.clone(), shares, area }
    }

    /// The point for two numbers in 0…1, evenly spread over the area.
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let number = self.shares.iter().position(|s| u < *s).unwrap_or(self.shares.len() - 1);
        let from = if number == 0 { 0.0 } else { self.shares[number - 1] };
        let root = ((u - from) / (self.shares[number] - from).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0).sqrt();
        let [a, b, c] = self.window.triangles[number];
        a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v)
    }
}

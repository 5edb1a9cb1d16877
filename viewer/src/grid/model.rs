//! What the Grid panel shows for which state.

use super::cells::{Cells, section};
use super::metric::Metric;
use crate::results::Results;
use crate::scale::ScaleChoice;
use glam::DVec2;
use lucarne::image::palette::Palette;
use lucarne::simulate::year::Sensors;

/// Everything the user has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Group of sensors.
    pub group: usize,
    /// Metric.
    pub metric: Metric,
    /// Scale of illuminances; shares go from 0 to 1.
    pub scale: ScaleChoice,
    /// Colours.
    pub palette: Palette,
    /// Contour lines.
    pub contours: bool,
    /// Values beside the sensors.
    pub numbers: bool,
    /// 3-D instead of plan.
    pub solid: bool,
    /// Turn of the 3-D view: yaw and pitch, radians.
    pub turn: [f32; 2],
    /// Enlargement of the 3-D view.
    pub zoom: f32,
}

impl Default for View {
    fn default() -> Self {
        Self {
            group: 0,
            metric: Metric::Autonomy,
            scale: ScaleChoice::automatic(false, 3.0),
            palette: Palette::Viridis,
            contours: true,
            numbers: true,
            solid: false,
            turn: [0.7, 0.6],
            zoom: 1.0,
        }
    }
}

/// Range of a plan: the sensors, and what of the scene lies near them.
pub fn extent(group: &Sensors, results: &Results) -> [DVec2; 2] {
    let cells = Cells::around(&group.positions);
    let (mut low, mut high) = (DVec2::MAX, DVec2::MIN);
    for m in &cells.middles {
        low = low.min(*m - cells.size * 0.5);
        high = high.max(*m + cells.size * 0.5);
    }
    let near = (high - low).max_element().max(2.0) * 0.35;
    if let Some(scene) = results.scene() {
        let height = group.positions.iter().map(|p| p.z).sum::<f64>() / group.count().max(1) as f64;
        let (l, h) = (low - near, high + near);
        // Walls that reach far beyond the sensors are those of the house, not of the room.
        for line in section(scene, height).iter().filter(|line| line.iter().all(|p| p.cmpge(l).all() && p.cmple(h).all())) {
            for p in line {
                low = low.min(*p);
                high = high.max(*p);
            }
        }
    }
    let margin = (high - low).max_element() * 0.04;
    [low - margin, high + margin]
}

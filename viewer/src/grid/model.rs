//! What the Grid panel shows for which state.

use super::metric::Metric;
use crate::results::Results;
use crate::scale::ScaleChoice;
use glam::DVec2;
use lucarne::image::palette::Palette;
use lucarne::scene::outline::{self, Cells, Cut};
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

/// Height of the plan of a group, m: the mean of its sensors.
pub fn height(group: &Sensors) -> f64 {
    group.positions.iter().map(|p| p.z).sum::<f64>() / group.count().max(1) as f64
}

/// Range of a plan: the sensors, and what of the scene lies near them.
pub fn extent(group: &Sensors, results: &Results) -> [DVec2; 2] {
    let lines = results.scene().map(|scene| Cut::plan(height(group)).section(scene)).unwrap_or_default();
    outline::extent(Cells::around(&group.positions).range(), &lines)
}

//! How a window is divided into parts.

use crate::simulate::project::{Parts, WindowSection};
use serde::{Deserialize, Serialize};

/// Of a window that is not divided.
pub(super) const WHOLE_ALL_THE_SAME: &str = "something stands before it, and V and D are averages over the whole: 'lucarne plan' says what that \
                                  changes, parts = \"auto\" divides it";

/// How a window is divided, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Division {
    /// What the project asks for.
    #[serde(skip)]
    pub asked: Parts,
    /// Columns and rows over the rectangle that holds the window.
    pub grid: [usize; 2],
    /// Parts: fields of the grid in which the window has an area.
    pub count: usize,
    /// Why, for people.
    pub because: String,
    /// By what a year's light at the worst sensor (without sensors, at the worst eye) would be wrong if V and D were
    /// averaged over the whole window, relative, as a first look estimates it; absent if none was taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_of_whole: Option<f64>,
    /// The same with these parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_left: Option<f64>,
}

impl Default for Division {
    fn default() -> Self {
        Self { asked: Parts::default(), grid: [1, 1], count: 1, because: String::new(), error_of_whole: None, error_left: None }
    }
}

impl Division {
    /// What a section asks for, undivided yet.
    pub(super) fn of(section: &WindowSection) -> Self {
        Self { asked: section.parts, ..Self::default() }
    }

    /// Whether it is whole though its parts may differ, and nobody looked.
    pub fn is_doubtful(&self) -> bool {
        self.because == WHOLE_ALL_THE_SAME
    }

    /// The parts in words, nothing of a whole window: `32 parts, 4 × 8`.
    pub fn describe(&self) -> Option<String> {
        let [columns, rows] = self.grid;
        (columns * rows > 1).then(|| format!("{} parts, {columns} × {rows}", self.count))
    }
}

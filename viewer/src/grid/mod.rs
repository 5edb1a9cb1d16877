//! The Grid panel: sensors on the room's plan.

pub mod metric;
pub mod model;
mod panel;
pub mod plan;
mod space;

pub use panel::GridPanel;

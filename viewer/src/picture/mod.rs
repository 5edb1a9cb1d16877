//! The picture panel.

pub mod model;
mod panel;
pub mod show;

pub use panel::PicturePanel;

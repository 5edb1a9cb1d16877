//! The picture panel.

pub mod model;
mod panel;
mod place;
pub mod show;

pub use panel::PicturePanel;

//! The BSDF panel.

pub mod disc;
pub mod export;
mod lobe;
pub mod model;
mod paint;
mod panel;
mod side;

pub use paint::palette_choice;
pub use panel::BsdfPanel;

//! The BSDF panel.

pub mod disc;
mod export;
mod lobe;
pub mod model;
mod panel;

pub use panel::{BsdfPanel, palette_choice};

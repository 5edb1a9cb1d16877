//! What the matrices give: illuminance, pictures, glare, each with its error.

pub mod annual;
pub mod control;
pub mod glare;
pub(crate) mod illuminance;
pub mod metrics;
pub(crate) mod mirrored;
mod moments;
mod monthly;
pub mod pictures;
pub(crate) mod sensors;
pub mod states;
pub(crate) mod suns;
pub(crate) mod uncertainty;
pub(crate) mod views;

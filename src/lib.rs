//! Annual daylight and glare simulation of rooms with complex windows, on any GPU.
//!
//! Light from the sky reaches a sensor through four phases, one matrix each:
//! `I = V · T · D · S` with the view matrix V (window → sensor), the window's transmission matrix T,
//! the daylight matrix D (sky → window) and the sky matrix S (one column per hour).

pub mod bins;
pub mod bsdf;
pub mod bvh;
pub mod camera;
pub mod error;
pub mod files;
pub mod glare;
pub mod gpu;
pub mod image;
pub mod kernels;
pub mod limits;
pub mod matrix;
pub mod progress;
pub mod scene;
pub mod simulate;
pub mod sky;
#[cfg(test)]
mod testing;
pub mod text;
pub mod units;
pub mod weather;

pub use error::{Error, Result, Warnings};

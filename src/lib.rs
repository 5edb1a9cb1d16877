//! Annual daylight and glare simulation of rooms with complex windows, on any GPU.
//!
//! Light from the sky reaches a sensor through four phases, one matrix each:
//! `I = V · T · D · S` with the view matrix V (window → sensor), the window's transmission matrix T,
//! the daylight matrix D (sky → window) and the sky matrix S (one column per hour). Five phases add
//! accurate suns. What a user needs to know is in the [`guide`].
//!
//! # Two walks through the code
//!
//! **From points to illuminance.** `lucarne run` ([`simulate::run`]) reads a project
//! ([`simulate::project`]: what is asked) and its files ([`simulate::inputs`]: what is there). The phases
//! ([`simulate::phases`]) make S with [`sky`], D with [`kernels::daylight_matrix`], V with
//! [`kernels::view_matrix`] and Cds with [`kernels::sun_matrix`], each as independent replicates
//! ([`simulate::sampling`]), and keep them in the output folder ([`simulate::store`]). One formula
//! ([`simulate::light`]) makes illuminance of them, and its noise a standard error
//! ([`simulate::results`]).
//!
//! **From a picture to DGP.** A view's rays ([`camera`]) give V of its pixels
//! ([`kernels::image_matrix`]). [`simulate::results::glare`] multiplies it with the light at the windows, tile by
//! tile, finds the sources ([`kernels::glare`]) and judges them ([`glare`]), without writing a picture.
//!
//! # Who imports whom
//!
//! Downwards only; `tests/architecture` holds the list:
//! `files, gpu, bins, matrix → bsdf, weather, sky, scene → bvh, camera, image → glare → kernels → simulate → cli`.
//! The device layer knows nothing of daylight, the readers nothing of the device, the library nothing of
//! the command line and the viewer.
//!
//! # What always holds
//!
//! - **Every kernel has a twin in f64** that is plainly correct, an analytic case, and planted faults that the
//!   comparison finds.
//! - **Same input, seed and device: same bits**, whatever the chunk size, the number of threads, the split of the
//!   work or the place where a run was stopped.
//! - **Every sampled matrix comes as independent replicates**; all errors are made of their spread.
//! - **Paths started are paths finished**: a kernel counts both, and a difference is an error, not darkness.
//! - **Right, a warning, or an error**: what is not modelled is said.

pub mod bins;
pub mod bsdf;
pub mod bvh;
pub mod camera;
pub mod error;
pub mod files;
pub mod glare;
pub mod gpu;
pub mod guide;
pub mod image;
pub mod kernels;
pub mod limits;
pub mod matrix;
pub mod progress;
pub(crate) mod random;
pub mod scene;
pub mod simulate;
pub mod sky;
mod statistics;
#[cfg(test)]
mod testing;
pub mod text;
pub mod units;
pub mod weather;

pub use error::{Error, Result, Warnings};

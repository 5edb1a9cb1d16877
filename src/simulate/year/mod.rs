//! A year of light as a run gives it and as a result folder holds it: illuminance, glare and pictures as
//! arrays, with their errors.
//!
//! [`Year`] is what a folder holds; [`Results`] is that and the room it belongs to. Pictures are not
//! kept in memory: [`picture`] computes any of them from the matrices, [`facade`] the light behind the
//! windows in any state.

mod arrays;
pub mod facade;
mod files;
pub mod metrics;
pub mod picture;
mod results;
mod states;

pub use self::arrays::{Sensors, ViewFile, Year};
pub(super) use self::files::TemporaryFolder;
pub use self::results::{Results, Surroundings};

//! The phases of a run, a file each: what its matrix depends on, whether an earlier run's serves, how it is
//! traced and kept.

pub mod picture_sets;
pub mod pixels;
pub mod sampled;
pub mod sky;
pub mod sun;
pub mod sun_pixels;

//! The phases of a run, a file each: what its matrix depends on, whether an earlier run's serves, how it is
//! traced and kept.

pub(crate) mod facade_suns;
pub(crate) mod picture_sets;
pub(crate) mod pixels;
pub(crate) mod sampled;
pub(crate) mod sky;
pub(crate) mod sun;
pub(crate) mod sun_pixels;

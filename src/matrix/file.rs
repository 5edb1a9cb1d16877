//! Radiance matrix files.

//! Radiance scene files.

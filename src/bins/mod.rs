//! Directional bins: where a direction falls, how large a bin is, and directions inside a bin.
//!
//! | basis | used for | type |
//! |---|---|---|
//! | Klems full, half, quarter and any ring basis of a BSDF file | windows | [`AngleBasis`] |
//! | Tregenza (MF:1), Reinhart MF:2…6, with the ground first | skies | [`ReinhartSky`] |
//! | Shirley-Chiu square | tensor trees, uniform sampling | [`shirley_chiu`] |
//!
//! Each basis has one table; sizes are derived from it and stand nowhere else. Shaders receive
//! the same tables as data.

mod frame;
mod reinhart;
mod rings;
pub mod shirley_chiu;

pub use frame::Frame;
pub use reinhart::ReinhartSky;
pub use rings::{AngleBasis, KlemsBasis, Ring};

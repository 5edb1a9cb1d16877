//! OpenEXR pictures: half or float, RGB or luminance, one picture or one part per hour.
//!
//! RGB is radiance in W/m²sr in Radiance's primaries; the channel Y is luminance in cd/m². The
//! standard attribute `whiteLuminance` says so (179 or 1 cd/m² for the value 1), and reading goes
//! by it. The view is kept as a text attribute `VIEW` of Radiance options, other header lines as
//! `comments`. Data are compressed without loss (ZIP, 16 lines).

mod read;
mod write;

pub use read::{Part, parts, read, read_part};
pub use write::{Parts, write, write_parts};

use crate::error::Error;
use std::path::Path;

/// Precision of the stored samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Samples {
    /// 16 bits: 0.05 % from 6e-5 to 65504; larger values are stored as 65504, with a warning.
    Half,
    /// 32 bits: exact.
    Float,
}

/// What is stored per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channels {
    /// R, G, B: radiance, W/m²sr.
    Rgb,
    /// Y: luminance, cd/m².
    Luminance,
}

/// How to store pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Precision.
    pub samples: Samples,
    /// Content.
    pub channels: Channels,
}

fn exr_error(path: &Path, error: ::exr::error::Error) -> Error {
    use ::exr::error::Error as Exr;
    match error {
        Exr::Io(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            Error::new("the file is truncated").file(path).help("make or copy it again")
        }
        Exr::Io(e) => Error::io(path, &e),
        Exr::NotSupported(what) => Error::new(format!("this kind of EXR is not supported: {what}")).file(path),
        Exr::Invalid(what) => {
            Error::new(format!("not a valid EXR file: {what}")).file(path).help("the file is damaged or no EXR; make or copy it again")
        }
        Exr::Aborted => Error::new("writing was aborted").file(path),
    }
}

#[cfg(test)]
mod tests;

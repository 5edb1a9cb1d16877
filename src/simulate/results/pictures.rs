//! Pictures of many hours from a view matrix of pixels: V · (T·D·S), one picture per column,
//! streamed.
//!
//! ```text
//! V (file or pictures) ──reader──▶ rows of pixels ──product──▶ [hour][pixel][rgb] ──▶ one file per hour
//! ```
//!
//! The three stages overlap. Hours are taken in passes and pixels in bands of whole rows, sized by
//! the memory allowed; V is read once if it fits, else once per pass. Pictures appear under their
//! names when a pass is complete: after an error those of earlier passes are there, whole, and
//! nothing else.

mod passes;
mod request;
mod view;

use self::passes::{HdrFiles, Sizes, Whole, passes};
pub(crate) use self::request::Addition;
pub use self::request::{Output, Request};
pub use self::view::PictureView;
use crate::error::{Error, Result, Warnings};
use crate::image::Picture;
use crate::image::exr;
use crate::kernels::product::Multiplier;
use crate::progress::Progress;

const RGB: usize = 3;

/// Makes one picture per column of the coefficients and writes it.
///
/// # Errors
/// Shapes that do not fit, too little memory, failures of device and file system, and
/// `cancelled`. Pictures of finished passes stay.
pub fn write_pictures(
    multiplier: &dyn Multiplier,
    view: &mut PictureView,
    request: &Request,
    progress: &dyn Progress,
    warnings: &mut Warnings,
) -> Result<()> {
    let Request { coefficients, hours, output, .. } = *request;
    if view.bins != coefficients.rows() {
        return Err(Error::new(format!("'{}' has {} columns (pictures), but {} are needed", view.name(), view.bins, coefficients.rows())));
    }
    assert_eq!((coefficients.cols(), coefficients.components()), (hours.len(), RGB), "one RGB column per hour");
    if hours.is_empty() {
        return Ok(());
    }
    let sizes = Sizes::new(multiplier, view, request)?;
    let [width, height] = [view.width, view.height];
    let title = view.view.clone();
    match output {
        Output::Hdr(pattern) => {
            let mut sinks = HdrFiles { pattern, width, height, view: title, header: request.header };
            passes(multiplier, view, request, &sizes, progress, &mut sinks)
        }
        Output::Exr(pattern, options) => {
            let mut done = |number: usize, pixels: Vec<[f32; 3]>| {
                let mut picture = Picture::new(width, height, pixels)?;
                picture.view.clone_from(&title);
                picture.header = request.header.to_vec();
                exr::write(&pattern.path(number), &picture, *options, warnings)
            };
            passes(multiplier, view, request, &sizes, progress, &mut Whole { pixels: width * height, done: &mut done })
        }
        Output::ExrParts(path, options) => {
            let names = hours.iter().map(|hour| format!("hour_{hour:04}")).collect();
            let parts = exr::Parts { width, height, view: title, header: request.header.to_vec(), names };
            exr::write_parts(path, &parts, *options, warnings, |put| {
                let mut done = |_: usize, pixels: Vec<[f32; 3]>| put(&pixels);
                passes(multiplier, view, request, &sizes, progress, &mut Whole { pixels: width * height, done: &mut done })
            })
        }
    }
}

#[cfg(test)]
mod tests;

//! Picture in which the sources found are coloured.

use super::{Analyser, Glare};
use crate::error::Result;
use crate::image::Picture;
use crate::units::BRIGHTNESS_WEIGHTS;

/// A picture of the luminance as seen, grey, with each source in a colour of its own and, where
/// `show_task` asks for it, the task area bluish. Luminance is kept everywhere, so that the picture
/// can be analysed again. Pixels outside the view are black.
///
/// # Errors
/// If the luminance image does not fit the view.
pub fn check_picture(analyser: &Analyser, luminance: &[f32], glare: &Glare, show_task: bool) -> Result<Picture> {
    let geometry = analyser.geometry();
    let mut pixels: Vec<[f32; 3]> =
        luminance.iter().enumerate().map(|(i, &l)| coloured(if geometry.is_inside(i) { l } else { 0.0 }, [1.0; 3])).collect();
    if show_task {
        for &p in analyser.task_pixels() {
            pixels[p as usize] = coloured(luminance[p as usize], [0.4, 0.4, 1.0]);
        }
    }
    for (n, source) in glare.sources.iter().enumerate() {
        for &p in &source.pixels {
            pixels[p as usize] = coloured(luminance[p as usize], colour(n));
        }
    }
    Picture::new(geometry.width, geometry.height, pixels)
}

/// Radiance of a hue with the given luminance.
fn coloured(luminance: f32, hue: [f64; 3]) -> [f32; 3] {
    let brightness: f64 = hue.iter().zip(BRIGHTNESS_WEIGHTS).map(|(c, w)| c * w).sum();
    hue.map(|c| (f64::from(luminance) / crate::units::LUMINOUS_EFFICACY * c / brightness) as f32)
}

/// Hues far apart for neighbouring numbers: steps of the golden angle around the colour circle.
fn colour(n: usize) -> [f64; 3] {
    let hue = (n as f64 * 0.618_033_988_75).fract() * 6.0;
    let ramp = |shift: f64| ((hue + shift).rem_euclid(6.0) - 3.0).abs() - 1.0;
    // Never quite black in a channel, so that a pixel's RGBE value keeps its grey part visible.
    [ramp(0.0), ramp(4.0), ramp(2.0)].map(|c| c.clamp(0.03, 1.0))
}

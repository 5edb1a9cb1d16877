//! From pixels to colours on the screen, fast enough for scrubbing.

use super::model::{MOST_SIDE, Mode, PictureFile, Tone, View};
use crate::plot::color32;
use eframe::egui::{Color32, ColorImage};
use lucarne::image::palette::{Palette, Scale};
use lucarne::units::LUMINOUS_EFFICACY;
use rayon::prelude::*;

/// Colours of a palette as a table: positions of a scale by one logarithm or division each.
pub struct Colors {
    table: Vec<Color32>,
    low: f32,
    factor: f32,
    log: bool,
}

impl Colors {
    /// Prepares the table.
    pub fn new(palette: Palette, scale: Scale, log: bool) -> Self {
        let table: Vec<Color32> = (0..=1023).map(|i| color32(palette.color(f64::from(i) / 1023.0))).collect();
        let (low, high) = (scale.minimum(), scale.maximum());
        let (low, factor) =
            if log { (low.log2() as f32, (1023.0 / (high / low).log2()) as f32) } else { (low as f32, (1023.0 / (high - low)) as f32) };
        Self { table, low, factor, log }
    }

    /// Colour of a value.
    #[inline]
    pub fn color(&self, value: f32) -> Color32 {
        let v = if self.log { value.max(1e-30).log2() } else { value };
        // The cast clamps below 0 and takes NaN to 0.
        self.table[(((v - self.low) * self.factor + 0.5) as usize).min(1023)]
    }
}

/// The picture's colours; very large pictures are thinned to what a texture can hold.
pub fn image(file: &PictureFile, view: &View, maximum: f64) -> ColorImage {
    let (w, h) = (file.picture.width, file.picture.height);
    let step = w.max(h).div_ceil(MOST_SIDE).max(1);
    let (tw, th) = (w.div_ceil(step), h.div_ceil(step));
    let mut pixels = vec![Color32::BLACK; tw * th];
    let rows = pixels.par_chunks_mut(tw).enumerate();
    match view.mode {
        Mode::Falsecolor => {
            let colors = Colors::new(view.palette, view.scale.scale(maximum), view.scale.log);
            rows.for_each(|(y, row)| {
                for (x, pixel) in row.iter_mut().enumerate() {
                    *pixel = colors.color(file.luminance[y * step * w + x * step]);
                }
            });
        }
        Mode::Photograph => {
            let tone = ToneMap::new(view, file.white());
            rows.for_each(|(y, row)| {
                for (x, pixel) in row.iter_mut().enumerate() {
                    let i = y * step * w + x * step;
                    *pixel = tone.color(file.picture.pixels[i], file.luminance[i]);
                }
            });
        }
    }
    ColorImage::new([tw, th], pixels)
}

/// Radiance to display values.
struct ToneMap {
    gain: f32,
    tone: Tone,
    gamma: Vec<u8>,
}

impl ToneMap {
    fn new(view: &View, white: f64) -> Self {
        let white = (white / LUMINOUS_EFFICACY).max(1e-12) * 2f64.powf(-view.stops);
        let gamma = (0..=4095).map(|i| ((f64::from(i) / 4095.0).powf(1.0 / 2.2) * 255.0).round() as u8).collect();
        Self { gain: (1.0 / white) as f32, tone: view.tone, gamma }
    }

    fn color(&self, rgb: [f32; 3], luminance: f32) -> Color32 {
        let l = (luminance / LUMINOUS_EFFICACY as f32 * self.gain).max(0.0);
        let factor = match self.tone {
            Tone::Linear => 1.0,
            Tone::Reinhard => 4.0 / (1.0 + 4.0 * l),
            Tone::Logarithmic if l > 0.0 => ((l.log10() + 4.0) / 4.0).clamp(0.0, 1.0) / l,
            Tone::Logarithmic => 0.0,
        };
        let [r, g, b] = rgb.map(|c| self.gamma[((c * self.gain * factor).clamp(0.0, 1.0) * 4095.0) as usize]);
        Color32::from_rgb(r, g, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_the_palette_s_colours() {
        for (scale, log) in [(Scale::linear(0.0, 2000.0).unwrap(), false), (Scale::logarithmic(2000.0, 3.0).unwrap(), true)] {
            let colors = Colors::new(Palette::Viridis, scale, log);
            for value in [0.0f32, 1.0, 3.0, 47.0, 500.0, 1999.0, 1e6] {
                let wanted = color32(Palette::Viridis.color(scale.position(f64::from(value))));
                let found = colors.color(value);
                let near = found.to_array().iter().zip(wanted.to_array()).all(|(a, b)| a.abs_diff(b) <= 2);
                assert!(near, "{value} {found:?} {wanted:?}");
            }
        }
    }
}

//! Where a picture lies in its panel, and what is told of a pixel.

use super::model::{Judged, PictureFile, View};
use crate::plot::{self, halo_text};
use eframe::egui::{self, Align2, Color32, Rect, Stroke, vec2};
use lucarne::image::palette::{rounded_number, short_number};

/// Where the picture lies on the screen.
pub struct Placement {
    /// Visible part of the panel.
    pub window: Rect,
    /// The whole picture, perhaps larger than the window.
    pub whole: Rect,
    size: [f64; 2],
}

impl Placement {
    pub fn new(frame: Rect, [w, h]: [usize; 2], view: &View) -> Self {
        let fit = (frame.width() / w as f32).min(frame.height() / h as f32);
        let unit = fit * view.zoom as f32;
        let whole = vec2(w as f32, h as f32) * unit;
        let window = Rect::from_center_size(frame.center(), vec2(whole.x.min(frame.width()), whole.y.min(frame.height())));
        let min = window.center() - vec2(whole.x * view.middle[0] as f32, whole.y * view.middle[1] as f32);
        Self { window, whole: Rect::from_min_size(min, whole), size: [w as f64, h as f64] }
    }

    pub fn share(&self, at: egui::Pos2) -> [f64; 2] {
        [f64::from((at.x - self.whole.left()) / self.whole.width()), f64::from((at.y - self.whole.top()) / self.whole.height())]
    }

    pub fn pixel(&self, at: egui::Pos2) -> [f64; 2] {
        let [u, v] = self.share(at);
        [u * self.size[0], v * self.size[1]]
    }

    pub fn screen(&self, [x, y]: [f64; 2]) -> egui::Pos2 {
        self.whole.min + vec2((x / self.size[0]) as f32 * self.whole.width(), (y / self.size[1]) as f32 * self.whole.height())
    }

    pub fn shift(&self, view: &mut View, delta: egui::Vec2) {
        view.middle[0] -= f64::from(delta.x / self.whole.width());
        view.middle[1] -= f64::from(delta.y / self.whole.height());
        view.keep_inside();
    }
}

/// The pixel at a place in pixels, if there is one.
pub fn pixel_of(file: &PictureFile, [x, y]: [f64; 2]) -> Option<(usize, usize)> {
    let inside = x >= 0.0 && y >= 0.0 && x < file.picture.width as f64 && y < file.picture.height as f64;
    inside.then_some((x as usize, y as usize))
}

/// Outlines of the task and of the glare sources.
pub fn overlay(painter: &egui::Painter, place: &Placement, judged: &Judged, sources: bool) {
    let draw = |edges: &[[[f32; 2]; 2]], color: Color32| {
        for edge in edges {
            let [a, b] = edge.map(|[x, y]| place.screen([f64::from(x), f64::from(y)]));
            painter.line_segment([a, b], Stroke::new(1.6, color));
        }
    };
    draw(&judged.task, Color32::from_rgb(86, 180, 233));
    if sources {
        for (i, (edges, source)) in judged.outlines.iter().zip(&judged.glare.sources).enumerate() {
            draw(edges, Color32::from_rgb(255, 90, 60));
            let at = place.screen([source.x + 0.5, place.size[1] - source.y - 0.5]);
            halo_text(painter, at, Align2::CENTER_CENTER, &(i + 1).to_string(), 14.0);
        }
    }
}

/// What is told of a pixel.
pub fn readout(file: &PictureFile, x: usize, y: usize, judged: Option<&Judged>) -> String {
    let i = y * file.picture.width + x;
    let value = f64::from(file.luminance[i]);
    if file.unit.is_empty() {
        return format!("row {}, column {}: {}", y + 1, x + 1, plot::value_text(value));
    }
    let [r, g, b] = file.picture.pixels[i];
    let mut text = format!(
        "x {x}, y {}   {} cd/m²   RGB {} {} {}",
        file.picture.height - 1 - y,
        rounded_number(value),
        short_number(r.into()),
        short_number(g.into()),
        short_number(b.into())
    );
    if let Some(j) = judged
        && let Some(n) = j.glare.sources.iter().position(|s| s.pixels.binary_search(&(i as u32)).is_ok())
    {
        let s = &j.glare.sources[n];
        text += &format!(
            "   source {}: {} cd/m², {:.4} sr, position index {:.2}",
            n + 1,
            rounded_number(s.luminance),
            s.solid_angle,
            s.position_index
        );
    }
    text
}

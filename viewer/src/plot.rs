//! Small plots that the panels share: axes, curves, and colours that suit either theme.

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Stroke, pos2, vec2};
use lucarne::image::palette::{Color, short_number};

/// A palette's colour for the window.
pub fn color32([r, g, b]: Color) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// Colour of axes and outlines.
pub fn axis(ui: &egui::Ui) -> Color32 {
    ui.visuals().weak_text_color()
}

/// Colour of grid lines.
pub fn grid(ui: &egui::Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_gray(64) } else { Color32::from_gray(216) }
}

/// Background of plots.
pub fn field(ui: &egui::Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_gray(20) } else { Color32::WHITE }
}

/// Two colours for curves, apart for colour-blind readers too (Okabe and Ito), lighter on black.
pub fn line_color(ui: &egui::Ui, index: usize) -> Color32 {
    let light = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167]];
    let dark = [[86, 180, 233], [230, 159, 0], [64, 190, 150], [214, 150, 190]];
    color32(if ui.visuals().dark_mode { dark } else { light }[index % 4])
}

/// Blue over white (dark: black) to orange for signed differences at −1…1.
pub fn diverging(t: f64, dark: bool) -> Color32 {
    let end = if t < 0.0 { [33.0, 102.0, 172.0] } else { [200.0, 90.0, 10.0] };
    let end = if dark { end.map(|c: f64| (c * 1.25).min(255.0)) } else { end };
    let middle = if dark { 34.0 } else { 250.0 };
    let s = t.abs().min(1.0);
    let [r, g, b] = end.map(|c| (middle + (c - middle) * s) as u8);
    Color32::from_rgb(r, g, b)
}

/// Axes of a plot: ranges of values over a rectangle.
#[derive(Debug, Clone, Copy)]
pub struct Axes {
    /// Where the values lie, without labels.
    pub rect: Rect,
    /// Left and right value.
    pub x: [f64; 2],
    /// Bottom and top value.
    pub y: [f64; 2],
}

impl Axes {
    /// Axes inside `outer`, with room for labels.
    pub fn inside(outer: Rect, x: [f64; 2], y: [f64; 2]) -> Self {
        let rect = Rect::from_min_max(outer.min + vec2(46.0, 24.0), outer.max - vec2(12.0, 36.0));
        Self { rect, x, y }
    }

    /// Place of a value.
    pub fn place(&self, x: f64, y: f64) -> Pos2 {
        let u = (x - self.x[0]) / (self.x[1] - self.x[0]);
        let v = (y - self.y[0]) / (self.y[1] - self.y[0]);
        pos2(self.rect.left() + self.rect.width() * u as f32, self.rect.bottom() - self.rect.height() * v as f32)
    }

    /// Value at a place.
    pub fn value(&self, p: Pos2) -> [f64; 2] {
        let u = f64::from((p.x - self.rect.left()) / self.rect.width());
        let v = f64::from((self.rect.bottom() - p.y) / self.rect.height());
        [self.x[0] + u * (self.x[1] - self.x[0]), self.y[0] + v * (self.y[1] - self.y[0])]
    }

    /// Frame, grid, numbers and names.
    pub fn paint(&self, ui: &egui::Ui, title: &str, x_name: &str, x_ticks: &[f64], y_ticks: &[f64]) {
        let painter = ui.painter();
        let (ink, weak) = (ui.visuals().text_color(), grid(ui));
        painter.rect_filled(self.rect, 0.0, field(ui));
        for &t in x_ticks {
            let p = self.place(t, self.y[0]);
            painter.line_segment([p, pos2(p.x, self.rect.top())], Stroke::new(1.0, weak));
            painter.text(p + vec2(0.0, 4.0), Align2::CENTER_TOP, short_number(t), FontId::proportional(11.0), ink);
        }
        for &t in y_ticks {
            let p = self.place(self.x[0], t);
            painter.line_segment([p, pos2(self.rect.right(), p.y)], Stroke::new(1.0, weak));
            painter.text(p - vec2(5.0, 0.0), Align2::RIGHT_CENTER, short_number(t), FontId::proportional(11.0), ink);
        }
        painter.rect_stroke(self.rect, 0.0, Stroke::new(1.0, axis(ui)), egui::StrokeKind::Middle);
        if !title.is_empty() {
            painter.text(self.rect.left_top() - vec2(0.0, 6.0), Align2::LEFT_BOTTOM, title, FontId::proportional(12.5), ink);
        }
        painter.text(pos2(self.rect.center().x, self.rect.bottom() + 19.0), Align2::CENTER_TOP, x_name, FontId::proportional(11.5), ink);
    }

    /// A curve, cut off at the frame.
    pub fn curve(&self, ui: &egui::Ui, points: impl IntoIterator<Item = [f64; 2]>, color: Color32, width: f32) {
        let points: Vec<Pos2> =
            points.into_iter().filter(|p| p[0].is_finite() && p[1].is_finite()).map(|[x, y]| self.place(x, y)).collect();
        ui.painter().with_clip_rect(self.rect.expand(1.0)).add(egui::Shape::line(points, Stroke::new(width, color)));
    }
}

/// Text with a halo, for numbers over pictures.
pub fn halo_text(painter: &egui::Painter, at: Pos2, anchor: Align2, text: &str, size: f32) {
    for d in [vec2(-1.0, 0.0), vec2(1.0, 0.0), vec2(0.0, -1.0), vec2(0.0, 1.0)] {
        painter.text(at + d, anchor, text, FontId::proportional(size), Color32::BLACK);
    }
    painter.text(at, anchor, text, FontId::proportional(size), Color32::WHITE);
}

/// A title above a field, cut off where the field ends.
pub fn title_above(ui: &egui::Ui, field: Rect, title: &str) {
    let mut job = egui::text::LayoutJob::simple_singleline(title.to_string(), FontId::proportional(13.0), ui.visuals().text_color());
    job.wrap = egui::text::TextWrapping::truncate_at_width(field.width());
    let text = ui.painter().layout_job(job);
    ui.painter().galley(field.left_top() - vec2(0.0, 6.0 + text.size().y), text, Color32::PLACEHOLDER);
}

/// Dims what is shown in place of something else, and says what it is.
pub fn veil(ui: &egui::Ui, rect: Rect, text: &str) {
    let fill = ui.visuals().panel_fill;
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 0.0, Color32::from_rgba_unmultiplied(fill.r(), fill.g(), fill.b(), 170));
    let text = painter.layout(text.to_string(), FontId::proportional(12.5), ui.visuals().strong_text_color(), rect.width() - 28.0);
    let place = Rect::from_center_size(rect.center(), text.size() + vec2(16.0, 8.0));
    painter.rect(place, 3.0, fill, Stroke::new(1.0, axis(ui)), egui::StrokeKind::Inside);
    painter.galley(place.min + vec2(8.0, 4.0), text, Color32::PLACEHOLDER);
}

/// A value with as many digits as help: four after the point, or a power of ten where it is small
/// or large.
pub fn value_text(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (0.01..1e5).contains(&size) { format!("{value:.4}") } else { format!("{value:.4e}") }
}

/// What an empty panel says: a heading and how to go on.
pub fn empty_state(ui: &mut egui::Ui, heading: &str, lines: &[&str]) {
    let top = (ui.available_height() * 0.32).max(10.0);
    ui.vertical_centered(|ui| {
        ui.add_space(top);
        ui.heading(heading);
        ui.add_space(6.0);
        for line in lines {
            ui.label(*line);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_place_and_read_back() {
        let axes = Axes { rect: Rect::from_min_size(pos2(10.0, 20.0), vec2(100.0, 50.0)), x: [0.0, 90.0], y: [0.0, 1.0] };
        assert_eq!(axes.place(45.0, 1.0), pos2(60.0, 20.0));
        let [x, y] = axes.value(pos2(60.0, 45.0));
        assert!((x - 45.0).abs() < 1e-6 && (y - 0.5).abs() < 1e-6);
    }

    #[test]
    fn values_keep_the_digits_of_the_command_line() {
        assert_eq!(value_text(0.678912), "0.6789");
        assert_eq!(value_text(0.0), "0.0000");
        assert_eq!(value_text(1.5e-5), "1.5000e-5");
    }
}

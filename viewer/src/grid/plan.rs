//! The plan: cells in their colours inside the room's outline.

use super::model::{extent, height};
use crate::plot::{self, color32, halo_text};
use crate::results::Results;
use crate::scale::{BAR_WIDTH, ColorBar};
use eframe::egui::{self, Align2, FontId, Rect, Sense, Stroke, pos2, vec2};
use glam::DVec2;
use lucarne::image::palette::{Palette, Scale, readable_on, rounded_number, short_number};
use lucarne::scene::outline::{Cells, Cut};
use lucarne::simulate::year::Sensors;

/// Where a plan lies on the screen: x to the right, y (north) up.
pub struct Frame {
    rect: Rect,
    low: DVec2,
    unit: f64,
}

impl Frame {
    /// Fits a range of the plan into a rectangle.
    pub fn fit(rect: Rect, [low, high]: [DVec2; 2]) -> Self {
        let size = (high - low).max(DVec2::splat(1e-3));
        let unit = (f64::from(rect.width()) / size.x).min(f64::from(rect.height()) / size.y);
        let used = vec2((size.x * unit) as f32, (size.y * unit) as f32);
        Self { rect: Rect::from_center_size(rect.center(), used), low, unit }
    }

    /// Place of a point.
    pub fn screen(&self, p: DVec2) -> egui::Pos2 {
        let d = (p - self.low) * self.unit;
        pos2(self.rect.left() + d.x as f32, self.rect.bottom() - d.y as f32)
    }

    /// Point at a place.
    pub fn point(&self, p: egui::Pos2) -> DVec2 {
        self.low + DVec2::new(f64::from(p.x - self.rect.left()), f64::from(self.rect.bottom() - p.y)) / self.unit
    }

    /// Points per metre.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// The part of the screen it fills.
    pub fn rect(&self) -> Rect {
        self.rect
    }
}

/// What a plan shows.
pub struct Plan<'a> {
    /// Sensors.
    pub group: &'a Sensors,
    /// Results they belong to.
    pub results: &'a Results,
    /// Value by sensor.
    pub values: &'a [f64],
    /// Colours.
    pub palette: Palette,
    /// Scale.
    pub scale: &'a Scale,
    /// Contour levels with their names.
    pub contours: Vec<(f64, String)>,
    /// Text of a value inside its cell; none if it is empty.
    pub label: &'a dyn Fn(f64) -> String,
}

impl Plan<'_> {
    /// Paints it; gives the sensor under the pointer.
    pub fn paint(&self, ui: &mut egui::Ui, rect: Rect) -> Option<usize> {
        let frame = Frame::fit(rect.shrink(4.0), extent(self.group, self.results));
        let cells = Cells::around(&self.group.positions);
        let painter = ui.painter_at(rect);
        painter.rect_filled(frame.rect(), 0.0, plot::field(ui));
        let half = cells.size * 0.5;
        let cell_points = vec2((cells.size.x * frame.unit()) as f32, (cells.size.y * frame.unit()) as f32);
        for (i, (m, v)) in cells.middles.iter().zip(self.values).enumerate() {
            let color = self.palette.color(self.scale.position(*v));
            let cell = Rect::from_two_pos(frame.screen(*m - half), frame.screen(*m + half));
            let outline: Vec<egui::Pos2> = cells.outline(i).into_iter().map(|p| frame.screen(p)).collect();
            let bounds = Rect::from_points(&outline);
            // Cells of even grids are rectangles.
            if outline.iter().all(|p| (p.x == bounds.left() || p.x == bounds.right()) && (p.y == bounds.top() || p.y == bounds.bottom())) {
                painter.rect_filled(bounds.shrink(0.5), 0.0, color32(color));
            } else {
                painter.add(egui::Shape::convex_polygon(outline, color32(color), Stroke::new(1.0, plot::field(ui))));
            }
            let text = (self.label)(*v);
            if cell_points.x > 26.0 && cell_points.y > 15.0 && !text.is_empty() {
                painter.text(
                    cell.center(),
                    Align2::CENTER_CENTER,
                    text,
                    FontId::proportional((cell_points.x / 3.4).clamp(9.0, 13.0)),
                    color32(readable_on(color)),
                );
            }
        }
        if let Some(scene) = self.results.scene() {
            let clip = painter.with_clip_rect(frame.rect().intersect(rect));
            for [a, b] in Cut::plan(height(self.group)).section(scene) {
                clip.line_segment([frame.screen(a), frame.screen(b)], Stroke::new(1.6, ui.visuals().text_color()));
            }
        }
        for (level, name) in &self.contours {
            let lines = cells.contour(self.values, *level);
            for (width, color) in [(3.2, egui::Color32::from_black_alpha(150)), (1.4, egui::Color32::WHITE)] {
                for [a, b] in &lines {
                    painter.line_segment([frame.screen(*a), frame.screen(*b)], Stroke::new(width, color));
                }
            }
            let first = lines.iter().flatten().min_by(|p, q| p.x.total_cmp(&q.x));
            if let Some(p) = first {
                halo_text(&painter, frame.screen(*p) + vec2(-3.0, 0.0), Align2::RIGHT_CENTER, name, 11.5);
            }
        }
        scale_bar(ui, &frame);
        let hover = ui.interact(frame.rect(), ui.scope_id().with("plan"), Sense::hover()).hover_pos()?;
        let under = cells.at(frame.point(hover))?;
        let m = cells.middles[under];
        painter.rect_stroke(
            Rect::from_two_pos(frame.screen(m - half), frame.screen(m + half)),
            0.0,
            Stroke::new(2.0, ui.visuals().strong_text_color()),
            egui::StrokeKind::Middle,
        );
        Some(under)
    }
}

/// A metre or so, and north.
fn scale_bar(ui: &egui::Ui, frame: &Frame) {
    let painter = ui.painter();
    let most = f64::from(frame.rect().width()) * 0.4;
    let length = [50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5].into_iter().find(|l| l * frame.unit() < most).unwrap_or(0.1);
    let (a, ink) = (frame.rect().left_bottom() + vec2(6.0, 14.0), Stroke::new(1.5, ui.visuals().text_color()));
    let b = a + vec2((length * frame.unit()) as f32, 0.0);
    painter.line_segment([a, b], ink);
    painter.text(b + vec2(6.0, 0.0), Align2::LEFT_CENTER, format!("{} m", short_number(length)), FontId::proportional(11.5), ink.color);
    let n = frame.rect().right_bottom() + vec2(-10.0, 22.0);
    painter.arrow(n, vec2(0.0, -14.0), ink);
    painter.text(n + vec2(-10.0, -6.0), Align2::CENTER_CENTER, "N", FontId::proportional(11.5), ink.color);
}

/// One line about a sensor.
pub fn sensor_text(group: &Sensors, sensor: usize, value: &str) -> String {
    let p = group.positions[sensor];
    format!("{} {}   x {:.2}  y {:.2}  z {:.2} m   {value}", group.name, sensor + 1, p.x, p.y, p.z)
}

/// The plan of one hour for the Year panel, with a legend; gives a line about the pointer.
#[allow(clippy::too_many_arguments)]
pub fn hour_plan(
    ui: &mut egui::Ui,
    rect: Rect,
    results: &Results,
    group: &Sensors,
    values: &[f64],
    palette: Palette,
    scale: &Scale,
    title: &str,
) -> Option<String> {
    ui.painter().text(rect.min + vec2(46.0, 0.0), Align2::LEFT_TOP, title, FontId::proportional(13.0), ui.visuals().text_color());
    let inner = Rect::from_min_max(rect.min + vec2(46.0, 22.0), rect.max - vec2(BAR_WIDTH + 14.0, 26.0));
    let label = |v: f64| rounded_number(v);
    let plan = Plan { group, results, values, palette, scale, contours: Vec::new(), label: &label };
    let under = plan.paint(ui, inner);
    let right = Frame::fit(inner.shrink(4.0), extent(group, results)).rect().right();
    let bar = Rect::from_min_max(pos2(right + 18.0, inner.top()), pos2(right + 18.0 + BAR_WIDTH, inner.bottom()));
    let color = |t: f64| color32(palette.color(t));
    let ticks = scale.ticks(6).into_iter().map(|v| (scale.position(v), short_number(v))).collect();
    ColorBar { color: &color, label: "lx", ticks, mark: under.map(|s| scale.position(values[s])) }.paint(ui, bar);
    under.map(|s| sensor_text(group, s, &format!("{} lx", rounded_number(values[s]))))
}

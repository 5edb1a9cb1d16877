//! The colour scale a user chooses, and the bar that shows it and can be dragged.

use crate::plot::{self, color32};
use eframe::egui::{self, Align2, FontId, Pos2, Rect, Sense, Stroke, pos2, vec2};
use lucarne::image::palette::{Palette, Scale, round_up, short_number};

/// Linear or logarithmic, with an end chosen by the user or by the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaleChoice {
    /// Logarithmic.
    pub log: bool,
    /// Decades below the end of a logarithmic scale.
    pub decades: f64,
    /// Upper end; `None` takes the data's.
    pub maximum: Option<f64>,
}

impl ScaleChoice {
    /// A scale whose end follows the data.
    pub fn automatic(log: bool, decades: f64) -> Self {
        Self { log, decades, maximum: None }
    }

    /// The scale for data of this largest value.
    pub fn scale(&self, largest: f64) -> Scale {
        let top = self.end(largest);
        let made = if self.log { Scale::logarithmic(top, self.decades.clamp(0.5, 12.0)) } else { Scale::linear(0.0, top) };
        made.unwrap_or_else(|_| Scale::linear(0.0, 1.0).expect("0 to 1 is a scale"))
    }

    /// The upper end for data of this largest value.
    pub fn end(&self, largest: f64) -> f64 {
        self.maximum.filter(|m| m.is_finite() && *m > 0.0).unwrap_or_else(|| round_up(largest))
    }

    /// Controls in a side panel.
    pub fn controls(&mut self, ui: &mut egui::Ui, largest: f64, unit: &str) {
        ui.horizontal(|ui| {
            ui.selectable_value(&mut self.log, false, "Linear");
            ui.selectable_value(&mut self.log, true, "Log").on_hover_text("Key L");
            if self.log {
                ui.add(egui::DragValue::new(&mut self.decades).range(0.5..=10.0).speed(0.05).max_decimals(1).suffix(" decades"));
            }
        });
        ui.horizontal(|ui| {
            let mut automatic = self.maximum.is_none();
            if ui
                .checkbox(&mut automatic, "Automatic end")
                .on_hover_text("The end of the scale follows the data. Dragging the colour bar sets it by hand.")
                .changed()
            {
                self.maximum = if automatic { None } else { Some(self.end(largest)) };
            }
            if let Some(maximum) = &mut self.maximum {
                let speed = *maximum * 0.01;
                ui.add(egui::DragValue::new(maximum).range(1e-9..=1e12).speed(speed).custom_formatter(|v, _| short_number(v)));
                ui.label(unit);
            }
        });
    }
}

/// Width that a bar with its numbers takes.
pub const BAR_WIDTH: f32 = 74.0;

/// What a colour bar shows.
pub struct ColorBar<'a> {
    /// Colour of a position 0…1 from the bottom.
    pub color: &'a dyn Fn(f64) -> egui::Color32,
    /// Quantity or unit above it.
    pub label: &'a str,
    /// Values with their positions.
    pub ticks: Vec<(f64, String)>,
    /// A value to mark, as position.
    pub mark: Option<f64>,
}

impl ColorBar<'_> {
    /// Paints the bar at the left of `rect`.
    pub fn paint(&self, ui: &egui::Ui, rect: Rect) -> Rect {
        let painter = ui.painter();
        let text = ui.visuals().text_color();
        painter.text(rect.left_top(), Align2::LEFT_TOP, self.label, FontId::proportional(12.0), text);
        let bar = Rect::from_min_max(pos2(rect.left(), rect.top() + 22.0), pos2(rect.left() + 16.0, rect.bottom() - 6.0));
        let mut mesh = egui::Mesh::default();
        const STEPS: u32 = 64;
        for k in 0..=STEPS {
            let t = f64::from(k) / f64::from(STEPS);
            let y = bar.bottom() - bar.height() * t as f32;
            let color = (self.color)(t);
            mesh.colored_vertex(pos2(bar.left(), y), color);
            mesh.colored_vertex(pos2(bar.right(), y), color);
            if k > 0 {
                let i = 2 * k;
                mesh.add_triangle(i - 2, i - 1, i);
                mesh.add_triangle(i - 1, i, i + 1);
            }
        }
        painter.add(mesh);
        painter.rect_stroke(bar, 0.0, Stroke::new(1.0, plot::axis(ui)), egui::StrokeKind::Outside);
        let mut last = f32::INFINITY;
        for (position, label) in &self.ticks {
            let y = bar.bottom() - bar.height() * *position as f32;
            if last - y < 13.0 || !(bar.top() - 1.0..=bar.bottom() + 1.0).contains(&y) {
                continue;
            }
            last = y;
            painter.line_segment([pos2(bar.right(), y), pos2(bar.right() + 4.0, y)], Stroke::new(1.0, plot::axis(ui)));
            painter.text(pos2(bar.right() + 7.0, y), Align2::LEFT_CENTER, label, FontId::proportional(12.0), text);
        }
        if let Some(mark) = self.mark {
            let y = bar.bottom() - bar.height() * mark.clamp(0.0, 1.0) as f32;
            let tip = pos2(bar.left() - 1.0, y);
            painter.add(egui::Shape::convex_polygon(vec![tip, tip + vec2(-7.0, -4.0), tip + vec2(-7.0, 4.0)], text, Stroke::NONE));
        }
        bar
    }
}

/// A colour bar of a palette that can be dragged: the upper half moves the end, the lower half of a
/// logarithmic scale the decades; a double click makes it automatic again.
pub fn draggable_bar(
    ui: &mut egui::Ui,
    rect: Rect,
    choice: &mut ScaleChoice,
    largest: f64,
    palette: Palette,
    label: &str,
    mark: Option<f64>,
) {
    let scale = choice.scale(largest);
    let ticks = scale.ticks(8).into_iter().map(|v| (scale.position(v), short_number(v))).collect();
    let color = |t: f64| color32(palette.color(t));
    let bar = ColorBar { color: &color, label, ticks, mark: mark.map(|v| scale.position(v)) }.paint(ui, rect);
    let id = ui.scope_id().with(("bar", label, rect.left() as i32));
    let response = ui.interact(bar.expand(4.0), id, Sense::click_and_drag());
    if response.double_clicked() {
        choice.maximum = None;
    } else if response.dragged() {
        let delta = response.drag_delta().y / bar.height();
        let start: Option<Pos2> = ui.input(|i| i.pointer.press_origin());
        let lower = start.is_some_and(|p| p.y > bar.center().y);
        if lower && choice.log {
            choice.decades = (choice.decades - f64::from(delta) * 4.0).clamp(0.5, 10.0);
        } else {
            choice.maximum = Some(choice.end(largest) * f64::from(-delta * 3.0).exp());
        }
    }
    response
        .on_hover_cursor(egui::CursorIcon::ResizeVertical)
        .on_hover_text("Drag the upper half to move the end, the lower half for the decades of a log scale; double click: automatic");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_follow_the_data_or_the_user() {
        let mut c = ScaleChoice::automatic(false, 3.0);
        assert_eq!(c.scale(1234.0).maximum(), 1500.0);
        assert_eq!(c.scale(0.0).maximum(), 1.0);
        assert_eq!(c.scale(f64::NAN).maximum(), 1.0);
        c.maximum = Some(70.0);
        c.log = true;
        let s = c.scale(1234.0);
        assert!((s.minimum() - 0.07).abs() < 1e-12 && s.maximum() == 70.0);
        c.maximum = Some(-1.0);
        assert_eq!(c.scale(3.0).maximum(), 3.0);
    }
}

//! The hour itself: its picture, its day, its plan.

use super::YearPanel;
use super::model::View;
use super::panel::plan_group;
use crate::grid;
use crate::picture::model::Mode;
use crate::picture::show;
use crate::plot::{self, Axes, halo_text};
use crate::results::Results;
use crate::scale::{BAR_WIDTH, draggable_bar};
use eframe::egui::{self, Align2, Color32, FontId, Rect, Sense, Stroke, pos2, vec2};
use lucarne::glare::annual::GlareClass;
use lucarne::image::palette::{round_steps, round_up, rounded_number};
use lucarne::weather::time::steps_per_day;
use std::sync::Arc;

/// How long a picture may be late before it is dimmed, s: while an hour is dragged pictures are always
/// late by a frame or two.
const PATIENCE: f64 = 0.3;

impl YearPanel {
    /// The carpet's quantity over the day of the hour.
    pub(super) fn day(&self, ui: &mut egui::Ui, rect: Rect, view: &mut View, results: &Results) {
        let per_day = steps_per_day(results.hours());
        let first = view.hour - view.hour % per_day;
        let day = &self.values.1[first..(first + per_day).min(self.values.1.len())];
        let top = if view.quantity.is_glare() { 1.0 } else { round_up(day.iter().copied().filter(|v| !v.is_nan()).fold(1.0, f64::max)) };
        let axes = Axes::inside(rect, [0.0, 24.0], [0.0, top]);
        let title = self.titled(format!("{} on this day, {}", view.quantity.name(results), view.quantity.unit()));
        axes.paint(ui, &title, "hour of the day", &[0.0, 6.0, 12.0, 18.0, 24.0], &round_steps(0.0, top, 5));
        let width = 24.0 / per_day as f64;
        let points: Vec<[f64; 2]> = day.iter().enumerate().map(|(i, v)| [(i as f64 + 0.5) * width, *v]).collect();
        axes.curve(ui, points.iter().copied(), plot::line_color(ui, 0), 2.0);
        if let Some([x, y]) = points.get(view.hour - first).filter(|p| !p[1].is_nan()) {
            ui.painter().circle_filled(axes.place(*x, *y), 5.0, plot::line_color(ui, 1));
        }
        let response = ui.interact(axes.rect, ui.scope_id().with("day"), Sense::click_and_drag());
        if let Some(p) = response.interact_pointer_pos() {
            let step = (axes.value(p)[0] / width).floor().clamp(0.0, per_day as f64 - 1.0) as usize;
            view.hour = (first + step).min(results.hours() - 1);
        }
    }

    pub(super) fn plan(&mut self, ui: &mut egui::Ui, rect: Rect, view: &View, results: &Arc<Results>) {
        let index = plan_group(results);
        let Some(group) = results.sensors.get(index).filter(|g| !g.positions.is_empty()) else { return };
        let lux = self.states.lux(&results.windows, &view.fractions);
        let matrix = lux.lux.and_then(|l| l.get(index)).unwrap_or(&group.illuminance);
        let values: Vec<f64> = (0..matrix.rows()).map(|s| f64::from(matrix.at(s, view.hour)[0])).collect();
        // One scale for carpet and plan where both show illuminance.
        let scale = view.carpet.scale(if view.quantity.is_glare() { self.plan_maximum } else { self.values.2 });
        let title = format!("{} on the plan, lx", group.name);
        if let Some(said) = grid::plan::hour_plan(ui, rect, results, group, &values, view.palette, &scale, &title) {
            self.readout = said;
        }
        if let Some(note) = &self.plan_note {
            plot::veil(ui, rect, note);
        }
    }

    /// Gives the left edge of what is beside the picture.
    pub(super) fn hour_picture(&mut self, ui: &mut egui::Ui, rect: Rect, view: &mut View, results: &Results) -> f32 {
        let note = self.picture_note(results);
        let Some(shown) = &self.shown else {
            let text = self.failed.clone().unwrap_or_else(|| "reading the view matrix…".into());
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(14.0), plot::axis(ui));
            return rect.right();
        };
        let (w, h) = (shown.file.picture.width as f32, shown.file.picture.height as f32);
        let facts = (rect.width() * 0.5).min(210.0);
        let room = vec2(rect.width() - BAR_WIDTH - 24.0 - facts, rect.height() - 4.0);
        let unit = (room.x / w).min(room.y / h);
        let place = Rect::from_min_size(pos2(rect.left() + 46.0, rect.top()), vec2(w, h) * unit);
        let maximum = shown.maximum;
        let key = format!("{} {:?} {:?} {:?} {}", shown.file.id, view.mode, view.palette, view.picture, view.stops);
        let texture = self.picture.get(ui.ctx(), key, false, || show::image(&shown.file, &view.picture_view(), maximum));
        ui.painter().image(texture, place, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        ui.painter().rect_stroke(place, 0.0, Stroke::new(1.0, plot::axis(ui)), egui::StrokeKind::Outside);
        let glare = self.glare.as_ref().filter(|(wish, _)| *wish == shown.wish).and_then(|(_, j)| j.as_ref());
        let screen = |x: f64, y: f64| place.min + vec2(x as f32, y as f32) * unit;
        if view.sources
            && let Some(j) = glare
        {
            for (i, (edges, source)) in j.outlines.iter().zip(&j.glare.sources).enumerate() {
                for [a, b] in edges {
                    let line = [screen(a[0].into(), a[1].into()), screen(b[0].into(), b[1].into())];
                    ui.painter().line_segment(line, Stroke::new(1.6, Color32::from_rgb(255, 90, 60)));
                }
                halo_text(
                    ui.painter(),
                    screen(source.x + 0.5, f64::from(h) - source.y - 0.5),
                    Align2::CENTER_CENTER,
                    &(i + 1).to_string(),
                    13.0,
                );
            }
        }
        if let (Some(note), Some(since)) = (&note, self.picture_late) {
            let left = PATIENCE - (ui.input(|i| i.time) - since);
            if left <= 0.0 || self.failed.is_some() {
                plot::veil(ui, place, note);
            } else {
                ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(left));
            }
        }
        let mut under = None;
        if let Some(p) = ui.interact(place, ui.scope_id().with("hour-picture"), Sense::hover()).hover_pos() {
            let (x, y) = (((p.x - place.left()) / unit) as usize, ((p.y - place.top()) / unit) as usize);
            if x < shown.file.picture.width && y < shown.file.picture.height {
                let value = f64::from(shown.file.luminance[y * shown.file.picture.width + x]);
                under = Some(value);
                self.readout = format!("x {x}, y {}   {} cd/m²", shown.file.picture.height - 1 - y, rounded_number(value));
            }
        }
        let mut left = place.right() + 14.0;
        if view.mode == Mode::Falsecolor {
            let bar = Rect::from_min_max(pos2(left, place.top()), pos2(left + BAR_WIDTH, place.bottom()));
            draggable_bar(ui, bar, &mut view.picture, maximum, view.palette, "cd/m²", under);
            left = bar.right() + 10.0;
        }
        let mut lines = Vec::new();
        if let Some(note) = note {
            lines.extend([(String::new(), false), (note, false)]);
        } else if let Some(j) = glare {
            let i = &j.glare.indices;
            lines.push((format!("DGP {:.3}", i.dgp), true));
            lines.push((format!("of this picture: {}", GlareClass::of(i.dgp).name()), false));
            lines.push((format!("Ev {} lx", rounded_number(j.glare.vertical_illuminance)), false));
            lines.push((format!("UGR {}", if i.ugr < 0.0 { "–".into() } else { format!("{:.1}", i.ugr) }), false));
            let count = j.glare.sources.len();
            lines.push((format!("{count} glare source{}", if count == 1 { "" } else { "s" }), false));
            if j.partial {
                lines.push(("the view is no hemisphere:".into(), false));
                lines.push(("Ev and DGP are too low".into(), false));
            }
        }
        lines.push((format!("mean {} cd/m²", rounded_number(shown.mean)), false));
        lines.push((
            match shown.seconds {
                _ if !shown.whole => "reading the view matrix…".into(),
                s if s < 0.5 => format!("computed in {:.0} ms", s * 1e3),
                s => format!("read and computed in {s:.1} s"),
            },
            false,
        ));
        for (i, (line, strong)) in lines.iter().enumerate() {
            let (size, color) = if *strong { (20.0, ui.visuals().strong_text_color()) } else { (13.0, ui.visuals().text_color()) };
            let y = place.top() + if i == 0 { 0.0 } else { 8.0 + 20.0 * i as f32 };
            ui.painter().text(pos2(left, y), Align2::LEFT_TOP, line, FontId::proportional(size), color);
        }
        if let Some(failed) = &self.failed {
            ui.painter().text(place.left_bottom(), Align2::LEFT_BOTTOM, failed, FontId::proportional(12.0), plot::line_color(ui, 1));
        }
        left
    }
}

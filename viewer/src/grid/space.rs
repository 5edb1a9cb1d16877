//! The sensors in space, inside the room's edges.

use super::model::View;
use crate::plot::{self, color32};
use eframe::egui::{self, Align2, FontId, Rect, Sense, Stroke, pos2, vec2};
use glam::{DVec2, DVec3};
use lucarne::image::palette::{Palette, Scale};
use lucarne::scene::outline::Cells;
use lucarne::simulate::year::Sensors;

/// Parallel projection, turned by two angles.
struct Camera {
    center: DVec3,
    unit: f64,
    middle: egui::Pos2,
    yaw: (f64, f64),
    pitch: (f64, f64),
}

impl Camera {
    fn turn(&self, p: DVec3) -> DVec3 {
        let d = p - self.center;
        let (s, c) = self.yaw;
        let (x, y) = (d.x * c + d.y * s, d.y * c - d.x * s);
        let (s, c) = self.pitch;
        // Right, up, towards the viewer.
        DVec3::new(x, y * s + d.z * c, d.z * s - y * c)
    }

    fn screen(&self, p: DVec3) -> (egui::Pos2, f64) {
        let t = self.turn(p);
        (self.middle + vec2((t.x * self.unit) as f32, (-t.y * self.unit) as f32), t.z)
    }
}

/// Paints the group with the room's edges; gives the sensor under the pointer.
#[allow(clippy::too_many_arguments)]
pub fn show(
    ui: &mut egui::Ui,
    rect: Rect,
    group: &Sensors,
    edges: &[[DVec3; 2]],
    values: &[f64],
    palette: Palette,
    scale: &Scale,
    view: &mut View,
) -> Option<usize> {
    let response = ui.interact(rect, ui.scope_id().with("space"), Sense::click_and_drag());
    if response.dragged() {
        let d = response.drag_delta();
        view.turn = [view.turn[0] - d.x * 0.01, (view.turn[1] + d.y * 0.01).clamp(0.02, 1.55)];
    }
    if response.hovered() {
        let wheel = ui.input(|i| i.smooth_scroll_delta().y);
        view.zoom = (view.zoom * (wheel * 0.004).exp()).clamp(0.3, 12.0);
    }
    let (mut low, mut high) = (DVec3::MAX, DVec3::MIN);
    for p in &group.positions {
        low = low.min(*p);
        high = high.max(*p);
    }
    // Surroundings far away are drawn, but do not set the size.
    let reach = (high - low).max_element().max(2.0) * 0.8;
    let near = |p: &DVec3| p.cmpge(low - reach).all() && p.cmple(high + reach).all();
    let (mut l, mut h) = (low, high);
    let inside: Vec<&[DVec3; 2]> = edges.iter().filter(|e| e.iter().all(near)).collect();
    for p in inside.iter().flat_map(|e| e.iter()) {
        l = l.min(*p);
        h = h.max(*p);
    }
    let size = (h - l).length().max(1.0);
    let camera = Camera {
        center: (l + h) * 0.5,
        unit: f64::from(rect.width().min(rect.height())) / size * f64::from(view.zoom),
        middle: rect.center(),
        yaw: f64::from(view.turn[0]).sin_cos(),
        pitch: f64::from(view.turn[1]).sin_cos(),
    };
    let painter = ui.painter_at(rect);
    for [a, b] in &inside {
        painter.line_segment([camera.screen(*a).0, camera.screen(*b).0], Stroke::new(1.0, plot::axis(ui)));
    }
    let cells = Cells::around(&group.positions);
    let half = cells.size * 0.5;
    let mut order: Vec<usize> = (0..group.positions.len().min(values.len())).collect();
    let depth: Vec<f64> = group.positions.iter().map(|p| camera.screen(*p).1).collect();
    order.sort_by(|a, b| depth[*a].total_cmp(&depth[*b]));
    let pointer = response.hover_pos();
    let mut under = None;
    for i in order {
        let p = group.positions[i];
        let (u, v) = match group.directions.get(i) {
            // Sensors that look sideways stand upright.
            Some(d) if d.z.abs() < 0.5 => (DVec3::new(-d.y, d.x, 0.0).normalize_or_zero() * 0.15, DVec3::Z * 0.15),
            _ => (DVec3::X * half.x, DVec3::Y * half.y),
        };
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| camera.screen(p + u * a + v * b).0);
        if pointer.is_some_and(|at| holds(&corners, at)) {
            under = Some((i, corners));
        }
        let color = color32(palette.color(scale.position(values[i])));
        painter.add(egui::Shape::convex_polygon(corners.to_vec(), color, Stroke::new(0.5, plot::field(ui))));
    }
    if let Some((_, corners)) = under {
        painter.add(egui::Shape::closed_line(corners.to_vec(), Stroke::new(2.0, ui.visuals().strong_text_color())));
    }
    let foot = pos2(rect.left() + 34.0, rect.bottom() - 30.0);
    let north = camera.turn(camera.center + DVec3::Y).truncate() * DVec2::new(1.0, -1.0) * 22.0;
    painter.arrow(foot, vec2(north.x as f32, north.y as f32), Stroke::new(1.5, ui.visuals().text_color()));
    painter.text(
        foot + vec2(north.x as f32, north.y as f32) * 1.5,
        Align2::CENTER_CENTER,
        "N",
        FontId::proportional(12.0),
        ui.visuals().text_color(),
    );
    response.on_hover_cursor(egui::CursorIcon::Grab);
    under.map(|(i, _)| i)
}

fn holds(corners: &[egui::Pos2; 4], p: egui::Pos2) -> bool {
    let side = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)
    };
    (0..4).all(|k| side(k) >= 0.0) || (0..4).all(|k| side(k) <= 0.0)
}

//! Parts of the BSDF panel's drawing: discs, rims, patches, and small controls.

use super::disc::{Disc, full_circle, limits, middle};
use super::model::View;
use crate::list::choose;
use crate::plot;
use eframe::egui::{self, Align2, Color32, FontId, Rect, RichText, Stroke, pos2, vec2};
use lucarne::bins::AngleBasis;
use lucarne::image::palette::Palette;

pub fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(8.0);
    ui.label(RichText::new(text).strong().size(14.0));
}

/// Chooses a palette.
pub fn palette_choice(ui: &mut egui::Ui, palette: &mut Palette) {
    let list = egui::ComboBox::from_id_salt("palette").width(84.0);
    choose(ui, list, palette.name(), Palette::ALL.map(|p| (p, p.name().to_string())), palette);
}

/// Green that is no green: a blue-green distinct from [`fault_color`] for colour-blind readers.
pub fn ok_color(ui: &egui::Ui) -> Color32 {
    plot::line_color(ui, 2)
}

pub fn fault_color(ui: &egui::Ui) -> Color32 {
    plot::line_color(ui, 1)
}

pub fn pixels(ui: &egui::Ui, disc: Disc) -> usize {
    ((2.0 * disc.radius * ui.ctx().pixels_per_point()).round() as usize).clamp(32, 1400)
}

pub fn title(ui: &egui::Ui, disc: Disc, title: &str, about: &str) {
    let at = disc.center - vec2(0.0, disc.radius + 24.0);
    let ink = ui.visuals().text_color();
    ui.painter().text(at - vec2(0.0, 16.0), Align2::CENTER_CENTER, title, FontId::proportional(15.0), ui.visuals().strong_text_color());
    ui.painter().text(at + vec2(0.0, 1.0), Align2::CENTER_CENTER, about, FontId::proportional(12.0), ink);
}

pub fn image(ui: &egui::Ui, disc: Disc, texture: egui::TextureId) {
    let rect = Rect::from_center_size(disc.center, vec2(2.0, 2.0) * disc.radius);
    ui.painter().image(texture, rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
}

pub fn rim(ui: &egui::Ui, disc: Disc) {
    ui.painter().circle_stroke(disc.center, disc.radius, Stroke::new(1.2, ui.visuals().text_color()));
    for (phi, anchor) in
        [(0.0, Align2::LEFT_CENTER), (90.0, Align2::CENTER_BOTTOM), (180.0, Align2::RIGHT_CENTER), (270.0, Align2::CENTER_TOP)]
    {
        let p = disc.place(90.0, phi);
        let out = (p - disc.center) / disc.radius * 3.0;
        ui.painter().text(p + out, anchor, format!("{phi}°"), FontId::proportional(11.0), plot::axis(ui));
    }
}

pub fn rings(ui: &egui::Ui, disc: Disc) {
    let line = Stroke::new(0.8, Color32::from_white_alpha(90));
    for theta in [15.0, 30.0, 45.0, 60.0, 75.0] {
        ui.painter().add(egui::Shape::line(full_circle(90).map(|phi| disc.place(theta, phi)).collect(), line));
    }
}

pub fn patches(ui: &egui::Ui, disc: Disc, basis: &AngleBasis, view: &View) {
    let line = Stroke::new(0.8, Color32::from_white_alpha(110));
    for bin in 0..basis.len() {
        let (theta, phi) = limits(basis, bin);
        if view.grid {
            ui.painter().add(egui::Shape::closed_line(disc.outline(theta, phi), line));
        }
        if view.numbers {
            let [t, p] = middle(basis, bin);
            let size = (disc.radius / 22.0).clamp(7.0, 13.0);
            plot::halo_text(ui.painter(), disc.place(t, p), Align2::CENTER_CENTER, &(bin + 1).to_string(), size);
        }
    }
}

/// A ring around the direction of the incident light.
pub fn marker(ui: &egui::Ui, disc: Disc, [theta, phi]: [f64; 2]) {
    let at = disc.place(theta, phi);
    ui.painter().circle_stroke(at, 5.5, Stroke::new(3.5, Color32::WHITE));
    ui.painter().circle_stroke(at, 5.5, Stroke::new(1.6, Color32::BLACK));
}

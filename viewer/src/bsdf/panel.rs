//! Painting the BSDF panel and taking its clicks.

use super::disc::{Disc, Projection, direction, disc_image, limits};
use super::lobe::Lobe;
use super::model::{BsdfFile, Compare, Integrals, Readout, View, angles_text, largest};
use super::paint::{image, marker, patches, pixels, rim, rings, title};
use crate::job::Derived;
use crate::outbox::Outbox;
use crate::plot::{self, Axes, color32, empty_state};
use crate::scale::{BAR_WIDTH, ColorBar, draggable_bar};
use crate::texture::CachedTexture;
use eframe::egui::{self, Align2, Color32, FontId, Key, Rect, Sense, Stroke, pos2, vec2};
use glam::DVec3;
use lucarne::bsdf::check::Finding;
use lucarne::bsdf::{Block, Component};
use lucarne::image::palette::{Scale, short_number};
use std::sync::Arc;

/// What belongs to one file.
#[derive(Default)]
pub struct Slot {
    pub(super) integrals: Derived<String, Option<Integrals>>,
    pub(super) findings: Derived<u64, Vec<Finding>>,
    pub(super) incident: CachedTexture,
    pub(super) outgoing: CachedTexture,
    pub(super) lobe: Lobe,
}

/// The panel with its files (one, or two that are compared).
#[derive(Default)]
pub struct BsdfPanel {
    pub(super) files: Vec<Arc<BsdfFile>>,
    pub(super) slots: [Slot; 2],
    pub(super) difference: CachedTexture,
    pub(super) readout: String,
}

impl BsdfPanel {
    /// Shows a file: the first, or the second of two to compare.
    pub fn open(&mut self, file: BsdfFile, view: &mut View, beside: bool) {
        if beside && self.files.len() == 1 {
            self.files.push(Arc::new(file));
        } else {
            view.fit(&file);
            self.files = vec![Arc::new(file)];
        }
    }

    /// Number of files shown.
    pub fn count(&self) -> usize {
        self.files.len()
    }

    /// Whether values are still being computed.
    pub fn busy(&self) -> bool {
        self.slots.iter().any(|s| s.integrals.busy() || s.findings.busy())
    }

    /// Keys of this panel.
    pub fn keys(&mut self, ui: &egui::Ui, view: &mut View) {
        let Some(file) = self.files.first().cloned() else { return };
        let pressed = |key: Key| ui.input(|i| i.key_pressed(key) && i.modifiers.is_none());
        for (key, around, outward) in [(Key::ArrowRight, -1, 0), (Key::ArrowLeft, 1, 0), (Key::ArrowUp, 0, 1), (Key::ArrowDown, 0, -1)] {
            if pressed(key) {
                view.step(&file, around, outward);
            }
        }
        for (key, component) in [Key::T, Key::B, Key::R, Key::F].into_iter().zip(Component::ALL) {
            if pressed(key) && file.blocks(view.band).get(component).is_some() {
                view.component = component;
                view.snap(&file);
            }
        }
        if pressed(Key::L) {
            view.scale.log = !view.scale.log;
        }
        if pressed(Key::G) {
            view.grid = !view.grid;
        }
        if pressed(Key::N) {
            view.numbers = !view.numbers;
        }
        if pressed(Key::D) {
            view.compare = if view.compare == Compare::Difference { Compare::SideBySide } else { Compare::Difference };
        }
        if pressed(Key::P) {
            let at = Projection::ALL.iter().position(|p| *p == view.projection).unwrap_or(0);
            view.projection = Projection::ALL[(at + 1) % 4];
        }
    }

    /// Paints the panel.
    pub fn show(&mut self, ui: &mut egui::Ui, view: &mut View, out: &mut Outbox) {
        if self.files.is_empty() {
            empty_state(
                ui,
                "No BSDF is open",
                &[
                    "Drop a BSDF file (.xml of WINDOW, genBSDF or Lucarne) here, or open one with Ctrl+O.",
                    "A second file, dropped while one is open, is compared with the first.",
                ],
            );
            return;
        }
        self.update(ui.ctx(), view);
        egui::Panel::left("bsdf-side").exact_size(272.0).resizable(false).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| self.side(ui, view, out));
        });
        egui::CentralPanel::default().show(ui, |ui| self.center(ui, view));
    }

    fn update(&mut self, ctx: &egui::Context, view: &View) {
        for (file, slot) in self.files.iter().zip(&mut self.slots) {
            let key = format!("{} {:?} {:?}", file.id, view.band, view.component);
            slot.integrals.update(ctx, key, || {
                let (file, view) = (file.clone(), view.clone());
                move || view.block(&file).map(Integrals::of)
            });
            slot.findings.update(ctx, file.id, || {
                let file = file.clone();
                move || file.findings()
            });
        }
    }

    /// Largest value of all files for the incident direction.
    pub(super) fn largest(&self, view: &View) -> f64 {
        self.files.iter().filter_map(|f| Some(largest(view.block(f)?, view.incident))).fold(0.0, f64::max)
    }

    fn center(&mut self, ui: &mut egui::Ui, view: &mut View) {
        let area = ui.available_rect_before_wrap();
        let status = Rect::from_min_max(pos2(area.left(), area.bottom() - 22.0), area.max);
        let area = Rect::from_min_max(area.min, pos2(area.right(), status.top()));
        let discs = self.files.len() + 1;
        let width = (area.width() - BAR_WIDTH * 2.0) / discs as f32;
        let side = width.min(area.height() * 0.60 - 30.0).max(60.0);
        let top = Rect::from_min_size(area.min, vec2(area.width(), side + 44.0));
        let radius = side / 2.0 - 20.0;
        let projection = view.projection;
        let disc_at = |k: usize, extra: f32| Disc {
            center: pos2(top.left() + extra + width * (k as f32 + 0.5), top.top() + 26.0 + side / 2.0),
            radius,
            projection,
        };
        self.readout = "Point at a hemisphere to read values; click the left one to choose where light comes from".into();
        // Bars stand right of the incident disc and right of the last one.
        let incident_disc = disc_at(0, 0.0);
        let bar_height = vec2(BAR_WIDTH, 2.0 * radius.max(40.0));
        self.incident_disc(ui, incident_disc, view);
        let bar = Rect::from_min_size(incident_disc.center + vec2(radius + 26.0, -radius), bar_height);
        let palette = view.palette;
        let color = |t: f64| color32(palette.color(t));
        let ticks = (0..=5).map(|i| (f64::from(i) / 5.0, format!("{:.1}", f64::from(i) / 5.0))).collect();
        let mark = self.slots[0].integrals.current().and_then(|v| v.as_ref()).map(|v| v.at(direction(view.incident)));
        ColorBar { color: &color, label: "share", ticks, mark }.paint(ui, bar);
        let top_value = self.largest(view);
        let scale = view.scale.scale(top_value);
        let mut hovered = None;
        for i in 0..self.files.len() {
            let disc = disc_at(i + 1, BAR_WIDTH);
            if i == 1 && view.compare == Compare::Difference {
                self.difference_disc(ui, disc, view, top_value);
            } else {
                hovered = self.outgoing_disc(ui, disc, view, i, &scale).or(hovered);
            }
        }
        let last = disc_at(self.files.len(), BAR_WIDTH);
        let bar = Rect::from_min_size(last.center + vec2(radius + 26.0, -radius), bar_height);
        if self.files.len() == 2 && view.compare == Compare::Difference {
            let dark = ui.visuals().dark_mode;
            let color = |t: f64| plot::diverging(2.0 * t - 1.0, dark);
            let end = self.largest_difference(view);
            let ticks = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|s: f64| ((s + 1.0) / 2.0, short_number(s * end))).to_vec();
            ColorBar { color: &color, label: "B−A, /sr", ticks, mark: None }.paint(ui, bar);
        } else {
            draggable_bar(ui, bar, &mut view.scale, top_value, view.palette, "1/sr", hovered);
        }
        let below = Rect::from_min_max(pos2(area.left(), top.bottom() + 4.0), area.max);
        if below.height() > 60.0 {
            let split = below.left() + below.width() * 0.5;
            self.curve(ui, Rect::from_min_max(below.min, pos2(split, below.bottom())), view);
            self.lobes(ui, Rect::from_min_max(pos2(split, below.top()), below.max), view, &scale);
        }
        ui.painter().text(
            status.left_center() + vec2(4.0, 0.0),
            Align2::LEFT_CENTER,
            &self.readout,
            FontId::proportional(13.0),
            ui.visuals().text_color(),
        );
    }

    fn incident_disc(&mut self, ui: &mut egui::Ui, disc: Disc, view: &mut View) {
        let file = self.files[0].clone();
        let Some(block) = view.block(&file) else { return };
        let slot = &mut self.slots[0];
        let words = if view.component.is_transmission() { "transmitted" } else { "reflected" };
        let about = match self.files.len() {
            1 => format!("share {words} from each direction"),
            _ => format!("light along {}", angles_text(view.incident)),
        };
        title(ui, disc, "Incident", &about);
        let size = pixels(ui, disc);
        let key = format!(
            "{} {:?} {:?} {:?} {:?} {size} {}",
            file.id,
            view.band,
            view.component,
            view.projection,
            view.palette,
            slot.integrals.current().is_some()
        );
        let palette = view.palette;
        let integrals = slot.integrals.current().and_then(|v| v.as_ref());
        let empty = plot::field(ui);
        let texture = slot.incident.get(ui.ctx(), key, true, || {
            disc_image(size, view.projection, |d| integrals.map_or(empty, |v| color32(palette.color(v.at(d)))))
        });
        image(ui, disc, texture);
        if let Block::Klems(m) = block {
            patches(ui, disc, m.incident(), view);
        } else {
            rings(ui, disc);
        }
        rim(ui, disc);
        let area = Rect::from_center_size(disc.center, vec2(2.0, 2.0) * disc.radius);
        let response = ui.interact(area, ui.scope_id().with("incident"), Sense::click_and_drag());
        let mut chosen = view.incident;
        if (response.clicked() || response.dragged())
            && let Some(angles) = response.interact_pointer_pos().and_then(|p| disc.angles(p))
        {
            chosen = [angles[0].min(89.0), angles[1]];
        }
        if let Some(angles) = response.hover_pos().and_then(|p| disc.angles(p)) {
            self.readout = format!("Incident   {}", Readout::incident(block, angles).text(&format!("share {words}"), ""));
        }
        if chosen != view.incident {
            view.incident = chosen;
            view.snap(&file);
        }
        if let Some(Block::Klems(m)) = view.block(&file) {
            let (theta, phi) = limits(m.incident(), m.incident().bin_of(direction(view.incident)));
            let outline = disc.outline(theta, phi);
            ui.painter().add(egui::Shape::closed_line(outline.clone(), Stroke::new(4.0, Color32::WHITE)));
            ui.painter().add(egui::Shape::closed_line(outline, Stroke::new(2.0, Color32::BLACK)));
        } else {
            marker(ui, disc, view.incident);
        }
    }

    /// Gives the value under the pointer.
    fn outgoing_disc(&mut self, ui: &mut egui::Ui, disc: Disc, view: &View, i: usize, scale: &Scale) -> Option<f64> {
        let file = self.files[i].clone();
        let letter = if self.files.len() == 2 { ["A: ", "B: "][i] } else { "" };
        let Some(block) = view.block(&file) else {
            title(ui, disc, &format!("{letter}Outgoing"), "not in this file");
            rim(ui, disc);
            return None;
        };
        let total = block.direct_hemispherical(direction(view.incident));
        let words = if view.component.is_transmission() { "transmitted" } else { "reflected" };
        // Two discs side by side have no room for the angles, which the incident disc tells.
        let light = if letter.is_empty() { format!("light along {}: ", angles_text(view.incident)) } else { String::new() };
        title(ui, disc, &format!("{letter}Outgoing"), &format!("{light}{total:.4} {words}"));
        let size = pixels(ui, disc);
        let key = format!(
            "{} {:?} {:?} {:?} {:?} {:?} {scale:?} {size}",
            file.id, view.band, view.component, view.incident, view.projection, view.palette
        );
        let texture = self.slots[i].outgoing.get(ui.ctx(), key, true, || {
            let (palette, incident) = (view.palette, direction(view.incident));
            let color = |v: f64| color32(palette.color(scale.position(v)));
            match block {
                Block::Klems(m) => {
                    let from = m.incident().bin_of(incident);
                    let table: Vec<Color32> = (0..m.outgoing().len()).map(|o| color(m.at(o, from))).collect();
                    disc_image(size, view.projection, |d| table[m.outgoing().bin_of(d)])
                }
                Block::Tree(_) => disc_image(size, view.projection, |d: DVec3| color(block.evaluate(d, incident))),
            }
        });
        image(ui, disc, texture);
        if let Block::Klems(m) = block {
            patches(ui, disc, m.outgoing(), view);
        } else {
            rings(ui, disc);
        }
        rim(ui, disc);
        marker(ui, disc, view.incident);
        let area = Rect::from_center_size(disc.center, vec2(2.0, 2.0) * disc.radius);
        let angles = ui.interact(area, ui.scope_id().with(("outgoing", i)), Sense::hover()).hover_pos().and_then(|p| disc.angles(p))?;
        let readout = Readout::outgoing(block, view.incident, angles);
        self.readout = format!("Outgoing {letter}  {}", readout.text("f", " /sr"));
        Some(readout.value)
    }

    fn largest_difference(&self, view: &View) -> f64 {
        let top = self.largest(view);
        lucarne::image::palette::round_up(view.scale.maximum.unwrap_or(top) * 0.5)
    }

    fn difference_disc(&mut self, ui: &mut egui::Ui, disc: Disc, view: &View, _top: f64) {
        let (a, b) = (self.files[0].clone(), self.files[1].clone());
        let (Some(x), Some(y)) = (view.block(&a), view.block(&b)) else {
            title(ui, disc, "Difference B − A", "one file lacks this component");
            rim(ui, disc);
            return;
        };
        let incident = direction(view.incident);
        let sums = y.direct_hemispherical(incident) - x.direct_hemispherical(incident);
        title(ui, disc, "Difference B − A", &format!("{sums:+.4} of the light"));
        let (size, end, dark) = (pixels(ui, disc), self.largest_difference(view), ui.visuals().dark_mode);
        let key =
            format!("{} {} {:?} {:?} {:?} {:?} {end} {dark} {size}", a.id, b.id, view.band, view.component, view.incident, view.projection);
        let texture = self.difference.get(ui.ctx(), key, true, || {
            disc_image(size, view.projection, |d: DVec3| plot::diverging((y.evaluate(d, incident) - x.evaluate(d, incident)) / end, dark))
        });
        image(ui, disc, texture);
        if let Block::Klems(m) = x {
            patches(ui, disc, m.outgoing(), view);
        }
        rim(ui, disc);
        marker(ui, disc, view.incident);
        let area = Rect::from_center_size(disc.center, vec2(2.0, 2.0) * disc.radius);
        if let Some(angles) = ui.interact(area, ui.scope_id().with("difference"), Sense::hover()).hover_pos().and_then(|p| disc.angles(p)) {
            let (p, q) = (Readout::outgoing(x, view.incident, angles), Readout::outgoing(y, view.incident, angles));
            self.readout = format!(
                "Difference   {}   A {}   B {}",
                Readout { value: q.value - p.value, ..p.clone() }.text("B − A", " /sr"),
                plot::value_text(p.value),
                plot::value_text(q.value)
            );
        }
    }

    fn curve(&mut self, ui: &mut egui::Ui, rect: Rect, view: &View) {
        let axes = Axes::inside(rect, [0.0, 90.0], [0.0, 1.0]);
        let words = if view.component.is_transmission() { "transmittance" } else { "reflectance" };
        axes.paint(
            ui,
            &format!("Direct-hemispherical {words}, mean over φ"),
            "incidence θ, degrees",
            &[0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0],
            &[0.0, 0.2, 0.4, 0.6, 0.8, 1.0],
        );
        let place = axes.place(view.incident[0], 0.0);
        ui.painter().line_segment([place, pos2(place.x, axes.rect.top())], Stroke::new(1.0, plot::axis(ui)));
        let hover = ui.interact(axes.rect, ui.scope_id().with("curve"), Sense::hover()).hover_pos();
        for i in 0..self.files.len() {
            let Some(Some(v)) = self.slots[i].integrals.current() else { continue };
            axes.curve(ui, v.curve.iter().copied(), plot::line_color(ui, i), 2.0);
            let name = if self.files.len() == 2 { ["A  ", "B  "][i] } else { "" };
            let text = format!("{name}diffuse light {:.4}", v.hemispherical);
            ui.painter().text(
                axes.rect.right_top() + vec2(-8.0, 8.0 + 17.0 * i as f32),
                Align2::RIGHT_TOP,
                text,
                FontId::proportional(12.5),
                plot::line_color(ui, i),
            );
            if let Some(p) = hover {
                let theta = (axes.value(p)[0] / 5.0).round().clamp(0.0, 17.0) * 5.0;
                if let Some([t, value]) = v.curve.iter().find(|c| (c[0] - theta).abs() < 0.1) {
                    ui.painter().circle_filled(axes.place(*t, *value), 3.5, plot::line_color(ui, i));
                    self.readout = if i == 0 {
                        format!("Incidence θ {t}°   {name}{value:.4}")
                    } else {
                        format!("{}   {name}{value:.4}", self.readout)
                    };
                }
            }
        }
    }

    fn lobes(&mut self, ui: &mut egui::Ui, rect: Rect, view: &mut View, scale: &Scale) {
        let title = if view.scale.log { "Lobe (logarithmic radius)" } else { "Lobe" };
        ui.painter().text(rect.min + vec2(10.0, 18.0), Align2::LEFT_BOTTOM, title, FontId::proportional(12.5), ui.visuals().text_color());
        let response = ui.interact(rect, ui.scope_id().with("lobe"), Sense::drag());
        if response.dragged() {
            let d = response.drag_delta();
            view.turn = [view.turn[0] + d.x * 0.01, (view.turn[1] + d.y * 0.01).clamp(-1.5, 1.5)];
        }
        response.on_hover_cursor(egui::CursorIcon::Grab);
        let n = self.files.len();
        for i in 0..n {
            let file = self.files[i].clone();
            let width = rect.width() / n as f32;
            let part = Rect::from_min_size(rect.min + vec2(width * i as f32, 0.0), vec2(width, rect.height()));
            let key = format!("{} {:?} {:?} {:?} {scale:?}", file.id, view.band, view.component, view.incident);
            self.slots[i].lobe.update(key, file.blocks(view.band), view, scale);
            self.slots[i].lobe.paint(ui, part, view);
        }
    }
}

//! The side of the Year panel: carpet, picture, façade, sky.

use super::YearPanel;
use super::dome;
use super::model::{Quantity, View, glare_quantity};
use crate::args::PanelKind;
use crate::bsdf::model::BsdfFile;
use crate::bsdf::palette_choice;
use crate::list::choose;
use crate::outbox::Outbox;
use crate::picture::model::Mode;
use crate::results::Results;
use eframe::egui::{self, Key, RichText, vec2};
use std::sync::Arc;

impl YearPanel {
    pub(super) fn side(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>, out: &mut Outbox) {
        ui.add_space(4.0);
        if let Some(quantity) = glare_quantity(results, view.quantity) {
            let button = egui::Button::new(RichText::new("Worst glare hour").strong()).min_size(vec2(ui.available_width() - 4.0, 30.0));
            let hint = "Goes to the hour of the year with the highest glare probability; of hours with the same, to that with the \
                        most light at the eye (key W)";
            if ui.add(button).on_hover_text(hint).clicked() {
                self.go_to_worst(view, results, None);
            }
            ui.horizontal(|ui| {
                for (name, places, hint) in [("Previous", -1, "The hour that is worse by a place (key P)"), ("Next", 1, "Key N")] {
                    if ui.button(name).on_hover_text(hint).clicked() {
                        self.go_to_worst(view, results, Some(places));
                    }
                }
                let text = self.ranking.1.text(view.hour, quantity.unit());
                ui.add(egui::Label::new(RichText::new(text).small()).wrap());
            });
        }
        heading(ui, "Carpet");
        let mut choices: Vec<Quantity> = (0..results.glare.len()).flat_map(|v| [Quantity::Dgp(v), Quantity::Class(v)]).collect();
        choices.extend((0..results.sensors.len()).map(Quantity::Mean));
        for (g, group) in results.sensors.iter().enumerate() {
            choices.extend((0..group.count()).map(|s| Quantity::Sensor(g, s)));
            choices.extend(group.directions.iter().enumerate().filter(|(_, d)| d.z.abs() < 0.5).map(|(s, _)| Quantity::Simplified(g, s)));
        }
        let list = egui::ComboBox::from_id_salt("quantity").width(ui.available_width() - 12.0).height(420.0);
        let choices = choices.into_iter().map(|c| (c, c.name(results)));
        choose(ui, list, &view.quantity.name(results), choices, &mut view.quantity);
        if !view.quantity.is_glare() {
            view.carpet.controls(ui, self.values.2, "lx");
        }
        ui.horizontal(|ui| {
            palette_choice(ui, &mut view.palette);
            if ui.button("Sensors on their plan").on_hover_text("The Grid panel").clicked() {
                out.show(PanelKind::Grid);
            }
        });
        self.picture_controls(ui, view, results, out);
        self.facade_controls(ui, view, results, out);
        heading(ui, "Sky");
        let sun = results.weather().and_then(|w| Some(w.sun(w.records.get(view.hour)?)));
        let sky = self.sky.current().and_then(Option::as_ref).filter(|s| view.hour < s.cols()).map(|s| (s, view.hour));
        if sky.is_none() && sun.is_none() && !self.sky.busy() {
            ui.weak("The folder holds no sky matrix.");
        } else if let Some(said) = dome::show(ui, &mut self.dome, sky, sun, view.palette) {
            self.readout = said;
        } else {
            self.readout.clear();
        }
        if let Some(sun) = sun {
            let text = if sun.is_up() {
                format!(
                    "Sun {:.0}° high, azimuth {:.0}°; 0.1 … 100 kcd/m², log",
                    sun.altitude.to_degrees(),
                    sun.azimuth.to_degrees().rem_euclid(360.0)
                )
            } else {
                "The sun is below the horizon".into()
            };
            ui.label(RichText::new(text).small());
        }
    }

    fn add_state_of(&mut self, path: &std::path::Path, out: &mut Outbox) {
        match BsdfFile::read(path) {
            Ok(file) => self.add_state(file),
            Err(e) => out.error(e.to_string()),
        }
    }

    fn picture_controls(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>, out: &mut Outbox) {
        if results.views.is_empty() {
            if !results.windows.is_empty() {
                heading(ui, "Picture");
                ui.add(
                    egui::Label::new(
                        RichText::new("Add a [[view]] to the project and run it again, to see the room at every hour.").small().weak(),
                    )
                    .wrap(),
                );
            }
            return;
        }
        heading(ui, "Picture");
        if results.views.len() > 1 {
            let shown = &results.views[view.view.min(results.views.len() - 1)].name;
            let choices = results.views.iter().enumerate().map(|(i, v)| (i, v.name.clone()));
            choose(ui, egui::ComboBox::from_id_salt("view"), shown, choices, &mut view.view);
        }
        ui.horizontal(|ui| {
            ui.selectable_value(&mut view.mode, Mode::Falsecolor, "Falsecolour");
            ui.selectable_value(&mut view.mode, Mode::Photograph, "Photograph");
        });
        match view.mode {
            Mode::Falsecolor => {
                ui.push_id("picture", |ui| view.picture.controls(ui, self.picture_maximum(), "cd/m²"));
            }
            Mode::Photograph => {
                ui.add(egui::Slider::new(&mut view.stops, -8.0..=8.0).step_by(0.25).text("stops"));
            }
        }
        ui.horizontal(|ui| {
            ui.checkbox(&mut view.sources, "Glare sources");
            if let Some(shown) = &self.shown
                && ui.button("Save HDR…").clicked()
            {
                let picture = shown.file.picture.clone();
                out.save(
                    format!("img_{:04}.hdr", shown.wish.hour).into(),
                    Box::new(move |path| lucarne::image::hdr::write(path, &picture)),
                );
            }
        });
    }

    /// What the picture is not: said where the illuminance has more phases.
    fn phases_note(&self, ui: &mut egui::Ui, results: &Results) {
        if results.summary.phases > 3 {
            let text = match &self.shown {
                Some(shown) if shown.traced && results.summary.windows.iter().filter(|w| w.sun_is_traced).count() > 1 => {
                    "Five phases, with the traced sun. Where windows with shades are in different states, the sun has their mean share."
                }
                Some(shown) if shown.traced => {
                    "Five phases, with the traced sun. A second state of a window has no shade: there the sun comes from the sky's patches."
                }
                _ => {
                    "The illuminance is that of five phases. This picture is of three, without the sharp sun: [glare] in the project has the suns of all hours traced."
                }
            };
            ui.add(egui::Label::new(RichText::new(text).small().weak()).wrap());
        }
    }

    fn facade_controls(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>, out: &mut Outbox) {
        if results.windows.is_empty() {
            return;
        }
        self.phases_note(ui, results);
        heading(ui, "Façade");
        for (i, name) in results.windows.iter().enumerate() {
            ui.horizontal(|ui| {
                ui.selectable_value(&mut self.state_window, i, name)
                    .on_hover_text("A BSDF dropped now becomes the second state of this window");
                ui.weak(self.states.name(i).map_or("as computed".to_string(), |s| format!("to {s}")));
            });
            let offered = results.states(name);
            if !offered.is_empty() {
                let label = |path: &std::path::PathBuf| path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
                let before = offered.iter().position(|p| self.states.name(i) == Some(label(p).as_str()));
                let mut chosen = before;
                let choices = offered.iter().enumerate().map(|(k, p)| (Some(k), label(p)));
                choose(ui, egui::ComboBox::from_id_salt(("state", i)), "states of the project", choices, &mut chosen);
                if let Some(path) = chosen.filter(|_| chosen != before).and_then(|k| offered.get(k)) {
                    self.state_window = i;
                    self.add_state_of(path, out);
                }
            }
            if self.states.name(i).is_some()
                && let Some(fraction) = view.fractions.get_mut(i)
            {
                ui.horizontal(|ui| {
                    if ui.selectable_label(*fraction == 0.0, "A").on_hover_text("as computed").clicked() {
                        *fraction = 0.0;
                    }
                    ui.add(egui::Slider::new(fraction, 0.0..=1.0).show_value(false))
                        .on_hover_text("States in between, linear in every value as 'lucarne bsdf interpolate'");
                    if ui.selectable_label(*fraction == 1.0, "B").clicked() {
                        *fraction = 1.0;
                    }
                    ui.label(format!("{:.0} %", *fraction * 100.0));
                });
            }
        }
        let id = egui::Id::unique("state-path");
        let mut path: String = ui.data(|d| d.get_temp(id)).unwrap_or_default();
        ui.horizontal(|ui| {
            let field = ui.add(
                egui::TextEdit::singleline(&mut path).hint_text("another state: BSDF file").desired_width(ui.available_width() - 58.0),
            );
            let enter = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            if (ui.button("Add").clicked() || enter) && !path.trim().is_empty() {
                self.add_state_of(std::path::Path::new(path.trim()), out);
                path.clear();
            }
        });
        ui.data_mut(|d| d.insert_temp(id, path));
    }
}

fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(8.0);
    ui.label(RichText::new(text).strong().size(14.0));
}

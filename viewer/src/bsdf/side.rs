//! The side of the BSDF panel: files, component, scale, and what the doctor says.

use super::BsdfPanel;
use super::disc::Projection;
use super::export;
use super::model::{Band, Compare, View, plain_words};
use super::paint::{fault_color, heading, ok_color, palette_choice};
use crate::outbox::Outbox;
use crate::plot;
use eframe::egui::{self, RichText, vec2};
use lucarne::bsdf::Component;
use lucarne::bsdf::check::Verdict;
use std::sync::Arc;

impl BsdfPanel {
    pub(super) fn side(&mut self, ui: &mut egui::Ui, view: &mut View, out: &mut Outbox) {
        let file = self.files[0].clone();
        ui.add_space(4.0);
        for (i, f) in self.files.iter().enumerate() {
            ui.horizontal(|ui| {
                if self.files.len() == 2 {
                    ui.colored_label(plot::line_color(ui, i), ["A", "B"][i]);
                }
                ui.strong(f.name()).on_hover_text(format!("{}\n{}", f.path.display(), f.bsdf.name));
            });
        }
        if self.files.len() == 1 {
            ui.weak("Drop a second file here to compare.");
        } else {
            ui.horizontal(|ui| {
                ui.selectable_value(&mut view.compare, Compare::SideBySide, "Side by side");
                ui.selectable_value(&mut view.compare, Compare::Difference, "Difference B − A").on_hover_text("Key D");
            });
            if ui.button("Close B").clicked() {
                self.files.truncate(1);
            }
        }
        heading(ui, "Component");
        let both = !file.bsdf.visible.is_empty() && !file.bsdf.solar.is_empty();
        if both {
            ui.horizontal(|ui| {
                ui.selectable_value(&mut view.band, Band::Visible, "Visible");
                ui.selectable_value(&mut view.band, Band::Solar, "Solar");
            });
        }
        for component in Component::ALL {
            let present = file.blocks(view.band).get(component).is_some();
            ui.add_enabled_ui(present, |ui| {
                let hint = format!("Light {}", plain_words(component));
                if ui
                    .selectable_label(view.component == component, component.xml_name())
                    .on_hover_text(&hint)
                    .on_disabled_hover_text("not in this file")
                    .clicked()
                {
                    view.component = component;
                    view.snap(&file);
                }
            });
        }
        if let Some(Some(v)) = self.slots[0].integrals.current() {
            ui.add(egui::Label::new(RichText::new(&v.description).small().weak()).wrap());
        }
        heading(ui, "Show");
        ui.horizontal_wrapped(|ui| {
            for p in Projection::ALL {
                let (name, keeps) = p.names();
                ui.selectable_value(&mut view.projection, p, name).on_hover_text(format!("{keeps} (key P)"));
            }
        });
        let top = self.largest(view);
        view.scale.controls(ui, top, "/sr");
        ui.horizontal(|ui| {
            ui.checkbox(&mut view.grid, "Patches").on_hover_text("Key G");
            ui.checkbox(&mut view.numbers, "Numbers").on_hover_text("Key N");
            palette_choice(ui, &mut view.palette);
        });
        ui.horizontal(|ui| {
            for kind in ["png", "svg"] {
                if ui.button(format!("Save {}…", kind.to_uppercase())).clicked() {
                    let (files, view) = (self.files.clone(), view.clone());
                    let name = file.path.with_extension(kind);
                    let name = name.file_name().map_or_else(|| format!("bsdf.{kind}").into(), std::path::PathBuf::from);
                    out.save(name, Box::new(move |path| export::write(&files.iter().map(Arc::as_ref).collect::<Vec<_>>(), &view, path)));
                }
            }
        });
        for i in 0..self.files.len() {
            self.verdicts(ui, i);
        }
    }

    fn verdicts(&self, ui: &mut egui::Ui, i: usize) {
        let title = if self.files.len() == 2 { format!("The doctor on {}", ["A", "B"][i]) } else { "The doctor".to_string() };
        heading(ui, &title);
        let Some(findings) = self.slots[i].findings.current() else {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.weak("examining…");
            });
            return;
        };
        let faults = findings.iter().filter(|f| f.verdict == Verdict::Fault).count();
        let sum = match faults {
            0 => "Sound".to_string(),
            1 => "1 fault".to_string(),
            n => format!("{n} faults"),
        };
        ui.label(RichText::new(sum).strong().color(if faults == 0 { ok_color(ui) } else { fault_color(ui) }));
        for verdict in [Verdict::Fault, Verdict::Note, Verdict::Sound] {
            for f in findings.iter().filter(|f| f.verdict == verdict) {
                let (sign, color) = match verdict {
                    Verdict::Fault => ("fault", fault_color(ui)),
                    Verdict::Note => ("note", plot::axis(ui)),
                    Verdict::Sound => ("ok", ok_color(ui)),
                };
                ui.horizontal_top(|ui| {
                    ui.add_sized(vec2(30.0, 14.0), egui::Label::new(RichText::new(sign).small().color(color)));
                    let text = format!("{}, {}: {}", f.item, f.place, f.text.lines().next().unwrap_or_default());
                    ui.add(egui::Label::new(RichText::new(text).small()).wrap()).on_hover_text(&f.text);
                });
            }
        }
    }
}

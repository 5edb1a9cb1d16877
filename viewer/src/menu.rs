//! The menu, the list of messages, and the field that asks what to open.

use crate::app::App;
use crate::args::PanelKind;
use crate::plot;
use crate::results::shortened;
use eframe::egui::{self, Color32, Key, RichText};
use std::path::PathBuf;

impl App {
    pub fn menu(&mut self, ui: &mut egui::Ui) {
        egui::MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| {
                if ui.button("Open…   Ctrl+O").clicked() {
                    self.path_field = Some(String::new());
                }
                ui.separator();
                ui.weak("Recent");
                let recent = self.remembered.recent.clone();
                if recent.is_empty() {
                    ui.weak("  nothing yet");
                }
                for path in &recent {
                    if ui.button(shortened(path)).on_hover_text(path.display().to_string()).clicked() {
                        self.open(path);
                    }
                }
                ui.separator();
                if ui.button("Quit").clicked() {
                    ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
                }
            });
            ui.menu_button("View", |ui| {
                let (back, forward) = self.history.steps();
                if ui.add_enabled(back, egui::Button::new("Undo   Ctrl+Z")).clicked() {
                    self.undo();
                }
                if ui.add_enabled(forward, egui::Button::new("Redo   Ctrl+Shift+Z")).clicked() {
                    self.redo();
                }
                ui.separator();
                let dark = ui.visuals().dark_mode;
                if ui.button(if dark { "Light   Ctrl+D" } else { "Dark   Ctrl+D" }).clicked() {
                    self.set_theme(&ui.ctx().clone(), !dark);
                }
            });
            if ui.button("Keys").on_hover_text("F1 or ?").clicked() {
                self.help = true;
            }
            ui.separator();
            for panel in PanelKind::ALL {
                let text = RichText::new(panel.name()).strong();
                ui.selectable_value(&mut self.views.panel, panel, text);
            }
            ui.separator();
            if let Some((path, _)) = self.loading.first() {
                ui.spinner();
                ui.weak(format!("reading {}", shortened(path)));
            } else if matches!(self.views.panel, PanelKind::Year | PanelKind::Grid)
                && let Some(results) = &self.results
            {
                ui.weak(&results.title);
            }
        });
    }

    pub fn message_list(&mut self, ui: &mut egui::Ui) {
        let mut closed = None;
        ui.add_space(2.0);
        for (i, (bad, text)) in self.messages.iter().enumerate().rev().take(4) {
            ui.horizontal_top(|ui| {
                if ui.small_button("×").on_hover_text("Close (Esc closes all)").clicked() {
                    closed = Some(i);
                }
                let color: Color32 = if *bad { plot::line_color(ui, 1) } else { ui.visuals().text_color() };
                ui.add(egui::Label::new(RichText::new(text.as_str()).color(color)).wrap());
            });
        }
        if let Some(i) = closed {
            self.messages.remove(i);
        }
    }

    pub fn open_field(&mut self, ctx: &egui::Context) {
        let Some(mut text) = self.path_field.take() else { return };
        let mut keep = true;
        egui::Modal::new(egui::Id::unique("open")).show(ctx, |ui| {
            ui.heading("Open");
            ui.label("Path of a result folder, a BSDF (.xml), a picture (.hdr, .exr) or a matrix (.mtx); or drop it on the window.");
            let id = egui::Id::unique("open-path");
            // Before it is there, so that the first letters are not lost.
            ui.memory_mut(|m| m.request_focus(id));
            ui.add(egui::TextEdit::singleline(&mut text).id(id).desired_width(520.0).hint_text("out/office"));
            for name in completions(&text) {
                if ui.selectable_label(false, &name).clicked() {
                    text = name;
                }
            }
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                let enter = ui.input(|i| i.key_pressed(Key::Enter));
                if (ui.button("Open").clicked() || enter) && !text.trim().is_empty() {
                    self.waiting.push(PathBuf::from(text.trim()));
                    keep = false;
                }
                if ui.button("Cancel").clicked() || ui.input(|i| i.key_pressed(Key::Escape)) {
                    keep = false;
                }
            });
        });
        self.path_field = keep.then_some(text);
    }
}

/// Files and folders that begin as the text does, at most eight.
fn completions(text: &str) -> Vec<String> {
    let (folder, start) = text.rsplit_once('/').map_or(("", text), |(f, s)| (f, s));
    let base = if text.starts_with('/') && folder.is_empty() {
        "/"
    } else if folder.is_empty() {
        "."
    } else {
        folder
    };
    let Ok(entries) = std::fs::read_dir(base) else { return Vec::new() };
    let mut names: Vec<String> = entries
        .flatten()
        .filter_map(|e| {
            let name = e.file_name().to_string_lossy().into_owned();
            let folder_end = if e.path().is_dir() { "/" } else { "" };
            let known = !folder_end.is_empty() || [".xml", ".hdr", ".pic", ".exr", ".mtx"].iter().any(|x| name.ends_with(x));
            let prefix = if text.contains('/') { format!("{folder}/") } else { String::new() };
            (name.starts_with(start) && !name.starts_with('.') && known).then(|| format!("{prefix}{name}{folder_end}"))
        })
        .collect();
    names.sort();
    names.truncate(8);
    names
}

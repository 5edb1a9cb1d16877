//! The small window that asks where to save.

use crate::outbox::{Outbox, Writer};
use eframe::egui;
use std::path::{Path, PathBuf};

/// A file that waits for its name.
pub struct Saving {
    path: String,
    write: Option<Writer>,
}

impl Saving {
    /// Offers a name in the working folder.
    pub fn new(name: &Path, write: Writer) -> Self {
        let folder = std::env::current_dir().unwrap_or_else(|_| PathBuf::from("."));
        Self { path: folder.join(name).display().to_string(), write: Some(write) }
    }

    /// Asks; `false` when it is settled.
    pub fn show(&mut self, ctx: &egui::Context, out: &mut Outbox) -> bool {
        let mut open = true;
        egui::Modal::new(egui::Id::unique("save")).show(ctx, |ui| {
            ui.heading("Save as");
            let id = egui::Id::unique("save-path");
            // Before it is there, so that the first letters are not lost.
            ui.memory_mut(|m| m.request_focus(id));
            ui.add(egui::TextEdit::singleline(&mut self.path).id(id).desired_width(460.0));
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                let enter = ui.input(|i| i.key_pressed(egui::Key::Enter));
                if (ui.button("Save").clicked() || enter) && !self.path.trim().is_empty() {
                    let path = PathBuf::from(self.path.trim());
                    match self.write.take().map(|w| w(&path)) {
                        Some(Ok(())) => out.note(format!("written: {}", path.display())),
                        Some(Err(e)) => out.error(e.to_string()),
                        None => {}
                    }
                    open = false;
                }
                if ui.button("Cancel").clicked() || ui.input(|i| i.key_pressed(egui::Key::Escape)) {
                    open = false;
                }
            });
        });
        open
    }
}

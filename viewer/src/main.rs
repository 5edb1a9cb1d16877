//! Viewer for Lucarne's results. So far it opens a window that says where results are; its panels
//! are still to be built.

use eframe::egui;
use std::process::ExitCode;

fn main() -> ExitCode {
    let started = eframe::run_native("Lucarne", eframe::NativeOptions::default(), Box::new(|_| Ok(Box::new(Viewer))));
    match started {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lucarne-viewer: error: {error}\n  help: the viewer needs a desktop session and a graphics driver");
            ExitCode::FAILURE
        }
    }
}

struct Viewer;

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        egui::CentralPanel::default().show(ui, |ui| {
            ui.heading("Lucarne");
            ui.label("Results of 'make demo' lie in out/office; pictures can be made with 'lucarne falsecolor'.");
        });
    }
}

//! The overlay that lists the keys.

use crate::args::PanelKind;
use eframe::egui;

const EVERYWHERE: &[(&str, &str)] = &[
    ("Ctrl+O", "open a file or folder"),
    ("Ctrl+1 … 4", "Year, Grid, Picture, BSDF"),
    ("Ctrl+Z, Ctrl+Shift+Z", "undo, redo a change of the view"),
    ("Ctrl+D", "dark or light"),
    ("Ctrl + / Ctrl −", "larger or smaller text and controls"),
    ("F1 or ?", "this list"),
    ("Esc", "close what is open"),
];

const YEAR: &[(&str, &str)] = &[
    ("← →", "an hour back, forward"),
    ("↑ ↓", "the same hour of the day before, after"),
    ("Home, End", "first and last hour of the year"),
    ("W", "worst glare hour"),
    ("N, P", "next and previous of the worst glare hours"),
    ("M", "highest hour of the carpet"),
    ("Space", "play the day, stop"),
    ("L", "linear or logarithmic colours of the picture"),
];

const GRID: &[(&str, &str)] =
    &[("← →, ↑ ↓", "an hour, a day (when an hour is shown)"), ("3", "plan or 3-D"), ("C", "contours"), ("drag", "turn the 3-D view")];

const PICTURE: &[(&str, &str)] = &[
    ("F", "falsecolour or photograph"),
    ("L", "linear or logarithmic"),
    ("+ −", "exposure, half a stop"),
    ("S", "glare sources"),
    ("I, P, T", "tools: inspect, line profile, task circle"),
    ("wheel, drag", "zoom, move (right button or inspect tool)"),
    ("0", "whole picture"),
];

const BSDF: &[(&str, &str)] = &[
    ("← →, ↑ ↓", "next incident patch around, outward and inward"),
    ("T, B, R, F", "transmission front, back; reflection front, back"),
    ("L", "linear or logarithmic"),
    ("P", "next projection"),
    ("G, N", "patch outlines, numbers"),
    ("D", "difference of two files"),
];

/// Shows the list; `false` once it is closed.
pub fn show(ctx: &egui::Context, panel: PanelKind) -> bool {
    let keys = match panel {
        PanelKind::Year => YEAR,
        PanelKind::Grid => GRID,
        PanelKind::Picture => PICTURE,
        PanelKind::Bsdf => BSDF,
    };
    let mut open = true;
    let response = egui::Modal::new(egui::Id::unique("help")).show(ctx, |ui| {
        ui.heading("Keys");
        for (title, list) in [("Everywhere", EVERYWHERE), (panel.name(), keys)] {
            ui.add_space(8.0);
            ui.strong(title);
            egui::Grid::new(title).num_columns(2).spacing([24.0, 4.0]).show(ui, |ui| {
                for (key, what) in list {
                    ui.monospace(*key);
                    ui.label(*what);
                    ui.end_row();
                }
            });
        }
        ui.add_space(10.0);
        if ui.button("Close").clicked() {
            open = false;
        }
    });
    open && !response.should_close()
}

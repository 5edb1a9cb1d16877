//! Painting the Grid panel and taking its clicks.

use super::metric::{Metric, spatial_share};
use super::model::View;
use super::plan::{Plan, sensor_text};
use super::space;
use crate::bsdf::palette_choice;
use crate::plot::{self, color32, empty_state};
use crate::results::Results;
use crate::scale::{BAR_WIDTH, ColorBar, draggable_bar};
use crate::year::YearLux;
use crate::year::model::{Quantity, lux_text};
use eframe::egui::{self, Align2, FontId, Key, Rect, RichText, pos2};
use glam::DVec3;
use lucarne::image::palette::{Scale, rounded_number};
use lucarne::metrics::lm83;
use lucarne::scene::outline::edges;
use std::sync::Arc;

/// The panel with what it has computed.
#[derive(Default)]
pub struct GridPanel {
    key: String,
    values: Vec<f64>,
    autonomy: Vec<f64>,
    edges: Vec<[DVec3; 2]>,
    readout: String,
    note: Option<String>,
}

impl GridPanel {
    /// Shows other results.
    pub fn open(&mut self, results: &Arc<Results>, view: &mut View) {
        *self = Self { edges: results.scene().map(edges).unwrap_or_default(), ..Self::default() };
        view.group = results.sensors.iter().position(|g| !g.positions.is_empty()).unwrap_or(0);
    }

    /// Nothing here takes longer than a frame.
    pub fn busy(&self) -> bool {
        false
    }

    /// Keys of this panel.
    pub fn keys(&mut self, ui: &egui::Ui, view: &mut View, results: &Results, hour: &mut usize) {
        let pressed = |key: Key| ui.input(|i| i.key_pressed(key) && i.modifiers.is_none());
        if pressed(Key::Num3) {
            view.solid = !view.solid;
        }
        if pressed(Key::C) {
            view.contours = !view.contours;
        }
        if view.metric == Metric::Hour {
            let mut year = crate::year::model::View { hour: *hour, ..Default::default() };
            for (key, steps, days) in [(Key::ArrowRight, 1, 0), (Key::ArrowLeft, -1, 0), (Key::ArrowDown, 0, 1), (Key::ArrowUp, 0, -1)] {
                if pressed(key) {
                    year.step(results, steps, days);
                }
            }
            *hour = year.hour;
        }
    }

    /// Paints the panel.
    pub fn show(&mut self, ui: &mut egui::Ui, view: &mut View, results: Option<&Arc<Results>>, lux: &YearLux<'_>, hour: &mut usize) {
        let Some(results) = results else {
            empty_state(
                ui,
                "No results are open",
                &["Drop a result folder of 'lucarne run' here, or open one with Ctrl+O.", "'make demo' computes one: out/office."],
            );
            return;
        };
        let Some(group) = results.sensors.get(view.group) else {
            empty_state(ui, "These results have no sensors", &["Add [[sensors]] with name and points to the project and run it again."]);
            return;
        };
        let key = format!(
            "{} {} {:?} {} {}",
            results.folder().display(),
            view.group,
            view.metric,
            if view.metric == Metric::Hour { *hour } else { 0 },
            lux.key
        );
        if self.key != key {
            let lux = lux.lux.and_then(|l| l.get(view.group)).unwrap_or(&group.illuminance);
            self.values = view.metric.values(lux, &results.times, *hour);
            self.autonomy = Metric::Autonomy.values(lux, &results.times, 0);
            self.key = key;
        }
        self.note.clone_from(&lux.instead);
        let state = lux.state.as_deref();
        egui::Panel::left("grid-side").exact_size(272.0).resizable(false).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| self.side(ui, view, results, state, hour));
        });
        egui::CentralPanel::default().show(ui, |ui| self.center(ui, view, results, state, hour));
    }

    fn largest(&self) -> f64 {
        self.values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max)
    }

    fn scale(&self, view: &View) -> Scale {
        if view.metric.is_share() {
            Scale::linear(0.0, 1.0).unwrap_or_else(|_| view.scale.scale(1.0))
        } else {
            view.scale.scale(self.largest())
        }
    }

    fn side(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Results, state: Option<&str>, hour: &mut usize) {
        heading(ui, "Sensors");
        for (i, group) in results.sensors.iter().enumerate() {
            ui.selectable_value(&mut view.group, i, format!("{} ({})", group.name, group.count()));
        }
        heading(ui, "Metric");
        for metric in Metric::ALL {
            let (name, about) = metric.names();
            ui.selectable_value(&mut view.metric, metric, name).on_hover_text(about);
        }
        if view.metric == Metric::Hour {
            let last = results.hours().saturating_sub(1);
            ui.spacing_mut().slider_width = ui.available_width() - 16.0;
            ui.add(egui::Slider::new(hour, 0..=last).show_value(false)).on_hover_text("Arrow keys step by hours and days");
            ui.label(format!("{}   hour {hour}", results.times[*hour]));
        }
        heading(ui, "Show");
        ui.horizontal(|ui| {
            ui.selectable_value(&mut view.solid, false, "Plan");
            ui.selectable_value(&mut view.solid, true, "3-D").on_hover_text("Key 3; drag to turn, wheel to zoom");
        });
        ui.horizontal(|ui| {
            ui.checkbox(&mut view.contours, "Contours").on_hover_text("Key C");
            ui.checkbox(&mut view.numbers, "Values");
            palette_choice(ui, &mut view.palette);
        });
        if !view.metric.is_share() {
            view.scale.controls(ui, self.largest(), "lx");
        }
        heading(ui, "Summary");
        let values: Vec<f64> = self.values.iter().copied().filter(|v| v.is_finite()).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let (group, mut others) = (results.sensors.get(view.group), 0);
        egui::Grid::new("summary").num_columns(2).spacing([18.0, 3.0]).show(ui, |ui| {
            for (name, value) in [("mean", mean), ("lowest", low), ("highest", self.largest())] {
                ui.weak(name);
                ui.strong(view.metric.text(value));
                ui.end_row();
            }
            let (share, count) = group.map_or((None, 0), |g| spatial_share(&self.autonomy, |s| g.is_of_plan(s)));
            let (name, hover) = share_names(group.map(|g| g.name.as_str()), results, state);
            ui.weak(name).on_hover_text(hover);
            ui.strong(share.map_or("–".to_string(), |s| format!("{:.1} %", s * 100.0)));
            ui.end_row();
            others = group.map_or(0, |g| g.count() - count);
        });
        let mut about = format!("Occupied: 8:00 to 18:00 standard time, every day. {}", about_blinds(results, state));
        if group.is_some_and(|g| g.directions.is_empty()) {
            about += " Where the sensors face is not known: all count.";
        }
        if others > 0 {
            about += &format!(" {others} of the sensors do not face up, and do not count in it.");
        }
        about += &match (&self.note, state) {
            (Some(note), _) => format!(" Shown: {note}."),
            (None, Some(state)) => format!(" The façade with {state}."),
            (None, None) => " The façade as computed.".to_string(),
        };
        ui.add(egui::Label::new(RichText::new(about).small().weak()).wrap());
    }

    fn center(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>, state: Option<&str>, hour: &mut usize) {
        let group = &results.sensors[view.group.min(results.sensors.len() - 1)];
        let mut title = format!("{}: {}", group.name, view.metric.names().0);
        if view.metric == Metric::Hour {
            title = format!("{}: {}", group.name, results.times[*hour]);
        }
        ui.label(RichText::new(title).strong().size(17.0));
        if let Some(state) = state {
            let text = match &self.note {
                Some(note) => note.clone(),
                None => format!("The façade with {state}: the Year panel's choice, not as computed"),
            };
            ui.add(egui::Label::new(RichText::new(text).color(ui.visuals().warn_fg_color)).wrap());
        }
        let area = ui.available_rect_before_wrap();
        if group.positions.is_empty() {
            ui.add_space(12.0);
            ui.label("Where these sensors are is not known: the illuminance table (.csv) beside the matrix is missing.");
            return;
        }
        let status = 22.0;
        let rect = Rect::from_min_max(area.min, pos2(area.right() - BAR_WIDTH - 14.0, area.bottom() - status - 26.0));
        let scale = self.scale(view);
        self.readout = "Point at a sensor to read it".into();
        let under = if view.solid {
            space::show(ui, rect, group, &self.edges, &self.values, view.palette, &scale, view)
        } else {
            let numbers = view.numbers;
            let share = view.metric.is_share();
            let label = move |v: f64| match (numbers, share) {
                (false, _) => String::new(),
                (true, true) => format!("{:.0}", v * 100.0),
                (true, false) => rounded_number(v),
            };
            let metric = view.metric;
            let name = |v: f64| if metric.is_share() { format!("{:.0} %", v * 100.0) } else { rounded_number(v) };
            let contours = if view.contours { levels(&scale).into_iter().map(|v| (v, name(v))).collect() } else { Vec::new() };
            Plan { group, results, values: &self.values, palette: view.palette, scale: &scale, contours, label: &label }.paint(ui, rect)
        };
        if let Some(sensor) = under {
            let text = match view.metric {
                Metric::Hour => {
                    // Errors are those of the façade as it was computed.
                    let error = Quantity::Sensor(view.group, sensor).error(results, *hour).filter(|_| state.is_none());
                    lux_text(self.values[sensor], error)
                }
                metric => metric.text(self.values[sensor]),
            };
            self.readout = sensor_text(group, sensor, &text);
        }
        if let Some(note) = &self.note {
            plot::veil(ui, rect, note);
        }
        let bar = Rect::from_min_max(pos2(rect.right() + 14.0, rect.top()), pos2(area.right(), rect.bottom()));
        let mark = under.map(|s| self.values[s]);
        if view.metric.is_share() {
            let palette = view.palette;
            let color = |t: f64| color32(palette.color(t));
            let ticks = (0..=5).map(|i| (f64::from(i) / 5.0, format!("{} %", i * 20))).collect();
            ColorBar { color: &color, label: "of hours", ticks, mark }.paint(ui, bar);
        } else {
            let largest = self.largest();
            draggable_bar(ui, bar, &mut view.scale, largest, view.palette, "lx", mark);
        }
        ui.painter().text(
            pos2(area.left() + 4.0, area.bottom() - status / 2.0),
            Align2::LEFT_CENTER,
            &self.readout,
            FontId::proportional(13.0),
            ui.visuals().text_color(),
        );
        if results.scene().is_none() {
            let text = "without the project file the room's outline is not known";
            ui.painter().text(
                pos2(area.right(), area.bottom() - status / 2.0),
                Align2::RIGHT_CENTER,
                text,
                FontId::proportional(11.5),
                plot::axis(ui),
            );
        }
    }
}

/// Contours at the numbers of the scale, without its ends.
fn levels(scale: &Scale) -> Vec<f64> {
    scale.ticks(5).into_iter().filter(|v| (0.02..0.98).contains(&scale.position(*v))).collect()
}

fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(8.0);
    ui.label(RichText::new(text).strong().size(14.0));
}

/// Whether LM-83's blinds are moved in what is shown.
fn has_blinds(results: &Results, state: Option<&str>) -> bool {
    state.is_none() && results.summary.control.as_ref().is_some_and(|c| c.lm83_blinds)
}

/// What the spatial share is called, and what it says: LM-83's own where the run says so.
fn share_names(group: Option<&str>, results: &Results, state: Option<&str>) -> (&'static str, &'static str) {
    let metrics = results.summary.sensors.iter().find(|g| Some(g.name.as_str()) == group).map(|g| &g.metrics);
    let is_lm83 = has_blinds(results, state) && metrics.is_some_and(|all| all.iter().any(|m| m.name == lm83::SDA));
    match (is_lm83, has_blinds(results, state)) {
        (true, _) => (
            "LM-83 sDA300/50%",
            "Share of the sensors facing up that have 300 lx or more for half of the hours from 8:00 to 18:00, with LM-83-12's blinds.",
        ),
        (false, true) => (
            "DA300 spatial share",
            "Share of the sensors facing up that have 300 lx or more for half of the hours from 8:00 to 18:00. LM-83's blinds are moved \
             for it; what else LM-83 asks for is missing: the report says what.",
        ),
        (false, false) => (
            "DA300 spatial share",
            "Share of the sensors facing up that have 300 lx or more for half of the hours from 8:00 to 18:00. LM-83's blinds are not \
             moved for it.",
        ),
    }
}

/// What was done about LM-83's blinds.
fn about_blinds(results: &Results, state: Option<&str>) -> String {
    if !has_blinds(results, state) {
        return "LM-83's blinds are not moved, so that the spatial share is not its own.".into();
    }
    let hours = results.summary.control.as_ref().and_then(|c| c.lm83_hours_above).unwrap_or(0.0);
    format!("LM-83's blinds are moved; in {hours} h they leave more than 2 % of the sensors in the sun.")
}

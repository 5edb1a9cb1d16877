//! Painting the Year panel and taking its clicks.

use super::carpet;
use super::dome;
use super::model::{Quantity, View, glare_quantity, steps_per_day, typical_maximum, worst};
use super::scrub::{Answer, Scrubber, Wish};
use super::states::States;
use crate::app::Outbox;
use crate::args::PanelKind;
use crate::bsdf::model::BsdfFile;
use crate::bsdf::palette_choice;
use crate::grid;
use crate::job::Derived;
use crate::picture::model::{Judged, Mode, PictureFile};
use crate::picture::show;
use crate::plot::{self, empty_state, halo_text};
use crate::results::Results;
use crate::scale::{BAR_WIDTH, draggable_bar};
use crate::texture::CachedTexture;
use eframe::egui::{self, Align2, Color32, FontId, Key, Rect, RichText, Sense, Stroke, pos2, vec2};
use lucarne::image::palette::rounded_number;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use std::sync::Arc;

/// The panel with what it has computed.
#[derive(Default)]
pub struct YearPanel {
    values: (String, Vec<f64>, f64),
    carpet: CachedTexture,
    scrubber: Option<Scrubber>,
    shown: Option<Shown>,
    glare: Option<(usize, Judged)>,
    picture: CachedTexture,
    failed: Option<String>,
    states: States,
    state_window: usize,
    sky: Derived<String, Option<Matrix<f32>>>,
    dome: CachedTexture,
    playing: bool,
    readout: String,
    pending: Vec<BsdfFile>,
}

/// The picture on the screen.
struct Shown {
    wish: Wish,
    file: PictureFile,
    whole: bool,
    seconds: f64,
}

impl YearPanel {
    /// Shows other results.
    pub fn open(&mut self, results: &Arc<Results>, view: &mut View) {
        view.fit(results);
        let mut states = std::mem::take(&mut self.states);
        states.reset(results.windows.len());
        *self = Self { states, ..Self::default() };
    }

    /// Takes a BSDF as another state of the façade.
    pub fn add_state(&mut self, file: BsdfFile) {
        self.pending.push(file);
    }

    /// Whether the picture or the carpet will still change.
    pub fn busy(&self) -> bool {
        let picture = self.scrubber.as_ref().is_some_and(|s| {
            self.failed.is_none() && (s.wanted() != self.shown.as_ref().filter(|p| p.whole).map(|p| &p.wish) || self.waits_for_glare())
        });
        picture || self.states.busy() || self.sky.busy() || !self.pending.is_empty()
    }

    fn waits_for_glare(&self) -> bool {
        match (&self.shown, &self.glare) {
            (Some(shown), Some((hour, _))) => *hour != shown.wish.hour,
            (Some(_), None) => true,
            _ => false,
        }
    }

    /// Keys of this panel.
    pub fn keys(&mut self, ui: &egui::Ui, view: &mut View, results: &Results) {
        let pressed = |key: Key| ui.input(|i| i.key_pressed(key) && i.modifiers.is_none());
        for (key, steps, days) in [(Key::ArrowRight, 1, 0), (Key::ArrowLeft, -1, 0), (Key::ArrowDown, 0, 1), (Key::ArrowUp, 0, -1)] {
            if pressed(key) {
                view.step(results, steps, days);
            }
        }
        if pressed(Key::Home) {
            view.hour = 0;
        }
        if pressed(Key::End) {
            view.hour = results.hours().saturating_sub(1);
        }
        if pressed(Key::W) {
            self.go_to_worst(view, results);
        }
        if pressed(Key::M)
            && let Some(hour) = worst(&self.values.1)
        {
            view.hour = hour;
        }
        if pressed(Key::Space) {
            self.playing = !self.playing;
        }
        if pressed(Key::L) {
            view.picture.log = !view.picture.log;
        }
    }

    fn go_to_worst(&mut self, view: &mut View, results: &Results) {
        if let Some(quantity) = glare_quantity(results) {
            let lux = self.states.lux(&view.fractions).map(|(_, l)| l.to_vec());
            view.quantity = quantity;
            if let Some(hour) = worst(&quantity.values(results, lux.as_deref())) {
                view.hour = hour;
            }
        }
    }

    /// Paints the panel.
    pub fn show(&mut self, ui: &mut egui::Ui, view: &mut View, results: Option<&Arc<Results>>, out: &mut Outbox) {
        let Some(results) = results else {
            empty_state(
                ui,
                "No results are open",
                &["Drop a result folder of 'lucarne run' here, or open one with Ctrl+O.", "'make demo' computes one: out/office."],
            );
            return;
        };
        for file in std::mem::take(&mut self.pending) {
            self.take_state(file, view, results, out);
        }
        self.update(ui.ctx(), view, results);
        egui::Panel::left("year-side").exact_size(272.0).resizable(false).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| self.side(ui, view, results, out));
        });
        egui::CentralPanel::default().show(ui, |ui| self.center(ui, view, results));
    }

    fn take_state(&mut self, file: BsdfFile, view: &mut View, results: &Results, out: &mut Outbox) {
        let window = self.state_window.min(results.windows.len().saturating_sub(1));
        if results.windows.is_empty() {
            out.error("these results have no windows whose state could be changed".into());
            return;
        }
        match self.states.add(results, window, &file) {
            Ok(()) => {
                view.fractions.resize(results.windows.len(), 0.0);
                view.fractions[window] = 1.0;
            }
            Err(e) => out.error(e.to_string()),
        }
    }

    fn update(&mut self, ctx: &egui::Context, view: &mut View, results: &Arc<Results>) {
        view.hour = view.hour.min(results.hours().saturating_sub(1));
        view.fractions.resize(results.windows.len(), 0.0);
        if self.playing {
            let per_day = steps_per_day(results.hours());
            let next = view.hour + 1;
            view.hour = if next.is_multiple_of(per_day) { next - per_day } else { next };
            ctx.request_repaint_after(std::time::Duration::from_millis(150));
        }
        self.sky.update(ctx, results.folder.display().to_string(), || {
            let path = results.matrix("S");
            move || read_matrix(&path).ok().map(|f| f.matrix)
        });
        self.states.update(ctx, results, &view.fractions);
        let lux = self.states.lux(&view.fractions);
        let key = format!("{} {:?} {}", results.folder.display(), view.quantity, lux.as_ref().map_or("", |l| l.0.as_str()));
        if self.values.0 != key {
            let values = view.quantity.values(results, lux.map(|l| l.1));
            let maximum = typical_maximum(&values);
            self.values = (key, values, maximum);
        }
        let Some(file) = results.views.get(view.view) else { return };
        if self.scrubber.as_ref().is_none_or(|s| s.view != file.name) {
            (self.shown, self.glare, self.failed) = (None, None, None);
            self.scrubber = Some(Scrubber::start(ctx, results, file));
        }
        let Some(scrubber) = &mut self.scrubber else { return };
        scrubber.wish(self.states.wish(view.hour, &view.fractions));
        for answer in scrubber.answers() {
            match answer {
                Answer::Picture { wish, file, whole, seconds } => self.shown = Some(Shown { wish, file: *file, whole, seconds }),
                Answer::Glare { hour, judged } => self.glare = Some((hour, *judged)),
                Answer::Failed(error) => self.failed = Some(error.to_string()),
            }
        }
    }

    fn side(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>, out: &mut Outbox) {
        ui.add_space(4.0);
        if glare_quantity(results).is_some() {
            let button = egui::Button::new(RichText::new("Worst glare hour").strong()).min_size(vec2(ui.available_width() - 4.0, 30.0));
            if ui.add(button).on_hover_text("Goes to the hour of the year with the highest glare probability (key W)").clicked() {
                self.go_to_worst(view, results);
            }
        }
        heading(ui, "Carpet");
        let mut choices: Vec<Quantity> = (0..results.glare.len()).flat_map(|v| [Quantity::Dgp(v), Quantity::Class(v)]).collect();
        choices.extend((0..results.groups.len()).map(Quantity::Mean));
        for (g, group) in results.groups.iter().enumerate() {
            choices.extend((0..group.len()).map(|s| Quantity::Sensor(g, s)));
            choices.extend(group.directions.iter().enumerate().filter(|(_, d)| d.z.abs() < 0.5).map(|(s, _)| Quantity::Simplified(g, s)));
        }
        egui::ComboBox::from_id_salt("quantity")
            .width(ui.available_width() - 12.0)
            .height(420.0)
            .selected_text(view.quantity.name(results))
            .show_ui(ui, |ui| {
                for choice in choices {
                    ui.selectable_value(&mut view.quantity, choice, choice.name(results));
                }
            });
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
        let sun = results.weather.as_ref().and_then(|w| Some(w.sun(w.records.get(view.hour)?)));
        let sky = self.sky.value().and_then(Option::as_ref).filter(|s| view.hour < s.cols()).map(|s| (s, view.hour));
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

    fn picture_controls(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>, out: &mut Outbox) {
        if results.views.is_empty() {
            return;
        }
        heading(ui, "Picture");
        if results.views.len() > 1 {
            egui::ComboBox::from_id_salt("view").selected_text(&results.views[view.view.min(results.views.len() - 1)].name).show_ui(
                ui,
                |ui| {
                    for (i, v) in results.views.iter().enumerate() {
                        ui.selectable_value(&mut view.view, i, &v.name);
                    }
                },
            );
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

    fn facade_controls(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>, out: &mut Outbox) {
        if results.windows.is_empty() {
            return;
        }
        heading(ui, "Façade");
        for (i, name) in results.windows.iter().enumerate() {
            ui.horizontal(|ui| {
                ui.selectable_value(&mut self.state_window, i, name)
                    .on_hover_text("A BSDF dropped now becomes the second state of this window");
                ui.weak(self.states.name(i).map_or("as computed".to_string(), |s| format!("→ {s}")));
            });
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
                match BsdfFile::read(std::path::Path::new(path.trim())) {
                    Ok(file) => {
                        self.pending.push(file);
                        path.clear();
                    }
                    Err(e) => out.error(e.to_string()),
                }
            }
        });
        ui.data_mut(|d| d.insert_temp(id, path));
        if self.states.changed(&view.fractions) && view.quantity.is_glare() && !matches!(view.quantity, Quantity::Simplified(..)) {
            ui.add(
                egui::Label::new(
                    RichText::new("The glare carpet is that of the computed state; the picture follows the façade.").small().weak(),
                )
                .wrap(),
            );
        }
    }

    fn picture_maximum(&self) -> f64 {
        self.shown.as_ref().map_or(1000.0, |s| s.file.typical_maximum())
    }

    fn center(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>) {
        let stamp = results.stamps[view.hour];
        ui.horizontal(|ui| {
            ui.label(RichText::new(stamp.text()).strong().size(17.0));
            ui.weak(format!("hour {}", view.hour));
            let value = self.values.1.get(view.hour).copied().unwrap_or(f64::NAN);
            ui.strong(view.quantity.text(value));
            let play = if self.playing { "Stop" } else { "Play the day" };
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.button(play).on_hover_text("Space").clicked() {
                    self.playing = !self.playing;
                }
            });
        });
        ui.horizontal(|ui| {
            ui.spacing_mut().slider_width = ui.available_width() - 16.0;
            let last = results.hours().saturating_sub(1);
            ui.add(egui::Slider::new(&mut view.hour, 0..=last).show_value(false))
                .on_hover_text("Drag through the year; arrow keys step by hours and days");
        });
        let area = ui.available_rect_before_wrap();
        let height = (area.height() * 0.34).clamp(120.0, 340.0);
        let outer = Rect::from_min_size(area.min, vec2(area.width(), height));
        let title = view.quantity.name(results);
        let (key, values, maximum) = std::mem::take(&mut self.values);
        let hovered = carpet::show(ui, outer, &mut self.carpet, &key, view, &values, &results.stamps, &title, maximum);
        if let Some(step) = hovered {
            self.readout = format!("{}   hour {step}   {}", results.stamps[step].text(), view.quantity.text(values[step]));
        }
        self.values = (key, values, maximum);
        let status = 22.0;
        let below = Rect::from_min_max(pos2(area.left(), outer.bottom() + 8.0), pos2(area.right(), area.bottom() - status));
        if results.views.is_empty() {
            self.plan(ui, below, view, results);
        } else {
            self.hour_picture(ui, below, view);
        }
        let text = if self.readout.is_empty() {
            "Point at the carpet, the picture or the sky to read values; click the carpet to go to an hour"
        } else {
            &self.readout
        };
        ui.painter().text(
            pos2(area.left() + 4.0, area.bottom() - status / 2.0),
            Align2::LEFT_CENTER,
            text,
            FontId::proportional(13.0),
            ui.visuals().text_color(),
        );
    }

    fn plan(&mut self, ui: &mut egui::Ui, rect: Rect, view: &View, results: &Arc<Results>) {
        let Some((_, group)) = results.groups.iter().enumerate().find(|(_, g)| !g.positions.is_empty()) else { return };
        let lux = self.states.lux(&view.fractions);
        let index = results.groups.iter().position(|g| std::ptr::eq(g, group)).unwrap_or(0);
        let matrix = lux.as_ref().and_then(|l| l.1.get(index)).unwrap_or(&group.lux);
        let values: Vec<f64> = (0..matrix.rows()).map(|s| f64::from(matrix.at(s, view.hour)[0])).collect();
        let scale = view.carpet.scale(self.values.2);
        let title = format!("{} on the plan, lx", group.name);
        if let Some(said) = grid::plan::hour_plan(ui, rect, results, group, &values, view.palette, &scale, &title) {
            self.readout = said;
        }
    }

    fn hour_picture(&mut self, ui: &mut egui::Ui, rect: Rect, view: &mut View) {
        let Some(shown) = &self.shown else {
            let text = self.failed.clone().unwrap_or_else(|| "reading the view matrix…".into());
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(14.0), plot::axis(ui));
            return;
        };
        let (w, h) = (shown.file.picture.width as f32, shown.file.picture.height as f32);
        let facts = 210.0;
        let room = vec2(rect.width() - BAR_WIDTH - 24.0 - facts, rect.height() - 4.0);
        let unit = (room.x / w).min(room.y / h);
        let place = Rect::from_min_size(pos2(rect.left() + 46.0, rect.top()), vec2(w, h) * unit);
        let maximum = shown.file.typical_maximum();
        let key = format!("{} {:?} {:?} {:?} {}", shown.file.id, view.mode, view.palette, view.picture, view.stops);
        let texture = self.picture.get(ui.ctx(), key, false, || show::image(&shown.file, &view.picture_view(), maximum));
        ui.painter().image(texture, place, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        ui.painter().rect_stroke(place, 0.0, Stroke::new(1.0, plot::axis(ui)), egui::StrokeKind::Outside);
        let glare = self.glare.as_ref().filter(|(hour, _)| *hour == shown.wish.hour).map(|(_, j)| j);
        let screen = |x: f64, y: f64| place.min + vec2(x as f32, y as f32) * unit;
        if view.sources
            && let Some(j) = glare
        {
            for (i, (edges, source)) in j.outlines.iter().zip(&j.glare.sources).enumerate() {
                for [a, b] in edges {
                    let line = [screen(a[0].into(), a[1].into()), screen(b[0].into(), b[1].into())];
                    ui.painter().line_segment(line, Stroke::new(1.6, Color32::from_rgb(255, 90, 60)));
                }
                halo_text(
                    ui.painter(),
                    screen(source.x + 0.5, f64::from(h) - source.y - 0.5),
                    Align2::CENTER_CENTER,
                    &(i + 1).to_string(),
                    13.0,
                );
            }
        }
        let mut under = None;
        if let Some(p) = ui.interact(place, ui.scope_id().with("hour-picture"), Sense::hover()).hover_pos() {
            let (x, y) = (((p.x - place.left()) / unit) as usize, ((p.y - place.top()) / unit) as usize);
            if x < shown.file.picture.width && y < shown.file.picture.height {
                let value = f64::from(shown.file.luminance[y * shown.file.picture.width + x]);
                under = Some(value);
                self.readout = format!("x {x}, y {}   {} cd/m²", shown.file.picture.height - 1 - y, rounded_number(value));
            }
        }
        let mut left = place.right() + 14.0;
        if view.mode == Mode::Falsecolor {
            let bar = Rect::from_min_max(pos2(left, place.top()), pos2(left + BAR_WIDTH, place.bottom()));
            draggable_bar(ui, bar, &mut view.picture, maximum, view.palette, "cd/m²", under);
            left = bar.right() + 10.0;
        }
        let mut lines = Vec::new();
        if let Some(j) = glare {
            let i = &j.glare.indices;
            lines.push((format!("DGP {:.3}", i.dgp), true));
            lines.push((crate::results::CLASSES[crate::results::class_of(i.dgp) as usize].into(), false));
            lines.push((format!("Ev {} lx", rounded_number(j.glare.vertical_illuminance)), false));
            lines.push((format!("UGR {}", if i.ugr < 0.0 { "–".into() } else { format!("{:.1}", i.ugr) }), false));
            lines.push((format!("{} glare sources", j.glare.sources.len()), false));
            if j.partial {
                lines.push(("the view is no hemisphere:".into(), false));
                lines.push(("Ev and DGP are too low".into(), false));
            }
        }
        let mean = shown.file.luminance.iter().map(|v| f64::from(*v)).sum::<f64>() / shown.file.luminance.len().max(1) as f64;
        lines.push((format!("mean {} cd/m²", rounded_number(mean)), false));
        lines.push((if shown.whole { format!("computed in {:.0} ms", shown.seconds * 1e3) } else { "reading…".into() }, false));
        for (i, (line, strong)) in lines.iter().enumerate() {
            let (size, color) = if *strong { (20.0, ui.visuals().strong_text_color()) } else { (13.0, ui.visuals().text_color()) };
            let y = place.top() + if i == 0 { 0.0 } else { 8.0 + 20.0 * i as f32 };
            ui.painter().text(pos2(left, y), Align2::LEFT_TOP, line, FontId::proportional(size), color);
        }
        if let Some(failed) = &self.failed {
            ui.painter().text(place.left_bottom(), Align2::LEFT_BOTTOM, failed, FontId::proportional(12.0), plot::line_color(ui, 1));
        }
    }
}

fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(8.0);
    ui.label(RichText::new(text).strong().size(14.0));
}

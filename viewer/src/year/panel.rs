//! Painting the Year panel and taking its clicks.

use super::carpet;
use super::model::{Quantity, Ranking, View, glare_quantity, typical_maximum};
use super::scrub::{Answer, Scrubber};
use super::states::{States, YearLux};
use super::wish::Wish;
use crate::bsdf::model::BsdfFile;
use crate::job::Derived;
use crate::outbox::Outbox;
use crate::picture::model::{Judged, PictureFile};
use crate::plot::{self, empty_state};
use crate::results::Results;
use crate::texture::CachedTexture;
use eframe::egui::{self, Align2, FontId, Key, Rect, RichText, pos2, vec2};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::weather::time::steps_per_day;
use std::sync::Arc;

/// The panel with what it has computed.
#[derive(Default)]
pub struct YearPanel {
    pub(super) values: (String, Vec<f64>, f64),
    /// Hours by their glare.
    pub(super) ranking: (String, Ranking),
    /// What header and carpet show in place of the chosen state of the façade.
    pub(super) note: Option<Note>,
    /// What the plan shows in place of it.
    pub(super) plan_note: Option<String>,
    /// Since when the picture is not the one that was asked for, s.
    pub(super) picture_late: Option<f64>,
    pub(super) carpet: CachedTexture,
    pub(super) scrubber: Option<Scrubber>,
    pub(super) shown: Option<Shown>,
    pub(super) glare: Option<(Wish, Option<Judged>)>,
    pub(super) picture: CachedTexture,
    pub(super) failed: Option<String>,
    pub(super) states: States,
    pub(super) state_window: usize,
    pub(super) sky: Derived<String, Option<Matrix<f32>>>,
    pub(super) dome: CachedTexture,
    pub(super) playing: bool,
    /// End of an automatic scale of the plan, lx.
    pub(super) plan_maximum: f64,
    pub(super) readout: String,
    pub(super) pending: Vec<BsdfFile>,
}

/// Said beside what is not as chosen.
pub struct Note {
    /// What it is.
    pub(super) text: String,
    /// Whether it will be another soon, or should be another.
    pub(super) late: bool,
}

/// The picture on the screen.
pub struct Shown {
    pub(super) wish: Wish,
    pub(super) file: PictureFile,
    pub(super) whole: bool,
    /// Whether its sun is as traced (five phases).
    pub(super) traced: bool,
    pub(super) seconds: f64,
    /// End of an automatic scale.
    pub(super) maximum: f64,
    /// Mean luminance, cd/m².
    pub(super) mean: f64,
}

impl YearPanel {
    /// Shows other results.
    pub fn open(&mut self, results: &Arc<Results>, view: &mut View) {
        view.fit(results);
        let mut states = std::mem::take(&mut self.states);
        states.reset(results.windows.len());
        let plan_maximum = typical_maximum(&Quantity::Mean(plan_group(results)).values(results, None));
        *self = Self { states, plan_maximum, ..Self::default() };
    }

    /// Takes a BSDF as another state of the façade.
    pub fn add_state(&mut self, file: BsdfFile) {
        self.pending.push(file);
    }

    /// Whether the year's illuminance will still change.
    pub fn follows_facade(&self) -> bool {
        self.states.busy()
    }

    /// Whether anything of this panel will still change while it is shown.
    pub fn busy(&self) -> bool {
        let picture = self.scrubber.as_ref().is_some_and(|s| {
            self.failed.is_none() && (s.wanted() != self.shown.as_ref().filter(|p| p.whole).map(|p| &p.wish) || self.waits_for_glare())
        });
        picture || self.sky.busy() || !self.pending.is_empty()
    }

    /// The year's illuminance in the chosen state of the façade.
    pub fn lux(&self, results: &Results, fractions: &[f64]) -> YearLux<'_> {
        self.states.lux(&results.windows, fractions)
    }

    /// Keeps the year's illuminance up with the façade, whichever panel shows it.
    pub fn follow_facade(&mut self, ctx: &egui::Context, view: &mut View, results: &Arc<Results>) {
        view.fractions.resize(results.windows.len(), 0.0);
        self.states.update(ctx, results, &view.fractions);
    }

    /// Hour of the picture on the screen, and the seconds it took.
    #[cfg(test)]
    pub fn picture_shown(&self) -> Option<(usize, f64)> {
        self.shown.as_ref().map(|s| (s.wish.hour, s.seconds))
    }

    fn waits_for_glare(&self) -> bool {
        match (&self.shown, &self.glare) {
            (Some(shown), Some((wish, _))) => *wish != shown.wish,
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
        for (key, places) in [(Key::W, None), (Key::N, Some(1)), (Key::P, Some(-1))] {
            if pressed(key) {
                self.go_to_worst(view, results, places);
            }
        }
        if pressed(Key::M) {
            let lux = self.lux(results, &view.fractions);
            view.hour = Ranking::of(view.quantity, results, lux.lux).worst().unwrap_or(view.hour);
        }
        if pressed(Key::Space) {
            self.playing = !self.playing;
        }
        if pressed(Key::L) {
            view.picture.log = !view.picture.log;
        }
    }

    /// Goes to the worst glare hour, or as many places further down from the hour shown.
    pub(super) fn go_to_worst(&mut self, view: &mut View, results: &Results, places: Option<isize>) {
        let Some(quantity) = glare_quantity(results, view.quantity) else { return };
        self.rank(view, results);
        if !view.quantity.is_glare() {
            view.quantity = quantity;
        }
        let ranking = &self.ranking.1;
        let hour = places.map_or_else(|| ranking.worst(), |places| ranking.beside(view.hour, places));
        view.hour = hour.unwrap_or(view.hour);
    }

    /// Brings the order of the glare hours up to date.
    fn rank(&mut self, view: &View, results: &Results) {
        let Some(quantity) = glare_quantity(results, view.quantity) else { return };
        let lux = self.states.lux(&results.windows, &view.fractions);
        let key = format!("{} {quantity:?} {}", results.folder().display(), lux.key);
        if self.ranking.0 != key {
            self.ranking = (key, Ranking::of(quantity, results, lux.lux));
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
        if self.playing {
            let per_day = steps_per_day(results.hours());
            let next = view.hour + 1;
            view.hour = if next.is_multiple_of(per_day) { next - per_day } else { next };
            ctx.request_repaint_after(std::time::Duration::from_millis(150));
        }
        self.sky.update(ctx, results.folder().display().to_string(), || {
            let path = results.matrix("S");
            move || read_matrix(&path).ok().map(|f| f.matrix)
        });
        self.follow_facade(ctx, view, results);
        self.rank(view, results);
        let lux = self.states.lux(&results.windows, &view.fractions);
        let key = format!("{} {:?} {}", results.folder().display(), view.quantity, lux.key);
        if self.values.0 != key {
            let values = view.quantity.values(results, lux.lux);
            let maximum = typical_maximum(&values);
            self.values = (key, values, maximum);
        }
        self.note = match (view.quantity.is_stored_only(), &lux.state, &lux.instead) {
            (true, Some(state), _) => Some(Note { text: format!("of the façade as computed, not with {state}"), late: false }),
            (false, _, Some(instead)) => Some(Note { text: instead.clone(), late: true }),
            _ => None,
        };
        self.plan_note = lux.instead;
        let Some(file) = results.views.get(view.view) else { return };
        if self.scrubber.as_ref().is_none_or(|s| s.view != file.name) {
            (self.shown, self.glare, self.failed) = (None, None, None);
            self.scrubber = Some(Scrubber::start(ctx, results, file));
        }
        let Some(scrubber) = &mut self.scrubber else { return };
        scrubber.wish(self.states.wish(view.hour, &view.fractions));
        for answer in scrubber.answers() {
            match answer {
                Answer::Picture { wish, file, whole, traced, seconds } => {
                    let maximum = file.typical_maximum();
                    let mean = file.luminance.iter().map(|v| f64::from(*v)).sum::<f64>() / file.luminance.len().max(1) as f64;
                    self.shown = Some(Shown { wish, file: *file, whole, traced, seconds, maximum, mean });
                }
                Answer::Glare { wish, judged } => self.glare = Some((wish, judged.map(|j| *j))),
                Answer::Failed(error) => self.failed = Some(error.to_string()),
            }
        }
        let late = self.picture_note(results).is_some();
        self.picture_late = late.then(|| self.picture_late.unwrap_or(ctx.input(|i| i.time)));
    }

    /// What the picture on the screen is, if it is not the one asked for last.
    pub(super) fn picture_note(&self, results: &Results) -> Option<String> {
        let (shown, wanted) = (&self.shown.as_ref()?.wish, self.scrubber.as_ref()?.wanted()?);
        shown.instead_of(wanted, results)
    }

    pub(super) fn picture_maximum(&self) -> f64 {
        self.shown.as_ref().map_or(1000.0, |s| s.maximum)
    }

    fn center(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>) {
        let time = results.times[view.hour];
        // Errors are those of the façade as it was computed.
        let (quantity, changed) = (view.quantity, self.states.changed(&view.fractions));
        let error = |hour: usize| quantity.error(results, hour).filter(|_| !changed);
        ui.horizontal(|ui| {
            let play = if self.playing { "Stop" } else { "Play the day" };
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.button(play).on_hover_text("Space").clicked() {
                    self.playing = !self.playing;
                }
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.label(RichText::new(time.to_string()).strong().size(17.0));
                    if ui.available_width() > 220.0 {
                        ui.weak(format!("hour {}", view.hour));
                    }
                    let value = self.values.1.get(view.hour).copied().unwrap_or(f64::NAN);
                    let text = view.quantity.text(results, view.hour, value, error(view.hour));
                    ui.add(egui::Label::new(RichText::new(text).strong()).truncate());
                });
            });
        });
        if let Some(note) = &self.note {
            let text = format!("{}: {}", view.quantity.unit(), note.text);
            ui.add(egui::Label::new(RichText::new(text).color(ui.visuals().warn_fg_color)).wrap());
        }
        ui.horizontal(|ui| {
            ui.spacing_mut().slider_width = ui.available_width() - 16.0;
            let last = results.hours().saturating_sub(1);
            ui.add(egui::Slider::new(&mut view.hour, 0..=last).show_value(false))
                .on_hover_text("Drag through the year; arrow keys step by hours and days");
        });
        let area = ui.available_rect_before_wrap();
        let height = (area.height() * 0.34).clamp(120.0, 340.0);
        let outer = Rect::from_min_size(area.min, vec2(area.width(), height));
        let title = self.titled(view.quantity.name(results));
        let (key, values, maximum) = std::mem::take(&mut self.values);
        let hovered = carpet::show(ui, outer, &mut self.carpet, &key, view, &values, &results.times, &title, maximum);
        if let Some(step) = hovered {
            let value = view.quantity.text(results, step, values[step], error(step));
            self.readout = format!("{}   hour {step}   {value}", results.times[step]);
        }
        if let Some(note) = self.note.as_ref().filter(|n| n.late) {
            plot::veil(ui, carpet::Layout::new(outer, values.len()).field, &note.text);
        }
        self.values = (key, values, maximum);
        let status = 22.0;
        let below = Rect::from_min_max(pos2(area.left(), outer.bottom() + 8.0), pos2(area.right(), area.bottom() - status));
        if results.views.is_empty() {
            let middle = below.left() + below.width() * 0.5;
            self.day(ui, Rect::from_min_max(below.min, pos2(middle, below.bottom())), view, results);
            self.plan(ui, Rect::from_min_max(pos2(middle, below.top()), below.max), view, results);
        } else {
            let left = self.hour_picture(ui, below, view, results);
            let rest = Rect::from_min_max(pos2(left - 40.0, below.top() + 190.0), below.max);
            if rest.width() > 260.0 && rest.height() > 150.0 {
                self.plan(ui, rest, view, results);
            }
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
}

impl YearPanel {
    /// A title of what follows the header's quantity.
    pub(super) fn titled(&self, title: String) -> String {
        match &self.note {
            Some(note) if note.late => title + " (another state)",
            Some(_) => title + " (façade as computed)",
            None => title,
        }
    }
}

/// The group of sensors shown on the plan: the first whose places are known.
pub fn plan_group(results: &Results) -> usize {
    results.sensors.iter().position(|g| !g.positions.is_empty()).unwrap_or(0)
}

//! Painting the Year panel and taking its clicks.

use super::carpet;
use super::model::{Quantity, View, glare_quantity, steps_per_day, typical_maximum, worst};
use super::scrub::{Answer, Scrubber, Wish};
use super::states::States;
use crate::app::Outbox;
use crate::bsdf::model::BsdfFile;
use crate::job::Derived;
use crate::picture::model::{Judged, PictureFile};
use crate::plot::empty_state;
use crate::results::Results;
use crate::texture::CachedTexture;
use eframe::egui::{self, Align2, FontId, Key, Rect, RichText, pos2, vec2};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use std::sync::Arc;

/// The panel with what it has computed.
#[derive(Default)]
pub struct YearPanel {
    pub(super) values: (String, Vec<f64>, f64),
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

    /// Whether the picture or the carpet will still change.
    pub fn busy(&self) -> bool {
        let picture = self.scrubber.as_ref().is_some_and(|s| {
            self.failed.is_none() && (s.wanted() != self.shown.as_ref().filter(|p| p.whole).map(|p| &p.wish) || self.waits_for_glare())
        });
        picture || self.states.busy() || self.sky.busy() || !self.pending.is_empty()
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

    pub(super) fn go_to_worst(&mut self, view: &mut View, results: &Results) {
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
                Answer::Picture { wish, file, whole, traced, seconds } => {
                    let maximum = file.typical_maximum();
                    let mean = file.luminance.iter().map(|v| f64::from(*v)).sum::<f64>() / file.luminance.len().max(1) as f64;
                    self.shown = Some(Shown { wish, file: *file, whole, traced, seconds, maximum, mean });
                }
                Answer::Glare { wish, judged } => self.glare = Some((wish, judged.map(|j| *j))),
                Answer::Failed(error) => self.failed = Some(error.to_string()),
            }
        }
    }

    pub(super) fn picture_maximum(&self) -> f64 {
        self.shown.as_ref().map_or(1000.0, |s| s.maximum)
    }

    fn center(&mut self, ui: &mut egui::Ui, view: &mut View, results: &Arc<Results>) {
        let stamp = results.stamps[view.hour];
        // Errors are those of the façade as it was computed.
        let (quantity, changed) = (view.quantity, self.states.changed(&view.fractions));
        let error = |hour: usize| quantity.error(results, hour).filter(|_| !changed);
        ui.horizontal(|ui| {
            ui.label(RichText::new(stamp.text()).strong().size(17.0));
            ui.weak(format!("hour {}", view.hour));
            let value = self.values.1.get(view.hour).copied().unwrap_or(f64::NAN);
            ui.strong(view.quantity.text(value, error(view.hour)));
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
            self.readout = format!("{}   hour {step}   {}", results.stamps[step].text(), view.quantity.text(values[step], error(step)));
        }
        self.values = (key, values, maximum);
        let status = 22.0;
        let below = Rect::from_min_max(pos2(area.left(), outer.bottom() + 8.0), pos2(area.right(), area.bottom() - status));
        if results.views.is_empty() {
            let middle = below.left() + below.width() * 0.5;
            self.day(ui, Rect::from_min_max(below.min, pos2(middle, below.bottom())), view, results);
            self.plan(ui, Rect::from_min_max(pos2(middle, below.top()), below.max), view, results);
        } else {
            let left = self.hour_picture(ui, below, view);
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

/// The group of sensors shown on the plan: the first whose places are known.
pub fn plan_group(results: &Results) -> usize {
    results.groups.iter().position(|g| !g.positions.is_empty()).unwrap_or(0)
}

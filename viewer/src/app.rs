//! The window: menu, tabs, messages, and what happens to files and keys.

use crate::args::{Args, PanelKind, Size, ThemeChoice, window_size};
use crate::bsdf::BsdfPanel;
use crate::grid::GridPanel;
use crate::help;
use crate::history::History;
use crate::job::Job;
use crate::open::{Opened, open};
use crate::outbox::Outbox;
use crate::picture::PicturePanel;
use crate::remember::Remembered;
use crate::results::Results;
use crate::save::Saving;
use crate::year::YearPanel;
use crate::{bsdf, grid, picture, year};
use eframe::egui::{self, Color32, Key, KeyboardShortcut, Modifiers};
use lucarne::image::palette::Palette;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Everything the user has chosen: what undo brings back.
#[derive(Clone, PartialEq, Default)]
pub struct Views {
    /// Panel in front.
    pub panel: PanelKind,
    /// BSDF panel.
    pub bsdf: bsdf::model::View,
    /// Picture panel.
    pub picture: picture::model::View,
    /// Year panel.
    pub year: year::model::View,
    /// Grid panel.
    pub grid: grid::model::View,
}

/// The program's state.
pub struct App {
    /// What the user has chosen.
    pub views: Views,
    pub(crate) history: History<Views>,
    pub(crate) bsdf: BsdfPanel,
    pub(crate) picture: PicturePanel,
    pub(crate) year: YearPanel,
    pub(crate) grid: GridPanel,
    pub(crate) results: Option<Arc<Results>>,
    pub(crate) loading: Vec<(PathBuf, Job<lucarne::Result<Opened>>)>,
    pub(crate) waiting: Vec<PathBuf>,
    pub(crate) messages: Vec<(bool, String)>,
    pub(crate) remembered: Remembered,
    pub(crate) remember_at: Option<PathBuf>,
    /// Text of the field of "Open".
    pub(crate) path_field: Option<String>,
    pub(crate) saving: Option<Saving>,
    pub(crate) help: bool,
    pub(crate) panel_wanted: Option<PanelKind>,
    pub(crate) hour_wanted: Option<usize>,
    /// Size that the window shall have once it is there.
    size_wanted: Option<Size>,
}

impl App {
    /// The program with the files of `args`; its state is remembered at `remember_at`.
    pub fn new(ctx: &egui::Context, args: &Args, remember_at: Option<PathBuf>) -> Self {
        let remembered = remember_at.as_deref().map(Remembered::read).unwrap_or_default();
        style(ctx);
        let theme = match (args.theme, remembered.theme.as_str()) {
            (Some(ThemeChoice::Dark), _) | (None, "dark") => egui::ThemePreference::Dark,
            (Some(ThemeChoice::Light), _) | (None, "light") => egui::ThemePreference::Light,
            // Without a window system there is no preference to follow.
            _ if args.screenshot.is_some() => egui::ThemePreference::Light,
            _ => egui::ThemePreference::System,
        };
        ctx.set_theme(theme);
        // Pixels of a screenshot are as large as asked for; those of a screen have a size of their own.
        let zoom = args.scale.or((remembered.zoom > 0.0).then_some(remembered.zoom));
        if let Some(zoom) = zoom.filter(|_| args.screenshot.is_none()) {
            ctx.set_zoom_factor(zoom.clamp(0.5, 4.0));
        }
        let mut views = Views::default();
        if let Ok(palette) = Palette::from_name(&remembered.palette) {
            views.bsdf.palette = palette;
            views.picture.palette = palette;
            views.year.palette = palette;
            views.grid.palette = palette;
        }
        if let Some(panel) = args.panel {
            views.panel = panel;
        }
        let mut app = Self {
            history: History::new(views.clone()),
            views,
            bsdf: BsdfPanel::default(),
            picture: PicturePanel::default(),
            year: YearPanel::default(),
            grid: GridPanel::default(),
            results: None,
            loading: Vec::new(),
            waiting: Vec::new(),
            messages: Vec::new(),
            remembered,
            remember_at,
            path_field: None,
            saving: None,
            help: false,
            panel_wanted: args.panel,
            hour_wanted: args.hour,
            size_wanted: args.size,
        };
        let again = app.remembered.recent.first().filter(|p| args.files.is_empty() && p.exists()).cloned();
        app.waiting = if args.files.is_empty() { again.into_iter().collect() } else { args.files.clone() };
        app
    }

    /// Opens a file in the background.
    pub fn open(&mut self, path: &Path) {
        self.waiting.push(path.to_path_buf());
    }

    /// Whether something is computed whose result will still change the window.
    pub fn busy(&self) -> bool {
        !self.loading.is_empty()
            || !self.waiting.is_empty()
            || self.bsdf.busy()
            || self.picture.busy()
            || self.year.follows_facade()
            || (self.views.panel == PanelKind::Year && self.year.busy())
            || self.grid.busy()
    }

    /// Whether the year's picture is that of an hour.
    #[cfg(test)]
    pub fn shows_hour(&self, hour: usize) -> bool {
        self.year.picture_shown().is_some_and(|p| p.0 == hour)
    }

    /// What the year's picture took to compute.
    #[cfg(test)]
    pub fn seconds_of_picture(&self) -> f64 {
        self.year.picture_shown().map_or(0.0, |p| p.1)
    }

    /// The first failure that is shown.
    pub fn first_error(&self) -> Option<String> {
        self.messages.iter().find(|(bad, _)| *bad).map(|(_, text)| text.clone())
    }

    /// One frame.
    pub fn frame(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        self.take_files(&ctx);
        let mut out = Outbox::default();
        if self.takes_keys(&ctx) {
            self.shortcuts(ui);
        }
        egui::Panel::top("menu").show(ui, |ui| self.menu(ui));
        if !self.messages.is_empty() {
            egui::Panel::bottom("messages").show(ui, |ui| self.message_list(ui));
        }
        let fill = ui.visuals().panel_fill;
        egui::CentralPanel::default().frame(egui::Frame::NONE.fill(fill)).show(ui, |ui| self.panel(ui, &mut out));
        if self.help {
            self.help = help::show(&ctx, self.views.panel);
        }
        self.open_field(&ctx);
        if let Some(mut saving) = self.saving.take()
            && saving.show(&ctx, &mut out)
        {
            self.saving = Some(saving);
        }
        self.carry_out(out);
        if !ctx.input(|i| i.pointer.any_down()) {
            self.history.note(&self.views);
        }
    }

    /// Whether keys are shortcuts: not while something is typed, and not while a list or menu is open.
    fn takes_keys(&self, ctx: &egui::Context) -> bool {
        let asks = self.saving.is_some() || self.path_field.is_some();
        !asks && !ctx.egui_wants_keyboard_input() && !egui::Popup::is_any_open(ctx)
    }

    fn panel(&mut self, ui: &mut egui::Ui, out: &mut Outbox) {
        // Asked again: a shortcut of this frame may have opened a field.
        let keys = !self.help && self.takes_keys(ui.ctx());
        if let Some(results) = &self.results {
            self.year.follow_facade(ui.ctx(), &mut self.views.year, results);
        }
        match self.views.panel {
            PanelKind::Bsdf => {
                if keys {
                    self.bsdf.keys(ui, &mut self.views.bsdf);
                }
                self.bsdf.show(ui, &mut self.views.bsdf, out);
            }
            PanelKind::Picture => {
                if keys {
                    self.picture.keys(ui, &mut self.views.picture);
                }
                self.picture.show(ui, &mut self.views.picture, out);
            }
            PanelKind::Year => {
                if keys && let Some(results) = &self.results {
                    self.year.keys(ui, &mut self.views.year, results);
                }
                self.year.show(ui, &mut self.views.year, self.results.as_ref(), out);
            }
            PanelKind::Grid => {
                let hour = &mut self.views.year.hour;
                if keys && let Some(results) = &self.results {
                    self.grid.keys(ui, &mut self.views.grid, results, hour);
                }
                let lux = self.results.as_ref().map(|r| self.year.lux(r, &self.views.year.fractions)).unwrap_or_default();
                self.grid.show(ui, &mut self.views.grid, self.results.as_ref(), &lux, hour);
            }
        }
    }

    fn carry_out(&mut self, out: Outbox) {
        self.messages.extend(out.messages);
        if let Some((name, write)) = out.save {
            self.saving = Some(Saving::new(&name, write));
        }
        if let Some(panel) = out.show {
            self.views.panel = panel;
        }
    }

    fn take_files(&mut self, ctx: &egui::Context) {
        let dropped: Vec<PathBuf> = ctx.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_path_buf()).collect());
        self.waiting.extend(dropped.into_iter().filter(|p| !p.as_os_str().is_empty()));
        for path in std::mem::take(&mut self.waiting) {
            let file = path.clone();
            self.loading.push((path, Job::start(ctx, move || open(&file))));
        }
        // In the order they were asked for, so that the second BSDF is the second.
        while let Some(result) = self.loading.first().and_then(|(_, job)| job.poll()) {
            let (path, _) = self.loading.remove(0);
            match result {
                Ok(Ok(opened)) => {
                    self.remembered.opened(&path);
                    self.remember();
                    self.take(opened);
                }
                Ok(Err(error)) => self.messages.push((true, error.to_string())),
                Err(()) => self.messages.push((true, format!("{}: reading failed unexpectedly", path.display()))),
            }
        }
    }

    fn take(&mut self, opened: Opened) {
        let panel = match opened {
            Opened::Bsdf(file) => {
                if self.views.panel == PanelKind::Year && self.results.is_some() && self.panel_wanted.is_none() {
                    // Over a year a BSDF is another state of the façade.
                    self.year.add_state(file);
                    return;
                }
                let beside = self.bsdf.count() == 1;
                self.bsdf.open(file, &mut self.views.bsdf, beside);
                PanelKind::Bsdf
            }
            Opened::Picture(file) => {
                self.picture.open(*file, &mut self.views.picture);
                PanelKind::Picture
            }
            Opened::Results(results) => {
                self.year.open(&results, &mut self.views.year);
                self.grid.open(&results, &mut self.views.grid);
                if let Some(hour) = self.hour_wanted.take() {
                    let last = results.hours().saturating_sub(1);
                    if hour > last {
                        self.messages.push((true, format!("--hour: hour {hour} does not exist; the last one is {last}")));
                    }
                    self.views.year.hour = hour.min(last);
                }
                self.messages.extend(results.notes.iter().map(|n| (false, n.clone())));
                self.results = Some(results);
                if self.views.panel == PanelKind::Grid { PanelKind::Grid } else { PanelKind::Year }
            }
        };
        self.views.panel = self.panel_wanted.take().unwrap_or(panel);
        self.history.amend(&self.views);
    }

    fn shortcuts(&mut self, ui: &egui::Ui) {
        let ctx = ui.ctx();
        // Ctrl with Alt types letters on many keyboards.
        let command = |key: Key| ctx.input_mut(|i| !i.modifiers.alt && i.consume_shortcut(&KeyboardShortcut::new(Modifiers::COMMAND, key)));
        if command(Key::O) {
            self.path_field = Some(String::new());
        }
        for (panel, key) in PanelKind::ALL.into_iter().zip([Key::Num1, Key::Num2, Key::Num3, Key::Num4]) {
            if command(key) {
                self.views.panel = panel;
            }
        }
        if ctx.input_mut(|i| i.consume_shortcut(&KeyboardShortcut::new(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z))) || command(Key::Y) {
            self.redo();
        }
        if command(Key::Z) {
            self.undo();
        }
        if command(Key::D) {
            self.set_theme(ctx, !ui.visuals().dark_mode);
        }
        let asked = ctx.input(|i| i.key_pressed(Key::F1) || i.key_pressed(Key::Questionmark));
        if asked {
            self.help = !self.help;
        }
        if ctx.input(|i| i.key_pressed(Key::Escape)) && !self.help {
            self.messages.clear();
        }
    }

    /// Makes the window as many pixels large as was asked for: only an open window knows its screen.
    pub(crate) fn fit_window(&mut self, ctx: &egui::Context) {
        if let Some(Size([w, h])) = self.size_wanted.take() {
            let points = egui::vec2(w as f32, h as f32) / ctx.pixels_per_point();
            ctx.send_viewport_cmd(egui::ViewportCommand::MinInnerSize(points.min(egui::vec2(640.0, 480.0) / ctx.zoom_factor())));
            ctx.send_viewport_cmd(egui::ViewportCommand::InnerSize(points));
        }
    }

    fn remember(&mut self) {
        self.remembered.palette = self.views.bsdf.palette.name().into();
        if let Some(path) = &self.remember_at {
            self.remembered.write(path);
        }
    }

    pub fn undo(&mut self) {
        if let Some(views) = self.history.undo() {
            self.views = views;
        }
    }

    pub fn redo(&mut self) {
        if let Some(views) = self.history.redo() {
            self.views = views;
        }
    }

    pub fn set_theme(&mut self, ctx: &egui::Context, dark: bool) {
        ctx.set_theme(if dark { egui::ThemePreference::Dark } else { egui::ThemePreference::Light });
        self.remembered.theme = if dark { "dark" } else { "light" }.into();
    }
}

fn style(ctx: &egui::Context) {
    ctx.all_styles_mut(|s| {
        s.spacing.item_spacing = egui::vec2(8.0, 5.0);
        s.spacing.button_padding = egui::vec2(7.0, 3.0);
        for (style, size) in [(egui::TextStyle::Body, 13.5), (egui::TextStyle::Button, 13.5), (egui::TextStyle::Small, 11.5)] {
            if let Some(font) = s.text_styles.get_mut(&style) {
                font.size = size;
            }
        }
        // The default greys are faint on white.
        if !s.visuals.dark_mode {
            s.visuals.override_text_color = Some(Color32::from_gray(35));
            s.visuals.weak_text_color = Some(Color32::from_gray(95));
        } else {
            s.visuals.override_text_color = Some(Color32::from_gray(222));
            s.visuals.weak_text_color = Some(Color32::from_gray(160));
        }
    });
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.fit_window(ui.ctx());
        self.frame(ui);
        let zoom = ui.ctx().zoom_factor();
        self.remembered.zoom = zoom;
        let size = ui.ctx().content_rect().size() * zoom;
        self.remembered.window = Some([size.x, size.y]);
    }

    fn on_exit(&mut self) {
        self.remember();
    }
}

/// Opens the window and runs until it is closed.
pub fn run_window(args: &Args) -> Result<(), String> {
    let remember_at = Remembered::path();
    let known = remember_at.as_deref().map(Remembered::read).and_then(|r| r.window);
    let [first, least] = window_size(args.size, known);
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default().with_inner_size(first).with_min_inner_size(least),
        ..Default::default()
    };
    let args = args.clone();
    eframe::run_native("Lucarne", options, Box::new(move |cc| Ok(Box::new(App::new(&cc.egui_ctx, &args, remember_at))))).map_err(|e| {
        format!(
            "{e}\n  help: the window needs a desktop session and a graphics driver; without them, --screenshot FILE.png writes a picture"
        )
    })
}

//! Painting the picture panel and taking its clicks.

use super::model::{Judged, Mode, PictureFile, Tone, Tool, View, histogram, judge, profile};
use super::place::{Placement, overlay, pixel_of, readout};
use super::show;
use crate::bsdf::palette_choice;
use crate::job::Derived;
use crate::outbox::Outbox;
use crate::plot::{self, Axes, empty_state, halo_text};
use crate::scale::{BAR_WIDTH, draggable_bar};
use crate::texture::CachedTexture;
use eframe::egui::{self, Align2, Color32, FontId, Key, Rect, RichText, Sense, Stroke, pos2, vec2};
use lucarne::image::palette::rounded_number;
use std::sync::Arc;

/// The panel with its picture.
#[derive(Default)]
pub struct PicturePanel {
    file: Option<Arc<PictureFile>>,
    maximum: f64,
    texture: CachedTexture,
    histogram: Option<([f64; 2], Vec<f64>)>,
    judged: Derived<String, Result<Judged, String>>,
}

impl PicturePanel {
    /// Shows a picture.
    pub fn open(&mut self, file: PictureFile, view: &mut View) {
        let same_size =
            self.file.as_ref().is_some_and(|f| (f.picture.width, f.picture.height) == (file.picture.width, file.picture.height));
        if !same_size {
            (view.zoom, view.middle, view.profile, view.task) = (1.0, [0.5, 0.5], None, None);
        }
        self.maximum = file.typical_maximum();
        self.histogram = Some(histogram(&file.luminance, 60));
        self.file = Some(Arc::new(file));
    }

    /// Whether glare is still being judged.
    pub fn busy(&self) -> bool {
        self.judged.busy()
    }

    /// Keys of this panel.
    pub fn keys(&mut self, ui: &egui::Ui, view: &mut View) {
        let pressed = |key: Key| ui.input(|i| i.key_pressed(key) && !i.modifiers.command);
        if pressed(Key::F) {
            view.mode = if view.mode == Mode::Falsecolor { Mode::Photograph } else { Mode::Falsecolor };
        }
        if pressed(Key::L) {
            view.scale.log = !view.scale.log;
        }
        if pressed(Key::S) {
            view.sources = !view.sources;
        }
        if pressed(Key::Plus) || pressed(Key::Equals) {
            view.stops += 0.5;
        }
        if pressed(Key::Minus) {
            view.stops -= 0.5;
        }
        if pressed(Key::Num0) {
            (view.zoom, view.middle) = (1.0, [0.5, 0.5]);
        }
        for (key, tool) in [(Key::I, Tool::Inspect), (Key::P, Tool::Profile), (Key::T, Tool::Task)] {
            if pressed(key) {
                view.tool = tool;
            }
        }
    }

    /// Paints the panel.
    pub fn show(&mut self, ui: &mut egui::Ui, view: &mut View, out: &mut Outbox) {
        let Some(file) = self.file.clone() else {
            empty_state(
                ui,
                "No picture is open",
                &[
                    "Drop a picture (.hdr, .pic, .exr) here, or open one with Ctrl+O.",
                    "The Year panel shows the pictures of a result folder without any file.",
                ],
            );
            return;
        };
        let key = format!("{} {} {:?}", file.id, view.threshold, view.task);
        if !ui.input(|i| i.pointer.any_down()) {
            self.judged.update(ui.ctx(), key, || {
                let (file, threshold, task) = (file.clone(), view.threshold, view.task);
                move || judge(&file, threshold, task).map_err(|e| e.message().to_string())
            });
        }
        egui::Panel::left("picture-side").exact_size(272.0).resizable(false).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| self.side(ui, &file, view, out));
        });
        egui::CentralPanel::default().show(ui, |ui| self.center(ui, &file, view));
    }

    fn side(&mut self, ui: &mut egui::Ui, file: &Arc<PictureFile>, view: &mut View, out: &mut Outbox) {
        ui.add_space(4.0);
        let name = file.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        ui.strong(name).on_hover_text(file.path.display().to_string());
        ui.weak(format!("{} × {} {}", file.picture.width, file.picture.height, if file.unit.is_empty() { "entries" } else { "pixels" }));
        heading(ui, "Colours");
        ui.horizontal(|ui| {
            ui.selectable_value(&mut view.mode, Mode::Falsecolor, "Falsecolour").on_hover_text("Key F");
            ui.selectable_value(&mut view.mode, Mode::Photograph, "Photograph").on_hover_text("Key F");
        });
        match view.mode {
            Mode::Falsecolor => {
                view.scale.controls(ui, self.maximum, file.unit);
                palette_choice(ui, &mut view.palette);
            }
            Mode::Photograph => {
                ui.horizontal(|ui| {
                    ui.selectable_value(&mut view.tone, Tone::Linear, "Linear").on_hover_text("As a camera: bright parts are clipped");
                    ui.selectable_value(&mut view.tone, Tone::Reinhard, "Reinhard").on_hover_text("L/(1+L): bright parts are compressed");
                    ui.selectable_value(&mut view.tone, Tone::Logarithmic, "Log").on_hover_text("Four decades of luminance");
                });
                ui.add(egui::Slider::new(&mut view.stops, -8.0..=8.0).step_by(0.25).text("stops")).on_hover_text("Keys + and −");
            }
        }
        heading(ui, "Pointer");
        ui.horizontal(|ui| {
            ui.selectable_value(&mut view.tool, Tool::Inspect, "Inspect").on_hover_text("Read values, drag to move, wheel to zoom (key I)");
            ui.selectable_value(&mut view.tool, Tool::Profile, "Profile").on_hover_text("Drag a line to see its profile (key P)");
            ui.selectable_value(&mut view.tool, Tool::Task, "Task").on_hover_text("Click the middle of the task area (key T)");
        });
        if let Some((_, degrees)) = &mut view.task {
            let mut clear = false;
            ui.horizontal(|ui| {
                ui.add(egui::DragValue::new(degrees).range(1.0..=120.0).speed(0.5).suffix("° task circle"));
                clear = ui.button("Remove").clicked();
            });
            if clear {
                view.task = None;
            }
        }
        if !file.unit.is_empty() {
            self.glare(ui, view);
        }
        if let Some((range, counts)) = &self.histogram {
            heading(ui, "Histogram");
            let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 110.0), Sense::hover());
            let top = counts.iter().copied().fold(1e-6, f64::max);
            let axes =
                Axes { rect: Rect::from_min_max(rect.min + vec2(6.0, 4.0), rect.max - vec2(6.0, 34.0)), x: *range, y: [0.0, top * 1.08] };
            axes.paint(ui, "", &format!("log₁₀ {}", if file.unit.is_empty() { "value" } else { file.unit }), &ticks(*range), &[]);
            let width = (range[1] - range[0]) / counts.len() as f64;
            for (i, share) in counts.iter().enumerate() {
                let x = range[0] + width * i as f64;
                let bar = Rect::from_two_pos(axes.place(x, 0.0), axes.place(x + width, *share));
                ui.painter().rect_filled(bar, 0.0, plot::line_color(ui, 0));
            }
        }
        ui.add_space(6.0);
        if ui.button("Save falsecolour PNG…").clicked() {
            let (file, view, maximum) = (file.clone(), view.clone(), self.maximum);
            out.save(
                "falsecolor.png".into(),
                Box::new(move |path| {
                    let options = lucarne::image::falsecolor::FalseColor {
                        palette: view.palette,
                        maximum: Some(view.scale.end(maximum)),
                        decades: view.scale.log.then_some(view.scale.decades),
                        ..Default::default()
                    };
                    options.draw(&file.picture, None)?.write(path, 1.0)
                }),
            );
        }
    }

    fn glare(&self, ui: &mut egui::Ui, view: &mut View) {
        heading(ui, "Glare");
        ui.horizontal(|ui| {
            ui.checkbox(&mut view.sources, "Outline sources").on_hover_text("Key S");
            ui.add(egui::DragValue::new(&mut view.threshold).range(1.0..=1e6).speed(20.0)).on_hover_text(
                "Luminance above which a pixel is glare: above 100 in cd/m², up to 100 a multiple of the task's luminance or the mean",
            );
        });
        match self.judged.current() {
            None => {
                ui.spinner();
            }
            Some(Err(message)) => {
                ui.add(egui::Label::new(RichText::new(message).weak()).wrap());
            }
            Some(Ok(j)) => {
                let i = &j.glare.indices;
                egui::Grid::new("glare").num_columns(4).spacing([14.0, 3.0]).show(ui, |ui| {
                    for (k, (name, value, hint)) in [
                        ("DGP", format!("{:.3}", i.dgp), "Daylight glare probability"),
                        ("UGR", number(i.ugr), "Unified glare rating"),
                        ("DGI", number(i.dgi), "Daylight glare index"),
                        ("CGI", number(i.cgi), "CIE glare index"),
                        ("Ev", format!("{} lx", rounded_number(j.glare.vertical_illuminance)), "Illuminance at the eye"),
                        ("Sources", j.glare.sources.len().to_string(), "Glare sources found"),
                    ]
                    .into_iter()
                    .enumerate()
                    {
                        ui.weak(name).on_hover_text(hint);
                        ui.strong(value);
                        if k % 2 == 1 {
                            ui.end_row();
                        }
                    }
                });
                if j.partial {
                    let text = "The view is no hemisphere: Ev and DGP lack what lies outside it, and are too low.";
                    ui.add(egui::Label::new(RichText::new(text).color(ui.visuals().warn_fg_color)).wrap());
                }
                if let Some(l) = j.glare.task_luminance {
                    ui.label(format!("Task {} cd/m², threshold {} cd/m²", rounded_number(l), rounded_number(j.glare.threshold)));
                }
            }
        }
    }

    fn center(&mut self, ui: &mut egui::Ui, file: &PictureFile, view: &mut View) {
        let area = ui.available_rect_before_wrap();
        let status_height = 22.0;
        let profile_height = if view.profile.is_some() { (area.height() * 0.28).min(220.0) } else { 0.0 };
        let frame = Rect::from_min_max(
            area.min,
            pos2(
                area.right() - if view.mode == Mode::Falsecolor { BAR_WIDTH + 8.0 } else { 0.0 },
                area.bottom() - status_height - profile_height,
            ),
        );
        let place = Placement::new(frame, [file.picture.width, file.picture.height], view);
        let options = (view.mode, view.palette, view.scale, view.tone, view.stops);
        let texture = self.texture.get(ui.ctx(), format!("{} {options:?}", file.id), false, || show::image(file, view, self.maximum));
        let painter = ui.painter().with_clip_rect(place.window);
        painter.rect_filled(place.window, 0.0, plot::field(ui));
        painter.image(texture, place.whole, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        let judged = self.judged.current().and_then(|j| j.as_ref().ok());
        if let Some(j) = judged {
            overlay(&painter, &place, j, view.sources);
        }
        if let Some(ends) = view.profile {
            let [a, b] = ends.map(|p| place.screen(p));
            painter.line_segment([a, b], Stroke::new(4.0, Color32::BLACK));
            painter.line_segment([a, b], Stroke::new(2.0, Color32::WHITE));
            halo_text(&painter, a + vec2(-8.0, -8.0), Align2::CENTER_CENTER, "A", 13.0);
            halo_text(&painter, b + vec2(8.0, -8.0), Align2::CENTER_CENTER, "B", 13.0);
        }
        let response = ui.interact(place.window, ui.scope_id().with("picture"), Sense::click_and_drag());
        self.pointer(ui, &response, &place, file, view);
        let under = response.hover_pos().map(|p| place.pixel(p)).and_then(|p| pixel_of(file, p));
        if view.mode == Mode::Falsecolor {
            let bar = Rect::from_min_max(pos2(frame.right() + 14.0, place.window.top()), pos2(area.right(), place.window.bottom()));
            let value = under.map(|(x, y)| f64::from(file.luminance[y * file.picture.width + x]));
            draggable_bar(
                ui,
                bar,
                &mut view.scale,
                self.maximum,
                view.palette,
                if file.unit.is_empty() { "value" } else { file.unit },
                value,
            );
        }
        let text = match under {
            None => "Point at the picture to read it; wheel to zoom, 0 for the whole".to_string(),
            Some((x, y)) => readout(file, x, y, judged),
        };
        let status = pos2(area.left() + 4.0, area.bottom() - status_height / 2.0);
        ui.painter().text(status, Align2::LEFT_CENTER, text, FontId::proportional(13.0), ui.visuals().text_color());
        if let Some(ends) = view.profile {
            let rect = Rect::from_min_max(
                pos2(area.left(), area.bottom() - status_height - profile_height),
                pos2(area.right(), area.bottom() - status_height),
            );
            self.profile(ui, rect, file, view, ends);
        }
    }

    fn pointer(&self, ui: &egui::Ui, response: &egui::Response, place: &Placement, file: &PictureFile, view: &mut View) {
        if let Some(at) = response.hover_pos() {
            let wheel = ui.input(|i| i.smooth_scroll_delta().y) + 200.0 * (ui.input(|i| i.zoom_delta()) - 1.0);
            if wheel != 0.0 {
                view.zoom_at(f64::from(wheel * 0.005).exp(), place.share(at));
            }
        }
        let here = response.interact_pointer_pos().map(|p| place.pixel(p));
        let moving = response.dragged_by(egui::PointerButton::Secondary) || response.dragged_by(egui::PointerButton::Middle);
        match (view.tool, here) {
            (Tool::Inspect, _) if response.dragged() => place.shift(view, response.drag_delta()),
            _ if moving => place.shift(view, response.drag_delta()),
            (Tool::Profile, Some(p)) if response.drag_started() => view.profile = Some([p, p]),
            (Tool::Profile, Some(p)) if response.dragged() => {
                if let Some(ends) = &mut view.profile {
                    ends[1] = p;
                }
            }
            (Tool::Profile, _) if response.clicked() => view.profile = None,
            (Tool::Task, Some(p)) if response.clicked() || response.dragged() => {
                let inside = pixel_of(file, p).is_some();
                if inside {
                    view.task = Some((p, view.task.map_or(30.0, |t| t.1)));
                }
            }
            _ => {}
        }
    }

    fn profile(&self, ui: &egui::Ui, rect: Rect, file: &PictureFile, view: &View, ends: [[f64; 2]; 2]) {
        let points = profile(file, ends);
        let length = points.last().map_or(1.0, |p| p[0]).max(1.0);
        let top = points.iter().map(|p| p[1]).fold(0.0, f64::max);
        let scale = view.scale.scale(top.max(1e-9));
        let log = view.scale.log;
        let height = |v: f64| if log { v.max(scale.minimum()).log10() } else { v };
        let y = if log {
            [scale.minimum().log10(), lucarne::image::palette::round_up(top).log10().max(scale.minimum().log10() + 0.5)]
        } else {
            [0.0, lucarne::image::palette::round_up(top)]
        };
        let axes = Axes::inside(rect, [0.0, length], y);
        let y_ticks = if log { ticks(y) } else { lucarne::image::palette::round_steps(y[0], y[1], 4) };
        let title =
            format!("Profile from A to B, {}{}", if log { "log₁₀ " } else { "" }, if file.unit.is_empty() { "value" } else { file.unit });
        axes.paint(ui, &title, "pixels", &lucarne::image::palette::round_steps(0.0, length, 8), &y_ticks);
        axes.curve(ui, points.iter().map(|p| [p[0], height(p[1])]), plot::line_color(ui, 0), 1.5);
    }
}

fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    (low.ceil() as i32..=high.floor() as i32).map(f64::from).collect()
}

fn number(value: f64) -> String {
    if value < 0.0 { "–".into() } else { format!("{value:.1}") }
}

fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(8.0);
    ui.label(RichText::new(text).strong().size(14.0));
}

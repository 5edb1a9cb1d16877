//! The carpet of a year: days to the right, hours of the day upwards.

use super::model::{Quantity, View, class_name};
use crate::plot::{self, color32};
use crate::scale::{BAR_WIDTH, ColorBar, draggable_bar};
use crate::texture::CachedTexture;
use eframe::egui::{self, Align2, Color32, ColorImage, FontId, Rect, Sense, Stroke, pos2, vec2};
use lucarne::glare::annual::{CLASS_LIMITS, GlareClass};
use lucarne::image::palette::{Palette, Scale};
use lucarne::weather::time::{Time, steps_per_day};

/// Where the carpet lies on the screen.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// The field of cells.
    pub field: Rect,
    /// Steps in all.
    pub steps: usize,
}

impl Layout {
    /// The field inside `outer`.
    pub fn new(outer: Rect, steps: usize) -> Self {
        let field = Rect::from_min_max(outer.min + vec2(46.0, 24.0), outer.max - vec2(BAR_WIDTH + 14.0, 20.0));
        Self { field, steps }
    }

    fn days(&self) -> usize {
        self.steps.div_ceil(steps_per_day(self.steps)).max(1)
    }

    /// The step at a place.
    pub fn step_at(&self, at: egui::Pos2) -> Option<usize> {
        let per_day = steps_per_day(self.steps);
        let u = ((at.x - self.field.left()) / self.field.width()).clamp(0.0, 0.99999);
        let v = ((self.field.bottom() - at.y) / self.field.height()).clamp(0.0, 0.99999);
        let step = (u * self.days() as f32) as usize * per_day + (v * per_day as f32) as usize;
        (step < self.steps).then_some(step)
    }

    /// The cell of a step.
    pub fn cell(&self, step: usize) -> Rect {
        let per_day = steps_per_day(self.steps);
        let (w, h) = (self.field.width() / self.days() as f32, self.field.height() / per_day as f32);
        let x = self.field.left() + (step / per_day) as f32 * w;
        let y = self.field.bottom() - (step % per_day + 1) as f32 * h;
        Rect::from_min_size(pos2(x, y), vec2(w, h))
    }
}

const CLASSES: usize = GlareClass::ALL.len();

/// Colours of a carpet.
pub struct Colors {
    /// Palette.
    pub palette: Palette,
    /// Scale; classes have their own.
    pub scale: Scale,
    /// Whether values are classes.
    pub classes: bool,
}

impl Colors {
    /// Colour of a value.
    pub fn of(&self, value: f64, none: Color32) -> Color32 {
        if value.is_nan() {
            return none;
        }
        if self.classes {
            color32(self.palette.color(value / (CLASSES - 1) as f64))
        } else {
            color32(self.palette.color(self.scale.position(value)))
        }
    }
}

/// The colours for a quantity: DGP from 0.2 to 0.6, illuminance as the user has chosen.
pub fn colors(view: &View, maximum: f64) -> Colors {
    let scale = if view.quantity.is_glare() {
        Scale::linear(0.2, 0.6).unwrap_or_else(|_| view.carpet.scale(maximum))
    } else {
        view.carpet.scale(maximum)
    };
    Colors { palette: view.palette, scale, classes: matches!(view.quantity, Quantity::Class(_)) }
}

/// Paints the carpet and takes clicks; gives the step under the pointer.
#[allow(clippy::too_many_arguments)]
pub fn show(
    ui: &mut egui::Ui,
    outer: Rect,
    texture: &mut CachedTexture,
    key: &str,
    view: &mut View,
    values: &[f64],
    times: &[Time],
    title: &str,
    maximum: f64,
) -> Option<usize> {
    let layout = Layout::new(outer, values.len());
    let per_day = steps_per_day(values.len());
    let colors = colors(view, maximum);
    let none = if ui.visuals().dark_mode { Color32::from_gray(44) } else { Color32::from_gray(228) };
    let key = format!("{key} {:?} {:?} {:?} {}", view.palette, colors.scale, view.quantity, ui.visuals().dark_mode);
    let id = texture.get(ui.ctx(), key, false, || {
        let days = values.len().div_ceil(per_day).max(1);
        let mut pixels = vec![none; days * per_day];
        for (i, v) in values.iter().enumerate() {
            pixels[(per_day - 1 - i % per_day) * days + i / per_day] = colors.of(*v, none);
        }
        ColorImage::new([days, per_day], pixels)
    });
    let painter = ui.painter();
    let ink = ui.visuals().text_color();
    painter.image(id, layout.field, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
    painter.rect_stroke(layout.field, 0.0, Stroke::new(1.0, plot::axis(ui)), egui::StrokeKind::Outside);
    plot::title_above(ui, layout.field, title);
    // A narrow carpet has room for a letter.
    let letters = if layout.field.width() < 12.0 * 30.0 { 1 } else { 3 };
    for (name, day) in months(times, per_day) {
        let cell = layout.cell(day * per_day);
        painter.line_segment(
            [pos2(cell.left(), layout.field.bottom()), pos2(cell.left(), layout.field.bottom() + 4.0)],
            Stroke::new(1.0, plot::axis(ui)),
        );
        painter.text(
            pos2(cell.left() + 4.0, layout.field.bottom() + 3.0),
            Align2::LEFT_TOP,
            &name[..letters],
            FontId::proportional(11.5),
            ink,
        );
    }
    for hour in [0, 6, 12, 18, 24] {
        let y = layout.field.bottom() - layout.field.height() * hour as f32 / 24.0;
        painter.text(pos2(layout.field.left() - 5.0, y), Align2::RIGHT_CENTER, format!("{hour} h"), FontId::proportional(11.5), ink);
    }
    let chosen = layout.cell(view.hour);
    let (c, halo) = (chosen.center(), Color32::from_black_alpha(170));
    for (width, color) in [(3.0, halo), (1.0, Color32::WHITE)] {
        let line = Stroke::new(width, color);
        painter.hline(layout.field.left()..=c.x - 6.0, c.y, line);
        painter.hline(c.x + 6.0..=layout.field.right(), c.y, line);
        painter.vline(c.x, layout.field.top()..=c.y - 6.0, line);
        painter.vline(c.x, c.y + 6.0..=layout.field.bottom(), line);
        painter.circle_stroke(c, 6.0, line);
    }
    let bar =
        Rect::from_min_max(pos2(layout.field.right() + 14.0, layout.field.top() - 20.0), pos2(outer.right(), layout.field.bottom() + 6.0));
    let mark = values.get(view.hour).copied().filter(|v| !v.is_nan());
    if colors.classes {
        class_legend(ui, bar, &colors);
    } else if view.quantity.is_glare() {
        let scale = colors.scale;
        let color = |t: f64| color32(colors.palette.color(t));
        let ends = [scale.minimum(), scale.maximum()];
        let ticks = ends[..1].iter().chain(&CLASS_LIMITS).chain(&ends[1..]).map(|v| (scale.position(*v), format!("{v:.2}"))).collect();
        ColorBar { color: &color, label: view.quantity.unit(), ticks, mark: mark.map(|v| scale.position(v)) }.paint(ui, bar);
    } else {
        draggable_bar(ui, bar, &mut view.carpet, maximum, view.palette, view.quantity.unit(), mark);
    }
    let response =
        ui.interact(layout.field, ui.scope_id().with("carpet"), Sense::click_and_drag()).on_hover_cursor(egui::CursorIcon::Crosshair);
    if (response.clicked() || response.dragged())
        && let Some(step) = response.interact_pointer_pos().and_then(|p| layout.step_at(p))
    {
        view.hour = step;
    }
    response.hover_pos().and_then(|p| layout.step_at(p))
}

/// Name and first day (from 0) of each month.
pub fn months(times: &[Time], per_day: usize) -> Vec<(&'static str, usize)> {
    let mut found: Vec<(&'static str, usize)> = Vec::new();
    let mut last = 0;
    for (day, time) in times.iter().step_by(per_day.max(1)).enumerate() {
        if time.month != last {
            last = time.month;
            found.extend(time.month_name().get(..3).map(|name| (name, day)));
        }
    }
    found
}

fn class_legend(ui: &egui::Ui, bar: Rect, colors: &Colors) {
    for i in 0..CLASSES {
        let top = bar.top() + 20.0 + 34.0 * (CLASSES - 1 - i) as f32;
        let swatch = Rect::from_min_size(pos2(bar.left(), top), vec2(14.0, 14.0));
        ui.painter().rect_filled(swatch, 2.0, colors.of(i as f64, Color32::TRANSPARENT));
        ui.painter().text(
            swatch.left_bottom() + vec2(0.0, 2.0),
            Align2::LEFT_TOP,
            class_name(i as f64),
            FontId::proportional(11.0),
            ui.visuals().text_color(),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn months_have_their_first_days() {
        let months = months(&Time::common_year(8760), 24);
        assert_eq!((months.len(), months[0], months[11]), (12, ("Jan", 0), ("Dec", 334)));
    }

    #[test]
    fn cells_and_places_agree() {
        let layout = Layout { field: Rect::from_min_size(pos2(50.0, 30.0), vec2(730.0, 240.0)), steps: 8760 };
        for step in [0, 23, 24, 1929, 4000, 8759] {
            assert_eq!(layout.step_at(layout.cell(step).center()), Some(step));
        }
        assert_eq!(layout.step_at(pos2(50.5, 269.0)), Some(0), "midnight of 1 January is below on the left");
    }
}

//! Legends: a bar of continuous colours with numbers, or a column of classes.

use super::drawing::{Anchor, Drawing};
use super::font;
use super::palette::{Color, INK, Palette, Scale, short_number};

/// Distance of the numbers from the bar, and length of their ticks, by size of text.
const TICK: f64 = 0.35;

/// A vertical bar of colours with numbers on its right and a title above.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ColorBar {
    /// Colours.
    pub palette: Palette,
    /// Values.
    pub scale: Scale,
    /// Values that are marked and written.
    pub ticks: Vec<f64>,
    /// Quantity and unit, above the bar; may be empty.
    pub title: String,
    /// Number of flat colours instead of a gradient.
    pub steps: Option<usize>,
    /// Size of the text.
    pub text_size: f64,
}

impl ColorBar {
    /// Width and height needed for a bar of the given width and height.
    pub(crate) fn size(&self, bar: [f64; 2]) -> [f64; 2] {
        let numbers = self.ticks.iter().map(|&t| font::width(&short_number(t), self.text_size)).fold(0.0, f64::max);
        let title = font::width(&self.title, self.text_size);
        [(bar[0] + 2.0 * TICK * self.text_size + numbers).max(title), bar[1] + self.above() + self.text_size / 2.0]
    }

    /// Height from the top to the bar.
    pub(crate) fn above(&self) -> f64 {
        // Half a number may stand above the end of the bar.
        if self.title.is_empty() { self.text_size * 0.4 } else { self.text_size * 1.6 }
    }

    /// Draws it with its upper left corner at a place; `bar` is width and height of the colours.
    pub(crate) fn draw(&self, drawing: &mut Drawing, [x, y]: [f64; 2], bar: [f64; 2]) {
        let [width, height] = bar;
        let top = y + self.above();
        if !self.title.is_empty() {
            drawing.label(&*self.title, [x, y + self.text_size * 0.4], self.text_size, INK, Anchor::Start);
        }
        let rows = self.steps.unwrap_or_else(|| (height.ceil() as usize * 2).clamp(2, 1024));
        let colors = (0..rows).rev().map(|i| self.palette.color((i as f64 + 0.5) / rows as f64)).collect();
        drawing.image([x, top, width, height], 1, colors);
        drawing.frame([x, top, width, height], self.text_size / 14.0, INK);
        let mut lines = Vec::new();
        for &tick in &self.ticks {
            let place = top + height * (1.0 - self.scale.position(tick).clamp(0.0, 1.0));
            lines.push(vec![[x + width, place], [x + width + TICK * self.text_size, place]]);
            drawing.label(short_number(tick), [x + width + 2.0 * TICK * self.text_size, place], self.text_size, INK, Anchor::Start);
        }
        drawing.lines(lines, self.text_size / 14.0, INK);
    }
}

/// A column of coloured squares with names.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ClassList {
    /// Names and colours, from the top.
    pub classes: Vec<(String, Color)>,
    /// Above the column; may be empty.
    pub title: String,
    /// Size of the text.
    pub text_size: f64,
}

impl ClassList {
    fn line(&self) -> f64 {
        self.text_size * 1.7
    }

    /// Width and height needed.
    pub(crate) fn size(&self) -> [f64; 2] {
        let names = self.classes.iter().map(|(n, _)| font::width(n, self.text_size)).fold(0.0, f64::max);
        let width = (names + self.text_size * 1.6).max(font::width(&self.title, self.text_size));
        let lines = self.classes.len() + usize::from(!self.title.is_empty());
        [width, lines as f64 * self.line()]
    }

    /// Draws it with its upper left corner at a place.
    pub(crate) fn draw(&self, drawing: &mut Drawing, [x, mut y]: [f64; 2]) {
        let size = self.text_size;
        if !self.title.is_empty() {
            drawing.label(&*self.title, [x, y + self.line() / 2.0], size, INK, Anchor::Start);
            y += self.line();
        }
        for (name, color) in &self.classes {
            let square = [x, y + (self.line() - size) / 2.0, size, size];
            drawing.rectangle(square, *color);
            drawing.frame(square, size / 18.0, INK);
            drawing.label(&**name, [x + size * 1.6, y + self.line() / 2.0], size, INK, Anchor::Start);
            y += self.line();
        }
    }
}

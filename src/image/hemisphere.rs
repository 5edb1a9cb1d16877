//! Hemisphere plots: a quantity over directions as discs side by side, with one legend.
//!
//! θ is the angle to the normal, 0° in the middle and 90° at the rim, in equal steps; φ runs
//! counter-clockwise from the right. For BSDFs, skies and position indices.

use super::drawing::{Anchor, Drawing, Text, arc};
use super::font::{self, TEXT_SIZE};
use super::legend::ColorBar;
use super::palette::{Color, GRID, INK, NO_DATA, Palette, Scale, WHITE};
use crate::error::{Error, Result};

/// Radius of a disc, pixels.
const RADIUS: f64 = 130.0;
/// Samples across a disc that shows a function.
const SAMPLES: usize = 520;

/// A patch of directions with one value; degrees. A patch around the normal has θ from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Smallest and largest angle to the normal.
    pub theta: [f64; 2],
    /// First and last azimuth, counter-clockwise; the last is larger.
    pub phi: [f64; 2],
    /// What is shown; NaN for none.
    pub value: f64,
}

/// What a disc shows.
pub enum Content<'a> {
    /// Patches of a basis.
    Patches(Vec<Patch>),
    /// A value for any θ and φ in degrees; NaN for none.
    Function(&'a dyn Fn(f64, f64) -> f64),
}

/// One disc.
pub struct Hemisphere<'a> {
    /// Below the disc; may be empty.
    pub title: String,
    /// What it shows.
    pub content: Content<'a>,
    /// A direction to mark, θ and φ in degrees: the incident one of a BSDF.
    pub mark: Option<[f64; 2]>,
}

/// Discs in rows, with one legend.
pub struct HemispherePlot<'a> {
    /// The discs.
    pub hemispheres: Vec<Hemisphere<'a>>,
    /// Discs per row.
    pub columns: usize,
    /// Above everything; may be empty.
    pub title: String,
    /// Quantity and unit, above the legend.
    pub label: String,
    /// Colours.
    pub palette: Palette,
    /// Values.
    pub scale: Scale,
}

impl HemispherePlot<'_> {
    /// Draws the plot.
    ///
    /// # Errors
    /// If there is nothing to draw.
    pub fn draw(&self) -> Result<Drawing> {
        if self.hemispheres.is_empty() || self.columns == 0 {
            return Err(Error::new("a plot of hemispheres needs at least one"));
        }
        let columns = self.columns.min(self.hemispheres.len());
        let rows = self.hemispheres.len().div_ceil(columns);
        let rim = TEXT_SIZE * 2.0;
        let cell = [2.0 * (RADIUS + rim) + 12.0, 2.0 * (RADIUS + rim) + TEXT_SIZE * 1.8];
        let top = if self.title.is_empty() { 10.0 } else { 14.0 + TEXT_SIZE * 2.0 };
        let bar = ColorBar {
            palette: self.palette,
            scale: self.scale,
            ticks: self.scale.ticks(8),
            title: self.label.clone(),
            steps: None,
            text_size: TEXT_SIZE,
        };
        let bar_size = [18.0, 2.0 * RADIUS - bar.above()];
        let [legend_width, _] = bar.size(bar_size);
        let left = 12.0;
        let legend_left = left + cell[0] * columns as f64 + 6.0;
        let width = (legend_left + legend_width).max(left + font::width(&self.title, TEXT_SIZE * 1.2)) + 14.0;
        let mut drawing = Drawing::new(width.ceil(), (top + cell[1] * rows as f64 + 6.0).ceil());
        if !self.title.is_empty() {
            drawing.label(&*self.title, [left + 6.0, 10.0 + TEXT_SIZE], TEXT_SIZE * 1.2, INK, Anchor::Start);
        }
        for (i, hemisphere) in self.hemispheres.iter().enumerate() {
            let (column, row) = (i % columns, i / columns);
            let center = [left + cell[0] * (column as f64 + 0.5), top + cell[1] * row as f64 + RADIUS + rim];
            self.disc(&mut drawing, hemisphere, center);
        }
        bar.draw(&mut drawing, [legend_left, top + rim], bar_size);
        Ok(drawing)
    }

    fn color(&self, value: f64) -> Color {
        if value.is_nan() { NO_DATA } else { self.palette.color(self.scale.position(value)) }
    }

    fn disc(&self, drawing: &mut Drawing, hemisphere: &Hemisphere, center: [f64; 2]) {
        let [x, y] = center;
        match &hemisphere.content {
            Content::Patches(patches) => {
                drawing.polygons(patches.iter().map(|p| (outline(p, center), self.color(p.value))).collect());
            }
            Content::Function(function) => {
                let mut pixels = Vec::with_capacity(SAMPLES * SAMPLES);
                for row in 0..SAMPLES {
                    for column in 0..SAMPLES {
                        let [u, v] = [column, row].map(|i| (i as f64 + 0.5) / SAMPLES as f64 * 2.0 - 1.0);
                        let radius = u.hypot(v);
                        // A little beyond the rim, which the line around the disc covers.
                        let inside = radius <= 1.004;
                        let phi = (-v).atan2(u).to_degrees().rem_euclid(360.0);
                        pixels.push(if inside { self.color(function((radius * 90.0).min(90.0), phi)) } else { WHITE });
                    }
                }
                drawing.image([x - RADIUS, y - RADIUS, 2.0 * RADIUS, 2.0 * RADIUS], SAMPLES, pixels);
            }
        }
        let mut grid: Vec<_> = [30.0, 60.0].iter().map(|theta| arc(center, RADIUS * theta / 90.0, 0.0, 360.0)).collect();
        grid.extend((0..4).map(|i| vec![place(90.0, f64::from(i) * 45.0, center), place(90.0, f64::from(i) * 45.0 + 180.0, center)]));
        drawing.lines(grid, 0.4, GRID);
        drawing.circle(center, RADIUS, 1.0, INK);
        for phi in [0.0, 90.0, 180.0, 270.0] {
            let [px, py] = place(90.0, phi, center);
            let (dx, dy) = ((px - x) / RADIUS, (py - y) / RADIUS);
            let anchor = if dx > 0.5 {
                Anchor::Start
            } else if dx < -0.5 {
                Anchor::End
            } else {
                Anchor::Middle
            };
            drawing.label(format!("{phi}°"), [px + dx * 5.0, py + dy * 9.0], TEXT_SIZE * 0.85, INK, anchor);
        }
        for theta in [30.0, 60.0] {
            let [px, py] = place(theta, 67.5, center);
            let size = TEXT_SIZE * 0.8;
            drawing.text(Text {
                text: format!("{theta}°"),
                place: [px, py],
                size,
                color: INK,
                anchor: Anchor::Middle,
                vertical: false,
                centered: true,
                halo: Some(WHITE),
            });
        }
        if let Some([theta, phi]) = hemisphere.mark {
            let at = place(theta, phi, center);
            drawing.circle(at, 5.0, 3.5, WHITE);
            drawing.circle(at, 5.0, 1.5, INK);
        }
        drawing.label(&*hemisphere.title, [x, y + RADIUS + TEXT_SIZE * 2.4], TEXT_SIZE, INK, Anchor::Middle);
    }
}

/// Place of a direction on a disc.
fn place(theta: f64, phi: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let radius = RADIUS * theta / 90.0;
    let phi = phi.to_radians();
    [x + radius * phi.cos(), y - radius * phi.sin()]
}

fn outline(patch: &Patch, center: [f64; 2]) -> Vec<[f64; 2]> {
    // On the screen angles run clockwise.
    let side = |theta: f64, from: f64, to: f64| arc(center, RADIUS * theta / 90.0, -from, -to);
    let [from, to] = patch.phi;
    let mut points = side(patch.theta[1], from, to);
    if patch.theta[0] > 0.0 {
        points.extend(side(patch.theta[0], to, from));
    } else if to - from < 360.0 {
        points.push(center);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(content: Content) -> HemispherePlot {
        HemispherePlot {
            hemispheres: vec![Hemisphere { title: "T front".into(), content, mark: Some([40.0, 180.0]) }],
            columns: 3,
            title: String::new(),
            label: "1/sr".into(),
            palette: Palette::Gray,
            scale: Scale::linear(0.0, 1.0).unwrap(),
        }
    }

    #[test]
    fn patches_and_functions_put_values_at_the_same_places() {
        // Black but for 20° < θ < 40° and 90° < φ < 180°, the upper left.
        let bright = |theta: f64, phi: f64| f64::from(u8::from((20.0..40.0).contains(&theta) && (90.0..180.0).contains(&phi)));
        let mut patches = vec![Patch { theta: [0.0, 20.0], phi: [0.0, 360.0], value: 0.0 }];
        for (low, high) in [(20.0, 40.0), (40.0, 90.0)] {
            patches.extend((0..4).map(|i| {
                let phi = [f64::from(i) * 90.0, f64::from(i + 1) * 90.0];
                Patch { theta: [low, high], phi, value: bright(low + 1.0, phi[0] + 1.0) }
            }));
        }
        let drawings = [plot(Content::Patches(patches)), plot(Content::Function(&bright))].map(|p| p.draw().unwrap().canvas(1.0).unwrap());
        let center = [12.0 + RADIUS + TEXT_SIZE * 2.0 + 6.0, 10.0 + RADIUS + TEXT_SIZE * 2.0];
        let mut checked = 0;
        for theta in [7.0, 25.0, 36.0, 50.0, 80.0] {
            for phi in (0..360).step_by(20).map(|p| f64::from(p) + 11.0) {
                let [x, y] = place(theta, phi, center);
                for canvas in &drawings {
                    let color = canvas.get(x as usize, y as usize);
                    // Grid, numbers and the mark are in between.
                    if color != [0; 3] && color != [255; 3] {
                        continue;
                    }
                    checked += 1;
                    assert_eq!(color == [255; 3], bright(theta, phi) > 0.5, "θ {theta}, φ {phi}");
                }
            }
        }
        assert!(checked > 120, "{checked}");
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let mut empty = plot(Content::Patches(Vec::new()));
        empty.draw().unwrap();
        empty.hemispheres.clear();
        assert!(empty.draw().is_err());
    }
}

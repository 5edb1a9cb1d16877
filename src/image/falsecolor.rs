//! Falsecolour: luminance as colours with a legend, as Radiance's `falsecolor`.

use super::Picture;
use super::drawing::{Anchor, Drawing, Text};
use super::font;
use super::legend::ColorBar;
use super::palette::{Color, INK, Palette, Scale, WHITE, round_up, rounded_number};
use crate::error::{Error, Result};
use crate::units::BRIGHTNESS_WEIGHTS;
use std::borrow::Cow;

/// Share of the bright pixels that an automatic scale leaves above its end: a few pixels of sun
/// should not darken all others.
const AUTOMATIC_EXCESS: f64 = 0.005;
/// Small pictures are enlarged to at least this many pixels.
const SMALLEST_SIDE: usize = 300;

/// Marks of equal luminance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Contours {
    /// None: a continuous picture.
    None,
    /// `-cl`: lines at the middle of each step.
    Lines,
    /// `-cb`: bands around the middle of each step.
    Bands,
    /// `-cp`: each step in one colour.
    Posterize,
}

/// How to colour a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct FalseColor {
    /// Colours.
    pub palette: Palette,
    /// Upper end of the scale (`-s`); `None` chooses a round one from the picture.
    pub maximum: Option<f64>,
    /// Decades of a logarithmic scale (`-log`).
    pub decades: Option<f64>,
    /// Factor from radiance to the numbers of the legend (`-m`): 179 for cd/m² or lx.
    pub multiplier: f64,
    /// Quantity or unit above the legend (`-l`).
    pub label: String,
    /// Number of steps (`-n`), for contours and the numbers of the legend; `None` writes round
    /// numbers, and makes eight steps of contours.
    pub steps: Option<usize>,
    /// Contours.
    pub contours: Contours,
    /// Whether to draw the legend.
    pub legend: bool,
    /// Whether to mark the darkest and the brightest pixel (`-e`).
    pub extrema: bool,
    /// Pixels of the result per pixel of the picture; `None` enlarges small pictures.
    pub zoom: Option<usize>,
}

impl Default for FalseColor {
    fn default() -> Self {
        Self {
            palette: Palette::Viridis,
            maximum: None,
            decades: None,
            multiplier: crate::units::LUMINOUS_EFFICACY,
            label: "cd/m²".into(),
            steps: None,
            contours: Contours::None,
            legend: true,
            extrema: false,
            zoom: None,
        }
    }
}

impl FalseColor {
    /// The numbers that are coloured: brightness × multiplier, per pixel.
    pub fn values(&self, picture: &Picture) -> Vec<f64> {
        let weigh = |p: &[f32; 3]| p.iter().zip(BRIGHTNESS_WEIGHTS).map(|(&c, w)| f64::from(c) * w).sum::<f64>() * self.multiplier;
        picture.pixels.iter().map(weigh).collect()
    }

    /// The scale for these numbers.
    ///
    /// # Errors
    /// If maximum or decades are impossible.
    pub fn scale(&self, values: &[f64]) -> Result<Scale> {
        let maximum = self.maximum.unwrap_or_else(|| automatic_maximum(values));
        match self.decades {
            Some(decades) => Scale::logarithmic(maximum, decades),
            None => Scale::linear(0.0, maximum).map_err(|e| e.help("the scale must be a positive number or 'auto'")),
        }
    }

    /// Colours of all pixels, without legend. Pixels between contours show `background`.
    ///
    /// # Errors
    /// If an option is impossible or the background has another size.
    pub fn colors(&self, picture: &Picture, background: &Picture) -> Result<Vec<Color>> {
        let values = self.values(picture);
        self.color_values(&values, &self.scale(&values)?, picture, background)
    }

    fn color_values(&self, values: &[f64], scale: &Scale, picture: &Picture, background: &Picture) -> Result<Vec<Color>> {
        let (width, height) = (picture.width, picture.height);
        let steps = self.contour_steps()?;
        let positions: Vec<f64> = values.iter().map(|&v| scale.position(v)).collect();
        if matches!(self.contours, Contours::None) {
            return Ok(positions.iter().map(|&p| self.palette.color(p)).collect());
        }
        if self.contours == Contours::Posterize {
            let middle = |p: f64| ((p.clamp(0.0, 1.0) * steps).floor().min(steps - 1.0) + 0.5) / steps;
            return Ok(positions.iter().map(|&p| self.palette.color(middle(p))).collect());
        }
        if (background.width, background.height) != (width, height) {
            return Err(Error::new(format!(
                "the background has {} × {} pixels, the picture {width} × {height}",
                background.width, background.height
            )));
        }
        let mut colors = tone_map(background);
        // Which of the lines a value is above; the casts clamp.
        let level = |x: usize, y: usize| (positions[y * width + x] * steps + 0.5).floor() as i64;
        for y in 0..height {
            for x in 0..width {
                let position = positions[y * width + x];
                let inside = (0.0..=1.0).contains(&position);
                let marked = match self.contours {
                    // Neighbours on both sides, so that lines are two pixels wide.
                    Contours::Lines => {
                        level(x.saturating_sub(1), y) != level((x + 1).min(width - 1), y)
                            || level(x, y.saturating_sub(1)) != level(x, (y + 1).min(height - 1))
                    }
                    _ => (0.4..=0.6).contains(&(position * steps).rem_euclid(1.0)),
                };
                if inside && marked {
                    colors[y * width + x] = self.palette.color(position);
                }
            }
        }
        Ok(colors)
    }

    fn contour_steps(&self) -> Result<f64> {
        match self.steps {
            Some(n) if !(1..=100).contains(&n) => Err(Error::new(format!("{n} steps are not possible")).field("-n").help("give 1 to 100")),
            n => Ok(n.unwrap_or(8) as f64),
        }
    }

    fn ticks(&self, scale: &Scale) -> Result<Vec<f64>> {
        let steps = self.contour_steps()?;
        let at = |offset: f64, count: usize| (0..count).map(|i| scale.value((i as f64 + offset) / steps)).collect();
        Ok(match self.contours {
            // The value of each line, as falsecolor writes it.
            Contours::Lines | Contours::Bands => at(0.5, steps as usize),
            Contours::Posterize => at(0.0, steps as usize + 1),
            Contours::None if self.steps.is_some() => at(0.0, steps as usize + 1),
            Contours::None => scale.ticks(8),
        })
    }

    /// The coloured picture with its legend. Contours are drawn over `background`, or over the
    /// picture itself.
    ///
    /// # Errors
    /// If an option is impossible, or the background has another size.
    pub fn draw(&self, picture: &Picture, background: Option<&Picture>) -> Result<Drawing> {
        if !self.multiplier.is_finite() || self.multiplier <= 0.0 {
            return Err(Error::new(format!("{} is no multiplier", self.multiplier)).field("-m").help("179 gives cd/m² or lx"));
        }
        if self.zoom == Some(0) {
            return Err(Error::new("a zoom of 0 leaves nothing").field("--zoom"));
        }
        let values = self.values(picture);
        let scale = self.scale(&values)?;
        let colors = self.color_values(&values, &scale, picture, background.unwrap_or(picture))?;
        let smaller = picture.width.min(picture.height);
        let zoom = self.zoom.unwrap_or_else(|| SMALLEST_SIDE.div_ceil(smaller.max(1))).min(64) as f64;
        let (width, height) = (picture.width as f64 * zoom, picture.height as f64 * zoom);
        // Lettering grows with the picture, so that it stays legible when shown smaller.
        let unit = (width.max(height) / 600.0).max(1.0);
        let text_size = 13.0 * unit;
        if !self.legend {
            let mut drawing = Drawing::new(width, height);
            drawing.image([0.0, 0.0, width, height], picture.width, colors);
            self.mark_extrema(&mut drawing, &values, picture.width, zoom, [0.0, 0.0], text_size);
            return Ok(drawing);
        }
        let margin = (12.0 * unit).round();
        let bar = ColorBar {
            palette: self.palette,
            scale,
            ticks: self.ticks(&scale)?,
            title: self.label.clone(),
            steps: (self.contours == Contours::Posterize).then_some(self.steps.unwrap_or(8)),
            text_size,
        };
        let bar_size = [18.0 * unit, (height - bar.above() - text_size / 2.0).max(60.0)];
        let [legend_width, legend_height] = bar.size(bar_size);
        let total = [width + legend_width + 3.5 * margin, height.max(legend_height) + 2.0 * margin].map(f64::round);
        let mut drawing = Drawing::new(total[0], total[1]);
        drawing.image([margin, margin, width, height], picture.width, colors);
        bar.draw(&mut drawing, [width + 2.5 * margin, margin], bar_size);
        self.mark_extrema(&mut drawing, &values, picture.width, zoom, [margin; 2], text_size);
        Ok(drawing)
    }

    fn mark_extrema(&self, drawing: &mut Drawing, values: &[f64], columns: usize, zoom: f64, [left, top]: [f64; 2], size: f64) {
        if !self.extrema {
            return;
        }
        // Black is outside a fisheye rather than the darkest place.
        let lit = || values.iter().copied().enumerate().filter(|(_, v)| *v > 0.0);
        let ends = [lit().min_by(|a, b| a.1.total_cmp(&b.1)), lit().max_by(|a, b| a.1.total_cmp(&b.1))];
        let right = left + columns as f64 * zoom;
        for (i, value) in ends.into_iter().flatten() {
            let center = [left + ((i % columns) as f64 + 0.5) * zoom, top + ((i / columns) as f64 + 0.5) * zoom];
            drawing.circle(center, size * 0.35, size / 4.0, WHITE);
            drawing.circle(center, size * 0.35, size / 10.0, INK);
            let text = rounded_number(value);
            let space = font::width(&text, size) + size;
            let (anchor, offset) = if center[0] + space < right { (Anchor::Start, size * 0.75) } else { (Anchor::End, -size * 0.75) };
            drawing.text(Text {
                text,
                place: [center[0] + offset, center[1]],
                size,
                color: INK,
                anchor,
                vertical: false,
                centered: true,
                halo: Some(WHITE),
            });
        }
    }
}

/// A round number that only a few pixels exceed.
fn automatic_maximum(values: &[f64]) -> f64 {
    let mut lit: Vec<f64> = values.iter().copied().filter(|v| *v > 0.0 && v.is_finite()).collect();
    if lit.is_empty() {
        return 1.0;
    }
    let index = ((lit.len() - 1) as f64 * (1.0 - AUTOMATIC_EXCESS)) as usize;
    let (_, value, _) = lit.select_nth_unstable_by(index, f64::total_cmp);
    round_up(*value)
}

/// An ordinary photograph of a picture: the brightest twentieth is white, gamma 2.2.
pub fn tone_map(picture: &Picture) -> Vec<Color> {
    let mut lit: Cow<[f32]> = picture.pixels.iter().map(|p| p[0].max(p[1]).max(p[2])).filter(|v| *v > 0.0).collect();
    let white = if lit.is_empty() {
        1.0
    } else {
        let index = (lit.len() - 1) * 19 / 20;
        *lit.to_mut().select_nth_unstable_by(index, f32::total_cmp).1
    };
    let table: Vec<u8> = (0..=4096).map(|i| ((f64::from(i) / 4096.0).powf(1.0 / 2.2) * 255.0).round() as u8).collect();
    let tone = |v: f32| table[((v / white).clamp(0.0, 1.0) * 4096.0) as usize];
    picture.pixels.iter().map(|p| p.map(tone)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Luminance from 0 to 1000 cd/m² from left to right.
    fn ramp(width: usize, height: usize) -> Picture {
        let pixels = (0..width * height).map(|i| [((i % width) as f64 / (width - 1) as f64 * 1000.0 / 179.0) as f32; 3]).collect();
        Picture::new(width, height, pixels).unwrap()
    }

    fn options() -> FalseColor {
        FalseColor { maximum: Some(1000.0), ..FalseColor::default() }
    }

    #[test]
    fn positions_follow_the_scale() {
        let picture = ramp(101, 3);
        let colors = options().colors(&picture, &picture).unwrap();
        let near = |a: Color, b: Color| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 1);
        for x in [0, 20, 50, 99] {
            assert!(near(colors[x], Palette::Viridis.color(x as f64 / 100.0)), "{x}");
        }
        let log = FalseColor { decades: Some(2.0), ..options() }.colors(&picture, &picture).unwrap();
        assert_eq!(log[0], Palette::Viridis.color(0.0));
        // 100 cd/m² is one of two decades below the end.
        assert!(near(log[10], Palette::Viridis.color(0.5)));
        let double = FalseColor { multiplier: 358.0, ..options() }.colors(&picture, &picture).unwrap();
        assert!(near(double[50], Palette::Viridis.color(1.0)));
    }

    #[test]
    fn contours_lie_where_falsecolor_puts_them() {
        let picture = ramp(801, 2);
        let lines = FalseColor { contours: Contours::Lines, steps: Some(4), ..options() }.colors(&picture, &picture).unwrap();
        let plain = tone_map(&picture);
        let marked: Vec<usize> = (0..801).filter(|&x| lines[x] != plain[x]).collect();
        // Lines at 125, 375, 625 and 875 cd/m², i.e. between pixels 99, 100 and so on.
        assert_eq!(marked.iter().filter(|x| (95..=105).contains(*x)).count(), 2);
        assert_eq!(marked.len(), 8, "{marked:?}");
        let bands = FalseColor { contours: Contours::Bands, steps: Some(4), ..options() }.colors(&picture, &picture).unwrap();
        let marked = (0..801).filter(|&x| bands[x] != plain[x]).count();
        assert!((156..=166).contains(&marked), "a fifth of all: {marked}");
        let flat = FalseColor { contours: Contours::Posterize, steps: Some(4), ..options() }.colors(&picture, &picture).unwrap();
        let mut distinct: Vec<_> = flat[..801].to_vec();
        distinct.dedup();
        assert_eq!(distinct, [0.125, 0.375, 0.625, 0.875].map(|p| Palette::Viridis.color(p)));
    }

    #[test]
    fn automatic_scales_are_round_and_ignore_a_few_pixels_of_sun() {
        let mut picture = ramp(100, 100);
        let values = options().values(&picture);
        assert_eq!(automatic_maximum(&values), 1000.0);
        picture.pixels[17] = [1e7; 3];
        assert_eq!(automatic_maximum(&options().values(&picture)), 1000.0);
        assert_eq!(automatic_maximum(&[0.0; 5]), 1.0);
        let black = Picture::new(3, 3, vec![[0.0; 3]; 9]).unwrap();
        FalseColor::default().draw(&black, None).unwrap();
    }

    #[test]
    fn the_legend_stands_beside_the_picture() {
        let picture = ramp(400, 300);
        let drawing = options().draw(&picture, None).unwrap();
        let canvas = drawing.canvas(1.0).unwrap();
        assert!(canvas.width() > 440 && canvas.width() < 560 && canvas.height() == 324, "{} {}", canvas.width(), canvas.height());
        assert_eq!(canvas.get(12, 12), Palette::Viridis.color(0.0));
        assert_eq!(canvas.get(0, 0), WHITE);
        let bare = FalseColor { legend: false, ..options() }.draw(&picture, None).unwrap().canvas(1.0).unwrap();
        assert_eq!((bare.width(), bare.height()), (400, 300));
        let small = FalseColor { legend: false, ..options() }.draw(&ramp(10, 10), None).unwrap().canvas(1.0).unwrap();
        assert_eq!(small.width(), 300);
    }

    #[test]
    fn impossible_options_are_refused() {
        let picture = ramp(20, 20);
        let fails = |o: FalseColor| assert!(o.draw(&picture, Some(&ramp(21, 20))).is_err(), "{o:?}");
        fails(FalseColor { maximum: Some(-1.0), ..options() });
        fails(FalseColor { maximum: Some(f64::NAN), ..options() });
        fails(FalseColor { decades: Some(0.0), ..options() });
        fails(FalseColor { multiplier: 0.0, ..options() });
        fails(FalseColor { steps: Some(0), ..options() });
        fails(FalseColor { zoom: Some(0), ..options() });
        fails(FalseColor { contours: Contours::Lines, ..options() });
    }
}

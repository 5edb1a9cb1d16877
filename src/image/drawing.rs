//! A drawing of shapes, text and images that becomes PNG or SVG.
//!
//! Plots are made once as a [`Drawing`] and written in both formats by [`Drawing::write`].
//! Coordinates are pixels of the SVG, from the upper left corner, y downwards; PNG may be finer by
//! a factor.

use super::canvas::Canvas;
use super::font;
use super::palette::{Color, WHITE};
use crate::error::{Error, Result};
use crate::files;
use std::path::Path;

/// Which end of a text is at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The text is centred there.
    Middle,
    /// The text ends there.
    End,
}

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// What it says.
    pub text: String,
    /// Place of its anchor: on the base line, or on half the height of capitals if `centered`.
    pub place: [f64; 2],
    /// Size of the face; capitals are 0.69 of it.
    pub size: f64,
    /// Colour.
    pub color: Color,
    /// Which end is at `place`.
    pub anchor: Anchor,
    /// Runs upwards instead of to the right.
    pub vertical: bool,
    /// Whether `place` is at half the height of capitals.
    pub centered: bool,
    /// A rim around the letters, for text on pictures.
    pub halo: Option<Color>,
}

#[derive(Debug, Clone, PartialEq)]
enum Item {
    Polygons(Vec<(Vec<[f64; 2]>, Color)>),
    Lines { lines: Vec<Vec<[f64; 2]>>, width: f64, color: Color },
    Text(Text),
    Image { rectangle: [f64; 4], columns: usize, pixels: Vec<Color> },
}

/// Shapes in the order in which they are drawn, on white.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    width: f64,
    height: f64,
    items: Vec<Item>,
}

impl Drawing {
    /// An empty drawing.
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, items: Vec::new() }
    }

    /// Width in pixels.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Fills a rectangle given by its upper left corner, width and height.
    pub fn rectangle(&mut self, [x, y, w, h]: [f64; 4], color: Color) {
        self.polygons(vec![(vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]], color)]);
    }

    /// Outlines a rectangle.
    pub fn frame(&mut self, [x, y, w, h]: [f64; 4], width: f64, color: Color) {
        self.lines(vec![vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h], [x, y]]], width, color);
    }

    /// Fills polygons; those of one call join without seams.
    pub fn polygons(&mut self, polygons: Vec<(Vec<[f64; 2]>, Color)>) {
        self.items.push(Item::Polygons(polygons));
    }

    /// Draws open lines.
    pub fn lines(&mut self, lines: Vec<Vec<[f64; 2]>>, width: f64, color: Color) {
        self.items.push(Item::Lines { lines, width, color });
    }

    /// Draws one straight line.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], width: f64, color: Color) {
        self.lines(vec![vec![from, to]], width, color);
    }

    /// Draws a circle.
    pub fn circle(&mut self, center: [f64; 2], radius: f64, width: f64, color: Color) {
        self.lines(vec![arc(center, radius, 0.0, 360.0)], width, color);
    }

    /// Writes horizontal text, its place at half the height of capitals.
    pub fn label(&mut self, text: impl Into<String>, place: [f64; 2], size: f64, color: Color, anchor: Anchor) {
        self.text(Text { text: text.into(), place, size, color, anchor, vertical: false, centered: true, halo: None });
    }

    /// Writes text that runs upwards, its middle at `place`: the name of an axis.
    pub(crate) fn upward_label(&mut self, text: impl Into<String>, place: [f64; 2], size: f64, color: Color) {
        self.text(Text { text: text.into(), place, size, color, anchor: Anchor::Middle, vertical: true, centered: true, halo: None });
    }

    /// Writes text.
    pub fn text(&mut self, text: Text) {
        self.items.push(Item::Text(text));
    }

    /// Places an image of `columns` pixels per row into a rectangle (x, y, width, height).
    pub fn image(&mut self, rectangle: [f64; 4], columns: usize, pixels: Vec<Color>) {
        self.items.push(Item::Image { rectangle, columns, pixels });
    }

    /// Draws everything on a canvas `scale` times as large.
    ///
    /// # Errors
    /// If it would be too large.
    pub(crate) fn canvas(&self, scale: f64) -> Result<Canvas> {
        let mut canvas = Canvas::new((self.width * scale).round() as usize, (self.height * scale).round() as usize)?;
        let scaled = |points: &[[f64; 2]]| points.iter().map(|p| p.map(|v| v * scale)).collect::<Vec<_>>();
        for item in &self.items {
            match item {
                Item::Polygons(polygons) => {
                    let polygons: Vec<_> = polygons.iter().map(|(p, c)| (vec![scaled(p)], *c)).collect();
                    canvas.fill(&polygons);
                }
                Item::Lines { lines, width, color } => {
                    let lines: Vec<_> = lines.iter().map(|l| scaled(l)).collect();
                    canvas.stroke(&lines, width * scale, *color);
                }
                Item::Text(text) => {
                    let [x, y] = text.start(font::width(&text.text, text.size));
                    canvas.text([x * scale, y * scale], &text.text, text.size * scale, text.color, text.vertical, text.halo);
                }
                Item::Image { rectangle, columns, pixels } => canvas.image(rectangle.map(|v| v * scale), *columns, pixels),
            }
        }
        Ok(canvas)
    }

    /// The drawing as SVG; images are embedded as PNG.
    ///
    /// # Errors
    /// If an image cannot be encoded.
    pub fn svg(&self) -> Result<String> {
        let (w, h) = (number(self.width), number(self.height));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"Helvetica, Arial, sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"{}\"/>\n",
            hex(WHITE)
        );
        for item in &self.items {
            match item {
                // A thin rim of the same colour hides the seams that viewers leave between shapes.
                Item::Polygons(polygons) => {
                    let rim = if polygons.len() > 1 { " stroke-width=\"0.5\"" } else { "" };
                    svg.push_str(&format!("<g{rim}>\n"));
                    for (points, color) in polygons {
                        let stroke = if polygons.len() > 1 { format!(" stroke=\"{}\"", hex(*color)) } else { String::new() };
                        svg.push_str(&format!("<path d=\"{}Z\" fill=\"{}\"{stroke}/>\n", path(points), hex(*color)));
                    }
                    svg.push_str("</g>\n");
                }
                Item::Lines { lines, width, color } => {
                    let d: String = lines.iter().map(|l| path(l)).collect();
                    svg.push_str(&format!(
                        "<path d=\"{d}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\" stroke-linejoin=\"round\"/>\n",
                        hex(*color),
                        number(*width)
                    ));
                }
                Item::Text(text) => svg.push_str(&text.svg()),
                Item::Image { rectangle: [x, y, width, height], columns, pixels } => {
                    let rows = pixels.len() / (*columns).max(1);
                    // Viewers that blur enlarged images find little left to enlarge.
                    let repeat =
                        |length: f64, count: usize| if length > count as f64 { (2.0 * length / count as f64).ceil() as usize } else { 1 };
                    let mut canvas = Canvas::new(columns * repeat(*width, *columns), rows * repeat(*height, rows))?;
                    canvas.image([0.0, 0.0, canvas.width() as f64, canvas.height() as f64], *columns, pixels);
                    svg.push_str(&format!(
                        "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
                         href=\"data:image/png;base64,{}\"/>\n",
                        number(*x),
                        number(*y),
                        number(*width),
                        number(*height),
                        base64::encode(canvas.png()?)
                    ));
                }
            }
        }
        svg.push_str("</svg>\n");
        Ok(svg)
    }

    /// Writes `.png` (enlarged by `scale`) or `.svg`, by the ending of the name.
    ///
    /// # Errors
    /// Other endings, and failures of the file system.
    pub fn write(&self, path: &Path, scale: f64) -> Result<()> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => self.canvas(scale)?.write_png(path),
            Some("svg") => {
                let svg = self.svg()?;
                files::write_atomically(path, |out| out.write_all(svg.as_bytes()).map_err(|e| Error::io(path, &e)))
            }
            _ => Err(Error::new("the name of a plot ends in .png or .svg").file(path)),
        }
    }
}

impl Text {
    /// Where the base line begins, for a text of the given width.
    fn start(&self, width: f64) -> [f64; 2] {
        let back = match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => width / 2.0,
            Anchor::End => width,
        };
        let down = if self.centered { font::cap_height(self.size) / 2.0 } else { 0.0 };
        let [x, y] = self.place;
        if self.vertical { [x + down, y + back] } else { [x - back, y + down] }
    }

    fn svg(&self) -> String {
        let [x, y] = self.start(0.0);
        let anchor = match self.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let turn = if self.vertical { format!(" transform=\"rotate(-90 {} {})\"", number(x), number(y)) } else { String::new() };
        let letters = self.text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let line = |paint: &str| {
            format!(
                "<text x=\"{}\" y=\"{}\" font-size=\"{}\" {paint} text-anchor=\"{anchor}\"{turn}>{letters}</text>\n",
                number(x),
                number(y),
                number(self.size)
            )
        };
        // The rim is a text of its own below: not all viewers paint outlines first.
        let halo = self.halo.map_or(String::new(), |c| {
            let rim = number((self.size / 5.0).max(2.0));
            line(&format!("fill=\"{0}\" stroke=\"{0}\" stroke-width=\"{rim}\" stroke-linejoin=\"round\"", hex(c)))
        });
        halo + &line(&format!("fill=\"{}\"", hex(self.color)))
    }
}

/// Points of an arc; degrees from the right, clockwise on the screen.
pub(crate) fn arc([x, y]: [f64; 2], radius: f64, from: f64, to: f64) -> Vec<[f64; 2]> {
    let steps = ((to - from).abs() / 3.0).ceil().max(1.0) as usize;
    (0..=steps)
        .map(|i| {
            let angle = (from + (to - from) * i as f64 / steps as f64).to_radians();
            [x + radius * angle.cos(), y + radius * angle.sin()]
        })
        .collect()
}

fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Hundredths of a pixel suffice.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn path(points: &[[f64; 2]]) -> String {
    let mut d = String::new();
    for (i, [x, y]) in points.iter().enumerate() {
        let letter = if i == 0 { 'M' } else { 'L' };
        d.push_str(&format!("{letter}{} {}", number(*x), number(*y)));
    }
    d
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::palette::INK;

    #[test]
    fn writes_png_and_well_formed_svg() {
        let folder = tempfile::tempdir().unwrap();
        let mut drawing = Drawing::new(120.0, 80.0);
        drawing.rectangle([10.0, 10.0, 30.0, 20.0], [200, 0, 0]);
        drawing.frame([10.0, 10.0, 30.0, 20.0], 1.0, INK);
        drawing.circle([80.0, 40.0], 20.0, 2.0, INK);
        drawing.label("a < b & \"c\" cd/m²", [60.0, 70.0], 12.0, INK, Anchor::Middle);
        drawing.image([50.0, 5.0, 20.0, 10.0], 2, vec![[0; 3], [255; 3]]);
        let png = folder.path().join("a.png");
        drawing.write(&png, 2.0).unwrap();
        assert_eq!(drawing.canvas(2.0).unwrap().get(50, 40), [200, 0, 0]);
        let svg = folder.path().join("a.SVG");
        drawing.write(&svg, 1.0).unwrap();
        let text = std::fs::read_to_string(&svg).unwrap();
        let mut reader = quick_xml::Reader::from_str(&text);
        let mut elements = 0;
        loop {
            match reader.read_event().unwrap() {
                quick_xml::events::Event::Eof => break,
                quick_xml::events::Event::Empty(_) | quick_xml::events::Event::Start(_) => elements += 1,
                _ => {}
            }
        }
        assert!(elements >= 8, "{elements}");
        assert!(drawing.write(&folder.path().join("a.gif"), 1.0).is_err());
    }
}

//! Lettering for pictures: widths and outlines of the fonts that the viewer shows, too.

use epaint_default_fonts::{HACK_REGULAR, UBUNTU_LIGHT};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{OutlineGlyph, OutlinePen};
use skrifa::{FontRef, MetadataProvider};
use std::sync::OnceLock;

/// Size of the text of charts, pixels.
pub(super) const TEXT_SIZE: f64 = 13.0;
/// Line pieces that stand for one curve of an outline.
const CURVE_STEPS: u32 = 6;

/// Width of a line around the letters, by size of text, that makes of the light face a regular one.
pub(crate) const RIM: f64 = 0.03;

/// A closed line.
pub type Contour = Vec<[f64; 2]>;

/// Ubuntu Light, and Hack for what it lacks: arrows, the raised minus.
fn fonts() -> &'static [FontRef<'static>; 2] {
    static FONTS: OnceLock<[FontRef<'static>; 2]> = OnceLock::new();
    FONTS.get_or_init(|| [UBUNTU_LIGHT, HACK_REGULAR].map(|bytes| FontRef::new(bytes).expect("the fonts are part of the program")))
}

/// A character's outline and advance in a text of size 1, and the font's units per size. Without a glyph in
/// any font it is the first one's box.
struct Glyph {
    outline: Option<OutlineGlyph<'static>>,
    advance: f64,
    units: f64,
}

impl Glyph {
    fn of(character: char) -> Self {
        let found = fonts().iter().find_map(|font| Some((font, font.charmap().map(character)?)));
        let (font, id) = found.unwrap_or((&fonts()[0], Default::default()));
        let units = f64::from(font.metrics(Size::unscaled(), LocationRef::default()).units_per_em);
        let advance = font.glyph_metrics(Size::unscaled(), LocationRef::default()).advance_width(id).unwrap_or(0.0);
        Self { outline: font.outline_glyphs().get(id), advance: f64::from(advance) / units, units }
    }
}

/// Width of a line of text, in the units of `size`.
pub fn width(text: &str, size: f64) -> f64 {
    text.chars().map(|c| Glyph::of(c).advance).sum::<f64>() * size
}

/// Height of capitals, in the units of `size`.
pub(crate) fn cap_height(size: f64) -> f64 {
    let metrics = fonts()[0].metrics(Size::unscaled(), LocationRef::default());
    size * f64::from(metrics.cap_height.unwrap_or(0.0)) / f64::from(metrics.units_per_em)
}

/// Outlines of a line of text that begins at the origin on the base line; x to the right, y **down**. Inside
/// is what they wind around.
pub fn outlines(text: &str, size: f64) -> Vec<Contour> {
    let mut pen = Pen { contours: Vec::new(), left: 0.0, scale: size };
    for glyph in text.chars().map(Glyph::of) {
        pen.scale = size / glyph.units;
        if let Some(outline) = glyph.outline {
            // Outlines of fonts that are part of the program are sound.
            let _ = outline.draw(Size::unscaled(), &mut pen);
        }
        pen.left += glyph.advance * size;
    }
    pen.contours
}

/// Draws outlines as lines.
struct Pen {
    contours: Vec<Contour>,
    left: f64,
    scale: f64,
}

impl Pen {
    fn place(&self, x: f32, y: f32) -> [f64; 2] {
        [self.left + f64::from(x) * self.scale, -f64::from(y) * self.scale]
    }

    /// A Bézier curve from the last point, by de Casteljau's way.
    fn curve<const N: usize>(&mut self, controls: [[f64; 2]; N]) {
        let Some(contour) = self.contours.last_mut() else { return };
        let Some(&start) = contour.last() else { return };
        for step in 1..=CURVE_STEPS {
            let t = f64::from(step) / f64::from(CURVE_STEPS);
            let mut points = vec![start];
            points.extend(controls);
            while points.len() > 1 {
                points = points.windows(2).map(|p| [0, 1].map(|i| p[0][i] + (p[1][i] - p[0][i]) * t)).collect();
            }
            contour.extend(points);
        }
    }
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.contours.push(vec![self.place(x, y)]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.curve([self.place(x, y)]);
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        self.curve([self.place(cx, cy), self.place(x, y)]);
    }

    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        self.curve([self.place(ax, ay), self.place(bx, by), self.place(x, y)]);
    }

    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What labels, titles and names of files may hold.
    const SIGNS: &str = "°²³¹⁻±·→←×−–≤≥φθτρΩµäöüßéèêÄÖÜ";

    #[test]
    fn every_character_of_a_label_is_in_a_font_and_stays_within_its_line() {
        let box_of = |c: char| outlines(&c.to_string(), 10.0);
        for c in ('!'..='~').chain(SIGNS.chars()) {
            let (contours, width) = (box_of(c), width(&c.to_string(), 10.0));
            assert!(!contours.is_empty() && contours != box_of('日'), "no glyph for {c:?}");
            for [x, y] in contours.into_iter().flatten() {
                assert!((-1.0..=width + 1.0).contains(&x) && (-10.0..=3.0).contains(&y), "{c:?}: {x} {y}");
            }
        }
        assert!(box_of(' ').is_empty() && !box_of('日').is_empty(), "unknown characters are boxes");
    }

    #[test]
    fn widths_and_heights_are_those_of_the_font() {
        // Ubuntu Light has 1000 units per size, digits of 564, capitals of 693.
        assert_eq!(width("", 10.0), 0.0);
        assert!((width("00", 10.0) - 2.0 * 5.64).abs() < 1e-9 && (cap_height(10.0) - 6.93).abs() < 1e-9);
        assert!((width("→", 10.0) - 10.0 * 1233.0 / 2048.0).abs() < 1e-9, "from Hack");
        let top = outlines("H", 10.0).into_iter().flatten().map(|[_, y]| -y).fold(0.0, f64::max);
        assert!((top - 6.93).abs() < 1e-6, "{top}");
        let twice = outlines("HH", 10.0);
        let shift = twice[twice.len() / 2][0][0] - twice[0][0][0];
        assert!((shift - width("H", 10.0)).abs() < 1e-9, "the second letter stands behind the first");
    }
}

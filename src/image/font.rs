//! Lettering for pictures: a small stroke font of its own, drawn at any size.
//!
//! Capitals are 7 units high, small letters 5, descenders reach −2. A glyph is its width and its
//! strokes, separated by `;`. A stroke is points `x,y` and arcs `@cx,cy,rx,ry,from,to` (degrees,
//! counter-clockwise from the right if `to` is larger).

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Size of the text of charts, pixels.
pub(super) const TEXT_SIZE: f64 = 13.0;
/// Height of capitals in font units.
const CAP_HEIGHT: f64 = 7.0;
/// Height of capitals by size of text, as in common sans-serif faces.
const CAP_BY_SIZE: f64 = 0.72;
/// Space after each glyph, units.
const SPACING: f64 = 1.7;
/// Thickness of strokes by height of capitals.
const WEIGHT: f64 = 0.125;

#[rustfmt::skip]
const GLYPHS: &[(char, f64, &str)] = &[
    (' ', 1.2, ""),
    ('0', 4.4, "@2.2,3.5,2.2,3.5,0,360"),
    ('1', 4.4, "0.9,5.5 2.6,7 2.6,0"),
    ('2', 4.4, "@2.15,4.95,2.05,2.05,165,-32 0.1,0 4.4,0"),
    ('3', 4.4, "@2.1,5.3,1.8,1.7,155,-90 @2.1,1.8,2.25,1.8,90,-155"),
    ('4', 4.4, "3.4,0 3.4,7 -0.1,2.1 4.6,2.1"),
    ('5', 4.4, "4,7 0.85,7 0.55,3.75 @2.2,2.25,2.15,2.25,138,-150"),
    ('6', 4.4, "@2.2,2.2,2.2,2.2,0,360;@4.4,2.2,4.4,4.8,180,100"),
    ('7', 4.4, "0.1,7 4.4,7 1.6,0"),
    ('8', 4.4, "@2.2,5.3,1.85,1.7,0,360;@2.2,1.8,2.2,1.8,0,360"),
    ('9', 4.4, "@2.2,4.8,2.2,2.2,0,360;@0,4.8,4.4,4.8,0,-80"),
    ('A', 5.2, "0,0 2.6,7 5.2,0;0.9,2.4 4.3,2.4"),
    ('B', 4.6, "0,0 0,7 2.3,7 @2.3,5.35,1.75,1.65,90,-90 0,3.7;2.3,3.7 @2.5,1.85,2.05,1.85,90,-90 0,0"),
    ('C', 5.0, "@2.9,3.5,2.9,3.5,47,313"),
    ('D', 5.1, "0,0 0,7 2,7 @2,3.5,3.1,3.5,90,-90 0,0"),
    ('E', 4.1, "4.1,7 0,7 0,0 4.1,0;0,3.7 3.6,3.7"),
    ('F', 4.0, "4.1,7 0,7 0,0;0,3.6 3.5,3.6"),
    ('G', 5.5, "@2.9,3.5,2.9,3.5,47,325 5.3,3.3 3.2,3.3"),
    ('H', 5.0, "0,0 0,7;5,0 5,7;0,3.6 5,3.6"),
    ('I', 0.9, "0.45,0 0.45,7"),
    ('J', 2.9, "2.8,7 2.8,1.6 @1.4,1.6,1.4,1.6,0,-160"),
    ('K', 4.8, "0,0 0,7;4.6,7 0,2.6;1.7,4.2 4.8,0"),
    ('L', 4.0, "0,7 0,0 4,0"),
    ('M', 6.0, "0,0 0,7 3,1.8 6,7 6,0"),
    ('N', 5.0, "0,0 0,7 5,0 5,7"),
    ('O', 6.0, "@3,3.5,3,3.5,0,360"),
    ('P', 4.6, "0,0 0,7 2.6,7 @2.6,5.1,2,1.9,90,-90 0,3.2"),
    ('Q', 6.0, "@3,3.5,3,3.5,0,360;3.8,1.6 5.8,-0.6"),
    ('R', 4.7, "0,0 0,7 2.6,7 @2.6,5.1,2,1.9,90,-90 0,3.2;2.6,3.2 4.7,0"),
    ('S', 4.6, "@2.35,5.25,2.05,1.75,28,270 @2.35,1.75,2.2,1.75,90,-152"),
    ('T', 5.0, "0,7 5,7;2.5,7 2.5,0"),
    ('U', 4.8, "0,7 0,2.4 @2.4,2.4,2.4,2.4,180,360 4.8,7"),
    ('V', 5.2, "0,7 2.6,0 5.2,7"),
    ('W', 7.0, "0,7 1.7,0 3.5,6.2 5.3,0 7,7"),
    ('X', 4.8, "0,0 4.8,7;0,7 4.8,0"),
    ('Y', 5.0, "0,7 2.5,3.4 5,7;2.5,3.4 2.5,0"),
    ('Z', 4.6, "0,7 4.6,7 0,0 4.6,0"),
    ('a', 4.1, "@2.05,2.5,2.05,2.5,0,360;4.1,5 4.1,0"),
    ('b', 4.1, "0,7.3 0,0;@2.05,2.5,2.05,2.5,0,360"),
    ('c', 3.8, "@2.25,2.5,2.25,2.5,48,312"),
    ('d', 4.1, "4.1,7.3 4.1,0;@2.05,2.5,2.05,2.5,0,360"),
    ('e', 4.2, "0.1,2.6 4.2,2.6 @2.15,2.5,2.1,2.5,3,318"),
    ('f', 2.4, "1,0 1,5.8 @2.4,5.8,1.4,1.4,180,85;0,4.9 2.4,4.9"),
    ('g', 4.1, "@2.05,2.5,2.05,2.5,0,360;4.1,5 4.1,-0.2 @2.1,-0.2,2,1.8,0,-150"),
    ('h', 4.0, "0,0 0,7.3;0,2.9 @2,2.9,2,2.1,180,0 4,0"),
    ('i', 0.8, "0.4,0 0.4,5;0.4,6.8 0.4,7"),
    ('j', 1.4, "1.1,5 1.1,-0.7 @-0.1,-0.7,1.2,1.3,0,-90;1.1,6.8 1.1,7"),
    ('k', 3.9, "0,0 0,7.3;3.7,5 0,1.6;1.4,2.9 3.9,0"),
    ('l', 0.8, "0.4,0 0.4,7.3"),
    ('m', 6.4, "0,0 0,5;0,3.1 @1.6,3.1,1.6,1.9,180,0 3.2,0;3.2,3.1 @4.8,3.1,1.6,1.9,180,0 6.4,0"),
    ('n', 4.0, "0,0 0,5;0,2.9 @2,2.9,2,2.1,180,0 4,0"),
    ('o', 4.3, "@2.15,2.5,2.15,2.5,0,360"),
    ('p', 4.1, "0,5 0,-2;@2.05,2.5,2.05,2.5,0,360"),
    ('q', 4.1, "4.1,5 4.1,-2;@2.05,2.5,2.05,2.5,0,360"),
    ('r', 2.4, "0,0 0,5;0,2.9 @2,2.9,2,2.1,180,78"),
    ('s', 3.6, "@1.85,3.75,1.6,1.25,25,270 @1.85,1.25,1.75,1.25,90,-155"),
    ('t', 2.5, "1.1,6.6 1.1,1.4 @2.4,1.4,1.3,1.4,180,278;0,4.9 2.5,4.9"),
    ('u', 4.0, "0,5 0,2.1 @2,2.1,2,2.1,180,360;4,5 4,0"),
    ('v', 4.0, "0,5 2,0 4,5"),
    ('w', 5.8, "0,5 1.4,0 2.9,4.6 4.4,0 5.8,5"),
    ('x', 3.8, "0,0 3.8,5;0,5 3.8,0"),
    ('y', 4.1, "0,5 2.1,0.2;4.1,5 1.5,-1.5 0.2,-2"),
    ('z', 3.7, "0,5 3.7,5 0,0 3.7,0"),
    ('.', 0.9, "0.35,0 0.55,0 0.55,0.2 0.35,0.2 0.35,0"),
    (',', 0.9, "0.6,0.2 0.1,-1.3"),
    (':', 0.9, "0.35,0 0.55,0 0.55,0.2 0.35,0.2 0.35,0;0.35,4.2 0.55,4.2 0.55,4.4 0.35,4.4 0.35,4.2"),
    (';', 0.9, "0.6,0.2 0.1,-1.3;0.5,4.2 0.5,4.35"),
    ('-', 2.4, "0,2.7 2.4,2.7"),
    ('−', 4.0, "0,2.9 4,2.9"),
    ('–', 3.8, "0,2.7 3.8,2.7"),
    ('_', 4.4, "0,-1.2 4.4,-1.2"),
    ('+', 4.0, "0,2.9 4,2.9;2,0.9 2,4.9"),
    ('=', 4.0, "0,2 4,2;0,3.9 4,3.9"),
    ('<', 4.0, "4,5 0,2.9 4,0.8"),
    ('>', 4.0, "0,5 4,2.9 0,0.8"),
    ('≤', 4.0, "4,5.6 0,3.8 4,2;0,0.5 4,0.5"),
    ('≥', 4.0, "0,5.6 4,3.8 0,2;0,0.5 4,0.5"),
    ('×', 3.6, "0.1,1.2 3.5,4.6;0.1,4.6 3.5,1.2"),
    ('·', 0.9, "0.35,2.8 0.55,2.8 0.55,3 0.35,3 0.35,2.8"),
    ('/', 2.8, "0,-0.8 2.8,7.6"),
    ('|', 0.8, "0.4,-1.2 0.4,7.6"),
    ('%', 6.2, "@1.2,5.6,1.2,1.4,0,360;@5,1.4,1.2,1.4,0,360;5.1,7 1.1,0"),
    ('(', 1.6, "@3.2,3,3,5.6,130,230"),
    (')', 1.6, "@-1.4,3,3,5.6,50,-50"),
    ('[', 1.5, "1.5,7.4 0,7.4 0,-1.3 1.5,-1.3"),
    (']', 1.5, "0,7.4 1.5,7.4 1.5,-1.3 0,-1.3"),
    ('\'', 0.6, "0.3,7.2 0.3,5.3"),
    ('"', 1.8, "0.3,7.2 0.3,5.3;1.5,7.2 1.5,5.3"),
    ('!', 0.8, "0.4,7 0.4,2.2;0.4,0 0.4,0.15"),
    ('?', 3.8, "@1.9,5.2,1.85,1.8,165,-60 1.8,2.9 1.8,2.1;1.8,0 1.8,0.15"),
    ('*', 3.6, "1.8,7 1.8,4;0.4,6.2 3.2,4.8;0.4,4.8 3.2,6.2"),
    ('#', 5.0, "1,0 2,7;3.2,0 4.2,7;0.2,4.7 5,4.7;0,2.3 4.8,2.3"),
    ('&', 5.4, "5.2,0 1.2,5 @2.2,5.6,1.4,1.4,205,-25 0.8,3 @2,1.8,2,1.8,130,330 5,3.2"),
    ('@', 7.0, "@3.4,2.5,1.5,1.7,0,360;4.9,4.2 4.9,1.4 @6,1.6,1.1,1,190,360 7,3 @3.5,2.8,3.5,4,0,300"),
    ('°', 2.2, "@1.1,5.9,1.1,1.1,0,360"),
    ('²', 2.0, "@0.98,6.2,0.85,0.9,160,-38 0.1,3.9 2,3.9"),
    ('³', 1.9, "@0.9,6.4,0.8,0.7,150,-90 @0.9,4.8,0.95,0.9,90,-150"),
    ('¹', 1.3, "0.2,6.4 1,7.1 1,3.9"),
    ('⁻', 1.9, "0,5.4 1.9,5.4"),
    ('µ', 4.0, "0,5 0,-2;0,2.1 @2,2.1,2,2.1,180,360;4,5 4,0"),
    ('θ', 4.2, "@2.1,3.6,2.1,3.6,0,360;0,3.6 4.2,3.6"),
    ('φ', 4.8, "@2.4,2.5,2.4,2.5,0,360;2.4,7 2.4,-2"),
    ('τ', 4.0, "0,5 4,5;2,5 2,1.4 @3.3,1.4,1.3,1.4,180,280"),
    ('ρ', 4.1, "0,-2 0,2.5;@2.05,2.5,2.05,2.5,0,360"),
    ('Ω', 5.8, "0,0 1.9,0 1.9,0.9 @2.9,3.9,2.7,3.1,250,-70 3.9,0.9 3.9,0 5.8,0"),
    ('→', 5.0, "0,2.9 5,2.9;3.3,4.5 5,2.9 3.3,1.3"),
    ('ß', 4.0, "0,0 0,5.4 @1.7,5.4,1.7,1.7,180,-60 1.6,3.9 @2.1,2,1.9,2,90,-110"),
];

/// Letters made of another one and a mark above it: dots, acute, grave, circumflex.
#[rustfmt::skip]
const ACCENTED: &[(char, char, char)] = &[
    ('ä', 'a', ':'), ('ö', 'o', ':'), ('ü', 'u', ':'), ('Ä', 'A', ':'), ('Ö', 'O', ':'), ('Ü', 'U', ':'), ('ë', 'e', ':'),
    ('é', 'e', '/'), ('á', 'a', '/'), ('ó', 'o', '/'), ('ú', 'u', '/'), ('É', 'E', '/'),
    ('è', 'e', '\\'), ('à', 'a', '\\'), ('ù', 'u', '\\'), ('ê', 'e', '^'), ('â', 'a', '^'), ('ô', 'o', '^'), ('û', 'u', '^'),
];

type Stroke = Vec<[f64; 2]>;

struct Glyph {
    width: f64,
    strokes: Vec<Stroke>,
}

fn glyphs() -> &'static HashMap<char, Glyph> {
    static TABLE: OnceLock<HashMap<char, Glyph>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut table: HashMap<char, Glyph> = GLYPHS
            .iter()
            .map(|&(c, width, strokes)| (c, Glyph { width, strokes: strokes.split(';').map(parse_stroke).collect() }))
            .collect();
        for &(c, base, mark) in ACCENTED {
            let Glyph { width, ref strokes } = table[&base];
            let mut strokes = strokes.clone();
            let (x, y) = (width / 2.0, if base.is_uppercase() { 8.2 } else { 6.4 });
            match mark {
                ':' => strokes.extend([x - 1.0, x + 1.0].map(|x| vec![[x, y], [x, y + 0.15]])),
                '/' => strokes.push(vec![[x - 0.4, y - 0.3], [x + 0.8, y + 0.9]]),
                '\\' => strokes.push(vec![[x + 0.4, y - 0.3], [x - 0.8, y + 0.9]]),
                _ => strokes.push(vec![[x - 1.1, y - 0.3], [x, y + 0.7], [x + 1.1, y - 0.3]]),
            }
            table.insert(c, Glyph { width, strokes });
        }
        table
    })
}

fn parse_stroke(text: &str) -> Stroke {
    let mut points = Stroke::new();
    for word in text.split_whitespace() {
        let numbers: Vec<f64> = word.trim_start_matches('@').split(',').map(|n| n.parse().expect("the font table holds numbers")).collect();
        match numbers[..] {
            [x, y] => points.push([x, y]),
            [cx, cy, rx, ry, from, to] => {
                let steps = ((to - from).abs() / 9.0).ceil() as usize;
                points.extend((0..=steps).map(|i| {
                    let angle = (from + (to - from) * i as f64 / steps as f64) * PI / 180.0;
                    [cx + rx * angle.cos(), cy + ry * angle.sin()]
                }));
            }
            _ => unreachable!("the font table holds points and arcs"),
        }
    }
    points
}

/// An empty box, for characters the font lacks.
fn missing() -> Glyph {
    Glyph { width: 4.0, strokes: vec![vec![[0.0, 0.0], [4.0, 0.0], [4.0, 7.0], [0.0, 7.0], [0.0, 0.0]]] }
}

fn unit(size: f64) -> f64 {
    size * CAP_BY_SIZE / CAP_HEIGHT
}

/// Width of a line of text, in the units of `size`.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    let units: f64 = text.chars().map(|c| glyphs().get(&c).map_or(4.0, |g| g.width) + SPACING).sum();
    (units - SPACING).max(0.0) * unit(size)
}

/// Height of capitals, in the units of `size`.
pub(crate) fn cap_height(size: f64) -> f64 {
    size * CAP_BY_SIZE
}

/// Thickness of the strokes, in the units of `size`.
pub(crate) fn stroke_width(size: f64) -> f64 {
    cap_height(size) * WEIGHT
}

/// Strokes of a line of text that begins at the origin on the base line; x to the right, y
/// **down**.
pub(crate) fn strokes(text: &str, size: f64) -> Vec<Stroke> {
    let scale = unit(size);
    let mut at = 0.0;
    let mut all = Vec::new();
    for c in text.chars() {
        let fallback;
        let glyph = match glyphs().get(&c) {
            Some(glyph) => glyph,
            None => {
                fallback = missing();
                &fallback
            }
        };
        all.extend(
            glyph
                .strokes
                .iter()
                .filter(|s| !s.is_empty())
                .map(|s| s.iter().map(|[x, y]| [(at + x) * scale, -y * scale]).collect::<Stroke>()),
        );
        at += glyph.width + SPACING;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printable_character_stays_within_its_box() {
        for c in ' '..='~' {
            if "$^`{}~\\".contains(c) {
                continue;
            }
            let glyph = glyphs().get(&c).unwrap_or_else(|| panic!("no glyph for {c:?}"));
            for [x, y] in glyph.strokes.iter().flatten() {
                assert!((-0.5..=glyph.width + 0.5).contains(x) && (-2.5..=8.0).contains(y), "{c:?}: {x} {y}");
            }
        }
        assert!(glyphs().len() >= GLYPHS.len() + ACCENTED.len(), "a character occurs twice");
    }

    #[test]
    fn widths_add_up() {
        assert_eq!(width("", 10.0), 0.0);
        assert!((width("00", 10.0) - (2.0 * 4.4 + SPACING) * 0.72 * 10.0 / 7.0).abs() < 1e-12);
        assert!(width("日", 10.0) > 0.0, "unknown characters are boxes");
    }
}

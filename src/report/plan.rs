//! Plans and sections of the room.

use crate::image::drawing::{Anchor, Drawing, Text};
use crate::image::legend::ColorBar;
use crate::image::palette::{Color, INK, Palette, Scale, WHITE, readable_on, round_steps, short_number};
use crate::scene::Scene;
use crate::scene::outline::{Cells, Cut, extent};
use crate::simulate::year::Sensors;
use glam::DVec2;

/// Room for a drawing, pixels.
const ROOM: [f64; 2] = [400.0, 360.0];
/// Around it.
const MARGIN: f64 = 14.0;
/// Size of text.
pub(super) const TEXT: f64 = 12.0;
/// Windows.
pub(super) const PANE: Color = [0, 114, 178];
/// Most lines of a room's outline: of a model with more only the longest are drawn.
const MOST_LINES: usize = 6_000;

/// A drawing in metres.
pub(super) struct Sheet {
    pub drawing: Drawing,
    range: [DVec2; 2],
    unit: f64,
    top: f64,
}

impl Sheet {
    /// An empty one of a range, lower left and upper right corner in m, with a title above and room for a legend
    /// on the right.
    pub fn new(title: &str, range: [DVec2; 2], legend: f64) -> Self {
        let size = (range[1] - range[0]).max(DVec2::splat(1e-3));
        let unit = (ROOM[0] / size.x).min(ROOM[1] / size.y);
        let top = MARGIN + if title.is_empty() { 0.0 } else { TEXT * 2.0 };
        let width = (size.x * unit + 2.0 * MARGIN + legend).max(crate::image::font::width(title, TEXT * 1.1) + 2.0 * MARGIN);
        let mut drawing = Drawing::new(width.ceil(), (top + size.y * unit + MARGIN + TEXT * 2.2).ceil());
        if !title.is_empty() {
            drawing.label(title, [MARGIN, MARGIN + TEXT * 0.3], TEXT * 1.1, INK, Anchor::Start);
        }
        Self { drawing, range, unit, top }
    }

    /// Place of a point.
    pub fn at(&self, p: DVec2) -> [f64; 2] {
        [MARGIN + (p.x - self.range[0].x) * self.unit, self.top + (self.range[1].y - p.y) * self.unit]
    }

    /// Upper right corner, beside which a legend stands.
    pub fn beside(&self) -> [f64; 2] {
        let [x, y] = self.at(self.range[1]);
        [x + MARGIN, y]
    }

    /// Pixels per metre.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Draws lines, cut at the range.
    pub fn lines(&mut self, lines: &[[DVec2; 2]], width: f64, color: Color) {
        let mut cut: Vec<[DVec2; 2]> = lines.iter().filter_map(|l| clipped(*l, self.range)).collect();
        cut.retain(|[a, b]| a.distance(*b) * self.unit > 0.4);
        if cut.len() > MOST_LINES {
            cut.sort_by(|a, b| b[0].distance(b[1]).total_cmp(&a[0].distance(a[1])));
            cut.truncate(MOST_LINES);
        }
        let lines = cut.into_iter().map(|[a, b]| vec![self.at(a), self.at(b)]).collect();
        self.drawing.lines(lines, width, color);
    }

    /// A round length below the drawing, and with `north` (degrees from +y, counter-clockwise) where north is.
    pub fn scale_bar(&mut self, north: Option<f64>) {
        let width = (self.range[1] - self.range[0]).x;
        let length = round_steps(0.0, width, 4).get(1).copied().unwrap_or(1.0);
        let [x, y] = self.at(self.range[0]);
        let y = y + TEXT * 1.1;
        let end = x + length * self.unit;
        self.drawing.lines(vec![vec![[x, y - 3.0], [x, y + 3.0]], vec![[x, y], [end, y]], vec![[end, y - 3.0], [end, y + 3.0]]], 1.0, INK);
        self.drawing.label(format!("{} m", short_number(length)), [end + 6.0, y], TEXT, INK, Anchor::Start);
        if let Some(degrees) = north {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let towards = [-sine, -cosine];
            let middle = [self.at(self.range[1])[0] - 12.0, y];
            let tip = [middle[0] + 9.0 * towards[0], middle[1] + 9.0 * towards[1]];
            let tail = [middle[0] - 9.0 * towards[0], middle[1] - 9.0 * towards[1]];
            let side = [towards[1] * 3.5, -towards[0] * 3.5];
            let base = [middle[0] + 2.0 * towards[0], middle[1] + 2.0 * towards[1]];
            self.drawing.line(tail, tip, 1.2, INK);
            self.drawing.polygons(vec![(vec![tip, [base[0] + side[0], base[1] + side[1]], [base[0] - side[0], base[1] - side[1]]], INK)]);
            self.drawing.label("N", [middle[0] - 16.0, middle[1]], TEXT, INK, Anchor::Middle);
        }
    }
}

/// The part of a line inside a range (Liang and Barsky).
fn clipped([a, b]: [DVec2; 2], [low, high]: [DVec2; 2]) -> Option<[DVec2; 2]> {
    let d = b - a;
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for (along, start, least, most) in [(d.x, a.x, low.x, high.x), (d.y, a.y, low.y, high.y)] {
        if along == 0.0 {
            if start < least || start > most {
                return None;
            }
            continue;
        }
        let (near, far) = ((least - start) / along, (most - start) / along);
        from = from.max(near.min(far));
        to = to.min(near.max(far));
    }
    (from < to).then(|| [a + d * from, a + d * to])
}

/// What the cells of a heat map show.
pub(super) struct HeatMap<'a> {
    /// Title above.
    pub title: String,
    /// The group.
    pub group: &'a Sensors,
    /// The room, if it is known.
    pub scene: Option<&'a Scene>,
    /// Where north is, degrees from +y.
    pub north: Option<f64>,
    /// Value by sensor.
    pub values: &'a [f64],
    /// Colours.
    pub palette: Palette,
    /// Scale.
    pub scale: Scale,
    /// Above the legend: the unit.
    pub label: &'a str,
    /// A value in its cell.
    pub text: &'a dyn Fn(f64) -> String,
}

impl HeatMap<'_> {
    /// Draws it.
    pub fn draw(&self) -> Drawing {
        let cells = Cells::around(&self.group.positions);
        let height = self.group.positions.iter().map(|p| p.z).sum::<f64>() / self.group.count().max(1) as f64;
        let walls = self.scene.map(|scene| Cut::plan(height).section(scene)).unwrap_or_default();
        let bar = ColorBar {
            palette: self.palette,
            scale: self.scale,
            ticks: self.scale.ticks(5),
            title: self.label.into(),
            steps: None,
            text_size: TEXT,
        };
        let length = 170.0;
        let mut sheet = Sheet::new(&self.title, extent(cells.range(), &walls), bar.size([14.0, length])[0] + MARGIN);
        let outlines = |i: usize| cells.outline(i).into_iter().map(|p| sheet.at(p)).collect::<Vec<_>>();
        let color = |v: f64| self.palette.color(self.scale.position(v));
        let polygons = self.values.iter().enumerate().map(|(i, v)| (outlines(i), color(*v))).collect();
        sheet.drawing.polygons(polygons);
        let cell = cells.size * sheet.unit();
        if cell.x > 26.0 && cell.y > 14.0 {
            let size = (cell.x / 3.4).clamp(7.0, 11.0);
            for (middle, value) in cells.middles.iter().zip(self.values) {
                let place = sheet.at(*middle);
                sheet.drawing.label((self.text)(*value), place, size, readable_on(color(*value)), Anchor::Middle);
            }
        }
        sheet.lines(&walls, 1.4, INK);
        let beside = sheet.beside();
        bar.draw(&mut sheet.drawing, beside, [14.0, length]);
        sheet.scale_bar(self.north);
        sheet.drawing
    }
}

/// Marks of a room's drawing.
pub(super) struct Marks<'a> {
    /// Title above.
    pub title: &'a str,
    /// Where it is cut.
    pub cut: Cut,
    /// Windows: their triangles, with a name.
    pub windows: &'a [(String, Vec<[glam::DVec3; 3]>)],
    /// Sensors of all groups.
    pub sensors: Vec<glam::DVec3>,
    /// Eyes, where they look, and names.
    pub eyes: &'a [(glam::DVec3, glam::DVec3, String)],
    /// Where north is, degrees from +y; nothing in sections.
    pub north: Option<f64>,
}

impl Marks<'_> {
    /// Draws the room with its windows, sensors and views.
    pub fn draw(&self, scene: &Scene) -> Drawing {
        let place = |p: &glam::DVec3| self.cut.place(*p);
        let panes = self.windows.iter().flat_map(|w| &w.1);
        let seen = self.sensors.iter().chain(self.eyes.iter().map(|e| &e.0)).chain(panes.clone().flatten()).map(place);
        let range = seen.fold([DVec2::MAX, DVec2::MIN], |[low, high], p| [low.min(p), high.max(p)]);
        let walls = self.cut.section(scene);
        let range = if range[0].x <= range[1].x { range } else { [DVec2::ZERO, DVec2::ONE] };
        let mut sheet = Sheet::new(self.title, extent(range, &walls), 0.0);
        // What lies before or behind the plane is pale.
        let edges: Vec<[DVec2; 2]> = panes
            .clone()
            .flat_map(|t| (0..3).map(|k| [place(&t[k]), place(&t[(k + 1) % 3])]))
            .filter(|[a, b]| a.distance(*b) > 1e-6)
            .collect();
        sheet.lines(&edges, 0.8, [160, 196, 220]);
        sheet.lines(&walls, 1.4, INK);
        sheet.lines(&self.cut.lines(panes), 3.0, PANE);
        let dot = if self.sensors.len() > 400 { 0.7 } else { 1.6 };
        for p in &self.sensors {
            let at = sheet.at(place(p));
            sheet.drawing.circle(at, dot, dot, [110, 110, 110]);
        }
        for (eye, direction, name) in self.eyes {
            let from = place(eye);
            let tip = from + (place(&(*eye + *direction)) - from).normalize_or_zero() * (22.0 / sheet.unit());
            let (from, tip) = (sheet.at(from), sheet.at(tip));
            sheet.drawing.line(from, tip, 1.6, [213, 94, 0]);
            sheet.drawing.circle(from, 2.5, 3.0, [213, 94, 0]);
            let text = Text {
                text: name.clone(),
                place: [from[0], from[1] - 11.0],
                size: TEXT,
                color: INK,
                anchor: Anchor::Middle,
                vertical: false,
                centered: true,
                halo: Some(WHITE),
            };
            sheet.drawing.text(text);
        }
        for (at, name) in names(self.windows, &self.cut) {
            let at = sheet.at(at);
            let text = Text {
                text: name,
                place: [at[0], at[1] + if self.north.is_some() { 11.0 } else { 0.0 }],
                size: TEXT,
                color: PANE,
                anchor: Anchor::Middle,
                vertical: false,
                centered: true,
                halo: Some(WHITE),
            };
            sheet.drawing.text(text);
        }
        sheet.scale_bar(self.north);
        sheet.drawing
    }
}

/// Names of windows and their places; of windows at one place, such as above each other in a plan, all in one line.
fn names(windows: &[(String, Vec<[glam::DVec3; 3]>)], cut: &Cut) -> Vec<(DVec2, String)> {
    let mut named: Vec<(DVec2, String)> = Vec::new();
    for (name, triangles) in windows {
        let corners = || triangles.iter().flatten().map(|p| cut.place(*p));
        let middle = corners().sum::<DVec2>() / corners().count().max(1) as f64;
        match named.iter_mut().find(|(at, _)| at.distance(middle) < 0.3) {
            Some((_, names)) => *names = format!("{names}, {name}"),
            None => named.push((middle, name.clone())),
        }
    }
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_range() {
        let range = [DVec2::ZERO, DVec2::new(2.0, 1.0)];
        let cut = |a: [f64; 2], b: [f64; 2]| clipped([a.into(), b.into()], range);
        assert_eq!(cut([-1.0, 0.5], [3.0, 0.5]), Some([DVec2::new(0.0, 0.5), DVec2::new(2.0, 0.5)]));
        assert_eq!(cut([0.5, 0.5], [1.0, 0.5]), Some([DVec2::new(0.5, 0.5), DVec2::new(1.0, 0.5)]));
        assert_eq!(cut([-1.0, 2.0], [3.0, 2.0]), None);
        assert_eq!(cut([3.0, 0.0], [3.0, 1.0]), None);
    }
}

//! Points in the plane with logarithmic axes, in series, with a line for their front.

use super::drawing::{Anchor, Drawing, Text};
use super::font::{self, TEXT_SIZE};
use super::legend::ClassList;
use super::palette::{Color, GRID, INK};
use crate::error::{Error, Result};

/// Size of a panel's area, pixels.
const AREA: [f64; 2] = [380.0, 300.0];
/// Room left of a panel for its ticks and label, and below it.
const MARGIN: [f64; 2] = [72.0, 52.0];

/// A point with its series.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Abscissa and ordinate; both above 0.
    pub at: [f64; 2],
    /// Index of its series.
    pub series: usize,
    /// Beside the point; may be empty.
    pub label: String,
    /// Drawn with a ring.
    pub marked: bool,
}

/// One plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Above it.
    pub title: String,
    /// Quantity and unit of the abscissa and the ordinate.
    pub axes: [String; 2],
    /// The points.
    pub points: Vec<Point>,
    /// Joined by a thick pale line, from the left.
    pub front: Vec<[f64; 2]>,
    /// A dashed line across, if any.
    pub limit: Option<f64>,
}

/// Panels side by side with one legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// Panels from the left.
    pub panels: Vec<Panel>,
    /// Name and colour of each series; points of one that is not line-free are joined.
    pub series: Vec<(String, Color)>,
    /// Series whose points are joined in their order.
    pub joined: Vec<usize>,
}

/// Powers of ten that hold all values.
fn decades(values: impl Iterator<Item = f64>) -> Result<[f64; 2]> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values {
        if !(v > 0.0 && v.is_finite()) {
            return Err(Error::new(format!("{v} has no place on a logarithmic axis")));
        }
        (low, high) = (low.min(v), high.max(v));
    }
    if low > high {
        return Err(Error::new("a plot needs points"));
    }
    // To the next of 1, 2, 5.
    let step = |v: f64, up: bool| {
        let power = 10f64.powf(v.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|s| s * power);
        if up {
            steps.into_iter().find(|s| *s >= v * 0.999).unwrap_or(10.0 * power)
        } else {
            steps.into_iter().rev().find(|s| *s <= v * 1.001).unwrap_or(power)
        }
    };
    Ok([step(low / 1.15, false), step(high * 1.15, true)])
}

/// 1, 2, 5, 10 … between limits.
fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let first = low.log10().floor() as i32;
    let last = high.log10().ceil() as i32;
    let all = (first..=last).flat_map(|power| [1.0, 2.0, 5.0].map(|s| s * 10f64.powi(power)));
    all.filter(|t| *t >= low * 0.999 && *t <= high * 1.001).collect()
}

fn number(value: f64) -> String {
    let text = if value >= 1.0 { format!("{value:.0}") } else { format!("{value:.6}") };
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

impl Scatter {
    /// Draws the panels.
    ///
    /// # Errors
    /// Without points, or with values that are not above 0.
    pub fn draw(&self) -> Result<Drawing> {
        let legend = ClassList { classes: self.series.clone(), title: String::new(), text_size: TEXT_SIZE };
        let panel_width = MARGIN[0] + AREA[0] + 16.0;
        let legend_left = panel_width * self.panels.len() as f64 + 8.0;
        let mut drawing = Drawing::new((legend_left + legend.size()[0] + 16.0).ceil(), 44.0 + AREA[1] + MARGIN[1]);
        for (i, panel) in self.panels.iter().enumerate() {
            self.panel(&mut drawing, panel, [panel_width * i as f64 + MARGIN[0], 44.0])?;
        }
        legend.draw(&mut drawing, [legend_left, 44.0]);
        Ok(drawing)
    }

    fn panel(&self, drawing: &mut Drawing, panel: &Panel, [left, top]: [f64; 2]) -> Result<()> {
        let all = |axis: usize| panel.points.iter().map(move |p| p.at[axis]);
        let (across, up) = (decades(all(0))?, decades(all(1).chain(panel.limit))?);
        let share = |v: f64, [low, high]: [f64; 2]| (v / low).ln() / (high / low).ln();
        let place = |[x, y]: [f64; 2]| [left + AREA[0] * share(x, across), top + AREA[1] * (1.0 - share(y, up))];
        let bottom = top + AREA[1];
        drawing.label(&*panel.title, [left, top - 20.0], TEXT_SIZE * 1.15, INK, Anchor::Start);
        for t in ticks(across) {
            let x = place([t, up[0]])[0];
            drawing.line([x, top], [x, bottom], 1.0, GRID);
            drawing.label(number(t), [x, bottom + TEXT_SIZE], TEXT_SIZE, INK, Anchor::Middle);
        }
        for t in ticks(up) {
            let y = place([across[0], t])[1];
            drawing.line([left, y], [left + AREA[0], y], 1.0, GRID);
            drawing.label(number(t), [left - 8.0, y], TEXT_SIZE, INK, Anchor::End);
        }
        drawing.frame([left, top, AREA[0], AREA[1]], 1.2, INK);
        drawing.label(&*panel.axes[0], [left + AREA[0] / 2.0, bottom + TEXT_SIZE * 2.7], TEXT_SIZE, INK, Anchor::Middle);
        drawing.upward_label(&*panel.axes[1], [left - MARGIN[0] + TEXT_SIZE, top + AREA[1] / 2.0], TEXT_SIZE, INK);
        if let Some(limit) = panel.limit {
            let y = place([across[0], limit])[1];
            let dashes = (0..48).map(|i| f64::from(i) * AREA[0] / 48.0);
            drawing.lines(dashes.map(|x| vec![[left + x, y], [left + x + AREA[0] / 96.0, y]]).collect(), 1.2, INK);
        }
        if panel.front.len() > 1 {
            drawing.lines(vec![panel.front.iter().map(|p| place(*p)).collect()], 7.0, [225, 225, 225]);
        }
        for &series in &self.joined {
            let line: Vec<[f64; 2]> = panel.points.iter().filter(|p| p.series == series).map(|p| place(p.at)).collect();
            if line.len() > 1 {
                drawing.lines(vec![line], 1.4, self.series[series].1);
            }
        }
        for point in &panel.points {
            let at = place(point.at);
            drawing.lines(vec![vec![at]], 9.0, self.series[point.series].1);
            if point.marked {
                drawing.circle(at, 8.5, 1.8, INK);
            }
        }
        self.labels(drawing, panel, &place, [left, top]);
        Ok(())
    }

    /// Labels to the right of their points, to the left or above and below where that is taken.
    fn labels(&self, drawing: &mut Drawing, panel: &Panel, place: &dyn Fn([f64; 2]) -> [f64; 2], [left, top]: [f64; 2]) {
        let size = TEXT_SIZE * 0.85;
        let mut taken: Vec<[f64; 4]> =
            panel.points.iter().map(|p| place(p.at)).map(|[x, y]| [x - 8.0, y - 5.0, x + 8.0, y + 5.0]).collect();
        for point in panel.points.iter().filter(|p| !p.label.is_empty()) {
            let [x, y] = place(point.at);
            let width = font::width(&point.label, size);
            let boxes = [
                [x + 11.0, y - size / 2.0],
                [x - 11.0 - width, y - size / 2.0],
                [x - width / 2.0, y - 10.0 - size],
                [x - width / 2.0, y + 10.0],
                [x + 6.0, y + 8.0],
                [x + 6.0, y - 8.0 - size],
                [x - 6.0 - width, y + 8.0],
                [x - 6.0 - width, y - 8.0 - size],
            ]
            .map(|[x, y]| [x, y, x + width, y + size]);
            let fits = |b: &[f64; 4]| b[0] > left && b[2] < left + AREA[0] && b[1] > top && b[3] < top + AREA[1];
            let free = |b: &[f64; 4]| taken.iter().all(|t| b[2] < t[0] || t[2] < b[0] || b[3] < t[1] || t[3] < b[1]);
            let Some(found) = boxes.into_iter().find(|b| fits(b) && free(b)) else { continue };
            taken.push(found);
            drawing.text(Text {
                text: point.label.clone(),
                place: [found[0], f64::midpoint(found[1], found[3])],
                size,
                color: self.series[point.series].1,
                anchor: Anchor::Start,
                vertical: false,
                centered: true,
                halo: Some([255; 3]),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(values: &[[f64; 2]]) -> Scatter {
        let point = |&at: &[f64; 2]| Point { at, series: 0, label: "a".into(), marked: false };
        let panel = Panel {
            title: "t".into(),
            axes: ["s".into(), "%".into()],
            points: values.iter().map(point).collect(),
            front: values.to_vec(),
            limit: Some(2.0),
        };
        Scatter { panels: vec![panel], series: vec![("series".into(), [0, 114, 178])], joined: vec![0] }
    }

    #[test]
    fn axes_hold_all_points_between_round_numbers() {
        assert_eq!(decades([0.3, 40.0].into_iter()).unwrap(), [0.2, 50.0]);
        assert_eq!(ticks([0.2, 5.0]), [0.2, 0.5, 1.0, 2.0, 5.0]);
        assert_eq!(["0.2", "0.05", "20"], [number(0.2), number(0.05), number(20.0)].map(|s| s.leak() as &str));
        let drawing = plot(&[[0.3, 5.0], [40.0, 0.1]]).draw().unwrap();
        let svg = drawing.svg().unwrap();
        assert!(svg.contains("series") && svg.contains(">50<") && svg.contains(">0.05<"), "{svg}");
    }

    #[test]
    fn what_has_no_logarithm_is_refused() {
        for bad in [[0.0, 1.0], [1.0, -1.0], [f64::NAN, 1.0]] {
            assert!(plot(&[bad]).draw().is_err());
        }
        assert!(
            Scatter { panels: vec![Panel { points: Vec::new(), limit: None, ..plot(&[]).panels[0].clone() }], ..plot(&[]) }.draw().is_err()
        );
    }
}

//! Carpet plots: a value for every hour of the year, months across and hours upwards.

use super::drawing::{Anchor, Drawing};
use super::font::{self, TEXT_SIZE};
use super::legend::{ClassList, ColorBar};
use super::palette::{Color, GRID, INK, NO_DATA, Palette, Scale};
use crate::error::{Error, Result};

/// Size of a day across and of an hour upwards, pixels.
const CELL: [f64; 2] = [2.0, 11.0];

const MONTHS: [&str; 12] = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// How values become colours.
#[derive(Debug, Clone, PartialEq)]
pub enum Coloring {
    /// Continuous, with a bar as legend.
    Continuous {
        /// Colours.
        palette: Palette,
        /// Values; what lies outside gets the colour of the nearer end.
        scale: Scale,
    },
    /// A colour per class, with a list as legend.
    Classes(Vec<Class>),
}

/// A range of values, from the limit of the class before (or −∞) up to its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Class {
    /// Name in the legend.
    pub name: String,
    /// First value that no longer belongs to it; the last class has +∞.
    pub limit: f64,
    /// Colour.
    pub color: Color,
}

/// A plot of one value per hour, or per shorter step, of a year or another number of whole days.
#[derive(Debug, Clone, PartialEq)]
pub struct Carpet<'a> {
    /// `values[day * steps_per_day + step]`; NaN where there is none (night, not occupied).
    pub values: &'a [f64],
    /// 24 for hourly values.
    pub steps_per_day: usize,
    /// Day of the year of the first value, from 0.
    pub first_day: usize,
    /// Whether the year has a 29 February.
    pub leap: bool,
    /// Above the plot; may be empty.
    pub title: String,
    /// Quantity and unit, above the legend; may be empty.
    pub label: String,
    /// Colours.
    pub coloring: Coloring,
    /// What NaN means, for the legend, for instance `night`; `None` leaves it out.
    pub missing: Option<String>,
    /// Whether classes are listed with their share of all values that are not NaN.
    pub shares: bool,
}

impl Coloring {
    /// Classes between limits, coloured evenly from a palette: one name more than limits.
    ///
    /// # Errors
    /// If limits do not rise or names do not fit.
    pub fn classes(limits: &[f64], names: &[&str], palette: Palette) -> Result<Self> {
        if names.len() != limits.len() + 1 {
            return Err(Error::new(format!(
                "{} limits make {} classes, but there are {} names",
                limits.len(),
                limits.len() + 1,
                names.len()
            )));
        }
        if !limits.windows(2).all(|w| w[0] < w[1]) || limits.iter().any(|l| l.is_nan()) {
            return Err(Error::new(format!("limits of classes must rise: {limits:?}")));
        }
        let last = limits.len().max(1) as f64;
        let all = limits.iter().copied().chain([f64::INFINITY]);
        let classes = all.zip(names).enumerate();
        Ok(Self::Classes(
            classes.map(|(i, (limit, name))| Class { name: (*name).to_owned(), limit, color: palette.color(i as f64 / last) }).collect(),
        ))
    }

    fn color(&self, value: f64) -> Color {
        if value.is_nan() {
            return NO_DATA;
        }
        match self {
            Self::Continuous { palette, scale } => palette.color(scale.position(value)),
            Self::Classes(classes) => classes.iter().find(|c| value < c.limit).or(classes.last()).map_or(NO_DATA, |c| c.color),
        }
    }
}

impl Carpet<'_> {
    /// Draws the plot.
    ///
    /// # Errors
    /// If the values are not whole days, or there are no classes.
    pub fn draw(&self) -> Result<Drawing> {
        let steps = self.steps_per_day;
        if steps == 0 || self.values.is_empty() || !self.values.len().is_multiple_of(steps) || self.values.len() / steps > 366 {
            return Err(Error::new(format!("{} values are not whole days of {steps} up to a year", self.values.len())));
        }
        if matches!(&self.coloring, Coloring::Classes(c) if c.is_empty()) {
            return Err(Error::new("a plot of classes needs classes"));
        }
        let days = self.values.len() / steps;
        let (width, height) = (365.0 * CELL[0], 24.0 * CELL[1]);
        let left = 18.0 + TEXT_SIZE * 2.6;
        let top = if self.title.is_empty() { 14.0 } else { 18.0 + TEXT_SIZE * 1.7 };
        let legend = self.legend();
        let [legend_width, legend_height] = legend.size();
        let legend_left = left + width + 24.0;
        let total_height = (top + height + TEXT_SIZE * 2.2).max(top + legend_height + 12.0);
        let mut drawing = Drawing::new((legend_left + legend_width + 16.0).ceil(), total_height.ceil());
        if !self.title.is_empty() {
            drawing.label(&*self.title, [left, 14.0 + TEXT_SIZE * 0.5], TEXT_SIZE * 1.2, INK, Anchor::Start);
        }
        // Row 0 of the image is the last step of the day.
        let pixels = (0..steps).rev().flat_map(|step| (0..days).map(move |day| (day, step)));
        let colors = pixels.map(|(day, step)| self.coloring.color(self.values[day * steps + step])).collect();
        drawing.image([left, top, width, height], days, colors);
        self.axes(&mut drawing, [left, top, width, height], days);
        legend.draw(&mut drawing, [legend_left, top]);
        Ok(drawing)
    }

    fn axes(&self, drawing: &mut Drawing, [left, top, width, height]: [f64; 4], days: usize) {
        let bottom = top + height;
        let x = |day: f64| left + width * day / days as f64;
        let y = |hour: f64| bottom - height * hour / 24.0;
        let mut ticks = Vec::new();
        for hour in (0..=24).step_by(3) {
            let long = hour % 6 == 0;
            ticks.push(vec![[left - if long { 5.0 } else { 3.0 }, y(f64::from(hour))], [left, y(f64::from(hour))]]);
            if long {
                drawing.label(hour.to_string(), [left - 8.0, y(f64::from(hour))], TEXT_SIZE, INK, Anchor::End);
            }
        }
        let mut grid = Vec::new();
        for hour in [6.0, 12.0, 18.0] {
            grid.push(vec![[left, y(hour)], [left + width, y(hour)]]);
        }
        if days >= 365 {
            let mut start = 0.0;
            for (month, name) in MONTHS.iter().enumerate() {
                let length = month_length(month, self.leap);
                drawing.label(*name, [x(start + length / 2.0), bottom + TEXT_SIZE * 1.1], TEXT_SIZE, INK, Anchor::Middle);
                start += length;
                if month < 11 {
                    ticks.push(vec![[x(start), bottom], [x(start), bottom + 5.0]]);
                    grid.push(vec![[x(start), top], [x(start), bottom]]);
                }
            }
        } else {
            for day in super::palette::round_steps(0.0, days as f64, 8).into_iter().filter(|d| d.fract() == 0.0) {
                ticks.push(vec![[x(day), bottom], [x(day), bottom + 5.0]]);
                if day < days as f64 {
                    let label = date(self.first_day + day as usize, self.leap);
                    drawing.label(label, [x(day + 0.5), bottom + TEXT_SIZE * 1.1], TEXT_SIZE, INK, Anchor::Middle);
                }
            }
        }
        drawing.lines(grid, 0.4, GRID);
        drawing.lines(ticks, 1.0, INK);
        drawing.frame([left, top, width, height], 1.0, INK);
        drawing.upward_label(
            "hour of day",
            [left - 12.0 - font::width("24", TEXT_SIZE) - TEXT_SIZE * 0.6, top + height / 2.0],
            TEXT_SIZE,
            INK,
        );
    }

    fn legend(&self) -> Legend {
        let mut list = ClassList { classes: Vec::new(), title: String::new(), text_size: TEXT_SIZE };
        let mut bar = None;
        match &self.coloring {
            Coloring::Continuous { palette, scale } => {
                let ticks = scale.ticks(6);
                bar = Some(ColorBar {
                    palette: *palette,
                    scale: *scale,
                    ticks,
                    title: self.label.clone(),
                    steps: None,
                    text_size: TEXT_SIZE,
                });
            }
            Coloring::Classes(classes) => {
                list.title.clone_from(&self.label);
                let counted = self.values.iter().filter(|v| !v.is_nan()).count().max(1) as f64;
                let mut below = f64::NEG_INFINITY;
                // The highest class on top.
                for class in classes {
                    let count = self.values.iter().filter(|v| **v >= below && **v < class.limit).count() as f64;
                    below = class.limit;
                    let share = if self.shares { format!(": {:.1} %", count / counted * 100.0) } else { String::new() };
                    list.classes.insert(0, (format!("{}{share}", class.name), class.color));
                }
            }
        }
        if let Some(name) = &self.missing {
            list.classes.push((name.clone(), NO_DATA));
        }
        Legend { bar, list }
    }
}

/// A bar, a list, or the list below the bar.
struct Legend {
    bar: Option<ColorBar>,
    list: ClassList,
}

impl Legend {
    const BAR: [f64; 2] = [18.0, 200.0];

    fn size(&self) -> [f64; 2] {
        let list = if self.list.classes.is_empty() { [0.0; 2] } else { self.list.size() };
        match &self.bar {
            Some(bar) => {
                let [w, h] = bar.size(Self::BAR);
                [w.max(list[0]), h + list[1]]
            }
            None => list,
        }
    }

    fn draw(&self, drawing: &mut Drawing, [x, mut y]: [f64; 2]) {
        if let Some(bar) = &self.bar {
            bar.draw(drawing, [x, y], Self::BAR);
            y += bar.size(Self::BAR)[1] + 4.0;
        }
        if !self.list.classes.is_empty() {
            self.list.draw(drawing, [x, y]);
        }
    }
}

fn month_length(month: usize, leap: bool) -> f64 {
    match month {
        1 if leap => 29.0,
        1 => 28.0,
        3 | 5 | 8 | 10 => 30.0,
        _ => 31.0,
    }
}

/// `21 Jun`: a day of the year, from 0.
fn date(day: usize, leap: bool) -> String {
    let mut rest = day as f64;
    let month = (0..11).find(|m| {
        let length = month_length(*m, leap);
        let within = rest < length;
        rest -= if within { 0.0 } else { length };
        within
    });
    format!("{} {}", rest + 1.0, MONTHS[month.unwrap_or(11)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn carpet(values: &[f64], coloring: Coloring) -> Carpet<'_> {
        Carpet {
            values,
            steps_per_day: 24,
            first_day: 0,
            leap: false,
            title: "Title".into(),
            label: "DGP".into(),
            coloring,
            missing: Some("night".into()),
            shares: true,
        }
    }

    #[test]
    fn months_make_a_year() {
        assert_eq!((0..12).map(|m| month_length(m, false)).sum::<f64>(), 365.0);
        assert_eq!((0..12).map(|m| month_length(m, true)).sum::<f64>(), 366.0);
    }

    #[test]
    fn days_of_a_part_of_a_year_have_their_dates() {
        let dates = [(0, false), (59, false), (59, true), (60, true), (171, false), (364, false), (365, true)];
        assert_eq!(dates.map(|(day, leap)| date(day, leap)), ["1 Jan", "1 Mar", "29 Feb", "1 Mar", "21 Jun", "31 Dec", "31 Dec"]);
        let values = vec![0.5; 4 * 24 * 10];
        let scale = Scale::linear(0.0, 1.0).unwrap();
        let plain = carpet(&values, Coloring::Continuous { palette: Palette::Gray, scale });
        let june = Carpet { steps_per_day: 96, first_day: 171, ..plain };
        let svg = june.draw().unwrap().svg().unwrap();
        assert!(svg.contains("21 Jun") && !svg.contains("Jan"));
    }

    #[test]
    fn hours_run_upwards_and_days_to_the_right() {
        let mut values = vec![0.0; 8760];
        values[24 * 100 + 7] = 1.0;
        values[24 * 364 + 23] = f64::NAN;
        let scale = Scale::linear(0.0, 1.0).unwrap();
        let drawing = carpet(&values, Coloring::Continuous { palette: Palette::Gray, scale }).draw().unwrap();
        let canvas = drawing.canvas(1.0).unwrap();
        let white: Vec<(usize, usize)> = (0..canvas.height())
            .flat_map(|y| (60..780).map(move |x| (x, y)))
            .filter(|&(x, y)| canvas.get(x, y) == [255; 3] && canvas.get(x - 3, y) == [0; 3])
            .collect();
        let (left, top) = (18.0 + TEXT_SIZE * 2.6, 18.0 + TEXT_SIZE * 1.7);
        assert!(!white.is_empty());
        for (x, y) in white {
            assert!(((x as f64 + 0.5 - left) / 2.0 - 100.5).abs() <= 1.0, "{x} {y}");
            assert!((24.0 - (y as f64 + 0.5 - top) / 11.0 - 7.5).abs() <= 0.6, "{x} {y}");
        }
    }

    #[test]
    fn classes_take_their_ranges() {
        let coloring = Coloring::classes(&[0.35, 0.4, 0.45], &["a", "b", "c", "d"], Palette::Viridis).unwrap();
        assert_eq!(coloring.color(0.2), Palette::Viridis.color(0.0));
        assert_eq!(coloring.color(0.35), Palette::Viridis.color(1.0 / 3.0));
        assert_eq!(coloring.color(7.0), Palette::Viridis.color(1.0));
        assert_eq!(coloring.color(f64::NAN), NO_DATA);
        let values: Vec<f64> = (0..48)
            .map(|i| {
                if i < 12 {
                    f64::NAN
                } else if i < 30 {
                    0.1
                } else {
                    0.42
                }
            })
            .collect();
        let plot = carpet(&values, coloring);
        let names: Vec<String> = plot.legend().list.classes.into_iter().map(|c| c.0).collect();
        assert_eq!(names, ["d: 0.0 %", "c: 50.0 %", "b: 0.0 %", "a: 50.0 %", "night"]);
        plot.draw().unwrap().svg().unwrap();
        assert!(Coloring::classes(&[1.0], &["a"], Palette::Hot).is_err());
        assert!(Coloring::classes(&[2.0, 1.0], &["a", "b", "c"], Palette::Hot).is_err());
        let scale = Scale::linear(0.0, 1.0).unwrap();
        for length in [0, 25, 24 * 400] {
            let values = vec![0.0; length];
            assert!(carpet(&values, Coloring::Continuous { palette: Palette::Gray, scale }).draw().is_err());
        }
    }
}

//! What the Year panel shows for which state.

use crate::picture::model::{Mode, Tone};
use crate::results::{CLASSES, Results};
use crate::scale::ScaleChoice;
use lucarne::glare::index::dgps;
use lucarne::image::palette::{Palette, rounded_number};
use lucarne::matrix::Matrix;
use std::sync::Arc;

/// Local standard time of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamp {
    /// Month, 1…12.
    pub month: u8,
    /// Day of the month, from 1.
    pub day: u8,
    /// Hours from midnight.
    pub hour: f64,
}

const MONTHS: [&str; 12] =
    ["January", "February", "March", "April", "May", "June", "July", "August", "September", "October", "November", "December"];
const LENGTHS: [u8; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

impl Stamp {
    /// Steps of a common year where a result does not tell its times: as many per day as fit 365 days.
    pub fn common_year(steps: usize) -> Vec<Self> {
        let per_day = steps_per_day(steps);
        (0..steps)
            .map(|i| {
                let (mut day, hour) = ((i / per_day) % 365, (i % per_day) as f64 + 0.5);
                let mut month = 0;
                while day >= usize::from(LENGTHS[month]) {
                    day -= usize::from(LENGTHS[month]);
                    month += 1;
                }
                Self { month: month as u8 + 1, day: day as u8 + 1, hour: hour * 24.0 / per_day as f64 }
            })
            .collect()
    }

    /// `21 June, 12:30`.
    pub fn text(&self) -> String {
        let minutes = (self.hour * 60.0).round() as u32;
        let month = MONTHS.get(usize::from(self.month).wrapping_sub(1)).unwrap_or(&"?");
        format!("{} {month}, {:02}:{:02}", self.day, minutes / 60, minutes % 60)
    }
}

/// Steps per day of a year of this many steps.
pub fn steps_per_day(steps: usize) -> usize {
    if steps.is_multiple_of(365) && steps >= 365 {
        steps / 365
    } else if steps.is_multiple_of(366) && steps >= 366 {
        steps / 366
    } else {
        24
    }
}

/// Name and first day (from 0) of each month within `days` days.
pub fn months(stamps: &[Stamp], per_day: usize) -> Vec<(&'static str, usize)> {
    let mut found: Vec<(&'static str, usize)> = Vec::new();
    let mut last = 0;
    for (day, stamp) in stamps.iter().step_by(per_day.max(1)).enumerate() {
        if stamp.month != last {
            last = stamp.month;
            if let Some(name) = MONTHS.get(usize::from(stamp.month).wrapping_sub(1)) {
                found.push((&name[..3], day));
            }
        }
    }
    found
}

/// What a carpet shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Illuminance at a sensor of a group.
    Sensor(usize, usize),
    /// Mean illuminance of a group.
    Mean(usize),
    /// Simplified DGP from the vertical illuminance at a sensor.
    Simplified(usize, usize),
    /// DGP of a view.
    Dgp(usize),
    /// Class of DGP of a view.
    Class(usize),
}

impl Quantity {
    /// In words, for titles.
    pub fn name(self, results: &Results) -> String {
        let group = |g: usize| results.groups.get(g).map_or("?", |g| g.name.as_str());
        let view = |v: usize| results.glare.get(v).map_or("?", |g| g.view.as_str());
        match self {
            Self::Sensor(g, s) => format!("Illuminance at {} {}", group(g), s + 1),
            Self::Mean(g) => format!("Mean illuminance of {}", group(g)),
            Self::Simplified(g, s) => format!("Simplified DGP at {} {}", group(g), s + 1),
            Self::Dgp(v) => format!("Daylight glare probability of {}", view(v)),
            Self::Class(v) => format!("Glare class of {}", view(v)),
        }
    }

    /// Unit above the colour bar.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Sensor(..) | Self::Mean(_) => "lx",
            Self::Simplified(..) => "DGPs",
            Self::Dgp(_) => "DGP",
            Self::Class(_) => "class",
        }
    }

    /// Whether it is about glare.
    pub fn is_glare(self) -> bool {
        !matches!(self, Self::Sensor(..) | Self::Mean(_))
    }

    /// Its values by hour; NaN where there is none. `lux` replaces the stored illuminance (another
    /// state of the façade).
    pub fn values(self, results: &Results, lux: Option<&[Arc<Matrix<f32>>]>) -> Vec<f64> {
        let matrix = |g: usize| lux.and_then(|l| l.get(g)).or_else(|| results.groups.get(g).map(|g| &g.lux));
        let none = || vec![f64::NAN; results.hours()];
        let row =
            |g: usize, s: usize| matrix(g).filter(|m| s < m.rows()).map(|m| m.row(s).iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
        match self {
            Self::Sensor(g, s) => row(g, s).unwrap_or_else(none),
            Self::Simplified(g, s) => {
                row(g, s).map_or_else(none, |r| r.into_iter().map(|e| if e > 0.0 { dgps(e) } else { f64::NAN }).collect())
            }
            Self::Mean(g) => matrix(g).map_or_else(none, |m| {
                let mut mean = vec![0.0; m.cols()];
                for s in 0..m.rows() {
                    mean.iter_mut().zip(m.row(s)).for_each(|(a, v)| *a += f64::from(*v) / m.rows() as f64);
                }
                mean
            }),
            Self::Dgp(v) => results.glare.get(v).map_or_else(none, |g| g.dgp.clone()),
            Self::Class(v) => results.glare.get(v).map_or_else(none, |g| g.class.clone()),
        }
    }

    /// The standard error of its value in an hour, where the results tell it.
    pub fn error(self, results: &Results, hour: usize) -> Option<f64> {
        let found = match self {
            Self::Sensor(g, s) => {
                let errors = results.groups.get(g)?.error.as_ref().filter(|e| s < e.rows() && hour < e.cols())?;
                f64::from(errors.at(s, hour)[0])
            }
            Self::Dgp(v) => *results.glare.get(v)?.error.get(hour)?,
            _ => return None,
        };
        (found > 0.0).then_some(found)
    }

    /// A value in words, with its standard error.
    pub fn text(self, value: f64, error: Option<f64>) -> String {
        if value.is_nan() {
            return "–".into();
        }
        match self {
            Self::Sensor(..) | Self::Mean(_) => lux_text(value, error),
            Self::Simplified(..) => format!("DGPs {value:.3}"),
            Self::Dgp(_) => format!(
                "DGP {value:.3}{}, {}",
                error.map_or_else(String::new, |e| format!(" ± {e:.3}")),
                CLASSES[crate::results::class_of(value) as usize]
            ),
            Self::Class(_) => CLASSES.get(value as usize).unwrap_or(&"?").to_string(),
        }
    }
}

/// An illuminance with its standard error.
pub fn lux_text(value: f64, error: Option<f64>) -> String {
    let error = error.map_or_else(String::new, |e| format!(" ± {}", rounded_number(e)));
    format!("{}{error} lx", rounded_number(value))
}

/// The hour of the largest value; the first of several.
pub fn worst(values: &[f64]) -> Option<usize> {
    let best = values.iter().enumerate().filter(|(_, v)| !v.is_nan());
    best.fold(None, |m: Option<(usize, f64)>, (i, v)| if m.is_none_or(|m| *v > m.1) { Some((i, *v)) } else { m }).map(|m| m.0)
}

/// What tells most about glare: DGP of the first view, else simplified DGP at the first sensor that
/// faces sideways.
pub fn glare_quantity(results: &Results) -> Option<Quantity> {
    if !results.glare.is_empty() {
        return Some(Quantity::Dgp(0));
    }
    let vertical = |g: &crate::results::Group| g.directions.iter().position(|d| d.z.abs() < 0.5);
    results.groups.iter().enumerate().find_map(|(i, g)| Some(Quantity::Simplified(i, vertical(g)?)))
}

/// Everything the user has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Hour of the year, from 0.
    pub hour: usize,
    /// What the carpet shows.
    pub quantity: Quantity,
    /// Scale of illuminance carpets.
    pub carpet: ScaleChoice,
    /// Colours of carpet and picture.
    pub palette: Palette,
    /// The picture's view.
    pub view: usize,
    /// Falsecolour or photograph.
    pub mode: Mode,
    /// Scale of the picture.
    pub picture: ScaleChoice,
    /// Exposure of the photograph, stops.
    pub stops: f64,
    /// Outline glare sources.
    pub sources: bool,
    /// How far each window is on its way to its second state, 0…1.
    pub fractions: Vec<f64>,
}

impl Default for View {
    fn default() -> Self {
        Self {
            hour: 12,
            quantity: Quantity::Mean(0),
            carpet: ScaleChoice { log: false, decades: 3.0, maximum: None },
            palette: Palette::Viridis,
            view: 0,
            mode: Mode::Falsecolor,
            picture: ScaleChoice { log: true, decades: 3.0, maximum: Some(5000.0) },
            stops: 0.0,
            sources: true,
            fractions: Vec::new(),
        }
    }
}

impl View {
    /// Chooses what the results have, and an hour with light.
    pub fn fit(&mut self, results: &Results) {
        *self = Self { palette: self.palette, ..Self::default() };
        self.fractions = vec![0.0; results.windows.len()];
        self.quantity = if results.glare.is_empty() { Quantity::Mean(0) } else { Quantity::Dgp(0) };
        let noon = |s: &Stamp| (s.month, s.day) == (3, 21) && (11.4..12.6).contains(&s.hour);
        self.hour = results.stamps.iter().position(noon).unwrap_or(results.hours() / 2);
    }

    /// Moves by steps and days.
    pub fn step(&mut self, results: &Results, steps: i64, days: i64) {
        let per_day = steps_per_day(results.hours()) as i64;
        let last = results.hours().saturating_sub(1) as i64;
        self.hour = (self.hour as i64 + steps + days * per_day).clamp(0, last) as usize;
    }

    /// The picture panel's view of the same choices.
    pub fn picture_view(&self) -> crate::picture::model::View {
        crate::picture::model::View {
            mode: self.mode,
            palette: self.palette,
            scale: self.picture,
            tone: Tone::Linear,
            stops: self.stops,
            ..Default::default()
        }
    }
}

/// Largest value but a few, for automatic scales.
pub fn typical_maximum(values: &[f64]) -> f64 {
    let mut lit: Vec<f64> = values.iter().copied().filter(|v| *v > 0.0).collect();
    if lit.is_empty() {
        return 1.0;
    }
    let k = ((lit.len() - 1) as f64 * 0.98) as usize;
    *lit.select_nth_unstable_by(k, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn years_have_their_days_and_months() {
        assert_eq!((steps_per_day(8760), steps_per_day(8784), steps_per_day(35040), steps_per_day(48)), (24, 24, 96, 24));
        let stamps = Stamp::common_year(8760);
        assert_eq!(stamps[24 * 31 + 12].text(), "1 February, 12:30");
        let m = months(&stamps, 24);
        assert_eq!((m.len(), m[0], m[11]), (12, ("Jan", 0), ("Dec", 334)));
    }

    #[test]
    fn the_worst_hour_is_the_first_of_the_largest_and_nights_do_not_count() {
        assert_eq!(worst(&[f64::NAN, 0.1, 0.7, 0.7, f64::NAN]), Some(2));
        assert_eq!(worst(&[f64::NAN]), None);
    }
}

//! What the Year panel shows for which state.

use crate::picture::model::{Mode, Tone};
use crate::results::Results;
use crate::scale::ScaleChoice;
use lucarne::glare::annual::GlareClass;
use lucarne::glare::index::dgps;
use lucarne::image::palette::{Palette, rounded_number};
use lucarne::matrix::Matrix;
use lucarne::simulate::results::glare::read::GlareYear;
use lucarne::simulate::year::Sensors;
use lucarne::weather::time::{Time, steps_per_day};
use std::sync::Arc;

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
        let group = |g: usize| results.sensors.get(g).map_or("?", |g| g.name.as_str());
        let view = |v: usize| results.glare.get(v).map_or_else(|| "?".to_string(), GlareYear::name);
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
        let matrix = |g: usize| lux.and_then(|l| l.get(g)).or_else(|| results.sensors.get(g).map(|g| &g.illuminance));
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
            Self::Class(v) => {
                results.glare.get(v).map_or_else(none, |g| g.class.iter().map(|c| c.map_or(f64::NAN, |c| f64::from(c as u8))).collect())
            }
        }
    }

    /// The standard error of its value in an hour, where the results tell it.
    pub fn error(self, results: &Results, hour: usize) -> Option<f64> {
        let found = match self {
            Self::Sensor(g, s) => {
                let errors = results.sensors.get(g)?.standard_error.as_ref().filter(|e| s < e.rows() && hour < e.cols())?;
                f64::from(errors.at(s, hour)[0])
            }
            Self::Dgp(v) => *results.glare.get(v)?.standard_error.get(hour)?,
            _ => return None,
        };
        (found > 0.0).then_some(found)
    }

    /// Its value at an hour in words, with its standard error.
    pub fn text(self, results: &Results, hour: usize, value: f64, error: Option<f64>) -> String {
        if value.is_nan() {
            return "–".into();
        }
        match self {
            Self::Sensor(..) | Self::Mean(_) => lux_text(value, error),
            Self::Simplified(..) => format!("DGPs {value:.3}"),
            Self::Dgp(v) => {
                let class = results.glare.get(v).and_then(|g| g.class[hour]).map_or("?", GlareClass::name);
                format!("DGP {value:.3}{}, {class}", error.map_or_else(String::new, |e| format!(" ± {e:.3}")))
            }
            Self::Class(_) => class_name(value).into(),
        }
    }

    /// Whether the results hold it for the computed state of the façade alone.
    pub fn is_stored_only(self) -> bool {
        matches!(self, Self::Dgp(_) | Self::Class(_))
    }
}

/// Name of a class by its place in [`GlareClass::ALL`].
pub fn class_name(class: f64) -> &'static str {
    if class.is_nan() { "?" } else { GlareClass::ALL.get(class as usize).map_or("?", |c| c.name()) }
}

/// An illuminance with its standard error.
pub fn lux_text(value: f64, error: Option<f64>) -> String {
    let error = error.map_or_else(String::new, |e| format!(" ± {}", rounded_number(e)));
    format!("{}{error} lx", rounded_number(value))
}

/// All hours that have a value, the highest first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ranking {
    hours: Vec<usize>,
    highest: f64,
    /// Hours that share the highest value.
    tied: usize,
}

impl Ranking {
    /// Hours by their values, and where these are the same by `then`: many hours have a DGP cut to 1.
    pub fn new(values: &[f64], then: &[f64]) -> Self {
        let key = |h: usize| (values[h], then.get(h).copied().filter(|v| !v.is_nan()).unwrap_or(f64::NEG_INFINITY));
        let mut hours: Vec<usize> = (0..values.len()).filter(|&h| !values[h].is_nan()).collect();
        // Stable: of the same the earliest is the first.
        hours.sort_by(|&a, &b| key(b).0.total_cmp(&key(a).0).then(key(b).1.total_cmp(&key(a).1)));
        let highest = hours.first().map_or(f64::NAN, |&h| values[h]);
        let tied = hours.iter().take_while(|&&h| values[h] == highest).count();
        Self { hours, highest, tied }
    }

    /// Hours of a quantity; glare that is cut to the same value by the light at the eye.
    pub fn of(quantity: Quantity, results: &Results, lux: Option<&[Arc<Matrix<f32>>]>) -> Self {
        let light = match quantity {
            Quantity::Dgp(v) | Quantity::Class(v) => results.glare.get(v).map(|g| g.illuminance.clone()),
            Quantity::Simplified(g, s) => Some(Quantity::Sensor(g, s).values(results, lux)),
            Quantity::Sensor(..) | Quantity::Mean(_) => None,
        };
        let values = match quantity {
            Quantity::Class(v) => Quantity::Dgp(v).values(results, lux),
            other => other.values(results, lux),
        };
        Self::new(&values, &light.unwrap_or_default())
    }

    /// The first hour.
    pub fn worst(&self) -> Option<usize> {
        self.hours.first().copied()
    }

    /// The hour that follows another one by so many places; the first one if the other has no place.
    pub fn beside(&self, hour: usize, places: isize) -> Option<usize> {
        let to = self.place(hour).map_or(0, |p| p.saturating_add_signed(places).min(self.hours.len() - 1));
        self.hours.get(to).copied()
    }

    /// Place of an hour, from 0.
    pub fn place(&self, hour: usize) -> Option<usize> {
        self.hours.iter().position(|&h| h == hour)
    }

    /// Where an hour stands, in words; the values are in this unit.
    pub fn text(&self, hour: usize, unit: &str) -> String {
        let place = self.place(hour).map_or_else(|| "no light".into(), |p| format!("{} of {}", p + 1, self.hours.len()));
        let (tied, highest) = (self.tied, self.highest);
        let tied = if tied > 1 { format!("; {tied} hours at {unit} {highest:.3}, in order of Ev") } else { String::new() };
        place + &tied
    }
}

/// What tells most about glare: what the carpet shows of it, else DGP of the first view, else
/// simplified DGP at the first sensor that faces sideways.
pub fn glare_quantity(results: &Results, shown: Quantity) -> Option<Quantity> {
    match shown {
        Quantity::Class(v) => return Some(Quantity::Dgp(v)),
        Quantity::Dgp(_) | Quantity::Simplified(..) => return Some(shown),
        Quantity::Sensor(..) | Quantity::Mean(_) => {}
    }
    if !results.glare.is_empty() {
        return Some(Quantity::Dgp(0));
    }
    let vertical = |g: &Sensors| g.directions.iter().position(|d| d.z.abs() < 0.5);
    results.sensors.iter().enumerate().find_map(|(i, g)| Some(Quantity::Simplified(i, vertical(g)?)))
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
        let noon = |s: &Time| (s.month, s.day) == (3, 21) && (11.4..12.6).contains(&s.hour);
        self.hour = results.times.iter().position(noon).unwrap_or(results.hours() / 2);
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
    fn of_hours_cut_to_the_same_dgp_the_brightest_is_the_worst() {
        let (none, light) = (f64::NAN, [0.0, 900.0, 21_300.0, 34_035.0, 20_000.0, 30_000.0]);
        let ranking = Ranking::new(&[none, 0.3, 1.0, 1.0, 0.99, 1.0], &light);
        assert_eq!((ranking.worst(), ranking.tied), (Some(3), 3));
        let mut passed = vec![3];
        while let Some(next) = ranking.beside(passed[passed.len() - 1], 1).filter(|h| !passed.contains(h)) {
            passed.push(next);
        }
        assert_eq!(passed, [3, 5, 2, 4, 1], "each once, nights left out");
        assert_eq!((ranking.beside(5, -1), ranking.beside(3, -1), ranking.beside(1, 1)), (Some(3), Some(3), Some(1)));
        assert_eq!(ranking.beside(0, 1), Some(3), "from the night to the worst");
        assert_eq!(ranking.text(5, "DGP"), "2 of 5; 3 hours at DGP 1.000, in order of Ev");
        // Without the light at the eye the earliest.
        assert_eq!(Ranking::new(&[none, 0.1, 0.7, 0.7], &[]).worst(), Some(2));
        let dark = Ranking::new(&[none], &[none]);
        assert_eq!((dark.worst(), dark.beside(0, 1)), (None, None));
    }
}

//! Numbers of sensors, with what noise makes of them.

use crate::metrics::{Estimated, Noise};
use crate::simulate::inputs::counting::{Column, Counting, MEAN};

/// The numbers of one sensor: of the result, and with the noise's errors put upon it.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorSample {
    /// By column.
    pub values: Vec<f64>,
    /// `[probe][column]`.
    pub probed: Vec<Vec<f64>>,
    /// `[draw][judged column]`.
    pub drawn: Vec<Vec<f64>>,
    /// Standard error that suns add to the mean, lx.
    pub sun: f64,
    /// Hours, of LM-83's, with more than 1000 lx of direct sun; the same with its standard error less and more. Absent
    /// where suns are not traced.
    pub sun_hours: Option<[f64; 3]>,
}

/// A row of illuminances and the directions of its errors.
#[derive(Clone)]
pub struct Row<'a> {
    /// lx by step.
    pub lux: Vec<f64>,
    /// As [`Noise::new`] lists them.
    pub directions: Vec<&'a [f32]>,
}

impl SensorSample {
    /// Counts everything of a sensor: its year, and its illuminance under the overcast sky (one step; NaN if unknown).
    pub fn new(counting: &Counting, noise: &Noise, year: &Row<'_>, overcast: &Row<'_>) -> Self {
        let dark = [f64::NAN];
        let sky = if overcast.lux.is_empty() { &dark[..] } else { &overcast.lux[..] };
        let number = |c: &Column, row: &[f64], sky: &[f64]| counting.number(c, row, sky[0]);
        let probe = |p: usize| {
            let (row, sky) = (noise.probe(p, &year.lux, &year.directions), noise.probe(p, sky, &overcast.directions));
            counting.columns.iter().map(|c| number(c, &row, &sky)).collect()
        };
        let draw = |d: usize| {
            let (row, sky) = (noise.draw(d, &year.lux, &year.directions), noise.draw(d, sky, &overcast.directions));
            counting.columns.iter().filter(|c| c.is_judged).map(|c| number(c, &row, &sky)).collect()
        };
        let draws = if counting.columns.iter().any(|c| c.is_judged) { noise.draws() } else { 0 };
        Self {
            values: counting.columns.iter().map(|c| number(c, &year.lux, sky)).collect(),
            probed: (0..noise.probes()).map(probe).collect(),
            drawn: (0..draws).map(draw).collect(),
            sun: 0.0,
            sun_hours: None,
        }
    }
}

/// Numbers of the sensors of one group, with their noise.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// What was counted.
    pub counting: &'a Counting,
    /// What could be made of it.
    pub noise: &'a Noise,
    /// Independent replicates; errors of sums know that of suns apart from theirs.
    pub replicates: usize,
}

impl Samples<'_> {
    /// A number of some sensors, from a column of each.
    pub fn of(&self, sensors: &[&SensorSample], column: usize, number: impl Fn(&[f64]) -> f64) -> Estimated {
        let value = number(&sensors.iter().map(|s| s.values[column]).collect::<Vec<_>>());
        let probed = |p: usize| number(&sensors.iter().map(|s| s.probed[p][column]).collect::<Vec<_>>());
        let probes = sensors.first().map_or(0, |s| s.probed.len());
        if self.is_linear(column) && self.replicates > 1 {
            // As if the suns' errors were the same at all sensors: no less than they are.
            let sun = number(&sensors.iter().map(|s| s.sun * self.per_lux(column)).collect::<Vec<_>>());
            let own = self.noise.standard_error(value, (0..self.replicates.min(probes)).map(probed));
            return Estimated { value, standard_error: own.hypot(sun) };
        }
        Estimated { value, standard_error: self.noise.standard_error(value, (0..probes).map(probed)) }
    }

    /// The numbers of one sensor, by column.
    pub fn sensor(&self, sensor: &SensorSample) -> Vec<Estimated> {
        (0..self.counting.columns.len()).map(|c| self.of(&[sensor], c, |v| v[0])).collect()
    }

    /// Whether a column is the mean of the year, or in proportion to it.
    fn is_linear(&self, column: usize) -> bool {
        use crate::metrics::Counted::{Exposure, Mean};
        use crate::simulate::inputs::counting::Time;
        let column = &self.counting.columns[column];
        matches!(column.counted, Mean | Exposure) && column.time == Time::All
    }

    fn per_lux(&self, column: usize) -> f64 {
        if self.counting.columns[column].name == MEAN { 1.0 } else { self.counting.all.hours / 1000.0 }
    }

    /// Place of a column among those that are judged.
    pub(super) fn judged(&self, column: usize) -> usize {
        self.counting.columns[..column].iter().filter(|c| c.is_judged).count()
    }
}

//! Metrics of a year that the sensors' colours show.

use lucarne::matrix::Matrix;
use lucarne::metrics::{AUTONOMY_LX, Clock, Counted, EXCEEDED_LX, FELL_SHORT_LX, Occupancy, Year, lm83};
use lucarne::weather::time::Time;

/// What the sensors' colours mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// Illuminance of the hour shown.
    Hour,
    /// Mean over all hours.
    Mean,
    /// Mean over occupied hours.
    MeanOccupied,
    /// Daylight autonomy: share of occupied hours with at least 300 lx.
    Autonomy,
    /// Continuous daylight autonomy: hours below 300 lx count in part.
    ContinuousAutonomy,
    /// Useful daylight illuminance: 100 to 3000 lx.
    Useful,
    /// Below 100 lx.
    UsefulFellShort,
    /// Above 3000 lx.
    UsefulExceeded,
}

impl Metric {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Hour,
        Self::Mean,
        Self::MeanOccupied,
        Self::Autonomy,
        Self::ContinuousAutonomy,
        Self::Useful,
        Self::UsefulFellShort,
        Self::UsefulExceeded,
    ];

    /// Name and what it means.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Hour => ("Illuminance of the hour", "The hour of the Year panel"),
            Self::Mean => ("Mean of all hours", "Day and night"),
            Self::MeanOccupied => ("Mean of occupied hours", "8:00 to 18:00 every day"),
            Self::Autonomy => ("Daylight autonomy DA300", "Share of occupied hours with at least 300 lx"),
            Self::ContinuousAutonomy => ("Continuous autonomy cDA300", "Hours below 300 lx count as the share they reach"),
            Self::Useful => ("Useful daylight UDI 100–3000", "Share of occupied hours between 100 and 3000 lx"),
            Self::UsefulFellShort => ("UDI fell short, below 100", "Share of occupied hours below 100 lx"),
            Self::UsefulExceeded => ("UDI exceeded, above 3000", "Share of occupied hours above 3000 lx"),
        }
    }

    /// Whether it is a share of occupied hours, 0…1.
    pub fn is_share(self) -> bool {
        !matches!(self, Self::Hour | Self::Mean | Self::MeanOccupied)
    }

    /// Values by sensor. Shares are 0…1.
    pub fn values(self, lux: &Matrix<f32>, times: &[Time], hour: usize) -> Vec<f64> {
        let year = Year::of_times(times);
        let time = if self == Self::Mean { Occupancy::always(&year) } else { Occupancy::lm83(&year, Clock::Standard) };
        let counted = match self {
            Self::Hour => return (0..lux.rows()).map(|s| f64::from(lux.row(s).get(hour).copied().unwrap_or(f32::NAN))).collect(),
            Self::Mean | Self::MeanOccupied => Counted::Mean,
            Self::Autonomy => Counted::AtLeast(AUTONOMY_LX),
            Self::ContinuousAutonomy => Counted::Continuous(AUTONOMY_LX),
            Self::Useful => Counted::Between(FELL_SHORT_LX, EXCEEDED_LX),
            Self::UsefulFellShort => Counted::Below(FELL_SHORT_LX),
            Self::UsefulExceeded => Counted::Above(EXCEEDED_LX),
        };
        let row = |s: usize| lux.row(s).iter().map(|v| f64::from(*v)).collect::<Vec<f64>>();
        (0..lux.rows()).map(|s| counted.of(&row(s), &time)).collect()
    }

    /// A value in words.
    pub fn text(self, value: f64) -> String {
        if value.is_nan() {
            "–".into()
        } else if self.is_share() {
            format!("{:.1} %", value * 100.0)
        } else {
            format!("{} lx", lucarne::image::palette::rounded_number(value))
        }
    }
}

/// DA300 spatial share of the sensors that `counts` admits, and their number; no share of none.
pub fn spatial_share(autonomy: &[f64], counts: impl Fn(usize) -> bool) -> (Option<f64>, usize) {
    let of_plan: Vec<f64> = autonomy.iter().enumerate().filter(|(i, _)| counts(*i)).map(|(_, a)| *a).collect();
    (lm83::spatial_share(&of_plan), of_plan.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn year(lux: impl Fn(usize, usize) -> f32) -> (Matrix<f32>, Vec<Time>) {
        let data = (0..2 * 8760).map(|k| lux(k / 8760, k % 8760)).collect();
        (Matrix::from_data(2, 8760, 1, data).unwrap(), Time::common_year(8760))
    }

    #[test]
    fn metrics_count_occupied_hours_only() {
        // 400 lx in the mornings, 200 lx in the afternoons, 5000 lx at night.
        let (lux, times) = year(|_, h| match h % 24 {
            8..13 => 400.0,
            13..18 => 200.0,
            _ => 5000.0,
        });
        let value = |m: Metric| m.values(&lux, &times, 9)[0];
        assert_eq!(value(Metric::Autonomy), 0.5);
        assert!((value(Metric::ContinuousAutonomy) - 5.0 / 6.0).abs() < 1e-12);
        assert_eq!((value(Metric::Useful), value(Metric::UsefulExceeded), value(Metric::UsefulFellShort)), (1.0, 0.0, 0.0));
        assert_eq!((value(Metric::MeanOccupied), value(Metric::Hour)), (300.0, 400.0));
        assert_eq!(spatial_share(&[0.5, 0.49, 1.0, 0.0], |_| true), (Some(0.5), 4));
        // A vertical sensor beside 15 desks, of which 12 reach it, does not make 81.2 % of 80 %.
        let desks: Vec<f64> = (0..16).map(|i| if (12..15).contains(&i) { 0.2 } else { 0.9 }).collect();
        assert_eq!(spatial_share(&desks, |i| i < 15), (Some(0.8), 15));
        assert_eq!(spatial_share(&desks, |_| false), (None, 0));
    }
}

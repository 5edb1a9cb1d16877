//! What is counted at one sensor over a year.

use super::occupancy::Occupancy;

/// Illuminance of daylight autonomy, lx.
pub const AUTONOMY_LX: f64 = 300.0;
/// Below it daylight is of no use, lx (UDI).
pub const FELL_SHORT_LX: f64 = 100.0;
/// Above it there is too much, lx (UDI).
pub const EXCEEDED_LX: f64 = 3000.0;

/// A number made of a sensor's illuminances in the steps that count.
///
/// Sources: daylight autonomy, C. F. Reinhart and O. Walkenhorst, Energy and Buildings 33 (2001); continuous, Z. Rogers,
/// "Daylighting metric development using daylight autonomy calculations in the sensor placement optimization tool" (2006);
/// useful daylight, A. Nabil and J. Mardaljevic, Energy and Buildings 38 (2006), in the four bands of J. Mardaljevic et al.,
/// "Daylighting, artificial lighting and non-visual effects study for a residential building" (2012); light exposure,
/// CIE 157:2004.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Counted {
    /// Mean, lx.
    Mean,
    /// Light exposure: sum over the time, klx·h.
    Exposure,
    /// Share of the time with at least so many lx, 0…1: daylight autonomy.
    AtLeast(f64),
    /// The same, but time below counts by the share of it that is reached: continuous daylight autonomy.
    Continuous(f64),
    /// Share of the time below so many lx: UDI fell short.
    Below(f64),
    /// Share of the time from the first, but below the second: UDI supplementary.
    From(f64, f64),
    /// Share of the time from the first to the second, both with it: UDI autonomous, useful daylight.
    Between(f64, f64),
    /// Share of the time above so many lx: UDI exceeded, thresholds of vertical illuminance.
    Above(f64),
}

impl Counted {
    /// The number for a row of illuminances, lx by step; 0 where no step counts.
    pub fn of(self, row: &[f64], time: &Occupancy) -> f64 {
        let count = time.steps.len().max(1) as f64;
        let mean = |f: &dyn Fn(f64) -> f64| time.steps.iter().map(|s| f(row[*s])).sum::<f64>() / count;
        let share = |f: &dyn Fn(f64) -> bool| time.steps.iter().filter(|s| f(row[**s])).count() as f64 / count;
        match self {
            Self::Mean => mean(&|v| v),
            Self::Exposure => mean(&|v| v) * time.hours / 1000.0,
            Self::AtLeast(lux) => share(&|v| v >= lux),
            Self::Continuous(lux) => mean(&|v| (v / lux).min(1.0)),
            Self::Below(lux) => share(&|v| v < lux),
            Self::From(low, high) => share(&|v| v >= low && v < high),
            Self::Between(low, high) => share(&|v| v >= low && v <= high),
            Self::Above(lux) => share(&|v| v > lux),
        }
    }

    /// Whether it is a share of the time, 0…1.
    pub fn is_share(self) -> bool {
        !matches!(self, Self::Mean | Self::Exposure)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Year;
    use super::*;

    #[test]
    fn limits_belong_to_one_side() {
        let time = Occupancy { name: String::new(), steps: vec![0, 1, 2, 3, 4, 5], hours: 6.0 };
        let row = [0.0, 99.9, 100.0, 300.0, 3000.0, 3000.1, 1e6];
        let of = |c: Counted| c.of(&row, &time) * 6.0;
        assert_eq!(of(Counted::Below(100.0)), 2.0, "100 lx is not below 100 lx");
        assert_eq!(of(Counted::From(100.0, 300.0)), 1.0);
        assert_eq!(of(Counted::Between(300.0, 3000.0)), 2.0);
        assert_eq!(of(Counted::Above(3000.0)), 1.0, "3000 lx is not above 3000 lx");
        assert_eq!(of(Counted::Between(100.0, 3000.0)), 3.0);
        assert_eq!(of(Counted::AtLeast(300.0)), 3.0, "300 lx is at least 300 lx");
        assert!((of(Counted::Continuous(300.0)) - (99.9 / 300.0 + 1.0 / 3.0 + 3.0)).abs() < 1e-12);
        assert!((of(Counted::Mean) / 6.0 - 6500.0 / 6.0).abs() < 1e-9, "the last step does not count");
        assert!((Counted::Exposure.of(&row, &time) - 6.5).abs() < 1e-12, "6500 lx·h");
    }

    #[test]
    fn exposure_does_not_depend_on_the_length_of_a_step() {
        let year = Year::common();
        let all = Occupancy::always(&year);
        assert!((Counted::Exposure.of(&[50.0; 8760], &all) - 438.0).abs() < 1e-9, "50 lx all year: 438 klx·h");
        let quarters = Year { length: 0.25, steps: year.steps.iter().flat_map(|s| [*s; 4]).collect() };
        assert!((Counted::Exposure.of(&[50.0; 35040], &Occupancy::always(&quarters)) - 438.0).abs() < 1e-9);
        assert_eq!(Counted::AtLeast(300.0).of(&[1.0], &Occupancy { name: String::new(), steps: vec![], hours: 0.0 }), 0.0);
    }
}

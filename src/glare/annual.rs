//! A year of DGP in a few numbers.

use crate::error::{Error, Result};

/// Upper DGP of the classes imperceptible, perceptible and disturbing.
pub const CLASS_LIMITS: [f64; 3] = [0.35, 0.40, 0.45];

/// How people find a view (J. Wienold, Building Simulation 2009).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum GlareClass {
    /// DGP up to 0.35.
    Imperceptible,
    /// Up to 0.40.
    Perceptible,
    /// Up to 0.45.
    Disturbing,
    /// Above.
    Intolerable,
}

impl GlareClass {
    /// All classes, the lowest DGP first.
    pub const ALL: [Self; 4] = [Self::Imperceptible, Self::Perceptible, Self::Disturbing, Self::Intolerable];

    /// The class of a DGP; a limit belongs to the class below it.
    pub fn of(dgp: f64) -> Self {
        match CLASS_LIMITS.iter().position(|&limit| dgp <= limit) {
            Some(0) => Self::Imperceptible,
            Some(1) => Self::Perceptible,
            Some(_) => Self::Disturbing,
            None => Self::Intolerable,
        }
    }

    /// The word for it, as files and tables use it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Imperceptible => "imperceptible",
            Self::Perceptible => "perceptible",
            Self::Disturbing => "disturbing",
            Self::Intolerable => "intolerable",
        }
    }

    /// The class that a file names.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }
}

/// Protection from glare by EN 17037, annex E: the DGP that no more than 5 % of the occupied hours exceed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum GlareProtection {
    /// More than 0.45.
    None,
    /// Up to 0.45.
    Minimum,
    /// Up to 0.40.
    Medium,
    /// Up to 0.35.
    High,
}

impl GlareProtection {
    /// The class of the DGP exceeded in 5 % of the occupied hours.
    pub fn of(dgp_exceeded: f64) -> Self {
        match GlareClass::of(dgp_exceeded) {
            GlareClass::Imperceptible => Self::High,
            GlareClass::Perceptible => Self::Medium,
            GlareClass::Disturbing => Self::Minimum,
            GlareClass::Intolerable => Self::None,
        }
    }

    /// The word for it, as files and tables use it.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Minimum => "minimum",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// Annual glare of one view over its occupied hours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AnnualGlare {
    /// Occupied hours.
    pub hours: f64,
    /// Hours in each [`GlareClass`], from imperceptible to intolerable.
    pub hours_in_class: [f64; 4],
    /// The least DGP that no more than 5 % of the occupied hours exceed.
    pub dgp_exceeded: f64,
    /// EN 17037's class of it.
    pub protection: GlareProtection,
    /// Share of the occupied hours with DGP ≤ 0.40 (N. L. Jones, "Fast climate-based glare analysis
    /// and spatial mapping", Building Simulation 2019).
    pub glare_autonomy: f64,
    /// Mean DGP.
    pub mean_dgp: f64,
    /// Greatest DGP.
    pub greatest_dgp: f64,
}

/// Share of the occupied hours that may exceed EN 17037's limits.
const MAY_EXCEED: f64 = 0.05;

impl AnnualGlare {
    /// Summary of one view's DGP at every time step of `step` hours. `occupied` chooses the steps that
    /// count. Night counts as occupied time without glare if it is given with its low DGP.
    ///
    /// # Errors
    /// If the lengths differ, no step is occupied, or a DGP is not between 0 and 1.
    pub fn new(dgp: &[f64], occupied: &[bool], step: f64) -> Result<Self> {
        if dgp.len() != occupied.len() {
            return Err(Error::new(format!("{} hours of DGP do not match {} hours of occupancy", dgp.len(), occupied.len())));
        }
        if let Some(hour) = dgp.iter().position(|d| !(0.0..=1.0).contains(d)) {
            return Err(Error::new(format!("hour {hour}: {} is not a DGP between 0 and 1", dgp[hour])));
        }
        let mut counted: Vec<f64> = dgp.iter().zip(occupied).filter(|&(_, &o)| o).map(|(&d, _)| d).collect();
        if counted.is_empty() {
            return Err(Error::new("no hour is occupied").help("check the schedule"));
        }
        counted.sort_unstable_by(f64::total_cmp);
        let count = counted.len();
        let mut in_class = [0usize; 4];
        counted.iter().for_each(|&d| in_class[GlareClass::of(d) as usize] += 1);
        let dgp_exceeded = counted[count - 1 - (MAY_EXCEED * count as f64 + 1e-9) as usize];
        Ok(Self {
            hours: count as f64 * step,
            hours_in_class: in_class.map(|n| n as f64 * step),
            dgp_exceeded,
            protection: GlareProtection::of(dgp_exceeded),
            glare_autonomy: (in_class[0] + in_class[1]) as f64 / count as f64,
            mean_dgp: counted.iter().sum::<f64>() / count as f64,
            greatest_dgp: counted[count - 1],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_meet_at_their_limits() {
        for (dgp, class, protection) in [
            (0.0, GlareClass::Imperceptible, GlareProtection::High),
            (0.35, GlareClass::Imperceptible, GlareProtection::High),
            (0.350_01, GlareClass::Perceptible, GlareProtection::Medium),
            (0.40, GlareClass::Perceptible, GlareProtection::Medium),
            (0.45, GlareClass::Disturbing, GlareProtection::Minimum),
            (0.450_01, GlareClass::Intolerable, GlareProtection::None),
            (1.0, GlareClass::Intolerable, GlareProtection::None),
        ] {
            assert_eq!(GlareClass::of(dgp), class);
            assert_eq!(GlareProtection::of(dgp), protection);
            assert_eq!(GlareClass::from_name(class.name()), Some(class));
        }
        assert_eq!(GlareClass::from_name("x"), None);
    }

    #[test]
    fn five_percent_of_the_occupied_hours_may_exceed() {
        // 100 occupied hours of which exactly 5 are intolerable: the class is that of the sixth.
        let mut dgp = vec![0.3; 90];
        dgp.extend([0.38; 5]);
        dgp.extend([0.7; 5]);
        let year = AnnualGlare::new(&dgp, &[true; 100], 1.0).unwrap();
        assert_eq!((year.hours_in_class, year.dgp_exceeded, year.protection), ([90.0, 5.0, 0.0, 5.0], 0.38, GlareProtection::Medium));
        assert!((year.glare_autonomy - 0.95).abs() < 1e-12);
        dgp[0] = 0.7;
        assert_eq!(AnnualGlare::new(&dgp, &[true; 100], 1.0).unwrap().protection, GlareProtection::None);
        // Hours without people do not count.
        let occupied: Vec<bool> = dgp.iter().map(|&d| d < 0.5).collect();
        let year = AnnualGlare::new(&dgp, &occupied, 1.0).unwrap();
        assert_eq!((year.hours, year.protection), (94.0, GlareProtection::Medium));
        assert!((year.greatest_dgp - 0.38).abs() < 1e-12);
    }

    #[test]
    fn shares_are_the_same_in_shorter_steps_and_hours_are_hours() {
        let dgp = [0.3, 0.38, 0.42, 0.7, 0.3, 0.3, 0.9, 0.3];
        let (whole, quarters) = [1.0, 0.25].map(|step| AnnualGlare::new(&dgp, &[true; 8], step).unwrap()).into();
        assert_eq!((whole.hours, whole.hours_in_class), (8.0, [4.0, 1.0, 1.0, 2.0]));
        assert_eq!((quarters.hours, quarters.hours_in_class), (2.0, [1.0, 0.25, 0.25, 0.5]));
        assert_eq!((quarters.dgp_exceeded, quarters.glare_autonomy), (whole.dgp_exceeded, whole.glare_autonomy));
    }

    #[test]
    fn faulty_input_is_named() {
        assert!(AnnualGlare::new(&[0.2], &[], 1.0).is_err());
        assert!(AnnualGlare::new(&[0.2], &[false], 1.0).unwrap_err().message().contains("occupied"));
        assert!(AnnualGlare::new(&[0.2, f64::NAN], &[true, true], 1.0).unwrap_err().message().contains("hour 1"));
        assert_eq!(AnnualGlare::new(&[0.2], &[true], 1.0).unwrap().dgp_exceeded, 0.2);
    }
}

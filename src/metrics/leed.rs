//! LEED v4.1 BD+C, credit Daylight, for new construction: options 1 and 2.

use super::share_of;

/// The rating system.
pub const SOURCE: &str = "LEED v4.1 BD+C, EQ Daylight";

/// Shares that bring 1, 2 and 3 points by option 1.
const OPTION_1: [f64; 3] = [0.40, 0.55, 0.75];
/// The same by option 2.
const OPTION_2: [f64; 3] = [0.55, 0.75, 0.90];
/// ASE above which it must be explained in writing how the space addresses glare.
pub const ASE_TO_EXPLAIN: f64 = 0.10;
/// What option 2 asks for at both hours, lx.
const LUX: std::ops::RangeInclusive<f64> = 300.0..=3000.0;

fn points(share: f64, limits: [f64; 3]) -> u8 {
    limits.iter().filter(|limit| share >= **limit).count() as u8
}

/// Points of option 1 by the average sDA300/50% of the regularly occupied floor area, and the sDA of each space: one more,
/// but no more than three, if every space has at least 55 %.
pub fn option_1(average: f64, spaces: &[f64]) -> u8 {
    let every = !spaces.is_empty() && spaces.iter().all(|s| *s >= OPTION_1[1]);
    (points(average, OPTION_1) + u8::from(every)).min(3)
}

/// What ASE asks for beside the points: nothing, or the explanation that is due above 10 %.
pub fn explanation(ase: f64) -> Option<&'static str> {
    (ase > ASE_TO_EXPLAIN).then_some("ASE is above 10 %: explain in writing how the space is designed to address glare")
}

/// The share of sensors with 300 to 3000 lx at 9:00 and at 15:00 of a clear day at the equinox, from the illuminances of
/// both, lx by sensor. Blinds that keep the view would need the lower limit alone.
///
/// # Panics
/// If the two have not as many sensors.
pub fn share_at_both(morning: &[f64], afternoon: &[f64]) -> Option<f64> {
    assert_eq!(morning.len(), afternoon.len(), "the same sensors at both hours");
    let pairs: Vec<_> = morning.iter().zip(afternoon).collect();
    share_of(&pairs, |(a, b)| LUX.contains(a) && LUX.contains(b))
}

/// Points of option 2.
pub fn option_2(share: f64) -> u8 {
    points(share, OPTION_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_those_of_the_tables() {
        let one = |average: f64| option_1(average, &[0.2]);
        assert_eq!([0.399, 0.40, 0.549, 0.55, 0.749, 0.75, 1.0].map(one), [0, 1, 1, 2, 2, 3, 3]);
        assert_eq!((option_1(0.6, &[0.55, 0.65]), option_1(0.6, &[0.549, 0.65]), option_1(0.8, &[0.8])), (3, 2, 3));
        assert_eq!([0.549, 0.55, 0.75, 0.899, 0.90].map(option_2), [0, 1, 2, 2, 3]);
        assert_eq!((explanation(0.10), explanation(0.101).is_some()), (None, true));
    }

    #[test]
    fn both_hours_count() {
        let share = share_at_both(&[300.0, 3000.0, 299.0, 500.0, 400.0], &[3000.0, 300.0, 500.0, 3001.0, 400.0]);
        assert_eq!(share, Some(0.6));
        assert_eq!(share_at_both(&[], &[]), None);
    }
}

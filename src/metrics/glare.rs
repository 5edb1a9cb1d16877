//! Glare of many views over the year: sGA and sDG, EN 17037's protection with its noise, and thresholds of vertical
//! illuminance that need no view.

use super::noise::Decision;
use super::share_of;
use crate::glare::index::dgps;
use crate::statistics::student_95;

/// DGP above which a view glares for sDG: disturbing (Solemma's sDG; J. A. Jakubiec and C. F. Reinhart 2012).
pub const DISTURBING: f64 = 0.38;
/// DGP above which it does for sGA (N. L. Jones, Building Simulation 2019).
pub const PERCEPTIBLE: f64 = 0.40;
/// Share of the occupied time in which a view may glare.
pub const TIME: f64 = 0.05;

/// The share of views that glare in no more than 5 % of the occupied time, from the share of that time with DGP above
/// 0.40 of each view: spatial glare autonomy, sGA.
pub fn spatial_autonomy(time: &[f64]) -> Option<f64> {
    share_of(time, |t| *t <= TIME)
}

/// The share of views that disturb in more than 5 % of the occupied time, from the share of that time with DGP above
/// 0.38 of each view: spatial disturbing glare, sDG.
pub fn spatial_disturbing(time: &[f64]) -> Option<f64> {
    share_of(time, |t| *t > TIME)
}

/// The share of the steps that count with a DGP above a limit; 0 of none.
pub fn time_above(dgp: &[f64], counts: &[bool], limit: f64) -> f64 {
    let counted: Vec<f64> = dgp.iter().zip(counts).filter(|(_, c)| **c).map(|(d, _)| *d).collect();
    share_of(&counted, |d| *d > limit).unwrap_or(0.0)
}

/// Factors of the standard errors by which a whole year of DGP is moved up and down to judge it again: the middles of so
/// many equal parts of Student's distribution, of the factor `confidence_95`. That all hours err the same way is the most
/// that their sum can err.
pub fn shifts(confidence_95: f64) -> [f64; 40] {
    let parts = 40;
    std::array::from_fn(|i| {
        let p = (i as f64 + 0.5) / f64::from(parts);
        // The normal quantile, stretched to the factor that is known.
        normal_quantile(p) * confidence_95 / student_95(1_000_000)
    })
}

/// A class judged of a year of DGP, and again of the year moved by its errors. Errors that are not known count as none.
pub fn decide<C: PartialEq>(dgp: &[f64], errors: &[f64], confidence_95: f64, class: impl Fn(&[f64]) -> C) -> Decision<C> {
    let moved = shifts(confidence_95).map(|shift| {
        let move_by = |(d, e): (&f64, &f64)| if e.is_finite() { (d + shift * e).clamp(0.0, 1.0) } else { *d };
        class(&dgp.iter().zip(errors).map(move_by).collect::<Vec<f64>>())
    });
    Decision::new(class(dgp), moved.into_iter())
}

/// Vertical illuminance at the eye at which the simplified DGPs is so much, lx. DGPs knows no view: a sensor that faces as
/// the eye does is enough.
pub fn vertical_lux(limit: f64) -> f64 {
    let (zero, slope) = (dgps(0.0), dgps(1.0) - dgps(0.0));
    (limit - zero) / slope
}

/// Quantile of the normal distribution (Abramowitz and Stegun 26.2.23: to 4.5e-4).
fn normal_quantile(p: f64) -> f64 {
    let t = (-2.0 * p.min(1.0 - p).ln()).sqrt();
    let z = t - (2.515_517 + 0.802_853 * t + 0.010_328 * t * t) / (1.0 + 1.432_788 * t + 0.189_269 * t * t + 0.001_308 * t * t * t);
    if p < 0.5 { -z } else { z }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_percent_is_no_glare_for_both() {
        assert_eq!(spatial_autonomy(&[0.05, 0.0501, 0.0, 1.0]), Some(0.5));
        assert_eq!(spatial_disturbing(&[0.05, 0.0501, 0.0, 1.0]), Some(0.5));
        let mut dgp = vec![0.2; 100];
        dgp[..5].fill(0.381);
        dgp[5..9].fill(0.38);
        assert_eq!((time_above(&dgp, &[true; 100], DISTURBING), time_above(&dgp, &[true; 100], PERCEPTIBLE)), (0.05, 0.0));
        let counts: Vec<bool> = (0..100).map(|i| i < 10).collect();
        assert_eq!((time_above(&dgp, &counts, DISTURBING), time_above(&dgp, &[false; 100], DISTURBING)), (0.5, 0.0));
        assert_eq!((spatial_autonomy(&[]), spatial_disturbing(&[])), (None, None));
    }

    #[test]
    fn vertical_illuminance_has_the_thresholds_of_dgps() {
        for (limit, lux) in [(0.35, 2669.0), (0.40, 3473.0), (0.45, 4277.0)] {
            assert!((vertical_lux(limit) - lux).abs() < 1.0, "{limit}: {}", vertical_lux(limit));
            assert!((dgps(vertical_lux(limit)) - limit).abs() < 1e-12);
        }
    }

    #[test]
    fn a_class_near_its_limit_is_undecided() {
        let class = |dgp: &[f64]| dgp[0] > 0.35;
        let of = |dgp: f64| decide(&[dgp], &[0.01], 1.96, class);
        assert!((of(0.3501).probability_of_another - 0.5).abs() < 0.03 && of(0.3501).is_undecided());
        assert!((of(0.36).probability_of_another - 0.16).abs() < 0.03, "a standard error away");
        assert_eq!((of(0.38).probability_of_another, of(0.38).is_undecided()), (0.0, false));
        assert!(decide(&[0.36], &[0.01], 4.3, class).probability_of_another > 0.25, "little is known of an error from few replicates");
        assert_eq!(decide(&[0.3501], &[f64::NAN], 1.96, class).probability_of_another, 0.0);
    }
}

//! Errors of means.

/// Variance of the mean of independent values; 0 of a single one, which is exact.
pub(crate) fn variance_of_mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count() as f64;
    if n < 2.0 {
        return 0.0;
    }
    let mean = values.clone().sum::<f64>() / n;
    values.map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))
}

/// The factor of Student's distribution: a mean of normal values with `freedom` degrees of freedom
/// lies within so many of its standard errors of the truth in 95 % of cases. Two-sided quantiles
/// (Abramowitz and Stegun 1964, table 26.10) up to 10, then Fisher's expansion about the normal
/// distribution (ibid. 26.7.5), which differs by less than 1e-4 there.
pub(crate) fn student_95(freedom: usize) -> f64 {
    const FEW: [f64; 10] = [12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281];
    match freedom {
        0 => f64::INFINITY,
        1..=10 => FEW[freedom - 1],
        _ => {
            let (x, n) = (1.959_964f64, freedom as f64);
            let g1 = (x.powi(3) + x) / 4.0;
            let g2 = (5.0 * x.powi(5) + 16.0 * x.powi(3) + 3.0 * x) / 96.0;
            let g3 = (3.0 * x.powi(7) + 19.0 * x.powi(5) + 17.0 * x.powi(3) - 15.0 * x) / 384.0;
            x + g1 / n + g2 / (n * n) + g3 / n.powi(3)
        }
    }
}

/// By what a variance with so many degrees of freedom is multiplied to be exceeded by the true one in one
/// case of ten: the freedom over the tenth percentile of χ² (Wilson and Hilferty 1931).
pub(crate) fn upper_variance(freedom: f64) -> f64 {
    let a = 2.0 / (9.0 * freedom.max(1.0));
    (1.0 - a - 1.281_552 * a.sqrt()).max(0.25).powi(-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn students_factors_are_those_of_the_tables() {
        for (freedom, wanted) in [(1, 12.706), (7, 2.365), (11, 2.201), (15, 2.131), (30, 2.042), (120, 1.980), (100_000, 1.960)] {
            assert!((student_95(freedom) - wanted).abs() < 6e-4, "{freedom}: {}", student_95(freedom));
        }
    }

    #[test]
    fn upper_variances_are_those_of_the_tables() {
        // χ² of 7, 28, 100 degrees: tenth percentiles 2.833, 18.94, 82.36.
        for (freedom, percentile) in [(7.0, 2.833), (28.0, 18.939), (100.0, 82.358)] {
            assert!((upper_variance(freedom) * percentile / freedom - 1.0).abs() < 3e-3, "{freedom}: {}", upper_variance(freedom));
        }
    }
}

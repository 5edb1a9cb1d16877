//! Comparison of traced matrices with the f64 reference, by their standard errors.

use super::TracedMatrix;
use super::reference::Estimate;

/// Chi-square-like comparison of a traced row with the reference: the deviations in units of their
/// combined standard errors must be spread as noise is. Bins too rare for a normal distribution
/// are compared in sum only. The error tells what is off.
pub fn agrees(traced: &TracedMatrix, row: usize, reference: &[[Estimate; 3]], samples: usize) -> Result<String, String> {
    let (mut squares, mut count, mut worst) = (0.0, 0, 0.0f64);
    let (mut sum, mut sum_reference, mut variance) = (0.0, 0.0, 0.0);
    for (bin, estimate) in reference.iter().enumerate() {
        for (c, estimate) in estimate.iter().enumerate() {
            let value = f64::from(traced.total.at(row, bin)[c]);
            let error = f64::from(traced.standard_error.at(row, bin)[c]).hypot(estimate.standard_error(samples));
            sum += value;
            sum_reference += estimate.mean(samples);
            variance += error * error;
            // `!` so that NaN counts as different.
            if !(estimate.mean(samples) * samples as f64 <= 100.0) {
                let z = (value - estimate.mean(samples)) / error;
                squares += z * z;
                worst = if z.abs() <= worst { worst } else { z.abs() };
                count += 1;
            }
        }
    }
    if count < 2 {
        return Err(format!("only {count} entries can be compared"));
    }
    let mean_square = squares / f64::from(count);
    let found = format!("{count} entries, mean z² {mean_square:.2}, worst |z| {worst:.1}, sums {sum:.5} {sum_reference:.5}");
    let sound = mean_square < 1.8 && worst < 7.0 && (sum - sum_reference).abs() < 5.0 * variance.sqrt();
    if sound { Ok(found) } else { Err(found) }
}

/// As [`agrees`], for tests.
pub fn assert_agrees(what: &str, traced: &TracedMatrix, row: usize, reference: &[[Estimate; 3]], samples: usize) {
    match agrees(traced, row, reference, samples) {
        Ok(found) => println!("{what}: {found}"),
        Err(found) => panic!("{what}: {found}"),
    }
}

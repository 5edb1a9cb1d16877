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
        // The channels of a bin err together.
        let mut bin_error = 0.0;
        for (c, estimate) in estimate.iter().enumerate() {
            let value = f64::from(traced.total.at(row, bin)[c]);
            let error = f64::from(traced.standard_error.at(row, bin)[c]).hypot(estimate.standard_error(samples));
            sum += value;
            sum_reference += estimate.mean(samples);
            bin_error += error;
            // `!` so that NaN counts as different.
            if !(estimate.mean(samples) * samples as f64 <= 100.0) {
                let z = (value - estimate.mean(samples)) / error;
                squares += z * z;
                worst = if z.abs() <= worst { worst } else { z.abs() };
                count += 1;
            }
        }
        variance += bin_error * bin_error;
    }
    // Entries too rare to be compared one by one leave the sum.
    let count = f64::from(count).max(1.0);
    let mean_square = squares / count;
    let found = format!(
        "{count} entries, mean z² {mean_square:.2}, worst |z| {worst:.1}, sums {sum:.5} {sum_reference:.5} ± {:.5}",
        variance.sqrt()
    );
    // Standard errors of eight batches make z² a little larger than 1 (1.4 where they dominate), and
    // few entries, of which three channels go together, spread it.
    let sound = mean_square < 1.4 + 2.5 * (6.0 / count).sqrt() && worst < 7.0 && (sum - sum_reference).abs() <= 5.0 * variance.sqrt();
    if sound { Ok(found) } else { Err(found) }
}

/// As [`agrees`], for tests.
pub(crate) fn assert_agrees(what: &str, traced: &TracedMatrix, row: usize, reference: &[[Estimate; 3]], samples: usize) {
    match agrees(traced, row, reference, samples) {
        Ok(found) => println!("{what}: {found}"),
        Err(found) => panic!("{what}: {found}"),
    }
}

//! What few hits leave open.
//!
//! The spread of batches knows of a contribution only by the samples that found it. Of n samples of weight w
//! that k hits are among, the contribution is known to w √(k + ½) / n (Jeffreys' prior of a Poisson
//! process): where there was no hit at all, it may still be as large as half a hit or two. The half that
//! the spread lacks is put upon the batches as deviations that add up to nothing, so that whatever is
//! computed from them carries it; of several rounds the first alone has it, since it falls as 1/n.

use super::stream_seed;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Hits from which their own spread is enough: half of one more is 1 % of their error then.
pub(crate) const ENOUGH_HITS: f64 = 32.0;

const GRID: f64 = (1u64 << 40) as f64;

/// Parts whose doubts are independent of each other. More, from [`Part::OTHERS`] on, share what patterns
/// there are.
pub(crate) struct Part;

impl Part {
    /// Reflections that a sensor's paths find.
    pub(crate) const REFLECTIONS: usize = 0;
    /// Windows behind what hides them.
    pub(crate) const WINDOWS: usize = 1;
    /// Light paths of which few arrive.
    pub(crate) const GATHERED: usize = 2;
    /// Single bins and windows.
    pub(crate) const OTHERS: usize = 3;
}

/// Deviations of batches that add up to 0 and give their mean a standard error of 1. Those of different
/// parts are orthogonal as far as there are batches (cosines of the discrete cosine transform); beyond that
/// their signs are as good as random, so that the squares add up and not the errors.
pub(crate) fn pattern(part: usize, batches: usize) -> Vec<f64> {
    let frequency = (1 + part % (batches - 1)) as f64;
    let sign = if stream_seed(part as u32, 0, 0x646f_7562) & 1 == 0 { 1.0 } else { -1.0 };
    let scale = sign * (2.0 * (batches - 1) as f64).sqrt();
    // Rounded, so that opposite ones are so in every bit and nothing is left of their sum.
    let value = |b: usize| (scale * (PI * frequency * (b as f64 + 0.5) / batches as f64).cos() * GRID).round() / GRID;
    (0..batches).map(value).collect()
}

/// Standard deviation of half a hit among so many samples.
pub(crate) fn half_a_hit(weight: f64, samples: f64) -> f64 {
    FRAC_1_SQRT_2 * weight / samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::view_matrix::mean_and_error;

    #[test]
    fn patterns_have_no_mean_an_error_of_one_and_do_not_add_up() {
        for batches in [2, 3, 4, 8, 25] {
            for part in 0..5 {
                let (mean, error) = mean_and_error(&pattern(part, batches));
                assert!(mean.abs() < 1e-11 && (error - 1.0).abs() < 1e-11, "{batches} {part}: {mean} {error}");
            }
        }
        let (a, b) = (pattern(Part::REFLECTIONS, 8), pattern(Part::OTHERS, 8));
        assert!(a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>().abs() < 1e-10);
        // Of 400 bins together: √400, not 400.
        let all: Vec<Vec<f64>> = (0..400).map(|bin| pattern(Part::OTHERS + bin, 8)).collect();
        let sums: Vec<f64> = (0..8).map(|batch| all.iter().map(|p| p[batch]).sum()).collect();
        let error = mean_and_error(&sums).1;
        assert!((10.0..30.0).contains(&error), "{error}");
    }
}

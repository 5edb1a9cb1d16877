//! What noise could make of a metric.
//!
//! Illuminances of different hours err together, through V and D. So their error is put upon the whole row at once:
//! replicate by replicate, as the sampling gave it. A standard error is the spread of what a metric becomes so; a class is
//! judged again under many draws of the same spread, and the share of draws in which it is another is the probability that
//! noise changes it. With few replicates the spread is itself uncertain: draws follow Student's distribution.

use crate::random::Random;
use crate::statistics::student_95;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Above this probability of another class a class is undecided within noise.
pub const UNDECIDED: f64 = 0.05;

/// Draws that classes are judged by.
const DRAWS: usize = 100;

/// An error put upon a row: by how much of each direction.
#[derive(Debug, Clone, PartialEq)]
struct Change {
    weights: Vec<f64>,
    /// Its part in the variance.
    share: f64,
}

/// Errors that the illuminances may have: directions in which they err together, and how far.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    probes: Vec<Change>,
    draws: Vec<Change>,
}

impl Noise {
    /// Noise whose directions are the deviations of so many independent replicates from their mean (fewer than 2: there
    /// are none) and, if `standard_errors`, one more: standard errors, as if all went up or down together, so that
    /// counts of hours err no less than they do. `confidence_95`: Student's factor of the replicates.
    pub fn new(replicates: usize, standard_errors: bool, confidence_95: f64) -> Self {
        let replicates = if replicates < 2 { 0 } else { replicates };
        let directions = replicates + usize::from(standard_errors);
        let only = |direction: usize, weight: f64, share: f64| {
            let mut weights = vec![0.0; directions];
            weights[direction] = weight;
            Change { weights, share }
        };
        // A deviation over √(R − 1) is an error as large as that of the mean.
        let step = 1.0 / (replicates.max(2) as f64 - 1.0).sqrt();
        let mut probes: Vec<Change> = (0..replicates).map(|r| only(r, step, 1.0 / replicates as f64)).collect();
        if standard_errors {
            probes.extend([-1.0, 1.0].map(|side| only(replicates, side, 0.5)));
        }
        let mut random = Random(17037);
        let freedom = freedom(confidence_95);
        let mut draws = Vec::new();
        while directions > 0 && draws.len() < DRAWS {
            let squares: f64 = (0..freedom).map(|_| normal(&mut random).powi(2)).sum();
            let student = (freedom as f64 / squares).sqrt();
            let of = |direction: usize, z: f64| if direction < replicates { z * step / (replicates as f64).sqrt() } else { z };
            let weights: Vec<f64> = (0..directions).map(|d| of(d, student * normal(&mut random))).collect();
            // In pairs, so that no side is preferred.
            draws.push(Change { weights: weights.iter().map(|w| -w).collect(), share: 0.0 });
            draws.push(Change { weights, share: 0.0 });
        }
        Self { probes, draws }
    }

    /// Changes that standard errors are made of.
    pub fn probes(&self) -> usize {
        self.probes.len()
    }

    /// Draws that classes are judged by.
    pub fn draws(&self) -> usize {
        self.draws.len()
    }

    /// A row with the error of a probe upon it; `directions` are rows as [`new`](Self::new) lists them.
    pub fn probe(&self, probe: usize, row: &[f64], directions: &[&[f32]]) -> Vec<f64> {
        self.probes[probe].upon(row, directions)
    }

    /// The same of a draw.
    pub fn draw(&self, draw: usize, row: &[f64], directions: &[&[f32]]) -> Vec<f64> {
        self.draws[draw].upon(row, directions)
    }

    /// The standard error of a number from what it becomes by each probe.
    pub fn standard_error(&self, value: f64, probed: impl Iterator<Item = f64>) -> f64 {
        self.probes.iter().zip(probed).map(|(c, p)| c.share * (p - value).powi(2)).sum::<f64>().sqrt()
    }
}

impl Change {
    fn upon(&self, row: &[f64], directions: &[&[f32]]) -> Vec<f64> {
        let mut changed = row.to_vec();
        for (weight, direction) in self.weights.iter().zip(directions).filter(|(w, _)| **w != 0.0) {
            changed.iter_mut().zip(*direction).for_each(|(v, d)| *v += weight * f64::from(*d));
        }
        changed
    }
}

/// The degrees of freedom that have this factor of Student's distribution; many where nothing was sampled.
fn freedom(confidence_95: f64) -> usize {
    let known = confidence_95.is_finite();
    (1..200).find(|f| known && student_95(*f) <= confidence_95 + 1e-9).unwrap_or(200)
}

/// Normally distributed (Box and Muller 1958).
fn normal(random: &mut Random) -> f64 {
    let (a, b) = (1.0 - random.next(), random.next());
    (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
}

/// A class, and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Decision<C> {
    /// The class of the result as it is.
    pub class: C,
    /// Probability that it is another without the noise.
    pub probability_of_another: f64,
}

impl<C: PartialEq> Decision<C> {
    /// A class and what it is in each draw; sure if there are none.
    pub fn new(class: C, drawn: impl Iterator<Item = C>) -> Self {
        let (mut other, mut all) = (0.0, 0.0f64);
        for c in drawn {
            all += 1.0;
            other += f64::from(u8::from(c != class));
        }
        Self { class, probability_of_another: other / all.max(1.0) }
    }

    /// Whether noise leaves it open.
    pub fn is_undecided(&self) -> bool {
        self.probability_of_another > UNDECIDED
    }
}

#[cfg(test)]
mod tests;

//! The best combination of states in every step: exact, by branch and bound.
//!
//! Light is additive: at a sensor or eye it is the sum over the groups of what each sends in its state, and never negative.
//! So the sum of some groups bounds that of all from below, and with the most of the others from above: whole families of
//! combinations are left out unseen, and none that could be better. A search that would look at more than
//! [`Problem::most_visits`] partial combinations of a step ends there; what it may have missed is bounded by the best bound
//! of what it has not looked at, and stated.

mod marginal;
mod moves;
mod problem;
mod search;

pub use marginal::{Marginal, marginal};
pub use moves::fewest_moves;
pub use problem::{Aim, Lights, Limit, Problem};
pub use search::{Best, best};

use super::{Facade, Schedule, State};
use crate::error::Result;
use rayon::prelude::*;

/// The optimum of a year.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// The states.
    pub schedule: Schedule,
    /// What the aim comes to in each step: mean illuminance in lx, or power for lights as a share of all of it.
    pub value: Vec<f64>,
    /// Steps in which no combination meets the limits, rising: there the one that exceeds them least stands.
    pub remaining: Vec<usize>,
    /// By how much each of these exceeds its limits: 0.1 are 10 %.
    pub excess: Vec<f64>,
    /// By how much a step's value may be worse than the best, where the search ended early; 0 of exact ones.
    pub may_be_lost: Vec<f64>,
}

/// Finds the best combination of each step for itself. Of equal ones the first, in the order of states, groups in order.
///
/// # Errors
/// States that are not those of the façade.
///
/// # Panics
/// If problem and façade have other groups.
pub fn optimum(problem: &Problem, facade: &Facade, lights: &dyn Lights, steps: usize) -> Result<Optimum> {
    assert!(facade.groups().iter().map(|g| g.states.len()).eq(problem.states.iter().copied()), "a problem of this façade");
    let found: Vec<Best> = (0..steps)
        .into_par_iter()
        .map_init(
            || vec![0.0; problem.values()],
            |buffer, step| {
                lights.fill(step, buffer);
                best(problem, buffer, None)
            },
        )
        .collect();
    of_best(facade, found)
}

fn of_best(facade: &Facade, found: Vec<Best>) -> Result<Optimum> {
    let states = (0..facade.groups().len()).map(|g| found.iter().map(|b| b.states[g]).collect()).collect();
    let remaining: Vec<usize> = (0..found.len()).filter(|s| found[*s].excess > 0.0).collect();
    Ok(Optimum {
        schedule: Schedule::new(facade, found.len(), states)?,
        value: found.iter().map(|b| b.value).collect(),
        excess: remaining.iter().map(|s| found[*s].excess).collect(),
        remaining,
        may_be_lost: found.iter().map(|b| b.may_be_lost).collect(),
    })
}

#[cfg(test)]
mod tests;

//! What each state and group is worth.

use super::problem::{Lights, Problem};
use super::search::best;
use super::{Facade, Optimum, State};
use rayon::prelude::*;

/// What is lost without a state or group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marginal {
    /// The group.
    pub group: usize,
    /// The state that were missing; nothing: the group stayed in its first state.
    pub state: Option<State>,
    /// By how much the aim's mean over the counted steps in which the limits are met either way were worse: lx, or a share
    /// of the lights' power.
    pub lost: f64,
    /// How many more steps would exceed the limits.
    pub more_remaining: usize,
}

/// The marginal value of each state of groups with several, and of each such group: the optimum again without it, in the
/// steps that use it (the others stay the best); of the steps that `counts` tells.
///
/// # Panics
/// If optimum and problem do not belong together.
pub fn marginal(problem: &Problem, facade: &Facade, lights: &dyn Lights, optimum: &Optimum, counts: &[bool]) -> Vec<Marginal> {
    let moving: Vec<usize> = (0..facade.groups().len()).filter(|g| problem.states[*g] > 1).collect();
    let mut cases: Vec<(usize, Option<State>)> = Vec::new();
    for group in moving {
        cases.extend((0..problem.states[group]).map(|s| (group, Some(s as State))));
        cases.push((group, None));
    }
    let used = |(group, state): (usize, Option<State>), step: usize| {
        let now = optimum.schedule.at(group, step);
        state.map_or(now != 0, |state| now == state)
    };
    let steps: Vec<usize> = (0..optimum.schedule.steps()).filter(|s| counts[*s]).collect();
    let mut exceeded = vec![false; optimum.schedule.steps()];
    optimum.remaining.iter().for_each(|s| exceeded[*s] = true);
    let all: Vec<Vec<State>> = problem.states.iter().map(|n| (0..*n as State).collect()).collect();
    // By step and case, in order: sums of the same bits whatever the threads.
    let found: Vec<Vec<(f64, bool)>> = steps
        .par_iter()
        .map_init(
            || vec![0.0; problem.values()],
            |buffer, step| {
                if cases.iter().any(|case| used(*case, *step)) {
                    lights.fill(*step, buffer);
                }
                let of = |case: &(usize, Option<State>)| {
                    if !used(*case, *step) {
                        return (0.0, false);
                    }
                    let mut allowed = all.clone();
                    match case.1 {
                        Some(state) => allowed[case.0].retain(|s| *s != state),
                        None => allowed[case.0] = vec![0],
                    }
                    let without = best(problem, buffer, Some(&allowed));
                    // Turned, so that less is worse, as a gain is.
                    let worse = problem.value(optimum.value[*step]) - problem.value(without.value);
                    let more = without.excess > 0.0 && !exceeded[*step];
                    (if without.excess > 0.0 || exceeded[*step] { 0.0 } else { worse }, more)
                };
                cases.iter().map(of).collect()
            },
        )
        .collect();
    let of_case = |(i, (group, state)): (usize, &(usize, Option<State>))| Marginal {
        group: *group,
        state: *state,
        lost: found.iter().map(|f| f[i].0).sum::<f64>() / steps.len().max(1) as f64,
        more_remaining: found.iter().filter(|f| f[i].1).count(),
    };
    cases.iter().enumerate().map(of_case).collect()
}

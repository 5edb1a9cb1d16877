//! Fewest moves: a shortest path over the steps.

use super::problem::{Lights, Problem};
use super::search::{Best, best};
use super::{Facade, Optimum, State, of_best};
use crate::error::{Error, Result};
use rayon::prelude::*;

/// Combinations beyond which the path is not sought.
pub(super) const MOST: usize = 20_000;

/// The schedule that meets the limits in every step (or exceeds them least, where none meets them) with the fewest moves
/// of groups, and of these the one with the highest sum of the aim. A step in which no combination meets the limits stands
/// in its best.
///
/// The cost of a path is (moves, −aim), compared in this order; the least cost of each combination in a step follows from
/// those of the step before, group by group: to stay costs nothing, to move costs one. Costs are kept of every √steps-th
/// step and found again between them on the way back.
///
/// # Errors
/// More than 20,000 combinations; states that are not those of the façade.
pub fn fewest_moves(problem: &Problem, facade: &Facade, lights: &dyn Lights, steps: usize) -> Result<Optimum> {
    let combinations = facade.combinations().and_then(|n| usize::try_from(n).ok()).filter(|n| *n <= MOST);
    let Some(count) = combinations else {
        return Err(Error::new(format!("fewest moves are sought among {MOST} combinations of states at most"))
            .help("choose another aim, or fewer groups or states"));
    };
    if steps == 0 {
        return of_best(facade, Vec::new());
    }
    let path = Path { problem, lights, combinations: (0..count).map(|i| states_of(&problem.states, i)).collect() };
    let stride = (steps as f64).sqrt().ceil() as usize;
    // Costs before every so manieth step.
    let mut kept = Vec::new();
    let mut costs = vec![Cost::default(); count];
    for step in 0..steps {
        if step % stride == 0 {
            kept.push(costs.clone());
        }
        costs = path.after(&costs, step, step == 0);
    }
    let mut last = first_least(&costs);
    let mut found: Vec<Best> = vec![path.at(last, steps - 1); steps];
    let mut end = steps;
    for (block, costs) in kept.into_iter().enumerate().rev() {
        let first = block * stride;
        let mut all = vec![costs];
        for step in first..end - 1 {
            let next = path.after(&all[step - first], step, step == 0);
            all.push(next);
        }
        for step in (first..end).rev() {
            found[step] = path.at(last, step);
            if step > 0 {
                last = path.before(&all[step - first], last);
            }
        }
        end = first;
    }
    of_best(facade, found)
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Cost {
    moves: u32,
    /// Less is better.
    aim: f64,
}

impl Cost {
    fn is_less(&self, other: &Self) -> bool {
        (self.moves, self.aim) < (other.moves, other.aim)
    }
}

/// No way leads here.
const NEVER: Cost = Cost { moves: u32::MAX, aim: f64::INFINITY };

struct Path<'a> {
    problem: &'a Problem,
    lights: &'a dyn Lights,
    combinations: Vec<Vec<State>>,
}

impl Path<'_> {
    /// Gain and excess of each combination that may stand in a step; nothing of the others.
    fn gains(&self, step: usize) -> Vec<Option<f64>> {
        let mut buffer = vec![0.0; self.problem.values()];
        self.lights.fill(step, &mut buffer);
        let of = |states: &Vec<State>| {
            let light = self.light(&buffer, states);
            (self.problem.excess(&light, None, self.problem.whole(&buffer, states)) == 0.0).then(|| self.problem.gain(&light))
        };
        let mut gains: Vec<Option<f64>> = self.combinations.par_iter().map(of).collect();
        if gains.iter().all(Option::is_none) {
            let only = best(self.problem, &buffer, None).states;
            let number = self.combinations.iter().position(|c| *c == only).unwrap_or(0);
            gains[number] = Some(self.problem.gain(&self.light(&buffer, &only)));
        }
        gains
    }

    fn light(&self, buffer: &[f64], states: &[State]) -> Vec<f64> {
        let mut light = buffer[..self.problem.channels].to_vec();
        for (group, state) in states.iter().enumerate() {
            let place = self.problem.place(group, *state);
            light.iter_mut().zip(&buffer[place..]).for_each(|(sum, own)| *sum += own);
        }
        light
    }

    fn at(&self, number: usize, step: usize) -> Best {
        let mut buffer = vec![0.0; self.problem.values()];
        self.lights.fill(step, &mut buffer);
        let states = self.combinations[number].clone();
        let light = self.light(&buffer, &states);
        let value = self.problem.value(self.problem.gain(&light));
        let excess = self.problem.excess(&light, None, self.problem.whole(&buffer, &states));
        Best { value, excess, states, may_be_lost: 0.0 }
    }

    /// Costs of all combinations after a step.
    fn after(&self, before: &[Cost], step: usize, is_first: bool) -> Vec<Cost> {
        let mut costs = before.to_vec();
        let mut inner = self.combinations.len();
        for states in self.problem.states.iter().filter(|_| !is_first) {
            inner /= states;
            for outer in (0..costs.len()).step_by(inner * states) {
                for i in outer..outer + inner {
                    let least = (0..*states).map(|s| costs[i + s * inner]).fold(NEVER, |a, b| if b.is_less(&a) { b } else { a });
                    let moved = Cost { moves: least.moves.saturating_add(1), ..least };
                    for s in 0..*states {
                        if moved.is_less(&costs[i + s * inner]) {
                            costs[i + s * inner] = moved;
                        }
                    }
                }
            }
        }
        for (cost, gain) in costs.iter_mut().zip(self.gains(step)) {
            *cost = gain.map_or(NEVER, |gain| Cost { aim: cost.aim - gain, ..*cost });
        }
        costs
    }

    /// The combination before from which one is reached at the least cost.
    fn before(&self, costs: &[Cost], to: usize) -> usize {
        let moves = |a: usize| self.combinations[a].iter().zip(&self.combinations[to]).filter(|(a, b)| a != b).count() as u32;
        let all: Vec<Cost> = costs.iter().enumerate().map(|(i, c)| Cost { moves: c.moves.saturating_add(moves(i)), ..*c }).collect();
        first_least(&all)
    }
}

fn first_least(costs: &[Cost]) -> usize {
    (1..costs.len()).fold(0, |least, i| if costs[i].is_less(&costs[least]) { i } else { least })
}

/// States of a combination's number: the last group changes fastest.
fn states_of(counts: &[usize], mut number: usize) -> Vec<State> {
    let mut states = vec![0; counts.len()];
    for (state, count) in states.iter_mut().zip(counts).rev() {
        (*state, number) = ((number % count) as State, number / count);
    }
    states
}

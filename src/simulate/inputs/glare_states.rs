//! In which states of the façade control needs the glare of views. DGP is no sum over the groups: each combination of states
//! is a façade of its own, with the glare of a whole year.

use super::Inputs;
use crate::control::State;
use crate::control::rules::Signal;
use crate::error::{Error, Result};
use crate::simulate::project::Project;
use crate::simulate::project::control::Asked;

/// Combinations of states whose glare is computed.
const MOST_COMBINATIONS: usize = 100;

/// What control needs to know of glare.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct GlareAsked {
    /// Numbers of the views.
    pub views: Vec<usize>,
    /// Combinations of states, rising.
    pub states: Vec<Vec<State>>,
}

impl Inputs {
    /// The views and the combinations of states whose DGP rules and optimal groups look at.
    ///
    /// # Errors
    /// More than 100 combinations.
    pub(crate) fn glare_of_states(&self, project: &Project) -> Result<GlareAsked> {
        let control = &project.control;
        let mut views = Vec::new();
        // Of each that asks: its group, and whether it asks with that group in its first state.
        let mut asked: Vec<(usize, bool)> = Vec::new();
        for rule in control.rules() {
            for reading in rule.readings() {
                if let Signal::Dgp(view) = reading.signal {
                    views.push(view);
                    asked.push((rule.group, !reading.as_set));
                }
            }
        }
        let is_optimal = |g: &usize| control.of_group(*g).is_some_and(|c| c.asked == Asked::Optimal);
        if let Some(group) = (0..self.facade.groups().len()).find(is_optimal).filter(|_| control.optimal.dgp.is_some()) {
            views.extend((0..project.views.len()).filter(|v| control.optimal.looks_from(&project.views[*v].name)));
            asked.push((group, false));
        }
        views.sort_unstable();
        views.dedup();
        let mut states: Vec<Vec<State>> = Vec::new();
        for (group, in_first) in asked {
            let of = |g: usize| if in_first && g == group { vec![0] } else { self.used(g) };
            let all: Vec<Vec<State>> = (0..self.facade.groups().len()).map(of).collect();
            let more = combinations(&all);
            states.extend(more.iter().flatten().cloned());
            states.sort_unstable();
            states.dedup();
            if more.is_none() || states.len() > MOST_COMBINATIONS {
                let message = format!("glare would have to be computed in more than {MOST_COMBINATIONS} combinations of states");
                let error = Error::new(message).help(
                    "put [[sensors]] at the eyes that face as the views do, and limit their illuminance: the simplified DGPs is 0.40 at 3473 lx",
                );
                return Err(control.of_group(group).map_or(error.clone(), |c| c.place.of(error)));
            }
        }
        Ok(GlareAsked { views, states })
    }
}

/// All combinations of these states of each group, the last changing fastest; nothing of more than 100.
pub(crate) fn combinations(states: &[Vec<State>]) -> Option<Vec<Vec<State>>> {
    states.iter().try_fold(1usize, |n, s| n.checked_mul(s.len())).filter(|n| *n <= MOST_COMBINATIONS)?;
    let mut all = vec![Vec::new()];
    for own in states {
        all = all.iter().flat_map(|c: &Vec<State>| own.iter().map(|s| [c.as_slice(), &[*s]].concat())).collect();
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn combinations_are_counted_with_the_last_changing_fastest() {
        let all = combinations(&[vec![0, 2], vec![1], vec![0, 1]]).unwrap();
        assert_eq!(all, [[0, 1, 0], [0, 1, 1], [2, 1, 0], [2, 1, 1]]);
        assert_eq!(combinations(&[vec![0; 11], vec![0; 10]]), None);
    }
}

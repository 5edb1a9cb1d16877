//! The state of each group in every time step.

use super::facade::{Facade, State};
use crate::error::{Error, Result};

/// States `[group][step]` of a façade.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schedule {
    states: Vec<Vec<State>>,
    steps: usize,
}

impl Schedule {
    /// A schedule of given states `[group][step]`.
    ///
    /// # Errors
    /// Groups or steps that are not those of the façade, states that a group does not have.
    pub fn new(facade: &Facade, steps: usize, states: Vec<Vec<State>>) -> Result<Self> {
        if states.len() != facade.groups().len() {
            return Err(Error::new(format!("a schedule of {} groups for a façade of {}", states.len(), facade.groups().len())));
        }
        for (group, row) in facade.groups().iter().zip(&states) {
            let of = |e: Error| e.field(format!("group '{}'", group.name));
            if row.len() != steps {
                return Err(of(Error::new(format!("the schedule has {} time steps, not {steps}", row.len()))));
            }
            if let Some(step) = row.iter().position(|s| usize::from(*s) >= group.states.len()) {
                let message = format!("step {step} is in state {} of {} (from 0)", row[step], group.states.len());
                return Err(of(Error::new(message)));
            }
        }
        Ok(Self { states, steps })
    }

    /// Each group in one state all the time.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn constant(facade: &Facade, steps: usize, states: &[State]) -> Result<Self> {
        Self::new(facade, steps, states.iter().map(|s| vec![*s; steps]).collect())
    }

    /// All groups in their first state.
    pub fn first(facade: &Facade, steps: usize) -> Self {
        Self { states: vec![vec![0; steps]; facade.groups().len()], steps }
    }

    /// Number of time steps.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Number of groups.
    pub fn groups(&self) -> usize {
        self.states.len()
    }

    /// The state of a group in a step.
    ///
    /// # Panics
    /// If there is no such group or step.
    pub fn at(&self, group: usize, step: usize) -> State {
        self.states[group][step]
    }

    /// The states of a group by step.
    ///
    /// # Panics
    /// If there is no such group.
    pub fn of_group(&self, group: usize) -> &[State] {
        &self.states[group]
    }

    /// The states of all groups in a step.
    ///
    /// # Panics
    /// If there is no such step.
    pub fn of_step(&self, step: usize) -> Vec<State> {
        self.states.iter().map(|row| row[step]).collect()
    }

    /// States that a group is ever in, rising.
    ///
    /// # Panics
    /// If there is no such group.
    pub fn used(&self, group: usize) -> Vec<State> {
        let mut used = self.states[group].clone();
        used.sort_unstable();
        used.dedup();
        used
    }

    /// The state that a group never leaves, if there is one.
    ///
    /// # Panics
    /// If there is no such group.
    pub fn constant_state(&self, group: usize) -> Option<State> {
        let row = &self.states[group];
        row.first().copied().filter(|first| row.iter().all(|s| s == first))
    }

    /// Hours that a group spends in each of so many states, with steps of `length` hours; of the steps that `counts`
    /// (a value per step) where it is given.
    ///
    /// # Panics
    /// If there is no such group, a state is beyond `states`, or `counts` lacks a step.
    pub fn hours(&self, group: usize, states: usize, length: f64, counts: Option<&[bool]>) -> Vec<f64> {
        let mut steps = vec![0usize; states];
        for (step, state) in self.states[group].iter().enumerate() {
            steps[usize::from(*state)] += usize::from(counts.is_none_or(|c| c[step]));
        }
        steps.into_iter().map(|n| n as f64 * length).collect()
    }

    /// How often a group is in another state than in the step before.
    ///
    /// # Panics
    /// If there is no such group.
    pub fn moves(&self, group: usize) -> usize {
        self.states[group].windows(2).filter(|w| w[0] != w[1]).count()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Group;
    use super::*;

    fn facade() -> Facade {
        let south = Group::new("south", &["open", "half", "closed"]).unwrap();
        Facade::new(vec![south, Group::new("north", &["clear", "dark"]).unwrap()]).unwrap()
    }

    #[test]
    fn hours_and_moves_are_counted() {
        let schedule = Schedule::new(&facade(), 6, vec![vec![0, 0, 2, 2, 1, 0], vec![1; 6]]).unwrap();
        assert_eq!(schedule.hours(0, 3, 0.25, None), [0.75, 0.25, 0.5]);
        let day = [false, true, true, false, false, true];
        assert_eq!(schedule.hours(0, 3, 1.0, Some(&day)), [2.0, 0.0, 1.0]);
        assert_eq!((schedule.moves(0), schedule.moves(1)), (3, 0));
        assert_eq!((schedule.constant_state(0), schedule.constant_state(1)), (None, Some(1)));
        assert_eq!((schedule.used(0), schedule.used(1)), (vec![0, 1, 2], vec![1]));
        assert_eq!((schedule.of_step(4), schedule.at(0, 4), schedule.of_group(1)), (vec![1, 1], 1, &[1u16; 6][..]));
        assert_eq!((schedule.steps(), schedule.groups()), (6, 2));
    }

    #[test]
    fn a_schedule_that_never_changes_is_a_constant_one() {
        let constant = Schedule::constant(&facade(), 4, &[2, 1]).unwrap();
        assert_eq!(constant, Schedule::new(&facade(), 4, vec![vec![2; 4], vec![1; 4]]).unwrap());
        assert_eq!(Schedule::first(&facade(), 4), Schedule::constant(&facade(), 4, &[0, 0]).unwrap());
    }

    #[test]
    fn what_does_not_fit_the_facade_is_refused() {
        let wrong = |states: Vec<Vec<State>>| Schedule::new(&facade(), 2, states).unwrap_err().to_string();
        assert!(wrong(vec![vec![0, 0]]).contains("1 groups for a façade of 2"));
        assert!(wrong(vec![vec![0, 0], vec![0]]).contains("group 'north': the schedule has 1 time steps, not 2"));
        assert!(wrong(vec![vec![0, 3], vec![0, 0]]).contains("step 1 is in state 3 of 3"));
    }
}

//! Rules at work, step by step.

use super::parse::Rule;
use super::signal::{Reading, Signal};
use crate::control::{Facade, Schedule, State};
use crate::error::Result;
use crate::metrics::Year;

/// What it is like in a step.
pub trait Values {
    /// A signal in its unit, with the groups in these states; of signals outdoors, whatever the states. Never asked for
    /// time and month.
    fn value(&self, signal: Signal, step: usize, states: &[State]) -> f64;

    /// Whether a step is occupied.
    fn occupied(&self, step: usize) -> bool;
}

/// Why a group is in its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decided {
    /// It has no rule.
    Given,
    /// By the clause of this number.
    Clause(u8),
    /// No clause is on.
    Otherwise,
    /// It has moved too short a time ago.
    Kept,
}

/// A group that moves back and forth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Oscillation {
    /// The group.
    pub group: usize,
    /// The first step of its first such time.
    pub step: usize,
    /// Moves, all year, to the state of two steps before.
    pub moves: usize,
}

/// What the groups do over the year.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Operation {
    /// Their states.
    pub schedule: Schedule,
    /// Why, `[group][step]`.
    pub decided: Vec<Vec<Decided>>,
    /// Groups that move back and forth.
    pub oscillations: Vec<Oscillation>,
}

/// Moves in a row, each back to the state of two steps before, that are no weather any more.
const BACK_AND_FORTH: usize = 4;

/// What a clause remembers.
#[derive(Clone, Default)]
struct Memory {
    /// Steps in a row in which its condition holds.
    held: usize,
    is_on: bool,
}

/// Moves the groups by their rules, one rule per group at most; those without one follow `given`.
///
/// In each step the groups decide in their order. A clause is on if its condition has held for its minutes, or if it was on
/// and its `until` does not hold. The first that is on decides. A group that has moved stays for the minutes of `keep`.
/// Minutes count whole steps, this one included: of hourly steps `for 90 min` are two. Where a step does not follow the one
/// before at once, nothing is remembered but the states.
///
/// # Errors
/// States that a group does not have.
///
/// # Panics
/// If `given` is not of this façade and year, or a rule of no group.
pub fn operate(rules: &[Rule], facade: &Facade, year: &Year, given: &Schedule, values: &dyn Values) -> Result<Operation> {
    let (steps, groups) = (year.steps.len(), facade.groups().len());
    assert_eq!((given.steps(), given.groups()), (steps, groups), "a schedule of this façade and year");
    let rule_of: Vec<Option<&Rule>> = (0..groups).map(|g| rules.iter().find(|r| r.group == g)).collect();
    let count = |minutes: f64| ((minutes / 60.0 / year.length - 1e-6).ceil() as usize).max(1);
    let mut memory: Vec<Vec<Memory>> = rule_of.iter().map(|r| vec![Memory::default(); r.map_or(0, |r| r.clauses.len())]).collect();
    // Steps since the group moved; none: long ago.
    let mut since: Vec<Option<usize>> = vec![None; groups];
    let mut states: Vec<State> = (0..groups).map(|g| if rule_of[g].is_some() || steps == 0 { 0 } else { given.at(g, 0) }).collect();
    let mut found = vec![Vec::with_capacity(steps); groups];
    let mut decided = vec![Vec::with_capacity(steps); groups];
    for step in 0..steps {
        if step == 0 || !follows(year, step) {
            memory.iter_mut().flatten().for_each(|m| *m = Memory::default());
            since.fill(None);
        }
        for group in 0..groups {
            let Some(rule) = rule_of[group] else {
                states[group] = given.at(group, step);
                found[group].push(states[group]);
                decided[group].push(Decided::Given);
                continue;
            };
            let occupied = values.occupied(step);
            let mut open = states.clone();
            open[group] = 0;
            let mut value = |reading: Reading| match reading.signal {
                Signal::Time => year.steps[step].begins,
                Signal::Month => f64::from(year.steps[step].month),
                signal => values.value(signal, step, if reading.as_set { &states } else { &open }),
            };
            // All clauses remember, also those behind the one that decides.
            for (clause, memory) in rule.clauses.iter().zip(&mut memory[group]) {
                let holds = clause.condition.holds(&mut value, occupied);
                memory.held = if holds { memory.held + 1 } else { 0 };
                let begins = memory.held >= count(clause.for_minutes);
                let stays = memory.is_on && clause.until.as_ref().is_some_and(|until| !until.holds(&mut value, occupied));
                memory.is_on = begins || stays;
            }
            let on = memory[group].iter().position(|m| m.is_on);
            let wanted = on.map_or(rule.otherwise, |i| rule.clauses[i].state);
            let why = on.map_or(Decided::Otherwise, |i| Decided::Clause(i as u8));
            let is_kept = wanted != states[group] && rule.keep_minutes > 0.0 && since[group].is_some_and(|n| n < count(rule.keep_minutes));
            decided[group].push(if is_kept { Decided::Kept } else { why });
            if !is_kept && wanted != states[group] {
                states[group] = wanted;
                since[group] = Some(0);
            }
            since[group] = since[group].map(|n| n + 1);
            found[group].push(states[group]);
        }
    }
    let oscillations = (0..groups).filter(|g| rule_of[*g].is_some()).filter_map(|g| oscillation(g, &found[g])).collect();
    Ok(Operation { schedule: Schedule::new(facade, steps, found)?, decided, oscillations })
}

/// Whether a step begins where the one before ends.
fn follows(year: &Year, step: usize) -> bool {
    let at = |i: usize| {
        let s = &year.steps[i];
        year.hour_of(s) as f64 + s.begins.fract()
    };
    ((at(step) - at(step - 1)).rem_euclid(year.whole()) - year.length).abs() < 1e-3
}

/// A group's moves back and forth, where there are [`BACK_AND_FORTH`] or more in a row somewhere.
fn oscillation(group: usize, states: &[State]) -> Option<Oscillation> {
    let back = |i: usize| i >= 2 && states[i] != states[i - 1] && states[i] == states[i - 2];
    let (mut run, mut moves, mut first) = (0, 0, None);
    for i in 0..=states.len() {
        if i < states.len() && back(i) {
            run += 1;
            continue;
        }
        if run >= BACK_AND_FORTH {
            moves += run;
            first.get_or_insert(i - run);
        }
        run = 0;
    }
    first.map(|step| Oscillation { group, step, moves })
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;

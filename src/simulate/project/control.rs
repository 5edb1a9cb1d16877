//! `[control]`: the state of each group of windows in every time step.
//!
//! ```toml
//! [control]
//! south = "blinds.csv"   # a state per time step
//! north = "open"         # or one that stays
//! east = { rule = "closed if irradiance > 250 W/m2 until irradiance < 200 W/m2; else open" }
//! roof = "lm-83"         # blinds as LM-83 moves them; or { lm-83 = ["open", "closed"] }
//! west = "optimal"       # what [optimal] asks for
//! ```
//!
//! A group that is not named stays in its first state.

use super::document::Place;
use super::names::alike;
use super::optimal::OptimalSection;
use super::output::Quantity;

use super::table::{Named, Table};
use crate::control::rules::{Known, Rule, Signal};
use crate::control::{Facade, Group, State};
use crate::error::{Error, Result};
use crate::text::nearest;
use std::path::PathBuf;

/// What decides the state of a group.
#[derive(Debug, Clone, PartialEq)]
pub enum Asked {
    /// It stays as it is.
    Stays(State),
    /// A schedule.
    Schedule(PathBuf),
    /// A rule: its text, and what it says.
    Rule(String, Option<Rule>),
    /// LM-83's blinds.
    Lm83 {
        /// The state with blinds open.
        open: State,
        /// The state with blinds closed.
        closed: State,
    },
    /// The best state of each step.
    Optimal,
}

impl Asked {
    /// Whether the run decides the states.
    pub fn is_decided_by_the_run(&self) -> bool {
        matches!(self, Self::Rule(..) | Self::Lm83 { .. } | Self::Optimal)
    }
}

/// What is asked for one group.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupControl {
    /// Number of the group.
    pub group: usize,
    /// What decides its state.
    pub asked: Asked,
    /// Where that stands in the project file.
    pub place: Place,
}

/// `[control]`
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ControlSection {
    /// The groups that are named.
    pub groups: Vec<GroupControl>,
    /// Whether the section stands in the project.
    pub is_given: bool,
    /// `[optimal]`
    pub optimal: OptimalSection,
}

impl ControlSection {
    /// # Errors
    /// Groups that there are not, or that are named twice; values that are neither a state of the group nor a file.
    pub(super) fn read(table: Option<Table<'_, '_>>, facade: &Facade) -> Result<Self> {
        let Some(mut table) = table else { return Ok(Self::default()) };
        let mut groups: Vec<GroupControl> = Vec::new();
        for (key, named) in table.all_named()? {
            let names: Vec<&str> = facade.groups().iter().map(|g| g.name.as_str()).collect();
            let Some(number) = facade.groups().iter().position(|g| alike(&g.name, &key)) else {
                let error = table.error(&key, format!("there is no group of windows '{key}' with states"));
                return Err(match (nearest(&key, &names), names.is_empty()) {
                    (_, true) => error.help("no window has states: add [[window.state]] to one, or take [control] out"),
                    (Some(name), _) => error.help(format!("did you mean '{name}'?")),
                    (None, _) => error.help(format!("the groups are: {}", names.join(", "))),
                });
            };
            if groups.iter().any(|g| g.group == number) {
                return Err(table.error(&key, format!("the group '{key}' is named twice (capitals do not count)")).help("take one out"));
            }
            let group = &facade.groups()[number];
            let asked = match named {
                Named::Text(text) => of_text(&table, &key, &text, group)?,
                Named::Rule(text) => Asked::Rule(text, None),
                Named::Lm83(states) => {
                    let of = |state: &String| group.state(state).map_err(|e| table.place(&key).of(e));
                    blinds(&table, &key, group, of(&states[0])?, of(&states[1])?)?
                }
            };
            groups.push(GroupControl { group: number, asked, place: table.place(&key) });
        }
        Ok(Self { groups, is_given: true, optimal: OptimalSection::default() })
    }

    /// Reads the rules when all that they can name is known, and checks what else the run is to decide.
    ///
    /// # Errors
    /// What is wrong with a rule, with the key and the column; optimal states that nothing is said of, or the contrary;
    /// states decided without sensors, or from irradiance.
    pub(super) fn check(&mut self, known: Known<'_>, quantity: Quantity, has_glare: bool) -> Result<()> {
        if let Some(place) = self.optimal.place.as_ref().filter(|_| self.groups.iter().all(|g| g.asked != Asked::Optimal)) {
            let error = Error::new("no group of windows is to be optimal");
            return Err(place.of(error).help("write the name of a group = \"optimal\" in [control], or take [optimal] out"));
        }
        let others: Vec<(usize, Asked)> = self.groups.iter().map(|g| (g.group, g.asked.clone())).collect();
        for control in &mut self.groups {
            let fault = |message: &str| control.place.of(Error::new(message));
            if quantity.is_solar() && control.asked.is_decided_by_the_run() {
                return Err(fault("rules, LM-83's blinds and optimal states look at illuminance, but the project asks for irradiance")
                    .help("take quantity out of [output], or give a table of states; a run in lux writes one: control/schedule.csv"));
            }
            match &mut control.asked {
                Asked::Rule(text, rule) => {
                    let read = Rule::parse(text, control.group, known).map_err(|e| control.place.of(e))?;
                    if !has_glare && read.readings().iter().any(|r| matches!(r.signal, Signal::Dgp(_))) {
                        return Err(fault("the DGP of a view needs a method of glare")
                            .help("add [glare] with method = \"image\"; or put [[sensors]] at the eye that face as the view does"));
                    }
                    let decides = |asked: &Asked| matches!(asked, Asked::Lm83 { .. } | Asked::Optimal);
                    if let Some(other) = others.iter().find(|(_, asked)| decides(asked))
                        && read.readings().iter().any(|r| r.signal.is_indoors())
                    {
                        return Err(control.place.of(Error::new(format!(
                            "this rule looks at light indoors, which the blinds of group '{}' change; these in turn are moved by all light indoors",
                            known.facade.groups()[other.0].name
                        ))).help("let the rule look at what is outdoors, or run without it first and give the states as a table: control/schedule.csv"));
                    }
                    *rule = Some(read);
                }
                Asked::Lm83 { .. } | Asked::Optimal if known.sensors.is_empty() => {
                    return Err(fault("nothing tells the light indoors: there are no sensors").help("add [[sensors]]"));
                }
                Asked::Optimal if self.optimal.place.is_none() => {
                    return Err(fault("nothing tells what is best")
                        .help("add [optimal] with aim = \"daylight\" and eyes = \"…\", the [[sensors]] at eyes"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Groups whose states the run decides.
    pub fn decided_by_the_run(&self) -> Vec<usize> {
        self.groups.iter().filter(|g| g.asked.is_decided_by_the_run()).map(|g| g.group).collect()
    }

    /// What is asked for a group, if it is named.
    pub fn of_group(&self, group: usize) -> Option<&GroupControl> {
        self.groups.iter().find(|g| g.group == group)
    }

    /// Rules of all groups that have one.
    pub fn rules(&self) -> Vec<Rule> {
        let of = |g: &GroupControl| if let Asked::Rule(_, rule) = &g.asked { rule.clone() } else { None };
        self.groups.iter().filter_map(of).collect()
    }
}

/// What a text asks for: a state, one of the words, or a file.
fn of_text(table: &Table<'_, '_>, key: &str, text: &str, group: &Group) -> Result<Asked> {
    if let Some(state) = group.states.iter().position(|s| s == text) {
        return Ok(Asked::Stays(state as State));
    }
    match text {
        "lm-83" => return blinds(table, key, group, 0, group.states.len() as State - 1),
        "optimal" => return Ok(Asked::Optimal),
        _ => {}
    }
    table.file_named(key, text).map(Asked::Schedule).map_err(|_| {
        let states: Vec<&str> = group.states.iter().map(String::as_str).collect();
        let message = format!("'{text}' is neither a state of the group '{}' nor a file", group.name);
        let error = table.error(key, message);
        if text.contains(" if ") {
            return error.help(format!("a rule stands in {{ rule = \"{text}\" }}"));
        }
        let near = nearest(text, &states.iter().copied().chain(["lm-83", "optimal"]).collect::<Vec<_>>());
        match near {
            Some(near @ ("lm-83" | "optimal")) => error.help(format!("did you mean \"{near}\"?")),
            Some(state) => error.help(format!("did you mean the state '{state}'?")),
            None => error.help(format!(
                "name a table of states (CSV), one of the group's states ({}), \"lm-83\", \"optimal\", or {{ rule = \"…\" }}",
                states.join(", ")
            )),
        }
    })
}

fn blinds(table: &Table<'_, '_>, key: &str, group: &Group, open: State, closed: State) -> Result<Asked> {
    if open == closed {
        return Err(table
            .error(key, format!("blinds of group '{}' need two states, open and closed", group.name))
            .help("add a [[window.state]], or name two states: { lm-83 = [\"open\", \"closed\"] }"));
    }
    Ok(Asked::Lm83 { open, closed })
}

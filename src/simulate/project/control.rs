//! `[control]`: the state of each group of windows in every time step.
//!
//! ```toml
//! [control]
//! south = "blinds.csv"   # a state per time step
//! north = "open"         # or one that stays
//! ```
//!
//! A group that is not named stays in its first state.

use super::document::Place;
use super::names::alike;
use super::table::Table;
use crate::control::{Facade, State};
use crate::error::Result;
use crate::text::nearest;
use std::path::PathBuf;

/// What decides the state of a group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Asked {
    /// It stays as it is.
    Stays(State),
    /// A schedule.
    Schedule(PathBuf),
}

/// What is asked for one group.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupControl {
    /// Number of the group.
    pub group: usize,
    /// What decides its state.
    pub asked: Asked,
    /// Where that stands in the project file.
    pub place: Place,
}

/// `[control]`
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ControlSection {
    /// The groups that are named.
    pub groups: Vec<GroupControl>,
    /// Whether the section stands in the project.
    pub is_given: bool,
}

impl ControlSection {
    /// # Errors
    /// Groups that there are not, or that are named twice; values that are neither a state of the group nor a file.
    pub(super) fn read(table: Option<Table<'_, '_>>, facade: &Facade) -> Result<Self> {
        let Some(mut table) = table else { return Ok(Self::default()) };
        let mut groups: Vec<GroupControl> = Vec::new();
        for (key, text) in table.all_texts().map_err(|e| e.help("write the name of a state, or of a table of states (CSV), in quotes"))? {
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
            let asked = match group.states.iter().position(|s| *s == text) {
                Some(state) => Asked::Stays(state as State),
                None => {
                    let states: Vec<&str> = group.states.iter().map(String::as_str).collect();
                    let help = || match nearest(&text, &states) {
                        Some(state) => format!("did you mean the state '{state}'?"),
                        None => format!("name a table of states (CSV), or one of the group's states: {}", states.join(", ")),
                    };
                    match table.file_named(&key, &text) {
                        Ok(file) => Asked::Schedule(file),
                        Err(_) => {
                            let message = format!("'{text}' is neither a state of the group '{}' nor a file", group.name);
                            return Err(table.error(&key, message).help(help()));
                        }
                    }
                }
            };
            groups.push(GroupControl { group: number, asked, place: table.place(&key) });
        }
        Ok(Self { groups, is_given: true })
    }

    /// Whether a group may change its state.
    pub fn follows_a_schedule(&self) -> bool {
        self.groups.iter().any(|g| matches!(g.asked, Asked::Schedule(_)))
    }
}

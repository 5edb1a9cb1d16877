//! Groups of windows and their states.

use crate::error::{Error, Result};
use crate::text::nearest;

/// Number of a state within its group, from 0.
pub type State = u16;

/// States that a group may have.
const MOST_STATES: usize = 1000;

/// Windows that move together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// Names of its states, in the order of the project.
    pub states: Vec<String>,
}

/// All groups of a façade.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Facade {
    groups: Vec<Group>,
}

impl Group {
    /// A group with states.
    ///
    /// # Errors
    /// No state or more than 1000, a name twice (also in other case), names that are empty or that a table cannot hold.
    pub fn new(name: impl Into<String>, states: &[impl AsRef<str>]) -> Result<Self> {
        let group = Self { name: name.into(), states: states.iter().map(|s| s.as_ref().trim().to_string()).collect() };
        let of = |e: Error| e.field(format!("group '{}'", group.name));
        check_name(&group.name).map_err(of)?;
        if group.states.is_empty() || group.states.len() > MOST_STATES {
            return Err(of(Error::new(format!("{} states; a group has 1 to {MOST_STATES}", group.states.len()))));
        }
        for (i, state) in group.states.iter().enumerate() {
            check_name(state).map_err(of)?;
            if group.states[..i].iter().any(|other| other.to_lowercase() == state.to_lowercase()) {
                return Err(of(Error::new(format!("two states are called '{state}'"))).help("give each its own name"));
            }
        }
        Ok(group)
    }

    /// Whether states are numbers to their project: then `1` is the state of this name, not the second one.
    fn has_numbers_as_names(&self) -> bool {
        self.states.iter().any(|s| s.parse::<f64>().is_ok())
    }

    /// The state of a name, in any case, or of a number from 0.
    ///
    /// # Errors
    /// There is none: with the names that may be meant.
    pub fn state(&self, word: &str) -> Result<State> {
        let word = word.trim();
        let lower = word.to_lowercase();
        let by_name = self.states.iter().position(|s| s.to_lowercase() == lower);
        // Spreadsheets write whole numbers as 2.0.
        let number = || word.strip_suffix(".0").unwrap_or(word).parse::<usize>().ok().filter(|n| *n < self.states.len());
        let found = by_name.or_else(|| if self.has_numbers_as_names() { None } else { number() });
        found.map(|n| n as State).ok_or_else(|| self.no_state(word))
    }

    fn no_state(&self, word: &str) -> Error {
        let names: Vec<&str> = self.states.iter().map(String::as_str).collect();
        let shown: String = word.chars().take(40).collect();
        let numbers = if self.has_numbers_as_names() { String::new() } else { format!(", or their numbers 0 to {}", names.len() - 1) };
        let help = match nearest(&shown, &names) {
            Some(near) if word.parse::<f64>().is_err() => format!("did you mean '{near}'? The states are {}{numbers}", listed(&names)),
            _ => format!("the states are {}{numbers}", listed(&names)),
        };
        Error::new(format!("group '{}' has no state '{}'", self.name, shown.escape_debug())).help(help)
    }
}

impl Facade {
    /// A façade of these groups, whose names differ.
    ///
    /// # Errors
    /// Two groups of one name.
    pub fn new(groups: Vec<Group>) -> Result<Self> {
        for (i, group) in groups.iter().enumerate() {
            if groups[..i].iter().any(|other| other.name.to_lowercase() == group.name.to_lowercase()) {
                return Err(Error::new(format!("two groups are called '{}'", group.name)).help("give each its own name"));
            }
        }
        Ok(Self { groups })
    }

    /// All groups.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// The number of a group by its name.
    ///
    /// # Errors
    /// There is none: with the name that may be meant.
    pub fn group(&self, name: &str) -> Result<usize> {
        self.groups.iter().position(|g| g.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.groups.iter().map(|g| g.name.as_str()).collect();
            let help = match nearest(name, &names) {
                Some(near) => format!("did you mean '{near}'?"),
                None if names.is_empty() => "no window has states".to_string(),
                None => format!("the groups are {}", listed(&names)),
            };
            Error::new(format!("there is no group of windows '{name}'")).help(help)
        })
    }

    /// In how many ways the groups can stand together; `None` beyond 2⁶⁴.
    pub fn combinations(&self) -> Option<u64> {
        self.groups.iter().try_fold(1u64, |n, g| n.checked_mul(g.states.len() as u64))
    }
}

/// Names in a row; of many the first ten.
pub(super) fn listed(names: &[&str]) -> String {
    const SHOWN: usize = 10;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|n| format!("'{n}'")).collect();
    let more = if names.len() > SHOWN { format!(" and {} more", names.len() - SHOWN) } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

fn check_name(name: &str) -> Result<()> {
    if name.trim().is_empty() {
        return Err(Error::new("a name is empty"));
    }
    match name.chars().find(|c| matches!(c, ',' | ';' | '"' | '#') || c.is_control()) {
        Some(c) => Err(Error::new(format!("the name '{}' has a '{}' in it", name.escape_debug(), c.escape_debug()))
            .help("names stand in tables: choose one without comma, semicolon, quote and #")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_found_by_name_and_number_and_slips_are_answered() {
        let group = Group::new("south", &["open", "blind 45", "closed"]).unwrap();
        let state = |word: &str| group.state(word).unwrap();
        assert_eq!([state("open"), state("Blind 45"), state(" closed "), state("0"), state("2"), state("1.0")], [0, 1, 2, 0, 2, 1]);
        let error = group.state("blnd 45").unwrap_err().to_string();
        assert!(error.contains("no state 'blnd 45'") && error.contains("did you mean 'blind 45'?"), "{error}");
        for wrong in ["3", "-1", "1.5", "", "1e0", "NaN"] {
            let error = group.state(wrong).unwrap_err().to_string();
            assert!(error.contains("'open', 'blind 45', 'closed', or their numbers 0 to 2"), "{error}");
        }
        // Angles as names are names, never numbers.
        let slats = Group::new("south", &["0", "45", "1"]).unwrap();
        assert_eq!((slats.state("45").unwrap(), slats.state("1").unwrap()), (1, 2));
        let error = slats.state("2").unwrap_err().to_string();
        assert!(error.contains("the states are '0', '45', '1'") && !error.contains("numbers"), "{error}");
    }

    #[test]
    fn names_are_unambiguous_and_fit_tables() {
        let wrong = |states: &[&str]| Group::new("g", states).unwrap_err().to_string();
        assert!(wrong(&["open", "Open"]).contains("two states are called 'Open'"));
        assert!(wrong(&["a,b"]).contains("','") && wrong(&["a\tb"]).contains("'\\t'"));
        assert!(wrong(&[""]).contains("empty") && wrong(&[]).contains("0 states"));
        let group = |name: &str| Group::new(name, &["open"]).unwrap();
        assert!(Facade::new(vec![group("a"), group("A")]).unwrap_err().to_string().contains("two groups"));
        let facade = Facade::new(vec![group("south"), Group::new("north", &["a", "b", "c"]).unwrap()]).unwrap();
        assert_eq!((facade.group("north").unwrap(), facade.combinations()), (1, Some(3)));
        let error = facade.group("nort").unwrap_err().to_string();
        assert!(error.contains("did you mean 'north'?"), "{error}");
        let many: Vec<Group> =
            (0..10).map(|i| Group::new(format!("{i}"), &(0..1000).map(|s| s.to_string()).collect::<Vec<_>>()).unwrap()).collect();
        assert_eq!(Facade::new(many).unwrap().combinations(), None);
    }
}

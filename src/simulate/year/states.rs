//! The states of the façade's groups through a year of results.

use super::arrays::Year;
use crate::error::{Error, Result};

impl Year {
    /// The state of a group of windows in each time step: its number among the states that the summary lists.
    ///
    /// # Errors
    /// A group that the results do not have, and a schedule that is missing or not theirs.
    pub fn states_of(&self, group: &str) -> Result<Vec<usize>> {
        let path = self.folder().join("control/schedule.csv");
        let fault = |what: String| Error::new(what).file(&path).help("run the project again");
        let Some(summary) = self.summary.groups.iter().find(|g| g.name == group) else {
            return Err(Error::new(format!("there is no group of windows '{group}'")).file(self.folder()));
        };
        let text = crate::text::read(&path, "a schedule")?;
        let mut rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let column = rows.next().and_then(|names| names.iter().position(|name| *name == group));
        let column = column.ok_or_else(|| fault(format!("the group '{group}' is not in the schedule")))?;
        let state = |row: Vec<&str>| summary.states.iter().position(|s| row.get(column).is_some_and(|name| *name == s.name));
        let states: Option<Vec<usize>> = rows.map(state).collect();
        states.filter(|all| all.len() == self.times.len()).ok_or_else(|| fault("the schedule is not that of the results".into()))
    }
}

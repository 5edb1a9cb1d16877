//! Faults between sections of a project.

use super::Project;
use crate::error::{Error, Result};

impl Project {
    /// Faults that depend on the number of phases.
    ///
    /// # Errors
    /// Matrices and pictures made elsewhere that do not fit the phases, or the states of the windows.
    pub(in crate::simulate) fn check_phases(&self, phases: u32) -> Result<()> {
        self.views_match(phases)?;
        self.suns_are_of_one_state(phases)?;
        self.imports_match(phases)
    }

    /// Suns made elsewhere passed the windows in one state.
    fn suns_are_of_one_state(&self, phases: u32) -> Result<()> {
        let Some(window) = self.windows.iter().find(|w| w.states.len() > 1).filter(|_| phases == 5) else { return Ok(()) };
        let sensors = self.sensors.iter().find(|s| s.sun.is_some()).map(|s| (&self.places.sensors, &s.name, "a sun matrix"));
        let view = self.views.iter().find(|v| v.given.sun.is_some()).map(|v| (&self.places.view, &v.name, "pictures of suns"));
        match sensors.or(view) {
            None => Ok(()),
            Some((place, name, what)) => Err(place
                .of(Error::new(format!(
                    "'{name}' has {what} made elsewhere, which passed the windows in one state, but window '{}' has {} states",
                    window.name,
                    window.states.len()
                )))
                .help("take 'sun' out, then suns are traced for each state; or make a project for each state, with its filling in place of the states")),
        }
    }

    /// Five phases need the direct parts of matrices too, and only they need suns.
    fn imports_match(&self, phases: u32) -> Result<()> {
        let windows = self.windows.iter().map(|w| (&self.places.window, &w.name, "daylight", &w.daylight));
        let sensors = self.sensors.iter().map(|s| (&self.places.sensors, &s.name, "view", &s.view));
        for (place, name, key, given) in windows.chain(sensors) {
            if phases == 5 && given.as_ref().is_some_and(|g| g.direct.is_none()) {
                let text = format!("'{name}' has a matrix '{key}' without its direct part, which five phases subtract");
                return Err(place.of(Error::new(text)).help(format!("add {key}_direct = \"….mtx\"")));
            }
        }
        match self.sensors.iter().find(|s| phases != 5 && s.sun.is_some()) {
            None => Ok(()),
            Some(group) => Err(self
                .places
                .sensors
                .of(Error::new(format!("'{}' has a sun matrix, which only five phases use", group.name)))
                .help("write phases = 5 and give the window a shade or tensor_tree, or take 'sun' out")),
        }
    }

    /// The same of pictures.
    fn views_match(&self, phases: u32) -> Result<()> {
        let fault = |text: String, help: &str| Err(self.places.view.of(Error::new(text)).help(help));
        for view in &self.views {
            let (name, given) = (&view.name, &view.given);
            if phases == 5 && given.view.is_some() && given.view_direct.is_none() {
                return fault(
                    format!("'{name}' has pictures 'view' without their direct part, which five phases subtract"),
                    "add view_direct = \"vd%03d.hdr\"",
                );
            }
            if phases != 5 && given.sun.is_some() {
                return fault(
                    format!("'{name}' has pictures of suns, which only five phases use"),
                    "write phases = 5 and give the window a shade or tensor_tree, or take 'sun' out",
                );
            }
        }
        Ok(())
    }
}

//! Faults between sections of a project.

use super::Project;
use super::views::ImageHours;
use crate::error::{Error, Result};

impl Project {
    /// Windows with several states change them together.
    pub(super) fn states_match(&self) -> Result<()> {
        let mut changing = self.windows.iter().filter(|w| !w.states.is_empty());
        let Some(first) = changing.next() else { return Ok(()) };
        match changing.find(|w| w.states.len() != first.states.len()) {
            None => Ok(()),
            Some(other) => {
                let [(a, n), (b, m)] = [(&first.name, first.states.len()), (&other.name, other.states.len())];
                let text = format!("window '{a}' has {n} states, '{b}' has {m}");
                let help = "give all windows with states the same number: the first of each belong together, and so on";
                Err(self.places.window.of(Error::new(text)).help(help))
            }
        }
    }

    /// Faults that depend on the number of phases.
    ///
    /// # Errors
    /// States whose results are not computed, matrices and pictures made elsewhere that do not fit the phases.
    pub(in crate::simulate) fn check_phases(&self, phases: u32) -> Result<()> {
        self.views_match(phases)?;
        self.states_have_results(phases)?;
        self.imports_match(phases)
    }

    /// Glare alone is computed for each state; anything else would be that of the first.
    fn states_have_results(&self, phases: u32) -> Result<()> {
        let Some(window) = self.windows.iter().find(|w| w.states.len() > 1) else { return Ok(()) };
        const HELP: &str =
            "write a project for each state, with 'bsdf' in place of 'states'; 'lucarne run A.toml B.toml' traces what they share once";
        if let Some(sunny) = self.windows.iter().find(|w| w.lets_suns_through()).filter(|_| phases == 5) {
            let text = format!("the sun would be traced through the shade or tensor tree of window '{}' in all states", sunny.name);
            return Err(self.places.window.of(Error::new(text)).help(format!("{HELP}; each with its own shade or tensor_tree")));
        }
        let (place, what) = if !self.sensors.is_empty() {
            (&self.places.sensors, "illuminance")
        } else if self.images.hours != ImageHours::None || self.images.components {
            (&self.places.images, "a picture")
        } else {
            return Ok(());
        };
        let text = format!("window '{}' has {} states, but {what} is computed for one state only", window.name, window.states.len());
        Err(place.of(Error::new(text)).help(HELP))
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

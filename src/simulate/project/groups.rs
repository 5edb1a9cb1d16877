//! Which windows change their states together.

use super::document::Place;
use super::names::alike;
use super::sections::WindowSection;
use crate::control::{Facade, Group};
use crate::error::{Error, Result};

/// The groups of windows with states, in the order of the project.
///
/// # Errors
/// Windows of a group whose states differ.
pub(super) fn facade(windows: &[WindowSection], place: &Place) -> Result<Facade> {
    let mut groups: Vec<(&WindowSection, Group)> = Vec::new();
    for window in windows {
        let of_group = groups.iter().find(|(_, g)| alike(&g.name, &window.group));
        let first = of_group.map(|(first, _)| *first);
        let differs = |first: &WindowSection| {
            let names = |w: &WindowSection| w.states.iter().map(|s| s.name.clone()).collect::<Vec<_>>();
            let told = |w: &WindowSection| match names(w).as_slice() {
                [] => "none".to_string(),
                names => format!("'{}'", names.join("', '")),
            };
            let text = format!(
                "windows '{}' and '{}' are of group '{}', but their states differ: {} and {}",
                first.name,
                window.name,
                window.group,
                told(first),
                told(window)
            );
            let help = "give them states of the same names in the same order, or groups of their own";
            (names(first) != names(window)).then(|| window.group_place.of(Error::new(text)).help(help))
        };
        // Also a window without states that is in the group of one with.
        let sharing = windows.iter().take_while(|w| !std::ptr::eq(*w, window)).find(|w| alike(&w.group, &window.group));
        if let Some(fault) = first.or(sharing).and_then(differs) {
            return Err(fault);
        }
        if first.is_none() && !window.states.is_empty() {
            let names: Vec<&str> = window.states.iter().map(|s| s.name.as_str()).collect();
            groups.push((window, Group::new(window.group.clone(), &names).map_err(|e| window.group_place.of(e))?));
        }
    }
    Facade::new(groups.into_iter().map(|(_, group)| group).collect()).map_err(|e| place.of(e))
}

#[cfg(test)]
impl super::Project {
    /// Gives a window these states, as `states = [files]` does.
    pub(crate) fn give_states(&mut self, window: usize, files: &[std::path::PathBuf]) {
        let section = &mut self.windows[window];
        let place = section.place.clone();
        let state = |(file, name): (&std::path::PathBuf, String)| super::states::StateSection {
            name,
            filling: super::filling::Filling::Bsdf(file.clone()),
            place: place.clone(),
            shade: None,
            tensor_tree: None,
        };
        section.states = files.iter().zip(super::states::unique_names(files)).map(state).collect();
        self.facade = facade(&self.windows, &place).unwrap();
    }
}

//! `[[window.state]]`: the states of a window, and which windows change them together.

use super::document::Place;
use super::names;
use super::sections::{Filling, WindowSection, check_ways, filling, ways};
use super::table::Table;
use crate::control::{Facade, Group};
use crate::error::{Error, Result};
use std::path::PathBuf;

/// One state of a window.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSection {
    /// Its name in results.
    pub name: String,
    /// What the window is made of in it.
    pub filling: Filling,
    /// Where that stands in the project file.
    pub place: Place,
    /// Slats and panes that the sun is traced through in it.
    pub shade: Option<PathBuf>,
    /// Scattering data that the sun is traced through in place of a shade.
    pub tensor_tree: Option<PathBuf>,
}

impl StateSection {
    /// The states of a window, by either form; none of a window that has but one.
    ///
    /// # Errors
    /// Both forms, names that are no names of files or stand twice, states without filling.
    pub(super) fn read_all(table: &mut Table<'_, '_>) -> Result<Vec<Self>> {
        let files = table.paths("states")?;
        let place = table.place("states");
        let tables = table.tables("state")?;
        if let (false, false) = (files.is_empty(), tables.is_empty()) {
            return Err(table.error("states", "a window has either 'states' or [[window.state]]").help("take one of the two out"));
        }
        let unique = unique_names(&files);
        let short = files.into_iter().zip(unique).map(|(file, name)| Self {
            name,
            filling: Filling::Bsdf(file),
            place: place.clone(),
            shade: None,
            tensor_tree: None,
        });
        let mut states: Vec<Self> = short.collect();
        for mut table in tables {
            let name = names::name(&mut table, "add name = \"open\" or the like")?;
            if states.iter().any(|s| alike(&s.name, &name)) {
                return Err(table
                    .error("name", format!("two states of a window have the name '{name}'"))
                    .help("give each its own name: result files are called after it (capitals do not count)"));
            }
            let (filling, place) = filling(&mut table, false)?;
            let (shade, tensor_tree) = ways(&mut table)?;
            check_ways(&table, &filling, shade.is_some(), tensor_tree.is_some())?;
            table.finish()?;
            states.push(Self { name, filling, place, shade, tensor_tree });
        }
        Ok(states)
    }
}

/// The files' names without their endings, numbered where files in different folders have the same.
fn unique_names(files: &[PathBuf]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut unique = if name.is_empty() { "state".to_string() } else { name.clone() };
        let mut number = 2;
        while names.contains(&unique) {
            unique = format!("{name}-{number}");
            number += 1;
        }
        names.push(unique);
    }
    names
}

/// Whether two names are the same: capitals do not count.
pub(crate) fn alike(a: &str, b: &str) -> bool {
    a.to_lowercase() == b.to_lowercase()
}

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
    pub(crate) fn give_states(&mut self, window: usize, files: &[PathBuf]) {
        let section = &mut self.windows[window];
        let place = section.place.clone();
        let state = |(file, name): (&PathBuf, String)| StateSection {
            name,
            filling: Filling::Bsdf(file.clone()),
            place: place.clone(),
            shade: None,
            tensor_tree: None,
        };
        section.states = files.iter().zip(unique_names(files)).map(state).collect();
        self.facade = facade(&self.windows, &place).unwrap();
    }
}

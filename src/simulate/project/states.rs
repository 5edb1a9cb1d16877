//! `[[window.state]]`: the states of a window.

use super::document::Place;
use super::filling::{Filling, SunData, check_ways, filling, ways};
use super::names::{self, alike};
use super::table::Table;
use crate::error::Result;
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
    pub tensor_tree: Option<SunData>,
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
pub(super) fn unique_names(files: &[PathBuf]) -> Vec<String> {
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

//! Several rooms in one run: a project file each, a folder of results each, and one table of annual
//! glare over all.
//!
//! Matrices that another room's run has already computed from the same inputs (the sky of the same
//! place, the room of another façade) are taken over, not computed again.

use super::run::{compute, context};
use super::store::Store;
use super::{Inputs, Project, Summary};
use crate::error::{Error, Result, Warnings};
use crate::files::write_atomically;
use crate::gpu::Device;
use crate::progress::{Progress, Whole, cancelled};
use std::path::{Path, PathBuf};

/// One of several projects.
pub struct Room {
    /// Name of its folder.
    pub name: String,
    /// The project.
    pub project: Project,
    /// Its files.
    pub inputs: Inputs,
}

impl Room {
    /// Reads all projects before any is computed. Rooms are named after their files, or after the
    /// files' folders where the files have the same name.
    ///
    /// # Errors
    /// What is wrong in which file; rooms of the same name.
    pub fn read_all(files: &[PathBuf], warnings: &mut Warnings) -> Result<Vec<Self>> {
        let names = names(files)?;
        let read = |(file, name): (&PathBuf, String)| {
            let project = Project::read(file)?;
            let inputs = Inputs::read(&project, warnings)?;
            Ok(Self { name, project, inputs })
        };
        files.iter().zip(names).map(read).collect()
    }
}

fn names(files: &[PathBuf]) -> Result<Vec<String>> {
    let text = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let own: Vec<String> = files.iter().map(|f| text(f.file_stem())).collect();
    let folder = |f: &PathBuf| {
        let full = std::fs::canonicalize(f).unwrap_or_else(|_| f.clone());
        text(full.parent().and_then(Path::file_name))
    };
    let is_twice = |name: &String, all: &[String]| all.iter().filter(|n| n.eq_ignore_ascii_case(name)).count() > 1;
    let any_twice = own.iter().any(|name| is_twice(name, &own));
    let names: Vec<String> = if any_twice { files.iter().map(folder).collect() } else { own };
    match files.iter().zip(&names).find(|(_, name)| is_twice(name, &names) || name.is_empty()) {
        Some((file, name)) => Err(Error::new(format!("two projects would have the name '{name}'"))
            .file(file)
            .help("give the project files different names, or put them into folders of different names")),
        None => Ok(names),
    }
}

/// Computes all rooms, each into the folder of `out` that has its name, and `glare/annual.csv` over
/// all of them.
///
/// # Errors
/// As [`run`](crate::simulate::run); results of the rooms before are there.
pub fn run_rooms(device: &Device, rooms: &[Room], out: &Path, progress: &dyn Progress, warnings: &mut Warnings) -> Result<Vec<Summary>> {
    let folders: Vec<PathBuf> = rooms.iter().map(|room| out.join(&room.name)).collect();
    let mut summaries = Vec::new();
    for (i, room) in rooms.iter().enumerate() {
        if progress.stop_requested() {
            return Err(cancelled());
        }
        // Later rooms too: their matrices may be there from an earlier run.
        let others: Vec<PathBuf> = folders.iter().filter(|f| **f != folders[i]).cloned().collect();
        let named = Named { room: &room.name, number: i, rooms: rooms.len(), progress };
        let store = Store::of(&folders[i], room.project.output.quantity)?.beside(others);
        summaries.push(compute(&context(device, &room.project, &room.inputs, &store, &named), warnings)?);
    }
    write_annual(out, rooms, &folders)?;
    Ok(summaries)
}

/// The rooms' tables one below the other, with a column for the room, and one for the state if any has
/// several.
fn write_annual(out: &Path, rooms: &[Room], folders: &[PathBuf]) -> Result<()> {
    let mut tables = Vec::new();
    for (room, folder) in rooms.iter().zip(folders).filter(|(room, _)| room.project.glare.is_some()) {
        let path = folder.join("glare/annual.csv");
        tables.push((&room.name, std::fs::read_to_string(&path).map_err(|e| Error::io(&path, &e))?));
    }
    let has_state = |text: &str| text.starts_with("view,state,");
    let Some((_, longest)) = tables.iter().max_by_key(|(_, text)| has_state(text)) else { return Ok(()) };
    let states = has_state(longest);
    let path = out.join("glare/annual.csv");
    let folder = out.join("glare");
    std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, &e))?;
    write_atomically(&path, |file| {
        let fault = |e: std::io::Error| Error::io(&path, &e);
        writeln!(file, "room,{}", longest.lines().next().unwrap_or_default()).map_err(fault)?;
        for (room, text) in &tables {
            for line in text.lines().skip(1) {
                match line.split_once(',') {
                    Some((view, rest)) if states && !has_state(text) => writeln!(file, "{room},{view},,{rest}"),
                    _ => writeln!(file, "{room},{line}"),
                }
                .map_err(fault)?;
            }
        }
        Ok(())
    })
}

/// Progress with the room's name.
struct Named<'a> {
    room: &'a str,
    number: usize,
    rooms: usize,
    progress: &'a dyn Progress,
}

impl Progress for Named<'_> {
    fn update(&self, stage: &str, fraction: f64) {
        self.progress.update(&format!("{}: {stage}", self.room), fraction);
    }

    /// All rooms count alike.
    fn update_of_whole(&self, stage: &str, fraction: f64, whole: Whole) {
        let others = (self.rooms - self.number - 1) as f64;
        let seconds_left = whole.seconds_left.map(|left| left + others * left / (1.0 - whole.share).max(0.01));
        let whole = Whole { share: (self.number as f64 + whole.share) / self.rooms as f64, seconds_left };
        self.progress.update_of_whole(&format!("{}: {stage}", self.room), fraction, whole);
    }

    fn shows_whole(&self) -> bool {
        self.progress.shows_whole()
    }

    fn stop_requested(&self) -> bool {
        self.progress.stop_requested()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rooms_are_named_after_their_files_or_folders() {
        let of = |files: &[&str]| names(&files.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["a/north.toml", "a/south.toml"]).unwrap(), ["north", "south"]);
        assert_eq!(of(&["x/attic/project.toml", "x/cellar/project.toml"]).unwrap(), ["attic", "cellar"]);
        for files in [&["a/p.toml", "b/a/p.toml"][..], &["p.toml", "p.toml"]] {
            let error = of(files).unwrap_err().to_string();
            assert!(error.contains("two projects") && error.contains("p.toml"), "{error}");
        }
    }
}

//! Projects made in code. A builder writes the project file that one would write by hand, so that checks,
//! defaults and messages are the same.

use super::Project;
use crate::error::{Error, Result};
use serde::Serialize;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Sections of which there may be several.
const REPEATED: [&str; 5] = ["window", "sensors", "view", "views", "moment"];

/// A project in the making; see [`Project::builder`].
#[derive(Debug, Clone)]
pub struct ProjectBuilder {
    folder: PathBuf,
    sections: Table,
    /// The first value that TOML cannot hold.
    fault: Option<Error>,
}

impl Project {
    /// A project made in code; paths are relative to `folder`.
    ///
    /// ```
    /// use lucarne::simulate::Project;
    /// let project = Project::builder("scenes/analytic/furnace")
    ///     .weather("../../office/weather/new_york.wea")
    ///     .scene(&["room.rad"])
    ///     .window("south", "window.rad", "../../office/bsdf/double_clear.xml")
    ///     .sensors("desk", "points.txt")
    ///     .set("quality", "preset", "draft")
    ///     .build()?;
    /// assert_eq!(project.windows[0].name, "south");
    /// # lucarne::Result::Ok(())
    /// ```
    pub fn builder(folder: impl AsRef<Path>) -> ProjectBuilder {
        ProjectBuilder { folder: folder.as_ref().to_path_buf(), sections: Table::new(), fault: None }
    }
}

impl ProjectBuilder {
    /// `[weather]`: a WEA or EPW file.
    #[must_use]
    pub fn weather(self, file: &str) -> Self {
        self.set("weather", "file", file)
    }

    /// `[scene]`: Radiance or glTF files of the room, without its windows.
    #[must_use]
    pub fn scene(self, files: &[&str]) -> Self {
        self.set("scene", "files", files)
    }

    /// A `[[window]]` with its surface and its BSDF.
    #[must_use]
    pub fn window(self, name: &str, surface: &str, bsdf: &str) -> Self {
        self.begin("window").set("window", "name", name).set("window", "surface", surface).set("window", "bsdf", bsdf)
    }

    /// A `[[window]]` of clear glass: its surface, and its visible transmittance at normal incidence.
    #[must_use]
    pub fn glass_window(self, name: &str, surface: &str, transmittance: f64) -> Self {
        self.begin("window").set("window", "name", name).set("window", "surface", surface).set("window", "glass", transmittance)
    }

    /// A group of `[[sensors]]`: a file of `x y z dx dy dz` lines.
    #[must_use]
    pub fn sensors(self, name: &str, points: &str) -> Self {
        self.begin("sensors").set("sensors", "name", name).set("sensors", "points", points)
    }

    /// A `[[view]]` of so many pixels, across and down.
    #[must_use]
    pub fn view(self, name: &str, file: &str, resolution: [usize; 2]) -> Self {
        self.begin("view").set("view", "name", name).set("view", "file", file).set("view", "resolution", resolution)
    }

    /// Begins another section of those that may be several (`window`, `sensors`, `view`, `views`, `moment`), or a section
    /// all of whose keys have defaults (`glare`).
    #[must_use]
    pub fn begin(mut self, section: &str) -> Self {
        if REPEATED.contains(&section) {
            if let Value::Array(all) = self.sections.entry(section).or_insert_with(|| Value::Array(Vec::new())) {
                all.push(Value::Table(Table::new()));
            }
        } else {
            self.sections.entry(section).or_insert_with(|| Value::Table(Table::new()));
        }
        self
    }

    /// Any key of a section as project files have it ([`project`](crate::simulate::project)); of several sections
    /// of a name it is the one added last.
    #[must_use]
    pub fn set(mut self, section: &str, key: &str, value: impl Serialize) -> Self {
        if !self.sections.contains_key(section) {
            self = self.begin(section);
        }
        let table = match self.sections.get_mut(section) {
            Some(Value::Array(all)) => all.last_mut(),
            other => other,
        };
        match (Value::try_from(value), table) {
            (Ok(value), Some(Value::Table(table))) => {
                table.insert(key.to_string(), value);
            }
            (Err(e), _) => self.fault = self.fault.or_else(|| Some(Error::new(e.to_string()).field(format!("{section}.{key}")))),
            _ => {}
        }
        self
    }

    /// The project file.
    ///
    /// # Errors
    /// A value that project files cannot hold.
    pub fn to_toml(&self) -> Result<String> {
        match &self.fault {
            Some(fault) => Err(fault.clone()),
            None => toml::to_string(&self.sections).map_err(|e| Error::new(e.to_string())),
        }
    }

    /// Checks the project as [`Project::read`] does. Lines in messages are those of `to_toml`.
    ///
    /// # Errors
    /// As [`Project::read`].
    pub fn build(self) -> Result<Project> {
        Project::parse(&self.folder.join("(built in code)"), &self.to_toml()?)
    }

    /// Writes the project file into its folder and reads it: whoever opens the results finds the room by it.
    ///
    /// # Errors
    /// As [`Project::read`], and failures of the file system.
    pub fn save(self, name: &str) -> Result<Project> {
        let (file, text) = (self.folder.join(name), self.to_toml()?);
        crate::files::write_atomically(&file, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io(&file, &e)))?;
        Project::read(&file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_made_in_code_is_checked_as_one_of_a_file() {
        let room = |folder: &str| {
            Project::builder(folder)
                .weather("../../office/weather/new_york.wea")
                .scene(&["room.rad"])
                .window("south", "window.rad", "../../bsdf/clear.xml")
                .sensors("desk", "points.txt")
        };
        let furnace = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/analytic/furnace");
        let project = room(furnace).sensors("floor", "points.txt").set("quality", "seed", 7).set("method", "bounces", 2).build().unwrap();
        assert_eq!((project.quality.seed, project.method.bounces, project.sensors.len()), (7, Some(2), 2));
        let error = room(furnace).set("quality", "sed", 7).build().unwrap_err().to_string();
        assert!(error.contains("(built in code)") && error.contains("did you mean 'seed'?"), "{error}");
        let error = room("no/folder").build().unwrap_err().to_string();
        assert!(error.contains("there is no file") && error.contains("no/folder"), "{error}");
        let error = room(furnace).set("quality", "seed", u64::MAX).build().unwrap_err().to_string();
        assert!(error.contains("quality.seed"), "{error}");
        let glare = room(furnace).set("view", "name", "seat").begin("glare").to_toml().unwrap();
        assert!(glare.contains("[[view]]") && glare.contains("[glare]"), "{glare}");
    }

    #[test]
    fn a_saved_project_is_the_same() {
        let folder = tempfile::tempdir().unwrap();
        for file in ["w.wea", "r.rad", "s.rad", "b.xml", "p.txt"] {
            std::fs::write(folder.path().join(file), "").unwrap();
        }
        let builder =
            Project::builder(folder.path()).weather("w.wea").scene(&["r.rad"]).window("south", "s.rad", "b.xml").sensors("desk", "p.txt");
        let (built, saved) = (builder.clone().build().unwrap(), builder.save("room.toml").unwrap());
        assert_eq!(saved.file, folder.path().join("room.toml"));
        // But for the name that messages give.
        let told = |project: &Project| format!("{project:?}").replace("(built in code)", "room.toml");
        assert_eq!(told(&built), told(&saved));
    }
}

//! Projects of a model and a weather file, without a project file.

use super::Project;
use crate::error::{Error, Result};
use crate::files;
use std::path::{Path, PathBuf};

/// The first line of project files that are written for models.
const HEADER: &str = "# Written by `lucarne run` for a model; sections may be added below.";

impl Project {
    /// The project of a Honeybee model and a weather file. With a folder its project file, `project.toml`, is kept
    /// there, where whoever opens the results finds the room by it; what was added to it counts.
    ///
    /// # Errors
    /// As [`Project::read`]; a project file in the folder that is another's.
    pub fn of_model(model: &Path, weather: &Path, folder: Option<&Path>) -> Result<Self> {
        // Before any folder is made.
        for file in [model, weather] {
            std::fs::metadata(file).map_err(|e| Error::io(file, &e))?;
        }
        let made = |folder: &Path, path: &dyn Fn(&Path) -> PathBuf| -> super::builder::ProjectBuilder {
            let text = |file: &Path| path(file).to_string_lossy().replace('\\', "/");
            Self::builder(folder).weather(&text(weather)).set("scene", "model", text(model))
        };
        let Some(folder) = folder else { return made(Path::new(""), &Path::to_path_buf).build() };
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, &e))?;
        let file = folder.join("project.toml");
        let builder = made(folder, &|file| files::relative(folder, file));
        let text = format!("{HEADER}\n{}", builder.to_toml()?);
        if file.exists() {
            let there = crate::text::read(&file, "a project file")?;
            // The same model and weather, perhaps with more below.
            if there.starts_with(&text) {
                return Self::read(&file);
            }
            if !there.starts_with(HEADER) || there.lines().count() != text.lines().count() {
                return Err(Error::new("this folder has a project file of its own")
                    .file(&file)
                    .help("give another folder (-o), or run that file: lucarne run project.toml"));
            }
        }
        files::write_atomically(&file, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io(&file, &e)))?;
        Self::read(&file)
    }
}

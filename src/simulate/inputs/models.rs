//! What a project leaves out of the models that it names.

use crate::error::{Error, Result, Warnings};
use crate::scene::{Format, honeybee, split_part};
use crate::simulate::project::{Filling, Project, SensorPoints};
use std::path::Path;

/// Names the windows, grids and views of the project's models that it does not use.
///
/// # Errors
/// A model that cannot be read any more.
pub(super) fn warn(project: &Project, warnings: &mut Warnings) -> Result<()> {
    for file in project.scene.files.iter().filter(|f| Format::of(f) == Format::Honeybee) {
        let model = honeybee::read(file, &mut Warnings::new())?;
        let names = |path: &Path, own: &str, name: &str| {
            let (of, part) = split_part(path);
            of == *file && part.as_deref().unwrap_or(own) == name
        };
        let windows = |name: &str| {
            // A section without a part takes the window of its name, or all if there is none.
            let is_whole =
                |path: &Path| path == file && !model.windows.iter().any(|w| project.windows.iter().any(|s| s.name == w.window.name));
            project.windows.iter().any(|s| is_whole(&s.surface)) || project.windows.iter().any(|s| names(&s.surface, &s.name, name))
        };
        let unused: Vec<&str> = model.windows.iter().map(|w| w.window.name.as_str()).filter(|name| !windows(name)).collect();
        let told = |what: &str, names: &[&str], help: &str| {
            let text = format!("{} {what}: {}", names.len(), names.join(", "));
            Error::new(text).file(file).help(help)
        };
        if !unused.is_empty() {
            let what = "windows of the model are in no [[window]], so no light comes in by them";
            warnings.push(told(
                what,
                &unused,
                "add a [[window]] with surface = \"model.hbjson#NAME\", or take all [[window]] out: then all are used",
            ));
        }
        for window in model.windows.iter().filter(|w| !w.states.is_empty()) {
            let Some(section) = project.windows.iter().find(|s| names(&s.surface, &s.name, &window.window.name)) else { continue };
            if section.states.is_empty() && section.filling == Filling::SceneGlass {
                let text = format!(
                    "window '{}' is that of the first of {} states of the model's dynamic group",
                    section.name,
                    window.states.len()
                );
                warnings.push(
                    section
                        .place
                        .of(Error::new(text))
                        .help("give it [[window.state]]s, or take all [[window]] out: then it has those of the model"),
                );
            }
        }
        let views = |name: &str| project.views.iter().any(|s| names(&s.file, &s.name, name));
        let unused: Vec<&str> = model.views.iter().map(|v| v.name.as_str()).filter(|name| !views(name)).collect();
        if !unused.is_empty() {
            warnings.push(told(
                "views of the model are not computed",
                &unused,
                "add [glare] or [images] to the project file for glare and pictures of them",
            ));
        }
        let grids =
            |name: &str| project.sensors.iter().any(|s| matches!(&s.points, SensorPoints::File(points) if names(points, &s.name, name)));
        let unused: Vec<&str> = model.sensors.iter().map(|g| g.name.as_str()).filter(|name| !grids(name)).collect();
        if !unused.is_empty() {
            warnings.push(told(
                "sensor grids of the model are not computed",
                &unused,
                "add [[sensors]] with points = \"model.hbjson#NAME\"",
            ));
        }
    }
    Ok(())
}

//! A result folder with the room it belongs to.

use super::arrays::Year;
use crate::error::{Result, Warnings};
use crate::scene::{MaterialIndex, Scene, Triangle, Window};
use crate::simulate::inputs::glazing::glazing;
use crate::simulate::inputs::reach::Light;
use crate::simulate::inputs::{grids, read_scene, read_surfaces};
use crate::simulate::project::{Filling, Project};
use crate::weather::Weather;
use crate::weather::time::Time;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A result folder, read back: the year and, if its project is found, the room.
///
/// ```no_run
/// let results = lucarne::simulate::Results::open("out/office".as_ref())?;
/// for group in &results.year.sensors {
///     println!("{}: {} lx at the first sensor at noon of the first day", group.name, group.illuminance.at(0, 12)[0]);
/// }
/// # lucarne::Result::Ok(())
/// ```
#[derive(Debug, Clone)]
pub struct Results {
    /// What was computed.
    pub year: Year,
    /// The room and its site, if the project is found.
    pub surroundings: Option<Surroundings>,
}

/// What the project of a result folder tells of the room.
#[derive(Debug, Clone)]
pub struct Surroundings {
    /// The project.
    pub project: Project,
    /// The room, its windows included.
    pub scene: Scene,
    /// The windows that the project names.
    pub windows: Vec<Window>,
    /// Site and weather.
    pub weather: Weather,
    /// Further states of windows that the project names: BSDF files by the window's name.
    pub states: HashMap<String, Vec<PathBuf>>,
}

impl Results {
    /// Reads a result folder and, where it finds the project, the room.
    ///
    /// # Errors
    /// As [`Year::open`]. A project that is missing or has changed is a note in [`Year::notes`].
    pub fn open(folder: &Path) -> Result<Self> {
        let mut year = Year::open(folder)?;
        let stated = Some(&year.summary.project).filter(|p| !p.as_os_str().is_empty()).map(|p| folder.join(p));
        let mut surroundings = None;
        if let Some(project) = stated.or_else(|| guess_project(folder)) {
            match Surroundings::read(&project, &mut year) {
                Ok(found) => surroundings = Some(found),
                Err(e) => year.notes.push(format!("the room's outline and the sun are not shown: {e}")),
            }
        }
        if let Some(weather) = surroundings.as_ref().map(|s| &s.weather)
            && weather.records.len() == year.times.len()
        {
            year.times = weather.records.iter().map(Time::from).collect();
        }
        Ok(Self { year, surroundings })
    }
}

impl Surroundings {
    /// Reads the room of a project, and where the sensors of its year face.
    fn read(file: &Path, year: &mut Year) -> Result<Self> {
        let project = Project::read(file)?;
        let mut warnings = Warnings::new();
        let weather = project.weather.load(&mut warnings)?;
        let mut scene = read_scene(&project, &mut warnings)?;
        let (mut states, mut windows) = (HashMap::new(), Vec::new());
        for section in &project.windows {
            // A section of several windows names each after itself.
            let own = |name: &&String| **name == section.name || name.starts_with(&format!("{}-", section.name));
            let data =
                section.states.iter().skip(1).filter_map(|s| if let Filling::Bsdf(file) = &s.filling { Some(file.clone()) } else { None });
            let data: Vec<PathBuf> = data.collect();
            if !data.is_empty() {
                let names = year.summary.windows.iter().map(|w| &w.name).filter(own);
                states.extend(names.map(|name| (name.clone(), data.clone())));
            }
            let mut of_section = read_surfaces(&project, section, &mut warnings)?;
            // As the results call them.
            let single = of_section.len() == 1;
            for window in &mut of_section {
                window.name = if single { section.name.clone() } else { format!("{}-{}", section.name, window.name) };
            }
            windows.extend(of_section);
        }
        let direct = project.choice(&glazing(&project)?).direct;
        for section in &project.sensors {
            let light = if direct { Light::Sky } else { Light::Windows(&windows) };
            let sensors = grids::sensors(&project, section, &scene, light, &mut warnings)?;
            if let Some(group) = year.sensors.iter_mut().find(|g| g.name == section.name && g.count() == sensors.len()) {
                group.positions = sensors.iter().map(|s| s.position).collect();
                group.directions = sensors.iter().map(|s| s.direction).collect();
            }
        }
        // Windows are part of the outline.
        for window in &windows {
            let surface = scene.surfaces.len() as u32;
            scene.surfaces.push(window.origin.clone());
            let triangle = |t: &[glam::DVec3; 3]| Triangle { vertices: *t, material: MaterialIndex(u32::MAX), surface };
            scene.triangles.extend(window.triangles.iter().map(triangle));
        }
        Ok(Self { project, scene, windows, weather, states })
    }
}

/// A result folder `out/NAME` of a checkout whose project is `scenes/NAME/project.toml`.
fn guess_project(folder: &Path) -> Option<PathBuf> {
    let folder = std::path::absolute(folder).ok()?;
    let project = folder.parent()?.parent()?.join("scenes").join(folder.file_name()?).join("project.toml");
    project.exists().then_some(project)
}

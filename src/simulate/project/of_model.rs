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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Warnings;
    use crate::simulate::Inputs;
    use crate::simulate::project::Filling;

    fn scenes() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
    }

    fn texts(warnings: &Warnings) -> Vec<String> {
        warnings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_model_and_weather_are_a_whole_project() {
        let (model, weather) = (scenes().join("honeybee_room/room.hbjson"), scenes().join("office/weather/new_york.wea"));
        for model in [model.clone(), model.with_file_name("model")] {
            let project = Project::of_model(&model, &weather, None).unwrap();
            let mut names: Vec<&str> = project.windows.iter().map(|w| w.name.as_str()).collect();
            names.sort_unstable();
            assert_eq!(names, ["facade", "roof_light", "south", "terrace", "west_blind"]);
            let filling = |name: &str| &project.windows.iter().find(|w| w.name == name).unwrap().filling;
            assert_eq!(*filling("south"), Filling::SceneGlass);
            assert!(matches!(filling("west_blind"), Filling::Bsdf(_)));
            let mut warnings = Warnings::new();
            let inputs = Inputs::read(&project, &mut warnings).unwrap();
            assert_eq!(inputs.sensors.iter().map(|g| g.sensors.len()).sum::<usize>(), 32);
            let window = |name: &str| inputs.windows.iter().find(|w| w.name == name).unwrap();
            assert!((window("south").window.area() - 2.8).abs() < 1e-9 && window("west_blind").transmission.rows() == 41);
            assert_eq!(window("facade").glass.unwrap().transmissivity, [0.65; 3]);
            let of_states: Vec<_> = window("facade").states.iter().map(|s| (s.name.as_str(), s.glass.unwrap().transmissivity)).collect();
            assert_eq!(of_states, [("0_facade", [0.65; 3]), ("1_facade", [0.1, 0.12, 0.14])]);
            assert_eq!(inputs.facade.groups()[0].states, ["0_facade", "1_facade"]);
            assert!(!inputs.seem_dark.contains(&true));
            let told = texts(&warnings);
            assert!(told.len() == 3 && told[1].contains("1 views of the model are not computed: desk"), "{told:?}");
            assert!(told[2].contains("nothing decides the state of the windows 'facade'") && told[2].contains("'0_facade'"), "{told:?}");
        }
    }

    #[test]
    fn the_project_file_of_a_model_is_kept_and_what_is_added_to_it_counts() {
        let out = tempfile::tempdir().unwrap();
        let (model, weather) = (scenes().join("honeybee_room/room.hbjson"), scenes().join("office/weather/new_york.wea"));
        let file = out.path().join("results/project.toml");
        let made = || Project::of_model(&model, &weather, Some(&out.path().join("results")));
        assert_eq!((made().unwrap().file, made().unwrap().views.len()), (file.clone(), 0));
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, format!("{text}\n[glare]\nmethod = \"dgps\"\n[quality]\nseed = 7\n")).unwrap();
        let project = made().unwrap();
        assert_eq!((project.quality.seed, project.views.len(), project.views[0].name.as_str()), (7, 1, "desk"));
        assert_eq!(project.views[0].view.unwrap().point, glam::DVec3::new(2.0, 5.0, 1.2));
        // Another's file is left alone, and so is what was added for another weather.
        let other = scenes().join("blinds/weather.wea");
        let error = Project::of_model(&model, &model, Some(&out.path().join("results"))).unwrap_err().to_string();
        assert!(error.contains("a project file of its own") && error.contains("help:"), "{error}");
        std::fs::write(&file, "[scene]\nfiles = [\"room.rad\"]\n").unwrap();
        assert!(made().unwrap_err().to_string().contains("a project file of its own"));
        assert!(Project::of_model(&model, &other.join("none.epw"), None).unwrap_err().to_string().contains("none.epw"));
    }

    #[test]
    fn control_moves_the_groups_of_a_model() {
        let folder = tempfile::tempdir().unwrap();
        let write = |control: &str| {
            let (model, weather) = (scenes().join("honeybee_room/room.hbjson"), scenes().join("office/weather/new_york.wea"));
            let text =
                format!("[weather]\nfile = \"{}\"\n[scene]\nmodel = \"{}\"\n[control]\n{control}\n", weather.display(), model.display());
            std::fs::write(folder.path().join("p.toml"), text).unwrap();
            Project::read(&folder.path().join("p.toml"))
        };
        let inputs = Inputs::read(&write("facade = \"1_facade\"").unwrap(), &mut Warnings::new()).unwrap();
        let window = inputs.windows.iter().find(|w| w.name == "facade").unwrap();
        assert_eq!((window.glass.unwrap().transmissivity, window.state), ([0.1, 0.12, 0.14], 1));
        std::fs::write(folder.path().join("s.csv"), "from,facade\n01-01T00:00,0\n07-01T00:00,1_facade\n").unwrap();
        let inputs = Inputs::read(&write("facade = \"s.csv\"").unwrap(), &mut Warnings::new()).unwrap();
        assert!(inputs.moves() && inputs.schedule.at(0, 0) == 0 && inputs.schedule.at(0, inputs.schedule.steps() - 1) == 1);
        let error = write("facade = \"2_facade\"").unwrap_err().to_string();
        assert!(error.contains("neither a state of the group 'facade' nor a file"), "{error}");
        let error = write("south = \"open\"").unwrap_err().to_string();
        assert!(error.contains("no group of windows 'south'"), "{error}");
    }

    #[test]
    fn parts_of_a_model_can_be_named_and_those_left_out_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let write = |more: &str| {
            let model = scenes().join("honeybee_room/room.hbjson");
            let (model, weather) = (model.display(), scenes().join("office/weather/new_york.wea"));
            let text = format!(
                "[weather]\nfile = \"{}\"\n[scene]\nmodel = \"{model}\"\n{}",
                weather.display(),
                more.replace("MODEL", &model.to_string())
            );
            std::fs::write(folder.path().join("p.toml"), text).unwrap();
            Project::read(&folder.path().join("p.toml"))
        };
        let project = write(
            "[[window]]\nname = \"main\"\nsurface = \"MODEL#south\"\nglass = 0.5\n\
             [[window]]\nname = \"west\"\nsurface = \"MODEL#west_blind\"\nbsdf = \"MODEL#blind\"\n\
             [[sensors]]\nname = \"grid\"\npoints = \"MODEL#Workplane\"\n[[view]]\nname = \"seat\"\nfile = \"MODEL#desk\"\n",
        );
        let mut warnings = Warnings::new();
        let inputs = Inputs::read(&project.unwrap(), &mut warnings).unwrap();
        assert_eq!((inputs.windows.len(), inputs.sensors[0].sensors.len()), (2, 24));
        let told = texts(&warnings).join("\n");
        assert!(told.contains("3 windows of the model are in no [[window]]") && told.contains(": terrace, facade, roof_light"), "{told}");
        assert!(told.contains("1 sensor grids of the model are not computed: Corridor") && !told.contains("1 views"), "{told}");
        for (more, words) in [
            ("[[window]]\nname = \"w\"\nsurface = \"MODEL#north\"\nglass = 0.5\n", "there is no window 'north', but: "),
            ("[[sensors]]\nname = \"w\"\npoints = \"MODEL#attic\"\n", "there is no grid of sensors 'attic', but: Workplane, Corridor"),
            ("[[view]]\nname = \"w\"\nfile = \"MODEL#attic\"\n", "there is no view 'attic', but: desk"),
            ("[[window]]\nname = \"w\"\nsurface = \"MODEL#west_blind\"\nglass = \"scene\"\n", "glass"),
        ] {
            let error = write(more).and_then(|p| Inputs::read(&p, &mut Warnings::new())).map(|_| ()).unwrap_err().to_string();
            assert!(error.contains(words), "{words}: {error}");
        }
        std::fs::write(folder.path().join("p.toml"), "[weather]\nfile = \"p.toml\"\n[scene]\nmodel = \"p.toml\"\n").unwrap();
        let error = Project::read(&folder.path().join("p.toml")).unwrap_err().to_string();
        assert!(error.contains("p.toml:4:") && error.contains("no Honeybee model"), "{error}");
    }
}

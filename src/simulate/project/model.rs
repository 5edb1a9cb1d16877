//! `[scene] model = "room.hbjson"`: windows, sensors and views of a Honeybee model, where the project names none.
//!
//! ```toml
//! [weather]
//! file = "city.epw"
//! [scene]
//! model = "room.hbjson"
//! files = ["street.rad"]              # optional: what else there is
//! ```
//!
//! That is a whole project. Without `[[window]]` all windows of the model are taken, with the glass or BSDF that it
//! gives them, and the states of its dynamic groups, which `[control]` moves; without `[[sensors]]` and `[[view]]` its sensor grids, or its views if it has no grids. Pictures and
//! glare of a project without `[[view]]` are those of the model's views. Parts of a model can be named, too:
//! `surface = "room.hbjson#south"`, `points = "room.hbjson#Workplane"`, `file = "room.hbjson#desk"` of a view,
//! `bsdf = "room.hbjson#blind"` of a modifier.

use super::filling::{Filling, SunData};
use super::given::GivenPictures;
use super::parts::Parts;
use super::sections::{SensorPoints, SensorsSection, WindowSection};
use super::states::StateSection;
use super::table::Place;
use super::views::{DEFAULT_RESOLUTION, ViewSection, view_of_options};
use crate::error::{Error, Result, Warnings};
use crate::scene::honeybee::{self, Model, ModelGlazing, ModelSun};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A model that a project names, where it stands there.
pub(super) struct NamedModel {
    file: PathBuf,
    model: Rc<Model>,
    place: Place,
}

impl NamedModel {
    /// Reads it. What it is warned of, the inputs say.
    ///
    /// # Errors
    /// As [`honeybee::read`].
    pub fn read(file: &Path, place: Place) -> Result<Self> {
        if !honeybee::is_honeybee(file) {
            return Err(place
                .of(Error::new(format!("'{}' is no Honeybee model", file.display())))
                .help("a model is an .hbjson file; Radiance and glTF files belong into files = [\"room.rad\"]"));
        }
        Ok(Self { file: file.to_path_buf(), model: honeybee::read(file, &mut Warnings::new())?, place })
    }

    fn part(&self, name: &str) -> PathBuf {
        PathBuf::from(format!("{}#{name}", self.file.display()))
    }

    /// All its windows; none for a model without, as of a courtyard.
    pub fn windows(&self) -> Vec<WindowSection> {
        let sun = |name: &str, sun: Option<&ModelSun>| match sun {
            Some(ModelSun::Shade(_)) => (Some(self.part(name)), None),
            Some(ModelSun::Bsdf(data)) => (None, Some(SunData::of_file(data.clone()))),
            None => (None, None),
        };
        let section = |window: &honeybee::ModelWindow| {
            let name = &window.window.name;
            let state = |state: &honeybee::ModelState| {
                let (shade, tensor_tree) = sun(&honeybee::sun_part(name, &state.name), state.sun.as_ref());
                let filling = match &state.glazing {
                    ModelGlazing::Glass(pane) => Filling::Pane(*pane),
                    ModelGlazing::Bsdf(data) => Filling::Bsdf(data.clone()),
                };
                StateSection { name: state.name.clone(), filling, place: self.place.clone(), shade, tensor_tree }
            };
            let states: Vec<StateSection> = window.states.iter().map(state).collect();
            let (shade, tensor_tree) = match states.first() {
                Some(first) => (first.shade.clone(), first.tensor_tree.clone()),
                None => sun(&honeybee::sun_part(name, ""), window.sun.as_ref()),
            };
            WindowSection {
                name: name.clone(),
                group: window.group.clone(),
                group_place: self.place.clone(),
                surface: self.part(name),
                filling: match (states.first(), &window.glazing) {
                    (Some(first), _) => first.filling.clone(),
                    (None, ModelGlazing::Glass(_)) => Filling::SceneGlass,
                    (None, ModelGlazing::Bsdf(data)) => Filling::Bsdf(data.clone()),
                },
                place: self.place.clone(),
                shade,
                tensor_tree,
                states,
                daylight: None,
                parts: Parts::default(),
                parts_place: self.place.clone(),
                found: None,
            }
        };
        self.model.windows.iter().map(section).collect()
    }

    /// All its sensor grids.
    pub fn sensors(&self) -> Vec<SensorsSection> {
        let section =
            |name: &String| SensorsSection { name: name.clone(), points: SensorPoints::File(self.part(name)), view: None, sun: None };
        self.model.sensors.iter().map(|g| section(&g.name)).collect()
    }

    /// All its views.
    ///
    /// # Errors
    /// Views that no camera has.
    pub fn views(&self) -> Result<Vec<ViewSection>> {
        let section = |view: &honeybee::ModelView| {
            Ok(ViewSection {
                name: view.name.clone(),
                file: self.part(&view.name),
                view: Some(view_of_options(&view.options).map_err(|e| e.file(self.part(&view.name)))?),
                resolution: DEFAULT_RESOLUTION,
                place: self.place.clone(),
                given: GivenPictures::default(),
            })
        };
        self.model.views.iter().map(section).collect()
    }
}

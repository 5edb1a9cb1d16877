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
//! gives them; without `[[sensors]]` and `[[view]]` its sensor grids, or its views if it has no grids. Pictures and
//! glare of a project without `[[view]]` are those of the model's views. Parts of a model can be named, too:
//! `surface = "room.hbjson#south"`, `points = "room.hbjson#Workplane"`, `file = "room.hbjson#desk"` of a view,
//! `bsdf = "room.hbjson#blind"` of a modifier.

use super::filling::Filling;
use super::given::GivenPictures;
use super::parts::Parts;
use super::sections::{SensorPoints, SensorsSection, WindowSection};
use super::table::Place;
use super::views::{DEFAULT_RESOLUTION, ViewSection, view_of_options};
use crate::error::{Error, Result, Warnings};
use crate::scene::honeybee::{self, Model, ModelGlazing};
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
        let section = |window: &honeybee::ModelWindow| WindowSection {
            name: window.window.name.clone(),
            group: window.window.name.clone(),
            group_place: self.place.clone(),
            surface: self.part(&window.window.name),
            filling: match &window.glazing {
                ModelGlazing::Glass(_) => Filling::SceneGlass,
                ModelGlazing::Bsdf(data) => Filling::Bsdf(data.clone()),
            },
            place: self.place.clone(),
            shade: None,
            tensor_tree: None,
            states: Vec::new(),
            daylight: None,
            parts: Parts::default(),
            parts_place: self.place.clone(),
            found: None,
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

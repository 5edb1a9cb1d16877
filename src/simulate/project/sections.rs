//! `[scene]`, `[[window]]`, `[[sensors]]`.

use super::filling::{Filling, SunData, check_ways, filling, ways};
use super::given::ImportSection;
use super::names::{check, name};
use super::parts::Parts;
use super::states::StateSection;
use super::table::{Place, Table};
use crate::error::Result;
use crate::scene::Window;
use crate::scene::grid::Spread;
use std::path::PathBuf;

/// `[scene]`: the room and what stands around it, without its windows.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSection {
    /// Scene files, Radiance's in the order Radiance would get them; the model, if there is one, among them.
    pub files: Vec<PathBuf>,
}

/// One `[[window]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowSection {
    /// Name in results and messages.
    pub name: String,
    /// Radiance file with the window's polygons, normals into the room.
    pub surface: PathBuf,
    /// What it is made of.
    pub filling: Filling,
    /// Where that stands in the project file.
    pub place: Place,
    /// Slats and panes that the sun is traced through, Radiance file.
    pub shade: Option<PathBuf>,
    /// Scattering data that the sun is traced through in place of a shade.
    pub tensor_tree: Option<SunData>,
    /// The windows that it moves with: its own name, if none is given.
    pub group: String,
    /// Where that stands in the project file.
    pub group_place: Place,
    /// All its states, which share view and daylight matrices; empty for one state. What it is made of and what the sun
    /// is traced through, above, are then those of the first.
    pub states: Vec<StateSection>,
    /// D and Dd made elsewhere.
    pub daylight: Option<ImportSection>,
    /// Over what parts of it V and D are averaged.
    pub parts: Parts,
    /// Where that stands in the project file.
    pub parts_place: Place,
    /// The window itself, where the project names none and it was found in the scene.
    pub(crate) found: Option<Window>,
}

/// Where the sensors of a group are.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorPoints {
    /// `points`: a file of `x y z dx dy dz` lines.
    File(PathBuf),
    /// `surface = "floor.rad"`: over the polygons of a file.
    OverFile(PathBuf, Spread),
    /// `surface = "floor"`: over surfaces of the scene of this material or name.
    OverSurface(String, Spread),
}

/// One `[[sensors]]`: a group of sensors with one result file.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorsSection {
    /// Name of the group, and of its result files.
    pub name: String,
    /// Where they are.
    pub points: SensorPoints,
    /// V and Vd made elsewhere.
    pub view: Option<ImportSection>,
    /// Cds made elsewhere.
    pub sun: Option<PathBuf>,
}

impl SceneSection {
    /// The section, and where its `model` stands, which is the last of its files.
    pub(super) fn read(mut table: Table<'_, '_>) -> Result<(Self, Option<Place>)> {
        let place = table.place("model");
        let Some(file) = table.path("model")? else {
            let files = table.required_paths("files", "add files = [\"materials.rad\", \"room.rad\"], or model = \"room.hbjson\"")?;
            table.finish()?;
            return Ok((Self { files }, None));
        };
        let mut files = table.paths("files")?;
        table.finish()?;
        files.push(file);
        Ok((Self { files }, Some(place)))
    }
}

impl WindowSection {
    /// The section as it would stand for a window that is in this state for ever.
    ///
    /// # Panics
    /// If it has states, and no such one.
    #[must_use]
    pub fn in_state(&self, number: usize) -> Self {
        let mut same = Self { states: Vec::new(), ..self.clone() };
        if !self.states.is_empty() {
            let state = self.states[number].clone();
            (same.filling, same.place, same.shade, same.tensor_tree) = (state.filling, state.place, state.shade, state.tensor_tree);
        }
        same
    }

    /// The section in each of its states; itself if there is one only.
    pub fn each_state(&self) -> Vec<Self> {
        (0..self.states.len().max(1)).map(|number| self.in_state(number)).collect()
    }

    /// Whether the project names what suns are traced through, in any of its states.
    pub fn names_what_suns_pass(&self) -> bool {
        let of_states = self.states.iter().any(|s| s.shade.is_some() || s.tensor_tree.is_some());
        self.shade.is_some() || self.tensor_tree.is_some() || of_states
    }

    /// Whether suns are traced through it in any of its states, by the five-phase method: through what the project names,
    /// or clear panes.
    pub fn lets_suns_through(&self) -> bool {
        self.names_what_suns_pass() || self.filling.is_clear() || self.states.iter().any(|s| s.filling.is_clear())
    }

    /// Whether it has several states, none of which lets a sun through as such.
    pub fn has_states_of_data_alone(&self) -> bool {
        self.states.len() > 1 && !self.lets_suns_through()
    }

    /// Whether it is clear glass, in every state.
    pub fn is_glass(&self) -> bool {
        self.filling.is_glass() && self.states.iter().all(|s| s.filling.is_glass())
    }

    /// Whether a window of this name is of it: its own, or with its polygons' modifier where the section has several.
    pub fn is_of(&self, window: &str) -> bool {
        window.strip_prefix(&self.name).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    }

    /// Files of scattering data, in all states; none of glass and layers.
    pub fn bsdf_files(&self) -> Vec<&PathBuf> {
        let mut files: Vec<&PathBuf> = self.filling.files().iter().collect();
        for file in self.states.iter().flat_map(|s| s.filling.files()) {
            if !files.contains(&file) {
                files.push(file);
            }
        }
        files
    }

    pub(super) fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let name = name(&mut table, "add name = \"south\" or the like")?;
        let surface =
            table.required_path("surface", "add surface = \"….rad\": the window's polygons, with normals that point into the room")?;
        let group = table.string("group")?;
        let group_place = table.place(if group.is_some() { "group" } else { "name" });
        if let Some(group) = &group {
            check(&table, "group", group)?;
        }
        let states = StateSection::read_all(&mut table)?;
        let (mut filling, mut place) = filling(&mut table, !states.is_empty())?;
        let (mut shade, mut tensor_tree) = ways(&mut table)?;
        check_ways(&table, &filling, shade.is_some(), tensor_tree.is_some())?;
        let own = [("shade", shade.is_some()), ("tensor_tree", tensor_tree.is_some())];
        if let (Some(first), Some((key, _))) = (states.first(), own.iter().find(|(_, given)| *given)) {
            let text = format!("the sun would be traced through the '{key}' of window '{name}' in all states, '{}' the first", first.name);
            return Err(table.error(key, text).help(format!("give each [[window.state]] its own '{key}', or none")));
        }
        if let Some(first) = states.first().cloned() {
            (filling, place, shade, tensor_tree) = (first.filling, first.place, first.shade, first.tensor_tree);
        }
        let daylight = ImportSection::read(&mut table, "daylight", "daylight_direct")?;
        let parts = Parts::read(&mut table)?;
        let parts_place = table.place("parts");
        table.finish()?;
        let group = group.unwrap_or_else(|| name.clone());
        Ok(Self {
            name,
            surface,
            filling,
            place,
            shade,
            tensor_tree,
            group,
            group_place,
            states,
            daylight,
            parts,
            parts_place,
            found: None,
        })
    }
}

/// Height of a work plane.
const WORK_PLANE: f64 = 0.8;

impl SensorPoints {
    fn read(table: &mut Table<'_, '_>) -> Result<Self> {
        let surface = table.string("surface")?;
        let spacing = table.number("spacing", 1e-3..=1e6)?;
        let height = table.number("height", 0.0..=1e6)?;
        let margin = table.number("margin", 0.0..=1e6)?;
        let Some(surface) = surface else {
            let help = "add points = \"….txt\" with a line 'x y z dx dy dz' per sensor, or surface = \"floor\" with spacing = 0.5";
            let Some(file) = table.path("points")? else {
                return Err(table.missing_all(&["points", "surface"], "has neither 'points' nor 'surface'", help));
            };
            if let Some((key, _)) = [("spacing", spacing), ("height", height), ("margin", margin)].iter().find(|(_, v)| v.is_some()) {
                return Err(table
                    .error(key, format!("'{key}' spreads sensors over a surface, but 'points' lists them"))
                    .help("give 'surface' in place of 'points', or take this out"));
            }
            return Ok(Self::File(file));
        };
        if table.path("points")?.is_some() {
            return Err(table
                .error("surface", "sensors are either listed in 'points' or spread over a 'surface'")
                .help("take one of the two out"));
        }
        let Some(spacing) = spacing else {
            return Err(table
                .error("surface", "sensors over a surface need their 'spacing'")
                .help("add spacing = 0.5 or the like, in the scene's unit"));
        };
        let spread = Spread { spacing, height: height.unwrap_or(WORK_PLANE), margin: margin.unwrap_or(0.0) };
        let is_file = ["rad", "gltf", "glb", "obj"].iter().any(|e| surface.to_lowercase().ends_with(&format!(".{e}")));
        let file = if is_file { table.path("surface")? } else { None };
        Ok(file.map_or(Self::OverSurface(surface, spread), |file| Self::OverFile(file, spread)))
    }
}

impl SensorsSection {
    pub(super) fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let name = name(&mut table, "add name = \"workplane\" or the like")?;
        let points = SensorPoints::read(&mut table)?;
        let view = ImportSection::read(&mut table, "view", "view_direct")?;
        let sun = table.path("sun")?;
        table.finish()?;
        Ok(Self { name, points, view, sun })
    }
}

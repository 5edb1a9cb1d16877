//! `[weather]`, `[scene]`, `[[window]]`, `[[sensors]]`.

use super::given::ImportSection;
use super::table::{Table, name};
use crate::error::Result;
use crate::scene::grid::Spread;
use std::path::PathBuf;

/// `[weather]`: where the hours come from.
#[derive(Debug, Clone, PartialEq)]
pub struct WeatherSection {
    /// Weather file, WEA or EPW.
    pub file: PathBuf,
}

/// `[scene]`: the room and what stands around it, without its windows.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneSection {
    /// Radiance scene files, in the order Radiance would get them.
    pub files: Vec<PathBuf>,
}

/// One `[[window]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowSection {
    /// Name in results and messages.
    pub name: String,
    /// Radiance file with the window's polygons, normals into the room.
    pub surface: PathBuf,
    /// Transmission of the window, Klems XML; the first of its states, if it has several.
    pub bsdf: PathBuf,
    /// Slats and panes that the sun is traced through, Radiance file.
    pub shade: Option<PathBuf>,
    /// Scattering data that the sun is traced through in place of a shade, XML of any kind.
    pub tensor_tree: Option<PathBuf>,
    /// Further states of the façade: glare is computed for each, with the same view and daylight
    /// matrices. All states, the first included; empty for one state.
    pub states: Vec<PathBuf>,
    /// D and Dd made elsewhere.
    pub daylight: Option<ImportSection>,
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

impl WeatherSection {
    pub(super) fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let file = table.required_path("file", "add file = \"….wea\" or \"….epw\"")?;
        table.finish()?;
        Ok(Self { file })
    }
}

impl SceneSection {
    pub(super) fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let files = table.required_paths("files", "add files = [\"materials.rad\", \"room.rad\"]")?;
        table.finish()?;
        Ok(Self { files })
    }
}

impl WindowSection {
    /// Whether suns are traced through it, by the five-phase method.
    pub fn lets_suns_through(&self) -> bool {
        self.shade.is_some() || self.tensor_tree.is_some()
    }

    pub(super) fn read(mut table: Table<'_, '_>) -> Result<Self> {
        let name = name(&mut table, "add name = \"south\" or the like")?;
        let surface =
            table.required_path("surface", "add surface = \"….rad\": the window's polygons, with normals that point into the room")?;
        let states = table.paths("states")?;
        let bsdf = match states.first() {
            // The key is asked for all the same, so that it is known.
            Some(first) => match table.path("bsdf")? {
                None => first.clone(),
                Some(_) => {
                    return Err(table
                        .error("bsdf", "a window has either one 'bsdf' or several 'states'")
                        .help("put this file first in 'states' and take 'bsdf' out"));
                }
            },
            None => table.required_path("bsdf", "add bsdf = \"….xml\": the window's Klems BSDF")?,
        };
        let shade = table.path("shade")?;
        let tensor_tree = table.path("tensor_tree")?;
        if shade.is_some() && tensor_tree.is_some() {
            return Err(table
                .error("tensor_tree", "the sun is traced either through a 'shade' or through a 'tensor_tree'")
                .help("keep the shade if there are slats or panes to trace, the tensor tree if there are only measured data"));
        }
        let daylight = ImportSection::read(&mut table, "daylight", "daylight_direct")?;
        table.finish()?;
        Ok(Self { name, surface, bsdf, shade, tensor_tree, states, daylight })
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
            let file = table.required_path("points", help)?;
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

//! Honeybee's Radiance folder, as honeybee-radiance writes it: `scene/`, `aperture/`, `aperture_group/`, `grid/`,
//! `view/` and `bsdf/` in one folder, `model`.

use super::assets::ModelView;
use super::geometry::Face3d;
use super::modifiers::{Kind, Modifier, basis_of};
use super::states::{self, Fate, Opening, OpeningState, StateShade};
use super::windows::{group, unique};
use super::{Model, all_groups, told_shades};
use crate::bsdf;
use crate::error::{Error, Result, Warnings};
use crate::scene::points::{self, SensorGrid};
use crate::scene::rad::{self, MadeOf, Polygon};
use crate::scene::{Material, MaterialIndex, MaterialKind, Scene, SurfaceOrigin, Triangle};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

/// What separates planes of windows, metres: Honeybee's default tolerance.
const TOLERANCE: f64 = 0.01;

/// Whether a folder is one that honeybee-radiance wrote.
pub(crate) fn is_folder(path: &Path) -> bool {
    path.is_dir() && (path.join("scene").is_dir() || path.join("aperture").is_dir() || path.join("model").is_dir())
}

/// Reads a folder. Lengths keep their unit, which should be metres: the files do not say.
///
/// # Errors
/// Anything wrong in its files; folders without surfaces.
pub(super) fn read(path: &Path, warnings: &mut Warnings) -> Result<Model> {
    let folder = if path.join("model").is_dir() { path.join("model") } else { path.to_path_buf() };
    let list = |name: &str, ending: &str| files(&folder.join(name), ending);
    let (mut groups, mut shade_groups) = (BTreeMap::new(), BTreeMap::new());
    let mut scene_files = list("scene", "mat")?;
    scene_files.extend(list("scene", "rad")?);
    for name in ["scene_dynamic", "scene_dynamic/indoor", "aperture_group/interior"] {
        for group in Group::read_all(&folder.join(name))? {
            shade_groups.insert(group.name, group.states.len());
            scene_files.push(group.states[0].default.clone());
        }
    }
    let mut scene = rad::read_scene(&scene_files, Path::new(""), warnings)?;
    let mut apertures = list("aperture", "mat")?;
    apertures.extend(list("aperture", "rad")?);
    let mut reader = Polygons { folder: &folder, scene: &mut scene, read: HashMap::new(), materials: HashMap::new() };
    let mut openings = Vec::new();
    for polygon in rad::read_polygons(&apertures, Path::new(""), warnings)? {
        let modifier = reader.modifier(&polygon, warnings)?;
        let face = Face3d { boundary: polygon.corners, holes: Vec::new() };
        if is_window(&modifier) {
            openings.push(Opening::of(face, modifier, None, polygon.origin));
        } else {
            // An opaque door.
            reader.add(&face, &modifier, polygon.origin);
        }
    }
    let mut first_only = BTreeMap::new();
    for group in Group::read_all(&folder.join("aperture_group"))? {
        groups.insert(group.name.clone(), group.states.len());
        for (face, origin, mut states) in reader.objects(&group, warnings)? {
            match states::judge(&states, false) {
                Fate::Moves => {}
                Fate::Stays => states.truncate(1),
                Fate::FirstOnly(why) => {
                    first_only.entry(group.name.clone()).or_insert((origin.name.clone(), why));
                    states.truncate(1);
                }
            }
            for shade in states[0].shades_of_scene() {
                reader.add(&shade.face, &shade.modifier, shade.origin.clone());
            }
            if states.len() == 1 && !is_window(&states[0].modifier) {
                reader.add(&face, &states[0].modifier, origin);
            } else {
                openings.push(Opening { face, group: Some(group.name.clone()), states, origin });
            }
        }
    }
    if scene.triangles.is_empty() && openings.is_empty() {
        return Err(Error::new("there is nothing in scene/ and aperture/ of this folder")
            .help("write it again: honeybee-radiance translate model-to-rad-folder model.hbjson"));
    }
    let (sensors, views) = assets(&folder)?;
    states::settle(&mut openings, &groups, &first_only, path, warnings);
    told_shades(&shade_groups, path, warnings);
    let windows = group(openings, TOLERANCE, warnings)?;
    Ok(Model { scene, windows, sensors, views, groups: all_groups(groups, shade_groups) })
}

fn is_window(modifier: &Modifier) -> bool {
    matches!(modifier.kind, Kind::Bsdf { .. } | Kind::Material(MaterialKind::Glass { .. }))
}

/// What polygons of the folder become.
struct Polygons<'a> {
    folder: &'a Path,
    scene: &'a mut Scene,
    /// Modifiers of scattering data.
    read: HashMap<String, Rc<Modifier>>,
    materials: HashMap<(String, String), MaterialIndex>,
}

impl Polygons<'_> {
    fn modifier(&mut self, polygon: &Polygon, warnings: &mut Warnings) -> Result<Rc<Modifier>> {
        let at = |e: Error| e.file(&polygon.origin.file).line(polygon.origin.line).field(format!("polygon '{}'", polygon.origin.name));
        let identifier = polygon.modifier.clone();
        let (file, up) = match &polygon.made_of {
            MadeOf::Material(kind) => return Ok(Rc::new(Modifier { identifier, kind: Kind::Material(*kind) })),
            MadeOf::Bsdf { file, up } => (file, *up),
        };
        if let Some(known) = self.read.get(&identifier) {
            return Ok(Rc::clone(known));
        }
        let data = scattering_data(self.folder, file).map_err(at)?;
        let basis = basis_of(&bsdf::read(&data, warnings)?).map_err(|e| e.file(&data))?;
        let modifier = Rc::new(Modifier { identifier: identifier.clone(), kind: Kind::Bsdf { up, basis, data } });
        self.read.insert(identifier, Rc::clone(&modifier));
        Ok(modifier)
    }

    /// Adds a surface; scattering data are none.
    fn add(&mut self, face: &Face3d, modifier: &Modifier, origin: SurfaceOrigin) {
        let Kind::Material(kind) = modifier.kind else { return };
        let scene = &mut *self.scene;
        // States have materials of their own, perhaps of the same name.
        let key = (modifier.identifier.clone(), format!("{kind:?}"));
        let material = *self.materials.entry(key).or_insert_with(|| {
            scene.materials.push(Material { name: modifier.identifier.clone(), kind });
            MaterialIndex((scene.materials.len() - 1) as u32)
        });
        let surface = scene.surfaces.len() as u32;
        scene.surfaces.push(origin);
        scene.triangles.extend(face.triangles().triangles.into_iter().map(|vertices| Triangle { vertices, material, surface }));
    }

    /// The apertures and doors of a group with all their states. In each file an object is followed by its shades; the
    /// black file has the objects alone.
    fn objects(&mut self, group: &Group, warnings: &mut Warnings) -> Result<Vec<(Face3d, SurfaceOrigin, Vec<OpeningState>)>> {
        let polygons = |file: &Path, warnings: &mut Warnings| rad::read_polygons(&[file.to_path_buf()], Path::new(""), warnings);
        let named: Option<HashSet<String>> = match &group.states[0].black {
            Some(file) if file.is_file() => Some(polygons(file, &mut Warnings::new())?.into_iter().map(|p| p.origin.name).collect()),
            _ => None,
        };
        let mut objects: Vec<(Face3d, SurfaceOrigin, Vec<OpeningState>)> = Vec::new();
        let mut numbers: HashMap<String, usize> = HashMap::new();
        for (number, state) in group.states.iter().enumerate() {
            let mut direct: HashMap<String, Rc<Modifier>> = HashMap::new();
            for polygon in state.direct.iter().filter(|f| f.is_file()).map(|f| polygons(f, warnings)).collect::<Result<Vec<_>>>()?.concat()
            {
                let modifier = self.modifier(&polygon, warnings)?;
                direct.insert(polygon.origin.name.clone(), modifier);
            }
            let mut last = None;
            for polygon in polygons(&state.default, warnings)? {
                let modifier = self.modifier(&polygon, warnings)?;
                let other = direct.get(&polygon.origin.name).filter(|d| d.identifier != modifier.identifier).cloned();
                let face = Face3d { boundary: polygon.corners, holes: Vec::new() };
                // Without a list of the objects, all polygons of the first state are objects.
                let known = numbers.get(&polygon.origin.name).copied();
                let is_object = named.as_ref().map_or(number == 0 || known.is_some(), |n| n.contains(&polygon.origin.name));
                if is_object {
                    let index = known.unwrap_or(objects.len());
                    if known.is_none() {
                        numbers.insert(polygon.origin.name.clone(), index);
                        objects.push((face, polygon.origin, Vec::new()));
                    }
                    objects[index].2.push(OpeningState { modifier, direct: other, shades: Vec::new() });
                    last = Some(index);
                } else if let Some(of) = last.and_then(|index| objects[index].2.last_mut()) {
                    let other = other.filter(|d| d.identifier != "black");
                    of.shades.push(StateShade { face, modifier, direct: other, origin: polygon.origin });
                }
            }
        }
        Ok(objects)
    }
}

/// Files of a folder and those below with this ending, by name; none if there is no such folder.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop().filter(|f| f.is_dir()) {
        for entry in std::fs::read_dir(&folder).map_err(|e| Error::io(&folder, &e))? {
            let path = entry.map_err(|e| Error::io(&folder, &e))?.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// A group of `states.json`.
struct Group {
    name: String,
    /// At least one.
    states: Vec<StateFiles>,
}

/// The files of a state.
struct StateFiles {
    default: PathBuf,
    direct: Option<PathBuf>,
    black: Option<PathBuf>,
}

impl Group {
    /// The groups of a folder; none if it has no `states.json`.
    fn read_all(folder: &Path) -> Result<Vec<Self>> {
        let file = folder.join("states.json");
        if !file.exists() {
            return Ok(Vec::new());
        }
        let wrong = |message: String| Error::new(message).file(&file).help("write the folder again");
        let value: Value = serde_json::from_slice(&crate::files::read(&file)?).map_err(|e| wrong(format!("this is no JSON: {e}")))?;
        let all = value.as_object().ok_or_else(|| wrong("this is no list of groups".into()))?;
        let mut found = Vec::new();
        for (name, list) in all {
            // Only what lies beside the list.
            let path = |number: usize, state: &Value, key: &str| {
                let Some(name) = state[key].as_str() else { return Ok(None) };
                if Path::new(name).components().any(|c| !matches!(c, Component::CurDir | Component::Normal(_))) {
                    return Err(wrong(format!("the file '{name}' of state {number} lies outside the folder")));
                }
                Ok(Some(folder.join(name)))
            };
            let state = |(number, state): (usize, &Value)| {
                let which = if number == 0 { "first state".to_string() } else { format!("file of state {number}") };
                let default = path(number, state, "default")?.ok_or_else(|| wrong(format!("group '{name}' has no {which}")))?;
                Ok(StateFiles { default, direct: path(number, state, "direct")?, black: path(number, state, "black")? })
            };
            let states = list.as_array().into_iter().flatten().enumerate().map(state).collect::<Result<Vec<_>>>()?;
            if states.is_empty() {
                return Err(wrong(format!("group '{name}' has no first state")));
            }
            found.push(Self { name: name.clone(), states });
        }
        Ok(found)
    }
}

/// Scattering data as the materials name them: from where the simulation runs, above the folder.
fn scattering_data(folder: &Path, name: &str) -> Result<PathBuf> {
    let above = folder.parent().unwrap_or(Path::new("")).join(name);
    let inside = folder.join("bsdf").join(Path::new(name).file_name().unwrap_or_default());
    [above, inside].into_iter().find(|p| p.is_file()).ok_or_else(|| {
        Error::new(format!("there is no file '{name}', neither above the folder nor in bsdf/")).help("write the folder again")
    })
}

/// Grids and views by the names of their files.
fn assets(folder: &Path) -> Result<(Vec<SensorGrid>, Vec<ModelView>)> {
    let mut taken = HashSet::new();
    let mut name = |folder: &Path, file: &Path| {
        let inside = file.strip_prefix(folder).unwrap_or(file).with_extension("");
        unique(&inside.to_string_lossy().replace(['/', '\\'], "-"), &mut taken)
    };
    let (grid, view) = (folder.join("grid"), folder.join("view"));
    let mut sensors = Vec::new();
    for file in files(&grid, "pts")? {
        sensors.push(SensorGrid { name: name(&grid, &file), sensors: points::read_points(&file)? });
    }
    let mut views = Vec::new();
    for file in files(&view, "vf")? {
        let text = crate::text::read(&file, "a view file")?;
        let options: Vec<&str> = text.split_whitespace().skip_while(|w| !w.starts_with("-v")).collect();
        views.push(ModelView { name: name(&view, &file), options: options.join(" ") });
    }
    Ok((sensors, views))
}

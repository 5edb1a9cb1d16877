//! Honeybee's Radiance folder, as honeybee-radiance writes it: `scene/`, `aperture/`, `aperture_group/`, `grid/`,
//! `view/` and `bsdf/` in one folder, `model`.

use super::assets::ModelView;
use super::geometry::Face3d;
use super::modifiers::{Kind, Modifier, basis_of};
use super::windows::{Opening, group, unique};
use super::{Model, told_groups};
use crate::bsdf;
use crate::error::{Error, Result, Warnings};
use crate::scene::points::{self, SensorGrid};
use crate::scene::rad::{self, MadeOf};
use crate::scene::{Material, MaterialIndex, MaterialKind, Triangle};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
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
    let mut groups: BTreeMap<String, usize> = BTreeMap::new();
    let mut scene_files = list("scene", "mat")?;
    scene_files.extend(list("scene", "rad")?);
    for name in ["scene_dynamic", "scene_dynamic/indoor", "aperture_group/interior"] {
        scene_files.extend(first_states(&folder.join(name), &mut groups)?.into_iter().map(|(_, file)| file));
    }
    let mut scene = rad::read_scene(&scene_files, Path::new(""), warnings)?;
    let mut apertures = list("aperture", "mat")?;
    apertures.extend(list("aperture", "rad")?);
    let mut polygons: Vec<_> =
        rad::read_polygons(&apertures, Path::new(""), warnings)?.into_iter().map(|polygon| (None, polygon)).collect();
    for (name, file) in first_states(&folder.join("aperture_group"), &mut groups)? {
        let own = rad::read_polygons(&[file], Path::new(""), warnings)?;
        polygons.extend(own.into_iter().map(|polygon| (Some(name.clone()), polygon)));
    }
    let mut openings = Vec::new();
    let mut materials: HashMap<String, MaterialIndex> = HashMap::new();
    let mut read: HashMap<String, Rc<Modifier>> = HashMap::new();
    for (group, polygon) in polygons {
        let at = |e: Error| e.file(&polygon.origin.file).line(polygon.origin.line).field(format!("polygon '{}'", polygon.origin.name));
        let face = Face3d { boundary: polygon.corners, holes: Vec::new() };
        let kind = match polygon.made_of {
            MadeOf::Material(kind) => kind,
            MadeOf::Bsdf { file, up } => {
                if !read.contains_key(&polygon.modifier) {
                    let data = scattering_data(&folder, &file).map_err(at)?;
                    let basis = basis_of(&bsdf::read(&data, warnings)?).map_err(|e| e.file(&data))?;
                    let modifier = Modifier { identifier: polygon.modifier.clone(), kind: Kind::Bsdf { up, basis, data } };
                    read.insert(polygon.modifier.clone(), Rc::new(modifier));
                }
                openings.push(Opening { face, modifier: Rc::clone(&read[&polygon.modifier]), group, origin: polygon.origin });
                continue;
            }
        };
        if let MaterialKind::Glass { .. } = kind {
            let modifier = Rc::new(Modifier { identifier: polygon.modifier, kind: Kind::Material(kind) });
            openings.push(Opening { face, modifier, group, origin: polygon.origin });
            continue;
        }
        // An opaque door.
        let material = *materials.entry(polygon.modifier.clone()).or_insert_with(|| {
            scene.materials.push(Material { name: polygon.modifier.clone(), kind });
            MaterialIndex((scene.materials.len() - 1) as u32)
        });
        let surface = scene.surfaces.len() as u32;
        scene.surfaces.push(polygon.origin);
        scene.triangles.extend(face.triangles().triangles.into_iter().map(|vertices| Triangle { vertices, material, surface }));
    }
    if scene.triangles.is_empty() && openings.is_empty() {
        return Err(Error::new("there is nothing in scene/ and aperture/ of this folder")
            .help("write it again: honeybee-radiance translate model-to-rad-folder model.hbjson"));
    }
    let (sensors, views) = assets(&folder)?;
    let groups: Vec<(String, usize)> = groups.into_iter().collect();
    told_groups(&groups, path, warnings);
    Ok(Model { scene, windows: group(openings, TOLERANCE, warnings)?, sensors, views, groups })
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

/// The first state of each group that `states.json` lists: the group and the file.
fn first_states(folder: &Path, groups: &mut BTreeMap<String, usize>) -> Result<Vec<(String, PathBuf)>> {
    let file = folder.join("states.json");
    if !file.exists() {
        return Ok(Vec::new());
    }
    let wrong = |message: String| Error::new(message).file(&file).help("write the folder again");
    let value: Value = serde_json::from_slice(&crate::files::read(&file)?).map_err(|e| wrong(format!("this is no JSON: {e}")))?;
    let all = value.as_object().ok_or_else(|| wrong("this is no list of groups".into()))?;
    let mut found = Vec::new();
    for (group, states) in all {
        let count = states.as_array().map_or(0, Vec::len);
        let name = states[0]["default"].as_str().ok_or_else(|| wrong(format!("group '{group}' has no first state")))?;
        let path = folder.join(name);
        // Only what lies beside the list.
        if Path::new(name).components().any(|c| !matches!(c, std::path::Component::CurDir | std::path::Component::Normal(_))) {
            return Err(wrong(format!("the state '{name}' of group '{group}' lies outside the folder")));
        }
        groups.insert(group.clone(), count);
        found.push((group.clone(), path));
    }
    Ok(found)
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

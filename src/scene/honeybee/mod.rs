//! Honeybee's models (`.hbjson`): rooms with apertures and shades, modifiers, sensor grids and views in one file.
//!
//! **Scene.** Faces (with holes for their apertures and doors), opaque doors and shades, as honeybee-radiance writes
//! them: the second side of a wall between two rooms stands two tolerances within its room, air boundaries are not
//! there, apertures between rooms are panes of the scene. A surface has its own modifier, or that of its room's
//! modifier set, or Honeybee's generic one. `modifier_blk`, energy properties, multipliers and light paths have no
//! effect.
//!
//! **Windows.** Every aperture, door and face to the outside whose modifier is Glass or BSDF, joined by plane,
//! orientation, modifier and dynamic group. Their names: the dynamic group's, the aperture's if it is alone, else
//! where they look (`south`, `south-2`). Normals point into the room, whichever way the model has them.
//!
//! **Units** become metres.
//!
//! **Dynamic groups** of apertures and doors are windows with states, if each state is a Glass, a BSDF, opaque or void,
//! and the shades of a state are those of all or belong to a BSDF ([`ModelSun`]). Of other groups, and of groups of
//! shades, the first state counts, and a warning names them.
//!
//! Scattering data have their front outside, as WINDOW writes them; in the static scene of honeybee-radiance, where
//! the polygon looks outside, Radiance turns them round, and a warning says so.
//!
//! Messages name the object by its place in the file, identifier and display name: `rooms[0].faces[3]
//! 'Office_South' (South wall)`.
//!
//! The format is that of [honeybee-schema](https://github.com/ladybug-tools/honeybee-schema), version 2.

mod assets;
mod folder;
mod geometry;
mod json;
mod modifiers;
mod reader;
mod states;
mod windows;

pub use assets::ModelView;
pub(crate) use modifiers::basis_of;
pub use states::{ModelGlazing, ModelState, ModelSun};
pub use windows::ModelWindow;
pub(crate) use windows::unique as unique_name;

use super::Scene;
use super::points::SensorGrid;
use crate::error::{Error, Result, Warnings};
use crate::{files, limits, text};
use json::Node;
use modifiers::Modifiers;
use reader::Reader;
use serde_json::Value;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What a model holds. Lengths are metres.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Model {
    /// All surfaces but the windows.
    pub scene: Scene,
    /// Windows, in order of first appearance.
    pub windows: Vec<ModelWindow>,
    /// Sensor grids, in the model's order.
    pub sensors: Vec<SensorGrid>,
    /// Views, in the model's order.
    pub views: Vec<ModelView>,
    /// Dynamic groups, with the number of their states.
    pub groups: Vec<(String, usize)>,
}

/// The newest version of the schema that this reader knows.
const KNOWN_VERSION: u64 = 2;
/// Rooms longer than this, or shorter than the second, in metres: the unit is likely another.
const LIKELY_SIZE: [f64; 2] = [300.0, 0.7];

/// Whether a file's name says that it is a Honeybee model, or a folder that it was written as one for Radiance.
pub(crate) fn is_honeybee(file: &Path) -> bool {
    folder::is_folder(file) || file.extension().is_some_and(|e| e.eq_ignore_ascii_case("hbjson") || e.eq_ignore_ascii_case("hbpkl"))
}

thread_local! {
    /// The model read last: a project asks for its scene, each window and each grid by itself.
    static LAST: RefCell<Option<(PathBuf, blake3::Hash, Rc<Model>, Warnings)>> = const { RefCell::new(None) };
}

/// The part of a model, `model.hbjson#part`, that suns are traced through in a state of a window; in the only one, if the
/// state has no name.
pub(crate) fn sun_part(window: &str, state: &str) -> String {
    format!("{window}/{state}")
}

/// What suns are traced through in such a part, if they are surfaces.
///
/// # Errors
/// As [`read`], and if there is no such part.
pub(crate) fn read_sun_part(file: &Path, part: &str, warnings: &mut Warnings) -> Result<Scene> {
    let model = read(file, warnings)?;
    let suns = model.windows.iter().flat_map(|w| {
        let of_states = w.states.iter().map(|s| (sun_part(&w.window.name, &s.name), &s.sun));
        of_states.chain([(sun_part(&w.window.name, ""), &w.sun)])
    });
    let found = suns.filter(|(name, _)| name == part).find_map(|(_, sun)| match sun {
        Some(ModelSun::Shade(scene)) => Some(scene.clone()),
        _ => None,
    });
    found.ok_or_else(|| {
        Error::new(format!("the model has no shades '{part}'")).file(file).help("a shade is a file of its own, shade = \"slats.rad\"")
    })
}

/// Reads a model, or the Radiance folder that honeybee-radiance wrote of one: there an opaque polygon of `aperture/` is
/// a door, fronts look outside, and lengths are metres.
///
/// # Errors
/// What is no Honeybee model; wrong types, missing parts and modifiers, unknown units: with the object.
pub fn read(file: &Path, warnings: &mut Warnings) -> Result<Rc<Model>> {
    if file.is_dir() {
        return folder::read(file, warnings).map(Rc::new);
    }
    check_bytes(std::fs::metadata(file).map_err(|e| Error::io(file, &e))?.len()).map_err(|e| e.file(file))?;
    let bytes = files::read(file)?;
    let hash = blake3::hash(&bytes);
    let told = |found: &Warnings, warnings: &mut Warnings| found.iter().for_each(|w| warnings.push(w.clone()));
    let known = LAST.with_borrow(|last| {
        let (path, of, model, found) = last.as_ref()?;
        (path == file && *of == hash).then(|| (Rc::clone(model), found.clone()))
    });
    if let Some((model, found)) = known {
        told(&found, warnings);
        return Ok(model);
    }
    let mut found = Warnings::new();
    let result = read_bytes(&bytes, file, &mut found).map_err(|e| e.file(file));
    told(&found, warnings);
    let model = Rc::new(result?);
    LAST.set(Some((file.to_path_buf(), hash, Rc::clone(&model), found)));
    Ok(model)
}

fn check_bytes(bytes: u64) -> Result<()> {
    if bytes <= limits::MODEL_BYTES {
        return Ok(());
    }
    let text = format!("this model has {} MiB; more than {} MiB are not read", bytes >> 20, limits::MODEL_BYTES >> 20);
    Err(Error::new(text).help("take the model apart by rooms or storeys, or write it for Radiance and give that folder: honeybee-radiance translate model-to-rad-folder model.hbjson"))
}

fn read_bytes(bytes: &[u8], file: &Path, warnings: &mut Warnings) -> Result<Model> {
    if file.extension().is_some_and(|e| e.eq_ignore_ascii_case("hbpkl")) {
        return Err(Error::new("this is a pickled Honeybee model, which only Python can open")
            .help("convert it: python3 -c \"from honeybee.model import Model; Model.from_hbpkl('model.hbpkl').to_hbjson('model', '.')\""));
    }
    let text = text::decode(bytes, "a Honeybee model")?;
    let value: Value = serde_json::from_str(&text).map_err(|e| {
        Error::new(format!("this is no JSON: {e}")).line(e.line()).help("the file is cut off or was changed by hand; export it again")
    })?;
    let model = Node::root(&value);
    check_kind(&model, warnings, file)?;
    let (scale, tolerance) = units(&model)?;
    let modifiers = Modifiers::read(&model, file, scale)?;
    let mut reader = Reader::new(file, modifiers, scale, tolerance, warnings);
    reader.model(&model)?;
    let Reader { scene, mut openings, groups, shade_groups, first_only, .. } = reader;
    states::settle(&mut openings, &groups, &first_only, file, warnings);
    let windows = windows::group(openings, tolerance, warnings)?;
    let (sensors, views) = assets::read(&model, scale, file, warnings)?;
    told_shades(&shade_groups, file, warnings);
    let groups = all_groups(groups, shade_groups);
    check_size(&scene, &model, file, warnings);
    if let Some(north) = model.number("north_angle")?.filter(|a| *a != 0.0) {
        let told = format!("the north angle of {north}° that this model of an old version has is not obeyed: +y is north");
        warnings.push(Error::new(told).file(file).field("north_angle").help("turn the model in Honeybee, or give north in [weather]"));
    }
    Ok(Model { scene, windows, sensors, views, groups })
}

/// Groups of windows and shades together, with the number of their states.
fn all_groups(mut groups: BTreeMap<String, usize>, shades: BTreeMap<String, usize>) -> Vec<(String, usize)> {
    for (name, count) in shades {
        let most = groups.entry(name).or_default();
        *most = (*most).max(count);
    }
    groups.into_iter().collect()
}

/// Names the groups of shades, whose other states do not count.
fn told_shades(groups: &BTreeMap<String, usize>, file: &Path, warnings: &mut Warnings) {
    let changing: Vec<String> = groups.iter().filter(|(_, n)| **n > 1).map(|(name, n)| format!("'{name}' ({n} states)")).collect();
    if !changing.is_empty() {
        let told = format!("dynamic groups of shades count in their first state: {}", changing.join(", "));
        let help = "run the model once for each state; shades that only a window needs may be part of the window's states, with a BSDF";
        warnings.push(Error::new(told).file(file).help(help));
    }
}

/// Whether this is a model, of a version that is known.
fn check_kind(model: &Node<'_>, warnings: &mut Warnings, file: &Path) -> Result<()> {
    if !model.value.is_object() {
        return Err(Error::new(format!("this is {}, not a Honeybee model", json::kind(model.value))).help("give an .hbjson file"));
    }
    match model.text("type")? {
        Some("Model") => {}
        Some(other) => {
            return Err(Error::new(format!("this is a Honeybee '{}', not a Model", super::rad::shortened(other)))
                .help("put it into a Model (Grasshopper: HB Model) and write that as HBJSON"));
        }
        None => return Err(Error::new("this JSON is no Honeybee model: it has no 'type'").help("give an .hbjson file")),
    }
    if model.get("buildings").is_some() {
        return Err(
            Error::new("this is a Dragonfly model").help("translate it to Honeybee: dragonfly translate model-to-honeybee model.dfjson")
        );
    }
    if let Some(version) = model.text("version")?
        && version.split('.').next().and_then(|v| v.parse::<u64>().ok()).is_none_or(|v| v > KNOWN_VERSION)
    {
        let told = format!(
            "the schema's version is {version}, newer than {KNOWN_VERSION}.x, which is known here: what is new in it is passed over"
        );
        warnings.push(Error::new(told).file(file).field("version").help("compare areas and counts: lucarne scene info MODEL"));
    }
    Ok(())
}

/// Metres per unit, and the tolerance in metres.
fn units(model: &Node<'_>) -> Result<(f64, f64)> {
    let (scale, usual) = match model.text("units")? {
        None | Some("Meters") => (1.0, 0.01),
        Some("Millimeters") => (0.001, 1.0),
        Some("Centimeters") => (0.01, 1.0),
        Some("Feet") => (0.3048, 0.01),
        Some("Inches") => (0.0254, 0.1),
        Some(other) => {
            return Err(Error::new(format!("there is no unit '{}'", super::rad::shortened(other)))
                .field("units")
                .help("units are Meters, Millimeters, Centimeters, Feet and Inches"));
        }
    };
    // 0 stands for no checks, but sides of walls still have to be told apart.
    let tolerance = model.number("tolerance")?.filter(|t| *t > 0.0).unwrap_or(usual);
    Ok((scale, tolerance * scale))
}

/// Whether the size of the model suits its unit.
fn check_size(scene: &Scene, model: &Node<'_>, file: &Path, warnings: &mut Warnings) {
    let rooms = model.value["rooms"].as_array().map_or(0, Vec::len);
    if rooms == 0 || scene.triangles.is_empty() {
        return;
    }
    // The median of all faces' sizes, which surroundings and huge halls leave as it is.
    let mut sizes: Vec<f64> = scene.triangles.iter().map(|t| (t.vertices[0] - t.vertices[2]).length()).collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes[sizes.len() / 2];
    let unit = model.value["units"].as_str().unwrap_or("Meters");
    let [longest, shortest] = LIKELY_SIZE;
    let guess = match median {
        m if m > longest => "smaller ones (Millimeters, Inches)",
        m if m < shortest / 10.0 => "larger ones (Meters)",
        _ => return,
    };
    let told = format!("faces are {median:.3} m long in units of {unit}: the coordinates look like {guess}");
    warnings.push(Error::new(told).file(file).field("units").help("set the model's units in Honeybee to those it was drawn in"));
}

#[cfg(test)]
mod tests;

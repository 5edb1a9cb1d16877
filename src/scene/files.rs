//! Scene files of every format: Radiance's `.rad`, OBJ, glTF (`.gltf`, `.glb`), Honeybee's models (`.hbjson`, or
//! their Radiance folder).

use super::honeybee;
use super::points::{self, Sensor, SensorGrid};
use super::{MaterialIndex, Scene, Triangle, Window, gltf, obj, rad};
use crate::error::{Error, Result, Warnings};
use std::path::{Path, PathBuf};

/// What a scene file is, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    Radiance,
    Gltf,
    Honeybee,
    Obj,
}

impl Format {
    pub(crate) fn of(file: &Path) -> Self {
        if gltf::is_gltf(file) {
            Self::Gltf
        } else if honeybee::is_honeybee(file) {
            Self::Honeybee
        } else if obj::is_obj(file) {
            Self::Obj
        } else {
            Self::Radiance
        }
    }

    /// Whether parts of such files have names by which they can be asked for.
    fn has_parts(self) -> bool {
        self != Self::Radiance
    }
}

/// Splits `room.gltf#south` into the file and the name of the part that is meant.
pub(crate) fn split_part(path: &Path) -> (PathBuf, Option<String>) {
    let text = path.to_string_lossy();
    match text.rsplit_once('#') {
        Some((file, part)) if Format::of(Path::new(file)).has_parts() && !path.exists() => (PathBuf::from(file), Some(part.to_string())),
        _ => (path.to_path_buf(), None),
    }
}

/// Reads and joins scene files. `.rad` files are read in their order as one scene, by
/// [`rad::read_scene`]; their modifiers serve [`obj`] files too; glTF files and Honeybee models are read each for itself,
/// by [`gltf::read`] and [`honeybee::read`], without their windows and sensors. Paths are relative to `base`.
///
/// # Errors
/// As those functions.
pub fn read_scene(files: &[PathBuf], base: &Path, warnings: &mut Warnings) -> Result<Scene> {
    read_scene_with(files, base, &gltf::Options::default(), warnings)
}

/// As [`read_scene`], with what glTF files do not say about themselves.
///
/// # Errors
/// As [`read_scene`].
pub fn read_scene_with(files: &[PathBuf], base: &Path, options: &gltf::Options, warnings: &mut Warnings) -> Result<Scene> {
    read(files, base, options, false, warnings).map(|(scene, _)| scene)
}

/// As [`read_scene`], with surfaces of scattering data, which else are an error.
///
/// # Errors
/// As [`read_scene`].
pub(crate) fn read_scene_and_scattering(
    files: &[PathBuf],
    base: &Path,
    warnings: &mut Warnings,
) -> Result<(Scene, Vec<rad::ScatteringData>)> {
    read(files, base, &gltf::Options::default(), true, warnings)
}

fn read(
    files: &[PathBuf],
    base: &Path,
    options: &gltf::Options,
    scattering: bool,
    warnings: &mut Warnings,
) -> Result<(Scene, Vec<rad::ScatteringData>)> {
    let (radiance, others): (Vec<PathBuf>, Vec<PathBuf>) = files.iter().cloned().partition(|f| Format::of(f) == Format::Radiance);
    let rad::Read { mut scene, mut definitions, scattering } = rad::read_scene_and_definitions(&radiance, base, scattering, warnings)?;
    for file in others.iter().map(|f| base.join(f)) {
        match Format::of(&file) {
            Format::Obj => obj::read_scene(&file, &mut definitions, &mut scene, warnings)?,
            Format::Honeybee => append(&mut scene, honeybee::read(&file, warnings)?.scene.clone()),
            _ => append(&mut scene, gltf::read(&file, options, warnings)?.scene),
        }
    }
    Ok((scene, scattering))
}

/// Joins what another file holds.
fn append(scene: &mut Scene, added: Scene) {
    let (materials, surfaces) = (scene.materials.len() as u32, scene.surfaces.len() as u32);
    scene.materials.extend(added.materials);
    scene.surfaces.extend(added.surfaces);
    scene.sources.extend(added.sources);
    scene.triangles.extend(added.triangles.into_iter().map(|t| Triangle {
        material: MaterialIndex(t.material.0 + materials),
        surface: t.surface + surfaces,
        ..t
    }));
}

/// Reads the windows of a file: [`rad::read_windows`], or what a glTF file marks as windows, or the apertures of a
/// Honeybee model. `room.gltf#south` means only the window `south`.
///
/// # Errors
/// As those functions, and files without (such) a window.
pub fn read_windows(file: &Path, base: &Path, warnings: &mut Warnings) -> Result<Vec<Window>> {
    let (path, part) = split_part(&base.join(file));
    let (mut windows, help) = match Format::of(&path) {
        Format::Radiance => return rad::read_windows(file, base, warnings),
        Format::Obj => return obj::read_windows(&path, part.as_deref(), warnings),
        Format::Gltf => (
            gltf::read(&path, &gltf::Options::default(), warnings)?.windows,
            "mark windows by \"window\": \"name\" in the extras of their node",
        ),
        Format::Honeybee => (
            honeybee::read(&path, warnings)?.windows.iter().map(|w| w.window.clone()).collect(),
            "windows of a model are its apertures to the outside with a modifier Glass or BSDF",
        ),
    };
    let names = windows.iter().map(|w| w.name.clone()).collect::<Vec<_>>();
    windows.retain(|w| part.as_ref().is_none_or(|p| *p == w.name));
    if windows.is_empty() {
        return Err(absent("window", part, &names).file(path).help(help));
    }
    Ok(windows)
}

/// The options of the view that `model.hbjson#name` means; `None` for other files.
///
/// # Errors
/// As [`honeybee::read`], and if there is no such view.
pub(crate) fn read_model_view(file: &Path, warnings: &mut Warnings) -> Result<Option<String>> {
    let (path, Some(part)) = split_part(file) else { return Ok(None) };
    if Format::of(&path) != Format::Honeybee {
        return Ok(None);
    }
    let model = honeybee::read(&path, warnings)?;
    let names = model.views.iter().map(|v| v.name.clone()).collect::<Vec<_>>();
    let found = model.views.iter().find(|v| v.name == part).map(|v| v.options.clone());
    found.map(Some).ok_or_else(|| absent("view", Some(part), &names).file(path))
}

/// Reads sensors: a points file ([`points::read_points`]), or what a glTF file marks as sensors or a Honeybee model
/// has as grids, all grids one after the other. `room.gltf#workplane` means only the grid `workplane`; so does
/// `preferred`, if the file has a grid of that name.
///
/// # Errors
/// As those functions, and files without (such) a grid.
pub fn read_sensors(file: &Path, preferred: Option<&str>, warnings: &mut Warnings) -> Result<Vec<Sensor>> {
    let (path, part) = split_part(file);
    let (grids, help): (Vec<SensorGrid>, _) = match Format::of(&path) {
        Format::Radiance | Format::Obj => return points::read_points(file),
        Format::Gltf => (
            gltf::read(&path, &gltf::Options::default(), warnings)?.sensors,
            "mark sensors by \"sensors\": \"name\" in the extras of their node",
        ),
        Format::Honeybee => (honeybee::read(&path, warnings)?.sensors.clone(), "add a sensor grid to the model, or give a points file"),
    };
    let names = grids.iter().map(|g| g.name.clone()).collect::<Vec<_>>();
    let part = part.or_else(|| preferred.filter(|p| names.iter().any(|n| n == p)).map(str::to_string));
    let sensors: Vec<Sensor> = grids.into_iter().filter(|g| part.as_ref().is_none_or(|p| *p == g.name)).flat_map(|g| g.sensors).collect();
    if sensors.is_empty() {
        return Err(absent("grid of sensors", part, &names).file(path).help(help));
    }
    Ok(sensors)
}

fn absent(what: &str, part: Option<String>, names: &[String]) -> Error {
    match part {
        Some(part) if !names.is_empty() => Error::new(format!("there is no {what} '{part}', but: {}", names.join(", "))),
        _ => Error::new(format!("the file marks nothing as {what}")),
    }
}

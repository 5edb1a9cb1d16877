//! Scene files of either format: Radiance's `.rad`, or glTF (`.gltf`, `.glb`).

use super::points::{self, Sensor};
use super::{MaterialIndex, Scene, Triangle, Window, gltf, rad};
use crate::error::{Error, Result, Warnings};
use std::path::{Path, PathBuf};

/// Reads and joins scene files. `.rad` files are read in their order as one scene, by
/// [`rad::read_scene`]; glTF files each for itself, by [`gltf::read`], without what they mark as
/// windows and sensors. Paths are relative to `base`.
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
    let (others, radiance): (Vec<PathBuf>, Vec<PathBuf>) = files.iter().cloned().partition(|f| gltf::is_gltf(f));
    let mut scene = rad::read_scene(&radiance, base, warnings)?;
    for file in others {
        let added = gltf::read(&base.join(file), options, warnings)?.scene;
        let (materials, surfaces) = (scene.materials.len() as u32, scene.surfaces.len() as u32);
        scene.materials.extend(added.materials);
        scene.surfaces.extend(added.surfaces);
        scene.triangles.extend(added.triangles.into_iter().map(|t| Triangle {
            material: MaterialIndex(t.material.0 + materials),
            surface: t.surface + surfaces,
            ..t
        }));
    }
    Ok(scene)
}

/// Reads the windows of a file: [`rad::read_windows`], or what a glTF file marks as windows.
/// `room.gltf#south` means only the window `south`.
///
/// # Errors
/// As those functions, and glTF files without (such) a window.
pub fn read_windows(file: &Path, base: &Path, warnings: &mut Warnings) -> Result<Vec<Window>> {
    let (path, part) = gltf::split_part(&base.join(file));
    if !gltf::is_gltf(&path) {
        return rad::read_windows(file, base, warnings);
    }
    let mut windows = gltf::read(&path, &gltf::Options::default(), warnings)?.windows;
    let names = windows.iter().map(|w| w.name.clone()).collect::<Vec<_>>();
    windows.retain(|w| part.as_ref().is_none_or(|p| *p == w.name));
    if windows.is_empty() {
        return Err(absent("window", part, &names).file(path).help("mark windows by \"window\": \"name\" in the extras of their node"));
    }
    Ok(windows)
}

/// Reads sensors: a points file ([`points::read_points`]), or what a glTF file marks as sensors, all
/// grids one after the other. `room.gltf#workplane` means only the grid `workplane`; so does
/// `preferred`, if the file has a grid of that name.
///
/// # Errors
/// As those functions, and glTF files without (such) a grid.
pub fn read_sensors(file: &Path, preferred: Option<&str>, warnings: &mut Warnings) -> Result<Vec<Sensor>> {
    let (path, part) = gltf::split_part(file);
    if !gltf::is_gltf(&path) {
        return points::read_points(file);
    }
    let grids = gltf::read(&path, &gltf::Options::default(), warnings)?.sensors;
    let names = grids.iter().map(|g| g.name.clone()).collect::<Vec<_>>();
    let part = part.or_else(|| preferred.filter(|p| names.iter().any(|n| n == p)).map(str::to_string));
    let sensors: Vec<Sensor> = grids.into_iter().filter(|g| part.as_ref().is_none_or(|p| *p == g.name)).flat_map(|g| g.sensors).collect();
    if sensors.is_empty() {
        return Err(absent("grid of sensors", part, &names)
            .file(path)
            .help("mark sensors by \"sensors\": \"name\" in the extras of their node"));
    }
    Ok(sensors)
}

fn absent(what: &str, part: Option<String>, names: &[String]) -> Error {
    match part {
        Some(part) if !names.is_empty() => Error::new(format!("there is no {what} '{part}', but: {}", names.join(", "))),
        _ => Error::new(format!("the file marks nothing as {what}")),
    }
}

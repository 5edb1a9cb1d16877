//! Wavefront OBJ files (`.obj`): polygons of named materials.
//!
//! **Geometry.** Polygons of three or more corners, convex or not; seams cut holes, as in Radiance. Coordinates are
//! taken as they are: +z is up, and the unit is the scene's. Negative indices count from the end, a backslash
//! continues a line. Lines, points and curves are left out with a warning; normals and texture coordinates have no
//! effect.
//!
//! **Materials.** `usemtl wall` means the modifier `wall` of the scene's `.rad` files. A material that is in none of
//! them has the diffuse colour (`Kd`) that the file's `mtllib` gives it, with a warning that says so: `plastic`
//! without gloss, or `glass` if it is transparent (`d` or `Tr`). Before any `usemtl` the name of the group (`g`) or
//! object (`o`) is tried. A material that nothing defines is an error.
//!
//! **Windows.** `surface = "room.obj#glazing"` means the polygons of the material or group `glazing`.

mod lines;
mod mtl;

use super::polygon::{PLANARITY_TOLERANCE, triangulate};
use super::rad::Definitions;
use super::windows::WindowBuilder;
use super::{Material, MaterialIndex, Scene, SurfaceOrigin, Triangle, Window};
use crate::error::{Error, Result, Warnings};
use crate::{limits, text};
use glam::DVec3;
use lines::{Face, Reader};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// Whether a file's name says that it is OBJ.
pub(crate) fn is_obj(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"))
}

/// Faces of one material and group that follow each other.
struct Surface {
    origin: SurfaceOrigin,
    /// By `usemtl`.
    material: Option<String>,
    triangles: Vec<[DVec3; 3]>,
}

struct Contents {
    surfaces: Vec<Surface>,
    /// Files named by `mtllib`.
    libraries: Vec<PathBuf>,
}

/// Reads a file's surfaces, with materials of these definitions or of the file's own libraries.
///
/// # Errors
/// Faulty lines, faces that name corners that are not there, materials that nothing defines.
pub(super) fn read_scene(file: &Path, definitions: &mut Definitions, scene: &mut Scene, warnings: &mut Warnings) -> Result<()> {
    let contents = read(file, warnings)?;
    let mut library = None;
    let mut known: HashMap<String, MaterialIndex> = HashMap::new();
    let mut of_library: Vec<String> = Vec::new();
    for surface in contents.surfaces {
        if surface.triangles.is_empty() {
            continue;
        }
        // A file without `usemtl` may have its materials by its groups.
        let name = surface.material.clone().unwrap_or_else(|| surface.origin.name.clone());
        let material = match known.get(&name) {
            Some(index) => *index,
            None => {
                let at = |e: Error| e.file(file).line(surface.origin.line);
                let index = match definitions.material(&name, &mut scene.materials, warnings).map_err(at)? {
                    Some(index) => index,
                    None => {
                        if library.is_none() {
                            library = Some(mtl::read(&contents.libraries, file, warnings)?);
                        }
                        let kind = library.as_ref().and_then(|l: &BTreeMap<String, mtl::Colour>| l.get(&name));
                        let kind = kind.ok_or_else(|| at(undefined(&name, surface.material.is_some(), &contents.libraries)))?.kind();
                        of_library.push(name.clone());
                        scene.materials.push(Material { name: name.clone(), kind });
                        MaterialIndex((scene.materials.len() - 1) as u32)
                    }
                };
                known.insert(name, index);
                index
            }
        };
        if scene.triangles.len() + surface.triangles.len() > limits::TRIANGLES {
            return Err(limits::exceeded("the scene has", limits::TRIANGLES, "triangles").file(file).help("simplify the meshes"));
        }
        let number = scene.surfaces.len() as u32;
        scene.surfaces.push(surface.origin);
        scene.triangles.extend(surface.triangles.into_iter().map(|vertices| Triangle { vertices, material, surface: number }));
    }
    if !of_library.is_empty() {
        let told =
            format!("materials that no .rad file defines have the diffuse colour of the mtllib, without gloss: {}", of_library.join(", "));
        warnings.push(
            Error::new(told)
                .file(file)
                .help("colours of an MTL file are for the screen: define them in a .rad file, `void plastic wall 0 0 5 .5 .5 .5 0 0`"),
        );
    } else if let Some(ignored) = contents.libraries.first() {
        let told = format!("'{}' is not read: all materials are those of the .rad files", ignored.display());
        warnings.push(Error::new(told).file(file).field("mtllib"));
    }
    Ok(())
}

/// The windows of a file: one per material, or those of the material or group that is meant.
///
/// # Errors
/// As [`read_scene`], and files without (such) polygons; windows that face opposite ways.
pub(super) fn read_windows(file: &Path, part: Option<&str>, warnings: &mut Warnings) -> Result<Vec<Window>> {
    let mut builders: Vec<WindowBuilder> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for surface in read(file, warnings)?.surfaces.into_iter().filter(|s| !s.triangles.is_empty()) {
        let material = surface.material.clone().unwrap_or_else(|| surface.origin.name.clone());
        for name in [&material, &surface.origin.name] {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
        let name = match part {
            None => material,
            Some(part) if part == material || part == surface.origin.name => part.to_string(),
            Some(_) => continue,
        };
        let index = builders.iter().position(|w| w.name() == name).unwrap_or_else(|| {
            builders.push(WindowBuilder::new(name, surface.origin.clone()));
            builders.len() - 1
        });
        builders[index].add(surface.origin, surface.triangles);
    }
    if builders.is_empty() {
        let what = part.map_or("polygon".to_string(), |p| format!("polygon of a material or group '{p}', but of: {}", names.join(", ")));
        return Err(Error::new(format!("there is no {what}")).file(file).help("name a material (usemtl) or group (g) of the file"));
    }
    builders.into_iter().map(|w| w.finish(warnings)).collect()
}

fn undefined(name: &str, is_named: bool, libraries: &[PathBuf]) -> Error {
    let what = match (is_named, libraries.first()) {
        (false, _) => format!("the faces of '{name}' have no material"),
        (true, None) => format!("the material '{name}' is in none of the scene's .rad files, and the file names no mtllib"),
        (true, Some(library)) => format!("the material '{name}' is neither in the scene's .rad files nor in '{}'", library.display()),
    };
    Error::new(what).help(format!("add a .rad file to the scene that defines it: `void plastic {name} 0 0 5 .5 .5 .5 0 0`"))
}

fn read(file: &Path, warnings: &mut Warnings) -> Result<Contents> {
    let text = text::read(file, "an OBJ file")?;
    let mut heard = Warnings::new();
    let result = contents(&text, file, &mut heard);
    heard.iter().for_each(|w| warnings.push(w.clone().file(file)));
    result.map_err(|e| e.file(file))
}

fn contents(text: &str, file: &Path, warnings: &mut Warnings) -> Result<Contents> {
    let mut reader = Reader::new(text);
    let mut surfaces: Vec<Surface> = Vec::new();
    let (mut flat, mut without_area) = (None, (0, 0));
    while let Some(Face { corners, line }) = reader.next_face()? {
        let cut = triangulate(&corners);
        if cut.triangles.is_empty() {
            without_area = (without_area.0 + 1, if without_area.0 == 0 { line } else { without_area.1 });
            continue;
        }
        if cut.flattened && flat.is_none_or(|(_, most)| cut.departure > most) {
            flat = Some((line, cut.departure));
        }
        let (name, material) = (reader.group(), reader.material());
        match surfaces.last_mut() {
            Some(last) if last.origin.name == name && last.material.as_deref() == material => last.triangles.extend(cut.triangles),
            _ => surfaces.push(Surface {
                origin: SurfaceOrigin { name: name.to_string(), file: file.to_path_buf(), line },
                material: material.map(str::to_string),
                triangles: cut.triangles,
            }),
        }
    }
    if let Some((line, departure)) = flat {
        let told = format!(
            "corners lie up to {departure:.4} outside the plane of their face, into which they are pressed ({PLANARITY_TOLERANCE} of its size are allowed)"
        );
        warnings.push(Error::new(told).line(line).help("export triangles"));
    }
    if let (n @ 1.., line) = without_area {
        warnings.push(Error::new(format!("{n} faces without area are left out")).line(line).help("remove them from the mesh"));
    }
    if let Some((line, what)) = reader.left_out() {
        warnings
            .push(Error::new(format!("'{what}' and what else is no polygon is left out")).line(line).help("export surfaces as polygons"));
    }
    if surfaces.is_empty() {
        return Err(Error::new("there is no face in this file").help("export polygons: lines that begin with v and f"));
    }
    Ok(Contents { surfaces, libraries: reader.libraries().iter().map(|l| file.parent().unwrap_or(Path::new("")).join(l)).collect() })
}

#[cfg(test)]
mod tests;

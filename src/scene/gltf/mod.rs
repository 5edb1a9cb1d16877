//! glTF 2.0 scenes (`.gltf` with its buffers, or `.glb`).
//!
//! **Axes and units.** glTF has +Y up and metres. Scenes here have +Z up: (x, y, z) becomes
//! (x, −z, y), so that glTF's −Z is north. Files that do not keep to that say so in the `extras` of
//! their scene or asset: `"up_axis": "Z"`, `"scale": 0.001` (metres per unit; any length unit may
//! serve as metre); [`Options`] say it for them.
//!
//! **Geometry.** Triangles, strips and fans of the nodes of the default scene, placed by the
//! nodes' transformations, once for each instance of `EXT_mesh_gpu_instancing`. All surfaces have two
//! sides. Skins, morph targets, animations, cameras and lights are left out.
//!
//! **Extensions.** Those of `extensions::OBEYED` are obeyed. Of any other that a file uses a warning
//! tells; one that it requires is refused.
//!
//! **Materials.** An exact Radiance material by the material's `extras`: `"radiance": "void plastic
//! wall 0 0 5 .5 .5 .5 0 0"`. Otherwise see [`materials`].
//!
//! **Windows and sensors** are marked in the `extras` of a node, mesh or (windows) material, or by
//! its name; a node's mark holds for all below it:
//!
//! | `extras` | name | meaning |
//! |---|---|---|
//! | `"window": "south"` | `window:south` | the triangles are the window `south`, fronts into the room |
//! | `"rfluxmtx": "h=kf u=+Z"` | | beside `window`: basis and up vector (axes of the scene, +Z up) |
//! | `"sensors": "workplane"` | `sensors:workplane` | each vertex is a sensor that faces along its normal |

mod buffers;
pub(crate) mod extensions;
mod instances;
mod marks;
pub mod materials;
mod reader;
mod write;

pub use write::write;

use super::points::SensorGrid;
use super::{Scene, Window};
use crate::error::{Error, Result, Warnings};
use crate::{files, text};
use buffers::Buffers;
use glam::{DAffine3, DMat3, DVec3};
use marks::extras;
use reader::Reader;
use serde_json::Value;
use std::path::Path;

/// Which axis of the file points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// As glTF prescribes.
    #[default]
    Y,
    /// Already as in this field.
    Z,
}

/// What a file does not say about itself. Its own `extras` take precedence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Which axis points up.
    pub up: UpAxis,
    /// Metres per unit of length.
    pub scale: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { up: UpAxis::Y, scale: 1.0 }
    }
}

/// What a glTF file holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Contents {
    /// Surfaces other than windows and sensors.
    pub scene: Scene,
    /// Windows, in order of first appearance.
    pub windows: Vec<Window>,
    /// Grids of sensors, in order of first appearance.
    pub sensors: Vec<SensorGrid>,
}

/// Whether a file's name says that it is glTF.
pub(crate) fn is_gltf(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf") || e.eq_ignore_ascii_case("glb"))
}

/// Reads a file. Its buffers must lie in its own folder or below.
///
/// # Errors
/// Broken files, missing or short buffers, buffers outside the folder, required extensions this
/// program does not know, coordinates that are not finite, materials or windows that make no sense:
/// with the file and the object.
pub fn read(file: &Path, options: &Options, warnings: &mut Warnings) -> Result<Contents> {
    let bytes = files::read(file)?;
    read_bytes(&bytes, file, options, warnings).map_err(|e| e.file(file))
}

fn read_bytes(bytes: &[u8], file: &Path, options: &Options, warnings: &mut Warnings) -> Result<Contents> {
    let broken = |message: String| Error::new(message).help("export the file again, as glTF 2.0");
    if bytes.starts_with(b"glTF") {
        let announced = bytes.get(8..12).map_or(0, |l| u32::from_le_bytes([l[0], l[1], l[2], l[3]]) as usize);
        if announced < 20 || announced > bytes.len() {
            return Err(broken(format!("the file is cut off: it has {} bytes and announces {announced}", bytes.len())));
        }
    } else if let Some(other) = text::Other::of(bytes) {
        return Err(other.instead_of("a glTF scene"));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let unreadable = |e: gltf::Error| broken(format!("this is not glTF: {e}"));
    let gltf = gltf::Gltf::from_slice_without_validation(bytes).map_err(unreadable)?;
    validate(&gltf)?;
    let version = &gltf.document.as_json().asset.version;
    if !version.starts_with("2.") {
        return Err(broken(format!("this is glTF {}, not 2.0", super::rad::shortened(version))));
    }
    let buffers = Buffers::load(&gltf, file)?;
    let json = extensions::json(bytes).map_err(broken)?;
    extensions::warn(&json, &mut |e| warnings.push(e.file(file)));
    let scene = gltf.default_scene().or_else(|| gltf.scenes().next()).ok_or_else(|| broken("the file has no scene".into()))?;
    let asset = extras(&gltf.document.as_json().asset.extras)?;
    let own = extras(scene.extras())?;
    let world = orientation(options, &[&own, &asset])?;
    let mut reader = Reader::new(file, &gltf, &json, &buffers, warnings);
    for node in scene.nodes() {
        reader.node(&node, world, None, 0)?;
    }
    reader.finish()
}

/// Checks all that the crate checks, and before that what it takes for granted meanwhile.
fn validate(gltf: &gltf::Gltf) -> Result<()> {
    use gltf::json::validation::{Checked, Error as Fault, Validate};
    let root = gltf.document.as_json();
    let mut faults = Vec::new();
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let position = primitive.attributes.get(&Checked::Valid(gltf::Semantic::Positions));
            if position.is_some_and(|index| index.value() >= root.accessors.len()) {
                faults.push((format!("meshes[{m}].primitives[{p}].attributes[\"POSITION\"]"), Fault::IndexOutOfBounds));
            }
        }
    }
    if faults.is_empty() {
        root.validate(root, gltf::json::Path::new, &mut |path, fault| {
            let place = path().to_string();
            if !extensions::OBEYED.iter().any(|e| place.starts_with("extensionsRequired") && place.contains(e)) {
                faults.push((place, fault));
            }
        });
    }
    let Some((place, fault)) = faults.first() else { return Ok(()) };
    Err(if place.starts_with("extensionsRequired") {
        Error::new(format!("the file requires an extension this program does not know: {place}"))
            .help("export without it (extensions that compress meshes are the usual ones)")
    } else {
        Error::new(format!("{place}: {fault} ({} faults)", faults.len())).help("export the file again, as glTF 2.0")
    })
}

/// The scene's axes and unit.
fn orientation(options: &Options, extras: &[&Value]) -> Result<DAffine3> {
    let said = |key: &str| extras.iter().map(|e| &e[key]).find(|v| !v.is_null());
    let up = match said("up_axis") {
        None => options.up,
        Some(v) => match v.as_str() {
            Some("Y" | "y") => UpAxis::Y,
            Some("Z" | "z") => UpAxis::Z,
            _ => return Err(Error::new(format!("up_axis is {v}")).help("write \"up_axis\": \"Y\" or \"Z\"")),
        },
    };
    let scale = match said("scale") {
        None => options.scale,
        Some(v) => v.as_f64().unwrap_or(f64::NAN),
    };
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(Error::new("the scale is not a positive number").help("write the metres per unit, for instance \"scale\": 0.001"));
    }
    let axes = match up {
        UpAxis::Y => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
        UpAxis::Z => DMat3::IDENTITY,
    };
    Ok(DAffine3::from_mat3(axes * scale))
}

#[cfg(test)]
mod tests;

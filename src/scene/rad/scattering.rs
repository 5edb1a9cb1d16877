//! Surfaces of scattering data: Radiance's `BSDF` and `aBSDF`. Rays of a scene do not meet them; those between indoors
//! and outdoors are windows.

use super::definition::Definition;
use super::syntax::shortened;
use super::xform::{Placement, Xform};
use crate::error::{Error, Result};
use crate::scene::MaterialIndex;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Scattering data that surfaces of a scene are made of. Their triangles have a material that does nothing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ScatteringData {
    /// The material that stands for it in the scene.
    pub material: MaterialIndex,
    /// Name of the modifier.
    pub modifier: String,
    /// XML.
    pub file: PathBuf,
    /// Up vector of its frame, in the world; the front of the surface is the data's front (+Z).
    pub up: DVec3,
    /// Whether its peak is a clear view (`aBSDF`).
    pub sees_through: bool,
}

const ARGUMENTS: &str = "`BSDF` has the strings: thickness file up-x up-y up-z functions [transform]; `aBSDF` the same without thickness; \
                         reals: none, or nine values of diffuse light that is added";
const WRITE_WINDOW: &str = "write it as a [[window]]: surface = \"….rad\" with this polygon, bsdf = \"….xml\"";

/// What a definition of scattering data says; its material is not yet known.
///
/// # Errors
/// Arguments that are missing; a thickness, a function file, added diffuse light or a pattern, which are not known here.
pub(super) fn read(definition: &Definition, base: &Path, placement: &Placement) -> Result<ScatteringData> {
    let object = definition.object();
    let sees_through = object.kind.word() == "aBSDF";
    if definition.modifier.is_some() {
        return Err(Error::new("a pattern on scattering data is not known here")
            .help("write `void` as its modifier, and put the colour into the data"));
    }
    let strings = match (sees_through, object.strings.split_first()) {
        (true, _) => &object.strings[..],
        (false, Some((thickness, rest))) => {
            match thickness.parse::<f64>() {
                Ok(0.0) => {}
                Ok(_) => {
                    return Err(Error::new(format!("its thickness {} says that it stands for geometry in the scene", shortened(thickness))).help(
                        "take slats and panes out of the scene into a file of their own, and write a [[window]]: surface = \"….rad\" with this \
                         polygon, bsdf = \"….xml\", shade = that file; or give the thickness 0 and leave the geometry out",
                    ));
                }
                Err(_) => {
                    return Err(Error::new(format!("the thickness '{}' is no number", shortened(thickness)))
                        .help("thicknesses from function files are not known here; write the number"));
                }
            }
            rest
        }
        (false, None) => &[],
    };
    let [file, x, y, z, functions, transform @ ..] = strings else {
        return Err(Error::new(format!("{} string arguments are too few", object.strings.len())).help(ARGUMENTS));
    };
    let up = match [x, y, z].map(|v| v.parse::<f64>()) {
        [Ok(x), Ok(y), Ok(z)] if x.is_finite() && y.is_finite() && z.is_finite() => DVec3::new(x, y, z),
        _ => {
            let text = format!(
                "its up vector '{} {} {}' is that of a function file ('{}')",
                shortened(x),
                shortened(y),
                shortened(z),
                shortened(functions)
            );
            return Err(Error::new(text).help("write the up vector in numbers; an upright pane has 0 0 1, one that lies 0 1 0"));
        }
    };
    if let Some(value) = object.reals.iter().find(|v| **v != 0.0) {
        return Err(Error::new(format!("diffuse light that is added to the data ({value}) is not known here"))
            .help(format!("put it into the data; or {WRITE_WINDOW}")));
    }
    let own = Xform::parse(transform)?;
    if own.count() != 1 || !own.files.is_empty() {
        return Err(Error::new("the transform of its up vector is no single motion").help(ARGUMENTS));
    }
    let turned = own.copies().first().map_or(up, |own| own.vector(up));
    Ok(ScatteringData {
        material: MaterialIndex(0),
        modifier: definition.name.clone(),
        file: super::patterns::find(file, definition.file(), base)?,
        up: placement.vector(turned).try_normalize().ok_or_else(|| Error::new("its up vector has no length").help(ARGUMENTS))?,
        sees_through,
    })
}

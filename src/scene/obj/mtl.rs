//! Colours of MTL files.

use crate::error::{Error, Result, Warnings};
use crate::scene::{MaterialKind, Pane};
use crate::text;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What of a material is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Colour {
    diffuse: [f64; 3],
    opacity: f64,
}

impl Colour {
    /// The material: diffuse, or a pane that passes what it does not cover.
    pub fn kind(&self) -> MaterialKind {
        let pane = Pane::of_transmittance([1.0 - self.opacity; 3]);
        match pane {
            Ok(pane) if self.opacity < 1.0 => pane.material(),
            // Clearer than any glass: as clear as glass is.
            Err(_) if self.opacity < 1.0 => MaterialKind::Glass { transmissivity: [1.0; 3], refraction_index: 1.52 },
            _ => MaterialKind::Plastic { color: self.diffuse.map(|c| c.clamp(0.0, 1.0)), specularity: 0.0, roughness: 0.0 },
        }
    }
}

/// Reads the libraries that are there; of those that are not a warning tells.
///
/// # Errors
/// Colours that are no numbers.
pub(super) fn read(libraries: &[PathBuf], obj: &Path, warnings: &mut Warnings) -> Result<BTreeMap<String, Colour>> {
    let mut found = BTreeMap::new();
    for library in libraries {
        if !library.exists() {
            let told = Error::new(format!("there is no file '{}'", library.display())).file(obj).field("mtllib");
            warnings.push(told.help("define the materials in a .rad file of the scene, or put the MTL file beside the OBJ file"));
            continue;
        }
        let text = text::read(library, "an MTL file")?;
        let mut name = None;
        for (number, line) in text.lines().enumerate() {
            let content = line.split('#').next().unwrap_or("").trim();
            let (word, rest) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
            if word == "newmtl" {
                name = Some(rest.trim().to_string());
                found.insert(rest.trim().to_string(), Colour { diffuse: [0.8; 3], opacity: 1.0 });
                continue;
            }
            let Some(colour) = name.as_ref().and_then(|n| found.get_mut(n)) else { continue };
            let numbers = || -> Result<Vec<f64>> {
                let finite = |w: &str| w.parse::<f64>().ok().filter(|v| v.is_finite());
                rest.split_whitespace().map(finite).collect::<Option<Vec<_>>>().filter(|n| !n.is_empty()).ok_or_else(|| {
                    Error::new(format!("'{content}' has no numbers")).file(library).line(number + 1).help("write Kd red green blue")
                })
            };
            match word {
                "Kd" if !rest.trim_start().starts_with(|c: char| c.is_ascii_alphabetic()) => {
                    let n = numbers()?;
                    colour.diffuse = [0, 1, 2].map(|i| *n.get(i).unwrap_or(&n[0]));
                }
                "d" if !rest.contains("halo") => colour.opacity = numbers()?[0].clamp(0.0, 1.0),
                "Tr" => colour.opacity = 1.0 - numbers()?[0].clamp(0.0, 1.0),
                _ => {}
            }
        }
    }
    Ok(found)
}

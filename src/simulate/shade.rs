//! What the sun is traced through: the real slats and panes of a window, and the black model around
//! them.

use super::project::{Project, WindowSection};
use crate::error::{Error, Result, Warnings};
use crate::scene::rad::ProxiedPane;
use crate::scene::{self, MaterialIndex, MaterialKind, Scene, Triangle, Window};
use glam::DVec3;
use std::path::PathBuf;

/// Geometry of a window's shade.
#[derive(Debug, Clone, PartialEq)]
pub struct Shade {
    /// Its triangles and materials, none of the room's.
    pub scene: Scene,
}

impl Shade {
    /// Reads the shade of a window. Its file may use materials of the project's scene files.
    ///
    /// # Errors
    /// Faults of the file; a shade without surfaces, or one that lies away from its window.
    pub fn read(project: &Project, section: &WindowSection, window: &Window, warnings: &mut Warnings) -> Result<Option<Self>> {
        let Some(file) = &section.shade else { return Ok(None) };
        let base = project.folder();
        let relative = |f: &PathBuf| f.strip_prefix(base).unwrap_or(f).to_path_buf();
        // Materials are looked up in all files before; what the shade adds comes last.
        let before: Vec<PathBuf> = project.scene.files.iter().filter(|f| !scene::gltf::is_gltf(f)).map(relative).collect();
        let mut known = Warnings::new();
        let first = scene::read_scene(&before, base, &mut known)?.triangles.len();
        let mut files = before;
        files.push(relative(file));
        let mut all = Warnings::new();
        let (together, panes) = if scene::gltf::is_gltf(file) {
            (scene::read_scene(&files, base, &mut all)?, Vec::new())
        } else {
            scene::rad::read_shade(&files, base, &mut all)?
        };
        for warning in all.iter().skip(known.iter().count()) {
            warnings.push(warning.clone());
        }
        let triangles = together.triangles[first.min(together.triangles.len())..].to_vec();
        let shade = Self { scene: Scene { triangles, sources: Vec::new(), ..together } };
        let lies_well = shade.check(window, warnings).and_then(|()| shade.check_slabs(&panes, warnings));
        lies_well.map_err(|e| e.file(file).field(format!("window '{}'", section.name)))?;
        Ok(Some(shade))
    }

    /// All of its corners.
    pub fn corners(&self) -> Vec<DVec3> {
        self.scene.triangles.iter().flat_map(|t| t.vertices).collect()
    }

    /// A shade must lie before or behind its window, and should cover it.
    fn check(&self, window: &Window, warnings: &mut Warnings) -> Result<()> {
        let (own_low, own_high) = extent(&self.corners(), window);
        let (low, high) = extent(&window.triangles.iter().flatten().copied().collect::<Vec<_>>(), window);
        if self.scene.triangles.is_empty() {
            return Err(Error::new("the shade has no surface").help("name the file with its slats and panes"));
        }
        let size = (high - low).length();
        let apart = (own_low - high).max(low - own_high);
        if apart.x > 0.0 || apart.y > 0.0 || apart.z > size {
            return Err(Error::new(format!(
                "the shade is not at its window: in the window's frame it spans {own_low:.3} … {own_high:.3}, the window {low:.3} … {high:.3}"
            ))
            .help("place it with xform, in the coordinates of the scene"));
        }
        let uncovered = (own_low - low).max(high - own_high);
        if uncovered.x > 0.05 * (high.x - low.x) || uncovered.y > 0.05 * (high.y - low.y) {
            warnings.push(
                Error::new(format!(
                    "the shade of window '{}' leaves {:.2} of its width or {:.2} of its height free: the sun shines in there",
                    window.name,
                    uncovered.x.max(0.0),
                    uncovered.y.max(0.0)
                ))
                .help("if there is glass, its panes belong into the shade's file too"),
            );
        }
        Ok(())
    }
}

/// Share of a pane's thickness, and length in the scene's unit, by which rounding may put geometry outside.
const SLAB_TOLERANCE: (f64, f64) = (0.01, 1e-4);

impl Shade {
    /// Geometry for which a `BSDF` of the file stands must lie in the slab that its thickness tells. What
    /// lies outside, Radiance's rays would meet beside the data that already contain it.
    fn check_slabs(&self, panes: &[ProxiedPane], warnings: &mut Warnings) -> Result<()> {
        let Some(thickest) = panes.iter().map(|p| p.thickness.abs()).reduce(f64::max) else { return Ok(()) };
        let outside = |p: DVec3| panes.iter().map(|pane| pane.outside(p)).fold(f64::INFINITY, f64::min);
        let allowed = SLAB_TOLERANCE.0 * thickest + SLAB_TOLERANCE.1;
        let farthest = |t: &&Triangle| t.vertices.into_iter().map(outside).fold(0.0, f64::max);
        let beyond: Vec<&Triangle> = self.scene.triangles.iter().filter(|t| farthest(t) > allowed).collect();
        let Some(worst) = beyond.iter().max_by(|a, b| farthest(a).total_cmp(&farthest(b))) else { return Ok(()) };
        let surface = &self.scene.surfaces[worst.surface as usize];
        let fault = Error::new(format!(
            "'{}' (line {}) lies {:.4} outside the slab of {thickest:.4} that its BSDF '{}' (line {}) stands for",
            surface.name,
            surface.line,
            farthest(worst),
            panes[0].origin.name,
            panes[0].origin.line
        ))
        .help("the geometry begins at the BSDF's surface and reaches as far behind it (before it, if negative) as its thickness");
        // Nothing inside: the thickness has the wrong sign, or the file the wrong place.
        if beyond.len() == self.scene.triangles.len() {
            return Err(fault);
        }
        warnings.push(fault);
        Ok(())
    }
}

/// Limits of points along the axes of a window's frame.
fn extent(points: &[DVec3], window: &Window) -> (DVec3, DVec3) {
    points
        .iter()
        .map(|p| window.frame.to_local(*p))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// The black model with the shades in place: everything in the scene absorbs all light but panes of
/// glass, the shades are as they are. Only light that comes straight through the windows, or by
/// their shades, is left; what the room then does with it belongs to other phases.
pub fn black_model<'s>(scene: &Scene, shades: impl Iterator<Item = &'s Shade>) -> Scene {
    let mut black = Scene { sources: Vec::new(), ..scene.clone() };
    for material in &mut black.materials {
        if !matches!(material.kind, MaterialKind::Glass { .. } | MaterialKind::Void) {
            material.kind = MaterialKind::Plastic { color: [0.0; 3], specularity: 0.0, roughness: 0.0 };
        }
    }
    for shade in shades {
        add(&mut black, &shade.scene);
    }
    black
}

/// Puts the surfaces of one scene into another.
pub fn add(scene: &mut Scene, other: &Scene) {
    let (materials, surfaces) = (scene.materials.len() as u32, scene.surfaces.len() as u32);
    scene.materials.extend(other.materials.iter().cloned());
    scene.surfaces.extend(other.surfaces.iter().cloned());
    scene.triangles.extend(other.triangles.iter().map(|t| Triangle {
        material: MaterialIndex(t.material.0 + materials),
        surface: t.surface + surfaces,
        ..*t
    }));
}

/// Surfaces of the shades whose mirror-like reflections of the sun are not traced.
pub fn warn_of_mirrors<'s>(shades: impl Iterator<Item = &'s Shade>, warnings: &mut Warnings) {
    // Below this a lost reflection is of no consequence.
    const LITTLE: f64 = 0.02;
    for shade in shades {
        let mirror = shade.scene.triangles.iter().map(|t| &shade.scene.materials[t.material.0 as usize]).find(|m| match m.kind {
            MaterialKind::Mirror { .. } => true,
            MaterialKind::Plastic { specularity, roughness, .. } | MaterialKind::Metal { specularity, roughness, .. } => {
                specularity > LITTLE && roughness * roughness <= 1e-6
            }
            _ => false,
        });
        if let Some(material) = mirror {
            warnings.push(
                Error::new(format!("'{}' reflects like a mirror: sunlight that its slats mirror into the room is left out", material.name))
                    .help("give it a roughness, as real slats have; then it is counted"),
            );
        }
    }
}

//! What the sun is traced through: the real slats and panes of a window, and the black model around
//! them.

use crate::error::{Error, Result, Warnings};
use crate::kernels::sun_matrix::mirrors::Mirrors;
use crate::scene::rad::ProxiedPane;
use crate::scene::{self, Material, MaterialIndex, MaterialKind, Pane, Scene, Triangle, Window};
use crate::simulate::project::{Project, WindowSection};
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
        let place = |e: Error| e.file(file).field(format!("window '{}'", section.name));
        if let (model, Some(part)) = scene::split_part(file)
            && scene::Format::of(&model) == scene::Format::Honeybee
        {
            let shade = Self { scene: scene::honeybee::read_sun_part(&model, &part, &mut Warnings::new())? };
            let mut doubts = Warnings::new();
            shade.check(window, &mut doubts).map_err(place)?;
            doubts.iter().for_each(|doubt| warnings.push(place(doubt.clone())));
            return Ok(Some(shade));
        }
        let base = project.folder();
        let relative = |f: &PathBuf| f.strip_prefix(base).unwrap_or(f).to_path_buf();
        // Materials are looked up in all files before; what the shade adds comes last.
        let before: Vec<PathBuf> =
            project.scene.files.iter().filter(|f| scene::Format::of(f) == scene::Format::Radiance).map(relative).collect();
        let mut known = Warnings::new();
        let first = scene::read_scene(&before, base, &mut known)?.triangles.len();
        let mut files = before;
        files.push(relative(file));
        let mut all = Warnings::new();
        let (together, panes) = if scene::Format::of(file) != scene::Format::Radiance {
            (scene::read_scene(&files, base, &mut all)?, Vec::new())
        } else {
            scene::rad::read_shade(&files, base, &mut all)?
        };
        for warning in all.iter().skip(known.iter().count()) {
            warnings.push(warning.clone());
        }
        let triangles = together.triangles[first.min(together.triangles.len())..].to_vec();
        let shade = Self { scene: Scene { triangles, sources: Vec::new(), ..together } };
        let mut doubts = Warnings::new();
        shade.check(window, &mut doubts).and_then(|()| shade.check_slabs(&panes, &mut doubts)).map_err(place)?;
        doubts.iter().for_each(|doubt| warnings.push(place(doubt.clone())));
        Ok(Some(shade))
    }

    /// A clear pane in the place of its window.
    pub fn of_pane(window: &Window, pane: &Pane) -> Self {
        let material = Material { name: format!("pane of {}", window.name), kind: pane.material() };
        let triangle = |vertices: &[DVec3; 3]| Triangle { vertices: *vertices, material: MaterialIndex(0), surface: 0 };
        let triangles = window.triangles.iter().map(triangle).collect();
        Self { scene: Scene { triangles, materials: vec![material], surfaces: vec![window.origin.clone()], ..Scene::default() } }
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

/// The material that a window's own polygons have, by the project's scene files and the window's own; nothing if it is
/// not defined there.
pub(super) fn own_material(project: &Project, section: &WindowSection, window: &Window) -> Option<MaterialKind> {
    if section.found.is_some() {
        // Its pane was found in the scene.
        return None;
    }
    let base = project.folder();
    let relative = |f: &PathBuf| f.strip_prefix(base).unwrap_or(f).to_path_buf();
    let file = scene::split_part(&section.surface).0;
    match scene::Format::of(&file) {
        scene::Format::Radiance => {}
        scene::Format::Honeybee => {
            let model = scene::honeybee::read(&file, &mut Warnings::new()).ok()?;
            let own = model.windows.iter().find(|w| w.window.name == window.name)?;
            return match &own.glazing {
                scene::honeybee::ModelGlazing::Glass(pane) => Some(pane.material()),
                scene::honeybee::ModelGlazing::Bsdf(_) => None,
            };
        }
        scene::Format::Gltf => return None,
        // Its material is one of the .rad files.
        scene::Format::Obj => {}
    }
    let is_radiance = |f: &&PathBuf| scene::Format::of(f) == scene::Format::Radiance;
    let mut files: Vec<PathBuf> = project.scene.files.iter().filter(is_radiance).map(relative).collect();
    files.push(relative(&section.surface));
    let all = scene::read_scene(&files, base, &mut Warnings::new()).ok()?;
    // The window's file comes last: of several surfaces of a name and line it is the last one.
    let is_own = |t: &&Triangle| all.surfaces.get(t.surface as usize).is_some_and(|s| *s == window.origin);
    let own = all.triangles.iter().rev().find(is_own)?;
    Some(all.materials[own.material.0 as usize].kind)
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
pub(crate) fn black_model<'s>(scene: &Scene, shades: impl Iterator<Item = &'s Shade>) -> Scene {
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
pub(crate) fn add(scene: &mut Scene, other: &Scene) {
    let (materials, surfaces) = (scene.materials.len() as u32, scene.surfaces.len() as u32);
    scene.materials.extend(other.materials.iter().cloned());
    scene.surfaces.extend(other.surfaces.iter().cloned());
    scene.triangles.extend(other.triangles.iter().map(|t| Triangle {
        material: MaterialIndex(t.material.0 + materials),
        surface: t.surface + surfaces,
        ..*t
    }));
}

/// What of the sun in mirror-like slats is not traced.
pub(crate) fn warn_of_mirrors<'s>(shades: impl Iterator<Item = &'s Shade>, warnings: &mut Warnings) {
    let mut all = Scene::default();
    shades.for_each(|s| add(&mut all, &s.scene));
    let mirrors = Mirrors::of(&all);
    let mut warn = |message: String, help: &str| warnings.push(Error::new(message).help(help));
    if mirrors.left_out > 0.01 {
        warn(
            format!(
                "{:.0} % of the shades' mirror-like surfaces are curved too finely: sunlight that they mirror into the room is left out",
                100.0 * mirrors.left_out
            ),
            "model slats by a few flat strips, or give them a roughness, as real slats have; then it is counted",
        );
    }
    if let Some(times) = mirrors.complete.filter(|times| *times < 3) {
        warn(
            format!(
                "slats mirror the sun in so many directions that light mirrored more than {} is left out",
                if times == 1 { "once" } else { "twice" }
            ),
            "model slats by fewer flat strips, or give them a roughness",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::trace::rooms::Builder;

    /// Warnings about slats of mirror whose strips are turned by these angles, degrees.
    fn warnings(turns: &[f64]) -> Vec<String> {
        let mut b = Builder::default();
        let mirror = b.material(MaterialKind::Mirror { color: [0.9; 3] });
        for turn in turns {
            let (y, z) = (turn.to_radians().cos(), turn.to_radians().sin());
            b.quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, y, z], [0.0, y, z]], mirror);
        }
        let mut found = Warnings::new();
        warn_of_mirrors([Shade { scene: b.scene }].iter(), &mut found);
        found.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn what_mirrors_lose_is_said() {
        assert!(warnings(&[20.0, 20.0]).is_empty(), "flat slats lose nothing");
        assert!(warnings(&[]).is_empty());
        let fine: Vec<f64> = (0..30).map(|i| 0.1 * f64::from(i)).collect();
        assert!(warnings(&fine)[0].contains("100 % of the shades' mirror-like surfaces"));
        let many: Vec<f64> = (0..20).map(|i| 3.0 * f64::from(i) + 0.03 * f64::from(i * i)).collect();
        assert!(warnings(&many)[0].contains("mirrored more than once"), "{:?}", warnings(&many));
    }
}

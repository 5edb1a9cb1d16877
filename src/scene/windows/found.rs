//! Plane panes of a scene, which may be its windows.

use super::{IN_PLANE, WindowBuilder, area_vector};
use crate::error::{Result, Warnings};
use crate::scene::{MaterialIndex, MaterialKind, Scene, SurfaceOrigin, Window};
use glam::DVec3;
use std::collections::BTreeMap;

/// Panes of one material in one plane.
#[derive(Debug, Clone)]
pub(crate) struct Panes {
    /// Their material.
    pub(crate) material: MaterialIndex,
    /// Unit normal of the first one's front.
    pub(crate) normal: DVec3,
    /// Triangles by surface, fronts to the side of the normal.
    pub(crate) surfaces: BTreeMap<u32, Vec<[DVec3; 3]>>,
    /// Their numbers among the scene's.
    pub(crate) numbers: Vec<usize>,
}

impl Panes {
    /// All triangles.
    pub(crate) fn triangles(&self) -> Vec<[DVec3; 3]> {
        self.surfaces.values().flatten().copied().collect()
    }

    /// m².
    pub(crate) fn area(&self) -> f64 {
        self.triangles().iter().map(|t| area_vector(t).length()).sum()
    }

    /// Where the first one was read from.
    pub(crate) fn origin(&self, scene: &Scene) -> SurfaceOrigin {
        let first = self.surfaces.keys().next().and_then(|s| scene.surfaces.get(*s as usize));
        first.cloned().unwrap_or(SurfaceOrigin { name: "glass".into(), file: "scene".into(), line: 1 })
    }

    /// The window that they are, with its normal into the room: along the panes' normal, or against it. `parameters` are
    /// those of rfluxmtx.
    ///
    /// # Errors
    /// As for windows of a file.
    pub(crate) fn window(&self, scene: &Scene, name: &str, along: bool, parameters: &str, warnings: &mut Warnings) -> Result<Window> {
        let mut builder = WindowBuilder::new(name.to_string(), self.origin(scene));
        builder.parameters(parameters)?;
        for (surface, triangles) in &self.surfaces {
            let turned = |t: &[DVec3; 3]| if along { *t } else { [t[0], t[2], t[1]] };
            let origin = scene.surfaces.get(*surface as usize).cloned().unwrap_or_else(|| self.origin(scene));
            builder.add(origin, triangles.iter().map(turned).collect());
        }
        builder.finish(warnings)
    }
}

/// A surface of more planes is curved.
const MOST_PLANES: usize = 12;

impl Scene {
    /// The panes of glass and of other materials, by plane and material; their surfaces that are curved are told apart.
    pub(crate) fn plane_panes(&self, others: &[MaterialIndex]) -> (Vec<Panes>, Vec<u32>) {
        let mut by_surface: BTreeMap<(u32, MaterialIndex), Vec<usize>> = BTreeMap::new();
        for (i, triangle) in self.triangles.iter().enumerate() {
            let is_glass = matches!(self.materials[triangle.material.0 as usize].kind, MaterialKind::Glass { .. });
            if (is_glass || others.contains(&triangle.material)) && area_vector(&triangle.vertices).length() > 0.0 {
                by_surface.entry((triangle.surface, triangle.material)).or_default().push(i);
            }
        }
        let (mut groups, mut curved): (Vec<Panes>, Vec<u32>) = (Vec::new(), Vec::new());
        for ((surface, material), numbers) in by_surface {
            let size = numbers.iter().map(|i| area_vector(&self.triangles[*i].vertices).length()).sum::<f64>().sqrt();
            // First among themselves: a surface may be the panes of several sides.
            let mut own: Vec<Panes> = Vec::new();
            for i in numbers {
                put(&mut own, material, surface, i, self.triangles[i].vertices, size);
            }
            if own.len() > MOST_PLANES {
                curved.push(surface);
                continue;
            }
            for panes in own {
                for (i, triangle) in panes.numbers.iter().zip(panes.triangles()) {
                    put(&mut groups, material, surface, *i, triangle, size);
                }
            }
        }
        (groups, curved)
    }
}

/// Puts a triangle to those in its plane.
fn put(groups: &mut Vec<Panes>, material: MaterialIndex, surface: u32, number: usize, triangle: [DVec3; 3], size: f64) {
    let Some(normal) = area_vector(&triangle).try_normalize() else { return };
    let is_in = |g: &Panes| {
        let at = g.surfaces.values().next().map_or(DVec3::ZERO, |t| t[0][0]);
        let near = |p: &DVec3| (*p - at).dot(g.normal).abs() <= IN_PLANE * size;
        g.material == material && g.normal.dot(normal).abs() > 1.0 - 1e-7 && triangle.iter().all(near)
    };
    let group = match groups.iter().position(is_in) {
        Some(place) => &mut groups[place],
        None => {
            groups.push(Panes { material, normal, surfaces: BTreeMap::new(), numbers: Vec::new() });
            groups.last_mut().expect("just pushed")
        }
    };
    let turned = if normal.dot(group.normal) < 0.0 { [triangle[0], triangle[2], triangle[1]] } else { triangle };
    group.surfaces.entry(surface).or_default().push(turned);
    group.numbers.push(number);
}

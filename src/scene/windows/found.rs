//! Plane panes of glass of a scene, which may be its windows.

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

    /// The window that they are, with its normal into the room: along the panes' normal, or against it.
    ///
    /// # Errors
    /// As for windows of a file.
    pub(crate) fn window(&self, scene: &Scene, name: &str, along: bool, warnings: &mut Warnings) -> Result<Window> {
        let mut builder = WindowBuilder::new(name.to_string(), self.origin(scene));
        for (surface, triangles) in &self.surfaces {
            let turned = |t: &[DVec3; 3]| if along { *t } else { [t[0], t[2], t[1]] };
            let origin = scene.surfaces.get(*surface as usize).cloned().unwrap_or_else(|| self.origin(scene));
            builder.add(origin, triangles.iter().map(turned).collect());
        }
        builder.finish(warnings)
    }
}

impl Scene {
    /// The panes of glass, by plane and material; surfaces of glass that are not plane are told apart.
    pub(crate) fn plane_panes(&self) -> (Vec<Panes>, Vec<u32>) {
        let mut by_surface: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (i, triangle) in self.triangles.iter().enumerate() {
            if matches!(self.materials[triangle.material.0 as usize].kind, MaterialKind::Glass { .. }) {
                by_surface.entry(triangle.surface).or_default().push(i);
            }
        }
        let (mut groups, mut curved): (Vec<Panes>, Vec<u32>) = (Vec::new(), Vec::new());
        for (surface, numbers) in by_surface {
            let triangles: Vec<[DVec3; 3]> = numbers.iter().map(|i| self.triangles[*i].vertices).collect();
            let areas: Vec<DVec3> = triangles.iter().map(area_vector).collect();
            let size = areas.iter().map(|a| a.length()).sum::<f64>().sqrt();
            let Some(normal) = areas.iter().max_by(|a, b| a.length().total_cmp(&b.length())).and_then(|a| a.try_normalize()) else {
                continue;
            };
            let at = triangles[0][0];
            let is_in =
                |t: &[DVec3; 3], at: DVec3, normal: DVec3, size: f64| t.iter().all(|p| (*p - at).dot(normal).abs() <= IN_PLANE * size);
            if !triangles.iter().all(|t| is_in(t, at, normal, size)) {
                curved.push(surface);
                continue;
            }
            let material = self.triangles[numbers[0]].material;
            let own = |g: &&mut Panes| {
                let first = g.surfaces.values().next().map_or(DVec3::ZERO, |t| t[0][0]);
                g.material == material
                    && g.normal.dot(normal).abs() > 1.0 - 1e-9
                    && triangles.iter().all(|t| is_in(t, first, g.normal, size))
            };
            let to = |normal: DVec3, t: &[DVec3; 3]| if area_vector(t).dot(normal) < 0.0 { [t[0], t[2], t[1]] } else { *t };
            match groups.iter_mut().find(own) {
                Some(group) => {
                    let turned = triangles.iter().map(|t| to(group.normal, t)).collect();
                    group.surfaces.insert(surface, turned);
                }
                None => {
                    let turned = triangles.iter().map(|t| to(normal, t)).collect();
                    groups.push(Panes { material, normal, surfaces: BTreeMap::from([(surface, turned)]) });
                }
            }
        }
        (groups, curved)
    }
}

//! Panes of glass that scene files have in the place of a window.

use super::openings::openings;
use super::{IN_PLANE, ONE_PANE, PARALLEL_DEG};
use crate::scene::{Material, MaterialIndex, MaterialKind, Scene, Triangle, Window};
use std::collections::{BTreeMap, BTreeSet};

/// A surface of glass that covers a window, seen along its normal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PaneAt {
    /// Index into [`Scene::surfaces`].
    pub(crate) surface: u32,
    /// Its material.
    pub(crate) material: MaterialIndex,
    /// Of the window that it covers, m².
    pub(crate) area: f64,
    /// From the window's plane, positive inside; of the farthest part.
    pub(crate) distance: f64,
    /// Whether it lies in the window's plane.
    pub(crate) is_in_plane: bool,
}

impl Scene {
    /// A material.
    ///
    /// # Panics
    /// If the scene has no such one.
    pub(crate) fn material(&self, index: MaterialIndex) -> &Material {
        &self.materials[index.0 as usize]
    }

    /// Panes of glass in or close to a window's plane that cover some of it.
    pub(crate) fn panes_at(&self, window: &Window) -> Vec<PaneAt> {
        let (openings, parallel) = (openings(std::slice::from_ref(window)), PARALLEL_DEG.to_radians().cos());
        let mut found: BTreeMap<u32, PaneAt> = BTreeMap::new();
        for triangle in &self.triangles {
            if !matches!(self.material(triangle.material).kind, MaterialKind::Glass { .. }) {
                continue;
            }
            for opening in &openings {
                let Some(overlap) = opening.base.overlap(&triangle.vertices, ONE_PANE * opening.size) else { continue };
                if overlap.cosine.abs() < parallel {
                    continue;
                }
                let [low, high] = overlap.depth;
                let distance = if low.abs() > high.abs() { low } else { high };
                let pane = found.entry(triangle.surface).or_insert(PaneAt {
                    surface: triangle.surface,
                    material: triangle.material,
                    area: 0.0,
                    distance: 0.0,
                    is_in_plane: true,
                });
                pane.area += overlap.area;
                pane.distance = if distance.abs() > pane.distance.abs() { distance } else { pane.distance };
                pane.is_in_plane &= distance.abs() <= IN_PLANE * opening.size;
            }
        }
        found.into_values().collect()
    }

    /// Cuts the parts of these surfaces out that lie in the plane of a window and cover it.
    pub(crate) fn take_out(&mut self, window: &Window, surfaces: &BTreeSet<u32>) {
        let openings = openings(std::slice::from_ref(window));
        let rest = |triangle: &Triangle| -> Vec<Triangle> {
            if !surfaces.contains(&triangle.surface) {
                return vec![*triangle];
            }
            let mut parts = vec![triangle.vertices];
            for opening in &openings {
                parts = parts
                    .into_iter()
                    .flat_map(|part| match opening.base.overlap(&part, IN_PLANE * opening.size) {
                        Some(found) => found.rest,
                        None => vec![part],
                    })
                    .collect();
            }
            parts.into_iter().map(|vertices| Triangle { vertices, ..*triangle }).collect()
        };
        self.triangles = self.triangles.iter().flat_map(rest).collect();
    }
}

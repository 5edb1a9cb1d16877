//! Faces and openings in the same place, and neighbours that are missing.

use super::Reader;
use crate::error::Error;
use crate::scene::honeybee::geometry::Face3d;
use crate::scene::honeybee::json::Node;
use crate::scene::honeybee::modifiers::Kind;
use crate::scene::honeybee::windows::doubled;
use crate::scene::{Material, MaterialIndex, Triangle};
use std::collections::{HashMap, HashSet};

impl<'a> Reader<'a, '_> {
    fn key(&self, face: &Face3d) -> Vec<[i64; 3]> {
        let mut key: Vec<[i64; 3]> = face.boundary.iter().map(|p| p.to_array().map(|v| (v / self.tolerance).round() as i64)).collect();
        key.sort_unstable();
        key
    }

    pub(super) fn look_for_double(&mut self, face: &Node<'a>, outline: &Face3d, room: Option<&Node<'a>>) {
        let key = self.key(outline);
        let name = face.value["identifier"].as_str().unwrap_or("").to_string();
        if let Some(other) = self.outlines.insert(key, name) {
            let rooms = if room.is_some() { ": both count, as outer walls" } else { "" };
            let told = face.error(format!("it lies in the same place as face '{other}'{rooms}"));
            self.warn(told.help("let Honeybee solve the adjacency of the rooms, or remove one of the two"));
        }
    }

    pub(super) fn check_adjacencies(&mut self) {
        let lost: Vec<(String, String)> = self.adjacencies.iter().filter(|(_, partner)| !self.faces.contains(partner)).cloned().collect();
        for (face, partner) in lost {
            let told = Error::new(format!(
                "face '{face}' is next to '{partner}', which is not in the model: it counts as an inner wall, and its apertures let no daylight in"
            ));
            self.warn(told.help("solve the adjacency of the rooms again, or give the face the boundary condition Outdoors"));
        }
    }

    /// Two openings in the same place that face each other are one pane between two rooms.
    pub(super) fn join_doubled_openings(&mut self) {
        let mut first: HashMap<Vec<[i64; 3]>, usize> = HashMap::new();
        let mut gone = HashSet::new();
        for i in 0..self.openings.len() {
            let key = self.key(&self.openings[i].face);
            let Some(&other) = first.get(&key) else {
                first.insert(key, i);
                continue;
            };
            if self.openings[i].face.normal().dot(self.openings[other].face.normal()) < 0.0 && !gone.contains(&other) {
                gone.extend([other, i]);
            }
        }
        if gone.is_empty() {
            return;
        }
        let openings = std::mem::take(&mut self.openings);
        let mut names = Vec::new();
        for (i, opening) in openings.into_iter().enumerate() {
            if !gone.contains(&i) {
                self.openings.push(opening);
                continue;
            }
            let key = self.key(&opening.face);
            if first[&key] != i {
                let other = names.iter().find(|(k, _)| *k == key).map_or("", |(_, n): &(_, String)| n.as_str());
                let told = doubled(other, &opening.origin.name, self.file, "rooms".to_string());
                self.warnings.push(told);
                continue;
            }
            names.push((key, opening.origin.name.clone()));
            let Kind::Material(kind) = opening.modifier().kind else { continue };
            let scene = &mut self.scene;
            let name = opening.modifier().identifier.clone();
            let material = *self.materials.entry(name.clone()).or_insert_with(|| {
                scene.materials.push(Material { name, kind });
                MaterialIndex((scene.materials.len() - 1) as u32)
            });
            let surface = scene.surfaces.len() as u32;
            scene.surfaces.push(opening.origin);
            scene.triangles.extend(opening.face.triangles().triangles.into_iter().map(|vertices| Triangle { vertices, material, surface }));
        }
    }
}

//! What a scene holds, and what looks wrong with it, before anything is computed.

mod edges;

pub use edges::{Edges, OpenSurface};

use super::honeybee::ModelGlazing;
use super::{Format, Material, MaterialKind, Scene, SurfaceOrigin, Triangle, Window, files, gltf, honeybee};
use crate::error::{Result, Warnings};
use crate::scene::MaterialIndex;
use glam::DVec3;
use serde::Serialize;
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// What scene files hold together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneInfo {
    /// Triangles, windows not counted.
    pub triangles: usize,
    /// Surfaces, as the files name them.
    pub surfaces: usize,
    /// Least and greatest coordinates, windows included; `None` if there is nothing.
    pub extent: Option<[[f64; 3]; 2]>,
    /// Materials in use, in order of first appearance.
    pub materials: Vec<MaterialUse>,
    /// Windows that the files mark as such; `.rad` and OBJ files mark none.
    pub windows: Vec<WindowUse>,
    /// Names of sensor grids, with the number of sensors.
    pub sensors: Vec<(String, usize)>,
    /// Names of views.
    pub views: Vec<String>,
    /// Edges of the triangles, windows included.
    pub edges: Edges,
    /// Pairs of surfaces with the same corners.
    pub doubled: Vec<[String; 2]>,
    /// What looks wrong, for people.
    pub doubts: Vec<String>,
}

/// What a material is used for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaterialUse {
    /// Its name.
    pub name: String,
    /// Its kind, as Radiance calls it, with what it reflects or lets pass.
    pub kind: String,
    /// Surfaces.
    pub surfaces: usize,
    /// Area of one side, in the scene's unit squared.
    pub area: f64,
}

/// A window of the files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WindowUse {
    /// Its name.
    pub name: String,
    /// Area, in the scene's unit squared.
    pub area: f64,
    /// Azimuth (degrees from +y, clockwise) and altitude of where it looks out to.
    pub faces: [f64; 2],
    /// Polygons or apertures.
    pub apertures: usize,
    /// What fills it, if the file says so.
    pub glazing: String,
}

/// Surfaces that the message about edges names.
const NAMED: usize = 6;
/// Median edges longer than these look like millimetres, or like inches or centimetres.
const LIKE_MILLIMETRES: f64 = 300.0;
const LIKE_INCHES: f64 = 25.0;

impl SceneInfo {
    /// Reads files as one scene, and looks at it.
    ///
    /// # Errors
    /// As [`files::read_scene`].
    pub fn read(paths: &[PathBuf], warnings: &mut Warnings) -> Result<Self> {
        let (mut scene, scattering) = files::read_scene_and_scattering(paths, Path::new(""), warnings)?;
        for data in &scattering {
            scene.materials[data.material.0 as usize].name = format!("{} (BSDF {})", data.modifier, data.file.display());
        }
        let (mut windows, mut sensors, mut views) = (Vec::new(), Vec::new(), Vec::new());
        let mut unit_is_known = false;
        for file in paths {
            match Format::of(file) {
                Format::Honeybee => {
                    let model = honeybee::read(file, warnings)?;
                    unit_is_known = true;
                    for w in &model.windows {
                        let glazing = match &w.glazing {
                            ModelGlazing::Glass(pane) => describe(&pane.material()),
                            ModelGlazing::Bsdf(data) => format!("BSDF {}", data.display()),
                        };
                        let states = if w.states.is_empty() { String::new() } else { format!(", the first of {} states", w.states.len()) };
                        windows.push((w.window.clone(), w.apertures.len(), format!("{}, {glazing}{states}", w.modifier)));
                    }
                    sensors.extend(model.sensors.iter().map(|g| (g.name.clone(), g.sensors.len())));
                    views.extend(model.views.iter().map(|v| v.name.clone()));
                }
                Format::Gltf => {
                    let contents = gltf::read(file, &gltf::Options::default(), warnings)?;
                    unit_is_known = true;
                    windows.extend(contents.windows.into_iter().map(|w| (w, 1, String::new())));
                    sensors.extend(contents.sensors.iter().map(|g| (g.name.clone(), g.sensors.len())));
                }
                _ => {}
            }
        }
        Ok(Self::of(&scene, windows, sensors, views, unit_is_known))
    }

    fn of(
        scene: &Scene,
        windows: Vec<(Window, usize, String)>,
        sensors: Vec<(String, usize)>,
        views: Vec<String>,
        unit_is_known: bool,
    ) -> Self {
        let window_triangles = windows.iter().enumerate().flat_map(|(i, (w, ..))| {
            let surface = (scene.surfaces.len() + i) as u32;
            w.triangles.iter().map(move |vertices| Triangle { vertices: *vertices, material: MaterialIndex(0), surface })
        });
        let all: Vec<Triangle> = scene.triangles.iter().copied().chain(window_triangles).collect();
        let names: Vec<SurfaceOrigin> = scene
            .surfaces
            .iter()
            .cloned()
            .chain(windows.iter().map(|(w, ..)| SurfaceOrigin { name: w.name.clone(), ..w.origin.clone() }))
            .collect();
        let edges = Edges::of(&all, &names);
        let corners = || all.iter().flat_map(|t| t.vertices);
        let extent = corners().next().map(|first| {
            let (low, high) = corners().fold((first, first), |(low, high), c| (low.min(c), high.max(c)));
            [low.to_array(), high.to_array()]
        });
        let doubled = doubled(&scene.triangles, &scene.surfaces, edges.tolerance);
        let windows = windows.into_iter().map(|(w, apertures, glazing)| WindowUse {
            area: w.area(),
            faces: w.faces(),
            apertures,
            glazing,
            name: w.name,
        });
        let mut info = Self {
            triangles: scene.triangles.len(),
            surfaces: scene.surfaces.len(),
            extent,
            materials: materials(scene),
            windows: windows.collect(),
            sensors,
            views,
            edges,
            doubled,
            doubts: Vec::new(),
        };
        info.doubts = info.find_doubts(unit_is_known);
        info
    }

    fn find_doubts(&self, unit_is_known: bool) -> Vec<String> {
        let mut doubts = Vec::new();
        let median = self.edges.median_length;
        if !unit_is_known && median > LIKE_INCHES {
            let (unit, scales) = match median > LIKE_MILLIMETRES {
                true => ("millimetres", "!xform -s 0.001 room.rad"),
                false => ("inches or centimetres", "!xform -s 0.0254 room.rad, or -s 0.01"),
            };
            doubts.push(format!("half of all edges are longer than {median:.0}: lengths look like {unit}; metres are wanted ({scales})"));
        }
        if self.edges.open > 0 {
            let names: Vec<String> =
                self.edges.open_surfaces.iter().take(NAMED).map(|s| format!("'{}' ({:.2})", s.name, s.length)).collect();
            let more = if self.edges.open_surfaces.len() > NAMED { " and others" } else { "" };
            doubts.push(format!(
                "{} edges are open over {:.2} in all, at {}{more}: right for shades, overhangs and furniture of single sheets; in walls, floors \
                 and ceilings light leaks there",
                self.edges.open,
                self.edges.open_length,
                names.join(", ")
            ));
        }
        if self.edges.turned > 0 {
            doubts.push(format!(
                "at {} of {} edges that two triangles share, these face opposite ways: of no consequence but for mirrors and windows",
                self.edges.turned, self.edges.shared
            ));
        }
        if let Some([a, b]) = self.doubled.first() {
            doubts.push(format!(
                "{} surfaces have the same corners as others, '{a}' and '{b}' first: which of their materials counts is left to chance",
                self.doubled.len()
            ));
        }
        doubts
    }
}

fn materials(scene: &Scene) -> Vec<MaterialUse> {
    let of = |m: &Material| MaterialUse { name: m.name.clone(), kind: describe(&m.kind), surfaces: 0, area: 0.0 };
    let mut uses: Vec<MaterialUse> = scene.materials.iter().map(of).collect();
    let mut last = None;
    for t in &scene.triangles {
        let used = &mut uses[t.material.0 as usize];
        used.surfaces += usize::from(last != Some(t.surface));
        let [a, b, c] = t.vertices;
        used.area += (b - a).cross(c - a).length() / 2.0;
        last = Some(t.surface);
    }
    uses.retain(|u| u.surfaces > 0);
    uses
}

/// A material's kind in a word, and its main number.
fn describe(kind: &MaterialKind) -> String {
    let debug = format!("{kind:?}");
    let word = debug.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("").to_lowercase();
    let mean = |c: &[f64; 3]| 0.265 * c[0] + 0.670 * c[1] + 0.065 * c[2];
    match kind {
        MaterialKind::Plastic { color, specularity, .. } => {
            format!("{word}, reflectance {:.3}", mean(color) * (1.0 - specularity) + specularity)
        }
        MaterialKind::Metal { color, .. } | MaterialKind::Mirror { color } => format!("{word}, reflectance {:.3}", mean(color)),
        MaterialKind::Trans { color, specularity, transmissivity, .. } => {
            format!("{word}, transmittance {:.3}", mean(color) * (1.0 - specularity) * transmissivity)
        }
        MaterialKind::Glass { .. } => {
            let pane = super::Pane::of_material(kind);
            format!("{word}, transmittance {:.3}", pane.map_or(0.0, |p| mean(&p.at(1.0).0)))
        }
        _ => word,
    }
}

/// Corners nearer than this part of the scene's farthest coordinate are the same place.
const SAME_PLACE: f64 = 1e-7;

/// Surfaces of different materials in the same place, of which chance decides which a ray meets: their number, and the
/// first two.
pub(crate) fn contradictions(scene: &Scene) -> (usize, Option<[SurfaceOrigin; 2]>) {
    if scene.triangles.iter().any(|t| t.surface as usize >= scene.surfaces.len()) {
        return (0, None);
    }
    let mut materials = vec![None; scene.surfaces.len()];
    scene.triangles.iter().for_each(|t| materials[t.surface as usize] = Some(t.material));
    let kind = |i: usize| materials[i].map(|m: MaterialIndex| scene.material(m).kind);
    let size = scene.triangles.iter().flat_map(|t| t.vertices).fold(0.0, |most: f64, v| most.max(v.abs().max_element()));
    let tolerance = (SAME_PLACE * size).max(f64::MIN_POSITIVE);
    let pairs = doubled_surfaces(&scene.triangles, scene.surfaces.len(), tolerance);
    let differ: Vec<[usize; 2]> = pairs.into_iter().filter(|[a, b]| kind(*a) != kind(*b)).collect();
    (differ.len(), differ.first().map(|pair| pair.map(|i| scene.surfaces[i].clone())))
}

/// Names of surfaces with the same corners.
fn doubled(triangles: &[Triangle], surfaces: &[SurfaceOrigin], tolerance: f64) -> Vec<[String; 2]> {
    doubled_surfaces(triangles, surfaces.len(), tolerance).into_iter().map(|pair| pair.map(|i| surfaces[i].name.clone())).collect()
}

/// Numbers of surfaces with the same corners.
fn doubled_surfaces(triangles: &[Triangle], surfaces: usize, tolerance: f64) -> Vec<[usize; 2]> {
    let mut corners: Vec<Vec<[i64; 3]>> = vec![Vec::new(); surfaces];
    for t in triangles {
        let rounded = t.vertices.map(|v: DVec3| v.to_array().map(|c| (c / tolerance).round() as i64));
        corners[t.surface as usize].extend(rounded);
    }
    let mut seen: HashMap<Vec<[i64; 3]>, usize> = HashMap::new();
    let mut found = Vec::new();
    for (i, mut key) in corners.into_iter().enumerate().filter(|(_, c)| !c.is_empty()) {
        key.sort_unstable();
        key.dedup();
        match seen.get(&key) {
            Some(first) => found.push([*first, i]),
            None => _ = seen.insert(key, i),
        }
    }
    found
}

impl fmt::Display for SceneInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "scene: {} triangles of {} surfaces, {} materials", self.triangles, self.surfaces, self.materials.len())?;
        if let Some([low, high]) = self.extent {
            let [x, y, z] = [0, 1, 2].map(|i| high[i] - low[i]);
            writeln!(
                f,
                "extent: {x:.3} × {y:.3} × {z:.3}, from {:.3} {:.3} {:.3} to {:.3} {:.3} {:.3}",
                low[0], low[1], low[2], high[0], high[1], high[2]
            )?;
        }
        let width = self.materials.iter().map(|m| m.name.chars().count()).max().unwrap_or(0);
        for m in &self.materials {
            writeln!(f, "material {:width$}  {:9.2} m² in {} surfaces  {}", m.name, m.area, m.surfaces, m.kind)?;
        }
        for w in &self.windows {
            let [azimuth, altitude] = w.faces;
            let tilt = if altitude == 0.0 { String::new() } else { format!(" and {altitude}° up") };
            let glazing = if w.glazing.is_empty() { String::new() } else { format!(", {}", w.glazing) };
            writeln!(f, "window {}: {:.2} m² facing {azimuth}°{tilt}, {} apertures{glazing}", w.name, w.area, w.apertures)?;
        }
        for (name, count) in &self.sensors {
            writeln!(f, "sensors {name}: {count}")?;
        }
        for name in &self.views {
            writeln!(f, "view {name}")?;
        }
        for doubt in &self.doubts {
            writeln!(f, "doubt: {doubt}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;

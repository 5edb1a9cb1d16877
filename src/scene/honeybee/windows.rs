//! Openings to the outside as windows: grouped by plane, orientation, modifier and dynamic group.

use super::geometry::Face3d;
use super::modifiers::Kind;
use super::states::{self, ModelGlazing, ModelState, ModelSun, Opening, OpeningState};
use crate::error::{Error, Result, Warnings};
use crate::limits;
use crate::scene::Window;
use crate::scene::windows::WindowBuilder;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// A window of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelWindow {
    /// Its name, geometry and basis.
    pub window: Window,
    /// The modifier of its apertures, in the first state.
    pub modifier: String,
    /// What fills it, in the first state.
    pub glazing: ModelGlazing,
    /// What suns pass in the first state, if by anything but that.
    pub sun: Option<ModelSun>,
    /// The windows that change their states with it: its own name if there are none.
    pub group: String,
    /// All its states; none if it never changes.
    pub states: Vec<ModelState>,
    /// Identifiers of its apertures and glass doors.
    pub apertures: Vec<String>,
}

/// Planes whose normals differ by less than about half of this are the same.
const NORMAL_STEP: f64 = 0.01;
/// Longest name of a window; a project's names may be as long.
const LONGEST_NAME: usize = 80;

/// Groups openings; `tolerance` in metres is what separates planes.
///
/// # Errors
/// More openings than a model may have; windows without area.
pub(super) fn group(openings: Vec<Opening>, tolerance: f64, warnings: &mut Warnings) -> Result<Vec<ModelWindow>> {
    if openings.len() > limits::WINDOW_SURFACES {
        let help = "take apart the model, or join the apertures of a wall";
        return Err(limits::exceeded("the model has", limits::WINDOW_SURFACES, "apertures to the outside").help(help));
    }
    let rounded = |v: f64, step: f64| (v / step).round() as i64;
    let mut groups: HashMap<_, usize> = HashMap::new();
    let mut sorted: Vec<Vec<Opening>> = Vec::new();
    for opening in openings {
        let normal = opening.face.normal();
        let plane = opening.face.boundary[0].dot(normal);
        let turned = normal.to_array().map(|v| rounded(v, NORMAL_STEP));
        let made_of = |s: &OpeningState| (s.modifier.identifier.clone(), s.direct.as_ref().map(|d| d.identifier.clone()));
        let states: Vec<_> = opening.states.iter().map(made_of).collect();
        let key = (states, opening.group.clone(), turned, rounded(plane, tolerance));
        let index = *groups.entry(key).or_insert_with(|| {
            sorted.push(Vec::new());
            sorted.len() - 1
        });
        sorted[index].push(opening);
    }
    // honeybee-radiance has the fronts of its static polygons outside, but those of its three-phase groups inside.
    let is_static = |o: &&Opening| o.group.is_none() && matches!(o.modifier().kind, Kind::Bsdf { .. });
    if let Some(first) = sorted.iter().flatten().find(is_static) {
        let told = format!(
            "scattering data have their front outside, as WINDOW and three phases have it: '{}' and all others of a BSDF; Radiance's own rays in \
             the static scene of honeybee-radiance meet them turned round",
            first.origin.name
        );
        warnings.push(Error::new(told).file(&first.origin.file).help("of data that are the same from both sides it makes no difference"));
    }
    // Groups have their names before all others, so that none has to give way to an aperture of the same name.
    let mut taken = HashSet::new();
    let mut names: HashMap<String, String> = HashMap::new();
    for group in sorted.iter().filter_map(|s| s[0].group.clone()) {
        names.entry(group).or_insert_with_key(|group| unique(group, &mut taken));
    }
    let mut used = HashSet::new();
    let window = |openings: Vec<Opening>| {
        let first = &openings[0];
        let group = first.group.as_ref().map(|group| names[group].clone());
        let name = match (&group, &openings[..]) {
            (Some(group), _) if used.insert(group.clone()) => group.clone(),
            (Some(group), _) => unique(group, &mut taken),
            (None, [only]) => unique(&only.origin.name, &mut taken),
            (None, _) => unique(orientation(first.face.normal()), &mut taken),
        };
        window(openings, group, name, warnings)
    };
    sorted.into_iter().map(window).collect()
}

fn window(group: Vec<Opening>, of_group: Option<String>, name: String, warnings: &mut Warnings) -> Result<ModelWindow> {
    let first = &group[0];
    let mut builder = WindowBuilder::new(name.clone(), first.origin.clone());
    if let Some((up, basis)) = first.states.iter().find_map(|s| s.modifier.directions()) {
        builder.parameters(&format!("h={basis} u={},{},{}", up.x, up.y, up.z))?;
    }
    let state = |(number, state): (usize, &OpeningState)| {
        let why = |why: &str| Error::new(format!("a window '{name}' of '{}' {why}", state.modifier.identifier));
        Ok(ModelState {
            name: format!("{number}_{}", of_group.as_ref().unwrap_or(&name)),
            modifier: state.modifier.identifier.clone(),
            glazing: state.glazing().map_err(why)?,
            sun: states::sun(&group, number),
        })
    };
    let mut states = first.states.iter().enumerate().map(state).collect::<Result<Vec<_>>>()?;
    let ModelState { glazing, sun, .. } = states[0].clone();
    if states.len() == 1 {
        states.clear();
    }
    for opening in &group {
        let inward = opening.face.triangles().triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect();
        builder.add(opening.origin.clone(), inward);
    }
    Ok(ModelWindow {
        window: builder.finish(warnings)?,
        modifier: first.modifier().identifier.clone(),
        glazing,
        sun,
        group: of_group.filter(|_| !states.is_empty()).unwrap_or(name),
        states,
        apertures: group.iter().map(|o| o.origin.name.clone()).collect(),
    })
}

/// Where an outward normal points.
fn orientation(normal: DVec3) -> &'static str {
    match normal.z {
        z if z > 0.7 => "skylight",
        z if z < -0.7 => "below",
        _ => {
            let azimuth = normal.x.atan2(normal.y).to_degrees().rem_euclid(360.0);
            ["north", "northeast", "east", "southeast", "south", "southwest", "west", "northwest"][((azimuth / 45.0).round() as usize) % 8]
        }
    }
}

/// A name that can be part of a file's, and that no other has (capitals do not count).
pub(crate) fn unique(wanted: &str, taken: &mut HashSet<String>) -> String {
    let allowed = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ') { c } else { '_' };
    let plain: String = wanted.trim_start_matches('.').chars().map(allowed).take(LONGEST_NAME).collect();
    let plain = if plain.is_empty() { "unnamed".to_string() } else { plain };
    let mut name = plain.clone();
    let mut number = 2;
    while !taken.insert(name.to_lowercase()) {
        name = format!("{plain}-{number}");
        number += 1;
    }
    name
}

/// On which side of its openings the room lies, by rays through the room's own faces.
pub(super) struct RoomSolid {
    triangles: Vec<[DVec3; 3]>,
}

impl RoomSolid {
    /// The faces of a room, without the holes for their openings.
    pub fn new(faces: &[Face3d]) -> Self {
        Self { triangles: faces.iter().flat_map(|f| f.triangles().triangles).collect() }
    }

    /// Whether the front of a face looks out of the room; `None` if the room is not closed.
    pub fn faces_out(&self, face: &Face3d) -> Option<bool> {
        let triangles = face.triangles().triangles;
        let size = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).length();
        let largest = triangles.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
        let start = largest.iter().sum::<DVec3>() / 3.0;
        let near = 1e-4 * size(largest).sqrt();
        let normal = face.normal();
        let (u, v) = normal.any_orthonormal_pair();
        let mut votes = 0i32;
        // Slightly off the normal, so that no ray meets an edge of a rectangular room.
        for tilt in [0.217 * u + 0.131 * v, -0.173 * u + 0.259 * v, 0.087 * u - 0.311 * v] {
            let [ahead, behind] = [1.0, -1.0].map(|sign| {
                let direction = sign * normal + tilt;
                self.triangles.iter().filter(|t| hit(t, start, direction).is_some_and(|d| d > near)).count() % 2
            });
            votes += match (ahead, behind) {
                (0, 1) => 1,
                (1, 0) => -1,
                _ => 0,
            };
        }
        (votes.abs() >= 2).then_some(votes > 0)
    }
}

/// Distance to a triangle in units of the direction.
fn hit(&[a, b, c]: &[DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let det = ab.dot(p);
    if det == 0.0 {
        return None;
    }
    let t = origin - a;
    let u = t.dot(p) / det;
    let q = t.cross(ab);
    let v = direction.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| ac.dot(q) / det)
}

/// What two windows in the same place call for.
pub(super) fn doubled(first: &str, second: &str, file: &std::path::Path, place: String) -> Error {
    Error::new(format!("'{second}' lies in the same place as '{first}' and faces the other way: both count as one pane between two rooms"))
        .file(file)
        .field(place)
        .help("let Honeybee solve the adjacency of the rooms, or remove one of the two")
}

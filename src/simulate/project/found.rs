//! Windows of a project that names none: panes of the scene's glass, and surfaces of scattering data, between indoors
//! and the open sky.
//!
//! Rays from both sides of a pane, spread as cosines, tell where it lies: panes count as walls to them, so that what
//! meets nothing is under the open sky on that side. Glass that is no window stays in the scene as it is; light passes
//! it all the same, found by chance. Scattering data elsewhere are an error: rays of a scene do not meet them.

use super::filling::{Filling, SunData};
use super::parts::Parts;
use super::sections::WindowSection;
use super::table::Place;
use crate::bsdf;
use crate::bvh::Caster;
use crate::error::{Error, Result, Warnings};
use crate::random::Random;
use crate::scene::honeybee::{basis_of, unique_name};
use crate::scene::windows::found::Panes;
use crate::scene::{self, MaterialIndex, MaterialKind, ScatteringData, Scene, SurfaceOrigin};
use glam::DVec3;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Rays from each side of a pane.
const RAYS: usize = 1024;
/// A side is under the open sky if this share of its rays meets nothing.
const OPEN: f64 = 0.02;
/// The room's side of a window has at most this part of the other side's share: rooms may have cracks.
const CLOSED: f64 = 0.25;
/// A room is told to be open if this share of the rays from the room's side of a pane meets nothing.
const LEAK: f64 = 0.005;
/// Windows that are taken; rays are aimed at each.
const MOST: usize = 256;

/// What the scene of a project has for windows.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Found {
    /// Its windows.
    pub windows: Vec<WindowSection>,
    /// Why other glass is none, for people.
    pub left: Vec<String>,
    /// What there is to say of the windows.
    pub warnings: Vec<Error>,
}

/// Finds the windows of a scene; `place` is where the project names its files.
///
/// # Errors
/// As for scenes and windows of a file; scattering data that are no window.
pub(super) fn find_in(files: &[PathBuf], folder: &Path, place: &Place) -> Result<Found> {
    let files: Vec<PathBuf> = files.iter().map(|f| f.strip_prefix(folder).unwrap_or(f).to_path_buf()).collect();
    // What the scene is warned of is said when it is read for the run.
    let (scene, scattering) = scene::read_scene_and_scattering(&files, folder, &mut Warnings::new())?;
    find(&scene, &scattering, place)
}

fn find(scene: &Scene, scattering: &[ScatteringData], place: &Place) -> Result<Found> {
    let (mut found, mut warnings) = (Found::default(), Warnings::new());
    let others: Vec<MaterialIndex> = scattering.iter().map(|s| s.material).collect();
    let (groups, curved) = scene.plane_panes(&others);
    let is_wall = |m: MaterialIndex| others.contains(&m) || scene.material(m).kind != MaterialKind::Void;
    let solid: Vec<[DVec3; 3]> = scene.triangles.iter().filter(|t| is_wall(t.material)).map(|t| t.vertices).collect();
    let caster = if groups.is_empty() { None } else { Caster::new(solid) };
    let mut taken = HashSet::new();
    let too_many = format!("there are many windows, and this is not among the first {MOST}");
    for panes in groups {
        let material = scene.material(panes.material);
        let data = scattering.iter().find(|s| s.material == panes.material);
        let [front, back] = [1.0, -1.0].map(|side| open_share(caster.as_ref(), &panes, side));
        let (outside, inside) = (front.max(back), front.min(back));
        let why = if outside < OPEN {
            Some("both of its sides are indoors")
        } else if inside > CLOSED * outside {
            Some("the sky is open to both of its sides")
        } else if found.windows.len() >= MOST {
            Some(too_many.as_str())
        } else {
            None
        };
        let origin = panes.origin(scene);
        match (why, data) {
            (Some(why), Some(_)) => return Err(no_window(&origin, &material.name, panes.area(), why)),
            (Some(why), None) => {
                found.left.push(told(&origin, &material.name, panes.area(), why));
                continue;
            }
            (None, _) => {}
        }
        let name = unique_name(&material.name, &mut taken);
        if inside >= LEAK {
            warnings.push(told_leak(&origin, &name, inside));
        }
        // The back is outdoors: the front is the room's side.
        let along = back > front;
        let (filling, tensor_tree, parameters) = match data {
            None => (Filling::SceneGlass, None, String::new()),
            Some(data) => of_data(data, along, &origin, &mut warnings)?,
        };
        let window = panes.window(scene, &name, along, &parameters, &mut warnings)?;
        found.windows.push(WindowSection {
            group: name.clone(),
            group_place: place.clone(),
            name,
            surface: origin.file,
            filling,
            place: place.clone(),
            shade: None,
            tensor_tree,
            states: Vec::new(),
            daylight: None,
            parts: Parts::default(),
            parts_place: place.clone(),
            found: Some(window),
        });
    }
    for surface in curved {
        let nameless = SurfaceOrigin { name: "glass".into(), file: "scene".into(), line: 1 };
        let origin = scene.surfaces.get(surface as usize).unwrap_or(&nameless);
        let of = scene.triangles.iter().filter(|t| t.surface == surface);
        let area = of.clone().map(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]).length() / 2.0).sum();
        let first = of.clone().next().map(|t| t.material);
        let name = first.map_or("glass", |m| &scene.material(m).name);
        if first.is_some_and(|m| others.contains(&m)) {
            return Err(no_window(origin, name, area, "it is not plane"));
        }
        found.left.push(told(origin, name, area, "it is not plane"));
    }
    found.warnings = warnings.iter().cloned().collect();
    Ok(found)
}

/// What a window of scattering data is made of, and the parameters of its frame. Suns see through `aBSDF`.
fn of_data(
    data: &ScatteringData,
    along: bool,
    origin: &SurfaceOrigin,
    warnings: &mut Warnings,
) -> Result<(Filling, Option<SunData>, String)> {
    let read = bsdf::read(&data.file, &mut Warnings::new())?;
    let basis = basis_of(&read).map_err(|e| e.file(&data.file))?;
    let parameters = format!("h={basis} u={},{},{}", data.up.x, data.up.y, data.up.z);
    if along {
        return Ok((Filling::Bsdf(data.file.clone()), data.sees_through.then(|| SunData::of_file(data.file.clone())), parameters));
    }
    let lost = if data.sees_through { "; suns are spread over its bins" } else { "" };
    warnings.push(
        Error::new(format!(
            "'{}' of scattering data '{}' has its front outdoors: the data are turned around, as Radiance has it{lost}",
            origin.name, data.modifier
        ))
        .file(&origin.file)
        .line(origin.line)
        .help("data of WINDOW and genBSDF have their front indoors: reverse the order of the polygon's vertices, if that is meant"),
    );
    let file = std::path::absolute(&data.file).map_err(|e| Error::io(&data.file, &e))?;
    Ok((Filling::Layers(vec![format!("flip:{}", file.display())]), None, parameters))
}

fn no_window(origin: &SurfaceOrigin, modifier: &str, area: f64, why: &str) -> Error {
    Error::new(format!("'{}' of scattering data '{modifier}' ({area:.2} m²) is no window: {why}", origin.name))
        .file(&origin.file)
        .line(origin.line)
        .help("scattering data are known between indoors and the open sky only: replace it by its geometry or a `trans`, or name the windows by [[window]]")
}

fn told_leak(origin: &SurfaceOrigin, name: &str, share: f64) -> Error {
    let text = format!(
        "the room behind window '{name}' is open or leaks: {:.1} % of the rays from its inner side meet nothing; light comes in there, too",
        100.0 * share
    );
    Error::new(text)
        .file(&origin.file)
        .line(origin.line)
        .help("close the room if it is closed: lucarne scene info FILE names surfaces with open edges")
}

fn told(origin: &SurfaceOrigin, material: &str, area: f64, why: &str) -> String {
    format!("glass '{material}' of {area:.2} m² ({}, {}:{}) is no window: {why}", origin.name, origin.file.display(), origin.line)
}

/// Share of the rays from one side (1: the front) that meet nothing.
fn open_share(caster: Option<&Caster>, panes: &Panes, side: f64) -> f64 {
    let Some(caster) = caster else { return 1.0 };
    let (triangles, normal) = (panes.triangles(), panes.normal * side);
    let start = 1e-4 * panes.area().sqrt();
    let escapes = |ray: &usize| {
        let mut random = Random(*ray as u64);
        let origin = random.point_on(&triangles);
        caster.nearest(origin, random.cosine_direction(normal), start).is_none()
    };
    (0..RAYS).filter(escapes).count() as f64 / RAYS as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::trace::rooms::Builder;

    const GLASS: MaterialKind = MaterialKind::Glass { transmissivity: [0.7; 3], refraction_index: 1.52 };

    #[test]
    fn a_room_that_is_open_behind_its_window_is_told() {
        for (missing, leaks) in [(&[2][..], false), (&[2, 3][..], true)] {
            let mut b = Builder::default();
            let (wall, glass) = (b.grey(0.5), b.material(GLASS));
            b.room([0.0; 3], [4.0, 6.0, 3.0], wall, missing);
            b.quad([[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [4.0, 0.0, 0.0]], glass);
            let found = find(&b.scene, &[], &Place::default()).unwrap();
            let told: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
            assert_eq!((found.windows.len(), told.len()), (1, usize::from(leaks)), "{told:?}");
            assert!(told.iter().all(|t| t.contains("is open or leaks") && t.contains("% of the rays")), "{told:?}");
        }
    }

    #[test]
    fn panes_between_room_and_sky_are_windows_whichever_way_they_are_drawn() {
        for turned in [false, true] {
            let mut b = Builder::default();
            let (wall, glass) = (b.grey(0.5), b.material(GLASS));
            // A room with its south side (y = 0) of glass, in two panes, and a partition of glass in its middle.
            b.room([0.0; 3], [4.0, 6.0, 3.0], wall, &[2]);
            let mut pane = |low: f64, high: f64, y: f64| {
                let mut corners = [[low, y, 0.0], [low, y, 3.0], [high, y, 3.0], [high, y, 0.0]];
                if turned {
                    corners.reverse();
                }
                b.quad(corners, glass);
            };
            pane(0.0, 2.0, 0.0);
            pane(2.0, 4.0, 0.0);
            pane(0.0, 4.0, 3.0);
            // A balustrade outside.
            pane(0.0, 4.0, -3.0);
            let found = find(&b.scene, &[], &Place::default()).unwrap();
            assert_eq!(found.windows.len(), 1, "{:?}", found.left);
            let window = found.windows[0].found.as_ref().unwrap();
            assert!((window.area() - 12.0).abs() < 1e-9 && window.frame.z.abs_diff_eq(DVec3::Y, 1e-9), "{:?}", window.frame);
            assert_eq!((window.faces(), &found.windows[0].filling), ([180.0, 0.0], &Filling::SceneGlass));
            let left = found.left.join("; ");
            assert!(left.contains("both of its sides are indoors") && left.contains("the sky is open to both"), "{left}");
        }
    }
}

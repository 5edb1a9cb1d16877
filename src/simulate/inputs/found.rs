//! Windows of a project that names none: panes of the scene's glass between indoors and the open sky.
//!
//! Rays from both sides of a pane, spread as cosines, tell where it lies: glass counts as a wall to them, so that what
//! meets nothing is under the open sky on that side. Panes that are no windows stay in the scene as they are; light
//! passes them all the same, found by chance.

use super::parts::Division;
use super::shade::Shade;
use super::windows::ProjectWindow;
use crate::bins::{AngleBasis, KlemsBasis};
use crate::bvh::Caster;
use crate::error::{Result, Warnings};
use crate::random::Random;
use crate::scene::windows::found::Panes;
use crate::scene::{MaterialKind, Pane, Scene, SurfaceOrigin};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Rays from each side of a pane.
const RAYS: usize = 1024;
/// A side is under the open sky if this share of its rays meets nothing.
const OPEN: f64 = 0.02;
/// The room's side of a window has at most this part of the other side's share: rooms may have cracks.
const CLOSED: f64 = 0.25;
/// Windows that are taken; rays are aimed at each.
const MOST: usize = 256;

/// The windows, and why other glass is none, for people.
pub(super) struct Found {
    pub(super) windows: Vec<ProjectWindow>,
    pub(super) left: Vec<String>,
}

/// Finds the windows of a scene and takes their panes out of it.
///
/// # Errors
/// As for windows of a file.
pub(super) fn find(scene: &mut Scene, warnings: &mut Warnings) -> Result<Found> {
    let (groups, curved) = scene.plane_panes();
    let solid: Vec<[DVec3; 3]> =
        scene.triangles.iter().filter(|t| scene.material(t.material).kind != MaterialKind::Void).map(|t| t.vertices).collect();
    let caster = Caster::new(solid);
    let mut found = Found { windows: Vec::new(), left: Vec::new() };
    let mut named: BTreeMap<String, usize> = BTreeMap::new();
    let mut taken = BTreeSet::new();
    let too_many = format!("there are many windows, and this is not among the first {MOST}");
    for panes in groups {
        let material = scene.material(panes.material).clone();
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
        if let Some(why) = why {
            found.left.push(told(&panes.origin(scene), &material.name, panes.area(), why));
            continue;
        }
        let Some(pane) = Pane::of_material(&material.kind) else { continue };
        let number = named.entry(material.name.clone()).or_default();
        *number += 1;
        let name = if *number == 1 { material.name.clone() } else { format!("{}-{number}", material.name) };
        let window = panes.window(scene, &name, back > front, warnings)?;
        let basis = AngleBasis::from(KlemsBasis::Full);
        found.windows.push(ProjectWindow {
            name,
            transmission: super::filling::pane_transmission(&pane, &basis)?,
            made_of: format!("glass of the scene '{}', {}", material.name, super::filling::describe(&pane)),
            glass: Some(pane),
            shade: Some(Shade::of_pane(&window, &pane)),
            parts: vec![window.clone()],
            division: Division::default(),
            window,
            pane: None,
            states: Vec::new(),
            daylight: None,
        });
        taken.extend(panes.numbers);
    }
    for surface in curved {
        let nameless = SurfaceOrigin { name: "glass".into(), file: "scene".into(), line: 1 };
        let origin = scene.surfaces.get(surface as usize).unwrap_or(&nameless);
        let of = scene.triangles.iter().filter(|t| t.surface == surface);
        let area = of.clone().map(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]).length() / 2.0).sum();
        let name = of.clone().next().map_or("glass", |t| &scene.material(t.material).name);
        found.left.push(told(origin, name, area, "it is not plane"));
    }
    let mut number = 0;
    scene.triangles.retain(|_| {
        number += 1;
        !taken.contains(&(number - 1))
    });
    Ok(found)
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
            let mut scene = b.scene;
            let before = scene.triangles.len();
            let found = find(&mut scene, &mut Warnings::new()).unwrap();
            assert_eq!(found.windows.len(), 1, "{:?}", found.left);
            let window = &found.windows[0].window;
            assert!((window.area() - 12.0).abs() < 1e-9 && window.frame.z.abs_diff_eq(DVec3::Y, 1e-9), "{:?}", window.frame);
            assert_eq!((window.faces(), scene.triangles.len()), ([180.0, 0.0], before - 4));
            let left = found.left.join("; ");
            assert!(left.contains("both of its sides are indoors") && left.contains("the sky is open to both"), "{left}");
        }
    }
}

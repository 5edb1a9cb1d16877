//! Scenes against the tutorial room and live Radiance.

use super::{read_scene, read_windows};
use crate::scene::{MaterialKind, Scene};
use crate::{Result, Warnings, testing};
use glam::DVec3;
use std::path::{Path, PathBuf};

fn read(files: &[&str], base: &Path) -> Result<(Scene, Vec<String>)> {
    let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
    let mut warnings = Warnings::new();
    let scene = read_scene(&files, base, &mut warnings)?;
    Ok((scene, warnings.iter().map(ToString::to_string).collect()))
}

fn tutorial_room() -> Option<PathBuf> {
    testing::shared().map(|s| s.join("data/tutorial_room"))
}

fn area_of(scene: &Scene, material: &str) -> f64 {
    let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
    let of = |i: u32| scene.materials[i as usize].name == material;
    scene.triangles.iter().filter(|t| of(t.material.0)).map(|t| area(t.vertices)).sum()
}

#[test]
fn the_tutorial_room_is_read_with_its_seam_holes() {
    let Some(room) = tutorial_room() else { return };
    let (scene, warnings) = read(&["materials.rad", "room.rad"], &room).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["Ground", "ExteriorWalls", "Floor", "InteriorWall", "Ceiling"]);
    assert!(scene.materials.iter().all(|m| matches!(m.kind, MaterialKind::Plastic { .. })));
    // From the corners in the files: walls 6.452524 × 3.055937, the southern one with a hole of
    // 6.096 × 1.524; the roof whole; the bottom a frame around 6.096².
    let (wall, height, inside) = (6.452524, 3.055937, 6.096);
    let exterior = 4.0 * wall * height - inside * 1.524 + wall * wall + (wall * wall - inside * inside);
    let read = area_of(&scene, "ExteriorWalls");
    assert!((read / exterior - 1.0).abs() < 1e-9, "{read} {exterior}");
    assert!((area_of(&scene, "Floor") - inside * inside).abs() < 1e-9);
    assert!((area_of(&scene, "Ceiling") - inside * inside).abs() < 1e-9);
}

#[test]
fn the_tutorial_windows_face_into_the_room() {
    let Some(room) = tutorial_room() else { return };
    let mut warnings = Warnings::new();
    let windows = read_windows(Path::new("objects/GlazingVmtx.rad"), &room, &mut warnings).unwrap();
    assert_eq!(windows.len(), 1);
    let window = &windows[0];
    assert_eq!((window.name.as_str(), window.basis.len()), ("Glazing", 145));
    assert!((window.area() - 6.096 * (2.4384 - 0.904875)).abs() < 1e-9);
    assert!((window.frame.z - DVec3::Y).length() < 1e-12);
    assert!((window.frame.y - DVec3::Z).length() < 1e-12 && (window.frame.x + DVec3::X).length() < 1e-12);
    for file in ["objects/Glazing.rad", "objects/GlazingVmtxx.rad", "objects/GlazingVmtxBlack.rad", "objects/GlazingGlow.rad"] {
        read_windows(Path::new(file), &room, &mut warnings).unwrap();
    }
    assert!(warnings.is_empty());
}

#[test]
fn thousands_of_slats_and_black_rooms_are_read() {
    let Some(room) = tutorial_room() else { return };
    let (scene, warnings) = read(&["materials.rad", "blinds/blindsOnly.rad"], &room).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    let polygons = std::fs::read_to_string(room.join("blinds/blindsOnly.rad")).unwrap().matches("polygon").count();
    assert_eq!(scene.triangles.len(), 2 * polygons);
    let (scene, _) = read(&["materialBlack.rad", "roomBlack.rad"], &room).unwrap();
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials[0].name, "black");
    let error = read(&["materials.rad", "blinds/blindsWithProxy.rad"], &room).unwrap_err().to_string();
    assert!(error.contains("BSDF") && error.contains("blindsWithProxy.rad:1"), "{error}");
}

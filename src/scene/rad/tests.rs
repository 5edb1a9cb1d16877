//! Scenes written by the tests into a folder of their own.

use super::*;
use crate::bins::AngleBasis;
use glam::DVec3;

/// Reads `main.rad` of a folder with the given files.
fn read(files: &[(&str, &str)]) -> (Result<Scene>, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let mut warnings = Warnings::new();
    let scene = read_scene(&["main.rad".into()], folder.path(), &mut warnings);
    let texts = warnings.iter().map(|w| w.to_string().replace(&format!("{}/", folder.path().display()), "")).collect();
    (scene.map_err(|e| Error::new(e.to_string().replace(&format!("{}/", folder.path().display()), ""))), texts)
}

fn one(text: &str) -> Scene {
    let (scene, warnings) = read(&[("main.rad", text)]);
    assert_eq!(warnings, Vec::<String>::new());
    scene.unwrap()
}

fn fails(text: &str) -> String {
    read(&[("main.rad", text)]).0.expect_err("should be refused").message().to_string()
}

fn area_vector(scene: &Scene) -> DVec3 {
    scene.triangles.iter().map(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]) / 2.0).sum()
}

fn area(scene: &Scene) -> f64 {
    scene.triangles.iter().map(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]).length() / 2.0).sum()
}

const RED: &str = "void plastic red 0 0 5 .5 .2 .2 .1 .05\n";
const SQUARE: &str = "red polygon p 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0\n";

#[test]
fn a_polygon_keeps_its_corners_material_and_place() {
    let scene = one(&format!("# comment\n{RED}\n{SQUARE}"));
    assert_eq!(scene.triangles.len(), 2);
    assert_eq!(area_vector(&scene), DVec3::Z);
    assert_eq!(scene.surfaces[0].line, 4);
    assert_eq!(scene.surfaces[0].name, "p");
    assert_eq!(scene.materials[0].kind, MaterialKind::Plastic { color: [0.5, 0.2, 0.2], specularity: 0.1, roughness: 0.05 });
}

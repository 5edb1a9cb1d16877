use super::*;
use crate::scene::{self, MaterialKind, Pane};

/// Writes files and reads them as one scene.
fn read_files(files: &[(&str, &str)]) -> (Result<Scene>, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let scene: Vec<PathBuf> = files.iter().filter(|(n, _)| !n.ends_with("mtl")).map(|(n, _)| PathBuf::from(n)).collect();
    let mut warnings = Warnings::new();
    let read = scene::read_scene(&scene, folder.path(), &mut warnings);
    (read, warnings.iter().map(|w| w.to_string().replace(&format!("{}/", folder.path().display()), "")).collect())
}

const WALL: (&str, &str) = ("m.rad", "void plastic wall 0 0 5 .5 .4 .3 0 0\nvoid glass pane 0 0 3 .9 .9 .9\n");

fn areas(scene: &Scene) -> Vec<(String, f64)> {
    let mut found = vec![0.0; scene.surfaces.len()];
    for t in &scene.triangles {
        let [a, b, c] = t.vertices;
        found[t.surface as usize] += (b - a).cross(c - a).length() / 2.0;
    }
    scene.surfaces.iter().map(|s| s.name.clone()).zip(found.into_iter().map(|a: f64| (a * 1e9).round() / 1e9)).collect()
}

#[test]
fn polygons_have_their_area_and_the_materials_of_the_rad_files() {
    // An L, a square with a hole by a seam, a triangle by negative indices; CR LF, a continued line.
    let obj = "# a comment\r\nv 0 0 0\r\nv 2 0 0\r\nv 2 1 0\r\nv 1 1 0\r\nv 1 2 0\r\nv 0 2 0 1.0\r\nvt 0 0\r\nvn 0 0 1\r\n\
               g ell\r\nusemtl wall\r\nf 1/1/1 2/1/1 3//1 \\\r\n  4 5/1 6\r\n\
               v 0 0 1\r\nv 4 0 1\r\nv 4 4 1\r\nv 0 4 1\r\nv 1 1 1\r\nv 1 3 1\r\nv 3 3 1\r\nv 3 1 1\r\n\
               o holed plate\r\nusemtl pane\r\nf 7 8 9 10 7 11 12 13 14 11\r\n\
               g last\r\nusemtl wall\r\ns off\r\nf -8 -7 -6\r\n";
    let (scene, warnings) = read_files(&[WALL, ("room.obj", obj)]);
    let scene = scene.unwrap();
    assert_eq!(areas(&scene), [("ell".into(), 3.0), ("holed plate".into(), 12.0), ("last".into(), 8.0)]);
    assert!(warnings.is_empty(), "{warnings:?}");
    let kind =
        |surface: usize| scene.materials[scene.triangles.iter().find(|t| t.surface as usize == surface).unwrap().material.0 as usize].kind;
    assert_eq!(kind(0), MaterialKind::Plastic { color: [0.5, 0.4, 0.3], specularity: 0.0, roughness: 0.0 });
    assert_eq!(kind(1), MaterialKind::Glass { transmissivity: [0.9; 3], refraction_index: 1.52 });
    assert_eq!((scene.surfaces[0].line, scene.surfaces[2].line), (12, 28), "{:?}", scene.surfaces);
    // Fronts are where corners run counter-clockwise.
    assert!(scene.triangles.iter().all(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]).z > 0.0));
    // Files may stand in any order.
    let (other, _) = read_files(&[("room.obj", obj), WALL]);
    assert_eq!(areas(&other.unwrap()), areas(&scene));
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn materials_of_an_mtl_file_count_where_no_rad_file_has_them_and_it_is_said() {
    let mtl = "newmtl brick\nKa 1 1 1\nKd 0.6 0.3 0.2\nKs .5 .5 .5\nmap_Kd brick.png\nnewmtl clear\nKd 1 1 1\nd 0.4\nnewmtl wall\nKd 0 1 0\nnewmtl film\nTr 0.4\n";
    let faces = "usemtl brick\nf 1 2 3\nusemtl clear\nf 1 2 3\nusemtl wall\nf 1 2 3\nusemtl film\nf 1 2 3\n";
    let obj = format!("mtllib colours.mtl\n{TRIANGLE}{faces}");
    let (scene, warnings) = read_files(&[WALL, ("room.obj", &obj), ("colours.mtl", mtl)]);
    let scene = scene.unwrap();
    let kind = |name: &str| scene.materials.iter().find(|m| m.name == name).unwrap().kind;
    assert_eq!(kind("brick"), MaterialKind::Plastic { color: [0.6, 0.3, 0.2], specularity: 0.0, roughness: 0.0 });
    assert_eq!(kind("wall"), MaterialKind::Plastic { color: [0.5, 0.4, 0.3], specularity: 0.0, roughness: 0.0 });
    assert_eq!(kind("clear"), Pane::of_transmittance([0.6; 3]).unwrap().material());
    assert_eq!(kind("film"), Pane::of_transmittance([0.4; 3]).unwrap().material());
    assert!(warnings.len() == 1 && warnings[0].contains("brick, clear, film") && warnings[0].contains("room.obj"), "{warnings:?}");
    // All in the .rad file: the library is not even looked for.
    let obj = format!("mtllib gone.mtl\n{TRIANGLE}usemtl wall\nf 1 2 3\n");
    let (scene, warnings) = read_files(&[WALL, ("room.obj", &obj)]);
    assert!(scene.is_ok() && warnings.len() == 1 && warnings[0].contains("gone.mtl' is not read"), "{warnings:?}");
    // Groups that are called as a modifier need no `usemtl`.
    let (scene, _) = read_files(&[WALL, ("room.obj", &format!("{TRIANGLE}g wall\nf 1 2 3\n"))]);
    assert_eq!(scene.unwrap().materials[0].name, "wall");
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    for (text, line, words) in [
        ("usemtl brick\nf 1 2 3\n", 5, "'brick' is in none of the scene's .rad files, and the file names no mtllib"),
        ("mtllib gone.mtl\nusemtl brick\nf 1 2 3\n", 6, "neither in the scene's .rad files nor in '"),
        ("f 1 2 3\n", 4, "the faces of 'default' have no material"),
        ("usemtl wall\nf 1 2 4\n", 5, "corner '4', but 3 corners"),
        ("usemtl wall\nf 0 1 2\n", 5, "corner '0'"),
        ("usemtl wall\nf -4 1 2\n", 5, "corner '-4'"),
        ("usemtl wall\nf 1 2\n", 5, "a face has 2 corners"),
        ("usemtl wall\nf 1 2 x\n", 5, "corner 'x'"),
        ("v 1 2\n", 4, "fewer than three coordinates"),
        ("v 1,5 2 3\n", 4, "write a point in place of the comma"),
        ("v 1 nan 3\n", 4, "'nan' is no number"),
        ("{\"a\": 1}\n", 4, "begins no line of an OBJ file"),
        ("call other.obj\n", 4, "is not done"),
        ("g nothing\n", 0, "there is no face"),
    ] {
        let (scene, _) = read_files(&[WALL, ("room.obj", &format!("{TRIANGLE}{text}"))]);
        let message = scene.map(|_| ()).unwrap_err().to_string();
        assert!(message.contains(words) && message.contains("help:"), "{text}: {message}");
        assert!(line == 0 || message.contains(&format!("room.obj:{line}:")), "{text}: {message}");
    }
}

#[test]
fn what_is_left_out_or_pressed_flat_is_told_once() {
    let more = "v 1 1 0.5\nusemtl wall\nf 1 2 4 3\nf 1 2 2\nf 1 1 3\nl 1 2\np 1\ncurv 0 1 1 2\nf 1 2 3\n";
    let (scene, warnings) = read_files(&[WALL, ("room.obj", &format!("{TRIANGLE}{more}"))]);
    assert_eq!(scene.unwrap().surfaces.len(), 1);
    let has = |words: &str| warnings.iter().filter(|w| w.contains(words)).count() == 1;
    assert!(
        has("2 faces without area") && has("'l' and what else is no polygon") && has("outside the plane of their face"),
        "{warnings:?}"
    );
    assert_eq!(warnings.len(), 3, "{warnings:?}");
}

#[test]
fn a_part_of_a_file_can_be_a_window() {
    let folder = tempfile::tempdir().unwrap();
    let obj = "v 0 0 0\nv 0 0 1\nv 2 0 1\nv 2 0 0\ng south\nusemtl pane\nf 1 2 3 4\ng floor\nusemtl wall\nf 1 4 3\n";
    std::fs::write(folder.path().join("room.obj"), obj).unwrap();
    let read = |name: &str| scene::read_windows(Path::new(name), folder.path(), &mut Warnings::new());
    for name in ["room.obj#south", "room.obj#pane"] {
        let windows = read(name).unwrap();
        assert!(windows.len() == 1 && (windows[0].area() - 2.0).abs() < 1e-12 && windows[0].frame.z == DVec3::Y, "{name}");
    }
    let message = read("room.obj#north").unwrap_err().to_string();
    assert!(message.contains("'north'") && message.contains("pane, south, wall, floor"), "{message}");
    assert_eq!(read("room.obj").unwrap().len(), 2);
}

use crate::error::Warnings;
use crate::scene::{Scene, Window, rad};
use glam::{DMat3, DVec3};

/// A scene and its windows from texts, each polygon as `name x y z  x y z …`, placed by a function of
/// its corners; windows by the name of their modifier. Files are `scene.rad` and `windows.rad`.
fn placed(scene: &[&str], windows: &[&str], place: &dyn Fn(DVec3) -> DVec3) -> (Result<Scene, String>, Vec<Window>, Vec<String>) {
    let polygon = |line: &&str| {
        let mut words = line.split_whitespace();
        let (modifier, name) = words.next().unwrap().split_once(':').unwrap();
        let numbers: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
        let corners: Vec<String> =
            numbers.chunks(3).map(|p| place(DVec3::from_slice(p))).map(|p| format!("{:.9} {:.9} {:.9}", p.x, p.y, p.z)).collect();
        format!("{modifier} polygon {name} 0 0 {} {}\n", numbers.len(), corners.join(" "))
    };
    let folder = tempfile::tempdir().unwrap();
    let materials = "void plastic wall 0 0 5 .5 .5 .5 0 0\nvoid glass pane 0 0 3 .9 .9 .9\n";
    let write = |name: &str, head: &str, lines: &[&str]| {
        std::fs::write(folder.path().join(name), format!("{head}{}", lines.iter().map(polygon).collect::<String>())).unwrap();
    };
    write("scene.rad", materials, scene);
    write("windows.rad", "", windows);
    let mut warnings = Warnings::new();
    let mut read = rad::read_scene(&["scene.rad".into()], folder.path(), &mut warnings).unwrap();
    let windows = rad::read_windows("windows.rad".as_ref(), folder.path(), &mut warnings).unwrap();
    let told = read.set_windows(&windows, &mut warnings);
    let relative = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    let warnings = warnings.iter().map(|w| relative(w.to_string())).collect();
    (told.map(|()| read).map_err(|e| relative(e.to_string())), windows, warnings)
}

fn read(scene: &[&str], windows: &[&str]) -> (Scene, Vec<Window>, Vec<String>) {
    let (scene, windows, warnings) = placed(scene, windows, &|p| p);
    (scene.unwrap(), windows, warnings)
}

fn area(scene: &Scene, name: &str) -> f64 {
    let of = |t: &&crate::scene::Triangle| scene.surfaces[t.surface as usize].name == name;
    scene.triangles.iter().filter(of).map(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]).length() / 2.0).sum()
}

/// Window 3 m × 1.5 m in the plane y = 0, room at +y.
const WINDOW: &str = "glazing:win .5 0 1  .5 0 2.5  3.5 0 2.5  3.5 0 1";

#[test]
fn what_covers_a_window_in_its_plane_is_cut_out_and_named() {
    let wall = "wall:full 0 0 0  0 0 3  4 0 3  4 0 0";
    let turn = DMat3::from_rotation_x(0.6) * DMat3::from_rotation_z(1.1);
    let survey = DVec3::new(583_960.4, 4_507_523.7, 31.6);
    let places: [(&str, Box<dyn Fn(DVec3) -> DVec3>); 4] = [
        ("upright", Box::new(|p| p)),
        ("tilted", Box::new(move |p| turn * p)),
        ("in survey coordinates", Box::new(move |p| turn * p + survey)),
        ("in millimetres", Box::new(move |p| turn * p * 1000.0)),
    ];
    for (what, place) in &places {
        let scale = if what.contains("milli") { 1e6 } else { 1.0 };
        for lines in [wall, "wall:full 4 0 0  4 0 3  0 0 3  0 0 0"] {
            let (scene, _, warnings) = placed(&[lines, "wall:floor 0 0 0  4 0 0  4 6 0  0 6 0"], &[WINDOW], place);
            let scene = scene.unwrap();
            assert!((area(&scene, "full") / scale - 7.5).abs() < 1e-6, "{what}: {}", area(&scene, "full"));
            assert!((area(&scene, "floor") / scale - 24.0).abs() < 1e-6, "{what}");
            assert_eq!(warnings.len(), 1, "{what}: {warnings:?}");
            let text = &warnings[0];
            assert!(
                text.starts_with(
                    "scene.rad:3: surface 'full': it covers all of window 'glazing' (windows.rad:1) in its plane; light passes"
                ),
                "{text}"
            );
        }
    }
    // A pane, and a frame that covers 15 cm at one side: 5 %.
    let (scene, _, warnings) =
        read(&["pane:glass .5 0 1  .5 0 2.5  3.5 0 2.5  3.5 0 1", "wall:frame .4 0 .9  .65 0 .9  .65 0 2.6  .4 0 2.6"], &[WINDOW]);
    assert!(area(&scene, "glass") < 1e-9 && (area(&scene, "frame") - (0.25 * 1.7 - 0.15 * 1.5)).abs() < 1e-9);
    assert!(
        warnings[0].contains("'glass'")
            && warnings[1].contains("'frame': it covers a part of")
            && warnings[1].contains("help: it covers 5.0 %;"),
        "{warnings:?}"
    );
    // Rounded to a tenth of a millimetre it is in the plane all the same.
    let (scene, _, warnings) = read(&["wall:full 0 -.0001 0  0 .0001 3  4 0 3  4 0 0"], &[WINDOW]);
    assert!((area(&scene, "full") - 7.5).abs() < 1e-6 && warnings.len() == 1, "{warnings:?}");
    // One warning for a wall that covers two windows.
    let two = ["a:w1 .5 0 1  .5 0 2  1.5 0 2  1.5 0 1", "b:w2 2 0 1  2 0 2  3 0 2  3 0 1"];
    let (scene, _, warnings) = read(&[wall], &two);
    assert!((area(&scene, "full") - 10.0).abs() < 1e-9 && warnings.len() == 1, "{warnings:?}");
    assert!(warnings[0].contains("window 'a' (windows.rad:1)") && warnings[0].contains("window 'b' (windows.rad:2)"), "{warnings:?}");
}

#[test]
fn what_stands_close_before_or_behind_a_window_stays_and_is_named() {
    for (y, side) in [("-.001", "outside"), (".001", "inside")] {
        let wall = format!("wall:full 0 {y} 0  0 {y} 3  4 {y} 3  4 {y} 0");
        let (scene, _, warnings) = read(&[&wall], &[WINDOW]);
        assert!((area(&scene, "full") - 12.0).abs() < 1e-9, "it really stands there");
        assert_eq!(warnings.len(), 1);
        let wanted = format!(
            "scene.rad:3: surface 'full': it covers all of window 'glazing' (windows.rad:1) from 0.0010 {side} its plane: no light"
        );
        assert!(warnings[0].starts_with(&wanted), "{warnings:?}");
        let frame = format!("wall:frame .4 {y} .9  .65 {y} .9  .65 {y} 2.6  .4 {y} 2.6");
        assert!(read(&[&frame], &[WINDOW]).2[0].contains("help: it covers 5.0 %;"));
        let pane = format!("pane:glass .5 {y} 1  .5 {y} 2.5  3.5 {y} 2.5  3.5 {y} 1");
        assert!(read(&[&pane], &[WINDOW]).2[0].contains("counts beside that of the window's glazing"));
    }
    // The window in the middle of a thick wall that was not cut.
    let (_, _, warnings) = read(&["wall:face 0 -.25 0  0 -.25 3  4 -.25 3  4 -.25 0"], &[WINDOW]);
    assert!(warnings[0].contains("covers all of") && warnings[0].contains("0.2500 outside"), "{warnings:?}");
    // A wall with its opening, reveals, a sill, an overhang, a frame 5 cm outside and a house across the street.
    let usual = [
        "wall:wall 0 0 0  4 0 0  4 0 3  0 0 3  0 0 0  .5 0 1  .5 0 2.5  3.5 0 2.5  3.5 0 1  .5 0 1",
        "wall:reveal .5 -.3 1  .5 0 1  .5 0 2.5  .5 -.3 2.5",
        "wall:sill .5 -.3 1  3.5 -.3 1  3.5 .1 1  .5 .1 1",
        "wall:slat .5 -.01 1.2  3.5 -.01 1.2  3.5 .02 1.2  .5 .02 1.2",
        "wall:frame .5 -.05 1  .6 -.05 1  .6 -.05 2.5  .5 -.05 2.5",
        "wall:house -9 -20 0  9 -20 0  9 -20 9  -9 -20 9",
    ];
    let (scene, _, warnings) = read(&usual, &[WINDOW]);
    assert_eq!((scene.windows.len(), warnings), (1, Vec::new()));
    assert!((area(&scene, "wall") - 7.5).abs() < 1e-9 && (area(&scene, "slat") - 0.09).abs() < 1e-9);
}

fn window_area(windows: &[&str]) -> (f64, Vec<String>) {
    let (_, windows, warnings) = read(&["wall:floor 0 0 0  4 0 0  4 6 0  0 6 0"], windows);
    (windows.iter().map(Window::area).sum(), warnings)
}

#[test]
fn a_place_that_surfaces_of_a_window_share_counts_once() {
    let (area, warnings) = window_area(&[WINDOW, "glazing:copy .5 0 1  .5 0 2.5  3.5 0 2.5  3.5 0 1"]);
    assert!((area - 4.5).abs() < 1e-9 && warnings.len() == 1, "{area} {warnings:?}");
    assert!(
        warnings[0]
            .starts_with("windows.rad:2: window 'glazing': all of surface 'copy' lies in the same place as surface 'win' (windows.rad:1)")
    );
    // Half of it, begun at another corner.
    let (area, warnings) = window_area(&[WINDOW, "glazing:half 5 0 2.5  5 0 1  2 0 1  2 0 2.5"]);
    assert!(
        (area - 6.75).abs() < 1e-9 && warnings[0].contains("a part of surface 'half'") && warnings[0].contains("help: it is 50 %;"),
        "{area} {warnings:?}"
    );
    // Neighbours share an edge.
    let (area, warnings) = window_area(&[WINDOW, "glazing:next 3.5 0 1  3.5 0 2.5  5 0 2.5  5 0 1"]);
    assert!((area - 6.75).abs() < 1e-9 && warnings.is_empty(), "{area} {warnings:?}");
}

#[test]
fn of_two_panes_behind_each_other_the_inner_one_counts() {
    let outer = "glazing:outer .5 -.006 1  .5 -.006 2.5  3.5 -.006 2.5  3.5 -.006 1";
    for windows in [[WINDOW, outer], [outer, WINDOW]] {
        let (_, found, warnings) = read(&["wall:floor 0 0 0  4 0 0  4 6 0  0 6 0"], &windows);
        assert!((found[0].area() - 4.5).abs() < 1e-9 && found[0].triangles.iter().flatten().all(|p| p.y == 0.0), "{found:?}");
        assert!(
            warnings.len() == 1 && warnings[0].contains("all of surface 'outer' lies 0.006 behind surface 'win' (windows.rad:"),
            "{warnings:?}"
        );
    }
    // What the inner one does not hide is a window still.
    let higher = "glazing:outer .5 -.006 1  .5 -.006 3  3.5 -.006 3  3.5 -.006 1";
    let (area, warnings) = window_area(&[WINDOW, higher]);
    assert!((area - 6.0).abs() < 1e-9 && warnings[0].contains("help: it is 75 %;"), "{area} {warnings:?}");
    // Roof lights of a saw-tooth roof stand behind each other, and all count.
    let (area, warnings) = window_area(&[WINDOW, "glazing:second .5 -2 1  .5 -2 2.5  3.5 -2 2.5  3.5 -2 1"]);
    assert!((area - 9.0).abs() < 1e-9 && warnings.is_empty(), "{area} {warnings:?}");
}

#[test]
fn two_windows_in_one_place_are_refused() {
    let error = |second: &str| placed(&[], &[WINDOW, second], &|p| p).0.map(|_| ()).unwrap_err();
    for (what, second) in [
        ("copy", "other:two .5 0 1  .5 0 2.5  3.5 0 2.5  3.5 0 1"),
        ("from the other side", "other:two 3.5 0 1  3.5 0 2.5  .5 0 2.5  .5 0 1"),
        ("in part", "other:two 3 0 1  3 0 2.5  5 0 2.5  5 0 1"),
        ("6 mm outside", "other:two .5 -.006 1  .5 -.006 2.5  3.5 -.006 2.5  3.5 -.006 1"),
        ("6 mm inside", "other:two .5 .006 1  .5 .006 2.5  3.5 .006 2.5  3.5 .006 1"),
    ] {
        let text = error(second);
        assert!(text.starts_with("windows.rad:2: window 'other': ") && text.contains("window 'glazing' (windows.rad:1)"), "{what}: {text}");
    }
    // Neighbours that overlap by the rounding of a millimetre, a window round the corner, one across the room.
    for second in [
        "other:two 3.499 0 1  3.499 0 2.5  5 0 2.5  5 0 1",
        "other:two 4 0 1  4 0 2  4 4 2  4 4 1",
        "other:two 3.5 6 1  3.5 6 2.5  .5 6 2.5  .5 6 1",
    ] {
        let (_, windows, warnings) = read(&[], &[WINDOW, second]);
        assert_eq!((windows.len(), warnings.len()), (2, 0), "{second}: {warnings:?}");
    }
}

#[test]
fn a_wall_of_thousands_of_openings_counts_each_once() {
    let square = |x: f64, z: f64| format!("glazing:s {x} 0 {z}  {x} 0 {}  {} 0 {}  {} 0 {z}", z + 0.8, x + 0.8, z + 0.8, x + 0.8);
    let grid: Vec<(f64, f64)> = (0..60).flat_map(|i| (0..60).map(move |k| (f64::from(i), f64::from(k)))).collect();
    // Some again, some shifted by half of their width.
    let again = grid.iter().step_by(100).copied();
    let shifted = grid.iter().skip(1800).step_by(500).map(|(x, z)| (x + 0.4, *z));
    let lines: Vec<String> = grid.iter().copied().chain(again).chain(shifted).map(|(x, z)| square(x, z)).collect();
    let (_, windows, warnings) = read(&[], &lines.iter().map(String::as_str).collect::<Vec<_>>());
    // A shifted one adds the gap of 0.2 m between two openings.
    let (count, added) = (3600.0 * 0.64, 4.0 * 0.2 * 0.8);
    assert!((windows[0].area() - count - added).abs() < 1e-6, "{}", windows[0].area());
    // Of each kind of warning the first are kept.
    assert!(warnings.len() >= 20 && warnings.iter().any(|w| w.contains("lies in the same place")), "{}", warnings.len());
}

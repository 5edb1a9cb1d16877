//! Scenes written by the tests into a folder of their own.

use super::*;
use glam::DVec3;

/// Reads `main.rad` of a folder with the given files; paths in messages start at the folder.
fn read(files: &[(&str, &str)]) -> (std::result::Result<Scene, String>, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let mut warnings = Warnings::new();
    let scene = read_scene(&["main.rad".into()], folder.path(), &mut warnings);
    let relative = |e: &Error| e.to_string().replace(&format!("{}/", folder.path().display()), "");
    (scene.map_err(|e| relative(&e)), warnings.iter().map(relative).collect())
}

fn one(text: &str) -> Scene {
    let (scene, warnings) = read(&[("main.rad", text)]);
    assert_eq!(warnings, Vec::<String>::new());
    scene.unwrap()
}

fn warned(text: &str) -> (Scene, String) {
    let (scene, warnings) = read(&[("main.rad", text)]);
    (scene.unwrap(), warnings.join("\n"))
}

fn fails(text: &str) -> String {
    read(&[("main.rad", text)]).0.expect_err(text)
}

fn area_vector(scene: &Scene) -> DVec3 {
    scene.triangles.iter().map(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]) / 2.0).sum()
}

/// Volume enclosed, negative if the fronts look inward.
fn volume(scene: &Scene) -> f64 {
    scene.triangles.iter().map(|t| t.vertices[0].cross(t.vertices[1]).dot(t.vertices[2]) / 6.0).sum()
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

#[test]
fn all_materials_are_understood() {
    let text = "void plastic a 0 0 5 .1 .2 .3 .01 .1\nvoid metal b 0 0 5 .1 .2 .3 .9 .1\nvoid trans c 0 0 7 .1 .2 .3 .01 .1 .4 .5\n\
        void glass d 0 0 3 .8 .9 .7\nvoid glass e 0 0 4 .8 .9 .7 1.4\nvoid mirror f 0 0 3 .8 .9 .7\nvoid light g 0 0 3 8 9 7\n\
        void glow h 0 0 4 8 9 7 -1\nvoid alias i a\nvoid mirror j 1 b 0 3 1 1 1\n";
    let polygons: String = "abcdefghij".chars().map(|m| format!("{m} {}", SQUARE.strip_prefix("red ").unwrap())).collect();
    let scene = one(&format!("{text}{polygons}void polygon none 0 0 9 0 0 0 1 0 0 1 1 0\n"));
    let kinds: Vec<MaterialKind> = scene.materials.iter().map(|m| m.kind).collect();
    let color = [0.1, 0.2, 0.3];
    let plastic = MaterialKind::Plastic { color, specularity: 0.01, roughness: 0.1 };
    let metal = MaterialKind::Metal { color, specularity: 0.9, roughness: 0.1 };
    let trans = MaterialKind::Trans { color, specularity: 0.01, roughness: 0.1, transmissivity: 0.4, transmitted_specularity: 0.5 };
    let glass = |refraction_index| MaterialKind::Glass { transmissivity: [0.8, 0.9, 0.7], refraction_index };
    let mirror = MaterialKind::Mirror { color: [0.8, 0.9, 0.7] };
    let light = MaterialKind::Light { radiance: [8.0, 9.0, 7.0] };
    let glow = MaterialKind::Glow { radiance: [8.0, 9.0, 7.0], max_radius: -1.0 };
    assert_eq!(kinds, [plastic, metal, trans, glass(1.52), glass(1.4), mirror, light, glow, plastic, metal, MaterialKind::Void]);
    assert_eq!(scene.materials[8].name, "i");
}

#[test]
fn a_name_means_its_latest_definition_before_the_place_of_use() {
    let scene =
        one(&format!("{RED}{SQUARE}void glow red 0 0 4 1 1 1 0\nvoid alias two red\n{RED}two ring r 0 0 8 0 0 0 0 0 1 0 1\n{SQUARE}"));
    let kinds: Vec<bool> = scene.materials.iter().map(|m| matches!(m.kind, MaterialKind::Glow { .. })).collect();
    assert_eq!(kinds, [false, true, false]);
}

#[test]
fn curved_surfaces_turn_the_right_way_and_have_the_right_size() {
    use std::f64::consts::PI;
    let of = |shape: &str| one(&format!("{RED}red {shape}\n"));
    // The inscribed sphere loses about 3/2 · (π/72)²·… of its volume; 0.4 % bounds it.
    let sphere = volume(&of("sphere s 0 0 4 1 2 3 2")) / (PI * 32.0 / 3.0);
    assert!(sphere < 1.0 && sphere > 0.996, "{sphere}");
    let bubble = volume(&of("bubble s 0 0 4 1 2 3 2")) / (PI * 32.0 / 3.0);
    assert!((bubble + sphere).abs() < 1e-12);
    // A polygon of 144 corners has sin(2π/144)/(2π/144) of its circle's area.
    let polygon = (2.0 * PI / 144.0).sin() * 72.0;
    let ring = of("ring r 0 0 8 1 2 3 0 -2 0 .5 2");
    assert!((area_vector(&ring) + DVec3::Y * polygon * 3.75).length() < 1e-12);
    let closed =
        |mantle: &str| of(&format!("{mantle} 0 0 7 0 0 0 0 0 2 .5\nred ring a 0 0 8 0 0 2 0 0 1 0 .5\nred ring b 0 0 8 0 0 0 0 0 -1 0 .5"));
    assert!((volume(&closed("cylinder c")) - 2.0 * 0.25 * polygon).abs() < 1e-12);
    assert!(volume(&closed("tube c")) < 0.0);
    let cone = of("cone k 0 0 8 0 0 0 0 0 3 1 0\nred ring b 0 0 8 0 0 0 0 0 -1 0 1");
    assert!((volume(&cone) - polygon).abs() < 1e-12);
}

#[test]
fn a_cylinder_and_the_rings_that_close_it_share_their_corners() {
    // In an oblique place, rotated and scaled, so that nothing is exact by chance.
    let can = "red cylinder c 0 0 7 .1 .2 .3 1.3 -.7 .9 .37\nred ring a 0 0 8 .1 .2 .3 -1.2 .9 -.6 0 .37\nred ring b 0 0 8 1.3 -.7 .9 1.2 -.9 .6 .37 0\n";
    let (scene, _) = read(&[("main.rad", &format!("{RED}!xform -rx 13 -rz 77 -s 1.7 -t 3 4 5 can.rad\n")), ("can.rad", can)]);
    let scene = scene.unwrap();
    let corners =
        |surface: u32| -> Vec<DVec3> { scene.triangles.iter().filter(|t| t.surface == surface).flat_map(|t| t.vertices).collect() };
    let mantle = corners(0);
    for ring in [1, 2] {
        let centre = corners(ring)[0];
        for p in corners(ring) {
            let rim = (p - centre).length() > 0.1;
            assert!(!rim || mantle.iter().any(|q| (p - q).length() < 1e-12), "{p}");
        }
    }
}

#[test]
fn every_edge_of_a_box_and_a_sphere_has_a_neighbour() {
    for shape in
        ["!genbox red b 1 2 3\n", "!genbox red b 1 2 3 -i -b .1\n", "!genbox red b 1 2 3 -i -r .2\n", "red sphere s 0 0 4 .3 .1 .2 .7\n"]
    {
        let scene = one(&format!("{RED}{shape}"));
        let mut edges: Vec<[[u64; 3]; 2]> = Vec::new();
        let key = |p: DVec3| p.to_array().map(|c| (c * 1e9).round() as i64 as u64);
        for t in &scene.triangles {
            let v = t.vertices.map(key);
            edges.extend([[v[0], v[1]], [v[1], v[2]], [v[2], v[0]]]);
        }
        for e in &edges {
            assert_eq!(edges.iter().filter(|o| o[0] == e[1] && o[1] == e[0]).count(), 1, "{shape}");
        }
    }
}

#[test]
fn files_are_found_in_the_working_folder_and_beside_the_file_that_names_them() {
    let glow = |level: u32| format!("void glow g 0 0 4 {level} 1 1 0\ng ring r 0 0 8 0 0 0 0 0 1 0 1\n");
    let level = |files: &[(&str, &str)], main: &str| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("sub")).unwrap();
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let scene = read_scene(&[main.into()], folder.path(), &mut Warnings::new());
        scene.map_err(|e| e.to_string().replace(&format!("{}/", folder.path().display()), "")).map(|s| match s.materials[0].kind {
            MaterialKind::Glow { radiance, .. } => radiance[0],
            _ => f64::NAN,
        })
    };
    let (here, beside) = (glow(1), glow(2));
    let (list, main) = ("!xform lamp.rad\n", "!xform sub/list.rad\n");
    let both = [("main.rad", main), ("sub/list.rad", list), ("sub/lamp.rad", &beside), ("lamp.rad", &here)];
    assert_eq!(level(&both, "sub/list.rad"), Ok(1.0), "a file of the scene itself");
    assert_eq!(level(&both, "main.rad"), Ok(2.0), "a file placed by xform");
    assert_eq!(level(&both[..3], "sub/list.rad"), Ok(2.0));
    assert_eq!(level(&[both[0], both[1], both[3]], "main.rad"), Ok(1.0));
    let missing = level(&both[..2], "main.rad").unwrap_err();
    assert!(missing.starts_with("sub/list.rad:1: the file 'lamp.rad' exists neither as sub/lamp.rad nor as lamp.rad"), "{missing}");
}

#[test]
fn nothing_is_executed() {
    let marker = std::env::temp_dir().join(format!("lucarne-executed-{}", std::process::id()));
    for command in [
        format!("!touch {}", marker.display()),
        format!("!genbox red b 1 1 1 ; touch {}", marker.display()),
        format!("!genbox red b 1 1 1 | touch {}", marker.display()),
        format!("!genbox red b 1 1 1 > {}", marker.display()),
        format!("!xform `touch {}`", marker.display()),
        format!("!xform \"$(touch {})\"", marker.display()),
        format!("!xform '!touch {}'", marker.display()),
        format!("! cat x.rad && touch {}", marker.display()),
        "!/usr/bin/xform x.rad".to_string(),
        "!gensdaymtx 6 21 12".to_string(),
        "!gensky 6 21 12 > sky.rad".to_string(),
    ] {
        let error = fails(&format!("{RED}\n{command}\n"));
        assert!(error.starts_with("main.rad:3: ") && error.contains("help: "), "{error}");
        assert!(!marker.exists(), "{command}");
    }
    assert!(fails("!obj2rad 6 21 12\n").contains("obj2rad' is not run"));
}

#[test]
fn circles_of_files_and_bombs_end() {
    let (circle, _) = read(&[("main.rad", "!xform a.rad\n"), ("a.rad", "# \n!xform b.rad\n"), ("b.rad", "!xform ./a.rad\n")]);
    let circle = circle.unwrap_err();
    assert!(circle.starts_with("b.rad:1: ") && circle.contains("includes itself (by way of a.rad → b.rad)"), "{circle}");
    let chain: Vec<(String, String)> = (0..70).map(|i| (format!("f{i}.rad"), format!("!xform f{}.rad\n", i + 1))).collect();
    let mut files: Vec<(&str, &str)> = chain.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    files.push(("main.rad", "!xform f0.rad\n"));
    assert!(read(&files).0.unwrap_err().contains("64 deep"));
    assert!(
        fails(&format!("{RED}!genbox red b 1 1 1 | xform -a 1000 -t 1 0 0 -a 1000 -t 0 1 0 -a 1000 -t 0 0 1\n")).contains("repetitions")
    );
    assert!(fails(&format!("{RED}!genblinds red b 1 1 1 1e12 0\n")).contains("nslats"));
    assert!(fails("void plastic m 0 0 99999999999 1 1\n").contains("ends where real argument 3"));
    assert!(fails("void plastic m 99999999999999999999999 0 0\n").contains("not a whole number"));
}

#[test]
fn materials_of_other_kinds_are_refused_only_where_they_are_used() {
    for kind in ["BSDF", "aBSDF", "mixdata", "plasfunc", "prism1", "mist", "transdata"] {
        let definition = format!("void {kind} other 0 0 0\n");
        one(&format!("{definition}{RED}{SQUARE}"));
        let error = fails(&format!("{definition}other {}", SQUARE.strip_prefix("red ").unwrap()));
        assert!(
            error.starts_with(&format!("main.rad:1: {kind} 'other': the material type `{kind}` is not supported\n  help: ")),
            "{error}"
        );
    }
    assert!(fails("void instance i 1 a.oct 0 0\n").contains("the surface type `instance` is not supported"));
    assert!(fails(&format!("{RED}red glow two 0 0 4 1 1 1 0\ntwo {}", SQUARE.strip_prefix("red ").unwrap())).contains("modify each other"));
}

#[test]
fn values_out_of_range_are_held_or_refused() {
    let square = SQUARE.strip_prefix("red ").unwrap();
    let (scene, warnings) = warned(&format!("void plastic m 0 0 5 1.5 .2 .2 0 0\nm {square}"));
    assert_eq!(scene.materials[0].kind, MaterialKind::Plastic { color: [1.0, 0.2, 0.2], specularity: 0.0, roughness: 0.0 });
    assert!(warnings.starts_with("main.rad:1: plastic 'm': a reflectance is 1.5, more than 1; 1 is used"), "{warnings}");
    // As measured spectra outside the gamut of RGB give them.
    let (scene, warnings) = warned(&format!("void plastic m 0 0 5 -0.0013 .2 .2 0 0\nm {square}"));
    assert_eq!(scene.materials[0].kind, MaterialKind::Plastic { color: [0.0, 0.2, 0.2], specularity: 0.0, roughness: 0.0 });
    assert!(warnings.starts_with("main.rad:1: plastic 'm': a reflectance is -0.0013, less than 0; 0 is used"), "{warnings}");
    for (material, kind) in [
        ("metal m 0 0 5 .2 -1 .2 0 0", MaterialKind::Metal { color: [0.2, 0.0, 0.2], specularity: 0.0, roughness: 0.0 }),
        ("mirror m 0 0 3 .2 .2 -.1", MaterialKind::Mirror { color: [0.2, 0.2, 0.0] }),
        ("glass m 0 0 3 .2 .2 -.1", MaterialKind::Glass { transmissivity: [0.2, 0.2, 0.0], refraction_index: 1.52 }),
        ("light m 0 0 3 20 2 -.1", MaterialKind::Light { radiance: [20.0, 2.0, 0.0] }),
        ("glow m 0 0 4 20 2 -.1 -1", MaterialKind::Glow { radiance: [20.0, 2.0, 0.0], max_radius: -1.0 }),
    ] {
        let (scene, warnings) = warned(&format!("void {material}\nm {square}"));
        assert!(scene.materials[0].kind == kind && warnings.contains("less than 0; 0 is used"), "{material}: {warnings}");
    }
    for argument in ["plastic m 0 0 5 .2 .2 .2 -.1 0", "plastic m 0 0 5 .2 .2 .2 0 -.1", "trans m 0 0 7 .2 .2 .2 0 0 -.1 1"] {
        assert!(fails(&format!("void {argument}\nm {square}")).contains("the argument -0.1 is negative"), "{argument}");
    }
    assert!(fails(&format!("void glass m 0 0 4 .9 .9 .9 .5\nm {square}")).contains("refraction index"));
    assert!(fails("void plastic m 0 0 4 .5 .5 .5 0\n").contains("4 real arguments, but 5 are needed"));
    assert!(fails("void glow sun 0 0 4 1 1 1 0\nsun source s 0 0 4 0 0 0 1\n").contains("direction of the source is zero"));
    let (scene, warnings) = warned(&format!("{RED}red source s 0 0 4 0 0 1 1\n"));
    assert!(scene.sources.is_empty() && warnings.contains("its modifier 'red' gives no light"));
}

#[test]
fn faults_in_the_text_are_named_with_their_place() {
    let cases = [
        ("red", "main.rad:1: the file ends where an object type"),
        ("void plastick m 0 0 5 1 1 1 0 0", "main.rad:1: 'plastick' is not an object type\n  help: did you mean `plastic`?"),
        ("void\n\nplastic m 0 0 5 .1 .1 .1 x 0", "main.rad:3: plastic 'm': real argument 4 of 5 is 'x': not a number"),
        ("void plastic m 0 0 5 .1 .1 .1 nan 0", "main.rad:1: plastic 'm': real argument 4 of 5 is 'nan': not a finite number"),
        ("void plastic m 0 0 5 .1 .1 .1 1e999 0", "main.rad:1: plastic 'm': real argument 4 of 5 is '1e999': not a finite"),
        ("void plastic m 0 0 5 .1 .1 # c\n .1 0 0", "main.rad:1: plastic 'm': real argument 3 of 5 is '#': a comment"),
        ("void plastic m 0 0 5.0 .1 .1 .1 0 0", "main.rad:1: plastic 'm': the number of real arguments is '5.0', not a whole number"),
        ("void plastic m 0 0 -5", "main.rad:1: plastic 'm': the number of real arguments is '-5'"),
        ("void plastic m 0 2 1 2 0", "main.rad:1: plastic 'm': 2 integer arguments are announced"),
        ("gone polygon p 0 0 9 0 0 0 1 0 0 1 1 0", "main.rad:1: polygon 'p': the modifier 'gone' is not defined before this line"),
        ("void polygon p 0 0 8 0 0 0 1 0 0 1 1", "main.rad:1: polygon 'p': 8 real arguments do not make a polygon"),
        ("void sphere p 0 0 5 0 0 0 1 1", "main.rad:1: sphere 'p': 5 real arguments do not make a sphere"),
        ("void alias a gone", "main.rad:1: alias 'a': 'gone' is not defined before this line"),
        ("void alias a void", "main.rad:1: alias 'a': an alias cannot stand for `void`"),
        ("!xform", "main.rad:1: this xform has no input file"),
        ("!xform -t 1 2 main.rad", "main.rad:1: xform -t needs a number, not 'main.rad'"),
        ("!xform -q 1 main.rad", "main.rad:1: xform has no option '-q'"),
        ("!xform -t 1 0 0 -n x main.rad", "main.rad:1: xform -n stands after a transformation"),
        ("!xform -s 0 main.rad", "main.rad:1: xform -s 0 would shrink"),
        ("!genbox m b 1 2", "main.rad:1: genbox lacks zsize"),
        ("!genbox m b 1 2 -3", "main.rad:1: the sizes 1 2 -3 must be positive"),
        ("!genbox m b 1 2 3 -o", "main.rad:1: genbox -o"),
        ("!genbox m b 1 2 3 -r .6", "main.rad:1: a bevel or rounding of 0.6 does not fit"),
        ("!genblinds m b .1 1 1 3 0 -r .04", "main.rad:1: slats of depth 0.1 cannot"),
        ("!genbox m b 1 2 3 | xform main.rad", "main.rad:1: this xform reads 'main.rad' and would throw"),
        ("!genbox 'm b 1 2 3", "main.rad:1: a quote ' is not closed"),
        ("#?RADIANCE\noconv -f a.rad\n", "main.rad: this is an octree"),
        ("void\0", "main.rad:1: this is binary data"),
    ];
    for (text, start) in cases {
        let error = fails(text);
        assert!(error.starts_with(start), "{text:?} gives {error:?}");
    }
}

#[test]
fn degenerate_surfaces_are_left_out_with_a_warning() {
    for shape in [
        "polygon p 0 0 9 0 0 0 1 0 0 2 0 0",
        "polygon p 0 0 12 0 0 0 1 1 0 1 0 0 0 1 0",
        "sphere s 0 0 4 0 0 0 0",
        "ring r 0 0 8 0 0 0 0 0 0 1 2",
        "ring r 0 0 8 0 0 0 0 0 1 1 1",
        "ring r 0 0 8 0 0 0 0 0 1 -1 .2",
        "cylinder c 0 0 7 1 1 1 1 1 1 .5",
        "cylinder c 0 0 7 1 1 1 1 1 2 0",
        "cone c 0 0 8 1 1 1 1 1 2 -1 1",
    ] {
        let (scene, warnings) = warned(&format!("{RED}red {shape}\n"));
        assert!(scene.triangles.is_empty() && warnings.contains("as in Radiance"), "{shape}: {warnings}");
    }
}

#[test]
fn lines_that_ask_for_too_much_end_in_one_error() {
    let pipes = |n: usize| format!("{RED}!genbox red b 1 1 1{}\n", " | xform -t 1 0 0".repeat(n));
    let moved = one(&pipes(63));
    assert_eq!(moved.triangles[0].vertices.map(|v| v.x.floor()).iter().fold(f64::INFINITY, |a, b| a.min(*b)), 63.0);
    assert!(fails(&pipes(64)).starts_with("main.rad:2: this line pipes more than 64 commands into each other"), "{}", fails(&pipes(64)));
    assert!(fails(&pipes(13_200)).contains("more than 64 commands"));

    let folder: Vec<(String, String)> = (0..10)
        .map(|i| (if i == 0 { "main.rad".into() } else { format!("n{i}.rad") }, format!("!xform -a 100 -t 1 0 0 n{}.rad\n", i + 1)))
        .chain([("n10.rad".into(), "# nothing\n".into())])
        .collect();
    let files: Vec<(&str, &str)> = folder.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let (scene, warnings) = read(&files);
    let error = scene.unwrap_err();
    assert!(error.contains("more than 2097152 copies of files and boxes") && warnings.is_empty(), "{error}");

    for (line, message) in [
        ("!genbox red b 1 1 1 | xform -a 2000000 -t 1 0 0 | xform -a 2000000 -t 0 1 0", "more than 2097152 copies"),
        ("!genbox red b 1 1 1 | xform -a 3000000 -t 1 0 0", "xform -a 3000000 asks for more than 2097152 repetitions"),
        ("!genbox red b 1 1 1 | xform -t 1 0 0 -i 99999999", "xform -i 99999999 asks for more than 2097152 repetitions"),
        ("!genbox red b 1 1 1 -b .1 | xform -a 365536 -t 2 0 0", "copies and generators make more than 1048576 triangles"),
        ("!genblinds red b 1 1 1 1000000 0", "copies and generators make more than 1048576 triangles"),
        ("!genblinds red b 1 1 1 1000000 0 +r .5", "this genblinds makes more than 1048576 surfaces"),
        ("!genblinds red b 1 1 1 9e9 0", "nslats is 9000000000; it must be between 1 and 1048576"),
    ] {
        let error = fails(&format!("{RED}{line}\n"));
        assert!(error.contains(message) && error.starts_with("main.rad:2: "), "{line}: {error}");
    }
    // A million repetitions are a handful of squares: 2²⁰ quarter turns about z are none.
    let turned = one(&format!("{RED}!genbox red b 1 2 3 | xform -i 1048576 -rz 90\n"));
    assert!(turned.triangles.iter().flat_map(|t| t.vertices).all(|v| v.min_element() >= 0.0 && v.cmple(DVec3::new(1.0, 2.0, 3.0)).all()));
}

#[test]
fn many_warnings_of_a_kind_are_few_lines() {
    let (scene, warnings) =
        warned("void plastic slat 0 0 5 0.60 0.60 0.60 0 0\n!genblinds slat blind 0.05 9223372036854775808 1.2 65535 30\n");
    assert!(scene.triangles.len() <= 2 * 65535);
    assert!(warnings.lines().count() <= 100 && warnings.contains("more like it)"), "{warnings}");
}

#[test]
fn garbage_and_truncation_never_panic() {
    let whole = format!(
        "{RED}{SQUARE}!genbox red b 1 1 1 -b .2 | xform -a 2 -t 1 0 0\n#@rfluxmtx h=kf u=+Y\nred cone c 0 0 8 0 0 0 0 0 1 .5 .2\nvoid alias x red\nx source s 0 0 4 0 0 1 180\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("main.rad");
    let try_bytes = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let mut warnings = Warnings::new();
        let _ = read_scene(&["main.rad".into()], folder.path(), &mut warnings);
        let _ = read_windows(Path::new("main.rad"), folder.path(), &mut warnings);
    };
    for end in 0..whole.len() {
        try_bytes(&whole.as_bytes()[..end]);
    }
    let mut state = 1_u64;
    for _ in 0..2000 {
        let mut bytes = whole.clone().into_bytes();
        for _ in 0..3 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let place = (state >> 33) as usize % bytes.len();
            bytes[place] = b"0123456789 .-e\n\"'!#|\\x\xff\x00"[(state >> 20) as usize % 24];
        }
        try_bytes(&bytes);
    }
}

#[test]
fn windows_group_by_modifier_and_take_their_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let read = |text: &str| {
        std::fs::write(folder.path().join("w.rad"), text).unwrap();
        let mut warnings = Warnings::new();
        let windows = read_windows(Path::new("w.rad"), folder.path(), &mut warnings);
        (windows.map_err(|e| e.to_string()), warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    };
    let south = "0 0 12 0 0 1 0 0 2 3 0 2 3 0 1";
    let text = format!(
        "#@rfluxmtx h=kh u=-Z\nvoid glow a 0 0 4 1 1 1 0\na polygon a1 {south}\nb polygon b1 {south}\n#@rfluxmtx h=kq\n#@rfluxmtx u=1,0,1 o=x.mtx\nc ring c1 0 0 8 1 1 3 0 0 -1 0 .5\na polygon a2 0 0 12 5 0 1 5 0 2 6 0 2 6 0 1\n"
    );
    let (windows, warnings) = read(&text);
    let windows = windows.unwrap();
    assert_eq!(warnings, "");
    let names: Vec<_> = windows.iter().map(|w| (w.name.as_str(), w.basis.len(), w.triangles.len())).collect();
    assert_eq!(names, [("a", 77, 4), ("b", 145, 2), ("c", 41, 144)]);
    assert_eq!((windows[0].frame.z, windows[0].frame.y), (DVec3::Y, DVec3::NEG_Z));
    assert_eq!((windows[1].frame.z, windows[1].frame.y), (DVec3::Y, DVec3::Z));
    assert!((windows[2].frame.y - DVec3::X).length() < 1e-12);
    assert_eq!((windows[0].origin.name.as_str(), windows[0].origin.line), ("a1", 3));

    let (turned, warnings) = read(&format!("a polygon a1 {south}\na polygon a2 0 0 12 0 0 1 0 0 2 3 1 2 3 1 1\n"));
    turned.unwrap();
    assert!(warnings.contains("is turned by"), "{warnings}");
    let away = read(&format!("a polygon a1 {south}\na polygon a2 0 0 12 3 0 1 3 0 2 0 0 2 0 0 1\n")).0.unwrap_err();
    assert!(away.contains("faces away from the other"), "{away}");
    for (text, message) in [
        ("a sphere s 0 0 4 0 0 0 1", "a sphere cannot be a window"),
        ("void glow a 0 0 4 1 1 1 0", "there is no window in this file"),
        ("#@rfluxmtx h=r4\na polygon p 0 0 9 0 0 0 1 0 0 1 1 0", "h=r4 is not a basis of windows"),
        ("#@rfluxmtx up=Z\na polygon p 0 0 9 0 0 0 1 0 0 1 1 0", "'up=Z' is not a parameter"),
        ("#@rfluxmtx u=1,2\na polygon p 0 0 9 0 0 0 1 0 0 1 1 0", "u=1,2 is not a direction"),
        ("#@rfluxmtx u=Z\na polygon p 0 0 9 0 0 0 1 0 0 1 1 0", "up vector is zero or parallel"),
        ("a polygon p 0 0 9 0 0 0 1 0 0 2 0 0", "the window has no area"),
    ] {
        let error = read(text).0.unwrap_err();
        assert!(error.contains(message), "{text}: {error}");
    }
    assert!(read(&format!("a polygon a1 {south}\n#@rfluxmtx h=kf\n")).1.contains("no surface follows"));
}

//! Scenes against the tutorial room and live Radiance.

use super::{read_scene, read_windows};
use crate::scene::{MaterialKind, Scene, Triangle};
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
    // What the sun is traced through: the slats, which lie in the slabs of their two BSDF faces.
    let files = ["materials.rad", "blinds/blindsWithProxy.rad"].map(PathBuf::from);
    let (shade, panes) = super::read_shade(&files, &room, &mut Warnings::new()).unwrap();
    assert_eq!(panes.iter().map(|p| p.thickness).collect::<Vec<_>>(), [0.0486638865, -0.0486638865]);
    assert!(shade.triangles.len() > 100 && shade.materials.iter().all(|m| !m.name.ends_with("Poly")));
    let outside = |p| panes.iter().map(|pane| pane.outside(p)).fold(f64::INFINITY, f64::min);
    assert!(shade.triangles.iter().flat_map(|t| t.vertices).all(|p| outside(p) < 1e-4));
}

/// Pseudo-random numbers in 0…1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) ^ (self.0 >> 17) & 0x7fff_ffff) as f64 / (1u64 << 31) as f64
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0;
            if v.length() < 1.0 && v.length() > 1e-3 {
                return v.normalize();
            }
        }
    }
}

/// A folder with the given files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::create_dir_all(folder.path().join(name).parent().unwrap()).unwrap();
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn commands_expand_as_radiance_does() {
    let Some(mut xform) = testing::radiance("xform") else { return };
    let commands = [
        "!genbox red box 1 2 3",
        "!genbox red box 1 2 3 -i",
        "!genbox red box 1 2 3 -b .1",
        "!genbox red box 1 2 3 -i -b .25",
        "!genbox red box 1 2 3 -r .2",
        "!genblinds red slat .1 1.5 2 7 30",
        "!genblinds red slat .1 1.5 2 3 -40 +r .06",
        "!genblinds red slat .1 1.5 2 3 20 -r .051",
        "!genblinds red slat .1 1.5 2 2 0 -r .05",
        "!genblinds red slat .1 1.5 2 2 5 -r 10",
        "!genblinds red slat .1 1.5 2 2 5 -r -.3",
        "!genblinds red slat .1 1 2 5 45 -r .1 | xform -rz 90 -t 1 2 3",
        "!genprism red prism 5 0 0 2 0 3 1 1 2 -1 1 -l .2 .1 3",
        "!genprism red prism 4 0 0 0 2 1 3 2 0 -l 0 0 -2 -c",
        "!genprism red prism 3 0 0 1 0 0 1 -e | xform -rx 20",
        "!gensurf red roof 's*4' 't*3' '1+.3*sin(PI*s)*t^2' 5 4",
        "!gensurf red flat 's' 't' '0' 3 2",
        "!gensurf red hole 's' 't' 'h(s,t)' 8 8 -e 'h(x,y)=x*y;r(s,t)=sqrt(sq(s-.5)+sq(t-.5));sq(x)=x*x' -e 'valid(s,t)=r(s,t)-.3'",
        "!genrev red vase 't*2' '.5+.2*sin(2*PI*t)' 9",
        "!genrev red lamp 'if(t-.5,1-t,t)' 'hermite(.2,.6,1,0,t)' 10",
        "!genrev red plate '1' 't+.1' 3 -e 'unused=1'",
        "!genworm red pipe 'cos(t*PI)' 'sin(t*PI)' 't' '.1' 7",
        "!genworm red root 'bezier(0,1,2,2,t)' 't' '0' '.3-.2*t' 4",
        "!genbox red box 1 2 3 | xform -mx -t .5 0 0 | xform -n outer -m blue -ry 33 -s .5",
        "!genbox red box 1 2 3 | xform -a 3 -t 2 0 0 -a 2 -t 0 0 4 | xform -I -rx 12",
        "!xform parts/things.rad",
        "!xform -n one -t 1 2 3 -rx 10 -ry 20 -rz 30 parts/things.rad",
        "!xform -rx 90 -ry 180 -rz 270 parts/things.rad",
        "!xform -mx -s 3 parts/things.rad",
        "!xform -my -mz -rz -45 parts/things.rad",
        "!xform -I parts/things.rad",
        "!xform -I -mz parts/things.rad",
        "!xform -s -2 parts/things.rad",
        "!xform -m blue parts/things.rad parts/nested.rad",
        "!xform -n a -a 3 -t 1.5 0 0 -rz 10 -a 2 -t 0 2 0 -i 1 -s 2 parts/things.rad",
        "!xform -t 1 0 0 -i 3 -rz 20 -t 0 .5 0 -i 1 -mz parts/things.rad",
        "!xform -i 0 -t 5 5 5 -i 2 -t 0 0 1 parts/things.rad",
        "!xform -e -n deep -rz 45 parts/nested.rad",
        "!xform -t 0 0 1 \\\n  -rz 5 'parts/things.rad'",
    ];
    let things = "red polygon p 0 0 12 0 0 0 1 0 0 1 1 .5 0 1 .5\nred sphere s 0 0 4 1 2 3 .5\nred bubble b 0 0 4 1 -2 3 .25\n\
        red cylinder c 0 0 7 0 0 0 0 1 1 .2\nred tube t 0 0 7 0 0 0 0 1 -1 .2\nred cone k 0 0 8 3 0 0 3 1 1 .2 .1\n\
        red cup u 0 0 8 4 0 0 4 1 1 0 .3\nred ring r 0 0 8 1 1 1 .6 0 .8 .5 .1\nglowing source sun 0 0 4 1 2 3 .5\nglowing ring g 0 0 8 0 0 0 0 0 1 0 1\n";
    let nested = "!genbox red inner .5 .5 .5 | xform -n nest -rx 30\n!xform -n again -m blue -t 0 0 9 -mx things.rad\n";
    let materials = "void plastic red 0 0 5 .5 .2 .2 0 0\nvoid plastic blue 0 0 5 .1 .2 .9 0 0\nvoid glow glowing 0 0 4 1 1 1 2\n";
    let folder = folder(&[
        ("parts/things.rad", things),
        ("parts/nested.rad", nested),
        ("materials.rad", materials),
        ("things.rad", "red ring wrong 0 0 8 0 0 0 0 0 1 0 1\n"),
    ]);
    xform.current_dir(folder.path()).arg("main.rad");
    for command in commands {
        std::fs::write(folder.path().join("main.rad"), format!("{command}\n")).unwrap();
        let (ours, warnings) = read(&["materials.rad", "main.rad"], folder.path()).unwrap_or_else(|e| panic!("{command}: {e}"));
        // -m takes their light from sources.
        assert!(warnings.iter().all(|w| w.contains("'blue' gives no light")), "{command}: {warnings:?}");
        std::fs::write(folder.path().join("expanded.rad"), testing::output(&mut xform)).unwrap();
        let (theirs, _) = read(&["materials.rad", "expanded.rad"], folder.path()).unwrap();
        assert_eq!(ours.triangles.len(), theirs.triangles.len(), "{command}");
        assert_eq!(ours.sources.len(), theirs.sources.len(), "{command}");
        let sources = ours.sources.iter().zip(&theirs.sources).map(|(a, b)| (a.direction - b.direction).length());
        assert!(sources.fold(0.0, f64::max) < 1e-9, "{command}");
        if command.contains(" -b ") || command.contains(" -r .2") {
            // The pieces come in another order, so only sums can be compared here; hits are
            // compared by another test.
            let sum = |s: &Scene| {
                s.triangles
                    .iter()
                    .map(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]).dot(t.vertices[0]) / 6.0)
                    .sum::<f64>()
            };
            assert!((sum(&ours) - sum(&theirs)).abs() < 1e-9, "{command}: enclosed volume");
            assert!((area_of(&ours, "red") - area_of(&theirs, "red")).abs() < 1e-9, "{command}");
            continue;
        }
        for (a, b) in ours.triangles.iter().zip(&theirs.triangles) {
            let (surface, other) = (&ours.surfaces[a.surface as usize], &theirs.surfaces[b.surface as usize]);
            assert_eq!(surface.name, other.name, "{command}");
            assert_eq!(ours.materials[a.material.0 as usize].name, theirs.materials[b.material.0 as usize].name, "{command}");
            // xform prints 12 digits.
            let far = a.vertices.iter().zip(b.vertices).map(|(p, q)| (p - q).length()).fold(0.0, f64::max);
            assert!(far < 1e-9, "{command}: {} is off by {far}", surface.name);
        }
    }
}

/// Name of the surface, distance and whether the front was hit, for each ray; all surfaces must be
/// of a `glow` with radiance 1, which only their fronts show.
fn radiance_hits(folder: &Path, files: &[&str], rays: &[[DVec3; 2]]) -> Option<Vec<Option<(String, f64, bool)>>> {
    use std::io::Write;
    let octree = testing::output(testing::radiance("oconv")?.current_dir(folder).arg("-w").args(files));
    std::fs::write(folder.join("scene.oct"), octree).unwrap();
    let text: String =
        rays.iter().map(|[o, d]| format!("{:.17e} {:.17e} {:.17e} {:.17e} {:.17e} {:.17e}\n", o.x, o.y, o.z, d.x, d.y, d.z)).collect();
    let mut input = tempfile::tempfile().unwrap();
    input.write_all(text.as_bytes()).unwrap();
    std::io::Seek::rewind(&mut input).unwrap();
    let mut rtrace = testing::radiance("rtrace")?;
    rtrace.current_dir(folder).args(["-h", "-w", "-ab", "0", "-dr", "0", "-oLvs", "scene.oct"]).stdin(input);
    let out = String::from_utf8(testing::output(&mut rtrace)).unwrap();
    let hits: Vec<_> = out
        .lines()
        .map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            let distance: f64 = words[0].parse().unwrap();
            let front = words[1].parse::<f64>().unwrap() > 0.5;
            (words[4] != "*").then(|| (words[4].to_string(), distance, front))
        })
        .collect();
    assert_eq!(hits.len(), rays.len());
    Some(hits)
}

/// Nearest hit by testing every triangle in f64 (Möller and Trumbore 1997).
fn nearest_hit(scene: &Scene, [origin, direction]: [DVec3; 2]) -> Option<(String, f64, bool)> {
    let mut nearest: Option<(u32, f64, bool)> = None;
    for t in &scene.triangles {
        let [a, b, c] = t.vertices;
        let (ab, ac) = (b - a, c - a);
        let p = direction.cross(ac);
        let determinant = ab.dot(p);
        if determinant == 0.0 {
            continue;
        }
        let s = origin - a;
        let u = s.dot(p) / determinant;
        let q = s.cross(ab);
        let v = direction.dot(q) / determinant;
        let distance = ac.dot(q) / determinant;
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 1e-6 && nearest.is_none_or(|n| distance < n.1) {
            nearest = Some((t.surface, distance, determinant > 0.0));
        }
    }
    nearest.map(|(surface, distance, front)| (scene.surfaces[surface as usize].name.clone(), distance, front))
}

/// Outlines that have been trouble somewhere: seams, holes wound either way, crossings, touching,
/// repeated corners, spikes.
fn nasty_outlines() -> Vec<(&'static str, Vec<[f64; 2]>)> {
    let mut outlines: Vec<(&str, Vec<[f64; 2]>)> = vec![
        ("concave", vec![[0., 0.], [1., 0.], [1., 1.], [0.5, 0.2], [0., 1.]]),
        (
            "seam to a corner",
            vec![[0., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 0.], [0.2, 0.2], [0.2, 0.8], [0.8, 0.8], [0.8, 0.2], [0.2, 0.2]],
        ),
        (
            "hole wound the same way",
            vec![[0., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 0.], [0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8], [0.2, 0.2]],
        ),
        (
            "two holes, seams in a row",
            vec![
                [0., 0.],
                [1., 0.],
                [1., 1.],
                [0., 1.],
                [0., 0.],
                [0.1, 0.1],
                [0.1, 0.3],
                [0.3, 0.3],
                [0.6, 0.6],
                [0.6, 0.9],
                [0.9, 0.9],
                [0.9, 0.6],
                [0.6, 0.6],
                [0.3, 0.3],
                [0.3, 0.1],
                [0.1, 0.1],
            ],
        ),
        (
            "hole that touches the outline",
            vec![[0., 0.], [0.5, 0.], [0.3, 0.5], [0.5, 0.7], [0.7, 0.5], [0.5, 0.], [1., 0.], [1., 1.], [0., 1.]],
        ),
        ("seam along the outline", vec![[0., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 0.5], [0., 0.2], [0.4, 0.2], [0.4, 0.5], [0., 0.5]]),
        ("uneven bow tie", vec![[0., 0.], [1., 1.], [1., 0.1], [0., 0.4]]),
        ("pentagram", (0..5).map(|i| (i as f64 * 4.0 * std::f64::consts::PI / 5.0).sin_cos().into()).collect()),
        ("spike", vec![[0., 0.], [1., 0.], [2., 0.], [1., 0.], [1., 1.], [0., 1.]]),
        ("repeated corners", vec![[0., 0.], [0., 0.], [1., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 1.], [0., 0.]]),
        ("corners on straight edges", vec![[0., 0.], [0.25, 0.], [0.5, 0.], [1., 0.], [1., 0.3], [1., 1.], [0.4, 1.], [0., 1.], [0., 0.5]]),
        ("twice around", vec![[0., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 0.], [1., 0.], [1., 1.], [0.3, 0.8]]),
        ("comb", (0..20).map(|i| [i as f64 / 20.0, if i % 4 < 2 { 0.0 } else { 0.9 }]).chain([[1.0, 1.0], [0.0, 1.0]]).collect()),
        ("clockwise", vec![[0., 0.], [0., 1.], [1., 1.], [0.5, 0.3]]),
    ];
    let mut random = Random(7);
    for n in [5, 6, 7, 8, 9, 12, 15, 20, 30] {
        for _ in 0..6 {
            outlines.push(("random", (0..n).map(|_| [random.next(), random.next()]).collect()));
        }
    }
    // On a grid, so that corners, edges and crossings coincide.
    for n in [6, 8, 10, 14] {
        for _ in 0..10 {
            let outline: Vec<[f64; 2]> =
                (0..n).map(|_| [(random.next() * 4.0).floor() / 4.0, (random.next() * 4.0).floor() / 4.0]).collect();
            let area: f64 = (0..n).map(|i| outline[i][0] * outline[(i + 1) % n][1] - outline[i][1] * outline[(i + 1) % n][0]).sum();
            // Without a net area a polygon has no plane: Radiance takes what rounding leaves.
            if area != 0.0 {
                outlines.push(("on a grid", outline));
            }
        }
    }
    outlines
}

/// Distance of a point from the nearest edge.
fn edge_distance(outline: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let point = glam::DVec2::from(point);
    (0..outline.len())
        .map(|i| {
            let (a, b) = (glam::DVec2::from(outline[i]), glam::DVec2::from(outline[(i + 1) % outline.len()]));
            let along = ((point - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
            (a + (b - a) * along - point).length()
        })
        .fold(f64::MAX, f64::min)
}

#[test]
fn nasty_polygons_have_radiances_inside() {
    let outlines = nasty_outlines();
    let mut random = Random(1);
    let mut text = String::from("void glow white 0 0 4 1 1 1 0\n");
    let (mut rays, mut targets) = (Vec::new(), Vec::new());
    for (i, (_, outline)) in outlines.iter().enumerate() {
        let z = random.direction();
        let (x, y) = z.any_orthonormal_pair();
        let origin = DVec3::new(3.0 * i as f64, 0.0, 0.0);
        let place = |p: [f64; 2]| origin + x * (p[0] - 0.5) + y * (p[1] - 0.5);
        let corners: String = outline.iter().flat_map(|&p| place(p).to_array()).map(|c| format!(" {c:.17e}")).collect();
        text.push_str(&format!("white polygon p{i} 0 0 {}{corners}\n", 3 * outline.len()));
        for _ in 0..400 {
            let target = [random.next() * 1.2 - 0.1, random.next() * 1.2 - 0.1];
            targets.push(target);
            let target = place(target);
            let side = if random.next() < 0.5 { 1.0 } else { -1.0 };
            rays.push([target + z * (0.1 * side), -z * side]);
        }
    }
    let folder = folder(&[("main.rad", &text)]);
    let Some(expected) = radiance_hits(folder.path(), &["main.rad"], &rays) else { return };
    let (scene, _) = read(&["main.rad"], folder.path()).unwrap();
    let mut hits = 0;
    for (i, (ray, expected)) in rays.iter().zip(&expected).enumerate() {
        let found = nearest_hit(&scene, *ray);
        let (kind, outline) = &outlines[i / 400];
        let agree = match (&found, expected) {
            (None, None) => true,
            (Some((name, distance, front)), Some((n, d, f))) => name == n && (distance - d).abs() < 1e-5 && front == f,
            _ => false,
        };
        // Radiance counts a point within its FTINY of an edge as inside.
        assert!(
            agree || edge_distance(outline, targets[i]) < 1e-6,
            "polygon {} ({kind}) {outline:?}: {:?} gives {found:?}, Radiance {expected:?}",
            i / 400,
            targets[i]
        );
        hits += usize::from(found.is_some());
    }
    assert!(hits > rays.len() / 8, "{hits} of {} rays hit", rays.len());
}

#[test]
fn polygons_that_are_not_plane_are_flattened_as_radiance_does() {
    let mut random = Random(5);
    let mut text = String::from("void glow white 0 0 4 1 1 1 0\n");
    let mut rays = Vec::new();
    for i in 0..40 {
        let centre = DVec3::new(4.0 * i as f64, 0.0, 0.0);
        let z = random.direction();
        let (x, y) = z.any_orthonormal_pair();
        let n = 4 + i % 6;
        let bend = [0.05, 0.1, 0.4][i % 3];
        let corners: String = (0..n)
            .flat_map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
                (centre + (x * cos + y * sin) * (0.4 + 0.6 * random.next()) + z * (bend * (random.next() - 0.5))).to_array()
            })
            .map(|c| format!(" {c:.17e}"))
            .collect();
        text.push_str(&format!("white polygon p{i} 0 0 {}{corners}\n", 3 * n));
        for _ in 0..300 {
            let origin = centre + random.direction() * 1.5;
            let target = centre + (x * (random.next() - 0.5) + y * (random.next() - 0.5)) * 2.0;
            rays.push([origin, (target - origin).normalize()]);
        }
    }
    let folder = folder(&[("main.rad", &text)]);
    let Some(expected) = radiance_hits(folder.path(), &["main.rad"], &rays) else { return };
    let (scene, warnings) = read(&["main.rad"], folder.path()).unwrap();
    assert!(warnings.len() == 20 && warnings[19].contains("(and 20 more like it)"), "{warnings:?}");
    let mut differ = 0;
    for (ray, expected) in rays.iter().zip(&expected) {
        match (nearest_hit(&scene, *ray), expected) {
            (None, None) => {}
            (Some((name, distance, front)), Some((n, d, f))) => {
                assert!(name == *n && front == *f && (distance - d).abs() < 1e-4, "{ray:?}")
            }
            _ => differ += 1,
        }
    }
    // Radiance drops one coordinate of the corners before it flattens them, as is done here; rays
    // within its FTINY of an edge may still differ.
    assert!(differ <= 1, "{differ} of {} rays", rays.len());
}

#[test]
fn curved_surfaces_and_rounded_boxes_are_hit_where_radiances_are() {
    let scene_text = "void glow white 0 0 4 1 1 1 0\n\
        white sphere sphere 0 0 4 0 0 0 1\nwhite bubble bubble 0 0 4 3 0 0 .9\n\
        white cylinder cylinder 0 0 7 6 -.5 -.8 6.5 .5 .8 .6\nwhite tube tube 0 0 7 9 -.5 .8 8.5 .5 -.8 .6\n\
        white cone cone 0 0 8 12 0 -.8 12.3 0 .8 .9 .2\nwhite cup cup 0 0 8 15 0 -.8 15 .5 .8 0 .9\n\
        white ring ring 0 0 8 18 0 0 .6 .5 .7 .9 .3\nwhite sphere inside_out 0 0 4 21 0 0 -.8\n\
        white cylinder negative 0 0 7 24 -.5 -.8 24.5 .5 .8 -.6\nwhite cone negative 0 0 8 27 0 -.8 27.3 0 .8 -.9 -.2\n\
        !genbox white rounded 1.2 1.6 1.4 -r .3 | xform -t 29.4 -.8 -.7\n!genbox white rounded_in 1.2 1.6 1.4 -i -r .3 | xform -t 32.4 -.8 -.7\n\
        !genbox white bevel 1.2 1.6 1.4 -b .3 | xform -t 35.4 -.8 -.7\n!genbox white bevel_in 1.2 1.6 1.4 -i -b .3 | xform -t 38.4 -.8 -.7\n";
    let folder = folder(&[("main.rad", scene_text)]);
    let mut random = Random(3);
    let (per_shape, shapes) = (1000, 14);
    let rays: Vec<[DVec3; 2]> = (0..per_shape * shapes)
        .map(|i| {
            let centre = DVec3::new(3.0 * (i / per_shape) as f64, 0.0, 0.0);
            // From inside and outside, towards a point near the shape.
            let origin = centre + random.direction() * if random.next() < 0.4 { 0.3 } else { 1.4 };
            let target = centre + random.direction() * random.next();
            [origin, (target - origin).normalize()]
        })
        .collect();
    let Some(expected) = radiance_hits(folder.path(), &["main.rad"], &rays) else { return };
    let (scene, _) = read(&["main.rad"], folder.path()).unwrap();
    for shape in 0..shapes {
        let range = shape * per_shape..(shape + 1) * per_shape;
        // Each shape is compared alone; hits of its neighbours, 3 apart, count as misses.
        let is_near = |p: DVec3| (p.x - 3.0 * shape as f64).abs() < 1.5;
        let near = |t: &Triangle| is_near(t.vertices[0]);
        let scene = Scene { triangles: scene.triangles.iter().filter(|t| near(t)).copied().collect(), ..scene.clone() };
        let name = expected[range.clone()].iter().flatten().map(|h| h.0.clone()).next().unwrap();
        let (mut differ, mut worst) = (0, 0.0_f64);
        for i in range {
            let expected = expected[i].as_ref().filter(|(_, d, _)| is_near(rays[i][0] + rays[i][1] * *d));
            match (nearest_hit(&scene, rays[i]), expected) {
                (Some((_, distance, front)), Some((_, d, f))) if front == *f && (distance - d).abs() < 0.05 => {
                    worst = worst.max((distance - d).abs())
                }
                (None, None) => {}
                _ => differ += 1,
            }
        }
        // Chords cut off 1e-3 of the radius, so rays within 1e-3 of a silhouette may miss; of rays
        // that fill a circle of about the shape's size this is a share of about 2e-3.
        assert!(differ <= per_shape * 8 / 1000, "{name}: {differ} of {per_shape} rays differ");
        assert!(worst < 0.05, "{name}: {worst}");
        eprintln!("{name}: {differ} of {per_shape} rays differ, others by at most {worst:.1e}");
    }
}

#[test]
fn window_frames_have_rfluxmtxs_bins() {
    use std::io::Write;
    // Upright, oblique and horizontal windows, both senses of rotation, default and given up vectors.
    let south = "-2 0 -2 -2 0 2 2 0 2 2 0 -2";
    let oblique = "-2 -1 -2 -2 1 2 2 1 2 2 -1 -2";
    let flat = "-2 -2 0 -2 2 0 2 2 0 2 -2 0";
    let steep = "-2 -2 -1.9 -2 2 1.9 2 2 1.9 2 -2 -1.9";
    let cases = [
        (south, "h=kf"),
        (south, "h=+kf u=Z"),
        (south, "h=-kf u=Z"),
        (south, "h=kh u=-X"),
        (oblique, "h=kf u=1,2,3"),
        (oblique, "h=-kq u=-1,0,.5"),
        (flat, "h=kf"),
        (flat, "h=kq u=+X"),
        (steep, "h=kf"),
        (oblique, "h=kh"),
    ];
    let mut random = Random(11);
    let folder = folder(&[("room.rad", "void plastic black 0 0 5 0 0 0 0 0\nblack sphere far 0 0 4 0 0 99 .1\n")]);
    for (corners, parameters) in cases {
        let text = format!("#@rfluxmtx {parameters}\nvoid glow w 0 0 4 1 1 1 0\nw polygon p 0 0 12 {corners}\n");
        std::fs::write(folder.path().join("w.rad"), text).unwrap();
        let window = read_windows(Path::new("w.rad"), folder.path(), &mut Warnings::new()).unwrap().remove(0);
        // From the room (where the normal points) through the centre.
        let directions: Vec<DVec3> = (0..300)
            .map(|_| {
                let d = random.direction();
                if d.dot(window.frame.z) > 0.0 { -d } else { d }
            })
            .collect();
        let rays: String = directions.iter().map(|d| format!("{} {} {} {} {} {}\n", -d.x, -d.y, -d.z, d.x, d.y, d.z)).collect();
        let mut input = tempfile::tempfile().unwrap();
        input.write_all(rays.as_bytes()).unwrap();
        std::io::Seek::rewind(&mut input).unwrap();
        let Some(mut rfluxmtx) = testing::radiance("rfluxmtx") else { return };
        rfluxmtx.current_dir(folder.path()).args(["-h", "-w", "-fa", "-ab", "0", "-", "w.rad", "room.rad"]).stdin(input);
        let out = String::from_utf8(testing::output(&mut rfluxmtx)).unwrap();
        let rows: Vec<Vec<f64>> =
            out.lines().filter(|l| !l.trim().is_empty()).map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect();
        assert_eq!(rows.len(), directions.len(), "{parameters}");
        let mut differ = 0;
        for (direction, row) in directions.iter().zip(&rows) {
            assert_eq!(row.len(), 3 * window.basis.len(), "{parameters}");
            let theirs = row.iter().position(|v| *v > 0.5).map(|i| i / 3);
            // Light travels the other way, into the room.
            let ours = window.basis.bin_of(window.frame.to_local(-direction));
            differ += usize::from(theirs != Some(ours));
        }
        // A ray may fall onto a limit of bins, where rounding decides.
        assert!(differ <= 1, "{parameters} {corners}: {differ} of {} rays in other bins", rows.len());
    }
}

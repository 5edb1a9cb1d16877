//! Extreme scenes, each with the value it must give and why.

use super::TracedMatrix;
use super::comparison::assert_agrees;
use super::reference;
use super::rooms::{Builder, asymmetric, placed, polygon_irradiance, sensor, street, window};
use crate::bins::{Frame, KlemsBasis, ReinhartSky};
use crate::gpu::Device;
use crate::kernels::daylight_matrix::{self, DaylightOptions};
use crate::kernels::view_matrix::{self, ViewOptions};
use crate::progress::Silent;
use crate::scene::points::Sensor;
use crate::scene::{MaterialKind, Scene, Window};
use crate::testing::{measured, short};
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

fn view(device: &Device, scene: &Scene, w: &Window, sensors: &[Sensor], options: &ViewOptions) -> TracedMatrix {
    let v = view_matrix::compute(device, scene, std::slice::from_ref(w), sensors, options, &Silent).unwrap();
    for m in [&v.total, &v.direct, &v.standard_error] {
        assert!(m.data().iter().all(|x| x.is_finite() && *x >= 0.0), "a value is not a number");
    }
    v
}

/// Green sum of a row, and the standard error of that sum.
fn row_sum(v: &TracedMatrix, row: usize) -> (f64, f64) {
    let bins = 0..v.total.cols();
    let sum = bins.clone().map(|b| f64::from(v.total.at(row, b)[1])).sum();
    (sum, bins.map(|b| f64::from(v.standard_error.at(row, b)[1]).powi(2)).sum::<f64>().sqrt())
}

fn direct_sum(v: &TracedMatrix, row: usize) -> f64 {
    (0..v.direct.cols()).map(|b| f64::from(v.direct.at(row, b)[1])).sum()
}

#[test]
fn size_and_place_of_the_scene_change_nothing() {
    let Some(device) = Device::for_tests("scale and place") else { return };
    let sensors =
        [sensor([1.0, 2.0, 0.8], [0.0, 0.0, 1.0]), sensor([3.6, 0.6, 0.1], [0.0, 0.2, 1.0]), sensor([0.05, 4.0, 1.5], [1.0, -0.3, 0.0])];
    let (scene, w) = asymmetric();
    let (outside, outer) = street();
    let options = ViewOptions { bounces: Some(3), light_paths: 32, ..ViewOptions::default() };
    let daylight_options = DaylightOptions { bounces: Some(2), paths: 64, ..DaylightOptions::default() };
    let sky = ReinhartSky::new(1).unwrap();
    let daylight = |scene: &Scene, w: &Window| daylight_matrix::compute(&device, scene, w, sky, &daylight_options, &Silent).unwrap().total;
    let v = view(&device, &scene, &w, &sensors, &options);
    let d = daylight(&outside, &outer);
    for (what, origin, scale) in [
        ("a room of 4 mm", DVec3::ZERO, 1e-3),
        ("a room of 4 km", DVec3::ZERO, 1e3),
        ("survey coordinates", DVec3::new(583_960.4, 4_507_523.7, 31.6), 1.0),
    ] {
        let moved: Vec<Sensor> = sensors.iter().map(|s| Sensor { position: origin + s.position * scale, ..*s }).collect();
        let (other, other_window) = placed(&scene, &w, origin, scale);
        let v2 = view(&device, &other, &other_window, &moved, &options);
        // The same random numbers: paths differ only where rounding turns a choice.
        for row in 0..sensors.len() {
            let (sum, error) = row_sum(&v, row);
            let (moved_sum, _) = row_sum(&v2, row);
            println!("{what}, sensor {row}: {moved_sum} of {sum} ± {error}");
            assert!((moved_sum - sum).abs() < 0.2 * error + 1e-4 * sum, "{what}: {moved_sum}, not {sum}");
        }
        let (other, other_window) = placed(&outside, &outer, origin, scale);
        let d2 = daylight(&other, &other_window);
        let difference: f64 = d.data().iter().zip(d2.data()).map(|(a, b)| f64::from(a - b).abs()).sum();
        let sum: f64 = d.data().iter().map(|&a| f64::from(a)).sum();
        println!("{what}: D differs by {:.1e}", difference / sum);
        assert!(difference < 2e-3 * sum, "{what}: {difference} of {sum}");
    }
}

/// A sphere of radius 1 with its top cut off: the opening is the window, its share of the sphere's
/// surface (as a cap) is `open`. Gives also the area of the opening and of the wall.
fn sphere(open: f64, reflectance: f64, rings: usize) -> (Scene, Window, f64, f64) {
    let mut b = Builder::default();
    let wall = b.grey(reflectance);
    let segments = 2 * rings;
    let start = (1.0 - 2.0 * open).acos();
    let at = |ring: usize, segment: usize| {
        let theta = start + (PI - start) * ring as f64 / rings as f64;
        let phi = TAU * segment as f64 / segments as f64;
        [theta.sin() * phi.cos(), theta.sin() * phi.sin(), if ring == rings { -1.0 } else { theta.cos() }]
    };
    for ring in 0..rings {
        for s in 0..segments {
            b.quad([at(ring, s), at(ring, s + 1), at(ring + 1, s + 1), at(ring + 1, s)], wall);
        }
    }
    let corner = |s: usize| DVec3::from_array(at(0, s));
    let middle = DVec3::new(0.0, 0.0, corner(0).z);
    let mut w = window([at(0, 0); 4], DVec3::NEG_Z, DVec3::Y, KlemsBasis::Quarter);
    w.triangles = (0..segments).map(|s| [middle, corner(s), corner(s + 1)]).collect();
    let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0;
    let (opening, walls) = (w.area(), b.scene.triangles.iter().map(|t| area(&t.vertices)).sum());
    (b.scene, w, opening, walls)
}

#[test]
fn a_sphere_fills_with_light_as_the_geometric_series_says() {
    let Some(device) = Device::for_tests("integrating sphere") else { return };
    // Light that leaves the wall of a sphere falls evenly on all of it, the opening's cap included.
    // With flux Φ through the opening every point of the wall receives, besides the direct light,
    // Φ ρ/A Σ (ρ (1 − open))^k over the reflections, 1/(1 − ρ (1 − open)) if there is no end.
    let oblique = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(0.7);
    let directions = [DVec3::NEG_Z, DVec3::X, DVec3::new(-0.6, 0.5, 0.3), DVec3::new(0.1, -1.0, -0.4), DVec3::new(0.3, 0.4, -0.9)];
    for (open, reflectance, bounces, paths, rings, tolerance) in [
        (0.05, 0.0, None, 8, 32, 0.0),
        (0.05, 0.9, Some(2), 32, 48, 0.01),
        (0.05, 0.9, Some(5), 32, 48, 0.01),
        (0.05, 0.9, None, 64, 48, 0.01),
        // Hundreds of reflections; few triangles, or devices that limit loops cut the paths off.
        (0.01, 0.999, None, 32, 20, 0.04),
        // A window of a hundredth of the room's width: 160 of its sizes across.
        (4e-5, 0.6, None, 64, 48, 0.01),
    ] {
        let (scene, w, opening, wall) = sphere(open, reflectance, rings);
        let (scene, w) = turned(&scene, &w, oblique);
        // The wall is a polyhedron inside the sphere.
        let inside = 1.0 - 5.0 / (rings * rings) as f64;
        let sensors: Vec<Sensor> = directions
            .iter()
            .map(|d| {
                let d = oblique * d.normalize();
                Sensor { position: d * inside, direction: -d, line: 0 }
            })
            .collect();
        let options = ViewOptions { bounces, light_paths: paths, near_samples: 256, direct_samples: 128, ..ViewOptions::default() };
        let v = view(&device, &scene, &w, &sensors, &options);
        let sphere_area = wall / (1.0 - open);
        let kept = reflectance * (1.0 - open);
        let series = match bounces {
            Some(b) => (0..b as i32 - 1).map(|k| kept.powi(k)).sum(),
            None => 1.0 / (1.0 - kept),
        };
        let expected = PI * opening * reflectance / sphere_area * series;
        let found: Vec<f64> = (0..sensors.len()).map(|row| row_sum(&v, row).0 - direct_sum(&v, row)).collect();
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        println!("open {open}, reflectance {reflectance}, -ab {bounces:?}: {mean:.5} of {expected:.5} {found:.4?}");
        assert!((mean - expected).abs() <= tolerance * expected, "{mean}, not {expected}");
        for value in found {
            assert!((value - expected).abs() <= 4.0 * tolerance * expected, "{value}, not {expected}");
        }
        if reflectance == 0.0 {
            assert_eq!(v.total, v.direct);
        }
    }
}

#[test]
fn a_white_furnace_glows_as_often_as_it_reflects() {
    let Some(device) = Device::for_tests("white furnace") else { return };
    // A closed room whose walls emit 1 and reflect ρ has the radiosity 1/(1 − ρ). Here the emission
    // enters through a small opening of a sphere, which spreads it evenly: every point of the wall
    // receives 1/(1 − ρ kept) times that, `kept` being what does not leave through the opening.
    const SAME: f64 = 1e-3;
    let mut texts = [const { Vec::new() }; 2];
    for (reflectance, rings, light_paths, near_samples, tolerance) in [(0.9, 20, 2048, 1024, Some(SAME)), (0.99, 12, 128, 1024, None)] {
        let (scene, w, opening, wall) = sphere(0.01, reflectance, rings);
        let inside = 1.0 - 5.0 / (rings * rings) as f64;
        let sensors: Vec<Sensor> = [DVec3::NEG_Z, DVec3::X, DVec3::new(-0.6, 0.5, 0.3), DVec3::new(0.1, -1.0, -0.4)]
            .map(|d| Sensor { position: d.normalize() * inside, direction: -d.normalize(), line: 0 })
            .to_vec();
        let v = view(&device, &scene, &w, &sensors, &ViewOptions { light_paths, near_samples, ..ViewOptions::default() });
        let even = PI * opening / wall;
        let expected = 1.0 / (1.0 - reflectance * (1.0 - opening / wall));
        // A sensor in front of the wall receives directly not quite what the wall receives.
        let reflected = |row: usize| row_sum(&v, row).0 - direct_sum(&v, row);
        let found: Vec<(f64, f64)> = (0..sensors.len()).map(|row| (1.0 + reflected(row) / even, row_sum(&v, row).1 / even)).collect();
        let mean = found.iter().map(|f| f.0).sum::<f64>() / found.len() as f64;
        // The sensors share the light paths: their errors do not average out.
        let error = found.iter().map(|f| f.1).sum::<f64>() / found.len() as f64;
        println!("reflectance {reflectance}: {mean:.4} ± {error:.4} of {expected:.4}; {found:.4?}");
        assert!((mean - expected).abs() < tolerance.map_or(4.0 * error, |t| t * expected), "{mean} ± {error}, not {expected}");
        assert!(error < 0.01 * expected, "so uncertain that everything agrees");
        texts[0].push(short((mean / expected - 1.0).abs()));
        texts[1].push(tolerance.map_or(format!("4 standard errors of {}", short(error / expected)), short));
    }
    let [found, held] = texts.map(|t| t.join(" / "));
    measured("white-furnace", &format!("within {found}"), &held);
}

/// Turns a scene and its window.
fn turned(scene: &Scene, w: &Window, turn: DMat3) -> (Scene, Window) {
    let (mut scene, mut w) = (scene.clone(), w.clone());
    for p in scene.triangles.iter_mut().flat_map(|t| &mut t.vertices).chain(w.triangles.iter_mut().flatten()) {
        *p = turn * *p;
    }
    w.frame = Frame { x: turn * w.frame.x, y: turn * w.frame.y, z: turn * w.frame.z };
    (scene, w)
}

#[test]
fn turning_the_room_and_sensors_on_its_surfaces_change_nothing() {
    let Some(device) = Device::for_tests("sensors on surfaces") else { return };
    let (scene, w) = asymmetric();
    // Well above the floor, exactly on it (in the middle and in a corner), and on the dark wall.
    let base = [
        ([1.3, 2.0, 1e-3], DVec3::Z),
        ([1.3, 2.0, 0.0], DVec3::Z),
        ([3.0, 4.0, 1e-3], DVec3::Z),
        ([3.0, 4.0, 0.0], DVec3::Z),
        ([1e-3, 2.0, 1.0], DVec3::X),
        ([0.0, 2.0, 1.0], DVec3::X),
    ];
    let options = ViewOptions { bounces: Some(3), light_paths: 256, near_samples: 2048, ..ViewOptions::default() };
    let mut first: Option<Vec<(f64, f64)>> = None;
    for turn in [DMat3::IDENTITY, DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(0.9) * DMat3::from_rotation_y(-0.6)] {
        let (scene, w) = turned(&scene, &w, turn);
        let sensors: Vec<Sensor> =
            base.iter().map(|(p, d)| Sensor { position: turn * DVec3::from_array(*p), direction: turn * *d, line: 0 }).collect();
        let v = view(&device, &scene, &w, &sensors, &options);
        let sums: Vec<(f64, f64)> = (0..sensors.len()).map(|row| row_sum(&v, row)).collect();
        println!("{sums:.5?}");
        for pair in sums.chunks(2) {
            let error = pair[0].1.hypot(pair[1].1);
            assert!((pair[0].0 - pair[1].0).abs() < 5.0 * error + 2e-3 * pair[0].0, "on the surface {:?}, above it {:?}", pair[1], pair[0]);
        }
        if let Some(first) = &first {
            for (a, b) in first.iter().zip(&sums) {
                assert!((a.0 - b.0).abs() < 5.0 * a.1.hypot(b.1) + 1e-3 * a.0, "turned {b:?}, not {a:?}");
            }
        }
        first = Some(sums);
    }
}

#[test]
fn windows_seen_edge_on_or_from_behind_give_what_geometry_says() {
    let Some(device) = Device::for_tests("windows seen edge-on") else { return };
    let corners = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let w = window(corners, DVec3::Y, DVec3::Z, KlemsBasis::Full);
    let options = ViewOptions { bounces: Some(1), ..ViewOptions::default() };
    const SAME: f64 = 1e-6;
    let mut worst = 0.0f64;
    // From 30° down to the very plane; facing the window, and with the window's plane as zenith.
    for y in [1.0, 0.1, 1e-2, 1e-4, 1e-6] {
        for normal in [DVec3::NEG_X, DVec3::new(-1.0, -0.2, 0.1)] {
            let v = view(&device, &Scene::default(), &w, &[sensor([3.0, y, 0.4], normal.to_array())], &options);
            let exact = polygon_irradiance(&corners.map(DVec3::from_array), DVec3::new(3.0, y, 0.4), normal.normalize());
            let found = row_sum(&v, 0).0;
            worst = worst.max((found / exact - 1.0).abs());
            assert!(worst < SAME, "y {y}: {found}, not {exact}");
        }
    }
    measured("windows-edge-on", &short(worst), &short(SAME));
    // In its plane, behind it, and on its surface facing away: exactly nothing, and no NaN.
    let nothing = [
        sensor([3.0, 0.0, 0.4], [-1.0, 0.0, 0.0]),
        sensor([0.5, -1.0, 0.5], [0.0, 1.0, 0.0]),
        sensor([0.5, 0.0, 0.5], [0.0, 1.0, 0.0]),
        sensor([0.5, 2.0, 0.5], [0.0, 1.0, 0.0]),
    ];
    let v = view(&device, &Scene::default(), &w, &nothing, &options);
    assert!(v.total.data().iter().all(|&x| x == 0.0));
    // The same behind a window of a closed room: its other side is no part of the scene's light.
    let (scene, w) = asymmetric();
    let options = ViewOptions { bounces: Some(3), light_paths: 32, ..ViewOptions::default() };
    let v = view(&device, &scene, &w, &[sensor([1.0, -0.5, 1.5], [0.0, 1.0, 0.0])], &options);
    assert_eq!(row_sum(&v, 0).0, 0.0, "light leaks through the window's back or the wall");
}

#[test]
fn a_hundred_million_samples_of_one_bin_add_up() {
    let Some(device) = Device::for_tests("a hundred million samples") else { return };
    // A window that faces the ground: all paths of a bin end in one cell, whose value is 1.
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let roof = window(corners, DVec3::Z, DVec3::Y, KlemsBasis::Quarter);
    let options = DaylightOptions { bounces: Some(0), paths: 1 << 19, batches: 5, ..DaylightOptions::default() };
    let d = daylight_matrix::compute(&device, &Scene::default(), &roof, ReinhartSky::new(1).unwrap(), &options, &Silent).unwrap();
    assert!(d.statistics.paths > 100_000_000, "{}", d.statistics.paths);
    const WHOLE: f32 = 1e-6;
    const HALF: f64 = 1e-5;
    let mut worst = 0.0f32;
    for bin in 0..d.total.rows() {
        let ground = d.total.at(bin, 0)[1];
        worst = worst.max((ground - 1.0).abs());
        assert!(worst < WHOLE, "bin {bin}: {ground}");
    }
    // A sensor whose window lies in one bin, half of it behind a wall: 10⁸ rays into that bin.
    let mut b = Builder::default();
    let black = b.grey(0.0);
    let far = 40.0;
    b.quad([[-9.0, 20.0, -9.0], [0.0, 20.0, -9.0], [0.0, 20.0, 9.0], [-9.0, 20.0, 9.0]], black);
    let corners = [[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]];
    let w = window(corners, DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    let eye = DVec3::new(0.0, far, 0.0);
    let options = ViewOptions { bounces: Some(1), direct_samples: 4_000_000, batches: 25, ..ViewOptions::default() };
    let v = view(&device, &b.scene, &w, &[sensor(eye.to_array(), [0.0, -1.0, 0.0])], &options);
    let exact = polygon_irradiance(&corners.map(DVec3::from_array), eye, DVec3::NEG_Y) / 2.0;
    let lit: Vec<usize> = (0..v.total.cols()).filter(|bin| v.total.at(0, *bin)[1] > 0.0).collect();
    println!("bins {lit:?}: {} of {exact} ± {}", row_sum(&v, 0).0, row_sum(&v, 0).1);
    assert_eq!(lit.len(), 1);
    let off = (row_sum(&v, 0).0 / exact - 1.0).abs();
    assert!(off < HALF, "{} of {exact}", row_sum(&v, 0).0);
    let found = format!("{}; {}", short(worst.into()), short(off));
    measured("hundred-million-samples", &found, &format!("{}; {}", short(WHOLE.into()), short(HALF)));
}

#[test]
fn where_short_connections_end_changes_nothing() {
    let Some(device) = Device::for_tests("short connections") else { return };
    let (scene, w) = asymmetric();
    // Beside the dark wall, in a corner, beside the pillar.
    let sensors =
        [sensor([0.05, 2.0, 0.4], [0.5, 0.0, 1.0]), sensor([0.1, 4.9, 0.1], [0.0, 0.0, 1.0]), sensor([2.95, 1.7, 1.0], [-0.3, 0.0, 1.0])];
    compare_splits(&device, &scene, &w, &sensors, &[0.05, 0.5, 3.0, 1e6]);
    // A peephole: all that comes from it is tiny.
    let b = Builder { scene };
    let hole =
        window([[1.0, 0.01, 1.5], [1.0, 0.01, 1.51], [1.01, 0.01, 1.51], [1.01, 0.01, 1.5]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    compare_splits(&device, &b.scene, &hole, &sensors, &[5.0, 100.0, 1e6]);
}

/// V for several radii within which connections are left to paths from the sensors: all unbiased.
fn compare_splits(device: &Device, scene: &Scene, w: &Window, sensors: &[Sensor], radii: &[f32]) {
    let results: Vec<TracedMatrix> = radii
        .iter()
        .map(|&near_radius| {
            let options = ViewOptions { bounces: Some(3), light_paths: 256, near_samples: 4096, near_radius, ..ViewOptions::default() };
            view(device, scene, w, sensors, &options)
        })
        .collect();
    for row in 0..sensors.len() {
        let sums: Vec<(f64, f64)> = results.iter().map(|v| row_sum(v, row)).collect();
        println!("sensor {row}: {sums:?}");
        for pair in sums.windows(2) {
            let difference = (pair[0].0 - pair[1].0).abs();
            // Not so uncertain that everything agrees.
            let error = pair[0].1.hypot(pair[1].1);
            assert!(difference < 4.5 * error && error < 0.08 * pair[0].0, "sensor {row}: {sums:?} at radii {radii:?}");
        }
    }
}

#[test]
fn a_long_corridor_is_lit_by_many_reflections() {
    let Some(device) = Device::for_tests("long corridor") else { return };
    let mut b = Builder::default();
    let wall = b.grey(0.85);
    b.room([0.0; 3], [1.0, 10.0, 1.0], wall, &[2]);
    let w = window([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    let sensors = [sensor([0.3, 9.5, 0.5], [0.0, -1.0, 0.0]), sensor([0.5, 7.0, 0.1], [0.0, 0.0, 1.0])];
    let options = ViewOptions { light_paths: 256, near_samples: 1024, ..ViewOptions::default() };
    let v = view(&device, &b.scene, &w, &sensors, &options);
    for (row, s) in sensors.iter().enumerate() {
        let samples = 400_000;
        let r = reference::view_row(&b.scene, std::slice::from_ref(&w), s.position, s.direction, u32::MAX, samples, 21 + row as u64);
        assert_agrees(&format!("corridor, sensor {row}"), &v, row, &r, samples);
    }
    // Truncated, most of it is missing: what is tested above is indeed light of many reflections.
    let short = view(&device, &b.scene, &w, &sensors, &ViewOptions { bounces: Some(4), ..options });
    assert!(row_sum(&short, 1).0 < 0.5 * row_sum(&v, 1).0);
}

#[test]
fn paths_cut_off_by_the_device_are_an_error_not_darkness() {
    let Some(device) = Device::for_tests("paths cut off") else { return };
    // Light to and fro between two perfect mirrors, each time past thousands of surfaces that it
    // misses by little.
    let mut b = Builder::default();
    let mirror = b.material(MaterialKind::Mirror { color: [1.0; 3] });
    let slat = b.grey(0.5);
    let m = 200.0;
    b.quad([[-m, 0.1, -m], [m, 0.1, -m], [m, 0.1, m], [-m, 0.1, m]], mirror);
    b.quad([[-m, -3.0, m], [m, -3.0, m], [m, -3.0, -m], [-m, -3.0, -m]], mirror);
    for k in 0..4000 {
        let y = -0.2 - 2.6 * f64::from(k) / 4000.0;
        let [p, q, r] = [[-m, y, -m], [m, y, -m], [-m, y, m]].map(DVec3::from_array);
        b.scene.triangles.push(crate::scene::Triangle { vertices: [p, q, r], material: slat, surface: 0 });
    }
    let w = window([[0.8, 0.0, 0.8], [0.8, 0.0, 0.9], [0.9, 0.0, 0.9], [0.9, 0.0, 0.8]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    let options = DaylightOptions { paths: 1, batches: 2, ..DaylightOptions::default() };
    let result = daylight_matrix::compute(&device, &b.scene, &w, ReinhartSky::new(1).unwrap(), &options, &Silent);
    match (device.loop_limit().unwrap(), result) {
        (Some(limit), Err(error)) => {
            println!("limit {limit}: {error}");
            assert!(error.to_string().contains("cut off by the device"), "{error}");
        }
        (None, Ok(_)) => {}
        (limit, result) => panic!("limit {limit:?}, but {:?}", result.map(|_| "a result")),
    }
}

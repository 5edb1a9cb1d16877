//! Points that receivers share on the surfaces: the reference, form factors, paths, choice.

use super::geometry::{Openings, ScatteredBy, SunMatrix, SunOptions, compute};
use super::shade_cells::Cells;
use super::tests::{blinds, sensors, suns};
use super::{Sun, reference};
use crate::gpu::{DEFAULT_MEMORY, Device, mutation};
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::rooms::{Builder, polygon_irradiance, sensor};
use crate::kernels::trace::{ROULETTE_WEIGHT, TraceTables};
use crate::progress::Silent;
use crate::scene::points::Sensor;
use crate::scene::{MaterialKind, Scene};
use crate::testing::{measured, short};
use glam::DVec3;

const POINTS: SunOptions = SunOptions {
    disc_samples: 4,
    paths: 1024,
    path_sets: 4,
    bounces: None,
    scattered_by: ScatteredBy::Points,
    batches: 4,
    seed: 1,
    roulette_weight: ROULETTE_WEIGHT,
    memory: DEFAULT_MEMORY,
};

fn run(device: &Device, scene: &Scene, openings: Openings<'_>, sensors: &[Sensor], suns: &[Sun], options: &SunOptions) -> SunMatrix {
    compute(device, scene, openings, sensors, suns, options, &Silent).unwrap()
}

fn at(m: &crate::matrix::Matrix<f32>, row: usize, sun: usize, c: usize) -> f64 {
    f64::from(m.at(row, sun)[c])
}

#[test]
fn shared_points_agree_with_the_reference() {
    let Some(device) = Device::for_tests("shared points on slats") else { return };
    let (mut scene, w) = blinds(0.7);
    // The reference's paths know no panes.
    scene.triangles.retain(|t| !matches!(scene.materials[t.material.0 as usize].kind, MaterialKind::Glass { .. }));
    let windows = std::slice::from_ref(&w);
    let (sensors, suns) = (sensors(), suns());
    const SAMPLES: usize = 100_000;
    // Four batches: a t-distribution of three degrees of freedom.
    const SIGMAS: f64 = 6.0;
    let mut worst = 0.0f64;
    for bounces in [2, 4] {
        let options = SunOptions { paths: 4096, bounces: Some(bounces), ..POINTS };
        let wanted: Vec<_> = sensors
            .iter()
            .flat_map(|s| suns[..3].iter().map(move |sun| (s, sun)))
            .map(|(s, sun)| reference::scattered(&scene, windows, s.position, s.direction, sun, bounces, SAMPLES, 7))
            .collect();
        let off = || {
            let m = run(&device, &scene, Openings::Windows(windows), &sensors, &suns, &options);
            let sigmas = |(i, wanted): (usize, &crate::kernels::trace::reference::Estimate)| {
                let (r, s) = (i / 3, i % 3);
                let found = at(&m.total, r, s, 0) - at(&m.direct, r, s, 0);
                let error = wanted.standard_error(SAMPLES).hypot(at(&m.scattered_error, r, s, 0).max(0.002 * found));
                (found - wanted.mean(SAMPLES)).abs() / error.max(1e-12)
            };
            wanted.iter().enumerate().map(sigmas).collect::<Vec<f64>>()
        };
        let found = off();
        println!("{bounces} bounces: {found:.1?} standard errors");
        assert!(found.iter().all(|sigmas| *sigmas < SIGMAS), "{bounces}: {found:?}");
        worst = found.iter().copied().fold(worst, f64::max);
        // Faults put into the shaders are found.
        let faults = [
            (2, "trace/sun_shade_links", "max(-dot(direction, point.facing), 0.0)", "step(0.0, -dot(direction, point.facing))"),
            (2, "trace/sun_shade_links", "(params.window_count == 0u || leaves", "(params.window_count == 0u || !leaves"),
            (2, "trace/sun_shade_links", "(cosines * point.area /", "(0.9 * cosines * point.area /"),
            (
                4,
                "trace/sun_shade_points",
                "let total = (reflected + transmitted) / f32(params.paths);",
                "let total = 0.7 * (reflected + transmitted);",
            ),
        ];
        for (at, file, from, to) in faults.into_iter().filter(|f| f.0 == bounces) {
            let found = mutation::with(file, from, to, off);
            assert!(found.iter().filter(|s| **s > SIGMAS).count() >= 2, "{at}: {file}: {to}: {found:?}");
        }
    }
    measured("shared-points-reference", &format!("within {} standard errors", short(worst)), &short(SIGMAS));
}

/// A plate lit head-on is of one radiance, so a sensor gets it by its form factor; the plate is a triangle,
/// a parallelogram and both together.
#[test]
fn a_lit_plate_is_seen_with_its_form_factor() {
    let Some(device) = Device::for_tests("a plate's form factor") else { return };
    let up = |x: f64, y: f64| DVec3::new(x, y, 1.0);
    let triangle = [up(-0.4, -0.3), up(0.7, -0.2), up(0.1, 0.6)];
    let quad = [up(0.9, -0.5), up(1.5, -0.5), up(1.6, 0.4), up(1.0, 0.4)];
    let sun = Sun::new(DVec3::NEG_Z);
    let s = sensor([0.1, 0.05, 0.0], [0.2, 0.1, 1.0]);
    let normal = s.direction.normalize();
    const BEYOND_NOISE: f64 = 2e-4;
    let mut worst = 0.0f64;
    for (what, corners) in [("triangle", vec![&triangle[..]]), ("parallelogram", vec![&quad[..]]), ("both", vec![&triangle[..], &quad[..]])]
    {
        let mut b = Builder::default();
        let white = b.grey(0.6);
        for c in &corners {
            b.quad([c[0], c[1], c[2], *c.last().unwrap()].map(|p| p.to_array()), white);
        }
        b.scene.triangles.retain(|t| (t.vertices[1] - t.vertices[0]).cross(t.vertices[2] - t.vertices[0]).length() > 1e-6);
        let options = SunOptions { paths: 1 << 14, bounces: Some(1), ..POINTS };
        let found = || {
            let m = run(&device, &b.scene, Openings::Anywhere, &[s], &[sun], &options);
            assert_eq!(m.direct.at(0, 0)[0], 0.0);
            (at(&m.total, 0, 0, 0), at(&m.scattered_error, 0, 0, 0))
        };
        let seen: f64 = corners.iter().map(|c| polygon_irradiance(c, s.position, normal)).sum();
        let expected = 0.6 / std::f64::consts::PI * sun.solid_angle() * seen;
        let (light, error) = found();
        println!("{what}: {:.6} of the form factor ± {:.6}", light / expected, error / expected);
        let off = (light / expected - 1.0).abs();
        assert!(off < 6.0 * error / expected + BEYOND_NOISE && error < 2e-3 * expected, "{what}: {light} {expected}");
        worst = worst.max(off);
        if what == "triangle" {
            let (from, to) = ("max(-dot(direction, point.facing), 0.0)", "step(0.0, -dot(direction, point.facing))");
            let (light, _) = mutation::with("trace/sun_shade_links", from, to, found);
            assert!((light / expected - 1.0).abs() > 2e-3, "{light} {expected}");
        }
        if what == "both" {
            // A black screen hides all of it, but not from a sun that shines in under it.
            let black = b.grey(0.0);
            b.quad([[-0.3, -0.3, 0.02], [0.5, -0.3, 0.02], [0.5, 0.4, 0.02], [-0.3, 0.4, 0.02]], black);
            let low = Sun::new(DVec3::new(1.0, 0.0, -0.3));
            let expected = expected * -low.direction.z;
            let hidden = || at(&run(&device, &b.scene, Openings::Anywhere, &[s], &[low.as_point()], &options).total, 0, 0, 0);
            assert_eq!(hidden(), 0.0);
            let (from, to) = ("light_passing(receiver.position, direction, distance,", "light_passing(receiver.position, direction, 1e-3,");
            assert!(mutation::with("trace/sun_shade_links", from, to, hidden) > 0.9 * expected);
        }
    }
    measured("shared-points-plate", &short(worst), &format!("6 standard errors + {}", short(BEYOND_NOISE)));
}

/// Slats that let light through, tinted panes that reflect them, windows and boxes in their place: what paths
/// find. Both are without bias, so the means of many seeds agree.
#[test]
fn shared_points_agree_with_paths_behind_panes_and_through_slats() {
    let Some(device) = Device::for_tests("shared points and paths") else { return };
    const SEEDS: u32 = 24;
    const SIGMAS: f64 = 5.0;
    let mut worst = 0.0f64;
    let translucent =
        MaterialKind::Trans { color: [0.8, 0.6, 0.7], specularity: 0.0, roughness: 0.0, transmissivity: 0.5, transmitted_specularity: 0.4 };
    for (what, kind) in [("slats", None), ("translucent slats", Some(translucent))] {
        let (mut scene, w) = blinds(0.7);
        if let Some(kind) = kind {
            scene.materials[1].kind = kind;
        }
        let shaded = [(w.clone(), vec![DVec3::new(0.4, -0.3, 0.9), DVec3::new(2.6, 0.1, 2.6)])];
        let windows = std::slice::from_ref(&w);
        let suns = suns();
        for (opening, openings) in
            [("window", Openings::Windows(windows)), ("box", Openings::Shaded(&shaded)), ("open", Openings::Anywhere)]
        {
            // Sum over the sensors, per sun and channel, of each seed.
            let sums = |by: ScatteredBy, paths: u32| -> Vec<Vec<f64>> {
                let of = |seed| {
                    let options = SunOptions { paths, scattered_by: by, bounces: Some(3), disc_samples: 1, seed, ..POINTS };
                    let m = run(&device, &scene, openings, &sensors(), &suns, &options);
                    let scattered = |i: usize| (0..4).map(|r| at(&m.total, r, i / 3, i % 3) - at(&m.direct, r, i / 3, i % 3)).sum::<f64>();
                    (0..12).map(scattered).collect()
                };
                (1..=SEEDS).map(of).collect()
            };
            let statistics = |sums: &[Vec<f64>], i: usize| {
                let n = sums.len() as f64;
                let mean = sums.iter().map(|s| s[i]).sum::<f64>() / n;
                (mean, sums.iter().map(|s| (s[i] - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
            };
            let (points, paths) = (sums(ScatteredBy::Points, 256), sums(ScatteredBy::Paths, 512));
            let sigmas: Vec<f64> = (0..12)
                .map(|i| {
                    let ((a, va), (b, vb)) = (statistics(&points, i), statistics(&paths, i));
                    (a - b) / (va + vb).sqrt().max(1e-5 * b)
                })
                .collect();
            let (a, b) = (statistics(&points, 1), statistics(&paths, 1));
            println!("{what}, {opening}: {:.4} ± {:.4} and {:.4}: {sigmas:.1?}", a.0 / b.0, a.1.sqrt() / b.0, b.1.sqrt() / b.0);
            assert!(b.0 > 0.0 && b.1.sqrt() < 0.02 * b.0);
            assert!(sigmas.iter().all(|s| s.abs() < SIGMAS), "{what}, {opening}: {sigmas:?}");
            worst = sigmas.iter().fold(worst, |worst, s| worst.max(s.abs()));
        }
    }
    measured("shared-points-paths", &short(worst), &short(SIGMAS));
}

#[test]
fn what_panes_reflect_is_counted_once() {
    let Some(device) = Device::for_tests("slats in a pane") else { return };
    // The sun lights the side of a plate that faces a pane; the sensor sees that in the pane alone.
    let mut b = Builder::default();
    let (white, glass) = (b.grey(0.8), b.material(MaterialKind::Glass { transmissivity: [0.9; 3], refraction_index: 1.52 }));
    b.quad([[-0.5, -0.5, 1.0], [0.5, -0.5, 1.0], [0.5, 0.5, 1.0], [-0.5, 0.5, 1.0]], white);
    b.quad([[-9.0, -9.0, 2.0], [9.0, -9.0, 2.0], [9.0, 9.0, 2.0], [-9.0, 9.0, 2.0]], glass);
    // Something it sees itself, or there would be no points.
    b.quad([[2.0, 0.0, 1.6], [2.1, 0.0, 1.6], [2.1, 0.1, 1.6], [2.0, 0.1, 1.6]], white);
    let sun = Sun::new(DVec3::new(0.3, 0.0, 1.0));
    let s = sensor([1.0, 0.2, 1.2], [0.0, 0.0, 1.0]);
    let sums = |by| {
        let options = SunOptions { paths: 1 << 12, scattered_by: by, bounces: Some(1), disc_samples: 1, ..POINTS };
        let m = run(&device, &b.scene, Openings::Anywhere, &[s], &[sun], &options);
        (at(&m.total, 0, 0, 0) - at(&m.direct, 0, 0, 0), at(&m.scattered_error, 0, 0, 0))
    };
    let (points, paths) = (sums(ScatteredBy::Points), sums(ScatteredBy::Paths));
    println!("in the pane {:.3e} ± {:.1e} and {:.3e} ± {:.1e}", points.0, points.1, paths.0, paths.1);
    assert!(paths.0 > 0.0 && (points.0 - paths.0).abs() < 6.0 * points.1.hypot(paths.1));
    // Without the weights of forced reflections they differ.
    let (from, to) = ("pane[1] / REFLECTED", "pane[1]");
    let fault = mutation::with("shared/sun_path", from, to, || sums(ScatteredBy::Points));
    assert!((fault.0 - points.0).abs() > 6.0 * fault.1.hypot(points.1), "{fault:?} {points:?}");
}

#[test]
fn tiles_and_memory_change_no_bit_of_shared_points() {
    let Some(device) = Device::for_tests("tiles of shared points") else { return };
    let (scene, w) = blinds(0.5);
    let many: Vec<Sensor> = (0..23).map(|i| sensor([0.3 + 0.15 * f64::from(i), 1.0, 0.8], [0.0, 0.0, 1.0])).collect();
    let options = SunOptions { paths: 8, ..POINTS };
    let all = run(&device, &scene, Openings::Windows(std::slice::from_ref(&w)), &many, &suns(), &options);
    let little =
        run(&device, &scene, Openings::Windows(std::slice::from_ref(&w)), &many, &suns(), &SunOptions { memory: 1 << 18, ..options });
    assert_eq!((&all.total, &all.scattered_error), (&little.total, &little.scattered_error));
    assert!(all.scattered_error.data().iter().any(|e| *e > 0.0));
}

fn chosen(scene: &Scene, receivers: &[([f32; 3], [f32; 3])]) -> Option<Vec<bool>> {
    let tables = TraceTables::without_windows(scene, &[DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0)]);
    let receiver = |(position, normal): &([f32; 3], [f32; 3])| {
        let p = tables.normalization.point(glam::Vec3::from(*position).as_dvec3());
        Receiver { position: p.to_array(), number: 0, normal: glam::Vec3::from(*normal).normalize().to_array(), role: 0 }
    };
    let receivers: Vec<Receiver> = receivers.iter().map(receiver).collect();
    Some(Cells::of(&tables)?.choose(&receivers, 16.0))
}

#[test]
fn receivers_share_points_where_these_can_stand_for_everything() {
    let (scene, _) = blinds(0.5);
    let before = ([1.5, 2.0, 1.5], [0.0, -1.0, 0.0]);
    // Next to a slat's upper side, and on it.
    let next = ([1.5, -0.11, 1.152], [0.0, 0.4, -1.0]);
    let on = ([1.5, -0.11, 1.15001], [0.0, -0.5, 1.0]);
    let away = ([1.5, 2.0, 1.5], [0.0, 1.0, 0.0]);
    assert_eq!(chosen(&scene, &[before, next, away]), Some(vec![true, false, true]));
    println!("on a slat: {:?}", chosen(&scene, &[on]));
    // Scatterers with a preferred direction need paths.
    for kind in [
        MaterialKind::Mirror { color: [0.8; 3] },
        MaterialKind::Metal { color: [0.8; 3], specularity: 0.9, roughness: 0.1 },
        MaterialKind::Plastic { color: [0.5; 3], specularity: 0.05, roughness: 0.0 },
        MaterialKind::Trans { color: [0.8; 3], specularity: 0.0, roughness: 0.1, transmissivity: 0.5, transmitted_specularity: 0.5 },
    ] {
        let mut scene = scene.clone();
        scene.materials[1].kind = kind;
        assert_eq!(chosen(&scene, &[before]), None);
    }
    // Of a huge ground around a small window little tells: the receiver sees it from above.
    let mut site = Builder { scene };
    let ground = site.grey(0.2);
    site.quad([[-4e3, -4e3, -9.0], [4e3, -4e3, -9.0], [4e3, 4e3, -9.0], [-4e3, 4e3, -9.0]], ground);
    let down = ([1.5, 2.0, 1.5], [0.0, -0.5, -1.0]);
    assert_eq!(chosen(&site.scene, &[down]), Some(vec![false]));
}

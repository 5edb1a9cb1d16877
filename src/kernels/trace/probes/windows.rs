//! Directions towards windows: solid angles, and uniformity.

use super::{WindowAnswer, WindowProbeParams, run};
use crate::bins::KlemsBasis;
use crate::gpu::Device;
use crate::kernels::trace::rooms::window;
use crate::kernels::trace::{TraceTables, WindowSurfaces};
use crate::scene::{Scene, Window};
use glam::DVec3;

/// Solid angle of a triangle seen from `eye`: the spherical excess of its three angles (Girard),
/// in full f64; another formula than the shader's.
fn solid_angle([a, b, c]: [DVec3; 3], eye: DVec3) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| (p - eye).normalize());
    // Angle at p between the great circles to q and r.
    let angle = |p: DVec3, q: DVec3, r: DVec3| {
        let (u, v) = (p.cross(q), p.cross(r));
        u.cross(v).length().atan2(u.dot(v))
    };
    angle(a, b, c) + angle(b, c, a) + angle(c, a, b) - std::f64::consts::PI
}

/// A rectangle from a corner and two sides.
struct Rectangle(DVec3, DVec3, DVec3);

impl Rectangle {
    fn at(&self, u: f64, v: f64) -> DVec3 {
        self.0 + self.1 * u + self.2 * v
    }

    /// Solid angle of the part u0…u1, v0…v1.
    fn solid_angle(&self, [u0, u1]: [f64; 2], [v0, v1]: [f64; 2], eye: DVec3) -> f64 {
        let [a, b, c, d] = [self.at(u0, v0), self.at(u1, v0), self.at(u1, v1), self.at(u0, v1)];
        solid_angle([a, b, c], eye) + solid_angle([a, c, d], eye)
    }

    fn window(&self, normal: DVec3) -> Window {
        let corners = [self.at(0.0, 0.0), self.at(0.0, 1.0), self.at(1.0, 1.0), self.at(1.0, 0.0)];
        window(corners.map(|p| p.to_array()), normal, DVec3::Z, KlemsBasis::Quarter)
    }
}

#[test]
fn windows_are_sampled_uniformly_in_solid_angle() {
    let Some(device) = Device::for_tests("directions towards windows") else { return };
    // A square in the south wall and a lower one in the west wall, both of about unit size.
    let rectangles = [
        Rectangle(DVec3::new(-0.5, 0.0, -0.5), DVec3::X, DVec3::Z),
        Rectangle(DVec3::new(-1.5, 1.0, -1.0), DVec3::Y * 1.2, DVec3::Z * 0.8),
    ];
    let windows = [rectangles[0].window(DVec3::Y), rectangles[1].window(DVec3::X)];
    let mut tables = TraceTables::new(&Scene::default(), &windows, WindowSurfaces::Open).unwrap();
    // The tables' own units.
    let n = tables.normalization;
    let scaled = |r: &Rectangle| Rectangle((r.0 - n.origin) * n.scale, r.1 * n.scale, r.2 * n.scale);
    let rectangles = rectangles.map(|r| scaled(&r));
    tables.features.glass = false;
    let scene = tables.upload(&device).unwrap();
    let count = 1u32 << 15;
    for (eye, tolerance) in [
        (DVec3::new(0.3, 1.5, -0.2), 1e-4),
        (DVec3::new(2.0, 0.6, 0.1), 1e-4),
        // Near the south window: almost half the sphere. Far away: sampled by area.
        (DVec3::new(0.1, 0.02, 0.1), 1e-4),
        (DVec3::new(5.0, 40.0, 8.0), 1e-3),
        (DVec3::new(300.0, 500.0, -20.0), 1e-3),
        // Behind the west window, edge-on to the south one but for a little.
        (DVec3::new(-4.0, 1e-3, 0.0), 2e-3),
    ] {
        let eye32 = n.point(eye);
        let eye = eye32.as_dvec3();
        let params = WindowProbeParams { eye: eye32.to_array(), seed: 11, count, window_count: 2, padding: [0; 2] };
        let params = device.uniform("params", &params).unwrap();
        let unanswered = WindowAnswer { weight: f32::NAN, ..WindowAnswer::default() };
        let answers = device.upload("answers", &vec![unanswered; count as usize]).unwrap();
        run(&device, &super::WINDOWS, Some(&scene), &[("params", &params), ("answers", &answers)], [count.div_ceil(64), 1, 1], None);
        // Cells of an 8 × 8 grid on each window: sums of weights against their exact solid angles.
        let cells = 8;
        let mut found = vec![0.0; 2 * cells * cells];
        for answer in device.read::<WindowAnswer>(&answers).unwrap() {
            let r = &rectangles[answer.window as usize];
            let p = eye + glam::Vec3::from_array(answer.direction).as_dvec3() * f64::from(answer.distance) - r.0;
            let (u, v) = (p.dot(r.1) / r.1.length_squared(), p.dot(r.2) / r.2.length_squared());
            let off = p.dot(r.1.cross(r.2).normalize()).abs();
            let margin = 2e-6 * eye.length().max(10.0);
            assert!(
                off < margin && (-margin..=1.0 + margin).contains(&u) && (-margin..=1.0 + margin).contains(&v),
                "{answer:?} is off its window: {u} {v} {off}"
            );
            let cell = |x: f64| ((x * cells as f64) as usize).min(cells - 1);
            found[(answer.window as usize * cells + cell(u)) * cells + cell(v)] += f64::from(answer.weight) / f64::from(count);
        }
        let (mut exact_total, mut chi) = (0.0, 0.0);
        let exact: Vec<f64> = (0..found.len())
            .map(|k| {
                let (w, i, j) = (k / (cells * cells), k / cells % cells, k % cells);
                let side = |i: usize| [i as f64 / cells as f64, (i + 1) as f64 / cells as f64];
                let seen = (eye - rectangles[w].0).dot(windows[w].frame.z) > 0.0;
                if seen { rectangles[w].solid_angle(side(i), side(j), eye) } else { 0.0 }
            })
            .collect();
        for (&exact, &found) in exact.iter().zip(&found) {
            exact_total += exact;
            assert!(exact > 0.0 || found == 0.0, "a window seen from behind was sampled");
        }
        for (exact, found) in exact.iter().zip(&found).filter(|(e, _)| **e > 0.0) {
            chi += (found - exact).powi(2) / exact * f64::from(count) / exact_total;
        }
        let total: f64 = found.iter().sum();
        println!("eye {eye}: solid angle {total:.6} of {exact_total:.6}, chi² {chi:.1}");
        assert!((total / exact_total - 1.0).abs() < tolerance, "{eye}: {total}, not {exact_total}");
        // Stratified points stay far below the 127 of independent ones.
        assert!(chi < 70.0, "{eye}: chi² {chi}");
    }
}

#[test]
fn points_of_a_window_are_uniform_in_area() {
    let Some(device) = Device::for_tests("points of windows") else { return };
    // An L of two rectangles of different size, six triangles of very different area.
    let mut w = window([[0.0; 3], [0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    let [a, b, c, d] = [[1.0, 0.0, 0.0], [1.0, 0.0, 0.5], [4.0, 0.0, 0.5], [4.0, 0.0, 0.0]].map(DVec3::from_array);
    w.triangles.extend([[a, b, c], [a, c, d], [a, a, b]]);
    let tables = TraceTables::new(&Scene::default(), std::slice::from_ref(&w), WindowSurfaces::Open).unwrap();
    let n = tables.normalization;
    let scene = tables.upload(&device).unwrap();
    let count = 1u32 << 14;
    let params =
        device.uniform("params", &WindowProbeParams { eye: [0.0, 5.0, 0.0], seed: 3, count, window_count: 1, padding: [0; 2] }).unwrap();
    let answers =
        device.upload("answers", &vec![WindowAnswer { point: [f32::NAN; 3], ..WindowAnswer::default() }; count as usize]).unwrap();
    run(&device, &super::WINDOWS, Some(&scene), &[("params", &params), ("answers", &answers)], [count.div_ceil(64), 1, 1], None);
    // Cells of 0.25 m: 32 in the first part, 24 in the second.
    let mut counts = std::collections::BTreeMap::new();
    for answer in device.read::<WindowAnswer>(&answers).unwrap() {
        let p = glam::Vec3::from_array(answer.point).as_dvec3() / n.scale + n.origin;
        let inside = (-1e-6..=1.0 + 1e-6).contains(&p.x) && (-1e-6..=2.0 + 1e-6).contains(&p.z)
            || (1.0 - 1e-6..=4.0 + 1e-6).contains(&p.x) && (-1e-6..=0.5 + 1e-6).contains(&p.z);
        assert!(inside && p.y.abs() < 1e-6, "{p}");
        *counts.entry(((p.x / 0.25).max(0.0) as u32, (p.z / 0.25).max(0.0) as u32)).or_insert(0u32) += 1;
    }
    let expected = f64::from(count) / 56.0;
    let chi: f64 = counts.values().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
    println!("{} cells, chi² {chi:.1}", counts.len());
    assert!((56..60).contains(&counts.len()) && chi < 40.0, "{} cells, chi² {chi}", counts.len());
}

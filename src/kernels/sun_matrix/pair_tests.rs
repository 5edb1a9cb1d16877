//! Direct sunlight at points behind pixels, against the f64 reference; panes that rays pass.

use super::pixels::{self, Models, PixelOptions};
use super::tests::blinds;
use super::{Openings, SunOptions, compute};
use super::{Sun, reference};
use crate::camera::{Raster, View};
use crate::gpu::{Device, mutation};
use crate::kernels::trace::rooms::{Builder, sensor};
use crate::progress::Silent;
use crate::scene::{MaterialKind, Scene};
use glam::DVec3;
use std::f64::consts::PI;

const FLOOR: f64 = 0.4;

/// Mean over the pixels of a narrow view of one point of the floor, with its standard error, for each sun.
fn narrow_picture(device: &Device, suns: &[Sun], disc_samples: u32) -> Vec<[(f64, f64); 3]> {
    let (scene, w) = blinds(0.0);
    let mut lit = Builder { scene: scene.clone() };
    let floor = lit.grey(FLOOR);
    let quad = [[0.0, 0.0, 0.01], [4.0, 0.0, 0.01], [4.0, 5.0, 0.01], [0.0, 5.0, 0.01]];
    lit.quad(quad, floor);
    let mut black = Builder { scene };
    let dark = black.grey(0.0);
    black.quad(quad, dark);
    let corners = lit.scene.triangles.iter().flat_map(|t| t.vertices).filter(|p| p.y < 0.0).collect();
    let shaded = [(w, corners)];
    let models =
        Models { lit: &lit.scene, black: &black.scene, first_shade: lit.scene.materials.len() as u32, shaded: &shaded, panes: &[] };
    let view = View::parse("-vtv -vp 1.4 2.0 1.21 -vd 0 0 -1 -vu 0 1 0 -vh 0.01 -vv 0.01").unwrap();
    let raster = Raster::fit(view.camera().unwrap(), 16, 16, 1.0).unwrap();
    let slats = SunOptions { disc_samples, batches: 16, ..SunOptions::default() }.direct();
    let options = PixelOptions { slats, panes: Default::default() };
    let pictures = pixels::compute(device, &models, &raster, suns, &options, &Silent, &mut Default::default()).unwrap();
    let mean = |c: usize, p: &pixels::SunPicture| {
        let values: Vec<f64> =
            (0..256u32).map(|i| p.pixels.iter().find(|(at, _)| *at == i).map_or(0.0, |(_, v)| f64::from(v[c]))).collect();
        let mean = values.iter().sum::<f64>() / 256.0;
        (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (255.0 * 256.0)).sqrt())
    };
    pictures.iter().map(|p| std::array::from_fn(|c| mean(c, p))).collect()
}

#[test]
fn pixels_see_suns_between_slats_as_defined() {
    let Some(device) = Device::for_tests("suns at pixels") else { return };
    let (scene, w) = blinds(0.0);
    let point = DVec3::new(1.4, 2.0, 0.01);
    // In part behind a slat's edge; in the clear; behind the house; below the window.
    let suns: Vec<Sun> =
        [[0.02, -1.0, 0.737], [0.05, -1.0, 0.87], [0.0, 1.0, 0.5], [0.0, -1.0, 0.1]].map(|d| Sun::new(DVec3::from_array(d))).to_vec();
    let expected: Vec<[f64; 3]> = suns
        .iter()
        .map(|s| reference::direct(&scene, std::slice::from_ref(&w), point, DVec3::Z, s, 40_000).map(|e| e * FLOOR / PI))
        .collect();
    let whole = suns[1].solid_angle() * FLOOR / PI;
    let share = expected[0][1] / (whole * 0.6);
    assert!((0.05..0.9).contains(&share), "the first sun is covered in part: {share}");
    let deviation = |disc_samples| {
        let mut worst = 0.0f64;
        for (found, expected) in narrow_picture(&device, &suns, disc_samples).iter().zip(&expected) {
            for c in 0..3 {
                let (mean, error) = found[c];
                worst = worst.max((mean - expected[c]).abs() / (5.0 * error + 1e-3 * expected[c] + 1e-4 * whole));
            }
        }
        worst
    };
    for disc_samples in [1, 4] {
        let found = deviation(disc_samples);
        assert!(found < 1.0, "{disc_samples} points: {found}");
    }
    for (file, from, to) in [
        ("sun_matrix/direct", "sum += cosine * passed;", "sum += passed;"),
        ("sun_matrix/direct", "cosines += max(cosine, 0.0);", "cosines += 1.0;"),
        ("sun_matrix/candidates", "listed = is_open(", "listed = !is_open("),
        ("sun_matrix/candidates", "let all = params.disc_samples + params.rim;", "let all = params.rim;"),
        ("sun_matrix/pixels", "weight * FRAC_1_PI", "weight * 0.35"),
        ("sun_matrix/pixels", "origin = leave_surface(hit, side);", "origin = leave_surface(hit, -side);"),
        ("sun_matrix/gates", "<= min(leave.x", ">= min(leave.x"),
    ] {
        let found = mutation::with(file, from, to, || deviation(4));
        assert!(found > 1.0, "{file}: {to}: {found}");
    }
}

/// What a point sun brings to a sensor behind these quads, all facing it, by the light without them.
fn through(device: &Device, quads: &[(f64, MaterialKind)]) -> [f64; 3] {
    let mut b = Builder::default();
    for (y, kind) in quads {
        let material = b.material(*kind);
        b.quad([[-1.0, *y, -1.0], [1.0, *y, -1.0], [1.0, *y, 1.0], [-1.0, *y, 1.0]], material);
    }
    let run = |scene: &Scene| {
        let sensor = [sensor([0.0, 3.0, 0.0], [0.0, -1.0, 0.0])];
        let options = SunOptions { disc_samples: 1, ..SunOptions::default() }.direct();
        let suns = [Sun::new(DVec3::NEG_Y).as_point()];
        let m = compute(device, scene, Openings::Anywhere, &sensor, &suns, &options, &Silent).unwrap();
        let v = m.direct.at(0, 0);
        [v[0], v[1], v[2]].map(f64::from)
    };
    let (with, without) = (run(&b.scene), run(&Scene::default()));
    std::array::from_fn(|c| with[c] / without[c])
}

#[test]
fn panes_weaken_light_once_each() {
    let Some(device) = Device::for_tests("panes one behind another") else { return };
    let glass = MaterialKind::Glass { transmissivity: [0.8, 0.7, 0.9], refraction_index: 1.52 };
    // The ray meets the diagonal that both triangles of a pane share.
    let one = through(&device, &[(0.0, glass)]);
    let normal = |t: f64| {
        let r = (0.52f64 / 2.52).powi(2);
        t * (1.0 - r).powi(2) / (1.0 - r * r * t * t)
    };
    for (found, t) in one.iter().zip([0.8, 0.7, 0.9]) {
        assert!((found / normal(t) - 1.0).abs() < 1e-5, "{found} of {}", normal(t));
    }
    let panes: Vec<(f64, MaterialKind)> = (0..6).map(|i| (-0.1 * f64::from(i), glass)).collect();
    for (found, one) in through(&device, &panes).iter().zip(one) {
        assert!((found / one.powi(6) - 1.0).abs() < 1e-5, "six panes");
    }
    // A film that lets a third through directly, between two panes; and a wall behind them.
    let film =
        MaterialKind::Trans { color: [1.0; 3], specularity: 0.0, roughness: 0.0, transmissivity: 0.5, transmitted_specularity: 2.0 / 3.0 };
    let three = [(0.0, glass), (-0.1, film), (-0.2, glass)];
    for (found, one) in through(&device, &three).iter().zip(one) {
        assert!((found / (one * one / 3.0) - 1.0).abs() < 1e-5, "{found} of {}", one * one / 3.0);
    }
    let wall = MaterialKind::Plastic { color: [0.5; 3], specularity: 0.0, roughness: 0.0 };
    assert_eq!(through(&device, &[(0.0, glass), (-0.1, wall)]), [0.0; 3]);
    let found = mutation::with("shared/bvh", "if !any(abs(met - distance)", "if !any(vec4<f32>(1.0)", || {
        let glass = MaterialKind::Glass { transmissivity: [0.8; 3], refraction_index: 1.52 };
        through(&device, &[(0.0, glass)])[0]
    });
    assert!((found / normal(0.8) - 1.0).abs() > 0.1, "counted twice: {found}");
}

//! Windows' images in pictures against their definition, and what pixels state where few rays find the light.

use super::tests::{Picture, picture_of, raster};
use super::*;
use crate::bins::KlemsBasis;
use crate::gpu::mutation;
use crate::kernels::trace::reference;
use crate::kernels::trace::rooms::{Builder, PlaneMirror, asymmetric, mirrored_irradiance, polish, polygon_irradiance, sensor, window};
use crate::kernels::view_matrix::mean_and_error;
use crate::kernels::view_matrix::reference::view_row;
use crate::scene::MaterialKind;
use crate::statistics::student_95;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

const PLASTIC: MaterialKind = MaterialKind::Plastic { color: [0.3; 3], specularity: 0.04, roughness: 0.0 };
const ROUGHER: MaterialKind = MaterialKind::Plastic { color: [0.3; 3], specularity: 0.04, roughness: 0.2 };
const GREY: f64 = 0.5;

/// A window in the plane y = 0, from corner to corner.
fn opening(low: [f64; 2], high: [f64; 2]) -> Window {
    let corner = |x: f64, z: f64| [x, 0.0, z];
    let corners = [corner(low[0], low[1]), corner(low[0], high[1]), corner(high[0], high[1]), corner(high[0], low[1])];
    window(corners, DVec3::Y, DVec3::Z, KlemsBasis::Quarter)
}

fn corners(w: &Window) -> [DVec3; 4] {
    let [[a, b, c], [_, _, d]] = [w.triangles[0], w.triangles[1]];
    [a, b, c, d]
}

/// The sum over all bins of each pixel in green, with its stated error.
fn sums(picture: &Picture, options: &ImageOptions) -> Vec<(f64, f64)> {
    let batches = options.batches as usize;
    let row = picture.batches.len() / picture.doubts.len() / batches;
    let sum = |values: &[f32]| values.iter().skip(1).step_by(3).map(|v| f64::from(*v)).sum::<f64>();
    let of = |(own, doubt): (&[f32], &f64)| {
        let (mean, error) = mean_and_error(&own.chunks_exact(row).map(sum).collect::<Vec<_>>());
        (mean, error.hypot(*doubt))
    };
    picture.batches.chunks_exact(batches * row).zip(&picture.doubts).map(of).collect()
}

/// What pixels show of a grey wall at y = 10 that faces a window, by what it is known to get.
struct Wall {
    scene: Scene,
    window: Window,
    raster: Raster,
    options: ImageOptions,
    wanted: Vec<f64>,
}

impl Wall {
    fn new(builder: Builder, window: Window, size: usize, options: ImageOptions, irradiance: &dyn Fn(DVec3) -> f64) -> Self {
        let mut b = builder;
        let grey = b.grey(GREY);
        b.quad([[-9.0, 10.0, -9.0], [9.0, 10.0, -9.0], [9.0, 10.0, 9.0], [-9.0, 10.0, 9.0]], grey);
        let raster = raster("-vtv -vp 1 8 1 -vd 0 1 0 -vu 0 0 1 -vh 20 -vv 20", size);
        let point = |p: usize| {
            let ray = raster.ray(p % size, p / size).unwrap();
            ray.origin + ray.direction * ((10.0 - ray.origin.y) / ray.direction.y)
        };
        let wanted = (0..raster.len()).map(|p| GREY / PI * irradiance(point(p))).collect();
        Self { scene: b.scene, window, raster, options: ImageOptions { jitter: 0.0, ..options }, wanted }
    }

    fn picture(&self, device: &Device, seed: u32) -> Vec<(f64, f64)> {
        let options = ImageOptions { seed, ..self.options };
        sums(&picture_of(device, &self.scene, std::slice::from_ref(&self.window), &self.raster, &options), &options)
    }

    /// Share of pixels over some seeds whose interval of 95 % holds the truth; the pictures' means relative to the
    /// truth, with the standard error of their mean.
    fn found(&self, device: &Device, seeds: u32) -> (f64, (f64, f64)) {
        let whole: f64 = self.wanted.iter().sum();
        let (mut held, mut means) = (0, Vec::new());
        let t = student_95(self.options.batches as usize - 1);
        // In f32 points ten metres away, in units of a small window, are known to some 1e-5.
        let rounding = 1e-4;
        for seed in 0..seeds {
            let pixels = self.picture(device, seed);
            held += pixels.iter().zip(&self.wanted).filter(|((v, e), wanted)| (v - **wanted).abs() <= t * e + rounding * **wanted).count();
            means.push(pixels.iter().map(|(v, _)| v).sum::<f64>() / whole);
        }
        (held as f64 / (seeds as usize * self.wanted.len()) as f64, mean_and_error(&means))
    }
}

/// The wall gets a fifth of its light by the image of a small window in a polished wall at x = 2, which reaches up to
/// `top`.
fn polished(top: f64, options: ImageOptions) -> Wall {
    let mut b = Builder::default();
    let plastic = b.material(PLASTIC);
    b.quad([[2.0, 0.0, 0.0], [2.0, 0.0, top], [2.0, 12.0, top], [2.0, 12.0, 0.0]], plastic);
    let w = opening([0.8, 1.4], [1.1, 1.75]);
    let lit = |p: DVec3| {
        let reflectance = polish(0.04);
        let mirror = PlaneMirror { point: DVec3::new(2.0, 0.0, 0.0), normal: DVec3::NEG_X, reflectance: &reflectance };
        let misses = |p: DVec3| (p.x - 2.0).abs() < 1e-9 && !(0.0..=top).contains(&p.z);
        let passes = |from: DVec3, to: DVec3| if misses(from) || misses(to) { 0.0 } else { 1.0 };
        let eye = sensor(p.to_array(), [0.0, -1.0, 0.0]);
        polygon_irradiance(&corners(&w), p, DVec3::NEG_Y) + mirrored_irradiance(&w, &eye, &[mirror], &passes)
    };
    Wall::new(b, w.clone(), 4, options, &lit)
}

#[test]
fn light_by_a_polished_wall_is_in_every_picture() {
    let Some(device) = Device::for_tests("images of windows in pictures") else { return };
    let options = ImageOptions { bounces: Some(1), ..ImageOptions::default() };
    // The whole image, and one of which the wall's upper edge shows half.
    for top in [2.5, 1.3] {
        let wall = polished(top, options);
        let seeds = 24;
        let compare = |seeds: u32| {
            let (share, (mean, error)) = wall.found(&device, seeds);
            println!("up to {top}: {:.1} % of pixels hold the truth, mean {mean:.5} ± {error:.5}", 100.0 * share);
            (share, (mean - 1.0).abs() / (4.0 * error + 1e-3), error)
        };
        let (share, off, error) = compare(seeds);
        assert!(off < 1.0 && error < 4e-3, "{off} {error}");
        // Three standard deviations of the binomial distribution.
        let cases = f64::from(seeds) * wall.wanted.len() as f64;
        assert!(share > 0.95 - 3.0 * (0.95 * 0.05 / cases).sqrt(), "{share}");
        for (path, from, to) in [
            ("light_paths/images", "towards - 2.0 * rise * view.mirror", "towards - 1.9 * rise * view.mirror"),
            ("light_paths/images", "passed * weight, bin", "passed * passed * weight, bin"),
            (
                "image_matrix/receivers",
                "receiver = Receiver(origin, ray.number, side, 0u)",
                "receiver = Receiver(origin, ray.number, -side, 0u)",
            ),
        ] {
            let found = mutation::with(path, from, to, || compare(8)).1;
            assert!(!(found < 1.0), "'{to}' in {path} is not found out: {found}");
        }
    }
}

/// Edges of a slit of 10 cm, along x.
const SLIT: [f64; 2] = [1.0, 1.1];

/// The wall sees a wide window through a slit.
fn slit(edges: [f64; 2], options: ImageOptions) -> Wall {
    let w = opening([-1.0, 0.0], [3.0, 3.0]);
    let lit = |p: DVec3| {
        // From there the slit is twice as wide on the window.
        let [low, high] = edges.map(|e| (2.0 * e - p.x).clamp(-1.0, 3.0));
        polygon_irradiance(&corners(&opening([low, 0.0], [high, 3.0])), p, DVec3::NEG_Y)
    };
    Wall::new(screen(edges), w.clone(), 4, options, &lit)
}

/// A black screen at y = 5 with a slit.
fn screen([left, right]: [f64; 2]) -> Builder {
    let mut b = Builder::default();
    let black = b.grey(0.0);
    b.quad([[-20.0, 5.0, -20.0], [-20.0, 5.0, 20.0], [left, 5.0, 20.0], [left, 5.0, -20.0]], black);
    b.quad([[right, 5.0, -20.0], [right, 5.0, 20.0], [20.0, 5.0, 20.0], [20.0, 5.0, -20.0]], black);
    b
}

/// The wall sees, through the slit, another one at y = 0 that a window beside the slit lights.
fn next_room(edges: [f64; 2], options: ImageOptions) -> Wall {
    let mut b = screen(edges);
    let lit_wall = b.grey(0.6);
    b.quad([[-1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 0.0, 3.0], [-1.0, 0.0, 3.0]], lit_wall);
    let corners_of = [[-1.0, 4.9, 0.0], [0.5, 4.9, 0.0], [0.5, 4.9, 3.0], [-1.0, 4.9, 3.0]];
    let w = window(corners_of, DVec3::NEG_Y, DVec3::Z, KlemsBasis::Quarter);
    let lit = |p: DVec3| {
        let [low, high] = edges.map(|e| (2.0 * e - p.x).clamp(-1.0, 3.0));
        const STEPS: [usize; 2] = [20, 60];
        let cell = (high - low) * 3.0 / (STEPS[0] * STEPS[1]) as f64;
        let at = |i: usize| {
            let (u, v) = (((i / STEPS[1]) as f64 + 0.5) / STEPS[0] as f64, ((i % STEPS[1]) as f64 + 0.5) / STEPS[1] as f64);
            let q = DVec3::new(low + (high - low) * u, 0.0, 3.0 * v);
            let to = p - q;
            0.6 / PI * polygon_irradiance(&corners(&w), q, DVec3::Y) * to.y * to.y / to.length_squared().powi(2) * cell
        };
        (0..STEPS[0] * STEPS[1]).map(at).sum()
    };
    Wall::new(b, w.clone(), 4, options, &lit)
}

#[test]
fn pixels_lit_through_a_slit_state_what_few_rays_leave_open() {
    let Some(device) = Device::for_tests("pictures through slits") else { return };
    let options = ImageOptions { bounces: Some(1), ..ImageOptions::default() };
    for (name, wall) in [("window", slit(SLIT, options)), ("next room", next_room(SLIT, ImageOptions { bounces: Some(2), ..options }))] {
        let (share, (mean, error)) = wall.found(&device, 120);
        println!("{name}: {:.1} % of pixels hold the truth, mean {mean:.4} ± {error:.4}", 100.0 * share);
        assert!((mean - 1.0).abs() < 4.0 * error && error < 0.03, "{name}: {mean} ± {error}");
        // Of four batches, most without a hit, intervals are wide; hardly any may miss.
        assert!(share > 0.935, "{name}: {share}");
    }
}

#[test]
fn a_window_is_seen_in_full_in_a_polished_wall_and_through_a_pane() {
    let Some(device) = Device::for_tests("reflected windows in pictures") else { return };
    let glass = MaterialKind::Glass { transmissivity: [0.8; 3], refraction_index: 1.52 };
    let w = opening([0.8, 1.4], [1.1, 1.75]);
    let image = DVec3::new(4.0 - 0.95, 0.0, 1.575);
    let eye = DVec3::new(1.0, 8.0, 1.2);
    let look = |at: DVec3| {
        let d = at - eye;
        raster(&format!("-vtv -vp {} {} {} -vd {} {} {} -vu 0 0 1 -vh .3 -vv .3", eye.x, eye.y, eye.z, d.x, d.y, d.z), 3)
    };
    let options = ImageOptions { bounces: Some(0), ..ImageOptions::default() };
    let mut b = Builder::default();
    let plastic = b.material(PLASTIC);
    b.quad([[2.0, 0.0, 0.0], [2.0, 0.0, 3.0], [2.0, 12.0, 3.0], [2.0, 12.0, 0.0]], plastic);
    let pane = b.material(glass);
    b.quad([[-3.0, 2.0, 0.0], [1.9, 2.0, 0.0], [1.9, 2.0, 3.0], [-3.0, 2.0, 3.0]], pane);
    let of = |at: DVec3, wanted: &dyn Fn(DVec3) -> f64| {
        let raster = look(at);
        let picture = picture_of(&device, &b.scene, std::slice::from_ref(&w), &raster, &options);
        sums(&picture, &options).into_iter().enumerate().fold(0.0f64, |worst, (p, (value, error))| {
            let wanted = wanted(raster.ray(p % 3, p / 3).unwrap().direction);
            // A pixel is a point of the image, nearly.
            // Of light between wall and pane nothing is known but by chance.
            worst.max((value / wanted - 1.0).abs()).max(if error < 0.03 { 0.0 } else { error / 0.03 })
        })
    };
    let compare = || {
        let pane = |d: DVec3| reference::glass_pane([0.8; 3], 1.52, d.y.abs()).0[0];
        let reflected = of(image, &|d| polish(0.04)(d.x.abs()) * pane(d));
        let through = of(DVec3::new(0.95, 0.0, 1.575), &pane);
        println!("reflected: off by {reflected:.1e}, through the pane {through:.1e}");
        reflected.max(through)
    };
    assert!(compare() < 5e-3);
    for (path, from, to) in [
        ("image_matrix/receivers", "weight *= parts[1];", "weight *= parts[0];"),
        ("image_matrix/receivers", "next_weight = weight * parts[0];", "next_weight = weight;"),
        ("image_matrix/receivers", "reflections > 1u) {\n                show", "reflections > 0u) {\n                show"),
    ] {
        let found = mutation::with(path, from, to, compare);
        assert!(!(found < 5e-3), "'{to}' in {path} is not found out: {found}");
    }
}

#[test]
fn a_rough_wall_that_may_show_a_window_is_doubted() {
    let Some(device) = Device::for_tests("rough walls in pictures") else { return };
    let w = opening([0.8, 1.4], [1.1, 1.75]);
    let raster = raster("-vtv -vp 1 8 1.2 -vd 1 -4 0 -vu 0 0 1 -vh 4 -vv 4", 4);
    let options = ImageOptions { bounces: Some(1), ..ImageOptions::default() };
    for (kind, doubted) in [(PLASTIC, false), (ROUGHER, true)] {
        let mut b = Builder::default();
        let material = b.material(kind);
        b.quad([[2.0, 0.0, 0.0], [2.0, 0.0, 3.0], [2.0, 12.0, 3.0], [2.0, 12.0, 0.0]], material);
        let picture = picture_of(&device, &b.scene, std::slice::from_ref(&w), &raster, &options);
        println!("{kind:?}: {:?}", picture.doubts);
        assert!(picture.doubts.iter().all(|d| (*d > 0.0) == doubted), "{kind:?}: {:?}", picture.doubts);
    }
}

#[test]
fn a_room_with_mirrors_and_panes_is_that_of_the_reference() {
    let Some(device) = Device::for_tests("pictures with specular surfaces") else { return };
    let (scene, window) = asymmetric();
    let mut b = Builder { scene };
    let mirror = b.material(MaterialKind::Mirror { color: [0.8, 0.7, 0.6] });
    let glass = b.material(MaterialKind::Glass { transmissivity: [0.8, 0.7, 0.6], refraction_index: 1.52 });
    b.quad([[3.9, 0.5, 2.5], [3.9, 2.5, 2.5], [3.9, 2.5, 0.5], [3.9, 0.5, 0.5]], mirror);
    b.quad([[0.2, 1.0, 0.3], [2.5, 1.0, 0.3], [2.5, 1.0, 2.7], [0.2, 1.0, 2.7]], glass);
    b.quad([[2.0, 0.2, 0.05], [3.9, 0.2, 0.05], [3.9, 3.0, 0.05], [2.0, 3.0, 0.05]], mirror);
    let scene = b.scene;
    // The east wall beside the mirrors, the back wall, and what the eastern mirror shows of the west wall.
    let points = [
        (DVec3::new(4.0, 4.0, 1.0), DVec3::NEG_X, 0.6),
        (DVec3::new(2.0, 5.0, 1.5), DVec3::NEG_Y, 0.6),
        (DVec3::new(0.0, 4.0, 1.6), DVec3::X, 0.1),
    ];
    let samples = 200_000;
    let rows: Vec<_> =
        points.par_iter().map(|(p, n, _)| view_row(&scene, std::slice::from_ref(&window), *p + *n * 1e-6, *n, 3, samples, 5)).collect();
    let eye = DVec3::new(2.2, 3.6, 1.5);
    let options = ImageOptions {
        bounces: Some(3),
        jitter: 0.0,
        batches: 8,
        window_samples: 1024,
        traced_every: 1,
        light_paths: 256,
        visibility_rays: 64,
        near_samples: 2048,
        ..ImageOptions::default()
    };
    let compare = || {
        let mut worst = 0.0f64;
        for ((point, _, reflectance), row) in points.iter().zip(&rows) {
            let d = *point - eye;
            let raster = raster(&format!("-vtv -vp {} {} {} -vd {} {} {} -vu 0 0 1 -vh 1 -vv 1", eye.x, eye.y, eye.z, d.x, d.y, d.z), 1);
            let picture = picture_of(&device, &scene, std::slice::from_ref(&window), &raster, &options);
            let (value, error) = sums(&picture, &options)[0];
            let scale = reflectance / PI;
            let wanted: f64 = row.iter().map(|e| e[1].mean(samples)).sum::<f64>() * scale;
            let noise = row.iter().map(|e| e[1].standard_error(samples)).fold(0.0, f64::hypot) * scale;
            println!("{point}: {value:.5} ± {error:.5}, reference {wanted:.5} ± {noise:.5}");
            assert!(error < 0.03 * wanted);
            worst = worst.max((value - wanted).abs() / (5.0 * error.hypot(noise)));
        }
        worst
    };
    assert!(compare() < 1.0);
    for (path, from, to) in [
        ("light_paths/near", "imaged = first && params.images == 1u", "imaged = first && params.images == 2u"),
        ("light_paths/images", "passed * weight, bin", "0.5 * passed * weight, bin"),
    ] {
        let found = mutation::with(path, from, to, compare);
        assert!(!(found < 1.0), "'{to}' in {path} is not found out: {found}");
    }
}

#[test]
fn pixels_behind_a_closed_screen_are_black_and_state_half_a_hit() {
    let Some(device) = Device::for_tests("pictures behind a screen") else { return };
    let options = ImageOptions { bounces: Some(1), ..ImageOptions::default() };
    let deeper = ImageOptions { bounces: Some(2), ..options };
    let (closed, open) = ([1.0; 2], [-20.0, 20.0]);
    let rays = f64::from(options.batches * options.window_samples / options.traced_every);
    let connections = f64::from(options.batches * options.visibility_rays);
    // What would arrive with nothing in the way, as that of one ray.
    let cases = [(slit(closed, options), slit(open, options), rays), (next_room(closed, deeper), next_room(open, deeper), connections)];
    let compare = || {
        cases.iter().fold(0.0f64, |worst, (wall, open, rays)| {
            let pixels = wall.picture(&device, 5);
            pixels.iter().zip(&open.wanted).fold(worst, |worst, ((value, error), whole)| {
                assert!(value.abs() < 1e-6 * error.max(1e-9), "{value} {error}");
                worst.max((error / (0.5f64.sqrt() * whole / rays) - 1.0).abs())
            })
        })
    };
    let found = compare();
    println!("stated errors differ by {found:.3}");
    // The whole is itself found by samples.
    assert!(found < 0.25, "{found}");
    for (path, from, to) in [
        ("image_matrix/direct", "chance.rays += 1.0;", "chance.rays += 2.0;"),
        ("image_matrix/direct", "chance.direct /= f32(params.window_samples);", ""),
        (
            "image_matrix/gather",
            "points[place].gathered_squares += each * each * traced;",
            "points[place].gathered_squares += each * traced;",
        ),
        ("image_matrix/gather", "let each = step * (FRAC_1_PI / 3.0", "let each = step * (FRAC_1_PI"),
    ] {
        let found = mutation::with(path, from, to, compare);
        assert!(!(found < 0.25), "'{to}' in {path} is not found out: {found}");
    }
}

#[test]
fn tiles_change_no_bit_of_mirrored_windows_and_doubts() {
    let Some(device) = Device::for_tests("tiles of pictures with mirrors") else { return };
    let options = ImageOptions { bounces: Some(2), ..ImageOptions::default() };
    let wall = polished(1.3, options);
    // Memory for five pixels.
    let small = ImageOptions { memory: 5 * (4 * 41 * 68 + 16 * 32) + 1, ..options };
    let [whole, tiled] = [options, small].map(|o| picture_of(&device, &wall.scene, std::slice::from_ref(&wall.window), &wall.raster, &o));
    assert!(whole.doubts.iter().any(|d| *d > 0.0));
    assert_eq!(whole.values, tiled.values);
    assert_eq!(whole.batches, tiled.batches);
    assert_eq!(whole.standard_error, tiled.standard_error);
    assert_eq!(whole.doubts, tiled.doubts);
}

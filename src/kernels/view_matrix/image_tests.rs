//! Images of windows in plane smooth surfaces against their definition; what few rays leave open.

use super::*;
use crate::bins::KlemsBasis;
use crate::gpu::mutation;
use crate::kernels::trace::reference::glass_pane;
use crate::kernels::trace::rooms::{Builder, PlaneMirror, mirrored_irradiance, polish, polygon_irradiance, sensor, window};
use crate::progress::Silent;
use crate::scene::MaterialKind;
use glam::DVec3;

/// A small window ten metres away, as in a long corridor.
fn far_window() -> Window {
    window([[0.8, 0.0, 1.4], [0.8, 0.0, 1.75], [1.1, 0.0, 1.75], [1.1, 0.0, 1.4]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter)
}

/// A sensor and the wall x = 2 of a material, up to the height `top`, behind a pane at x = 1.7 if there is one.
fn corridor(material: MaterialKind, pane: bool, top: f64) -> Scene {
    let mut b = Builder::default();
    let wall = b.material(material);
    b.quad([[2.0, 0.0, 0.0], [2.0, 0.0, top], [2.0, 12.0, top], [2.0, 12.0, 0.0]], wall);
    if pane {
        let glass = b.material(PANE);
        b.quad([[1.7, 3.0, 0.0], [1.7, 9.0, 0.0], [1.7, 9.0, 3.0], [1.7, 3.0, 3.0]], glass);
    }
    b.scene
}

const PANE: MaterialKind = MaterialKind::Glass { transmissivity: [0.8; 3], refraction_index: 1.52 };

struct Corridor {
    scene: Scene,
    wanted: f64,
}

fn corridors(eye: &Sensor) -> Vec<Corridor> {
    let plastic = MaterialKind::Plastic { color: [0.3; 3], specularity: 0.04, roughness: 0.0 };
    let metal = MaterialKind::Metal { color: [0.7; 3], specularity: 0.6, roughness: 0.0 };
    let mirror = MaterialKind::Mirror { color: [0.9; 3] };
    let trans =
        MaterialKind::Trans { color: [0.6; 3], specularity: 0.05, roughness: 0.0, transmissivity: 0.3, transmitted_specularity: 0.4 };
    let glass = |cosine: f64| glass_pane([0.8; 3], 1.52, cosine).1[0];
    let of: [(MaterialKind, Box<dyn Fn(f64) -> f64 + Sync>); 5] = [
        (plastic, Box::new(polish(0.04))),
        (metal, Box::new(polish(0.42))),
        (mirror, Box::new(|_| 0.9)),
        (trans, Box::new(polish(0.05))),
        (PANE, Box::new(glass)),
    ];
    let mut all = Vec::new();
    for (material, reflectance) in &of {
        for (pane, top) in [(false, 2.5), (true, 2.5), (false, 1.3)] {
            // The stronger a mirror behind a pane is, the more of the light goes between them several times.
            if pane && !matches!(material, MaterialKind::Plastic { .. }) {
                continue;
            }
            let wall = || PlaneMirror { point: DVec3::new(2.0, 0.0, 0.0), normal: DVec3::NEG_X, reflectance };
            let in_pane = || PlaneMirror { point: DVec3::new(1.7, 0.0, 0.0), normal: DVec3::NEG_X, reflectance: &glass };
            let passes = |from: DVec3, to: DVec3| {
                let on = |p: DVec3, x: f64| (p.x - x).abs() < 1e-9;
                let misses = |p: DVec3| on(p, 2.0) && p.z > top || on(p, 1.7) && !(3.0..9.0).contains(&p.y);
                if misses(from) || misses(to) {
                    return 0.0;
                }
                let at = from + (to - from) * ((1.7 - from.x) / (to.x - from.x));
                let through = pane && !on(from, 1.7) && !on(to, 1.7) && (from.x - 1.7) * (to.x - 1.7) < 0.0 && (3.0..9.0).contains(&at.y);
                if through { glass_pane([0.8; 3], 1.52, (to - from).normalize().x.abs()).0[0] } else { 1.0 }
            };
            let by = |mirrors: &[PlaneMirror<'_>]| mirrored_irradiance(&far_window(), eye, mirrors, &passes);
            let mut wanted = by(&[wall()]);
            if pane {
                // The pane's own image, and that between wall and pane, which no ray is aimed at.
                wanted += by(&[in_pane()]) + by(&[wall(), in_pane(), wall()]);
            }
            all.push(Corridor { scene: corridor(*material, pane, top), wanted });
        }
    }
    all
}

/// What arrives otherwise than directly, with its error, in the green channel.
fn imaged(device: &Device, scene: &Scene, eye: Sensor, seed: u32, first_round: bool) -> (f64, f64) {
    let options = ViewOptions { bounces: Some(1), seed, first_round, keep_batches: true, ..ViewOptions::default() };
    let v = compute(device, scene, &[far_window()], &[eye], &options, &Silent).unwrap();
    let sum = |m: &Matrix<f32>| m.data().iter().skip(1).step_by(3).map(|x| f64::from(*x)).sum::<f64>();
    mean_and_error(&v.batches.iter().map(|b| sum(&b.total) - sum(&b.direct)).collect::<Vec<_>>())
}

#[test]
fn images_in_smooth_planes_are_those_of_the_definition() {
    let Some(device) = Device::for_tests("images of windows") else { return };
    let eye = sensor([1.0, 10.0, 1.0], [0.0, -1.0, 0.0]);
    let corridors = corridors(&eye);
    let worst = |print: bool| {
        // Faults are looked for in the first wall's light alone.
        corridors.iter().take(if print { usize::MAX } else { 3 }).enumerate().fold(0.0f64, |worst, (i, c)| {
            let (found, error) = imaged(&device, &c.scene, eye, 3, false);
            // Behind a pane a path may be reflected still more often.
            let behind = if c.scene.materials.len() > 1 { 0.03 * c.wanted } else { 0.0 };
            if print {
                println!("{i}: {found:.3e} ± {error:.1e}, wanted {:.3e}", c.wanted);
            }
            if behind == 0.0 {
                assert!(!print || error < 0.03 * c.wanted, "{i}: {error} of {}", c.wanted);
            }
            worst.max((found - c.wanted).abs() / (4.0 * error + behind + 2e-3 * c.wanted))
        })
    };
    assert!(worst(true) < 1.0);
    for (path, from, to) in [
        ("light_paths/images", "towards - 2.0 * rise * view.mirror", "towards - 1.99 * rise * view.mirror"),
        ("light_paths/images", "passed * parts[1] *", "passed * parts[1] * parts[1] *"),
        ("light_paths/images", "passed *= parts[0];", "passed *= 0.5 * parts[0];"),
        ("light_paths/images", "rest * 0.99999", "rest * 1.01"),
        ("light_paths/images", "dot(to_window.direction, view.normal)", "dot(to_window.direction, view.mirror)"),
        ("light_paths/images", "triangle_plane(hit.triangle) == view.plane", "triangle_plane(hit.triangle) > 0u"),
        ("shared/bvh", "return triangle_quad(triangle, 2u).w;", "return 0u;"),
    ] {
        let found = mutation::with(path, from, to, || worst(false));
        assert!(!(found < 1.0), "'{to}' in {path} is not found out: {found}");
    }
}

#[test]
fn every_seed_sees_the_image_and_states_its_error() {
    let Some(device) = Device::for_tests("images of windows by seeds") else { return };
    let eye = sensor([1.0, 10.0, 1.0], [0.0, -1.0, 0.0]);
    let corridors = corridors(&eye);
    // The whole image, and one that the wall's upper edge cuts.
    for room in [&corridors[0], &corridors[2]] {
        let mut squares = 0.0;
        for seed in 0..12 {
            let (found, error) = imaged(&device, &room.scene, eye, seed, true);
            assert!(error > 0.0 && (found - room.wanted).abs() < 5.0 * error, "seed {seed}: {found} ± {error}, wanted {}", room.wanted);
            squares += ((found - room.wanted) / error).powi(2);
        }
        // Squares of Student's t with 7 degrees of freedom: mean 1.4, of twelve of them below 4.
        assert!(squares / 12.0 < 4.0, "{}", squares / 12.0);
    }
}

/// A window behind a black screen at y = 1 with a slit of this width from x = 2.
fn screened(slit: f64) -> (Scene, Window) {
    let mut b = Builder::default();
    let black = b.grey(0.0);
    let right = 2.0 + slit;
    b.quad([[-10.0, 1.0, -10.0], [-10.0, 1.0, 13.0], [2.0, 1.0, 13.0], [2.0, 1.0, -10.0]], black);
    b.quad([[right, 1.0, -10.0], [right, 1.0, 13.0], [14.0, 1.0, 13.0], [14.0, 1.0, -10.0]], black);
    let w = window([[0.5, 0.0, 1.0], [0.5, 0.0, 2.5], [3.5, 0.0, 2.5], [3.5, 0.0, 1.0]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    (b.scene, w)
}

#[test]
fn a_window_behind_a_wall_gives_nothing_and_what_a_gap_might_give_is_its_error() {
    let Some(device) = Device::for_tests("hidden windows") else { return };
    let (scene, w) = screened(0.0);
    let eye = sensor([2.0, 2.0, 0.8], [0.0, 0.0, 1.0]);
    for seed in 0..6 {
        let options = ViewOptions { bounces: Some(1), direct_samples: 64, batches: 2, seed, ..ViewOptions::default() };
        let v = compute(&device, &scene, std::slice::from_ref(&w), &[eye], &options, &Silent).unwrap();
        assert!(v.total.data().iter().chain(v.direct.data()).all(|x| *x == 0.0), "seed {seed}");
        // Half a hit among 128 samples.
        let mut row = vec![0.0; 41];
        unobstructed::add_unobstructed_row(&w, eye.position, DVec3::Z, &mut row);
        let wanted = 0.5f64.sqrt() / 128.0 * row.iter().sum::<f64>();
        let stated: f64 = v.standard_error.data().iter().step_by(3).map(|x| f64::from(*x)).sum();
        assert!((stated / wanted - 1.0).abs() < 1e-3, "{stated} {wanted}");
    }
    // Where nothing is in the way there is nothing to doubt, but for the rounding of f64.
    let open = compute(&device, &Scene::default(), &[w], &[eye], &ViewOptions { bounces: Some(1), ..ViewOptions::default() }, &Silent);
    assert!(open.unwrap().standard_error.data().iter().all(|x| *x < 1e-12));
}

#[test]
fn bins_that_few_rays_meet_err_as_they_state() {
    let Some(device) = Device::for_tests("bins behind a slit") else { return };
    let (scene, w) = screened(0.5);
    let eye = sensor([2.2, 2.0, 0.8], [0.0, -0.5, 1.0]);
    let run = |direct_samples: u32, batches: u32, seed: u32| {
        let options = ViewOptions { bounces: Some(1), direct_samples, batches, seed, ..ViewOptions::default() };
        compute(&device, &scene, std::slice::from_ref(&w), &[eye], &options, &Silent).unwrap()
    };
    let truth = run(1 << 16, 8, 99);
    let (mut squares, mut count, mut silent) = (0.0, 0.0, 0);
    for seed in 0..40 {
        let v = run(16, 4, seed);
        for bin in 0..41 {
            let of = |m: &Matrix<f32>| f64::from(m.at(0, bin)[0]);
            let (off, error) = (of(&v.total) - of(&truth.total), of(&v.standard_error));
            if off.abs() > 1e-4 * of(&truth.total) + 1e-6 {
                silent += usize::from(error == 0.0);
                squares += (off / error.max(1e-9)).powi(2).min(100.0);
                count += 1.0;
            }
        }
    }
    println!("{count} bins, mean z² {}, {silent} without an error", squares / count);
    // Four batches: Student's t with three degrees of freedom, whose squares have the mean 3.
    assert!(silent as f64 <= 0.01 * count && squares / count < 4.5, "{silent} of {count}, {}", squares / count);
}

#[test]
fn each_bin_behind_a_slit_has_its_own_share_of_light() {
    let Some(device) = Device::for_tests("bins behind a wide slit") else { return };
    let (scene, w) = screened(1.0);
    // To the left of the slit: the right part of the window shows, and nothing of the left.
    let eye = sensor([1.5, 2.0, 1.7], [0.0, -1.0, 0.0]);
    let (samples, bounces) = (400_000, 1);
    let reference = crate::kernels::view_matrix::reference::view_row(
        &scene,
        std::slice::from_ref(&w),
        eye.position,
        eye.direction,
        bounces,
        samples,
        5,
    );
    let compare = || {
        let options = ViewOptions { bounces: Some(bounces), direct_samples: 2048, ..ViewOptions::default() };
        let v = compute(&device, &scene, std::slice::from_ref(&w), &[eye], &options, &Silent).unwrap();
        crate::kernels::trace::comparison::agrees(&v, 0, &reference, samples)
    };
    println!("{}", compare().unwrap());
    let fault = ("window_at(to_window.window), -to_window.direction", "window_at(to_window.window), to_window.direction");
    let found = mutation::with("view_matrix/direct", fault.0, fault.1, compare);
    assert!(found.is_err(), "{found:?}");
}

#[test]
fn reflections_that_no_path_found_are_doubted() {
    let Some(device) = Device::for_tests("doubtful reflections") else { return };
    let eye = sensor([1.0, 10.0, 1.0], [0.0, -1.0, 0.0]);
    let plastic = MaterialKind::Plastic { color: [0.3; 3], specularity: 0.04, roughness: 0.0 };
    let mut scene = corridor(plastic, false, 2.5);
    let alone = imaged(&device, &scene, eye, 1, true).1;
    // A polished floor too: the image of the image in the wall may be seen in it.
    let floor = scene.triangles[0].material;
    let mut b = Builder { scene };
    b.quad([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 12.0, 0.0], [0.0, 12.0, 0.0]], floor);
    scene = b.scene;
    let [fine, wall] = [polish(0.04), polish(0.04)];
    let wall = PlaneMirror { point: DVec3::new(2.0, 0.0, 0.0), normal: DVec3::NEG_X, reflectance: &wall };
    let floor = PlaneMirror { point: DVec3::ZERO, normal: DVec3::Z, reflectance: &fine };
    let w = far_window();
    let free = |_: DVec3, _: DVec3| 1.0;
    let single = |m: PlaneMirror<'_>| mirrored_irradiance(&w, &eye, &[m], &free);
    // The floor is met first, by all of this light.
    let both = mirrored_irradiance(&w, &eye, &[PlaneMirror { ..floor }, PlaneMirror { ..wall }], &free);
    let wanted = single(wall) + single(floor) + both;
    assert!(both > 0.0);
    let mut found_none = 0;
    for seed in 0..8 {
        let (found, error) = imaged(&device, &scene, eye, seed, true);
        found_none += usize::from(found < wanted - 0.9 * both);
        assert!(
            error > 3.0 * alone && (found - wanted).abs() < 3.0 * error,
            "seed {seed}: {found} ± {error}, wanted {wanted}, of it {both}"
        );
    }
    println!("{found_none} of 8 seeds miss the image of the image, {both:.2e} of {wanted:.2e}");
}

/// The light of a slit's share of a window, exactly.
#[test]
fn a_slit_is_seen_as_wide_as_it_is() {
    let Some(device) = Device::for_tests("a slit") else { return };
    let (scene, w) = screened(0.02);
    let eye = sensor([2.01, 3.0, 1.7], [0.0, -1.0, 0.0]);
    // Seen from there the slit is 3/2 as wide on the window.
    let seen = |x: f64, z: f64| DVec3::new(2.01 + 1.5 * (x - 2.01), 0.0, z);
    let wanted = polygon_irradiance(&[seen(2.0, 1.0), seen(2.0, 2.5), seen(2.02, 2.5), seen(2.02, 1.0)], eye.position, DVec3::NEG_Y);
    let options = ViewOptions { bounces: Some(1), keep_batches: true, ..ViewOptions::default() };
    let v = compute(&device, &scene, &[w], &[eye], &options, &Silent).unwrap();
    let sum = |m: &Matrix<f32>| m.data().iter().step_by(3).map(|x| f64::from(*x)).sum::<f64>();
    let (found, error) = mean_and_error(&v.batches.iter().map(|b| sum(&b.total)).collect::<Vec<_>>());
    assert!((found - wanted).abs() < 4.0 * error && error < 0.1 * wanted, "{found} ± {error}, {wanted}");
}

#[test]
fn light_paths_that_none_of_few_rays_reach_are_doubted() {
    let Some(device) = Device::for_tests("doubtful light paths") else { return };
    // A wall that a window lights, beside a black wall without a slit and with nothing in its place.
    let room = |closed: bool| {
        let mut b = Builder::default();
        let (black, grey) = (b.grey(0.0), b.grey(0.6));
        b.quad([[-1.0, 0.5, 0.0], [-1.0, 2.5, 0.0], [-1.0, 2.5, 2.0], [-1.0, 0.5, 2.0]], grey);
        if closed {
            b.quad([[2.0, -9.0, -9.0], [2.0, 9.0, -9.0], [2.0, 9.0, 9.0], [2.0, -9.0, 9.0]], black);
        }
        b.scene
    };
    let w = window([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    let eye = sensor([3.0, 1.5, 1.0], [-0.4, 1.0, 0.0]);
    let run =
        |closed: bool, options: ViewOptions| compute(&device, &room(closed), std::slice::from_ref(&w), &[eye], &options, &Silent).unwrap();
    let green = |m: &Matrix<f32>| m.data().iter().skip(1).step_by(3).map(|x| f64::from(*x)).collect::<Vec<_>>();
    let options =
        ViewOptions { bounces: Some(2), direct_samples: 16, light_paths: 4, visibility_rays: 1, near_samples: 1, ..ViewOptions::default() };
    // What would arrive with nothing in the way, and what half a ray stands for, of a ray to each bin in eight batches.
    let open = green(&run(false, ViewOptions { light_paths: 1024, visibility_rays: 32, ..options }).total);
    let half = 0.5f64.sqrt() / 8.0 * open.iter().map(|v| v * v).sum::<f64>() / open.iter().sum::<f64>();
    let worst = || {
        (0..4).fold(0.0f64, |worst, seed| {
            let v = run(true, ViewOptions { seed, ..options });
            assert!(v.total.data().iter().all(|v| *v == 0.0));
            let ratio = green(&v.standard_error).iter().sum::<f64>() / half;
            println!("seed {seed}: {ratio:.2} of half a ray");
            // Four light paths to a bin differ, so that some rays stand for more.
            worst.max(ratio / 2.0).max(0.8 / ratio)
        })
    };
    assert!(worst() < 1.0);
    for (path, from, to) in [
        ("view_matrix/gather", "weight * weight * squares", "weight * squares"),
        ("shared/gathering", "alike += 1.0;", "alike += 4.0;"),
        ("view_matrix/gather", "weight * f32(RAYS)", "step * f32(RAYS)"),
    ] {
        let found = mutation::with(path, from, to, worst);
        assert!(!(found < 1.0), "'{to}' is not found out: {found}");
    }
}

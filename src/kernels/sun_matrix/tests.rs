use super::geometry::{Openings, SunMatrix, SunOptions, compute};
use super::pixels::{self, Models};
use super::{Sun, reference};
use crate::bins::KlemsBasis;
use crate::gpu::{Device, mutation};
use crate::kernels::trace::rooms::{Builder, sensor, window};
use crate::progress::{Progress, Silent};
use crate::scene::points::Sensor;
use crate::scene::{MaterialKind, Scene, Window};
use glam::DVec3;

/// A black room with a coloured pane and a few tilted slats before its south window, off centre.
pub(super) fn blinds(slat: f64) -> (Scene, Window) {
    let mut b = Builder::default();
    let black = b.grey(0.0);
    let slats = b.grey(slat);
    let glass = b.material(MaterialKind::Glass { transmissivity: [0.8, 0.7, 0.9], refraction_index: 1.52 });
    b.room([0.0, 0.0, 0.0], [4.0, 5.0, 3.0], black, &[2]);
    // South wall with an opening x 0.5…2.5, z 1…2.5.
    for [x0, x1, z0, z1] in [[0.0, 0.5, 0.0, 3.0], [2.5, 4.0, 0.0, 3.0], [0.5, 2.5, 0.0, 1.0], [0.5, 2.5, 2.5, 3.0]] {
        b.quad([[x0, 0.0, z0], [x0, 0.0, z1], [x1, 0.0, z1], [x1, 0.0, z0]], black);
    }
    b.quad([[0.5, -0.3, 1.0], [2.5, -0.3, 1.0], [2.5, -0.3, 2.5], [0.5, -0.3, 2.5]], glass);
    for i in 0..5 {
        let z = 1.1 + 0.3 * f64::from(i);
        b.quad([[0.5, -0.2, z], [2.5, -0.2, z], [2.5, -0.02, z + 0.1], [0.5, -0.02, z + 0.1]], slats);
    }
    let w = window([[0.5, 0.0, 1.0], [0.5, 0.0, 2.5], [2.5, 0.0, 2.5], [2.5, 0.0, 1.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    (b.scene, w)
}

pub(super) fn sensors() -> Vec<Sensor> {
    vec![
        sensor([1.4, 1.0, 1.3], [0.0, 0.0, 1.0]),
        sensor([1.5, 1.6, 0.9], [0.1, 0.0, 1.0]),
        sensor([1.3, 2.0, 1.2], [0.0, -1.0, 0.2]),
        sensor([1.0, 1.2, 1.35], [1.0, -0.3, 0.0]),
    ]
}

pub(super) fn suns() -> Vec<Sun> {
    [[0.1, -1.0, 0.37], [-0.13, -1.0, 0.52], [0.2, -1.0, 0.3], [0.05, -1.0, 0.6], [0.0, 1.0, 0.5]]
        .map(|d| Sun::new(DVec3::from_array(d)))
        .to_vec()
}

/// The largest deviation from the reference in units of what is allowed.
fn deviation(m: &SunMatrix, scene: &Scene, w: &Window) -> f64 {
    let windows = std::slice::from_ref(w);
    let mut worst = 0.0f64;
    for (r, s) in sensors().iter().enumerate() {
        for (i, sun) in suns().iter().enumerate() {
            let straight = reference::direct(scene, windows, s.position, s.direction, sun, 4000);
            for c in 0..3 {
                let allowed = 4.0 * f64::from(m.direct_error.at(r, i)[c]) + 0.002 * straight[c] + 0.03 * sun.solid_angle() / 64.0;
                worst = worst.max((f64::from(m.direct.at(r, i)[c]) - straight[c]).abs() / allowed);
            }
        }
    }
    worst
}

#[test]
fn straight_light_agrees_with_the_reference() {
    let Some(device) = Device::for_tests("straight sun matrix") else { return };
    let (scene, w) = blinds(0.5);
    let options = SunOptions { disc_samples: 256, ..SunOptions::default() }.direct();
    let m = compute(&device, &scene, Openings::Windows(std::slice::from_ref(&w)), &sensors(), &suns(), &options, &Silent).unwrap();
    let lit = m.direct.data().iter().filter(|v| **v > 0.0).count();
    let found = deviation(&m, &scene, &w);
    println!("{lit} entries lit, deviation {found:.2}");
    assert!(lit >= 12, "the suns shine in");
    assert!(found < 1.0, "{found}");
    assert_eq!(m.direct, m.total);
    assert!((0..4).all(|r| m.total.at(r, 4)[0] == 0.0), "the sun behind the house is not seen");
    // Faults put into the shader are found.
    for (file, from, to) in [
        ("trace/sun_gather", "cosines += cosine;", "cosines += 1.0;"),
        ("shared/window", "if dot(direction, window.z) >= 0.0", "if dot(direction, window.z) < 0.0"),
        ("shared/bvh", "result *= pane_transmittance(triangle, slope);", "result *= 0.9;"),
    ] {
        let m = mutation::with(file, from, to, || {
            compute(&device, &scene, Openings::Windows(std::slice::from_ref(&w)), &sensors(), &suns(), &options, &Silent).unwrap()
        });
        let found = deviation(&m, &scene, &w);
        assert!(found > 1.0, "{file}: {to}: {found}");
    }
}

/// Two wings across a court: light of a low sun would come through the far one by its two windows.
#[test]
fn the_windows_of_other_rooms_stop_the_sun() {
    let Some(device) = Device::for_tests("suns behind other windows") else { return };
    let (mut scene, w) = blinds(0.6);
    scene.triangles.retain(|t| !matches!(scene.materials[t.material.0 as usize].kind, MaterialKind::Glass { .. }));
    let far = |x: [f64; 2], y: f64, normal: DVec3| {
        let [a, b] = x;
        let corners = [[a, y, 0.0], [b, y, 0.0], [b, y, 6.0], [a, y, 6.0]];
        window(corners, normal, DVec3::Z, KlemsBasis::Full)
    };
    // The far wing's northern window, which low suns meet from outside or from its room, and one whose sun
    // is traced as well: it lets light out of its room, never in.
    let (closed, traced) = (far([-1.0, 1.8], -6.0, DVec3::NEG_Y), far([1.9, 3.0], -6.0, DVec3::NEG_Y));
    scene.windows = vec![w.clone(), closed, traced.clone()];
    let windows = [w, traced];
    let options = SunOptions { disc_samples: 256, paths: 1024, bounces: Some(2), ..SunOptions::default() };
    let run = |scene: &Scene| compute(&device, scene, Openings::Windows(&windows), &sensors(), &suns(), &options, &Silent).unwrap();
    let mut open = scene.clone();
    open.windows.clear();
    let sum = |m: &SunMatrix| m.direct.data().iter().map(|v| f64::from(*v)).sum::<f64>();
    let (m, holes) = (run(&scene), run(&open));
    println!("direct light {:.3e}; with the windows that are not traced as holes {:.3e}", sum(&m), sum(&holes));
    let worst = |m: &SunMatrix, scene: &Scene| {
        let mut worst = 0.0f64;
        for (r, s) in sensors().iter().enumerate() {
            for (i, sun) in suns().iter().enumerate() {
                let straight = reference::direct(scene, &windows, s.position, s.direction, sun, 4000)[0];
                let allowed = 4.0 * f64::from(m.direct_error.at(r, i)[0]) + 0.002 * straight + 0.03 * sun.solid_angle() / 64.0;
                worst = worst.max((f64::from(m.direct.at(r, i)[0]) - straight).abs() / allowed);
                let wanted = reference::scattered(scene, &windows[..1], s.position, s.direction, sun, 2, 20_000, 7);
                let found = f64::from(m.total.at(r, i)[0]) - f64::from(m.direct.at(r, i)[0]);
                let error = wanted.standard_error(20_000).hypot(f64::from(m.scattered_error.at(r, i)[0]).max(0.01 * found));
                worst = worst.max((found - wanted.mean(20_000)).abs() / (6.0 * error).max(1e-12));
            }
        }
        worst
    };
    let found = worst(&m, &scene);
    assert!(found < 1.0, "{found}");
    assert!(sum(&m) > 0.0 && sum(&m) < 0.8 * sum(&holes), "{} of {}", sum(&m), sum(&holes));
    let fault = mutation::with("shared/window", "if dot(direction, window.z) <= 0.0 {", "if true {", || run(&scene));
    assert!(worst(&fault, &scene) > 1.0, "light enters through a window that is traced");
}

#[test]
fn light_beside_the_window_does_not_count() {
    let Some(device) = Device::for_tests("sun matrix of a free window") else { return };
    let (_, w) = blinds(0.5);
    let nothing = Scene::default();
    let s = [sensor([1.5, 1.0, 1.2], [0.0, 0.0, 1.0])];
    let through = Sun::new(DVec3::new(0.0, -1.0, 0.8));
    let beside = Sun::new(DVec3::new(2.0, -1.0, 0.8));
    let options = SunOptions::default().direct();
    let m = compute(&device, &nothing, Openings::Windows(std::slice::from_ref(&w)), &s, &[through, beside], &options, &Silent).unwrap();
    let expected = through.solid_angle() * through.direction.z;
    assert!((f64::from(m.total.at(0, 0)[1]) / expected - 1.0).abs() < 1e-4, "{:?}", m.total.at(0, 0));
    assert_eq!(m.total.at(0, 1)[1], 0.0);
    // Without a window the open scene lets both in.
    let m = compute(&device, &nothing, Openings::Anywhere, &s, &[through, beside], &options, &Silent).unwrap();
    for (i, sun) in [through, beside].iter().enumerate() {
        assert!((f64::from(m.total.at(0, i)[1]) / (sun.solid_angle() * sun.direction.z) - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_shade_lets_light_in_beside_the_polygon_of_its_window() {
    let Some(device) = Device::for_tests("sun matrix of a shaded window") else { return };
    let (_, w) = blinds(0.5);
    let s = [sensor([1.5, 1.0, 1.2], [0.0, 0.0, 1.0])];
    // Passes z = 2.6 at the window's plane, 10 cm above it, and z = 3.3 half a metre outside.
    let above = Sun::new(DVec3::new(0.0, -1.0, 1.4));
    let below = Sun::new(DVec3::new(0.0, -1.0, -0.6));
    let options = SunOptions::default().direct();
    let run = |corners: Vec<DVec3>| {
        let shaded = [(w.clone(), corners)];
        let m = compute(&device, &Scene::default(), Openings::Shaded(&shaded), &s, &[above, below], &options, &Silent).unwrap();
        (m.total.at(0, 0)[0], m.total.at(0, 1)[0])
    };
    assert_eq!(run(vec![]), (0.0, 0.0));
    assert!(run(vec![DVec3::new(1.0, 0.1, 2.5)]).0 > 0.0, "inside the room it is within the shade's box");
    assert_eq!(run(vec![DVec3::new(1.0, -0.5, 2.5)]), (0.0, 0.0));
    assert!(run(vec![DVec3::new(1.0, -0.5, 3.4)]).0 > 0.0);
}

#[test]
fn scattered_light_agrees_with_the_reference() {
    let Some(device) = Device::for_tests("scattered sun matrix") else { return };
    let (mut scene, w) = blinds(0.7);
    // The reference's paths know no panes.
    scene.triangles.retain(|t| !matches!(scene.materials[t.material.0 as usize].kind, MaterialKind::Glass { .. }));
    let windows = std::slice::from_ref(&w);
    let (sensors, suns) = (sensors(), suns());
    let mut faults = 0;
    for (bounces, change) in [(2, false), (4, false), (4, true)] {
        let options = SunOptions { paths: 4096, bounces: Some(bounces), disc_samples: 4, ..SunOptions::default() };
        let run = || compute(&device, &scene, Openings::Windows(windows), &sensors, &suns, &options, &Silent).unwrap();
        let m = if change { mutation::with("shared/sun", "(share * cos_out)", "(share * 0.9 * cos_out)", run) } else { run() };
        for (r, s) in sensors.iter().enumerate() {
            for (i, sun) in suns.iter().enumerate().take(3) {
                const SAMPLES: usize = 100_000;
                let wanted = reference::scattered(&scene, windows, s.position, s.direction, sun, bounces, SAMPLES, 7);
                let found = f64::from(m.total.at(r, i)[0]) - f64::from(m.direct.at(r, i)[0]);
                let error = wanted.standard_error(SAMPLES).hypot(f64::from(m.scattered_error.at(r, i)[0]).max(0.005 * found));
                let sigmas = (found - wanted.mean(SAMPLES)).abs() / error.max(1e-12);
                println!("{bounces} {r} {i}: {found:.4e} {:.4e} {sigmas:.1} σ", wanted.mean(SAMPLES));
                if change {
                    faults += usize::from(sigmas > 4.0);
                } else {
                    // Four batches: a t-distribution of three degrees of freedom.
                    assert!(sigmas < 6.0, "bounces {bounces}, sensor {r}, sun {i}: {found} {}", wanted.mean(SAMPLES));
                }
            }
        }
    }
    assert!(faults >= 3, "a fault of 10 % shows: {faults}");
}

#[test]
fn a_slat_of_known_light_is_seen_with_its_form_factor() {
    let Some(device) = Device::for_tests("sunlit slat") else { return };
    // A white wall outside that fills the window's view, lit head-on: radiance ρ/π · Ω.
    let mut b = Builder::default();
    let white = b.grey(0.8);
    b.quad([[-100.0, -1.0, -100.0], [100.0, -1.0, -100.0], [100.0, -1.0, 100.0], [-100.0, -1.0, 100.0]], white);
    let w = window([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    let s = [sensor([0.5, 1.0, 0.5], [0.0, -1.0, 0.0])];
    // The sun stands behind the sensor, so its straight light does not come through the window.
    let sun = Sun::new(DVec3::Y);
    let m = compute(
        &device,
        &b.scene,
        Openings::Windows(std::slice::from_ref(&w)),
        &s,
        &[sun],
        &SunOptions { paths: 256, ..SunOptions::default() },
        &Silent,
    )
    .unwrap();
    // Configuration factor of a square of side 1, centred, at the distance of the window: four quarters. Behind
    // it, twice as far, the wall lies in the shadow of the window, which absorbs what comes from the room.
    let factor = |distance: f64| {
        let (x, u) = (0.5 / distance, (0.5f64 / distance).hypot(1.0));
        4.0 * 2.0 * (x / u) * (x / u).atan() / (2.0 * std::f64::consts::PI)
    };
    let expected = 0.8 * sun.solid_angle() * (factor(1.0) - factor(2.0));
    let found = f64::from(m.total.at(0, 0)[0]);
    assert!((found / expected - 1.0).abs() < 0.003, "{found} {expected}");
    assert_eq!(m.direct.at(0, 0)[0], 0.0);
}

#[test]
fn tiles_and_memory_change_no_bit() {
    let Some(device) = Device::for_tests("tiles of the sun matrix") else { return };
    let (scene, w) = blinds(0.5);
    let many: Vec<Sensor> = (0..23).map(|i| sensor([0.3 + 0.15 * f64::from(i), 1.0, 0.8], [0.0, 0.0, 1.0])).collect();
    let options = SunOptions { paths: 8, ..SunOptions::default() };
    let all = compute(&device, &scene, Openings::Windows(std::slice::from_ref(&w)), &many, &suns(), &options, &Silent).unwrap();
    let little = SunOptions { memory: 1 << 18, ..options };
    assert_eq!(all, compute(&device, &scene, Openings::Windows(std::slice::from_ref(&w)), &many, &suns(), &little, &Silent).unwrap());
}

/// Some drivers end long loops: what one invocation takes does not grow with what is asked for.
#[test]
fn any_number_of_points_and_paths_can_be_asked_for() {
    let Some(device) = Device::for_tests("many samples of suns") else { return };
    let (scene, w) = blinds(0.6);
    let windows = [w];
    let run = |options: SunOptions| compute(&device, &scene, Openings::Windows(&windows), &sensors(), &suns(), &options, &Silent).unwrap();
    let few = run(SunOptions { disc_samples: 256, paths: 256, ..SunOptions::default() });
    let many = run(SunOptions { disc_samples: 1 << 14, paths: 1 << 12, ..SunOptions::default() });
    let (mut found, mut worst) = (0, 0.0f32);
    for ((a, b), error) in few.total.data().iter().zip(many.total.data()).zip(few.standard_error().data()) {
        // Four batches tell an error within a factor of two; half a point of the disc is always in doubt.
        worst = worst.max((a - b).abs() / (error + 0.01 * b + 1e-9));
        found += usize::from(*b > 0.0);
    }
    println!("{found} entries, {worst:.1} standard errors");
    assert!(found >= 36 && worst < 6.0, "{found} {worst}");
    let error = |m: &SunMatrix| m.standard_error().data().iter().map(|e| e * e).sum::<f32>().sqrt();
    assert!(error(&many) < 0.4 * error(&few), "{} {}", error(&many), error(&few));
}

#[test]
fn senseless_input_is_refused_and_work_can_be_stopped() {
    let Some(device) = Device::for_tests("bad input of the sun matrix") else { return };
    let (scene, w) = blinds(0.5);
    let run = |sensors: &[Sensor], suns: &[Sun], options: &SunOptions, progress: &dyn Progress| {
        compute(&device, &scene, Openings::Windows(std::slice::from_ref(&w)), sensors, suns, options, progress).map_err(|e| e.to_string())
    };
    let good = SunOptions::default();
    let blind = [sensor([1.0, 1.0, 1.0], [0.0, 0.0, 0.0])];
    assert!(run(&blind, &suns(), &good, &Silent).unwrap_err().contains("sensor 1"));
    let wide = [Sun { direction: DVec3::Z, radius: 2.0 }];
    assert!(run(&sensors(), &wide, &good, &Silent).unwrap_err().contains("no disc"));
    let nowhere = [Sun { direction: DVec3::NAN, radius: 0.1 }];
    assert!(run(&sensors(), &nowhere, &good, &Silent).unwrap_err().contains("no disc"));
    assert!(run(&sensors(), &suns(), &SunOptions { batches: 1, ..good }, &Silent).is_err());
    let empty = run(&sensors(), &[], &good, &Silent).unwrap();
    assert_eq!((empty.total.rows(), empty.total.cols()), (4, 0));
    struct Stop;
    impl Progress for Stop {
        fn update(&self, _: &str, _: f64) {}
        fn stop_requested(&self) -> bool {
            true
        }
    }
    assert!(run(&sensors(), &suns(), &good, &Stop).is_err());
}

/// The room without what fills its window, with a grey floor, seen from its middle.
#[test]
fn a_picture_holds_the_disc_and_the_patch_that_the_sun_lights() {
    let Some(device) = Device::for_tests("suns in a picture") else { return };
    let (mut scene, w) = blinds(0.5);
    scene.triangles.retain(|t| t.material.0 == 0);
    let mut lit = Builder { scene: scene.clone() };
    let floor = lit.grey(0.4);
    lit.quad([[0.0, 0.0, 0.01], [4.0, 0.0, 0.01], [4.0, 5.0, 0.01], [0.0, 5.0, 0.01]], floor);
    let mut black = Builder { scene };
    let dark = black.grey(0.0);
    black.quad([[0.0, 0.0, 0.01], [4.0, 0.0, 0.01], [4.0, 5.0, 0.01], [0.0, 5.0, 0.01]], dark);
    let shaded = [(w, Vec::new())];
    let first_shade = lit.scene.materials.len() as u32;
    let models = Models { lit: &lit.scene, black: &black.scene, first_shade, shaded: &shaded, panes: &[] };
    let eye = DVec3::new(1.5, 2.0, 1.2);
    let view = crate::camera::View::parse("-vta -vp 1.5 2.0 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180").unwrap();
    let slats = SunOptions { disc_samples: 4, paths: 1, ..SunOptions::default() }.direct();
    let options = pixels::PixelOptions { slats, panes: Default::default() };
    // Seen through the window; and one that only lights the floor.
    let suns = [Sun::new(DVec3::new(0.1, -1.0, 0.3)), Sun::new(DVec3::new(0.0, -1.0, 1.2))];
    for size in [64, 200] {
        let raster = crate::camera::Raster::fit(view.camera().unwrap(), size, size, 1.0).unwrap();
        let pictures = pixels::compute(&device, &models, &raster, &suns, &options, &Silent, &mut Default::default()).unwrap();
        let omega = crate::glare::PixelGeometry::new(&raster).unwrap().projected_solid_angles;
        let direction = |pixel: usize| raster.ray(pixel % raster.width(), pixel / raster.width()).unwrap().direction;
        let above = |p: &&(u32, [f32; 3])| direction(p.0 as usize).z > 0.0;
        let disc: f64 = pictures[0].disc_pixels.iter().map(|(p, v)| f64::from(v[1]) * omega[*p as usize]).sum();
        // Its illuminance at the eye, wherever in a pixel it stands.
        let whole = -suns[0].direction.y * suns[0].solid_angle();
        assert!((disc / whole - 1.0).abs() < 1e-3, "{size}: {disc:e} of {whole:e}");
        assert!(pictures[1].disc_pixels.is_empty() && pictures[1].discs.is_empty(), "the high sun is hidden by the lintel");
        assert!(pictures.iter().all(|p| p.pixels.iter().filter(above).count() == 0), "the disc is beside the pixels");
        // As a source it is whole, as bright as the sun, and where the sun is.
        let [seen] = pictures[0].discs[..] else { panic!("{:?}", pictures[0].discs) };
        assert!((f64::from(seen.solid_angle) / suns[0].solid_angle() - 1.0).abs() < 1e-6 && seen.radiance == [1.0; 3]);
        assert!((DVec3::from(seen.direction.map(f64::from)) - suns[0].direction).length() < 1e-4 && seen.error < 1e-9);
        for (sun, picture) in suns.iter().zip(&pictures) {
            let bright = 0.4 / std::f64::consts::PI * sun.solid_angle() * sun.direction.z;
            // Where the floor's point sees the sun's centre through the window, well inside.
            let mut inside = 0;
            for (pixel, value) in picture.pixels.iter().filter(|p| !above(p)) {
                let d = direction(*pixel as usize);
                let point = eye + d * ((eye.z - 0.01) / -d.z);
                let at = point + sun.direction * (point.y / -sun.direction.y);
                if at.x > 0.7 && at.x < 2.3 && at.z > 1.2 && at.z < 2.3 {
                    inside += 1;
                    assert!((f64::from(value[1]) / bright - 1.0).abs() < 2e-3, "{size}: {value:?} {bright:e}");
                }
                assert!(f64::from(value[1]) <= bright * 1.001);
            }
            // The low sun's patch lies behind the camera.
            assert!(inside > size / 8 || sun.direction.z < 0.4, "{inside} pixels");
        }
    }
}

#[test]
fn a_slit_of_a_tenth_of_a_millimetre_lets_through_what_geometry_says() {
    let Some(device) = Device::for_tests("a thin slit") else { return };
    // Above the sensor a roof with a slit, the sun in the zenith. From 10 mm below, the slit shows the
    // whole disc; from 100 mm below, a strip of it.
    let (half, plate) = (0.5e-4, 50.0);
    const SIGMAS: f64 = 4.0;
    let mut worst = 0.0f64;
    let cases = [
        ("at the origin", DVec3::ZERO, 1.0),
        ("in survey coordinates", DVec3::new(583_960.4, 4_507_523.7, 31.6), 1.0),
        ("a thousand times as large", DVec3::ZERO, 1e3),
    ];
    for (what, origin, scale) in cases {
        for wide in [false, true] {
            let mut b = Builder::default();
            let black = b.grey(0.0);
            for side in [-1.0, 1.0] {
                b.quad(
                    [[side * half, -plate, 0.0], [side * plate, -plate, 0.0], [side * plate, plate, 0.0], [side * half, plate, 0.0]],
                    black,
                );
            }
            if wide {
                // A site of kilometres around it.
                b.quad([[-4e3, -4e3, -20.0], [4e3, -4e3, -20.0], [4e3, 4e3, -20.0], [-4e3, 4e3, -20.0]], black);
            }
            b.scene.triangles.iter_mut().flat_map(|t| &mut t.vertices).for_each(|p| *p = origin + *p * scale);
            let depths = [0.005, 0.1];
            let sensors: Vec<Sensor> = depths
                .iter()
                .flat_map(|depth| [(0.0, depth), (3e-3, depth)])
                .map(|(x, depth)| Sensor { position: origin + DVec3::new(x, 0.3, -depth) * scale, direction: DVec3::Z, line: 0 })
                .collect();
            let sun = Sun::new(DVec3::Z);
            let options = SunOptions { disc_samples: 512, ..SunOptions::default() }.direct();
            let m = compute(&device, &b.scene, Openings::Anywhere, &sensors, &[sun], &options, &Silent).unwrap();
            let seen = |row: usize| f64::from(m.direct.at(row, 0)[1]) / sun.solid_angle();
            // The share of a disc within `w` of its middle line, in units of its radius.
            let strip = |w: f64| if w >= 1.0 { 1.0 } else { (w * (1.0 - w * w).sqrt() + w.asin()) * std::f64::consts::FRAC_2_PI };
            for (i, depth) in depths.iter().enumerate() {
                let expected = strip(half / (depth * sun.chord()));
                let error = f64::from(m.direct_error.at(2 * i, 0)[1]) / sun.solid_angle();
                println!("{what}, wide {wide}, {depth} below: {} ± {error} of {expected}", seen(2 * i));
                assert!((seen(2 * i) - expected).abs() < SIGMAS * error + 2e-3, "{what}: {} of {expected}", seen(2 * i));
                worst = worst.max((seen(2 * i) - expected).abs() / error.max(1e-3));
                assert_eq!(seen(2 * i + 1), 0.0, "{what}: light beside the slit");
            }
        }
    }
    crate::testing::measured("thin-slit", &format!("within {} standard errors", crate::testing::short(worst)), &SIGMAS.to_string());
}

//! Suns by way of mirror-like slats: closed form, the definition in f64, Radiance.

use super::geometry::{Openings, SunMatrix, SunOptions, compute};
use super::mirrors::reflection;
use super::pane::PaneOptions;
use super::pixels::{self, Models, PixelOptions, SeenDisc, SunPicture};
use super::{Sun, reference};
use crate::bins::KlemsBasis;
use crate::camera::{Raster, View};
use crate::error::Warnings;
use crate::glare::PixelGeometry;
use crate::gpu::{Device, mutation};
use crate::kernels::trace::rooms::{Builder, sensor, window};
use crate::kernels::trace::smooth_fresnel;
use crate::progress::Silent;
use crate::scene::points::Sensor;
use crate::scene::rad::read_scene;
use crate::scene::{MaterialKind, Scene};
use crate::testing::{self, measured, percent, short};
use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;

fn run(device: &Device, scene: &Scene, openings: Openings<'_>, sensors: &[Sensor], suns: &[Sun], options: &SunOptions) -> SunMatrix {
    compute(device, scene, openings, sensors, suns, options, &Silent).unwrap()
}

#[test]
fn one_flat_mirror_throws_the_sun_where_geometry_says() {
    let Some(device) = Device::for_tests("a mirror in the sun") else { return };
    // A level mirror outside; a sensor above looks down at it, the other way to the sun.
    const SAME: f64 = 1e-4;
    let mut worst = 0.0f64;
    for smooth in [false, true] {
        let mut b = Builder::default();
        let kind = if smooth {
            MaterialKind::Metal { color: [0.8, 0.7, 0.6], specularity: 0.9, roughness: 0.0 }
        } else {
            MaterialKind::Mirror { color: [0.72, 0.63, 0.54] }
        };
        let mirror = b.material(kind);
        b.quad([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]], mirror);
        let sun = Sun::new(DVec3::new(0.0, -1.0, 1.0));
        // The image stands below: it is seen by way of (0, 0, 0), beside the mirror, and half at its rim.
        let sensors = [1.0, 3.5, 2.0].map(|y| sensor([0.2, y, 1.0], [0.0, -0.2, -1.0]));
        let m = run(
            &device,
            &b.scene,
            Openings::Anywhere,
            &sensors,
            &[sun],
            &SunOptions { disc_samples: 256, ..SunOptions::default() }.direct(),
        );
        let image = DVec3::new(sun.direction.x, sun.direction.y, -sun.direction.z);
        let whole = sun.solid_angle() * image.dot(DVec3::new(0.0, -0.2, -1.0).normalize());
        // Metals of this reflectance follow Radiance's approximation to Fresnel's formula.
        let fresnel = if smooth { smooth_fresnel(0.5f64.sqrt()) } else { 0.0 };
        for (c, reflectance) in [0.72, 0.63, 0.54].into_iter().enumerate() {
            let expected = whole * (reflectance + fresnel * (1.0 - reflectance));
            let found = f64::from(m.direct.at(0, 0)[c]);
            worst = worst.max((found / expected - 1.0).abs());
            assert!(worst < SAME, "{smooth} {c}: {found:e} {expected:e}");
            assert_eq!(m.direct.at(1, 0)[c], 0.0);
            let half = f64::from(m.direct.at(2, 0)[c]) / expected;
            assert!((half - 0.5).abs() < 0.02, "{half}");
        }
        assert_eq!(m.direct, m.total);
    }
    measured("level-mirror", &short(worst), &short(SAME));
}

/// Mirror-like slats of two tilts outside, black above and below; sensors inside look out and down.
fn louvre() -> (Scene, Vec<Sensor>, Vec<Sun>) {
    let mut b = Builder::default();
    let mirror = b.material(MaterialKind::Mirror { color: [0.8; 3] });
    let black = b.grey(0.0);
    for i in 0..4 {
        let z = 1.0 + 0.15 * f64::from(i);
        let rise = if i % 2 == 0 { 0.02 } else { 0.06 };
        // Upper face, and a lower one a little below it.
        b.quad([[0.0, -0.2, z], [1.0, -0.2, z], [1.0, 0.0, z + rise], [0.0, 0.0, z + rise]], mirror);
        b.quad([[0.0, 0.0, z + rise - 1e-3], [1.0, 0.0, z + rise - 1e-3], [1.0, -0.2, z - 1e-3], [0.0, -0.2, z - 1e-3]], mirror);
    }
    b.quad([[-3.0, 0.0, -1.0], [4.0, 0.0, -1.0], [4.0, 0.0, 0.9], [-3.0, 0.0, 0.9]], black);
    b.quad([[-3.0, 0.0, 1.6], [4.0, 0.0, 1.6], [4.0, 0.0, 4.0], [-3.0, 0.0, 4.0]], black);
    let suns = [[0.02, -1.0, 0.42], [-0.05, -1.0, 0.55], [0.0, -1.0, 0.75], [0.03, -1.0, 1.1], [-0.02, -1.0, 1.6]]
        .map(|d| Sun { radius: 0.02, ..Sun::new(DVec3::from_array(d)) });
    // Where slats throw them, and where one shines in straight.
    let mut sensors = Vec::new();
    for (slat, sun, away) in [(0, 0, 1.2), (1, 1, 0.9), (2, 2, 1.1), (2, 0, 1.4), (1, 0, 0.7), (0, 1, 1.0)] {
        let rise = if slat % 2 == 0 { 0.02 } else { 0.06 };
        let image = reflection(DVec3::new(0.0, -rise, 0.2).normalize()) * suns[sun].direction;
        let point = DVec3::new(0.5, -0.06, 1.0 + 0.15 * f64::from(slat) + rise * 0.7);
        sensors.push(Sensor { position: point - image * away, direction: image + DVec3::new(0.2, 0.0, 0.1), line: 0 });
    }
    sensors.push(sensor([0.5, 0.6, 1.05], [0.0, -1.0, 0.3]));
    (b.scene, sensors, suns.to_vec())
}

#[test]
fn mirror_slats_agree_with_the_definition() {
    let Some(device) = Device::for_tests("mirror-like slats") else { return };
    let (scene, sensors, suns) = louvre();
    let options = SunOptions { disc_samples: 128, ..SunOptions::default() }.direct();
    let pairs: Vec<_> = sensors.iter().flat_map(|s| suns.iter().map(move |sun| (s, sun))).collect();
    let wanted: Vec<[f64; 2]> = pairs
        .par_iter()
        .map(|(s, sun)| {
            let straight = reference::direct(&scene, &[], s.position, s.direction, sun, 4000)[0];
            [straight, reference::mirrored(&scene, s.position, s.direction, sun, 4e-3)]
        })
        .collect();
    const OF_MIRRORED: f64 = 0.015;
    let worst = |print: bool| {
        let m = run(&device, &scene, Openings::Anywhere, &sensors, &suns, &options);
        let mut worst = 0.0f64;
        for (i, [straight, mirrored]) in wanted.iter().enumerate() {
            let (row, sun) = (i / suns.len(), i % suns.len());
            let found = f64::from(m.direct.at(row, sun)[0]);
            let whole = suns[sun].solid_angle();
            // The oracle's grid has some hundred points in the image of a disc.
            let allowed = 4.0 * f64::from(m.direct_error.at(row, sun)[0]) + OF_MIRRORED * mirrored + 0.005 * whole;
            worst = worst.max((found - straight - mirrored).abs() / allowed);
            if print {
                println!("{row} {sun}: {:.4} straight {:.4} mirrored {:.4}", found / whole, straight / whole, mirrored / whole);
            }
        }
        worst
    };
    let found = worst(true);
    assert!(found < 1.0, "{found}");
    assert!(wanted.iter().filter(|w| w[1] > 1e-6).count() >= 6, "mirrors throw the sun in");
    for (from, to) in [
        ("result *= parts[1];", "result *= parts[1] * parts[1];"),
        ("entered && reflected && largest(rest)", "entered && largest(rest)"),
        ("largest(rest) < SAME_IMAGE", "largest(rest) < 4.0"),
    ] {
        let found = mutation::with("shared/mirrored", from, to, || worst(false));
        assert!(found > 1.0, "{to}: {found}");
    }
    measured("mirror-slats", &format!("{} of what is allowed", short(found)), &format!("{} + 4 standard errors", percent(OF_MIRRORED)));
}

#[test]
fn light_that_a_mirror_throws_onto_a_wall_reaches_those_who_see_the_wall() {
    let Some(device) = Device::for_tests("a mirror and a wall") else { return };
    // A level mirror, a white wall beside it that sees the image only, and a sensor before the wall.
    let mut b = Builder::default();
    let mirror = b.material(MaterialKind::Mirror { color: [0.9; 3] });
    let white = b.grey(0.6);
    b.quad([[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 0.0, 0.0], [-5.0, 0.0, 0.0]], mirror);
    // The front looks to the south and down; the sun, high in the south, lights it by the mirror alone.
    b.quad([[-5.0, 0.0, 0.1], [5.0, 0.0, 0.1], [5.0, -1.0, 2.1], [-5.0, -1.0, 2.1]], white);
    let sun = Sun::new(DVec3::new(0.0, -0.3, 1.0));
    let normal = DVec3::new(0.0, -2.0, -1.0).normalize();
    let s = sensor([0.0, -0.55, 1.0], [0.0, 1.0, 0.5]);
    let options = SunOptions { paths: 1024, bounces: Some(1), ..SunOptions::default() };
    let m = run(&device, &b.scene, Openings::Anywhere, &[s], &[sun], &options);
    let image = DVec3::new(sun.direction.x, sun.direction.y, -sun.direction.z);
    // Of one brightness as far as the sensor sees: 0.6/π · 0.9 · Ω cos, over nearly the half space.
    let radiance = 0.6 / std::f64::consts::PI * 0.9 * sun.solid_angle() * image.dot(normal);
    assert!(sun.direction.dot(normal) < 0.0 && image.dot(normal) > 0.0);
    let found = f64::from(m.total.at(0, 0)[0]) / (std::f64::consts::PI * radiance);
    println!("{found} of an infinite wall's light");
    assert!(found > 0.9 && found < 1.0, "{found}");
    assert_eq!(m.direct.at(0, 0)[0], 0.0);
}

/// Radiance's `mirror` surfaces show virtual sources in its direct calculation, as often as `-dr` says.
#[test]
fn point_suns_in_mirrors_are_radiances() {
    let Some(device) = Device::for_tests("Radiance's virtual suns") else { return };
    let (Some(mut oconv), Some(mut rcontrib)) = (testing::radiance("oconv"), testing::radiance("rcontrib")) else { return };
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let (scene, sensors, _) = louvre();
    let mut text = String::from("void mirror m 0 0 3 .8 .7 .6\nvoid plastic b 0 0 5 0 0 0 0 0\n");
    for (i, pair) in scene.triangles.chunks(2).enumerate() {
        let name = if matches!(scene.materials[pair[0].material.0 as usize].kind, MaterialKind::Mirror { .. }) { "m" } else { "b" };
        let [a, b, c] = pair[0].vertices;
        let corners: String = [a, b, c, a + c - b].map(|p| format!(" {} {} {}", p.x, p.y, p.z)).concat();
        text += &format!("{name} polygon p{i} 0 0 12{corners}\n");
    }
    write("scene.rad", &text);
    let suns: Vec<Sun> = (0..120)
        .map(|i| Sun::new(DVec3::new(0.3 * (f64::from(i) * 0.618).fract() - 0.15, -1.0, 0.2 + 0.013 * f64::from(i))).as_point())
        .collect();
    let lights: String = suns
        .iter()
        .enumerate()
        .map(|(i, s)| {
            let d = s.direction;
            format!("void light sol{i} 0 0 3 1e6 1e6 1e6\nsol{i} source s{i} 0 0 4 {} {} {} 0.533\n", d.x, d.y, d.z)
        })
        .collect();
    write("suns.rad", &lights);
    write("suns.mod", &(0..suns.len()).map(|i| format!("sol{i}\n")).collect::<String>());
    // Around the first sensors, so that many suns are thrown to some of them.
    let many: Vec<Sensor> = (0..40)
        .map(|i| {
            let s = sensors[i % 6];
            Sensor { position: s.position + DVec3::new(0.01, 0.013, -0.007) * i as f64, ..s }
        })
        .collect();
    let line = |s: &Sensor| {
        let (p, d) = (s.position, s.direction);
        format!("{} {} {} {} {} {}\n", p.x, p.y, p.z, d.x, d.y, d.z)
    };
    write("points", &many.iter().map(line).collect::<String>());
    write("scene.oct", "");
    std::fs::write(folder.path().join("scene.oct"), testing::output(oconv.args(["scene.rad", "suns.rad"]).current_dir(folder.path())))
        .unwrap();
    let options = format!("-h -V+ -I+ -ab 0 -dr 4 -dc 1 -dt 0 -dj 0 -y {} -faf -M suns.mod scene.oct", many.len());
    rcontrib.args(options.split(' ')).current_dir(folder.path()).stdin(std::fs::File::open(folder.path().join("points")).unwrap());
    let bytes = testing::output(&mut rcontrib);
    let theirs: Vec<f64> = bytes.chunks_exact(12).map(|v| f64::from(f32::from_le_bytes([v[0], v[1], v[2], v[3]])) / 1e6).collect();
    let scene = read_scene(&["scene.rad".into()], Path::new(folder.path()), &mut Warnings::new()).unwrap();
    let options = SunOptions { disc_samples: 1, ..SunOptions::default() }.direct();
    let all = run(&device, &scene, Openings::Anywhere, &many, &suns, &options);
    let mut straight_scene = scene.clone();
    straight_scene.materials.iter_mut().for_each(|m| m.kind = MaterialKind::Plastic { color: [0.0; 3], specularity: 0.0, roughness: 0.0 });
    let straight = run(&device, &straight_scene, Openings::Anywhere, &many, &suns, &options);
    const SAME: f64 = 1e-4;
    // Pairs at edges, in a hundred.
    const AT_EDGES: usize = 1;
    let (mut mirrored, mut off, mut worst) = (0, 0, 0.0f64);
    for row in 0..many.len() {
        for sun in 0..suns.len() {
            let (found, expected) = (f64::from(all.direct.at(row, sun)[0]), theirs[row * suns.len() + sun]);
            mirrored += usize::from(found > f64::from(straight.direct.at(row, sun)[0]) * 1.001);
            if (found - expected).abs() > SAME * suns[sun].solid_angle() {
                off += 1;
                println!("{row} {sun}: {:.4} Radiance {:.4}", found / suns[sun].solid_angle(), expected / suns[sun].solid_angle());
            } else if expected > 0.0 {
                worst = worst.max((found / expected - 1.0).abs());
            }
        }
    }
    println!("{mirrored} pairs with mirrored light; {off} differ, the others within {worst:.1e}");
    assert!(mirrored > 150 && worst < SAME);
    assert!(off * 100 <= AT_EDGES * mirrored, "{off} of {mirrored}");
    let found = format!("{mirrored} pairs with mirrored light within {}, {off} differ", short(worst));
    measured("mirrored-point-suns", &found, &format!("{}; {AT_EDGES} % of the pairs off at edges", short(SAME)));
}

/// The sun's images on a picture's pixels: the eye gets what a sensor in its place gets.
#[test]
fn a_picture_shows_the_suns_images_as_bright_as_a_sensor_has_them() {
    let Some(device) = Device::for_tests("mirror-like slats in pictures") else { return };
    let (scene, mut sensors, suns) = louvre();
    // One that sees the sun beside its image, and some that see images alone.
    sensors.drain(1..4);
    let hole = [[0.0, 0.0, 0.9], [1.0, 0.0, 0.9], [1.0, 0.0, 1.6], [0.0, 0.0, 1.6]];
    let corners = scene.triangles.iter().flat_map(|t| t.vertices).filter(|p| (0.0..=1.0).contains(&p.x)).collect();
    let shaded = [(window(hole, DVec3::Y, DVec3::Z, KlemsBasis::Full), corners)];
    let slats = SunOptions { disc_samples: 512, ..SunOptions::default() }.direct();
    let found = run(&device, &scene, Openings::Shaded(&shaded), &sensors, &suns, &slats);
    let models = Models { lit: &scene, black: &scene, first_shade: 0, shaded: &shaded, panes: &[] };
    let options = PixelOptions { slats: SunOptions { disc_samples: 4, paths: 1, ..slats }, panes: PaneOptions::default() };
    // By the pixels, or by the discs as sources of their own.
    let at_eyes = |sensors: &[Sensor], on_pixels: bool| {
        let eye = |s: &Sensor| {
            let (p, d) = (s.position, s.direction);
            let view = format!("-vta -vp {} {} {} -vd {} {} {} -vu 0 0 1 -vh 180 -vv 180", p.x, p.y, p.z, d.x, d.y, d.z);
            let raster = Raster::fit(View::parse(&view).unwrap().camera().unwrap(), 64, 64, 1.0).unwrap();
            let pictures = pixels::compute(&device, &models, &raster, &suns, &options, &Silent, &mut Default::default()).unwrap();
            let weights = PixelGeometry::new(&raster).unwrap().projected_solid_angles;
            let light = |p: &SunPicture| p.clone().with_disc().iter().map(|(k, v)| f64::from(v[0]) * weights[*k as usize]).sum::<f64>();
            let ahead = s.direction.normalize();
            let cosine = |d: &SeenDisc| DVec3::from(d.direction.map(f64::from)).dot(ahead);
            let of_discs = |p: &SunPicture| p.discs.iter().map(|d| f64::from(d.radiance[0] * d.solid_angle) * cosine(d)).sum::<f64>();
            pictures.iter().map(|p| if on_pixels { light(p) } else { of_discs(p) }).collect::<Vec<_>>()
        };
        sensors.iter().map(eye).collect::<Vec<_>>()
    };
    const OF_LIGHT: f64 = 0.01;
    let worst = |shown: &[Vec<f64>]| {
        let (mut worst, mut images) = (0.0f64, 0);
        for (row, s) in sensors.iter().enumerate().take(shown.len()) {
            for (column, sun) in suns.iter().enumerate() {
                let wanted = f64::from(found.direct.at(row, column)[0]);
                let straight = reference::direct(&scene, &[], s.position, s.direction, sun, 400)[0];
                images += usize::from(wanted > straight + 0.1 * sun.solid_angle());
                let allowed = OF_LIGHT * wanted + 4.0 * f64::from(found.direct_error.at(row, column)[0]) + 0.003 * sun.solid_angle();
                worst = worst.max((shown[row][column] - wanted).abs() / allowed);
            }
        }
        (worst, images)
    };
    let mut most = 0.0f64;
    for on_pixels in [true, false] {
        let (found_worst, images) = worst(&at_eyes(&sensors, on_pixels));
        println!("{images} sensors with images, {found_worst:.2} of what is allowed");
        assert!(found_worst < 1.0 && images >= 5, "{found_worst} {images}");
        most = most.max(found_worst);
    }
    let without =
        mutation::with("trace/sun_rays", "if MIRRORED {", "if MIRRORED && ray.origin.x > 1e9 {", || at_eyes(&sensors[..1], false));
    assert!(worst(&without).0 > 1.0);
    measured("eye-of-images", &format!("{} of what is allowed", short(most)), &format!("{} + 4 standard errors", percent(OF_LIGHT)));
}

use super::*;
use crate::bins::KlemsBasis;
use crate::kernels::trace::comparison::assert_agrees;
use crate::kernels::trace::rooms::{Builder, asymmetric, sensor, window};
use crate::kernels::view_matrix::reference::view_row;
use crate::progress::Silent;
use crate::scene::{Lobes, MaterialKind};
use glam::DVec3;
use std::f64::consts::PI;

#[test]
fn a_black_room_gives_the_analytic_configuration_factor() {
    let Some(device) = Device::for_tests("direct view matrix") else { return };
    let scene = crate::scene::Scene::default();
    // 1 m × 1 m window, 3 m in front of a vertical sensor: configuration factor 0.0341068.
    let w = window([[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    let options = ViewOptions { bounces: Some(1), direct_samples: 1024, ..ViewOptions::default() };
    // Perpendicular: corner over the point, a = 1, b = 1.5, c = 2: 0.0253442.
    let corner = window([[0.0, 2.0, 0.0], [0.0, 2.0, 1.5], [1.0, 2.0, 1.5], [1.0, 2.0, 0.0]], DVec3::NEG_Y, DVec3::Z, KlemsBasis::Full);
    for (w, s, expected) in [
        (&w, sensor([0.0, 3.0, 0.0], [0.0, -1.0, 0.0]), 0.0341068),
        (&corner, sensor([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), perpendicular(1.0, 1.5, 2.0)),
        // Far away: sampled by area.
        (&w, sensor([0.0, 300.0, 0.0], [0.0, -1.0, 0.0]), parallel(0.5, 0.5, 300.0) * 4.0),
        // 1 cm in front of the window.
        (&w, sensor([0.0, 0.01, 0.0], [0.0, -1.0, 0.0]), parallel(0.5, 0.5, 0.01) * 4.0),
    ] {
        let v = compute(&device, &scene, std::slice::from_ref(w), &[s], &options, &Silent).unwrap();
        let sum: f64 = (0..145).map(|b| f64::from(v.total.at(0, b)[0])).sum();
        println!("{sum} {} ratio {}", PI * expected, sum / (PI * expected));
        assert!((sum / (PI * expected) - 1.0).abs() < 1e-3, "{sum} {}", PI * expected);
        assert_eq!(v.total, v.direct);
    }
    // Behind the window there is nothing to see.
    let v = compute(&device, &scene, &[w], &[sensor([0.0, -1.0, 0.0], [0.0, 1.0, 0.0])], &options, &Silent).unwrap();
    assert!(v.total.data().iter().all(|&x| x == 0.0));
}

/// Configuration factor of a parallel rectangle a × b at distance c, one corner over the point.
fn parallel(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (u, v) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / u * (y / u).atan() + y / v * (x / v).atan()) / (2.0 * PI)
}

/// Configuration factor of a perpendicular rectangle: width a, height b, at distance c.
fn perpendicular(a: f64, b: f64, c: f64) -> f64 {
    let r = (b * b + c * c).sqrt();
    ((a / c).atan() - c / r * (a / r).atan()) / (2.0 * PI)
}

#[test]
fn an_asymmetric_room_agrees_with_the_reference_bin_by_bin() {
    let Some(device) = Device::for_tests("view matrix") else { return };
    let (scene, w) = asymmetric();
    let sensors =
        [sensor([1.0, 2.0, 0.8], [0.0, 0.0, 1.0]), sensor([3.6, 0.6, 0.1], [0.0, 0.2, 1.0]), sensor([0.05, 4.0, 1.5], [1.0, -0.3, 0.0])];
    for bounces in [1, 2, 4] {
        let options = ViewOptions { bounces: Some(bounces), light_paths: 256, ..ViewOptions::default() };
        let v = compute(&device, &scene, std::slice::from_ref(&w), &sensors, &options, &Silent).unwrap();
        for (row, s) in sensors.iter().enumerate() {
            let samples = 400_000;
            let r = view_row(&scene, std::slice::from_ref(&w), s.position, s.direction, bounces, samples, 7 + row as u64);
            assert_agrees(&format!("-ab {bounces}, sensor {row}"), &v, row, &r, samples);
        }
    }
}

#[test]
fn mirrors_glass_and_translucent_walls_agree_with_the_reference() {
    let Some(device) = Device::for_tests("view matrix with specular surfaces") else { return };
    let (mut scene, w) = asymmetric();
    let mut b = Builder { scene: std::mem::take(&mut scene) };
    let mirror = b.material(MaterialKind::Mirror { color: [0.8, 0.7, 0.6] });
    let glass = b.material(MaterialKind::Glass { transmissivity: [0.9, 0.8, 0.7], refraction_index: 1.52 });
    let trans = b.material(MaterialKind::Trans {
        color: [0.7, 0.7, 0.6],
        specularity: 0.05,
        roughness: 0.0,
        transmissivity: 0.5,
        transmitted_specularity: 0.3,
    });
    b.quad(
        [[3.9, 0.5, 0.5], [3.9, 2.5, 0.5], [3.9, 2.5, 2.5], [3.9, 0.5, 2.5]]
            .map(|p| p)
            .into_iter()
            .rev()
            .collect::<Vec<_>>()
            .try_into()
            .unwrap(),
        mirror,
    );
    b.quad([[0.2, 1.0, 0.3], [2.5, 1.0, 0.3], [2.5, 1.0, 2.7], [0.2, 1.0, 2.7]], glass);
    b.quad([[0.5, 3.0, 0.0], [2.5, 3.0, 0.0], [2.5, 3.0, 2.0], [0.5, 3.0, 2.0]], trans);
    let screen = b.material(MaterialKind::Lobes(Lobes {
        diffuse: [0.3, 0.2, 0.1],
        diffuse_transmitted: [0.1, 0.2, 0.1],
        specular: [0.1, 0.05, 0.1],
        specular_transmitted: [0.3, 0.4, 0.5],
        roughness: 0.0,
    }));
    b.quad([[2.7, 1.5, 0.2], [2.7, 3.5, 0.2], [2.7, 3.5, 1.8], [2.7, 1.5, 1.8]], screen);
    let scene = b.scene;
    let sensors =
        [sensor([1.0, 2.0, 0.8], [0.0, 0.0, 1.0]), sensor([1.5, 4.0, 1.0], [0.0, -1.0, 0.3]), sensor([2.5, 1.4, 1.0], [1.0, 0.0, 0.2])];
    let options = ViewOptions { bounces: Some(3), light_paths: 256, near_samples: 4096, ..ViewOptions::default() };
    let v = compute(&device, &scene, std::slice::from_ref(&w), &sensors, &options, &Silent).unwrap();
    for (row, s) in sensors.iter().enumerate() {
        let samples = 400_000;
        let r = view_row(&scene, std::slice::from_ref(&w), s.position, s.direction, 3, samples, 17 + row as u64);
        assert_agrees(&format!("specular, sensor {row}"), &v, row, &r, samples);
    }
}

#[test]
fn equal_seeds_give_equal_bits_whatever_the_tile() {
    let Some(device) = Device::for_tests("tiles of the view matrix") else { return };
    let (scene, w) = asymmetric();
    let sensors: Vec<Sensor> = (0..37).map(|i| sensor([0.1 + 0.1 * f64::from(i), 2.0, 0.8], [0.0, 0.0, 1.0])).collect();
    let options = ViewOptions { bounces: Some(3), light_paths: 8, direct_samples: 32, near_samples: 16, ..ViewOptions::default() };
    let whole = compute(&device, &scene, std::slice::from_ref(&w), &sensors, &options, &Silent).unwrap();
    let small = ViewOptions { memory: 3 * 5 * 8 * 145 * 12 + 1, ..options };
    let tiled = compute(&device, &scene, std::slice::from_ref(&w), &sensors, &small, &Silent).unwrap();
    assert_eq!(whole.total, tiled.total);
    assert_eq!(whole.standard_error, tiled.standard_error);
    let other = compute(&device, &scene, &[w], &sensors, &ViewOptions { seed: 2, ..options }, &Silent).unwrap();
    assert_ne!(whole.total, other.total);
}

#[test]
fn a_closed_white_room_fills_up_to_the_analytic_radiosity() {
    let Some(device) = Device::for_tests("furnace") else { return };
    // A sphere-like argument for a cube: all faces emit through "windows" is not possible, so one
    // face is the window and the mean over the other faces follows from energy conservation; here
    // the room is untruncated and the sum over all faces of absorbed flux equals the emitted flux.
    let reflectance = 0.8;
    let mut b = Builder::default();
    let wall = b.grey(reflectance);
    b.room([0.0; 3], [1.0; 3], wall, &[2]);
    let w = window([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    // Sensors spread over the five walls, facing inwards.
    let n = 12;
    let mut sensors = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let (u, v) = ((f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n));
            let e = 1e-4;
            sensors.push(sensor([e, u, v], [1.0, 0.0, 0.0]));
            sensors.push(sensor([1.0 - e, u, v], [-1.0, 0.0, 0.0]));
            sensors.push(sensor([u, 1.0 - e, v], [0.0, -1.0, 0.0]));
            sensors.push(sensor([u, v, e], [0.0, 0.0, 1.0]));
            sensors.push(sensor([u, v, 1.0 - e], [0.0, 0.0, -1.0]));
        }
    }
    let options = ViewOptions { light_paths: 16, direct_samples: 64, near_samples: 64, ..ViewOptions::default() };
    let v = compute(&device, &b.scene, &[w], &sensors, &options, &Silent).unwrap();
    let area = 5.0;
    let mean: f64 = v.total.data().iter().map(|&x| f64::from(x)).sum::<f64>() / (3.0 * sensors.len() as f64);
    // Emitted flux π·1 m² is absorbed by the walls, (1 − ρ) of what they receive, and by the window
    // itself, which receives what the walls send back: E_window = F-weighted, found by reciprocity:
    // flux balance π = (1 − ρ)·E·5 + E_window·1, with E_window = ρ·Σ E_i F_i. Both unknowns come
    // from the traced result: a sensor on the window measures E_window.
    let back: Vec<Sensor> = (0..n * n)
        .map(|k| sensor([(f64::from(k / n) + 0.5) / f64::from(n), 1e-4, (f64::from(k % n) + 0.5) / f64::from(n)], [0.0, 1.0, 0.0]))
        .collect();
    let w = window([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    let on_window = compute(&device, &b.scene, &[w], &back, &options, &Silent).unwrap();
    let e_window: f64 = on_window.total.data().iter().map(|&x| f64::from(x)).sum::<f64>() / (3.0 * back.len() as f64);
    let balance = (1.0 - reflectance) * mean * area + e_window;
    println!("mean wall irradiance {mean}, window {e_window}, balance {balance} of {PI}");
    // The grid of sensors integrates a field with steep edges: 1 %.
    assert!((balance / PI - 1.0).abs() < 0.01, "{balance}");
}

//! Against Radiance's two-phase daylight coefficients (`rfluxmtx` with the pane as `glass` in the scene).

use super::*;
use crate::Warnings;
use crate::kernels::view_matrix::mean_and_error;
use crate::matrix::file::read_matrix_from;
use crate::progress::Silent;
use crate::scene::rad::{read_scene, read_windows};
use crate::testing;
use glam::DVec3;
use std::fs::File;
use std::path::{Path, PathBuf};

const MATERIALS: &str =
    "void plastic wall 0 0 5 .6 .55 .5 0 0\nvoid plastic floor 0 0 5 .3 .25 .2 0 0\nvoid plastic ceiling 0 0 5 .8 .8 .8 0 0
void plastic outer 0 0 5 .4 .35 .3 0 0\nvoid plastic ground 0 0 5 .2 .22 .18 0 0\nvoid glass pane 0 0 3 .85 .9 .8\n";
const PANE: &str = "#@rfluxmtx h=kf u=+Z\npane polygon south 0 0 12  0.8 0.12 0.9  0.8 0.12 2.2  2.2 0.12 2.2  2.2 0.12 0.9\n";

/// A room 3 m × 4 m × 2.8 m whose window has a reveal of 0.3 m, an overhang and ground before it.
fn room() -> String {
    let mut text = String::new();
    let mut quad = |material: &str, corners: [[f64; 3]; 4]| {
        let numbers: String = corners.iter().flatten().map(|v| format!(" {v}")).collect();
        text += &format!("{material} polygon p{} 0 0 12{numbers}\n", text.len());
    };
    quad("floor", [[0.0, 0.3, 0.0], [3.0, 0.3, 0.0], [3.0, 4.0, 0.0], [0.0, 4.0, 0.0]]);
    quad("ceiling", [[0.0, 0.3, 2.8], [0.0, 4.0, 2.8], [3.0, 4.0, 2.8], [3.0, 0.3, 2.8]]);
    quad("wall", [[0.0, 0.3, 0.0], [0.0, 4.0, 0.0], [0.0, 4.0, 2.8], [0.0, 0.3, 2.8]]);
    quad("wall", [[3.0, 0.3, 0.0], [3.0, 0.3, 2.8], [3.0, 4.0, 2.8], [3.0, 4.0, 0.0]]);
    quad("wall", [[0.0, 4.0, 0.0], [3.0, 4.0, 0.0], [3.0, 4.0, 2.8], [0.0, 4.0, 2.8]]);
    for (y, material) in [(0.3, "wall"), (0.0, "outer")] {
        for (x0, x1, z0, z1) in [(0.0, 3.0, 0.0, 0.9), (0.0, 3.0, 2.2, 2.8), (0.0, 0.8, 0.9, 2.2), (2.2, 3.0, 0.9, 2.2)] {
            quad(material, [[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]]);
        }
    }
    quad("wall", [[0.8, 0.0, 0.9], [2.2, 0.0, 0.9], [2.2, 0.3, 0.9], [0.8, 0.3, 0.9]]);
    quad("wall", [[0.8, 0.0, 2.2], [0.8, 0.3, 2.2], [2.2, 0.3, 2.2], [2.2, 0.0, 2.2]]);
    quad("wall", [[0.8, 0.0, 0.9], [0.8, 0.3, 0.9], [0.8, 0.3, 2.2], [0.8, 0.0, 2.2]]);
    quad("wall", [[2.2, 0.0, 0.9], [2.2, 0.0, 2.2], [2.2, 0.3, 2.2], [2.2, 0.3, 0.9]]);
    quad("outer", [[0.4, -0.7, 2.4], [2.6, -0.7, 2.4], [2.6, 0.0, 2.4], [0.4, 0.0, 2.4]]);
    quad("ground", [[-15.0, -20.0, 0.0], [18.0, -20.0, 0.0], [18.0, 0.0, 0.0], [-15.0, 0.0, 0.0]]);
    text
}

/// The room in this folder, and its window.
fn read(there: &Path) -> (Scene, GlazedWindow) {
    let mut warnings = Warnings::new();
    let mut scene = read_scene(&["room.rad"].map(PathBuf::from), there, &mut warnings).unwrap();
    let window = read_windows(Path::new("pane.rad"), there, &mut warnings).unwrap().remove(0);
    scene.set_windows(std::slice::from_ref(&window), &mut warnings).unwrap();
    assert!(warnings.is_empty());
    (scene, GlazedWindow { window, pane: Pane { transmissivity: [0.85, 0.9, 0.8], refraction_index: 1.52 } })
}

/// Runs a program of Radiance in a folder.
fn run(folder: &Path, program: &str, arguments: &str, input: Option<&str>, output: &str) {
    let mut command = testing::radiance(program).unwrap();
    command.current_dir(folder).args(arguments.split_whitespace()).stdout(File::create(folder.join(output)).unwrap());
    if let Some(input) = input {
        command.stdin(File::open(folder.join(input)).unwrap());
    }
    testing::output(&mut command);
}

/// Luminous sum of a part of a row.
fn sum(row: &[f32], patches: std::ops::Range<usize>) -> f64 {
    row[patches.start * 3..patches.end * 3]
        .chunks_exact(3)
        .map(|c| 0.265 * f64::from(c[0]) + 0.67 * f64::from(c[1]) + 0.065 * f64::from(c[2]))
        .sum()
}

#[test]
fn a_room_with_reveal_and_ground_agrees_with_rfluxmtx_of_two_phases() {
    if testing::radiance("rfluxmtx").is_none() {
        return;
    }
    let Some(device) = Device::for_tests("coefficients beside Radiance's") else { return };
    // Each sensor several times, a tenth of a millimetre apart: the spread is Radiance's noise.
    const REPEATS: usize = 8;
    let places = [
        ([1.5, 1.0, 0.8], [0.0, 0.0, 1.0]),
        ([0.6, 3.4, 0.8], [0.0, 0.0, 1.0]),
        ([2.5, 2.5, 1.5], [-0.5, -1.0, 0.1]),
        ([1.5, -1.0, 1.0], [0.0, 1.0, 0.5]),
    ];
    let temporary = tempfile::tempdir().unwrap();
    let there = temporary.path();
    let write = |name: &str, text: &str| std::fs::write(there.join(name), text).unwrap();
    write("room.rad", &format!("{MATERIALS}{}", room()));
    write("pane.rad", PANE);
    let dome = |name: &str, side: &str| format!("void glow {name} 0 0 4 1 1 1 0\n{name} source {name}_dome 0 0 4 0 0 {side} 180\n");
    write("sky.rad", &format!("#@rfluxmtx u=+Y h=u\n{}\n#@rfluxmtx u=+Y h=r1\n{}", dome("below", "-1"), dome("above", "1")));
    let points: String = places
        .iter()
        .flat_map(|(p, d)| (0..REPEATS).map(move |i| format!("{} {} {} {} {} {}\n", p[0] + 1e-4 * i as f64, p[1], p[2], d[0], d[1], d[2])))
        .collect();
    write("points.txt", &points);
    run(there, "oconv", "-f room.rad pane.rad", None, "room.oct");
    let options = format!("-I+ -ab 4 -ad 8192 -lw 2e-5 -n 2 -y {} -faf - sky.rad -i room.oct", places.len() * REPEATS);
    run(there, "rfluxmtx", &options, Some("points.txt"), "C.mtx");
    let peer = read_matrix_from::<f32>(File::open(there.join("C.mtx")).unwrap()).unwrap().matrix;

    let (scene, glazed) = read(there);
    let sensors: Vec<Sensor> =
        places.iter().map(|(p, d)| Sensor { position: DVec3::from_array(*p), direction: DVec3::from_array(*d), line: 0 }).collect();
    let options = CoefficientOptions { bounces: Some(4), direct_samples: 1024, keep_batches: true, ..CoefficientOptions::default() };
    let sky = ReinhartSky::new(1).unwrap();
    let c = compute(&device, &scene, &[glazed], &sensors, sky, &options, &Silent).unwrap();
    for sensor in 0..sensors.len() {
        // The ground, the sky's lower and upper half, all.
        for part in [0..1, 1..61, 61..146, 0..146] {
            let (theirs, their_error) =
                mean_and_error(&(0..REPEATS).map(|i| sum(peer.row(sensor * REPEATS + i), part.clone())).collect::<Vec<_>>());
            let (ours, error) = mean_and_error(&c.batches.iter().map(|b| sum(b.total.row(sensor), part.clone())).collect::<Vec<_>>());
            let difference = ours / theirs - 1.0;
            println!(
                "sensor {sensor}, patches {part:?}: {ours:.5} ± {error:.1e}, Radiance {theirs:.5} ± {their_error:.1e}: {:+.2} %",
                100.0 * difference
            );
            assert!((ours - theirs).abs() < 4.0 * error.hypot(their_error) + 0.003 * theirs, "{ours} {theirs}");
        }
    }
}

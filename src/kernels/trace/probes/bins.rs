//! Bins of directions and directions of bins against the f64 tables.

use super::{BinAnswer, BinProbe, BinProbeParams, run};
use crate::bins::{KlemsBasis, ReinhartSky};
use crate::gpu::Device;
use crate::kernels::daylight_matrix::sky_rows;
use crate::kernels::trace::reference::Random;
use crate::kernels::trace::rooms::window;
use crate::kernels::trace::{TraceTables, WindowSurfaces};
use crate::scene::Scene;
use glam::DVec3;

/// How near to a limit a direction may be put on its other side, radians: atan2 is allowed
/// 4096 ulp by WGSL; Mesa's has 3e-6.
const NEAR: f64 = 1e-5;

/// Whether `bin` is that of a direction within `NEAR` of this one.
fn is_neighbour(direction: DVec3, bin: usize, bin_of: &dyn Fn(DVec3) -> usize) -> bool {
    let x = direction.any_orthonormal_vector();
    let y = direction.cross(x);
    (0..16).any(|k| {
        let angle = f64::from(k) * std::f64::consts::TAU / 16.0;
        bin_of((direction + (x * angle.cos() + y * angle.sin()) * NEAR).normalize()) == bin
    })
}

#[test]
fn directions_fall_into_the_bins_of_the_tables() {
    let Some(device) = Device::for_tests("directional bins") else { return };
    let mut random = Random(5);
    // Three windows of different basis and different orientation in one scene.
    let frames = [(DVec3::Y, DVec3::Z), (DVec3::new(0.3, -0.5, -0.7), DVec3::Y), (DVec3::NEG_Z, DVec3::new(1.0, 1.0, 0.0))];
    let windows: Vec<_> = KlemsBasis::ALL
        .into_iter()
        .zip(frames)
        .map(|(basis, (normal, up))| window([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], normal, up, basis))
        .collect();
    let tables = TraceTables::new(&Scene::default(), &windows, WindowSurfaces::Open).unwrap();
    let scene = tables.upload(&device).unwrap();
    let n = 100_000;
    for (w, subdivision) in [(0, 1), (1, 2), (2, 4), (0, 6)] {
        let (frame, basis) = (windows[w].frame, &windows[w].basis);
        let sky = ReinhartSky::new(subdivision).unwrap();
        let probes: Vec<BinProbe> = (0..n)
            .map(|i| {
                let (z, phi) = (2.0 * random.next() - 1.0, std::f64::consts::TAU * random.next());
                let r = (1.0 - z * z).sqrt();
                let mut d = DVec3::new(r * phi.cos(), r * phi.sin(), z);
                match i % 10 {
                    // Near the axes and planes of the frame, of the world, and near limits.
                    0 => d = (frame.z + d * 1e-4).normalize(),
                    1 => d = DVec3::new(d.x, d.y, d.z * 1e-5).normalize(),
                    2 => d = DVec3::new(d.x * 1e-5, d.y, d.z).normalize(),
                    3 => d = DVec3::new(d.x * 1e-6, d.y * 1e-6, 1.0).normalize(),
                    4 => d = frame.to_world(basis.direction(i % basis.len(), 1e-7, 1e-7)),
                    _ => {}
                }
                BinProbe {
                    direction: d.as_vec3().to_array(),
                    bin: (i % basis.len()) as u32,
                    random: [random.next() as f32, random.next() as f32],
                    ..BinProbe::default()
                }
            })
            .collect();
        let params = BinProbeParams {
            count: n as u32,
            window: w as u32,
            sky_rows: sky.rows().count() as u32 + 1,
            row_height: sky.row_height() as f32,
        };
        let params = device.uniform("params", &params).unwrap();
        let rows = device.upload("sky rows", &sky_rows(sky)).unwrap();
        let questions = device.upload("probes", &probes).unwrap();
        let unanswered = BinAnswer { window_bin: u32::MAX, sky_bin: u32::MAX, ..BinAnswer::default() };
        let answers = device.upload("answers", &vec![unanswered; n]).unwrap();
        let own = [("params", &params), ("sky_rows", &rows), ("probes", &questions), ("answers", &answers)];
        run(&device, &super::BINS, Some(&scene), &own, [(n as u32).div_ceil(64), 1, 1], None);
        let in_window = |d: DVec3| basis.bin_of(frame.to_local(d));
        let in_sky = |d: DVec3| sky.bin_of(d);
        let (mut differing, mut sky_differing, mut worst) = ([0, 0], [0, 0], 0.0f64);
        for (i, (probe, answer)) in probes.iter().zip(device.read::<BinAnswer>(&answers).unwrap()).enumerate() {
            // The first five of ten are near limits on purpose.
            let ordinary = usize::from(i % 10 >= 5);
            let d = glam::Vec3::from_array(probe.direction).as_dvec3();
            if in_window(d) != answer.window_bin as usize {
                differing[ordinary] += 1;
                assert!(is_neighbour(d, answer.window_bin as usize, &in_window), "{d}: bin {}, not {}", answer.window_bin, in_window(d));
            }
            if in_sky(d) != answer.sky_bin as usize {
                sky_differing[ordinary] += 1;
                assert!(is_neighbour(d, answer.sky_bin as usize, &in_sky), "{d}: patch {}, not {}", answer.sky_bin, in_sky(d));
            }
            let [u, v] = probe.random.map(f64::from);
            let expected = frame.to_world(basis.direction(probe.bin as usize, u, v));
            let off = (glam::Vec3::from_array(answer.direction).as_dvec3() - expected).length();
            worst = worst.max(off);
            // Near the pole the sine is the root of a small difference: 3e-4 at worst.
            assert!(off < 1e-3 && is_inside(answer.direction, probe.bin as usize, &in_window), "bin {}: off by {off}", probe.bin);
        }
        println!(
            "window {w}, MF:{subdivision}: {differing:?} and {sky_differing:?} of {n} on the other side of a limit (near it, ordinary); directions within {worst:.1e}"
        );
        assert!(differing[1] < 10 && sky_differing[1] < 10 + 5 * subdivision);
    }
}

fn is_inside(direction: [f32; 3], bin: usize, bin_of: &dyn Fn(DVec3) -> usize) -> bool {
    let d = glam::Vec3::from_array(direction).as_dvec3();
    bin_of(d) == bin || is_neighbour(d, bin, bin_of)
}

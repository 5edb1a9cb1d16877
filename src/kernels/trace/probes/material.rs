//! Panes of glass and diffuse directions against f64 and their distributions.

use super::{MaterialAnswer, MaterialProbe, random::sample_pair, run};
use crate::gpu::Device;
use crate::kernels::trace::reference::{Random, glass_pane};
use glam::DVec3;

fn answers(device: &Device, probes: &[MaterialProbe]) -> Vec<MaterialAnswer> {
    let questions = device.upload("probes", probes).unwrap();
    let unanswered = MaterialAnswer { transmitted: [f32::NAN; 3], direction: [f32::NAN; 3], ..MaterialAnswer::default() };
    let answers = device.upload("answers", &vec![unanswered; probes.len()]).unwrap();
    let groups = [(probes.len() as u32).div_ceil(64), 1, 1];
    let own = [("probes", &questions), ("answers", &answers)];
    run(device, &super::MATERIAL, None, &own, groups, None);
    device.read(&answers).unwrap()
}

#[test]
fn panes_transmit_and_reflect_as_fresnel_says() {
    // Radiance's manual: 88 % transmittance at normal incidence is a transmissivity of 0.96.
    let (t, r) = glass_pane([0.96; 3], 1.52, 1.0);
    assert!((t[0] - 0.88).abs() < 2e-3 && (t[0] + r[0] - 0.96).abs() < 1e-3, "{t:?} {r:?}");
    let Some(device) = Device::for_tests("panes of glass") else { return };
    let mut random = Random(1);
    let probes: Vec<MaterialProbe> = (0..20_000)
        .map(|i| MaterialProbe {
            transmissivity: std::array::from_fn(|_| if i % 50 == 0 { 1.0 } else { random.next() as f32 }),
            index: if i % 3 == 0 { 1.52 } else { 1.0 + 1.5 * random.next() as f32 },
            normal: [0.0, 0.0, 1.0],
            // Grazing incidence too.
            cosine: match i % 4 {
                0 => 1.0,
                1 => 10f64.powf(-6.0 * random.next()) as f32,
                _ => random.next().max(1e-6) as f32,
            },
            ..MaterialProbe::default()
        })
        .collect();
    let mut worst = 0.0f64;
    for (probe, answer) in probes.iter().zip(answers(&device, &probes)) {
        let (t, r) = glass_pane(probe.transmissivity.map(f64::from), f64::from(probe.index), f64::from(probe.cosine));
        for c in 0..3 {
            let (found_t, found_r) = (f64::from(answer.transmitted[c]), f64::from(answer.reflected[c]));
            worst = worst.max((found_t - t[c]).abs()).max((found_r - r[c]).abs());
            // Grazing: the difference of 1 and a cosine of 1e-5 has few digits.
            assert!(
                (found_t - t[c]).abs() < 5e-5 && (found_r - r[c]).abs() < 5e-5,
                "{probe:?}: {found_t} {found_r}, not {} {}",
                t[c],
                r[c]
            );
            assert!(found_t >= 0.0 && found_r >= 0.0 && found_t + found_r < 1.0 + 1e-5, "{probe:?}: {answer:?}");
        }
    }
    println!("largest difference of a transmittance or reflectance: {worst:.1e}");
}

#[test]
fn diffuse_directions_are_distributed_as_the_cosine() {
    let Some(device) = Device::for_tests("diffuse directions") else { return };
    let tilted = DVec3::new(-0.3, 0.8, -0.4).normalize();
    for (k, normal) in [DVec3::Z, DVec3::NEG_Z, DVec3::X, tilted, DVec3::new(1e-4, -1e-4, -1.0).normalize()].into_iter().enumerate() {
        let n = 1u32 << 14;
        let probes: Vec<MaterialProbe> = (0..n)
            .map(|i| MaterialProbe {
                index: 1.5,
                cosine: 1.0,
                normal: normal.as_vec3().to_array(),
                random: sample_pair(i, k as u32, 3).map(|bits| bits as f32 / (1 << 24) as f32),
                ..MaterialProbe::default()
            })
            .collect();
        // Equal shares of sin² and of the azimuth are equally likely.
        let (rings, sectors) = (9, 15);
        let mut counts = vec![0u32; rings * sectors];
        let x = normal.any_orthonormal_vector();
        for answer in answers(&device, &probes) {
            let d = glam::Vec3::from_array(answer.direction).as_dvec3();
            assert!((d.length() - 1.0).abs() < 1e-6 && d.dot(normal) > -1e-6, "{d}");
            let sin2 = (1.0 - d.dot(normal).powi(2)).clamp(0.0, 1.0 - 1e-12);
            let azimuth = d.dot(normal.cross(x)).atan2(d.dot(x)) / std::f64::consts::TAU + 0.5;
            counts[(sin2 * rings as f64) as usize * sectors + (azimuth * sectors as f64) as usize % sectors] += 1;
        }
        let expected = f64::from(n) / (rings * sectors) as f64;
        let chi: f64 = counts.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
        println!("normal {normal}: chi² {chi:.1} of {} cells", rings * sectors);
        // The points are stratified: far below what independent ones would give.
        assert!(chi < 60.0, "{normal}: {chi}");
    }
}

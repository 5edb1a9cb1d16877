//! Cosines and sines.

use super::run;
use crate::gpu::Device;
use std::f64::consts::TAU;

/// `shared/circle.wgsl`, operation by operation.
fn circle(turns: f32) -> [f32; 2] {
    let quarters = (4.0 * turns + 0.5).floor();
    let x = TAU as f32 * (turns - 0.25 * quarters);
    let x2 = x * x;
    let cosine = 1.0 - x2 * (1.0 / 2.0 - x2 * (1.0 / 24.0 - x2 * (1.0 / 720.0 - x2 * (1.0 / 40320.0))));
    let sine = x - x * x2 * (1.0 / 6.0 - x2 * (1.0 / 120.0 - x2 * (1.0 / 5040.0 - x2 * (1.0 / 362_880.0))));
    match (quarters as i32).rem_euclid(4) {
        0 => [cosine, sine],
        1 => [-sine, cosine],
        2 => [-cosine, -sine],
        _ => [sine, -cosine],
    }
}

#[test]
fn cosines_and_sines_are_those_of_the_host_on_every_driver() {
    let Some(device) = Device::for_tests("cosines and sines") else { return };
    // All that random numbers give, the limits of the quarters, and some more turns to either side.
    let grid = (0..1u32 << 16).map(|i| i as f32 / 65536.0);
    let limits = (-40..=40).flat_map(|k| [-1e-6, -6e-8, 0.0, 6e-8, 1e-6].map(|d| k as f32 * 0.125 + d));
    let turns: Vec<f32> = grid.chain(limits).chain([1e-30, -1e-12, 1000.3, -4095.999]).collect();
    let asked = device.upload("turns", &turns).unwrap();
    let found = device.upload("found", &vec![[f32::NAN; 2]; turns.len()]).unwrap();
    run(&device, &super::CIRCLE, None, &[("turns", &asked), ("found", &found)], [(turns.len() as u32).div_ceil(64), 1, 1], None);
    let (mut worst, mut different) = (0.0f64, 0);
    for (turns, found) in turns.iter().zip(device.read::<[f32; 2]>(&found).unwrap()) {
        let (sine, cosine) = (f64::from(*turns) * TAU).sin_cos();
        let error = (f64::from(found[0]) - cosine).abs().max((f64::from(found[1]) - sine).abs());
        assert!(error < 1.2e-7, "{turns} turns: {found:?}, not {cosine} {sine}");
        worst = worst.max(error);
        // A driver may fuse a product and a sum: then the last bit differs.
        let host = circle(*turns);
        different += usize::from(found != host);
        assert!(found.iter().zip(host).all(|(a, b)| (a - b).abs() <= 1.2e-7), "{turns} turns: {found:?}, on the host {host:?}");
    }
    println!("largest error {worst:.2e}; {different} of {} differ from the host", turns.len());
}

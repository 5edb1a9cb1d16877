//! The shaders' random points, bit by bit.

use super::{RandomProbeParams, run};
use crate::gpu::Device;

/// Owen scramble by Vegdahl's improved Laine-Karras hash, on plain (not reversed) bits.
fn scramble(value: u32, seed: u32) -> u32 {
    let mut v = value.reverse_bits();
    v ^= v.wrapping_mul(0x3d20_adea);
    v = v.wrapping_add(seed);
    v = v.wrapping_mul((seed >> 16) | 1);
    v ^= v.wrapping_mul(0x0552_6c56);
    v ^= v.wrapping_mul(0x53a2_2864);
    v.reverse_bits()
}

fn hash(x: u32) -> u32 {
    let mut h = (x ^ (x >> 16)).wrapping_mul(0x21f0_aaad);
    h = (h ^ (h >> 15)).wrapping_mul(0xd35a_2d97);
    h ^ (h >> 15)
}

fn combine(a: u32, b: u32) -> u32 {
    hash(a ^ b.wrapping_mul(0x9e37_79b9).wrapping_add(0x85eb_ca6b))
}

/// First two dimensions of Sobol's sequence from their direction numbers.
fn sobol(index: u32) -> [u32; 2] {
    let (mut direction, mut second) = (1u32 << 31, 0);
    for bit in 0..32 {
        if index >> bit & 1 == 1 {
            second ^= direction;
        }
        direction ^= direction >> 1;
    }
    [index.reverse_bits(), second]
}

/// The pair of `shared/random.wgsl`, as multiples of 2⁻²⁴.
pub(crate) fn sample_pair(index: u32, pair: u32, seed: u32) -> [u32; 2] {
    let stream = combine(seed, pair);
    let [first, second] = sobol(scramble(index, stream));
    [scramble(first, combine(stream, 1)) >> 8, scramble(second, combine(stream, 2)) >> 8]
}

#[test]
fn the_shader_draws_the_same_bits() {
    let Some(device) = Device::for_tests("random numbers") else { return };
    for (seed, pair, first) in [(1, 0, 0), (0xffff_ffff, 5, 1 << 20), (0x1234_5678, 900, 0xffff_ff00)] {
        let count = 256u32;
        let params = RandomProbeParams { seed, dimension_pair: pair, first, count };
        let params = device.uniform("params", &params).unwrap();
        let points = device.upload("points", &vec![[f32::NAN; 2]; count as usize]).unwrap();
        run(&device, &super::RANDOM, None, &[("params", &params), ("points", &points)], [count.div_ceil(64), 1, 1], None);
        for (i, found) in device.read::<[f32; 2]>(&points).unwrap().into_iter().enumerate() {
            let expected = sample_pair(first.wrapping_add(i as u32), pair, seed).map(|bits| bits as f32 / (1 << 24) as f32);
            assert_eq!(found.map(f32::to_bits), expected.map(f32::to_bits), "point {i} of pair {pair}");
            assert!(found.iter().all(|v| (0.0..1.0).contains(v)));
        }
    }
}

#[test]
fn every_aligned_power_of_two_of_points_is_stratified_in_all_elementary_intervals() {
    for (seed, pair) in [(1, 0), (2, 7), (0xdead_beef, 100)] {
        for (first, bits) in [(0u32, 6u32), (0, 10), (1 << 10, 10), (3 << 8, 8)] {
            for split in 0..=bits {
                let mut seen = vec![false; 1 << bits];
                for i in first..first + (1 << bits) {
                    let [x, y] = sample_pair(i, pair, seed);
                    let cell = ((x >> (24 - split)) << (bits - split)) | (y >> (24 - (bits - split)));
                    assert!(!seen[cell as usize], "two points in one interval: seed {seed}, {first}…, 2^{split} columns");
                    seen[cell as usize] = true;
                }
            }
        }
    }
}

#[test]
fn pairs_batches_and_seeds_are_independent() {
    // Chi-square of a 16 × 16 grid with coordinates of different pairs, seeds and neighbours.
    let n = 1u32 << 16;
    let coordinates: [(&str, &dyn Fn(u32) -> [u32; 2]); 4] = [
        ("x of pairs 0 and 1", &|i| [sample_pair(i, 0, 1)[0], sample_pair(i, 1, 1)[0]]),
        ("y of pairs 3 and 6", &|i| [sample_pair(i, 3, 1)[1], sample_pair(i, 6, 1)[1]]),
        ("x of streams 1 and 2", &|i| [sample_pair(i, 0, combine(combine(9, 1), 4))[0], sample_pair(i, 0, combine(combine(9, 2), 4))[0]]),
        ("x of neighbouring bins", &|i| [sample_pair(i, 0, combine(9, 1))[0], sample_pair(i, 0, combine(9, 2))[0]]),
    ];
    for (what, pair) in coordinates {
        let mut counts = [0u32; 256];
        for i in 0..n {
            let [x, y] = pair(i);
            counts[((x >> 20) * 16 + (y >> 20)) as usize] += 1;
        }
        let expected = f64::from(n) / 256.0;
        let chi: f64 = counts.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
        println!("{what}: chi² {chi:.0} of 255 cells");
        // Both coordinates are stratified, which lowers chi² a little (225 degrees of freedom).
        assert!(chi < 255.0 + 6.0 * (2.0f64 * 255.0).sqrt(), "{what}: {chi}");
    }
}

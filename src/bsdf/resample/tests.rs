//! Changing the basis keeps what it should.

use super::*;
use crate::bins::KlemsBasis;
use crate::bsdf::{Bsdf, read_from, write};
use crate::error::Warnings;
use crate::testing;

fn basis(b: KlemsBasis) -> AngleBasis {
    AngleBasis::from(b)
}

/// A peak and an asymmetric remainder.
fn sample(b: KlemsBasis) -> KlemsMatrix {
    let basis = basis(b);
    KlemsMatrix::from_fn(&basis, |o, i| {
        let remainder = ((o * 145 + i) as f64 * 0.618_034).fract().powi(6) * 0.2;
        remainder + if o == i { 0.3 / basis.projected_solid_angle(i) } else { 0.0 }
    })
}

#[test]
fn klems_to_tree_and_other_bases_keeps_hemispherical_values() {
    for b in KlemsBasis::ALL {
        let source = Block::Klems(sample(b));
        for other in KlemsBasis::ALL {
            let matrix = Block::Klems(to_klems(&source, &basis(other), &basis(other)));
            assert!((matrix.hemispherical() - source.hemispherical()).abs() < 1e-12);
        }
        for log2 in [2, 4] {
            let tree = Block::Tree(to_tree(&source, 4, log2, 0.0).unwrap());
            assert!((tree.hemispherical() - source.hemispherical()).abs() < 1e-6, "{} {}", tree.hemispherical(), source.hemispherical());
            let back = to_klems(&tree, &basis(b), &basis(b));
            assert!((back.hemispherical() - source.hemispherical()).abs() < 1e-6);
            let cost = loss(&source, &tree);
            assert!(cost.peak < 1.0 + 1e-6 && cost.rms > 0.0 && cost.rms < cost.rms_of_source);
        }
    }
}

#[test]
fn lambertian_data_survive_every_change_exactly() {
    let flat = Block::Klems(KlemsMatrix::from_fn(&basis(KlemsBasis::Full), |_, _| 0.2));
    for rank in [3, 4] {
        let tree = to_tree(&flat, rank, 3, 1e-6).unwrap();
        assert!((tree.direct_hemispherical(DVec3::X * 0.3) - 0.2 * PI).abs() < 1e-5);
        // Rank 3 keeps its unused upper half at 0.
        assert!(tree.len() <= 16, "equal cells are joined: {}", tree.len());
        let back = to_klems(&Block::Tree(tree), &basis(KlemsBasis::Half), &basis(KlemsBasis::Quarter));
        assert!(back.values().iter().all(|v| (v - 0.2).abs() < 1e-6));
    }
}

#[test]
fn means_over_bins_agree_with_sampling_the_tree() {
    let tree = to_tree(&Block::Klems(sample(KlemsBasis::Quarter)), 4, 3, 0.0).unwrap();
    let half = basis(KlemsBasis::Half);
    let matrix = to_klems(&Block::Tree(tree.clone()), &half, &half);
    let n = 24;
    for (o, i) in [(0, 0), (5, 5), (40, 40), (76, 3), (30, 60)] {
        let mut sum = 0.0;
        for k in 0..n * n * n * n {
            let at = |d: u32| ((k / n_pow(n, d)) % n) as f64 / n as f64 + 0.5 / n as f64;
            sum += tree.evaluate(half.direction(o, at(0), at(1)), half.direction(i, at(2), at(3)));
        }
        let sampled = sum / (n * n * n * n) as f64;
        assert!((sampled - matrix.at(o, i)).abs() < 0.02 * matrix.at(o, i).max(0.05), "{o} {i}: {sampled} {}", matrix.at(o, i));
    }
}

fn n_pow(n: usize, d: u32) -> usize {
    n.pow(d)
}

#[test]
fn an_isotropic_tree_keeps_direct_hemispherical_values() {
    let full = basis(KlemsBasis::Full);
    // Depends on θ only: 0.6 cos θ straight through and 0.1 diffuse.
    let f = |o: usize, i: usize| 0.1 / PI + if o == i { 0.6 * full.centre(i).z / full.projected_solid_angle(i) } else { 0.0 };
    let source = Block::Klems(KlemsMatrix::from_fn(&full, f));
    let tree = Block::Tree(to_tree(&source, 3, 4, 0.0).unwrap());
    assert!((tree.hemispherical() - source.hemispherical()).abs() < 1e-3, "{} {}", tree.hemispherical(), source.hemispherical());
    for slice in 0..8 {
        let (low, high) = (1.0 - (slice + 1) as f64 / 8.0, 1.0 - slice as f64 / 8.0);
        let middle = (low + high) / 2.0;
        let light = DVec3::new(middle * 0.6, middle * 0.8, (1.0 - middle * middle).sqrt());
        assert!((tree.direct_hemispherical(light) - mean_direct_hemispherical(&source, low, high)).abs() < 1e-5);
    }
    let back = to_klems(&tree, &full, &full);
    assert!((back.hemispherical() - source.hemispherical()).abs() < 1e-3);
    let straight = |m: &KlemsMatrix, i: usize| m.at(i, i) * full.projected_solid_angle(i);
    let through = full.bin_of(DVec3::new(0.34, 0.0, 0.94));
    assert!(straight(&back, through) > 0.2, "{}", straight(&back, through));
}

/// A smooth tree: bsdf2klems samples at random, and with the spikes of a traced tree its
/// hemispherical values still scatter by 1 % at `-n 4096`.
#[test]
fn bsdf2klems_of_our_tree_agrees() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.xml");
    let quarter = basis(KlemsBasis::Quarter);
    let smooth = KlemsMatrix::from_fn(&quarter, |o, i| {
        let d = quarter.centre(o) - quarter.centre(i);
        0.05 + 0.4 * (-4.0 * d.length_squared()).exp() * (1.0 + 0.5 * quarter.centre(o).x)
    });
    let mut bsdf = Bsdf::default();
    bsdf.visible.transmission_front = Some(Block::Tree(to_tree(&Block::Klems(smooth), 4, 3, 0.0).unwrap()));
    write(Some(&path), &bsdf, "").unwrap();
    let Some(mut bsdf2klems) = testing::radiance("bsdf2klems") else { return };
    let klems = testing::output(bsdf2klems.args(["-q", "-n", "256"]).arg(&path));
    let theirs = read_from(klems.as_slice(), &mut Warnings::new()).unwrap().visible.transmission_front.unwrap();
    let theirs = theirs.as_klems().unwrap();
    let ours = to_klems(bsdf.visible.transmission_front.as_ref().unwrap(), &quarter, &quarter);
    let largest = ours.values().iter().fold(0.0f64, |m, v| m.max(*v));
    let rms = (ours.values().iter().zip(theirs.values()).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 1681.0).sqrt();
    println!("hemispherical {} and {}, RMS difference {rms:.1e}, largest value {largest:.2}", ours.hemispherical(), theirs.hemispherical());
    assert!((ours.hemispherical() - theirs.hemispherical()).abs() < 5e-4);
    assert!(rms < 0.01 * largest, "{rms}");
}

#[test]
fn impossible_trees_are_refused() {
    let block = Block::Klems(sample(KlemsBasis::Quarter));
    assert!(to_tree(&block, 4, 7, 0.0).is_err() && to_tree(&block, 2, 3, 0.0).is_err() && to_tree(&block, 4, 0, 0.0).is_err());
}

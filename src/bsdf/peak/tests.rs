//! Peaks of made-up data, by both criteria and by Radiance's own material.

use super::*;
use crate::bins::Frame;
use crate::bins::shirley_chiu::disk_from_square;
use crate::bsdf::{Block, Blocks, Bsdf, TensorTree, write};
use crate::testing;

/// A tree of 2^log2 cells per side: 0.1 diffuse, a share `through` straight ahead, and a halo of
/// `halo` times the diffuse value in the cells around it.
fn peaked(log2: u32, through: f64, halo: f64) -> Blocks {
    textured(log2, through, halo, 0.0)
}

/// As `peaked`, with a background that varies from cell to cell, so that cells are not joined.
fn textured(log2: u32, through: f64, halo: f64, texture: f64) -> Blocks {
    let n = 1usize << log2;
    let ahead = through * (n * n) as f64 / PI;
    let grid: Vec<f32> = (0..n.pow(4))
        .map(|k| {
            let digit = |d: u32| (k / n.pow(3 - d) % n) as i64;
            let background = 0.1 / PI * (1.0 + texture * (k as f64 * 0.618_034).fract());
            let apart = (digit(0) - digit(2)).abs().max((digit(1) - digit(3)).abs());
            (match apart {
                0 => background + ahead,
                1 => background * (1.0 + halo),
                _ => background,
            }) as f32
        })
        .collect();
    Blocks { transmission_front: Some(Block::Tree(TensorTree::from_grid(4, log2, &grid, 0.0))), ..Blocks::default() }
}

fn scattering(log2: u32, through: f64, halo: f64) -> Scattering {
    Scattering::of_blocks(&peaked(log2, through, halo)).unwrap()
}

/// Directions in the middle of cells.
fn incident() -> impl Iterator<Item = DVec3> {
    [(5, 5), (16, 16), (20, 9), (10, 25)].into_iter().flat_map(|(a, b)| {
        let [x, y] = disk_from_square((f64::from(a) + 0.5) / 32.0, (f64::from(b) + 0.5) / 32.0);
        let z = (1.0 - x * x - y * y).sqrt();
        [DVec3::new(x, y, z), DVec3::new(x, y, -z)]
    })
}

#[test]
fn a_sharp_peak_is_taken_out_with_its_energy() {
    let s = scattering(5, 0.6, 0.0);
    for d in incident() {
        let peak = s.peak(d).unwrap();
        assert!((peak.transmittance - 0.6).abs() < 1e-5, "{peak:?}");
        assert!(peak.surround.abs() < 1e-6 && (peak.cell - PI / 1024.0).abs() < 1e-9);
        assert!(s.has_published_peak(d));
        // The sun's disc lies inside the guarded disc, directions three cells away do not.
        let sun = 6.8e-5 * d.z.abs();
        assert!(peak.guards(d, d, sun));
        let away = DVec3::new(d.x - 4.5 * peak.cell.sqrt(), d.y, d.z);
        assert!(!peak.guards(away, d, sun));
    }
    assert!(s.has_peak());
    let halo = scattering(5, 0.6, 1.0);
    let peak = halo.peak(incident().next().unwrap()).unwrap();
    assert!(peak.surround > 0.01 / PI && peak.surround < 0.1 / PI, "{peak:?}");
}

#[test]
fn the_two_criteria_differ_between_a_contrast_of_1_5_and_8() {
    // Eight cells per side: the peak is worth enough at every contrast from 3 on.
    let share = |contrast: f64| (contrast - 1.0) * 0.1 / 64.0;
    for (contrast, published, present) in [(1.3, false, false), (3.0, true, false), (7.5, true, false), (20.0, true, true)] {
        let s = Scattering::of_blocks(&textured(3, share(contrast), 0.0, 1e-3)).unwrap();
        for d in incident() {
            assert_eq!(s.has_published_peak(d), published, "{contrast}");
            assert_eq!(s.peak(d).is_some(), present, "{contrast}");
        }
    }
}

#[test]
fn data_without_a_through_component_or_a_surround_have_no_peak() {
    let flat = Blocks { transmission_front: Some(Block::Tree(TensorTree::constant(4, 0.2))), ..Blocks::default() };
    let reflecting = Blocks { reflection_front: Some(Block::Tree(TensorTree::constant(4, 0.2))), ..Blocks::default() };
    for blocks in [flat, reflecting] {
        let s = Scattering::of_blocks(&blocks).unwrap();
        assert!(!s.has_peak() && !s.has_published_peak(DVec3::Z));
    }
    // Below a twentieth of a per cent.
    let faint = scattering(5, 4e-4, 0.0);
    assert!(incident().all(|d| faint.peak(d).is_none()));
}

/// The sun's irradiance behind a pane of Radiance's `aBSDF`, as a share of the unobstructed one.
#[test]
fn transmittances_are_those_of_radiances_material() {
    let folder = tempfile::tempdir().unwrap();
    for (name, blocks, front) in [
        ("peak", peaked(5, 0.6, 0.0), true),
        ("halo", peaked(5, 0.3, 3.0), true),
        ("coarse", peaked(4, 0.7, 0.5), true),
        ("textured", textured(4, 0.2, 3.0, 0.2), true),
        // The other transmission only: by reciprocity.
        ("back", Blocks { transmission_back: peaked(5, 0.4, 1.0).transmission_front, ..Blocks::default() }, false),
    ] {
        let s = Scattering::of_blocks(&blocks).unwrap();
        let xml = folder.path().join(format!("{name}.xml"));
        write(Some(&xml), &Bsdf { visible: blocks, ..Bsdf::default() }, "").unwrap();
        let frame = Frame::new(DVec3::NEG_Z, DVec3::Y).unwrap();
        for d in incident().filter(|d| d.z < 0.0) {
            let sun = frame.to_world(d);
            let pane = format!("void aBSDF pane 5 {} 0 1 0 . 0 0\npane polygon p 0 0 12 -9 -9 0 -9 9 0 9 9 0 9 -9 0\n", xml.display());
            let scene = format!("void light l 0 0 3 1 1 1\nl source s 0 0 4 {} {} {} .1\n", sun.x, sun.y, sun.z);
            let irradiance = |text: String| -> Option<f64> {
                let rad = folder.path().join("scene.rad");
                std::fs::write(&rad, text).unwrap();
                let octree = folder.path().join("scene.oct");
                std::fs::write(&octree, testing::output(testing::radiance("oconv")?.arg(&rad))).unwrap();
                let points = folder.path().join("points");
                std::fs::write(&points, "0 0 -1 0 0 1\n").unwrap();
                let mut rtrace = testing::radiance("rtrace")?;
                rtrace.args(["-h", "-I", "-ab", "0", "-dj", "0", "-lw", "0", "-dt", "0"]).arg(&octree);
                rtrace.stdin(std::fs::File::open(&points).unwrap());
                let text = String::from_utf8(testing::output(&mut rtrace)).unwrap();
                Some(text.split_whitespace().next().unwrap().parse().unwrap())
            };
            let Some(open) = irradiance(scene.clone()) else { return };
            let shaded = irradiance(scene + &pane).unwrap();
            let ours = s.peak(d).map_or(0.0, |p| p.transmittance);
            println!("{name} {d:.3}: Radiance {:.5}, ours {ours:.5} ({front})", shaded / open);
            // Its values are changed by up to 2e-4, which also parts cells of equal value.
            assert!((shaded / open - ours).abs() < 4e-4 * ours.max(0.1), "{name} {d}: {} {ours}", shaded / open);
        }
    }
}

//! The shaders against the f64 definitions.

use super::*;
use crate::bins::KlemsBasis;
use crate::bins::shirley_chiu::disk_from_square;
use crate::bsdf::{Blocks, read, resample};
use crate::error::Warnings;
use crate::gpu::{Device, Kernel};
use crate::kernels::trace::reference::Random;
use crate::testing;
use glam::DVec3;

fn direction(random: &mut Random) -> DVec3 {
    let [x, y] = disk_from_square(random.next(), random.next());
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    DVec3::new(x, y, if random.next() < 0.5 { z } else { -z })
}

/// A direction for the device.
fn single(direction: DVec3) -> [f32; 3] {
    direction.as_vec3().to_array()
}

pub(super) fn ask(device: &Device, words: &PackedBsdfs, probes: &[BsdfProbe]) -> Vec<BsdfAnswer> {
    let kernel = Kernel::new(device, &PROBE, &[]).unwrap();
    let words = device.upload("BSDF", words.words()).unwrap();
    let questions = device.upload("probes", probes).unwrap();
    let answers = device.zeros::<BsdfAnswer>("answers", probes.len()).unwrap();
    let bind = kernel.bind(&[("bsdf_words", &words), ("probes", &questions), ("answers", &answers)]).unwrap();
    device.dispatch(&kernel, &bind, [probes.len().div_ceil(64) as u32, 1, 1]).unwrap();
    device.read(&answers).unwrap()
}

pub(super) fn probe(outgoing: DVec3, incident: DVec3, random: [f64; 3]) -> BsdfProbe {
    BsdfProbe {
        outgoing: single(outgoing),
        pane: 0,
        incident: single(incident),
        padding0: 0,
        random: random.map(|r| r as f32),
        padding1: 0,
    }
}

/// As the device sees it.
pub(super) fn rounded(d: DVec3) -> DVec3 {
    d.as_vec3().as_dvec3()
}

/// The given files' data, isotropic trees made from them, and lobes that are missing.
pub(super) fn cases() -> Vec<(String, Scattering)> {
    let mut cases = Vec::new();
    let mut push = |name: &str, blocks: &Blocks| cases.push((name.to_string(), Scattering::of_blocks(blocks).unwrap()));
    let spiky = |b: KlemsBasis| {
        Block::Klems(KlemsMatrix::from_fn(&b.into(), |o, i| 0.02 + ((o * 145 + i) as f64 * 0.618_034).fract().powi(6) * 0.2))
    };
    let made = Blocks {
        transmission_front: Some(spiky(KlemsBasis::Half)),
        reflection_front: Some(spiky(KlemsBasis::Quarter)),
        reflection_back: Some(Block::Tree(TensorTree::constant(4, 0.1))),
        ..Blocks::default()
    };
    push("made up", &made);
    let as_trees = |blocks: &Blocks, rank: usize, log2: u32| {
        let tree = |b: &Option<Block>| b.as_ref().map(|b| Block::Tree(resample::to_tree(b, rank, log2, 0.05).unwrap()));
        Blocks {
            transmission_front: tree(&blocks.transmission_front),
            transmission_back: None,
            reflection_front: tree(&blocks.reflection_front),
            reflection_back: None,
        }
    };
    push("made up, rank 3", &as_trees(&made, 3, 4));
    push("made up, rank 4", &as_trees(&made, 4, 3));
    if let Some(shared) = testing::shared() {
        for name in ["blinds.xml", "clear.xml", "ven45.xml", "blinds_correct_klems.xml", "blinds_correct_t4.xml"] {
            let bsdf = read(&shared.join("data/tutorial_room/bsdf").join(name), &mut Warnings::new()).unwrap();
            push(name, &bsdf.visible);
            if ["clear.xml", "ven45.xml"].contains(&name) {
                push(&format!("{name}, rank 3"), &as_trees(&bsdf.visible, 3, 4));
            }
        }
    }
    cases
}

#[test]
fn values_agree_with_f64_on_ten_thousand_pairs_per_file() {
    let Some(device) = Device::for_tests("scattering functions") else { return };
    for (name, scattering) in cases() {
        let mut words = PackedBsdfs::new();
        // Not at the beginning of the words: addresses are absolute.
        words
            .push(
                &Scattering::of_blocks(&Blocks { transmission_back: Some(Block::Tree(TensorTree::constant(3, 0.3))), ..Blocks::default() })
                    .unwrap(),
                Tables::Evaluate,
            )
            .unwrap();
        let pane = words.push(&scattering, Tables::Evaluate).unwrap();
        let mut random = Random(3);
        let pairs: Vec<(DVec3, DVec3)> = (0..20_000).map(|_| (direction(&mut random), direction(&mut random))).collect();
        let probes: Vec<BsdfProbe> = pairs.iter().map(|(o, i)| BsdfProbe { pane, ..probe(*o, *i, [0.5; 3]) }).collect();
        let answers = ask(&device, &words, &probes);
        let (mut edges, mut largest) = (0, 0.0f64);
        for ((o, i), answer) in pairs.iter().zip(&answers) {
            let (o, i) = (rounded(*o), rounded(*i));
            let ours = scattering.evaluate(o, i);
            let difference = (f64::from(answer.value) - ours).abs() / ours.max(1e-9);
            if difference > 1e-4 {
                // On the edge of a cell: the value next to it.
                let near = |d: DVec3, k: usize| {
                    let step = 2e-5;
                    let moved = d + DVec3::new([step, -step, 0.0, 0.0, 0.0][k], [0.0, 0.0, step, -step, 0.0][k], 0.0);
                    moved.normalize()
                };
                let found = (0..25).any(|k| {
                    let v = scattering.evaluate(near(o, k % 5), near(i, k / 5));
                    (f64::from(answer.value) - v).abs() <= 1e-4 * v
                });
                assert!(found, "{name}: {} {ours} at {o} {i}", answer.value);
                edges += 1;
            } else {
                largest = largest.max(difference);
            }
        }
        println!("{name}: {} pairs, {edges} on edges, largest relative difference {largest:.1e}", pairs.len());
        assert!(edges <= pairs.len() / 500, "{name}: {edges}");
    }
}

/// Cells per side of the square into which samples of trees are sorted, and how finely each of
/// them is integrated: together a multiple of the trees' cells, so that the integrals are exact.
const N: usize = 16;
const SUB: usize = 4;

/// The bin, or the cell of the square turned with the light, that an outgoing direction falls into.
fn category(lobe: &Lobe, outgoing: DVec3, incident: DVec3) -> usize {
    match &lobe.residue {
        Residue::Block(Block::Klems(m)) => m.outgoing().bin_of(outgoing),
        Residue::Block(Block::Tree(t)) => {
            let point = t.point(outgoing, incident);
            (point[t.rank() - 2] * N as f64) as usize * N + (point[t.rank() - 1] * N as f64) as usize
        }
        Residue::ReversedIsotropic(_) => 0,
    }
}

/// Integrals of the lobe over the categories.
fn expected_shares(lobe: &Lobe, incident: DVec3) -> Vec<f64> {
    match &lobe.residue {
        Residue::Block(Block::Klems(m)) => {
            let basis = m.outgoing();
            (0..basis.len()).map(|o| lobe.evaluate(basis.centre(o), incident) * basis.projected_solid_angle(o)).collect()
        }
        Residue::Block(Block::Tree(t)) => {
            let n = N * SUB;
            let azimuth = if t.rank() == 3 { incident.y.atan2(incident.x) } else { 0.0 };
            let mut shares = vec![0.0; N * N];
            for k in 0..n * n {
                let at = |i: usize| (i as f64 + 0.5) / n as f64;
                let [x, y] = disk_from_square(at(k / n), at(k % n));
                let d = DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
                let d = glam::DQuat::from_rotation_z(azimuth) * d;
                shares[k / n / SUB * N + k % n / SUB] += lobe.evaluate(d, incident);
            }
            shares
        }
        Residue::ReversedIsotropic(_) => vec![1.0],
    }
}

/// What differs, if not everything agrees.
type Outcome = std::result::Result<(), String>;

/// Whether samples fall where the f64 function is, with its weight; what differs, if not.
fn samples_follow(device: &Device, cases: &[(String, Scattering)]) -> Outcome {
    let mut random = Random(9);
    let ensure = |holds: bool, what: String| if holds { Ok(()) } else { Err(what) };
    for (name, scattering) in cases {
        let mut words = PackedBsdfs::new();
        words.push(scattering, Tables::Sample).unwrap();
        for round in 0..4 {
            let incident = rounded(direction(&mut random));
            let transmitted = round % 2 == 0;
            let component = Scattering::component_of(incident, transmitted);
            let Some(lobe) = scattering.lobe(component) else { continue };
            if lobe.direct_hemispherical(incident) < 1e-3 {
                continue;
            }
            let side = DVec3::Z * if transmitted == (incident.z >= 0.0) { 1.0 } else { -1.0 };
            let probes: Vec<BsdfProbe> =
                (0..20_000).map(|_| probe(side, incident, [random.next(), random.next(), random.next()])).collect();
            let answers = ask(device, &words, &probes);
            let weighted = matches!(lobe.residue, Residue::ReversedIsotropic(_));
            let whole = lobe.direct_hemispherical(incident);
            let mut expected = expected_shares(lobe, incident);
            let total: f64 = expected.iter().sum();
            expected.iter_mut().for_each(|v| *v *= answers.len() as f64 / total);
            let mut counts = vec![0.0; expected.len()];
            for answer in &answers {
                let d = DVec3::from_array(answer.direction.map(f64::from));
                ensure((d.length() - 1.0).abs() < 1e-5 && (d.z >= 0.0) == (side.z > 0.0), format!("{name}: {d}"))?;
                counts[category(lobe, d, incident)] += 1.0;
                if !weighted {
                    let close = |found: f32| (f64::from(found) - whole).abs() < 1e-4 * whole;
                    ensure(close(answer.weight) && close(answer.direct_hemispherical), format!("{name}: {} {whole}", answer.weight))?;
                }
            }
            if weighted {
                let mean = answers.iter().map(|a| f64::from(a.weight)).sum::<f64>() / answers.len() as f64;
                ensure((mean - whole).abs() < 0.1 * whole, format!("{name}: {mean} {whole}"))?;
                continue;
            }
            let (mut chi, mut cells) = (0.0, 0.0);
            for (count, wanted) in counts.iter().zip(&expected) {
                if *wanted > 8.0 {
                    chi += (count - wanted) * (count - wanted) / wanted;
                    cells += 1.0;
                }
            }
            if cells > 1.0 {
                let excess = (chi - (cells - 1.0)) / (2.0 * (cells - 1.0f64)).sqrt();
                ensure(excess < 5.0, format!("{name} {component:?}: χ² is {excess} standard deviations above its mean"))?;
            }
        }
    }
    Ok(())
}

#[test]
fn samples_follow_the_function_and_conserve_energy() {
    let Some(device) = Device::for_tests("sampling of scattering functions") else { return };
    samples_follow(&device, &cases()).unwrap();
}

/// Whether values are those of the f64 function but on a few edges.
fn values_agree(device: &Device, cases: &[(String, Scattering)]) -> Outcome {
    for (name, scattering) in cases {
        let mut words = PackedBsdfs::new();
        words.push(scattering, Tables::Evaluate).unwrap();
        let mut random = Random(3);
        let pairs: Vec<(DVec3, DVec3)> = (0..4000).map(|_| (direction(&mut random), direction(&mut random))).collect();
        let probes: Vec<BsdfProbe> = pairs.iter().map(|(o, i)| probe(*o, *i, [0.5; 3])).collect();
        let answers = ask(device, &words, &probes);
        let differs = |((o, i), answer): &(&(DVec3, DVec3), &BsdfAnswer)| {
            let ours = scattering.evaluate(rounded(*o), rounded(*i));
            (f64::from(answer.value) - ours).abs() > 1e-4 * ours.max(1e-9)
        };
        let count = pairs.iter().zip(&answers).filter(differs).count();
        // Rounding moves one pair in 500 over an edge at most, as tested above.
        if count > pairs.len() / 500 {
            return Err(format!("{name}: {count} of {} values differ", pairs.len()));
        }
    }
    Ok(())
}

#[test]
fn faults_in_the_shaders_of_scattering_functions_are_found_out() {
    let Some(device) = Device::for_tests("faults in shaders of scattering functions") else { return };
    let made_up = &cases()[..3];
    type Comparison = fn(&Device, &[(String, Scattering)]) -> Outcome;
    let faults: [(&str, &str, &str, Comparison); 11] = [
        (
            "bsdf_scattering/scattering",
            "select(TRANSMISSION_BACK, REFLECTION_BACK,",
            "select(REFLECTION_BACK, TRANSMISSION_BACK,",
            values_agree,
        ),
        (
            "bsdf_scattering/scattering",
            "outgoing.y * turn.x - outgoing.x * turn.y",
            "outgoing.y * turn.x + outgoing.x * turn.y",
            values_agree,
        ),
        (
            "bsdf_scattering/scattering",
            "isotropic_value(lobe, -incident, -outgoing)",
            "isotropic_value(lobe, -outgoing, -incident)",
            values_agree,
        ),
        ("bsdf_scattering/scattering", "child |= 1u << i;", "child |= 2u >> i;", values_agree),
        ("bsdf_scattering/square", "if phi < -FRAC_PI_4 {", "if phi < -2.0 * FRAC_PI_4 {", values_agree),
        ("bsdf_scattering/square", "vec2<f32>(-(phi - 2.0 * FRAC_PI_4)", "vec2<f32>((phi - 2.0 * FRAC_PI_4)", values_agree),
        ("bsdf_scattering/square", "0.25 - 0.125 *", "0.25 + 0.125 *", samples_follow),
        ("bsdf_scattering/sample", "+ random.y - 0.5)", "+ random.y)", samples_follow),
        ("bsdf_scattering/sample", "low = middle + 1u;", "low = middle + 2u;", samples_follow),
        ("bsdf_scattering/sample", "p.x * turn.x - p.y * turn.y", "p.x * turn.x + p.y * turn.y", samples_follow),
        ("bsdf_scattering/sample", "result.weight = lambertian + places.total;", "result.weight = places.total;", samples_follow),
    ];
    let mut survivors = Vec::new();
    for (path, from, to, compare) in faults {
        compare(&device, made_up).unwrap();
        match crate::gpu::mutation::with(path, from, to, || compare(&device, made_up)) {
            Ok(()) => survivors.push(format!("{path}: '{from}' may be '{to}'")),
            Err(found) => println!("{path}: '{to}' is found out: {found}"),
        }
    }
    assert!(survivors.is_empty(), "{}", survivors.join("\n"));
}

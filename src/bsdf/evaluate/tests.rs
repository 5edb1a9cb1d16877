//! Evaluation, sampling and peaks against their definitions and against Radiance's library.

use super::*;
use crate::bins::shirley_chiu::disk_from_square;
use crate::bins::{AngleBasis, KlemsBasis};
use crate::bsdf::{KlemsMatrix, read, resample};
use crate::error::Warnings;
use crate::testing;
use std::io::Write;
use std::process::{Command, Stdio};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in projected solid angle on one of the two sides.
    fn direction(&mut self) -> DVec3 {
        let [x, y] = disk_from_square(self.next(), self.next());
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        DVec3::new(x, y, if self.next() < 0.5 { z } else { -z })
    }
}

fn basis(b: KlemsBasis) -> AngleBasis {
    AngleBasis::from(b)
}

fn spiky(b: KlemsBasis) -> KlemsMatrix {
    KlemsMatrix::from_fn(&basis(b), |o, i| 0.02 + ((o * 145 + i) as f64 * 0.618_034).fract().powi(6) * 0.2)
}

/// Number of kinds of [`made_up`] blocks.
const KINDS: usize = 4;

/// Blocks of one kind: T front with a Lambertian part, R front, R back.
fn made_up(kind: usize) -> Blocks {
    let klems = |b| Block::Klems(spiky(b));
    let block = |b| match kind {
        0 => klems(b),
        3 => klems(KlemsBasis::Full),
        1 => Block::Tree(resample::to_tree(&klems(b), 4, 3, 0.0).unwrap()),
        _ => Block::Tree(resample::to_tree(&klems(b), 3, 4, 0.0).unwrap()),
    };
    Blocks {
        transmission_front: Some(block(KlemsBasis::Quarter)),
        transmission_back: None,
        reflection_front: Some(block(KlemsBasis::Half)),
        reflection_back: Some(block(KlemsBasis::Quarter)),
    }
}

#[test]
fn sides_blocks_and_reciprocity_are_as_defined() {
    for kind in 0..KINDS {
        let blocks = made_up(kind);
        let scattering = Scattering::of_blocks(&blocks).unwrap();
        let mut random = Random(kind as u64);
        for _ in 0..2000 {
            let (o, i) = (random.direction(), random.direction());
            let component = Scattering::component(o, i);
            assert_eq!(component.is_front(), i.z > 0.0);
            assert_eq!(component.is_transmission(), (i.z > 0.0) == (o.z > 0.0));
            let wanted = blocks.evaluate(component, o, i).unwrap();
            assert!((scattering.evaluate(o, i) - wanted).abs() < 1e-6 * wanted.max(1e-3), "{kind} {o} {i}");
        }
        let lobe = scattering.lobe(Component::TransmissionFront).unwrap();
        assert!(lobe.lambertian >= 0.02 * PI * 0.99, "{}", lobe.lambertian);
        assert_eq!(scattering.lobe(Component::TransmissionBack).unwrap().lambertian, lobe.lambertian);
    }
    let no_reflection = Blocks { transmission_back: Some(Block::Tree(TensorTree::constant(4, 0.1))), ..Blocks::default() };
    let scattering = Scattering::of_blocks(&no_reflection).unwrap();
    assert_eq!(scattering.evaluate(DVec3::NEG_Z, DVec3::Z), 0.0);
    assert!((scattering.evaluate(DVec3::Z, DVec3::Z) - 0.1).abs() < 1e-7);
    assert!(Scattering::of_blocks(&Blocks::default()).unwrap_err().to_string().contains("Visible"));
}

#[test]
fn the_lambertian_part_is_split_off_by_radiances_limits() {
    let split = |block: Block| Lobe::new(&block).lambertian;
    let full = basis(KlemsBasis::Full);
    let flat = |f: f64| Block::Klems(KlemsMatrix::from_fn(&full, |o, i| f + (o * i % 3) as f64));
    assert_eq!(split(flat(0.009 / PI)), 0.0);
    assert!((split(flat(0.02 / PI)) - 0.02).abs() < 1e-9);
    assert_eq!(split(flat(-0.5)), 0.0);
    assert_eq!(split(Block::Tree(TensorTree::constant(4, 1.6 / PI))), 0.0);
    assert!((split(Block::Tree(TensorTree::constant(4, 0.3 / PI))) - 0.3).abs() < 1e-6);
    // The unused half of a rank 3 tree is zero and does not count.
    let tree = resample::to_tree(&Block::Klems(KlemsMatrix::from_fn(&full, |_, _| 0.3 / PI)), 3, 2, 0.0).unwrap();
    assert!((split(Block::Tree(tree)) - 0.3).abs() < 0.01);
}

#[test]
fn bad_data_are_errors_or_warnings() {
    let half = basis(KlemsBasis::Quarter);
    let with = |block: Block| {
        let mut bsdf = Bsdf::default();
        bsdf.visible.transmission_front = Some(block);
        bsdf
    };
    let warned = |bsdf: &Bsdf| {
        let mut warnings = Warnings::new();
        Scattering::checked(bsdf, &mut warnings).unwrap();
        warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    let klems = |f: &dyn Fn(usize, usize) -> f64| Block::Klems(KlemsMatrix::from_fn(&half, f));
    assert_eq!(warned(&with(klems(&|_, _| 0.2))), "");
    assert!(warned(&with(klems(&|o, i| if o == i { -1.0 } else { 0.2 }))).contains("41 values are negative"));
    assert!(warned(&with(klems(&|_, _| 0.4))).contains("125.7 % of the light from the outside"));
    assert!(warned(&with(Block::Tree(TensorTree::constant(3, 9.0)))).contains("lucarne bsdf check"));
    let reflecting = Bsdf { visible: Blocks { reflection_back: Some(klems(&|_, _| 0.1)), ..Blocks::default() }, ..Bsdf::default() };
    assert!(warned(&reflecting).contains("no transmission"));
    for value in [f64::NAN, f64::INFINITY] {
        let error = Scattering::new(&with(klems(&|o, _| if o == 3 { value } else { 0.1 }))).unwrap_err().to_string();
        assert!(error.contains("not a finite number") && error.contains("Transmission Front"), "{error}");
    }
    // Up along the normal gives no frame.
    assert!(crate::bins::Frame::new(DVec3::Y, DVec3::NEG_Y * 3.0).unwrap_err().to_string().contains("parallel"));
}

#[test]
fn faults_of_trees_in_files_name_their_line() {
    let file = |data: &str| {
        format!(
            "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>TensorTree3</IncidentDataStructure></DataDefinition>\n\
             <WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>\n\
             <WavelengthDataDirection>Transmission Front</WavelengthDataDirection><AngleBasis>LBNL/Shirley-Chiu</AngleBasis>\n\
             <ScatteringData>\n{data}\n</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"
        )
    };
    let parse = |data: &str| crate::bsdf::read_from(file(data).as_bytes(), &mut Warnings::new());
    let leaf = "{ 0.1 }\n".repeat(8);
    assert!(parse(&format!("{{{leaf}}}")).is_ok());
    for (data, words) in [
        (format!("{{{leaf}"), "open brace"),
        (format!("{{{leaf}}}}}"), "brace"),
        (format!("{{{leaf}{{ 0.1 }}}}"), "more than 8"),
        (format!("{{{}}}", "{ 0.1 }\n".repeat(7)), "7 groups"),
        (format!("{{{}{{ nan }}}}", "{ 0.1 }\n".repeat(7)), "finite"),
        (format!("{{{}{{ ten }}}}", "{ 0.1 }\n".repeat(7)), "not a number"),
    ] {
        let error = parse(&data).unwrap_err().to_string();
        assert!(error.contains("line ") && error.contains(words), "{data}: {error}");
    }
}

#[test]
fn direct_hemispherical_values_are_the_integral_and_sampling_conserves_energy() {
    const WEIGHT: f64 = 1e-4;
    let mut worst = 0.0f64;
    for kind in 0..KINDS {
        let scattering = Scattering::of_blocks(&made_up(kind)).unwrap();
        let mut random = Random(7);
        for round in 0..8 {
            let incident = random.direction();
            for transmitted in [true, false] {
                let lobe = scattering.lobe(Scattering::component_of(incident, transmitted)).unwrap();
                let wanted = scattering.direct_hemispherical(incident, transmitted);
                let n = 400;
                let mut integral = 0.0;
                for k in 0..n * n {
                    let [x, y] = disk_from_square((k / n) as f64 / n as f64 + 0.5 / n as f64, (k % n) as f64 / n as f64 + 0.5 / n as f64);
                    integral += lobe.evaluate(DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()), incident) * PI / (n * n) as f64;
                }
                assert!((integral - wanted).abs() < 3e-3 * wanted, "{kind} {round}: {integral} {wanted}");
                if matches!(lobe.residue, Residue::ReversedIsotropic(_)) {
                    continue;
                }
                for _ in 0..20 {
                    let sample = scattering.sample(incident, transmitted, [random.next(), random.next(), random.next()]).unwrap();
                    assert!((sample.weight - wanted).abs() < WEIGHT * wanted);
                    worst = worst.max((sample.weight / wanted - 1.0).abs());
                    let f = scattering.evaluate(sample.direction, incident);
                    assert!((f / sample.density - sample.weight).abs() < 1e-9 * wanted, "{kind} {f} {}", sample.density);
                    assert_eq!((sample.direction.z > 0.0) == (incident.z > 0.0), transmitted);
                }
            }
        }
    }
    testing::measured("bsdf-sample-weights", &format!("within {}", testing::short(worst)), &testing::short(WEIGHT));
}

/// χ² of samples against the function's integrals over 12 × 12 cells of the square, as standard
/// deviations above its mean.
fn chi_square(scattering: &Scattering, incident: DVec3, transmitted: bool, samples: usize, random: &mut Random) -> f64 {
    const N: usize = 12;
    const SUB: usize = 20;
    let lobe = scattering.lobe(Scattering::component_of(incident, transmitted)).unwrap();
    let cell = |d: DVec3| {
        let [u, v] = crate::bins::shirley_chiu::square_from_disk(d.x, d.y);
        (u * N as f64) as usize * N + (v * N as f64) as usize
    };
    let mut expected = vec![0.0; N * N];
    for k in 0..(N * SUB).pow(2) {
        let n = N * SUB;
        let at = |i: usize| (i as f64 + 0.5) / n as f64;
        let [x, y] = disk_from_square(at(k / n), at(k % n));
        let d = DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
        expected[cell(d)] += lobe.evaluate(d, incident) * PI / (n * n) as f64;
    }
    let total: f64 = expected.iter().sum();
    let mut counts = vec![0.0; N * N];
    for _ in 0..samples {
        let s = scattering.sample(incident, transmitted, [random.next(), random.next(), random.next()]).unwrap();
        counts[cell(s.direction)] += 1.0;
    }
    let (mut chi, mut cells) = (0.0, 0.0);
    for (count, part) in counts.iter().zip(&expected) {
        let wanted = part / total * samples as f64;
        if wanted > 8.0 {
            chi += (count - wanted) * (count - wanted) / wanted;
            cells += 1.0;
        }
    }
    (chi - (cells - 1.0)) / (2.0 * (cells - 1.0f64)).sqrt()
}

#[test]
fn samples_are_distributed_as_the_function() {
    const DEVIATIONS: f64 = 4.5;
    let (mut random, mut worst) = (Random(11), 0.0f64);
    for kind in 0..KINDS {
        let scattering = Scattering::of_blocks(&made_up(kind)).unwrap();
        for (incident, transmitted) in [
            (DVec3::new(0.3, -0.5, 0.81).normalize(), true),
            (DVec3::new(-0.7, 0.1, 0.7).normalize(), false),
            (DVec3::new(0.1, 0.2, -0.9).normalize(), kind != 2),
        ] {
            let excess = chi_square(&scattering, incident, transmitted, 20_000, &mut random);
            assert!(excess.abs() < DEVIATIONS, "{kind} {incident}: {excess} standard deviations");
            worst = worst.max(excess.abs());
        }
    }
    testing::measured("bsdf-samples", &format!("χ² within {} standard deviations", testing::short(worst)), &testing::short(DEVIATIONS));
}

/// Values of Radiance's library for pairs of vectors that point away from the surface.
fn radiance_values(file: &std::path::Path, pairs: &[(DVec3, DVec3)]) -> Option<Vec<f64>> {
    testing::radiance("rtrace")?;
    let script = "import sys\n\
        try:\n    from pyradiance import bsdf\nexcept ImportError:\n    sys.exit(3)\n\
        sd = bsdf.load_file(sys.argv[1])\n\
        for line in sys.stdin:\n    print(repr(float(bsdf.query(sd, *map(float, line.split()))[1])))\n";
    let mut child = Command::new("python3")
        .args(["-c", script])
        .arg(file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python3 starts");
    let angles = |d: DVec3| format!("{:.12} {:.12}", d.z.clamp(-1.0, 1.0).acos().to_degrees(), d.y.atan2(d.x).to_degrees());
    let text: String = pairs.iter().map(|(a, b)| format!("{} {}\n", angles(*a), angles(*b))).collect();
    let mut stdin = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
    let out = child.wait_with_output().unwrap();
    let _ = writer.join();
    if out.status.code() == Some(3) {
        testing::skip(testing::Need::Radiance, &"pyradiance has no module bsdf");
        return None;
    }
    assert!(out.status.success());
    Some(String::from_utf8(out.stdout).unwrap().lines().map(|l| l.parse().unwrap()).collect())
}

/// The factor by which Radiance changes the residue so that equal neighbours can be told apart.
fn perturbation(lobe: &Lobe, outgoing: DVec3, incident: DVec3, reversed: bool) -> f64 {
    let fraction = |x: f64| x - x.trunc();
    match &lobe.residue {
        Residue::Block(Block::Klems(m)) => {
            let (mut i, mut o) = (m.incident().bin_of(incident), m.outgoing().bin_of(outgoing));
            let (mut n_in, mut n_out) = (m.incident().len(), m.outgoing().len());
            if reversed {
                (i, o) = (m.outgoing().opposite(o), m.incident().opposite(i));
                (n_in, n_out) = (n_out, n_in);
            }
            let d = 2.0 * n_in as f64 / (i as f64 + 0.22545) + 4.0 * n_out as f64 / (o as f64 + 0.70281);
            1.0 + 6e-4 * (fraction(d) - 0.5)
        }
        Residue::Block(Block::Tree(t)) => {
            let (o, i) = if reversed { (-incident, -outgoing) } else { (outgoing, incident) };
            let tree = if reversed { t.reversed().unwrap() } else { t.clone() };
            tree_perturbation(&tree, o, i)
        }
        Residue::ReversedIsotropic(t) => tree_perturbation(t, -incident, -outgoing),
    }
}

fn tree_perturbation(tree: &TensorTree, outgoing: DVec3, incident: DVec3) -> f64 {
    let corner = tree.cell(tree.point(outgoing, incident)).corner;
    let d: f64 = (0..tree.rank()).map(|k| (f64::from(2u32 << k) / (corner[k] + 0.01687)).fract() - 0.5).sum();
    1.0 + 1e-4 * d
}

/// Bound on relative differences from Radiance's library.
const SAME: f64 = 1e-4;

/// Pairs compared, differences beyond it that lie on the edge of a cell, and the largest other
/// relative difference after taking Radiance's perturbation out.
fn compare_with_radiance(path: &std::path::Path, pairs: usize) -> Option<(usize, usize, f64)> {
    let bsdf = read(path, &mut Warnings::new()).unwrap();
    let scattering = Scattering::new(&bsdf).unwrap();
    let mut random = Random(5);
    // Radiance's first vector is that of the incident light here; both point away from the surface.
    let pairs: Vec<(DVec3, DVec3)> = (0..pairs).map(|_| (random.direction(), random.direction())).collect();
    let theirs = radiance_values(path, &pairs)?;
    let (mut edges, mut largest) = (0, 0.0f64);
    for ((a, b), theirs) in pairs.iter().zip(&theirs) {
        let (outgoing, incident) = (*b, -*a);
        let component = Scattering::component(outgoing, incident);
        let Some(lobe) = scattering.lobe(component) else {
            assert!(*theirs < 1e-12);
            continue;
        };
        let reversed = bsdf.visible.get(component).is_none();
        let residue = lobe.evaluate(outgoing, incident) - lobe.lambertian / PI;
        // The Lambertian part of a matrix is the least of the perturbed values.
        let least = lobe.lambertian / PI;
        let slack = if matches!(lobe.residue, Residue::Block(Block::Klems(_))) { 3e-4 * least } else { 0.0 };
        let ours = least + residue * perturbation(lobe, outgoing, incident, reversed);
        let difference = ((ours - theirs).abs() - slack).max(0.0) / ours.max(1e-6);
        if difference > SAME {
            // The same pair moved by 1e-9 on either side must show Radiance's value.
            let near = |d: DVec3, k: usize| d + DVec3::new([1e-7, -1e-7, 0.0, 0.0][k % 4], [0.0, 0.0, 1e-7, -1e-7][k % 4], 0.0);
            let on_edge = (0..16).any(|k| {
                let v = lobe.evaluate(near(outgoing, k), near(incident, k / 4));
                (v - theirs).abs() < 1e-3 * v.max(1e-6)
            });
            assert!(on_edge, "{}: {ours} {theirs} at {a} {b}", path.display());
            edges += 1;
        } else {
            largest = largest.max(difference);
        }
    }
    Some((pairs.len(), edges, largest))
}

#[test]
fn values_agree_with_radiances_library_on_ten_thousand_pairs_per_file() {
    let Some(shared) = testing::shared() else { return };
    let folder = shared.join("data/tutorial_room/bsdf");
    let mut files: Vec<std::path::PathBuf> =
        ["blinds.xml", "clear.xml", "ven45.xml", "blinds_correct_klems.xml", "blinds_correct_t4.xml"].map(|n| folder.join(n)).to_vec();
    let made = tempfile::tempdir().unwrap();
    // Bases of the other sizes; isotropic trees, whole and with one transmission missing on either side; a reversed rank 4.
    for (name, source, rank, missing) in [
        ("clear3", "clear.xml", 3, None),
        ("ven3", "ven45.xml", 3, Some(Component::TransmissionBack)),
        ("ven3b", "ven45.xml", 3, Some(Component::TransmissionFront)),
        ("ven4", "ven45.xml", 4, Some(Component::TransmissionFront)),
        ("ven_klems", "ven45.xml", 0, Some(Component::TransmissionBack)),
        ("ven_half", "ven45.xml", 1, None),
        ("ven_quarter", "ven45.xml", 2, Some(Component::TransmissionFront)),
    ] {
        let mut bsdf = read(&folder.join(source), &mut Warnings::new()).unwrap();
        bsdf.solar = Blocks::default();
        for component in Component::ALL {
            let slot = bsdf.visible.slot(component);
            if missing == Some(component) {
                *slot = None;
            } else if let (Some(block), true) = (slot.as_ref(), rank > 0) {
                let coarse = |b: KlemsBasis| Block::Klems(resample::to_klems(block, &basis(b), &basis(b)));
                *slot = Some(match rank {
                    1 => coarse(KlemsBasis::Half),
                    2 => coarse(KlemsBasis::Quarter),
                    _ => Block::Tree(resample::to_tree(block, rank, 4, 0.0).unwrap()),
                });
            }
        }
        let path = made.path().join(format!("{name}.xml"));
        crate::bsdf::write(Some(&path), &bsdf, "").unwrap();
        files.push(path);
    }
    let (count, mut all_edges, mut most) = (files.len(), 0, 0.0f64);
    for path in files {
        let Some((pairs, edges, largest)) = compare_with_radiance(&path, 10_000) else { return };
        println!("{}: {pairs} pairs, {edges} on edges, largest relative difference {largest:.1e}", path.file_name().unwrap().display());
        assert!(edges <= pairs / 1000, "{}: {edges}", path.display());
        assert!(largest <= SAME);
        (all_edges, most) = (all_edges + edges, most.max(largest));
    }
    let found = format!("{count} files: {} relative, {all_edges} pairs on an edge", testing::short(most));
    testing::measured("bsdf-values", &found, &testing::short(SAME));
}

//! Scattering functions at their limits: the sharpest peaks, light along the pane.

use super::tests::{ask, cases, probe, rounded};
use super::*;
use crate::bins::shirley_chiu::disk_from_square;
use crate::bsdf::{Blocks, Bsdf, read_from, write_to};
use crate::error::Warnings;
use crate::gpu::Device;
use crate::kernels::trace::reference::Random;
use crate::testing::{measured, short};
use glam::DVec3;
use std::f64::consts::PI;

const DEPTH: u32 = 10;
const BACKGROUND: f64 = 0.1 / PI;
const THROUGH: f64 = 0.7;

/// A tree of rank 4, 2^10 cells per side, all background but for one cell straight ahead that takes
/// the share `THROUGH`: 2.3·10⁵ sr⁻¹. And the direction in the middle of that cell.
fn sharpest() -> (Scattering, DVec3) {
    let n = f64::from(1u32 << DEPTH);
    // Of the children of a node one is on the way to the peak: equal halves of incident and outgoing.
    let children = (0..DEPTH).map(|level| if level % 3 == 0 { 10 } else { 5 });
    let (mut text, mut place) = (format!("{{ {} }}", BACKGROUND + THROUGH * n * n / PI), [0.5; 2]);
    for child in children.rev() {
        let node: Vec<String> = (0..16).map(|k| if k == child { text.clone() } else { format!("{{ {BACKGROUND} }}") }).collect();
        text = format!("{{ {} }}", node.join(" "));
        place = [f64::midpoint(f64::from(u8::from(child == 5)), place[0]), f64::midpoint(f64::from(u8::from(child == 10)), place[1])];
    }
    let even = Blocks { transmission_front: Some(Block::Tree(TensorTree::constant(4, 0.125))), ..Blocks::default() };
    let mut xml = Vec::new();
    write_to(&mut xml, &Bsdf { visible: even, ..Bsdf::default() }, "a test").unwrap();
    let xml = String::from_utf8(xml).unwrap();
    let before = xml.find("<ScatteringData>").unwrap() + "<ScatteringData>".len();
    let after = xml.find("</ScatteringData>").unwrap();
    let xml = format!("{}{text}{}", &xml[..before], &xml[after..]);
    let bsdf = read_from(xml.as_bytes(), &mut Warnings::new()).unwrap();
    let [x, y] = disk_from_square(place[0], place[1]);
    (Scattering::new(&bsdf).unwrap(), DVec3::new(x, y, (1.0 - x * x - y * y).sqrt()))
}

#[test]
fn a_peak_of_a_hundred_thousand_keeps_its_energy() {
    let (scattering, ahead) = sharpest();
    let n = f64::from(1u32 << DEPTH);
    let peak = BACKGROUND + THROUGH * n * n / PI;
    assert!(peak > 1e5);
    const EXACT: f64 = 1e-6;
    const ON_DEVICE: f64 = 1e-4;
    let of_peak = (scattering.evaluate(ahead, ahead) / peak - 1.0).abs();
    assert!(of_peak < EXACT, "{}", scattering.evaluate(ahead, ahead));
    assert!((scattering.evaluate(DVec3::Z, ahead) / BACKGROUND - 1.0).abs() < 1e-6);
    let whole = THROUGH + PI * BACKGROUND;
    assert!((scattering.direct_hemispherical(ahead, true) / whole - 1.0).abs() < EXACT);
    assert!((scattering.direct_hemispherical(DVec3::Z, true) / (PI * BACKGROUND) - 1.0).abs() < 1e-6);
    let Some(device) = Device::for_tests("the sharpest peak") else { return };
    let mut words = PackedBsdfs::new();
    words.push(&scattering, Tables::Sample).unwrap();
    let mut random = Random(11);
    let probes: Vec<BsdfProbe> = (0..20_000).map(|_| probe(ahead, ahead, [random.next(), random.next(), random.next()])).collect();
    let answers = ask(&device, &words, &probes);
    // Within the peak's cell or close to it.
    let radius = 2.0 * PI.sqrt() / n;
    let (mut inside, mut worst) = (0, 0.0f64);
    for a in &answers {
        let off = [f64::from(a.value) / peak, f64::from(a.weight) / whole, f64::from(a.direct_hemispherical) / whole];
        worst = off.iter().fold(worst, |worst, ratio| worst.max((ratio - 1.0).abs()));
        assert!(worst < ON_DEVICE, "{} of {peak}, {} and {} of {whole}", a.value, a.weight, a.direct_hemispherical);
        let d = DVec3::from_array(a.direction.map(f64::from));
        assert!((d.length() - 1.0).abs() < 1e-5);
        inside += u32::from((d - ahead).length() < radius / ahead.z);
    }
    let share = THROUGH / whole;
    let deviation = (f64::from(inside) / answers.len() as f64 - share) / (share * (1.0 - share) / answers.len() as f64).sqrt();
    assert!(deviation.abs() < 4.5, "{inside} of {}: {deviation} standard deviations", answers.len());
    let found = format!("{} in f64, {} on the device", short(of_peak), short(worst));
    measured("sharpest-peak", &found, &format!("{}; {}", short(EXACT), short(ON_DEVICE)));
}

#[test]
fn light_along_the_pane_is_a_number_in_every_bin() {
    let device = Device::for_tests("light along the pane");
    for (name, scattering) in cases() {
        let mut words = PackedBsdfs::new();
        words.push(&scattering, Tables::Sample).unwrap();
        let mut random = Random(5);
        let mut pairs = Vec::new();
        for azimuth in 0..72 {
            let (sin, cos) = f64::from(5 * azimuth + 1).to_radians().sin_cos();
            for z in [0.0, -0.0, 1e-40, 1e-7, -1e-7, 1e-3, -1e-3] {
                let along = rounded(DVec3::new(cos, sin, z));
                let steep = rounded(DVec3::new(0.3 * sin, -0.2 * cos, if azimuth % 2 == 0 { 0.9 } else { -0.9 }).normalize());
                pairs.extend([(steep, along), (along, steep), (rounded(DVec3::new(-sin, cos, -z)), along)]);
            }
        }
        for (outgoing, incident) in &pairs {
            let value = scattering.evaluate(*outgoing, *incident);
            assert!(value.is_finite() && value >= 0.0, "{name}: {value} at {outgoing} {incident}");
            for transmitted in [true, false] {
                let whole = scattering.direct_hemispherical(*incident, transmitted);
                assert!(whole.is_finite() && whole >= 0.0, "{name}: {whole}");
                if let Some(s) = scattering.sample(*incident, transmitted, [random.next(), random.next(), random.next()]) {
                    assert!(s.direction.is_finite() && s.weight.is_finite() && s.weight >= 0.0 && s.density.is_finite(), "{name}: {s:?}");
                }
            }
        }
        let Some(device) = &device else { continue };
        let probes: Vec<BsdfProbe> = pairs.iter().map(|(o, i)| probe(*o, *i, [random.next(), random.next(), random.next()])).collect();
        let mut differ = 0;
        for ((o, i), a) in pairs.iter().zip(ask(device, &words, &probes)) {
            let fine = |v: f32| v.is_finite() && v >= 0.0;
            assert!(fine(a.value) && fine(a.weight) && fine(a.direct_hemispherical), "{name}: {} {} at {o} {i}", a.value, a.weight);
            assert!(a.direction.iter().all(|v| v.is_finite()), "{name}: {:?} at {o} {i}", a.direction);
            let exact = scattering.evaluate(*o, *i);
            differ += usize::from((f64::from(a.value) - exact).abs() > 1e-4 * exact + 1e-9);
        }
        // On edges of cells, and where the sign of a zero decides between the sides.
        assert!(differ < pairs.len() / 20, "{name}: {differ} of {} differ", pairs.len());
        println!("{name}: {differ} of {} differ", pairs.len());
    }
}

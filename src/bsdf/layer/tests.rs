use super::*;
use crate::bins::KlemsBasis;
use crate::bsdf::check;
use crate::bsdf::glass;
use crate::bsdf::glass::length;
use std::f64::consts::PI;

fn quarter() -> AngleBasis {
    AngleBasis::from(KlemsBasis::Quarter)
}

fn combined(layers: &[&Bsdf]) -> System {
    let layers: Vec<Layer> = layers.iter().map(|l| Layer::from((*l).clone())).collect();
    combine(&layers, &quarter(), &mut Warnings::new()).unwrap()
}

/// Lambertian on both sides.
fn diffuser(t: f64, rf: f64, rb: f64) -> Bsdf {
    let flat = |v: f64| Some(Block::Klems(KlemsMatrix::from_fn(&quarter(), |_, _| v / PI)));
    let blocks = Blocks { transmission_front: flat(t), transmission_back: flat(t), reflection_front: flat(rf), reflection_back: flat(rb) };
    Bsdf { visible: blocks.clone(), solar: blocks, ..Bsdf::default() }
}

/// Different everywhere, reciprocal, left-right asymmetric.
fn odd(seed: usize) -> Bsdf {
    let basis = quarter();
    let symmetric = |level: f64, shift: usize| {
        KlemsMatrix::from_fn(&basis, |o, i| {
            let random = |o: usize, i: usize| ((o * 41 + i + shift) as f64 * 0.618_034).fract();
            level / PI * (0.5 + 0.5 * (random(o, i) + random(basis.opposite(i), basis.opposite(o))))
        })
    };
    let through = KlemsMatrix::from_fn(&basis, |o, i| {
        0.3 / PI * ((o * 41 + i + seed) as f64 * 0.414_21).fract() + if o == i { 0.2 / basis.projected_solid_angle(i) } else { 0.0 }
    });
    let blocks = Blocks {
        transmission_back: Some(Block::Klems(through.reversed())),
        transmission_front: Some(Block::Klems(through)),
        reflection_front: Some(Block::Klems(symmetric(0.2, seed + 5))),
        reflection_back: Some(Block::Klems(symmetric(0.3, seed + 9))),
    };
    Bsdf { name: format!("odd {seed}"), visible: blocks.clone(), solar: blocks, ..Bsdf::default() }
}

fn hemispherical(system: &System) -> [f64; 4] {
    Component::ALL.map(|c| system.bsdf.visible.get(c).unwrap().hemispherical())
}

#[test]
fn two_diffusers_have_their_textbook_values() {
    let (a, b) = (diffuser(0.4, 0.3, 0.5), diffuser(0.2, 0.6, 0.1));
    let system = combined(&[&a, &b]);
    let d = 1.0 - 0.5 * 0.6;
    let wanted = [0.4 * 0.2 / d, 0.2 * 0.4 / d, 0.3 + 0.4 * 0.6 * 0.4 / d, 0.1 + 0.2 * 0.5 * 0.2 / d];
    for (h, w) in hemispherical(&system).iter().zip(wanted) {
        assert!((h - w).abs() < 1e-12, "{h} {w}");
    }
    let first = 0.3 + 0.4 * 0.6 / d * 0.1;
    assert!((system.absorptance[0][0].hemispherical[0] - first).abs() < 1e-12);
}

#[test]
fn specular_panes_multiply_bin_by_bin() {
    let basis = AngleBasis::from(KlemsBasis::Full);
    let [p, q] = ["clear_3mm", "clear_6mm"].map(|n| glass::named(n).unwrap());
    let system = combine(&[p.clone().into(), q.clone().into()], &basis, &mut Warnings::new()).unwrap();
    let through = |blocks: &Blocks, bin| blocks.transmission_front.as_ref().unwrap().as_klems().unwrap().direct_hemispherical(bin);
    for (bin, theta) in [(0, 0.0), (30, 30.0), (100, 60.0), (140, 82.5)] {
        let at = |wavelength| {
            let ([t1, _, _, r1], [t2, _, r2, _]) = (p.at(&p.normal(wavelength), theta), q.at(&q.normal(wavelength), theta));
            t1 * t2 / (1.0 - r1 * r2)
        };
        assert!((through(&system.bsdf.visible, bin) - at(0.5)).abs() < 1e-12);
        assert!((through(&system.bsdf.solar, bin) - 0.49 * at(0.5) - 0.51 * at(1.5)).abs() < 1e-12);
    }
}

#[test]
fn layers_that_pass_different_light_stop_the_sun_together() {
    // Half of the spectrum each: what one passes the other absorbs. Band means alone would give a quarter.
    let spectrum = |low: f64, high: f64| {
        let rows = [[0.3, low, 0.0, 0.0], [0.6, low, 0.0, 0.0], [0.600_1, high, 0.0, 0.0], [2.5, high, 0.0, 0.0]];
        spectrum::Spectrum::new(&rows).unwrap()
    };
    let pane = |s| Pane { name: String::new(), thickness: 0.006, coated: true, values: Values::Spectral(s) };
    let (blue, red) = (pane(spectrum(0.5, 0.0)), pane(spectrum(0.0, 0.5)));
    let solar = |layers: &[Layer]| {
        let system = combine(layers, &quarter(), &mut Warnings::new()).unwrap();
        (system.bsdf.solar.transmission_front.unwrap().direct_hemispherical(glam::DVec3::Z), system.absorptance[1].clone())
    };
    let (alone, _) = solar(&[blue.clone().into()]);
    let (through, absorbed) = solar(&[blue.clone().into(), red.into()]);
    assert!((0.1..0.2).contains(&alone) && through < 1e-4, "{alone} {through}");
    assert!((through + absorbed[0].front[0] + absorbed[1].front[0] - 1.0).abs() < 1e-12);
    // With itself, and with a film whose two bands say that it passes visible light only.
    assert!((solar(&[blue.clone().into(), blue.clone().into()]).0 - alone / 2.0).abs() < 1e-4);
    let mut film = diffuser(0.8, 0.1, 0.1);
    film.solar = diffuser(0.8 * spectrum::VISIBLE_SHARE, 0.1, 0.1).visible;
    let visible_part = solar(&[blue.clone().into(), film.into()]).0;
    // All but the ultraviolet, some 6 % of what the pane passes.
    assert!((0.92..0.97).contains(&(visible_part / (0.8 * alone))), "{visible_part} {alone}");
}

#[test]
fn energy_is_accounted_for_and_the_system_is_reciprocal() {
    let layers = [odd(1), odd(20), diffuser(0.3, 0.4, 0.5)];
    let system = combined(&[&layers[0], &layers[1], &layers[2]]);
    let m = |c| system.bsdf.visible.get(c).unwrap().as_klems().unwrap();
    for i in 0..41 {
        for (t, r, front) in [
            (Component::TransmissionFront, Component::ReflectionFront, true),
            (Component::TransmissionBack, Component::ReflectionBack, false),
        ] {
            let absorbed: f64 = system.absorptance[0].iter().map(|a| if front { a.front[i] } else { a.back[i] }).sum();
            let total = m(t).direct_hemispherical(i) + m(r).direct_hemispherical(i) + absorbed;
            assert!((total - 1.0).abs() < 1e-12, "bin {i}: {total}");
        }
    }
    let reversed = m(Component::TransmissionBack).reversed();
    for (a, b) in m(Component::TransmissionFront).values().iter().zip(reversed.values()) {
        assert!((a - b).abs() < 1e-12);
    }
    assert!(check::is_sound(&check::check(&system.bsdf, &Warnings::new())));
}

#[test]
fn grouping_does_not_matter_and_turning_everything_around_swaps_the_sides() {
    let (a, b, c) = (odd(1), odd(7), odd(30));
    let whole = combined(&[&a, &b, &c]);
    let pair = combined(&[&b, &c]);
    let grouped = combined(&[&a, &pair.bsdf]);
    let around = combined(&[&flipped(&c).unwrap(), &flipped(&b).unwrap(), &flipped(&a).unwrap()]);
    let back = flipped(&around.bsdf).unwrap();
    for component in Component::ALL {
        let values = |x: &Bsdf| x.visible.get(component).unwrap().as_klems().unwrap().values().to_vec();
        for other in [&grouped.bsdf, &back] {
            assert!(values(&whole.bsdf).iter().zip(values(other)).all(|(x, y)| (x - y).abs() < 1e-10), "{component:?}");
        }
    }
}

#[test]
fn incomplete_layers_are_named() {
    let mut layer = odd(1);
    layer.visible.transmission_back = None;
    assert!(combine(&[layer.clone().into(), odd(2).into()], &quarter(), &mut Warnings::new()).is_ok(), "reciprocity serves");
    layer.visible.reflection_back = None;
    let message = combine(&[odd(2).into(), layer.clone().into()], &quarter(), &mut Warnings::new()).unwrap_err().to_string();
    assert!(message.contains("layer 2 (odd 1), Visible: Reflection Back is missing"), "{message}");
    layer.visible = Blocks::default();
    let mut warnings = Warnings::new();
    assert!(combine(&[odd(2).into(), layer.into()], &quarter(), &mut warnings).unwrap().bsdf.visible.is_empty());
    assert_eq!(warnings.iter().count(), 1);
    assert!(combine(&[], &quarter(), &mut Warnings::new()).is_err());
    let mirror = diffuser(0.0, 1.0, 1.0);
    assert!(
        combine(&[mirror.clone().into(), mirror.into()], &quarter(), &mut Warnings::new())
            .unwrap_err()
            .to_string()
            .contains("never gets out")
    );
    assert!(length("16mm").unwrap() == 0.016 && length("1").unwrap() == 1.0 && length("-1").is_err() && length("x").is_err());
}

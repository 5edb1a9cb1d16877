use super::*;
use crate::bins::KlemsBasis;
use crate::bsdf::Component::{self, ReflectionBack, ReflectionFront, TransmissionBack, TransmissionFront};
use crate::kernels::trace::rooms::Builder;
use crate::progress::Silent;
use crate::scene::MaterialKind;
use std::f64::consts::PI;

fn sample(b: Builder, dim: [f64; 6], repeats: [bool; 2]) -> Sample {
    Sample::new(b.scene, Some(dim), repeats, &mut Warnings::new()).unwrap()
}

fn run(sample: &Sample, directions: Directions, options: &GenerationOptions) -> Table {
    let mut table = Table::new(directions);
    generate(&Device::shared().unwrap(), sample, &mut table, options, &Silent, &mut Warnings::new(), &mut |_| Ok(())).unwrap();
    table
}

fn both_methods() -> [GenerationOptions; 2] {
    [Method::Paths, Method::Chains].map(|method| GenerationOptions { method, ..few() })
}

fn few() -> GenerationOptions {
    GenerationOptions { samples: 512, batches: 4, ..GenerationOptions::default() }
}

#[test]
fn a_hole_is_the_identity_in_every_basis() {
    for directions in [Directions::Klems(KlemsBasis::Full), Directions::Klems(KlemsBasis::Half), Directions::Tree4(2)] {
        let hole = sample(Builder::default(), [0.0, 1.0, 0.0, 1.0, -0.1, 0.0], [false, false]);
        let table = run(&hole, directions, &GenerationOptions { samples: 16, batches: 2, ..few() });
        let projected = directions.outgoing_projected();
        for component in [TransmissionFront, TransmissionBack] {
            for i in 0..directions.incident() {
                for o in 0..directions.outgoing() {
                    let expected = if i == o { 1.0 / projected[o] } else { 0.0 };
                    let found = table.mean(component, o, i);
                    assert!(
                        (found - expected).abs() < 1e-5 * expected.max(1.0),
                        "{directions:?} {component:?} {i} {o}: {found} {expected}"
                    );
                }
            }
            assert!((table.hemispherical(component) - 1.0).abs() < 1e-5);
        }
        assert_eq!(table.hemispherical(ReflectionFront) + table.hemispherical(ReflectionBack), 0.0);
    }
}

#[test]
fn a_lambertian_plate_reflects_evenly() {
    let mut b = Builder::default();
    let grey = b.grey(0.9);
    b.quad([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]], grey);
    // Repeating, so that no light passes its edges.
    let plate = sample(b, [0.0, 2.0, 0.0, 1.0, 0.0, 0.0], [true, true]);
    let bases = [Directions::Klems(KlemsBasis::Full), Directions::Tree4(2), Directions::Tree3(3)];
    for (directions, options) in bases.into_iter().flat_map(|d| both_methods().map(|o| (d, o))) {
        let table = run(&plate, directions, &options);
        for component in [ReflectionFront, ReflectionBack] {
            assert!((table.hemispherical(component) - 0.9).abs() < 1e-3, "{}", table.hemispherical(component));
            check(&table, component, |_, _| 0.9 / PI);
        }
        assert_eq!(table.hemispherical(TransmissionFront) + table.hemispherical(TransmissionBack), 0.0);
    }
}

/// All entries against their expectation: the mean square of deviations over standard errors is
/// about 1.
fn check(table: &Table, component: Component, expected: impl Fn(usize, usize) -> f64) {
    let d = table.directions();
    let (mut deviations, mut errors) = (0.0, 0.0);
    for i in 0..d.incident() {
        for o in 0..d.outgoing() {
            deviations += (table.mean(component, o, i) - expected(o, i)).powi(2);
            errors += table.standard_error(component, o, i).powi(2);
        }
    }
    let n = (d.incident() * d.outgoing()) as f64;
    let floor = 1e-5 * expected(0, 0);
    assert!(
        (deviations / n).sqrt() < 1.5 * (errors / n).sqrt() + floor,
        "{component:?}: RMS deviation {}, standard error {}",
        (deviations / n).sqrt(),
        (errors / n).sqrt()
    );
}

#[test]
fn a_translucent_plate_divides_its_light() {
    let mut b = Builder::default();
    let kind = MaterialKind::Trans { color: [0.8; 3], specularity: 0.0, roughness: 0.0, transmissivity: 0.5, transmitted_specularity: 0.0 };
    let trans = b.material(kind);
    b.quad([[0.0, 0.0, -0.1], [2.0, 0.0, -0.1], [2.0, 1.0, -0.1], [0.0, 1.0, -0.1]], trans);
    let plate = sample(b, [0.0, 2.0, 0.0, 1.0, -0.1, -0.1], [true, true]);
    for options in both_methods() {
        let table = run(&plate, Directions::Klems(KlemsBasis::Quarter), &options);
        for component in Component::ALL {
            let found = table.hemispherical(component);
            // Chains draw the side on which they start: a binomial error of the share of each side.
            let drawn = f64::from(options.samples * options.batches);
            let tolerance = if options.method == Method::Chains { 4.0 * 0.4 / drawn.sqrt() / 2.0 } else { 2e-3 };
            assert!((found - 0.4).abs() < tolerance, "{component:?}: {found} by {options:?}");
            check(&table, component, |_, _| 0.4 / PI);
        }
    }
}

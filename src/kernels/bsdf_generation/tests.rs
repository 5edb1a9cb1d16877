use super::*;
use crate::bins::AngleBasis;
use crate::bins::KlemsBasis;
use crate::bsdf::Component::{self, ReflectionBack, ReflectionFront, TransmissionBack, TransmissionFront};
use crate::bsdf::blinds::Venetian;
use crate::gpu::mutation;
use crate::kernels::bsdf_generation::reference::bsdf_column;
use crate::kernels::trace::rooms::Builder;
use crate::progress::Silent;
use crate::scene::{MaterialIndex, MaterialKind, Scene, Triangle};
use crate::testing;
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;

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
    const SAME: f64 = 1e-5;
    let mut worst = 0.0f64;
    for directions in [Directions::Klems(KlemsBasis::Full), Directions::Klems(KlemsBasis::Half), Directions::Tree4(2)] {
        let hole = sample(Builder::default(), [0.0, 1.0, 0.0, 1.0, -0.1, 0.0], [false, false]);
        let table = run(&hole, directions, &GenerationOptions { samples: 16, batches: 2, ..few() });
        let projected = directions.outgoing_projected();
        for component in [TransmissionFront, TransmissionBack] {
            for i in 0..directions.incident() {
                for o in 0..directions.outgoing() {
                    let expected = if i == o { 1.0 / projected[o] } else { 0.0 };
                    let found = table.mean(component, o, i);
                    worst = worst.max((found - expected).abs() / expected.max(1.0));
                    assert!(worst < SAME, "{directions:?} {component:?} {i} {o}: {found} {expected}");
                }
            }
            assert!((table.hemispherical(component) - 1.0).abs() < SAME);
        }
        assert_eq!(table.hemispherical(ReflectionFront) + table.hemispherical(ReflectionBack), 0.0);
    }
    testing::measured("hole", &format!("the identity to {}", testing::short(worst)), &testing::short(SAME));
}

#[test]
fn a_lambertian_plate_reflects_evenly() {
    let mut b = Builder::default();
    let grey = b.grey(0.9);
    b.quad([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]], grey);
    // Repeating, so that no light passes its edges.
    let plate = sample(b, [0.0, 2.0, 0.0, 1.0, 0.0, 0.0], [true, true]);
    const SAME: f64 = 1e-3;
    let mut worst = 0.0f64;
    let bases = [Directions::Klems(KlemsBasis::Full), Directions::Tree4(2), Directions::Tree3(3)];
    for (directions, options) in bases.into_iter().flat_map(|d| both_methods().map(|o| (d, o))) {
        let table = run(&plate, directions, &options);
        for component in [ReflectionFront, ReflectionBack] {
            worst = worst.max((table.hemispherical(component) - 0.9).abs());
            assert!(worst < SAME, "{}", table.hemispherical(component));
            check(&table, component, |_, _| 0.9 / PI);
        }
        assert_eq!(table.hemispherical(TransmissionFront) + table.hemispherical(TransmissionBack), 0.0);
    }
    // With a fault planted this is not reached.
    testing::measured("lambertian-plate", &format!("within {}", testing::short(worst)), &testing::short(SAME));
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
            assert!((found - 0.4).abs() < 2e-3, "{component:?}: {found} by {options:?}");
            check(&table, component, |_, _| 0.4 / PI);
        }
    }
}

#[test]
fn two_translucent_plates_send_light_to_and_fro() {
    let mut b = Builder::default();
    let kind = MaterialKind::Trans { color: [0.8; 3], specularity: 0.0, roughness: 0.0, transmissivity: 0.5, transmitted_specularity: 0.0 };
    let trans = b.material(kind);
    for z in [-0.3, -0.1] {
        b.quad([[0.0, 0.0, z], [2.0, 0.0, z], [2.0, 1.0, z], [0.0, 1.0, z]], trans);
    }
    // Endless plates, with room before, between and behind them.
    let plates = sample(b, [0.0, 2.0, 0.0, 1.0, -0.4, 0.0], [true, true]);
    // Each passes and reflects 0.4, evenly: a geometric series.
    let (r, t) = (0.4, 0.4);
    let (through, back) = (t * t / (1.0 - r * r), r + t * t * r / (1.0 - r * r));
    // A chain passes with a chance of 0.19: 4 × 8192 chains know the mean to 1.2 %. Paths are many more.
    let [paths, chains] = both_methods();
    for options in [paths, GenerationOptions { samples: 8192, ..chains }] {
        let table = run(&plates, Directions::Klems(KlemsBasis::Quarter), &options);
        for (component, wanted) in
            [(TransmissionFront, through), (TransmissionBack, through), (ReflectionFront, back), (ReflectionBack, back)]
        {
            let found = table.hemispherical(component);
            assert!((found - wanted).abs() < 1e-2, "{component:?}: {found} {wanted} by {options:?}");
            check(&table, component, |_, _| wanted / PI);
        }
    }
}

/// File, text, the fault put in its place, and the test that it must make fail.
const FAULTS: &[(&str, &str, &str, fn())] = &[
    (
        "bsdf_generation/paths",
        "select(0u, params.out_cells, direction.z > 0.0)",
        "select(params.out_cells, 0u, direction.z > 0.0)",
        a_hole_is_the_identity_in_every_basis,
    ),
    (
        "bsdf_generation/paths",
        "turned(direction, vec2<f32>(turn.x, -turn.y))",
        "turned(direction, turn)",
        isotropic_trees_average_over_azimuth,
    ),
    ("bsdf_generation/paths", "direction = cosine_direction(side, slope);", "direction = side;", a_lambertian_plate_reflects_evenly),
    ("bsdf_generation/directions", "if phi < -quarter {", "if phi < 0.0 {", a_hole_is_the_identity_in_every_basis),
    ("bsdf_generation/directions", "a = -(phi - 2.0 * quarter)", "a = (phi - 2.0 * quarter)", a_hole_is_the_identity_in_every_basis),
    (
        "bsdf_generation/chain_start",
        "(reflected + transmitted) < reflected",
        "(reflected + transmitted) > reflected",
        a_lambertian_plate_reflects_evenly,
    ),
    ("bsdf_generation/chain_start", "chain.leaving = -arriving;", "", a_translucent_plate_divides_its_light),
    ("bsdf_generation/chain_walk", "weight /= survival;", "", two_translucent_plates_send_light_to_and_fro),
    (
        "bsdf_generation/chain_walk",
        "let side = select(facing, -facing, event.transmitted);",
        "let side = facing;",
        two_translucent_plates_send_light_to_and_fro,
    ),
    ("bsdf_generation/fans", "chain.weight / (0.5 * TAU)", "chain.weight / TAU", a_lambertian_plate_reflects_evenly),
    ("bsdf_generation/fans", "vec3<f32>(cosine * chosen.weight)", "vec3<f32>(cosine)", a_lambertian_plate_reflects_evenly),
    ("bsdf_generation/sample", "nearest + 1e-5", "nearest - 1e-1", two_translucent_plates_send_light_to_and_fro),
    (
        "bsdf_generation/sample",
        "position.x = select(params.high.x, params.low.x, direction.x > 0.0);",
        "position.x = select(params.low.x, params.high.x, direction.x > 0.0);",
        two_translucent_plates_send_light_to_and_fro,
    ),
];

#[test]
fn faults_in_the_shaders_of_generation_are_found_out() {
    if Device::for_tests("faults in shaders of BSDF generation").is_none() {
        return;
    }
    let survives = |(path, from, to, test): &&(&str, &str, &str, fn())| {
        let start = std::time::Instant::now();
        let passes = mutation::with(path, from, to, || std::panic::catch_unwind(test).is_ok());
        println!("{path}: '{to}' {} in {:.1?}", if passes { "SURVIVES" } else { "is found out" }, start.elapsed());
        passes
    };
    let survivors: Vec<_> = FAULTS.iter().filter(survives).map(|(path, from, to, _)| format!("{path}: '{from}' may be '{to}'")).collect();
    assert!(survivors.is_empty(), "{}", survivors.join("\n"));
}

/// A device without symmetry: tilted plates of several materials before a tinted pane.
fn louvre() -> Builder {
    let mut b = Builder::default();
    let plastic = b.material(MaterialKind::Plastic { color: [0.7, 0.5, 0.3], specularity: 0.05, roughness: 0.0 });
    let metal = b.material(MaterialKind::Metal { color: [0.8; 3], specularity: 0.6, roughness: 0.0 });
    let trans = b.material(MaterialKind::Trans {
        color: [0.9, 0.8, 0.7],
        specularity: 0.03,
        roughness: 0.0,
        transmissivity: 0.4,
        transmitted_specularity: 0.3,
    });
    let glass = b.material(MaterialKind::Glass { transmissivity: [0.8, 0.9, 0.85], refraction_index: 1.52 });
    let mirror = b.material(MaterialKind::Mirror { color: [0.85; 3] });
    b.quad([[0.0, 0.0, -0.4], [1.0, 0.0, -0.4], [1.0, 0.6, -0.4], [0.0, 0.6, -0.4]], glass);
    b.quad([[0.0, 0.05, -0.35], [1.0, 0.05, -0.35], [1.0, 0.2, -0.05], [0.0, 0.2, -0.05]], plastic);
    b.quad([[0.0, 0.35, -0.35], [0.7, 0.35, -0.35], [0.7, 0.5, -0.05], [0.0, 0.5, -0.05]], metal);
    b.quad([[0.8, 0.0, -0.3], [0.9, 0.6, -0.3], [0.9, 0.6, 0.0], [0.8, 0.0, 0.0]], trans);
    b.quad([[0.05, 0.0, -0.3], [0.05, 0.6, -0.3], [0.1, 0.6, -0.1], [0.1, 0.0, -0.1]], mirror);
    b
}

/// Our table against the analog reference for some incident bins: the mean square of deviations over
/// their variance is about 1, and sums over a hemisphere agree.
fn compare(table: &Table, scene: &Scene, low: [f64; 2], high: [f64; 2], faces: [f64; 2], bins: &[usize], samples: usize) {
    let Directions::Klems(basis) = table.directions() else { panic!("matrices only") };
    let basis = AngleBasis::from(basis);
    let lambda = table.directions().outgoing_projected();
    let mut all = (0.0, 0.0);
    for (side, components) in [[ReflectionFront, TransmissionFront], [TransmissionBack, ReflectionBack]].into_iter().enumerate() {
        for &bin in bins {
            let column = bsdf_column(scene, low, high, faces[side], side == 0, &basis, bin, samples, bin as u64 + 77 * side as u64);
            for (component, column) in components.into_iter().zip(column.chunks_exact(basis.len())) {
                let (mut squares, mut variances, mut ours, mut theirs) = (0.0, 0.0, 0.0, 0.0);
                for (o, estimate) in column.iter().enumerate() {
                    let (a, b) = (table.mean(component, o, bin) * lambda[o], estimate.mean(samples));
                    let (ea, eb) = (table.standard_error(component, o, bin) * lambda[o], estimate.standard_error(samples));
                    squares += (a - b).powi(2);
                    variances += ea * ea + eb * eb;
                    ours += a;
                    theirs += b;
                }
                // Few entries dominate: the ratio of one bin scatters widely.
                let ratio = (squares / variances.max(1e-12)).sqrt();
                let sum_error = 4.0 * (variances * 4.0).sqrt() + 1e-3;
                assert!(ratio < 3.5, "{component:?} {bin}: RMS deviation {ratio} standard errors");
                all.0 += squares / variances.max(1e-12);
                all.1 += 1.0;
                assert!((ours - theirs).abs() < sum_error, "{component:?} {bin}: {ours} {theirs}, error {sum_error}");
            }
        }
    }
    let ratio = f64::sqrt(all.0 / all.1);
    assert!(ratio < 1.4, "RMS deviation of all {ratio} standard errors");
}

#[test]
fn both_methods_agree_with_the_analog_reference() {
    let scene = louvre().scene;
    let mut warnings = Warnings::new();
    let device = Sample::new(scene.clone(), None, [false, false], &mut warnings).unwrap();
    assert!(warnings.is_empty());
    for method in [Method::Paths, Method::Chains] {
        let options = GenerationOptions { samples: 4096, batches: 32, method, ..GenerationOptions::default() };
        let table = run(&device, Directions::Klems(KlemsBasis::Quarter), &options);
        let faces = [device.low.z - 1e-5, device.high.z + 1e-5];
        compare(&table, &scene, [0.0, 0.0], [1.0, 0.6], faces, &[0, 2, 7, 12, 17, 25, 30, 38], 40_000);
    }
}

fn venetian(angle: f64) -> (Sample, Scene) {
    let blind = Venetian { width: 0.025, spacing: 0.02, angle, rise: 0.003, thickness: 0.0 };
    let period = blind.period().unwrap();
    let mut b = Builder::default();
    b.material(MaterialKind::Plastic { color: [0.6; 3], specularity: 0.0, roughness: 0.0 });
    let scene = |triangles: Vec<[DVec3; 3]>| Scene {
        triangles: triangles.into_iter().map(|vertices| Triangle { vertices, material: MaterialIndex(0), surface: 0 }).collect(),
        ..b.scene.clone()
    };
    let (low, high) = (period.low, period.high);
    let dim = [low.x, high.x, low.y, high.y, low.z, high.z];
    let repeating = Sample::new(scene(period.triangles.clone()), Some(dim), [true, true], &mut Warnings::new()).unwrap();
    // The same blind, long and high enough that its edges do not matter for light from the middle.
    let middle = (low.x + high.x) / 2.0;
    let wide = (-15..=15).flat_map(|k| {
        let move_to = move |p: DVec3| DVec3::new((p.x - middle) * 41.0 + middle, p.y + 0.02 * f64::from(k), p.z);
        period.triangles.iter().map(move |t| t.map(move_to)).collect::<Vec<_>>()
    });
    (repeating, scene(wide.collect()))
}

#[test]
fn a_repeating_blind_is_an_endless_one() {
    let (repeating, wide) = venetian(25.0);
    let options = GenerationOptions { samples: 4096, batches: 32, ..GenerationOptions::default() };
    for method in [Method::Paths, Method::Chains] {
        let table = run(&repeating, Directions::Klems(KlemsBasis::Quarter), &GenerationOptions { method, ..options });
        let (low, high) = (repeating.low, repeating.high);
        compare(&table, &wide, [low.x, low.y], [high.x, high.y], [low.z - 1e-6, high.z + 1e-6], &[0, 3, 11, 18], 12_000);
    }
}

#[test]
fn trees_hold_the_same_light_as_matrices() {
    let (blind, _) = venetian(25.0);
    let options = GenerationOptions { samples: 4096, average_reciprocal: true, ..GenerationOptions::default() };
    let matrix = run(&blind, Directions::Klems(KlemsBasis::Quarter), &options);
    let tree = run(&blind, Directions::Tree4(3), &options);
    for component in Component::ALL {
        let (a, b) = (matrix.hemispherical(component), tree.hemispherical(component));
        assert!((a - b).abs() < 0.01 * a, "{component:?} {a} {b}");
        for cull in [0.0, 80.0] {
            let block = tree.block(component, cull);
            assert!((block.hemispherical() - b).abs() < 1e-4, "{component:?} {} {b}", block.hemispherical());
        }
    }
    // Helmholtz: what comes out of the table is reciprocal.
    let d = tree.directions();
    let opposite = d.opposite();
    for (o, i) in [(0, 5), (17, 40), (63, 3)] {
        let (there, back) = (tree.mean(TransmissionFront, o, i), tree.mean(TransmissionBack, opposite[i], opposite[o]));
        assert!((there - back).abs() < 1e-6 * there.max(1.0));
    }
}

#[test]
fn isotropic_trees_average_over_azimuth() {
    // A plate with holes is nearly isotropic; what counts here is the energy, and that light goes on
    // towards +x, where the incident azimuth is turned.
    let mut b = Builder::default();
    let grey = b.grey(0.5);
    b.quad([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.0]], grey);
    let plate = sample(b, [0.0, 1.0, 0.0, 1.0, 0.0, 0.0], [true, true]);
    for options in both_methods() {
        let table = run(&plate, Directions::Tree3(4), &options);
        assert!((table.hemispherical(TransmissionFront) - 0.5).abs() < 5e-3);
        assert!((table.hemispherical(ReflectionBack) - 0.25).abs() < 5e-3);
        for theta in [20.0f64, 45.0, 70.0] {
            let d = DVec3::new(theta.to_radians().sin(), 0.0, theta.to_radians().cos());
            let block = table.block(TransmissionFront, 0.0);
            assert!((block.direct_hemispherical(d) - 0.5).abs() < 0.03);
            assert!(block.evaluate(d, d) > 5.0 * block.evaluate(DVec3::new(-d.x, 0.0, d.z), d), "{theta}");
        }
    }
}

#[test]
fn a_table_goes_on_where_it_stopped_and_stops_on_request() {
    use std::sync::atomic::{AtomicBool, Ordering};
    struct Stop(AtomicBool);
    impl Progress for Stop {
        fn update(&self, _: &str, _: f64) {}
        fn stop_requested(&self) -> bool {
            self.0.load(Ordering::SeqCst)
        }
    }
    let (blind, _) = venetian(0.0);
    let device = Device::shared().unwrap();
    let d = Directions::Klems(KlemsBasis::Quarter);
    let options = few();
    let whole = run(&blind, d, &options);
    let mut table = Table::new(d);
    let mut bytes = Vec::new();
    let stop = Stop(false.into());
    let stopped = generate(&device, &blind, &mut table, &options, &stop, &mut Warnings::new(), &mut |t| {
        bytes = t.to_bytes();
        stop.0.store(true, Ordering::SeqCst);
        Ok(())
    });
    assert!(stopped.unwrap_err().message().contains("stopped"));
    let mut again = Table::from_bytes(d, &bytes).unwrap();
    assert!(again.batches() > 0 && again.batches() < options.batches);
    generate(&device, &blind, &mut again, &options, &Silent, &mut Warnings::new(), &mut |_| Ok(())).unwrap();
    assert!(again == whole, "the same bits");
}

#[test]
fn misplaced_geometry_is_explained() {
    let plate = |z: f64| {
        let mut b = Builder::default();
        let grey = b.grey(0.5);
        b.quad([[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]], grey);
        b.scene
    };
    let fault = |scene: Scene, dim: Option<[f64; 6]>| Sample::new(scene, dim, [false; 2], &mut Warnings::new()).unwrap_err().to_string();
    assert!(fault(Scene::default(), None).contains("no geometry"));
    assert!(fault(plate(0.1), None).contains("in the room"));
    assert!(fault(plate(-0.5), Some([0.0, 1.0, 0.0, 1.0, -0.1, 0.0])).contains("reaches out of the box"));
    assert!(fault(plate(-0.05), Some([5.0, 6.0, 0.0, 1.0, -0.1, 0.0])).contains("outside the box"));
    assert!(fault(plate(-0.05), Some([1.0, 0.0, 0.0, 1.0, -0.1, 0.0])).contains("ascending"));
    assert!(fault(plate(-0.05), Some([0.0, 0.0, 0.0, 1.0, -0.1, 0.0])).contains("no extent along x"));
    assert!(fault(plate(-0.05), Some([0.0, f64::NAN, 0.0, 1.0, -0.1, 0.0])).contains("ascending"));
    let mut upright = Scene { ..plate(0.0) };
    for p in upright.triangles.iter_mut().flat_map(|t| &mut t.vertices) {
        *p = DVec3::new(p.x, 0.0, p.y - 1.0);
    }
    assert!(fault(upright, None).contains("no extent along y"));
    let warned = |scene: Scene, dim: [f64; 6]| {
        let mut warnings = Warnings::new();
        let sample = Sample::new(scene, Some(dim), [true; 2], &mut warnings).unwrap();
        let mut table = Table::new(Directions::Klems(KlemsBasis::Quarter));
        generate(&Device::shared().unwrap(), &sample, &mut table, &few(), &Silent, &mut warnings, &mut |_| Ok(())).unwrap();
        warnings.iter().map(ToString::to_string).collect::<String>()
    };
    assert!(warned(plate(0.0), [0.0, 1.0, 0.0, 1.0, 0.0, 0.0]).contains("no opening"));
    assert!(warned(plate(-3.0), [0.0, 1.0, 0.0, 1.0, -3.0, 0.0]).contains("far behind"));
    // A sheet askew in a box as deep as it is high.
    let mut askew = Builder::default();
    let grey = askew.grey(0.5);
    askew.quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, -0.5], [0.0, 1.0, -0.5]], grey);
    let small = Sample::new(askew.scene, None, [false; 2], &mut Warnings::new()).unwrap();
    let mut warnings = Warnings::new();
    explain_edges(&small, &mut warnings);
    explain_edges(&Sample { repeats: [true; 2], ..small }, &mut warnings);
    assert_eq!(warnings.iter().count(), 1);
    assert!(warnings.iter().all(|w| w.to_string().contains("50 % as deep")));
    // Mirrors that turn their backs to the light.
    let mut b = Builder::default();
    let mirror = b.material(MaterialKind::Mirror { color: [0.9; 3] });
    b.quad([[0.0, 0.0, 0.0], [0.8, 0.0, 0.0], [0.8, 1.0, 0.0], [0.0, 1.0, 0.0]], mirror);
    assert!(warned(b.scene, [0.0, 1.0, 0.0, 1.0, 0.0, 0.0]).contains("back of mirrors"));
}

/// Radiance's own BSDF of a device as genBSDF makes it: light from the outside, `[outgoing][incident]`
/// for transmission and reflection, 1/sr, quarter basis.
fn radiance(folder: &Path, device: &Sample, samples: u32) -> Option<[Vec<f64>; 2]> {
    let (low, high) = (device.low, device.high);
    let z = low.z - 1e-5;
    let sender = format!(
        "#@rfluxmtx u=-Y h=-kq\nvoid glow send 0 0 4 1 1 1 0\nsend polygon face 0 0 12 {} {} {z} {} {} {z} {} {} {z} {} {} {z}\n",
        low.x, low.y, low.x, high.y, high.x, high.y, high.x, low.y
    );
    std::fs::write(folder.join("sender.rad"), sender).unwrap();
    let receivers = "#@rfluxmtx u=-Y h=-kq\nvoid glow room 0 0 4 1 1 1 0\nroom source r 0 0 4 0 0 1 180\n\
                     #@rfluxmtx u=-Y h=+kq\nvoid glow outside 0 0 4 1 1 1 0\noutside source o 0 0 4 0 0 -1 180\n";
    std::fs::write(folder.join("receivers.rad"), receivers).unwrap();
    let count = samples.to_string();
    let arguments =
        ["-fd", "-w", "-n", "1", "-ab", "5", "-ad", "16", "-lw", "1e-3", "-c", &count, "sender.rad", "receivers.rad", "device.rad"];
    let found = testing::output(testing::radiance("rfluxmtx")?.current_dir(folder).args(arguments));
    let matrix = crate::matrix::file::read_matrix_from::<f64>(found.as_slice()).unwrap().matrix;
    let basis = AngleBasis::from(KlemsBasis::Quarter);
    let n = basis.len();
    // One matrix per receiver, below each other in one stream.
    assert_eq!((matrix.rows(), matrix.cols()), (n, 2 * n));
    let block = |first: usize| {
        let entry = |o: usize, i: usize| matrix.data()[(i * 2 * n + first + o) * matrix.components()] / basis.projected_solid_angle(o);
        (0..n * n).map(|k| entry(k / n, k % n)).collect()
    };
    Some([block(0), block(n)])
}

#[test]
fn radiance_finds_the_same_bsdf() {
    let (blind, _) = venetian(25.0);
    // Five slats, with edges, and a pane; Radiance's mirrors and panes are tested above by reference.
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("void plastic slat 0 0 5 .6 .6 .6 0 0\nvoid glass pane 0 0 3 .9 .9 .9\n");
    text += "pane polygon p 0 0 12 0 0 -.03 .2 0 -.03 .2 .1 -.03 0 .1 -.03\n";
    for (k, t) in (0..5).flat_map(|k| blind.scene.triangles.iter().map(move |t| (k, t))) {
        let corners = t.vertices.map(|p| format!("{} {} {}", p.x, p.y + 0.02 * f64::from(k), p.z)).join(" ");
        text += &format!("slat polygon s 0 0 9 {corners}\n");
    }
    std::fs::write(folder.path().join("device.rad"), text).unwrap();
    let scene = crate::scene::rad::read_scene(&["device.rad".into()], folder.path(), &mut Warnings::new()).unwrap();
    let device = Sample::new(scene, None, [false, false], &mut Warnings::new()).unwrap();
    // Two runs with different rays show Radiance's own noise.
    let Some(first) = radiance(folder.path(), &device, 500) else { return };
    let second = radiance(folder.path(), &device, 400).unwrap();
    let options = GenerationOptions { samples: 4096, bounces: Some(5), ..GenerationOptions::default() };
    let table = run(&device, Directions::Klems(KlemsBasis::Quarter), &options);
    let basis = AngleBasis::from(KlemsBasis::Quarter);
    let n = basis.len();
    for ((component, a), b) in [TransmissionFront, ReflectionFront].into_iter().zip(&first).zip(&second) {
        let (mut deviation, mut noise, mut ours, mut theirs) = (0.0, 0.0, 0.0, 0.0);
        for k in 0..n * n {
            let (mean, share) = ((a[k] + b[k]) / 2.0, basis.projected_solid_angle(k / n) * basis.projected_solid_angle(k % n) / PI);
            let f = table.mean(component, k / n, k % n);
            deviation += (f - mean).powi(2);
            noise += ((a[k] - b[k]) / 2.0).powi(2) + table.standard_error(component, k / n, k % n).powi(2);
            ours += f * share;
            theirs += mean * share;
        }
        let ratio = (deviation / noise).sqrt();
        assert!(ratio < 1.5, "{component:?}: RMS deviation is {ratio} times the noise");
        assert!((ours - theirs).abs() < 3e-3, "{component:?}: hemispherical {ours} {theirs}");
    }
}

#[test]
fn window_knows_the_same_slat_angle() {
    let script = "
import pywincalc as w, numpy as np
optical = w.ProductDataOpticalDualBandHemispheric(0, 0, .6, .6, 0, 0, .6, .6, .0005)
slats = w.create_venetian_blind(w.VenetianGeometry(25, .025, .02, 0, True, w.DistributionMethodType.DIRECTIONAL_DIFFUSE, 40), optical, w.ProductDataThermal(1, .0005))
hemisphere = w.BSDFHemisphere.create(w.BSDFBasisType.QUARTER)
system = w.GlazingSystem(solid_layers=[slats], bsdf_hemisphere=hemisphere)
found = system.optical_method_results('PHOTOPIC').system_results
print(found.front.transmittance.diffuse_diffuse, found.front.reflectance.diffuse_diffuse)
solid = np.array(hemisphere.get_directions(w.BSDFDirection.Outgoing).lambda_vector())
print(*(solid @ np.array(found.front.transmittance.matrix)))";
    let Some(out) = testing::pywincalc(script) else { return };
    let theirs: Vec<f64> = String::from_utf8(out).unwrap().split_whitespace().map(|w| w.parse().unwrap()).collect();
    let period = Venetian { width: 0.025, spacing: 0.02, angle: 25.0, rise: 0.0, thickness: 0.0 }.period().unwrap();
    let mut scene = venetian(25.0).0.scene;
    scene.triangles = period.triangles.iter().map(|&vertices| Triangle { vertices, material: MaterialIndex(0), surface: 0 }).collect();
    let (low, high) = (period.low, period.high);
    let blind = Sample::new(scene, Some([low.x, high.x, low.y, high.y, low.z, high.z]), [true, true], &mut Warnings::new()).unwrap();
    let table = run(&blind, Directions::Klems(KlemsBasis::Quarter), &GenerationOptions { samples: 2048, ..GenerationOptions::default() });
    // WINDOW takes directions at the bins' centres and slats in 40 segments of even radiosity.
    assert!((table.hemispherical(TransmissionFront) - theirs[0]).abs() < 0.02, "{} {}", table.hemispherical(TransmissionFront), theirs[0]);
    assert!((table.hemispherical(ReflectionFront) - theirs[1]).abs() < 0.02, "{} {}", table.hemispherical(ReflectionFront), theirs[1]);
    let block = table.block(TransmissionFront, 0.0);
    let matrix = block.as_klems().unwrap();
    let (up, down) = (9 + 3, 9 + 9);
    assert!(matrix.direct_hemispherical(up) > 1.5 * matrix.direct_hemispherical(down));
    for bin in [0, up, down] {
        assert!(
            (matrix.direct_hemispherical(bin) - theirs[2 + bin]).abs() < 0.05,
            "{bin}: {} {}",
            matrix.direct_hemispherical(bin),
            theirs[2 + bin]
        );
    }
}

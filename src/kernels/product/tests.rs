//! Both ways of multiplying against the f64 reference.

use super::*;
use crate::gpu::{Device, mutation};

/// A matrix of reproducible values of mixed sign and size.
fn matrix(rows: usize, cols: usize, components: usize, seed: u32) -> Matrix<f32> {
    let mut state = seed.wrapping_mul(2_654_435_761).wrapping_add(1);
    let data = (0..rows * cols * components)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let unit = (state >> 8) as f32 / 16_777_216.0;
            (unit - 0.3) * if state.is_multiple_of(7) { 1000.0 } else { 1.0 }
        })
        .collect();
    Matrix::from_data(rows, cols, components, data).unwrap()
}

fn multipliers(what: &str) -> Vec<Box<dyn Multiplier>> {
    let mut all: Vec<Box<dyn Multiplier>> = vec![Box::new(Native)];
    if let Some(device) = Device::for_tests(what) {
        all.push(Box::new(OnDevice::with_kernel(&device, DeviceKernel::Tiled).unwrap()));
        if device.subgroup_size().is_some() {
            all.push(Box::new(OnDevice::with_kernel(&device, DeviceKernel::Subgroup).unwrap()));
        }
    }
    all
}

/// Shapes below, at and beyond the tiles of every kernel.
const SHAPES: [(usize, usize, usize, usize); 9] = [
    (1, 1, 1, 1),
    (1, 145, 1, 3),
    (3, 5, 7, 3),
    (32, 8, 8, 1),
    (100, 145, 24, 3),
    (127, 147, 129, 3),
    (130, 8, 300, 3),
    (5, 1300, 3, 3),
    (600, 9, 520, 3),
];

/// The first entry of all shapes and arrangements that is off by more than rounding allows.
fn first_fault(multiplier: &dyn Multiplier) -> Option<String> {
    for (rows, terms, columns, components) in SHAPES {
        let (a, b) = (matrix(rows, terms, components, 1), matrix(terms, columns, components, 2));
        let (exact, magnitudes) = reference::product(&a.map(f64::from), &b.map(f64::from));
        let left = multiplier.left(rows, terms, components, a.data().into()).unwrap();
        let right = multiplier.right(terms, columns, components, b.data().into()).unwrap();
        for arrangement in [Arrangement::Rows, Arrangement::Columns] {
            let mut got = vec![f32::NAN; rows * columns * components];
            multiplier.multiply(&left, &right, 0, columns, arrangement, &mut got).unwrap();
            for (i, entry) in got.chunks_exact(components).enumerate() {
                let (row, column) = match arrangement {
                    Arrangement::Rows => (i / columns, i % columns),
                    Arrangement::Columns => (i % rows, i / rows),
                };
                for (c, value) in entry.iter().enumerate() {
                    let error = (f64::from(*value) - exact.at(row, column)[c]).abs();
                    let bound = reference::gamma(terms) * magnitudes.at(row, column)[c];
                    if error.is_nan() || error > bound {
                        return Some(format!(
                            "{rows}×{terms}×{columns} {arrangement:?}: entry {row}, {column}, {c}: {error:e} > {bound:e}"
                        ));
                    }
                }
            }
        }
    }
    None
}

#[test]
fn every_entry_lies_within_the_rounding_bound() {
    for multiplier in multipliers("products") {
        assert_eq!(first_fault(&*multiplier), None, "{}", multiplier.description());
    }
}

#[test]
fn faults_planted_in_the_shaders_are_found() {
    let Some(device) = Device::for_tests("faults planted in product shaders") else { return };
    let faults = [
        (DeviceKernel::Tiled, "product/gemm_tiled", "vec4<f32>(lower.z), b", "vec4<f32>(lower.y), b"),
        (DeviceKernel::Tiled, "product/gemm_tiled", "left_tile[k * QUADS + 16u", "left_tile[k * QUADS + 15u"),
        (DeviceKernel::Tiled, "shared/gemm", "= row2;", "= row1;"),
        (DeviceKernel::Tiled, "shared/gemm", "= turned[3];", "= turned[2];"),
        (DeviceKernel::Tiled, "product/pack", "element * params.components + component]", "element * params.components]"),
        (DeviceKernel::Tiled, "product/pack", "element % params.columns", "element % params.rows"),
        (DeviceKernel::Subgroup, "generated", "(rows.z, 1u)", "(rows.z, 0u)"),
        (DeviceKernel::Subgroup, "generated", "term < params.inner", "term + 8u < params.inner"),
        (DeviceKernel::Subgroup, "product/gemm_subgroup", "+ params.first_column +", "+ 1u +"),
    ];
    for (kernel, path, from, to) in faults {
        if kernel == DeviceKernel::Subgroup && device.subgroup_size().is_none() {
            continue;
        }
        let multiplier = mutation::with(path, from, to, || OnDevice::with_kernel(&device, kernel));
        assert!(first_fault(&multiplier.unwrap()).is_some(), "nobody noticed '{to}' in {path}");
    }
}

#[test]
fn bits_do_not_depend_on_tiles_and_columns_are_rows_transposed() {
    let (rows, terms, columns, components) = (700, 61, 530, 3);
    let (a, b) = (matrix(rows, terms, components, 3), matrix(terms, columns, components, 4));
    for multiplier in multipliers("tiles of products") {
        let left = multiplier.left(rows, terms, components, a.data().into()).unwrap();
        let right = multiplier.right(terms, columns, components, b.data().into()).unwrap();
        let mut whole = vec![f32::NAN; rows * columns * components];
        multiplier.multiply(&left, &right, 0, columns, Arrangement::Rows, &mut whole).unwrap();
        let entry = |row: usize, column: usize| &whole[(row * columns + column) * components..][..components];
        for (first, count) in [(0, columns), (0, 1), (5, 256), (127, 403), (529, 1)] {
            let mut part = vec![f32::NAN; rows * count * components];
            multiplier.multiply(&left, &right, first, count, Arrangement::Columns, &mut part).unwrap();
            for (i, values) in part.chunks_exact(components).enumerate() {
                assert_eq!(values, entry(i % rows, first + i / rows), "{} columns {first}+{count}", multiplier.description());
            }
        }
        for (first, count) in [(0, 100), (100, 333), (699, 1)] {
            let part = &a.data()[first * terms * components..(first + count) * terms * components];
            let left = multiplier.left(count, terms, components, part.into()).unwrap();
            let mut got = vec![f32::NAN; count * columns * components];
            multiplier.multiply(&left, &right, 0, columns, Arrangement::Rows, &mut got).unwrap();
            assert_eq!(got, whole[first * columns * components..][..got.len()], "{} rows {first}+{count}", multiplier.description());
        }
    }
    let Some(device) = Device::for_tests("small tiles of products") else { return };
    for bytes in [1, 100_000, 1_000_000] {
        let kernel = if device.subgroup_size().is_some() { DeviceKernel::Subgroup } else { DeviceKernel::Tiled };
        let small = OnDevice::with_kernel(&device, kernel).unwrap().tiles_of(bytes);
        let large = OnDevice::with_kernel(&device, kernel).unwrap();
        assert!(multiply(&small, &a, &b).unwrap() == multiply(&large, &a, &b).unwrap(), "tiles of {bytes} bytes");
    }
}

#[test]
fn chains_are_evaluated_from_the_right_and_gray_factors_apply_to_all_components() {
    let (v, t, d, s) = (matrix(4, 9, 3, 5), matrix(9, 9, 1, 6), matrix(9, 11, 3, 7), matrix(11, 6, 3, 8));
    let t3 = with_components(&t, 3).into_owned();
    for multiplier in multipliers("chains") {
        let got = chain(&*multiplier, &[&v, &t, &d, &s]).unwrap();
        let ds = multiply(&*multiplier, &d, &s).unwrap();
        let tds = multiply(&*multiplier, &t3, &ds).unwrap();
        assert_eq!(got, multiply(&*multiplier, &v, &tds).unwrap());
        assert_eq!(chain(&*multiplier, &[&s]).unwrap(), s);
    }
    assert!(chain(&Native, &[]).is_err());
    let error = chain(&Native, &[&v, &d, &d]).unwrap_err().to_string();
    assert!(error.contains("matrix 2 has 11 columns, but matrix 3 has 9 rows"), "{error}");
    assert!(chain(&Native, &[&matrix(2, 2, 2, 1), &matrix(2, 2, 3, 1)]).unwrap_err().to_string().contains("NCOMP"));
}

#[test]
fn empty_factors_and_zero_terms_give_zeros() {
    for multiplier in multipliers("empty products") {
        for (rows, terms, columns) in [(0, 3, 4), (3, 0, 4), (3, 4, 0)] {
            let got = multiply(&*multiplier, &matrix(rows, terms, 3, 1), &matrix(terms, columns, 3, 2)).unwrap();
            assert!(got.data().iter().all(|v| *v == 0.0) && (got.rows(), got.cols()) == (rows, columns));
        }
    }
}

#[test]
fn values_that_overflow_are_an_error_on_every_way() {
    let big = Matrix::from_data(1, 2, 1, vec![f32::MAX, f32::MAX]).unwrap();
    let two = Matrix::from_data(2, 1, 1, vec![2.0, 2.0]).unwrap();
    for multiplier in multipliers("overflow") {
        assert!(multiply(&*multiplier, &big, &two).is_err(), "{}", multiplier.description());
    }
}

#[test]
fn the_largest_and_smallest_numbers_stay_within_the_rounding_bound() {
    // What devices may flush to zero.
    let tiny = f64::from(f32::MIN_POSITIVE);
    let sky = |patch: usize, hour: usize| match (patch, hour) {
        // A sun of 10⁹ beside a sky of 1, in one patch and not in every hour.
        (70, 0..=2) => 1e9,
        _ => 1.0 + (patch * 7 + hour) as f32 * 1e-3,
    };
    let filled = |rows: usize, cols: usize, f: &dyn Fn(usize, usize) -> f32| {
        Matrix::from_data(rows, cols, 1, (0..rows * cols).map(|k| f(k / cols, k % cols)).collect()).unwrap()
    };
    let mixed = |row: usize, col: usize| if (row + col).is_multiple_of(3) { 1e-40 } else { 1e-30 };
    let cases = [
        (
            "sun and sky",
            filled(40, 146, &|row, col| if col == 70 && row % 2 == 0 { 0.0 } else { 1e-3 * (row + 1) as f32 }),
            filled(146, 9, &sky),
        ),
        ("specular peaks beside a diffuse part", filled(145, 145, &|row, col| if row == col { 1e5 } else { 1e-6 }), filled(145, 30, &sky)),
        ("subnormal factors", filled(33, 20, &mixed), filled(20, 17, &|_, _| 1.0)),
        ("products below all numbers", filled(33, 20, &|_, _| 1e-30), filled(20, 17, &|_, _| 1e-30)),
        ("the largest numbers", filled(9, 12, &|_, _| 1e30), filled(12, 10, &|_, _| 2e7)),
        (
            "terms that cancel",
            filled(9, 146, &|_, col| if col % 2 == 0 { 1e6 } else { -1e6 }),
            filled(146, 10, &|row, _| 1.0 + (row / 2) as f32),
        ),
    ];
    let mut worst = 0.0f64;
    for multiplier in multipliers("extreme products") {
        for (what, a, b) in &cases {
            let (exact, magnitudes) = reference::product(&a.map(f64::from), &b.map(f64::from));
            let got = multiply(&*multiplier, a, b).unwrap();
            for ((got, exact), magnitude) in got.data().iter().zip(exact.data()).zip(magnitudes.data()) {
                let allowed = reference::gamma(a.cols()) * magnitude + a.cols() as f64 * tiny;
                let error = (f64::from(*got) - exact).abs();
                assert!(error <= allowed, "{what}, {}: {got}, not {exact}", multiplier.description());
                worst = worst.max(error / allowed.max(tiny));
                // No sum of light is off by more than a ten-thousandth.
                assert!(what.contains("cancel") || error <= 1e-4 * exact + a.cols() as f64 * tiny, "{what}: {got}, not {exact}");
            }
        }
    }
    let found = format!("at most {} of the bound of f32 rounding", crate::testing::percent(worst));
    crate::testing::measured("extreme-products", &found, "that bound");
}

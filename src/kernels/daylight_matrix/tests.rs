use super::reference::daylight_row;
use super::*;
use crate::bins::Frame;
use crate::bins::KlemsBasis;
use crate::error::Warnings;
use crate::gpu::mutation;
use crate::kernels::trace::comparison::assert_agrees;
use crate::kernels::trace::reference::Estimate;
use crate::kernels::trace::rooms::{Builder, street, window};
use crate::progress::Silent;
use crate::scene::MaterialKind;
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

fn tregenza() -> ReinhartSky {
    ReinhartSky::new(1).unwrap()
}

fn row_sum(d: &Matrix<f32>, bin: usize, c: usize) -> f64 {
    (0..d.cols()).map(|p| f64::from(d.at(bin, p)[c])).sum()
}

#[test]
fn a_street_without_symmetry_agrees_with_the_reference_bin_by_bin() {
    let Some(device) = Device::for_tests("daylight matrix") else { return };
    let (scene, mut w) = street();
    w.basis = KlemsBasis::Quarter.into();
    for bounces in [0, 2] {
        let options = DaylightOptions { bounces: Some(bounces), paths: 4096, ..DaylightOptions::default() };
        let d = compute(&device, &scene, &w, tregenza(), &options, &Silent).unwrap();
        // Bins of every ring, more of those in which light comes from the sky.
        let rows: Vec<_> = [0, 3, 7, 12, 18, 23, 30, 35, 39]
            .into_par_iter()
            .map(|bin| (bin, daylight_row(&scene, &w, bin, tregenza(), bounces, 100_000, 5 + bin as u64)))
            .collect();
        for (bin, row) in rows {
            assert_agrees(&format!("-ab {bounces}, bin {bin}"), &d, bin, &row, 100_000);
        }
    }
}

#[test]
fn finer_skies_of_other_bases_agree_with_the_reference() {
    let Some(device) = Device::for_tests("daylight matrix of finer skies") else { return };
    let (scene, mut w) = street();
    w.basis = KlemsBasis::Quarter.into();
    let sky = ReinhartSky::new(2).unwrap();
    let options = DaylightOptions { bounces: Some(1), paths: 2048, ..DaylightOptions::default() };
    let d = compute(&device, &scene, &w, sky, &options, &Silent).unwrap();
    assert_eq!((d.total.rows(), d.total.cols()), (41, 578));
    for bin in [3, 20, 37] {
        let row = daylight_row(&scene, &w, bin, sky, 1, 200_000, 5 + bin as u64);
        assert_agrees(&format!("MF:2, quarter basis, bin {bin}"), &d, bin, &row, 200_000);
    }
}

/// Length of what two arcs of the circle have in common.
fn common_arc([from, to]: [f64; 2], [other_from, other_to]: [f64; 2]) -> f64 {
    (-2..=2)
        .map(|turn| {
            let shift = f64::from(turn) * TAU;
            (to.min(other_to + shift) - from.max(other_from + shift)).max(0.0)
        })
        .sum()
}

#[test]
fn a_roof_light_under_the_open_sky_is_the_overlap_of_rings_and_rows() {
    let Some(device) = Device::for_tests("daylight matrix of a roof light") else { return };
    // Normal down into the room, up vector north: local x points west, so light travelling towards
    // local azimuth φ comes from the compass azimuth φ + 90°.
    let w = window([[0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [1.0, 1.0, 3.0], [0.0, 1.0, 3.0]], DVec3::NEG_Z, DVec3::Y, KlemsBasis::Full);
    let options = DaylightOptions { paths: 4096, ..DaylightOptions::default() };
    for sky in [tregenza(), ReinhartSky::new(4).unwrap()] {
        let d = compute(&device, &crate::scene::Scene::default(), &w, sky, &options, &Silent).unwrap();
        let sin2 = |altitude: f64| altitude.sin().powi(2);
        let (mut squares, mut count, mut covered) = (0.0, 0, 0.0);
        for bin in 0..145 {
            let (ring, position) = w.basis.ring_of(bin);
            let cos2 = |degrees: f64| degrees.to_radians().cos().powi(2);
            let (high, low) = (cos2(ring.theta_min), cos2(ring.theta_max));
            let width = TAU / ring.bins as f64;
            let arc = [(position as f64 - 0.5) * width + TAU / 4.0, (position as f64 + 0.5) * width + TAU / 4.0];
            for patch in 1..sky.len() {
                let (altitudes, azimuths) = sky.limits(patch);
                let part = (high.min(sin2(altitudes[1])) - low.max(sin2(altitudes[0]))).max(0.0) / (high - low);
                let exact = part * common_arc(arc, azimuths) / width;
                let found = f64::from(d.total.at(bin, patch)[1]);
                let error = f64::from(d.standard_error.at(bin, patch)[1]);
                covered += exact;
                if exact == 0.0 {
                    assert!(found < 1e-4, "bin {bin} sees patch {patch}: {found}");
                    continue;
                }
                // One sample in 32768 is the least that can be told.
                let z = (found - exact) / error.hypot(3e-5);
                assert!(z.abs() < 8.0, "bin {bin}, patch {patch}: {found}, not {exact} ± {error}");
                squares += z * z;
                count += 1;
            }
            assert!((row_sum(&d.total, bin, 0) - 1.0).abs() < 1e-5 && d.total.at(bin, 0) == [0.0; 3]);
        }
        assert!((covered / 145.0 - 1.0).abs() < 1e-9, "the overlaps are a partition");
        println!("MF:{}: {count} overlaps, mean z² {:.2}", sky.subdivision(), squares / f64::from(count));
        assert!(squares / f64::from(count) < 1.8);
    }
}

#[test]
fn a_vertical_window_under_the_open_sky_agrees_with_quadrature() {
    let Some(device) = Device::for_tests("daylight matrix of a vertical window") else { return };
    // Facing south-west, so that nothing falls on limits.
    let normal = DVec3::new(0.6, 0.8, 0.0);
    let w = window([[0.0, 0.0, 0.0], [0.8, -0.6, 0.0], [0.8, -0.6, 1.0], [0.0, 0.0, 1.0]], normal, DVec3::Z, KlemsBasis::Full);
    let options = DaylightOptions { paths: 4096, ..DaylightOptions::default() };
    let sky = tregenza();
    let d = compute(&device, &crate::scene::Scene::default(), &w, sky, &options, &Silent).unwrap();
    let n = 700;
    let rows: Vec<(usize, Vec<f64>)> = [0, 7, 21, 40, 58, 63, 83, 87, 105, 111, 129, 142]
        .into_par_iter()
        .map(|bin| {
            let mut row = vec![0.0; sky.len()];
            for i in 0..n * n {
                let (u, v) = (((i / n) as f64 + 0.5) / n as f64, ((i % n) as f64 + 0.5) / n as f64);
                row[sky.bin_of(-w.frame.to_world(w.basis.direction(bin, u, v)))] += 1.0 / (n * n) as f64;
            }
            (bin, row)
        })
        .collect();
    let (mut squares, mut count) = (0.0, 0);
    for (bin, row) in rows {
        for (patch, &exact) in row.iter().enumerate() {
            let found = f64::from(d.total.at(bin, patch)[0]);
            let error = f64::from(d.standard_error.at(bin, patch)[0]);
            if exact > 0.0 || found > 0.0 {
                let z = (found - exact) / error.hypot(5e-5);
                assert!(z.abs() < 8.0, "bin {bin}, patch {patch}: {found}, not {exact} ± {error}");
                squares += z * z;
                count += 1;
            }
        }
    }
    println!("{count} overlaps, mean z² {:.2}", squares / f64::from(count));
    assert!(count > 40 && squares / f64::from(count) < 1.8, "mean z² {}", squares / f64::from(count));
}

#[test]
fn nothing_is_lost_or_gained_where_nothing_absorbs() {
    let Some(device) = Device::for_tests("balance of the daylight matrix") else { return };
    let mut b = Builder::default();
    let white = b.grey(1.0);
    let mirror = b.material(MaterialKind::Metal { color: [1.0; 3], specularity: 1.0, roughness: 0.0 });
    // Large and slanted ground, a wall, slats, and a mirror on both sides. The window alone absorbs.
    b.quad([[-300.0, -600.0, -8.0], [300.0, -600.0, -4.0], [300.0, 300.0, 1.0], [-300.0, 300.0, -2.0]], white);
    b.quad([[-20.0, -9.0, -5.0], [4.0, -11.0, -5.0], [4.0, -11.0, 9.0], [-20.0, -9.0, 9.0]], white);
    b.quad([[9.0, -8.0, 6.0], [9.0, -1.0, 6.0], [9.0, -1.0, -3.0], [9.0, -8.0, -3.0]], mirror);
    for k in 0..20 {
        let z = 1.0 + 0.08 * f64::from(k);
        b.quad([[0.3, -0.10, z], [2.2, -0.10, z], [2.2, -0.02, z + 0.03], [0.3, -0.02, z + 0.03]], white);
    }
    let w = window([[0.5, 0.0, 1.0], [0.5, 0.0, 2.5], [2.0, 0.0, 2.5], [2.0, 0.0, 1.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    let d = compute(&device, &b.scene, &w, tregenza(), &DaylightOptions { paths: 512, ..DaylightOptions::default() }, &Silent).unwrap();
    let mut ground: f64 = 0.0;
    let samples = 2000;
    let kept: Vec<Estimate> = (0..145)
        .into_par_iter()
        .map(|bin| {
            let row = daylight_row(&b.scene, &w, bin, tregenza(), 1000, samples, 3 + bin as u64);
            row.iter().fold(Estimate::default(), |sum, cell| sum.with(&cell[0]))
        })
        .collect();
    // What the window does not keep leaves: of each bin 4096 paths against 2000.
    let (mut squares, mut difference, mut variance) = (0.0, 0.0, 0.0);
    for (bin, kept) in kept.iter().enumerate() {
        let (found, wanted) = (row_sum(&d.total, bin, 0), kept.mean(samples));
        let error2 = wanted * (1.0 - wanted) * (1.0 / samples as f64 + 1.0 / 4096.0) + 1e-6;
        squares += (found - wanted).powi(2) / error2 / 145.0;
        difference += found - wanted;
        variance += error2;
        assert!(found < 1.0 + 1e-5, "bin {bin}: {found}");
        ground += f64::from(d.total.at(bin, 0)[0]) / 145.0;
    }
    println!("what leaves: mean z² {squares:.2}, all together {difference:.3} ± {:.3} of 145", variance.sqrt());
    assert!(squares < 1.6 && difference.abs() < 4.0 * variance.sqrt(), "{squares} {difference}");
    // Only what passes over the edges of the ground reaches the lower hemisphere: the window sees
    // less than 1/100 of it beyond. Rays that start below their own surface would end there too.
    println!("mean share of the ground: {ground:.1e}");
    assert!(ground < 0.015, "{ground}");
}

#[test]
fn equal_seeds_give_equal_bits_in_any_number_of_dispatches() {
    let Some(device) = Device::for_tests("dispatches of the daylight matrix") else { return };
    let (scene, mut w) = street();
    w.basis = KlemsBasis::Quarter.into();
    let options = DaylightOptions { paths: 1000, batches: 3, ..DaylightOptions::default() };
    let run = |options: &DaylightOptions, chunk| {
        compute_in_dispatches(&device, &scene, std::slice::from_ref(&w), tregenza(), options, chunk, &Silent).unwrap()
    };
    let whole = run(&options, PATHS_PER_DISPATCH);
    assert_eq!(whole.total, compute(&device, &scene, &w, tregenza(), &options, &Silent).unwrap().total);
    for chunk in [1000, 256, 97] {
        let parts = run(&options, chunk);
        assert_eq!(whole.total, parts.total, "{chunk} paths per dispatch");
        assert_eq!(whole.direct, parts.direct);
        assert_eq!(whole.standard_error, parts.standard_error);
        assert_eq!(whole.statistics, parts.statistics);
    }
    assert_ne!(whole.total, run(&DaylightOptions { seed: 2, ..options }, PATHS_PER_DISPATCH).total);
}

#[test]
fn the_direct_part_is_at_most_the_total_and_knows_no_bounces() {
    let Some(device) = Device::for_tests("direct daylight matrix") else { return };
    let (scene, mut w) = street();
    w.basis = KlemsBasis::Half.into();
    let run = |bounces| {
        let options = DaylightOptions { bounces, paths: 256, ..DaylightOptions::default() };
        compute(&device, &scene, &w, tregenza(), &options, &Silent).unwrap()
    };
    let (none, two, all) = (run(Some(0)), run(Some(2)), run(None));
    // What a façade mirrors is no diffuse bounce, but not direct either.
    let sum = |m: &Matrix<f32>| m.data().iter().map(|&v| f64::from(v)).sum::<f64>();
    assert!(sum(&none.direct) > 0.0 && sum(&none.total) > sum(&none.direct));
    assert_eq!(none.direct, two.direct);
    assert_eq!(none.direct, all.direct);
    assert!(sum(&none.total) < sum(&two.total) && sum(&two.total) < sum(&all.total));
    for d in [&two, &all] {
        for (direct, total) in d.direct.data().iter().zip(d.total.data()) {
            assert!(direct <= total, "{direct} of {total}");
        }
    }
}

#[test]
fn a_wall_in_the_plane_of_the_window_does_not_stand_before_it() {
    let Some(device) = Device::for_tests("a wall in the window's plane") else { return };
    let (street, mut w) = street();
    w.basis = KlemsBasis::Quarter.into();
    let options = DaylightOptions { bounces: Some(1), paths: 2048, ..DaylightOptions::default() };
    let turn = DMat3::from_rotation_x(0.4) * DMat3::from_rotation_z(0.7);
    // As drawn; tilted, so that no coordinate is exact; far from the origin, and rounded as files are.
    for (what, turned, origin, digits) in [
        ("upright", DMat3::IDENTITY, DVec3::ZERO, 1e9),
        ("tilted", turn, DVec3::ZERO, 1e9),
        ("survey coordinates, rounded to 10 µm", turn, DVec3::new(583_960.4, 4_507_523.7, 31.6), 1e5),
    ] {
        let placed = |p: DVec3| ((origin + turned * p) * digits).round() / digits;
        let mut open = street.clone();
        open.triangles.iter_mut().flat_map(|t| &mut t.vertices).for_each(|p| *p = placed(*p));
        let mut own = w.clone();
        own.triangles.iter_mut().flatten().for_each(|p| *p = placed(*p));
        own.frame = Frame::new(turned * w.frame.z, turned * w.frame.y).unwrap();
        // A wall over all of it, whose front looks either way; a pane, and a frame on a part.
        for front in [false, true] {
            let mut b = Builder { scene: open.clone() };
            let (wall, glass) = (b.grey(0.5), b.material(MaterialKind::Glass { transmissivity: [0.5; 3], refraction_index: 1.52 }));
            let mut quad = |[x0, x1]: [f64; 2], [z0, z1]: [f64; 2], material| {
                let mut corners = [[x0, z0], [x1, z0], [x1, z1], [x0, z1]].map(|[x, z]| placed(DVec3::new(x, 0.0, z)).to_array());
                if front {
                    corners.reverse();
                }
                b.quad(corners, material);
            };
            quad([-6.0, 6.0], [0.0, 5.0], wall);
            quad([0.5, 2.0], [1.0, 2.5], glass);
            quad([0.4, 0.6], [0.9, 2.6], wall);
            let mut warnings = Warnings::new();
            b.scene.set_windows(std::slice::from_ref(&own), &mut warnings).unwrap();
            assert!(!warnings.is_empty());
            let d = compute(&device, &b.scene, &own, tregenza(), &options, &Silent).unwrap();
            for bin in [3, 12, 23, 35] {
                let row = daylight_row(&open, &own, bin, tregenza(), 1, 50_000, 5 + bin as u64);
                assert_agrees(&format!("{what}, bin {bin}"), &d, bin, &row, 50_000);
            }
        }
    }
}

/// A black wing with a window on either side, across a court, and bright slats before the own window.
#[test]
fn other_windows_and_the_own_one_absorb() {
    let Some(device) = Device::for_tests("other windows of D") else { return };
    let mut b = Builder::default();
    let (black, white) = (b.grey(0.0), b.grey(0.9));
    // The far wing with an opening 6 m × 3 m through it, from y = -4 to y = -6; slats before the own window.
    for y in [-4.0, -6.0] {
        for ([x0, x1], [z0, z1]) in
            [([-8.0, 8.0], [-2.0, 0.0]), ([-8.0, 8.0], [3.0, 6.0]), ([-8.0, -3.0], [0.0, 3.0]), ([3.0, 8.0], [0.0, 3.0])]
        {
            b.quad([[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]], black);
        }
    }
    for k in 0..4 {
        let z = 0.55 + 0.25 * f64::from(k);
        b.quad([[-0.5, -0.25, z], [0.5, -0.25, z], [0.5, -0.05, z + 0.2], [-0.5, -0.05, z + 0.2]], white);
    }
    let own = window([[-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, 1.5], [-0.5, 0.0, 1.5]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    let far = |y: f64, normal| window([[-3.0, y, 0.0], [3.0, y, 0.0], [3.0, y, 3.0], [-3.0, y, 3.0]], normal, DVec3::Z, KlemsBasis::Full);
    let holes = b.scene.clone();
    b.scene.windows = vec![far(-4.0, DVec3::NEG_Y), own.clone(), far(-6.0, DVec3::Y)];
    let options = DaylightOptions { bounces: Some(3), paths: 4096, ..DaylightOptions::default() };
    let d = compute(&device, &b.scene, &own, tregenza(), &options, &Silent).unwrap();
    let samples = 200_000;
    let rows: Vec<(usize, f64, f64)> = [0, 4, 11, 20, 27, 33, 40]
        .into_par_iter()
        .map(|bin| {
            let row = daylight_row(&b.scene, &own, bin, tregenza(), 3, samples, 9 + bin as u64);
            let sum = row.iter().fold(Estimate::default(), |sum, cell| sum.with(&cell[0]));
            (bin, sum.mean(samples), sum.standard_error(samples))
        })
        .collect();
    // Largest deviation of these rows' sums, in standard errors: of 32,768 paths and of the reference's.
    let worst = |d: &TracedMatrix| {
        rows.iter().fold(0.0f64, |worst, (bin, wanted, error)| {
            let own = error * (samples as f64 / 32_768.0).sqrt();
            worst.max((row_sum(&d.total, *bin, 0) - wanted).abs() / error.hypot(own))
        })
    };
    println!("{rows:?}, worst {:.1} standard errors", worst(&d));
    assert!(worst(&d) < 4.0, "{}", worst(&d));
    // Windows as holes, and paths that begin in the plane of their own window.
    let pass =
        "if material.kind == 0u { (*walk).weight = vec3<f32>(1.0); (*walk).position += direction * (hit.distance + 1e-3); return step; }";
    let absorbed = "if event.lobe == LOBE_NONE || largest((*walk).weight) <= 0.0 ||";
    for (path, from, to) in [
        ("shared/outside", absorbed, format!("{pass}\n{absorbed}").as_str()),
        (
            "daylight_matrix/paths",
            "offset_from_surface(window_point(window, sample_pair(index, 0u, seed)), -window.z)",
            "window_point(window, sample_pair(index, 0u, seed))",
        ),
    ] {
        let fault = mutation::with(path, from, to, || compute(&device, &b.scene, &own, tregenza(), &options, &Silent).unwrap());
        assert!(worst(&fault) > 6.0, "{to}: {}", worst(&fault));
    }
    // The same with black plates in place of the windows, the own one a little behind its plane.
    let mut plates = Builder { scene: holes.clone() };
    for y in [-4.0, -6.0] {
        plates.quad([[-3.0, y, 0.0], [3.0, y, 0.0], [3.0, y, 3.0], [-3.0, y, 3.0]], black);
    }
    plates.quad([[-0.5, 1e-3, 0.5], [0.5, 1e-3, 0.5], [0.5, 1e-3, 1.5], [-0.5, 1e-3, 1.5]], black);
    let sum = |scene: &Scene| {
        let d = compute(&device, scene, &own, tregenza(), &options, &Silent).unwrap();
        d.total.data().iter().map(|v| f64::from(*v)).sum::<f64>()
    };
    let (found, plate, open) = (d.total.data().iter().map(|v| f64::from(*v)).sum::<f64>(), sum(&plates.scene), sum(&holes));
    println!("sum of D {found:.2}, with black plates {plate:.2}, with the far windows as holes {open:.2}");
    const SAME: f64 = 0.01;
    assert!((found / plate - 1.0).abs() < SAME && open > 1.1 * found, "{found} {plate} {open}");
    let text = format!("{found:.2}; with plates {plate:.2}, with holes {open:.2}");
    crate::testing::measured("other-windows", &text, &crate::testing::percent(SAME));
}

#[test]
fn a_window_before_a_wall_sees_no_sky_and_states_what_a_gap_might_show() {
    let Some(device) = Device::for_tests("a walled-up window") else { return };
    let mut b = crate::kernels::trace::rooms::Builder::default();
    let black = b.grey(0.0);
    b.room([-1.0, -3.0, 0.0], [4.0, 1.0, 4.0], black, &[]);
    let (_, w) = crate::kernels::trace::rooms::asymmetric();
    let sky = ReinhartSky::new(1).unwrap();
    for first_round in [true, false] {
        let options = DaylightOptions { paths: 64, batches: 4, first_round, keep_batches: true, ..DaylightOptions::default() };
        let d = compute(&device, &b.scene, &w, sky, &options, &Silent).unwrap();
        assert!(d.total.data().iter().all(|v| *v == 0.0));
        // Half a path of 256, somewhere in the sky; later rounds add none.
        let wanted = if first_round { 0.5f64.sqrt() / 256.0 } else { 0.0 };
        for bin in [0, 60, 144] {
            let stated: f64 = (0..sky.len()).map(|p| f64::from(d.standard_error.at(bin, p)[1])).sum();
            assert!((stated - wanted).abs() < 1e-4 * wanted.max(1e-6), "{stated} {wanted}");
            let of_batches: f64 = d.batches.iter().map(|b| f64::from(b.total.at(bin, 0)[1])).sum();
            assert!(of_batches.abs() < 1e-9);
        }
    }
}

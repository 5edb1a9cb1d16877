//! Light paths of suns, against the f64 reference and what the coefficients call theirs.

use super::reference::light_row;
use super::tests::{House, house};
use super::*;
use crate::gpu::mutation;
use crate::kernels::sun_matrix::{Sun, SunMatrix};
use crate::kernels::trace::reference::Estimate;
use crate::kernels::trace::rooms::sensor;
use crate::kernels::view_matrix::mean_and_error;
use crate::progress::Silent;
use crate::statistics::student_95;
use glam::DVec3;
use rayon::prelude::*;

/// Large suns, which the reference's paths meet: into the south window, the west one, over the ground alone, and by way of the
/// mirror outside.
fn suns() -> Vec<Sun> {
    [[0.1, -1.0, 0.8], [-1.0, 0.2, 0.4], [0.6, 1.0, 0.7], [0.9, -0.6, 0.25]]
        .map(|d| Sun { direction: DVec3::from_array(d).normalize(), radius: 0.3 })
        .to_vec()
}

/// Nothing is near: the sensors' own paths have no part in it.
fn options() -> CoefficientOptions {
    CoefficientOptions {
        bounces: Some(4),
        light_paths: 64,
        near_samples: 16,
        visibility_rays: 16,
        near_radius: 1e-4,
        batches: 16,
        sun_paths: Some(512),
        keep_batches: true,
        ..CoefficientOptions::default()
    }
}

/// The house and what its suns bring, `[sensor][sun]`.
struct SunlitHouse {
    house: House,
    reference: Vec<Vec<[Estimate; 3]>>,
}

const SAMPLES: usize = 400_000;

impl SunlitHouse {
    fn new(bounces: u32) -> Self {
        let mut house = house();
        // Close to a sill, where connections are short.
        house.sensors.remove(3);
        let suns = suns();
        let sun_of = |d: DVec3| suns.iter().position(|s| s.direction.dot(d) > s.radius.cos());
        let row = |(i, s): (usize, &Sensor)| {
            let [_, _, row] =
                light_row(&house.scene, &house.windows, (s.position, s.direction), (suns.len(), &sun_of), bounces, SAMPLES, 11 + i as u64);
            row
        };
        let reference = house.sensors.par_iter().enumerate().map(row).collect();
        Self { house, reference }
    }

    fn compute(&self, device: &Device, options: &CoefficientOptions) -> std::result::Result<SunMatrix, String> {
        compute_suns(device, &self.house.scene, &self.house.windows, &self.house.sensors, &suns(), options, &Silent)
            .map_err(|e| e.to_string())
    }

    /// Deviations from the reference in standard errors.
    fn check(&self, device: &Device, options: &CoefficientOptions) -> std::result::Result<String, String> {
        let found = self.compute(device, options)?;
        let (mut text, mut squares, mut count, mut worst) = (String::new(), 0.0, 0.0, 0.0f64);
        for (sensor, row) in self.reference.iter().enumerate() {
            for (sun, wanted) in row.iter().enumerate() {
                for c in 0..3 {
                    let (value, error) = (f64::from(found.total.at(sensor, sun)[c]), f64::from(found.own_error.at(sensor, sun)[c]));
                    let (wanted, own) = (wanted[c].mean(SAMPLES), wanted[c].standard_error(SAMPLES));
                    if c == 1 {
                        text += &format!("sensor {sensor}, sun {sun}: {value:.5} ± {error:.5}, {wanted:.5} ± {own:.5}\n");
                    }
                    let deviation = error.hypot(own);
                    // Too rare in the reference for a normal distribution.
                    if wanted * SAMPLES as f64 > 100.0 {
                        let z = (value - wanted) / deviation;
                        squares += z * z;
                        count += 1.0;
                        worst = worst.max(z.abs());
                    }
                }
            }
        }
        text += &format!("{count} entries, mean z² {:.2}, worst {worst:.1}", squares / count);
        // Channels go together.
        if squares / count < 1.0 + 3.0 * (6.0f64 / count).sqrt() && worst < 4.5 { Ok(text) } else { Err(text) }
    }
}

#[test]
fn light_paths_of_suns_bring_what_reference_paths_to_them_bring() {
    let Some(device) = Device::for_tests("light paths of suns") else { return };
    for bounces in [4, 2] {
        let lit = SunlitHouse::new(bounces);
        let options = CoefficientOptions { bounces: Some(bounces), ..options() };
        println!("{}", lit.check(&device, &options).unwrap_or_else(|e| panic!("{e}")));
    }
}

#[test]
fn faults_in_the_light_paths_of_suns_are_found_out() {
    let Some(device) = Device::for_tests("faults in the light paths of suns") else { return };
    let lit = SunlitHouse::new(4);
    println!("{}", lit.check(&device, &options()).unwrap_or_else(|e| panic!("without a fault: {e}")));
    let mut survivors = Vec::new();
    for (path, from, to) in [
        ("coefficients/sun_starts", "(cosine * window.area / area * total)", "(cosine * total)"),
        ("coefficients/sun_starts", "light.weight * (total * PI)", "light.weight * total"),
        ("coefficients/sun_starts", "(f32(params.samples) / f32(count))", "1.0"),
        ("coefficients/sun_starts", "params.first_pane + w)", "params.first_pane)"),
        ("coefficients/sunlight", "(cosine * FRAC_1_PI)", "FRAC_1_PI"),
        ("coefficients/sunlight", "result.weight *= sum;", ""),
        ("coefficients/gather", "params.sunlit, (label", "OTHER, (label"),
    ] {
        match mutation::with(path, from, to, || lit.check(&device, &options())) {
            Ok(found) => survivors.push(format!("{path}: '{from}' may be '{to}': {found}")),
            Err(found) => println!("{path}: '{to}' is found out: {}", found.lines().last().unwrap_or_default()),
        }
    }
    assert!(survivors.is_empty(), "{}", survivors.join("\n"));
}

/// An even sky is a sun as large as the sky's half: what batches call sunlit is what a sun as large as a patch brings.
#[test]
fn the_sunlit_part_of_the_coefficients_agrees_with_the_reference() {
    let Some(device) = Device::for_tests("the sunlit part of the coefficients") else { return };
    let mut house = house();
    house.sensors.remove(3);
    let sky = ReinhartSky::new(1).unwrap();
    // Without what few hits leave open, which has either sign.
    let options = CoefficientOptions { first_round: false, ..options() };
    let c = compute(&device, &house.scene, &house.windows, &house.sensors, sky, &options, &Silent).unwrap();
    for (row, s) in house.sensors.iter().enumerate() {
        let [_, _, reference] =
            light_row(&house.scene, &house.windows, (s.position, s.direction), (1, &|_| Some(0)), 4, SAMPLES / 4, 17 + row as u64);
        for channel in 0..3 {
            let of = |m: &Matrix<f32>| m.row(row).iter().skip(channel).step_by(3).map(|v| f64::from(*v)).sum::<f64>();
            let batches: Vec<f64> = c.batches.iter().map(|b| of(b.sunlit.as_ref().unwrap()) - of(&b.direct)).collect();
            let (found, error) = mean_and_error(&batches);
            let (wanted, own) = (reference[0][channel].mean(SAMPLES / 4), reference[0][channel].standard_error(SAMPLES / 4));
            println!("sensor {row}, channel {channel}: {found:.5} ± {error:.5}, {wanted:.5} ± {own:.5}");
            assert!((found - wanted).abs() < 4.5 * error.hypot(own), "{found} {wanted}");
        }
        for b in &c.batches {
            let sunlit = b.sunlit.as_ref().unwrap();
            assert!(b.total.data().iter().zip(sunlit.data()).zip(b.direct.data()).all(|((t, s), d)| s <= t && d <= s));
        }
    }
}

#[test]
fn equal_seeds_give_equal_bits_however_suns_and_sensors_are_cut() {
    let Some(device) = Device::for_tests("chunks of suns") else { return };
    let house = house();
    let sensors: Vec<Sensor> = (0..23).map(|i| sensor([0.1 + 0.15 * f64::from(i), 2.0, 0.8], [0.0, 0.0, 1.0])).collect();
    let many: Vec<Sun> = (0..9).map(|i| Sun::new(DVec3::new(-2.0 + 0.5 * f64::from(i), -1.0, 1.0))).collect();
    let options = CoefficientOptions { bounces: None, sun_paths: Some(8), batches: 4, light_paths: 8, near_samples: 16, ..options() };
    let run = |sensors: &[Sensor], suns: &[Sun], options: &CoefficientOptions| {
        compute_suns(&device, &house.scene, &house.windows, sensors, suns, options, &Silent).unwrap()
    };
    let options = CoefficientOptions { near_radius: 0.4, ..options };
    let whole = run(&sensors, &many, &options);
    assert!(whole.total.data().iter().any(|v| *v > 0.0));
    // Two suns at a time.
    let cut = run(&sensors, &many, &CoefficientOptions { memory: 2 * 4 * 23 * 4 * 6, ..options });
    assert!(cut.statistics.paths > 0);
    assert_eq!((&whole.total, &whole.own_error), (&cut.total, &cut.own_error));
    // A sensor's light depends on no other sensor, a sun's on no later one.
    let few = run(&sensors[..5], &many[..3], &options);
    for row in 0..5 {
        assert_eq!(few.total.row(row), &whole.total.row(row)[..9]);
    }
}

/// Other random numbers differ by the stated errors.
#[test]
fn stated_errors_of_suns_cover_the_truth() {
    let Some(device) = Device::for_tests("errors of the light paths of suns") else { return };
    let house = house();
    let suns: Vec<Sun> = (0..12).map(|i| Sun::new(DVec3::new(-1.0 + 0.2 * f64::from(i), -1.0, 0.4 + 0.1 * f64::from(i)))).collect();
    let options = CoefficientOptions { bounces: None, sun_paths: Some(128), batches: 8, visibility_rays: 4, near_radius: 0.4, ..options() };
    let run = |seed: u32, paths: u32| {
        let options = CoefficientOptions { seed, sun_paths: Some(paths), ..options };
        compute_suns(&device, &house.scene, &house.windows, &house.sensors[..3], &suns, &options, &Silent).unwrap()
    };
    let truth = run(1000, 4096);
    let seeds = 24;
    let (mut covered, mut all, mut squares) = (0, 0, 0.0);
    for seed in 1..=seeds {
        let found = run(seed, 128);
        for row in 0..3 {
            for sun in 0..suns.len() {
                let of = |m: &Matrix<f32>| f64::from(m.at(row, sun)[1]);
                let error = of(&found.own_error).hypot(of(&truth.own_error));
                if error > 0.0 {
                    let z = (of(&found.total) - of(&truth.total)) / error;
                    covered += usize::from(z.abs() < student_95(7));
                    squares += z * z;
                    all += 1;
                }
            }
        }
    }
    let share = f64::from(covered as u32) / f64::from(all as u32);
    let z2 = squares / f64::from(all as u32);
    println!("{covered} of {all}: {share:.3}, mean z² {z2:.2}");
    // Student's distribution of seven degrees has a variance of 7/5. Binomial noise of 864 cases is 0.7 %.
    assert!((0.92..0.985).contains(&share) && (0.8..2.2).contains(&z2), "{share} {z2}");
}

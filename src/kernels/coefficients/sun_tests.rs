//! Light paths of suns, against the f64 reference and what the coefficients call theirs.

use super::reference::light_row;
use super::tests::{House, closed_house, house};
use super::*;
use crate::bins::KlemsBasis;
use crate::gpu::mutation;
use crate::kernels::sun_matrix::{Sun, SunMatrix};
use crate::kernels::trace::reference::Estimate;
use crate::kernels::trace::rooms::{Builder, sensor, window};
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
        sun_sets: 4 * COPIES as u32,
        keep_batches: true,
        ..CoefficientOptions::default()
    }
}

/// Each sun so many times, where few rays go to each.
const COPIES: usize = 8;

/// Everything by the sensors' own paths.
fn own_paths() -> CoefficientOptions {
    CoefficientOptions { light_paths: 0, sun_paths: Some(256), ..options() }
}

/// A good part by light paths, a good part by the sensors' own.
fn both() -> CoefficientOptions {
    CoefficientOptions { near_radius: 1.2, sun_paths: Some(256), ..options() }
}

/// A house and what its suns bring, `[sensor][sun]`.
struct SunlitHouse {
    house: House,
    bounces: u32,
    /// With light paths, and by the sensors' own paths alone.
    reference: [Vec<Vec<[Estimate; 3]>>; 2],
}

const SAMPLES: usize = 400_000;

impl SunlitHouse {
    fn new(house: House, bounces: u32) -> Self {
        let suns = suns();
        let sun_of = |d: DVec3| suns.iter().position(|s| s.direction.dot(d) > s.radius.cos());
        let row = |(i, s): (usize, &Sensor)| {
            let [_, _, all, own] =
                light_row(&house.scene, &house.windows, (s.position, s.direction), (suns.len(), &sun_of), bounces, SAMPLES, 11 + i as u64);
            (all, own)
        };
        let (all, own) = house.sensors.par_iter().enumerate().map(row).unzip();
        Self { house, bounces, reference: [all, own] }
    }

    /// What each sun brings, the mean of its copies: their rays, light paths and, in sets of their own, surfaces are independent.
    fn compute(&self, device: &Device, options: &CoefficientOptions) -> std::result::Result<SunMatrix, String> {
        let suns = suns();
        let all: Vec<Sun> = (0..COPIES).flat_map(|_| suns.clone()).collect();
        let options = CoefficientOptions { bounces: Some(self.bounces), ..*options };
        let found = compute_suns(device, &self.house.scene, &self.house.windows, &self.house.sensors, &all, &options, &Silent)
            .map_err(|e| e.to_string())?;
        let error = found.standard_error();
        let mut mean = SunMatrix::zeros(self.house.sensors.len(), suns.len());
        for row in 0..self.house.sensors.len() {
            for sun in 0..suns.len() {
                for c in 0..3 {
                    let of = |m: &Matrix<f32>, k: usize| f64::from(m.at(row, k * suns.len() + sun)[c]);
                    mean.total.at_mut(row, sun)[c] = ((0..COPIES).map(|k| of(&found.total, k)).sum::<f64>() / COPIES as f64) as f32;
                    mean.own_error.at_mut(row, sun)[c] =
                        ((0..COPIES).map(|k| of(&error, k).powi(2)).sum::<f64>().sqrt() / COPIES as f64) as f32;
                }
            }
        }
        Ok(mean)
    }

    /// Deviations from the reference in standard errors.
    fn check(&self, device: &Device, options: &CoefficientOptions) -> std::result::Result<String, String> {
        let found = self.compute(device, options)?;
        let reference = &self.reference[usize::from(options.light_paths == 0)];
        let (mut text, mut squares, mut count, mut worst) = (String::new(), 0.0, 0.0, 0.0f64);
        for (sensor, row) in reference.iter().enumerate() {
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
fn suns_bring_what_reference_paths_to_them_bring() {
    let Some(device) = Device::for_tests("suns behind glass") else { return };
    for bounces in [4, 2] {
        for (house, ways) in [(house(), [options(), own_paths()]), (closed_house(), [own_paths(), both()])] {
            let lit = SunlitHouse::new(house, bounces);
            for options in ways {
                let named = |e| format!("-ab {bounces}, {} light paths, near {}: {e}", options.light_paths, options.near_radius);
                println!("{}", lit.check(&device, &options).map(named).unwrap_or_else(|e| panic!("{}", named(e))));
            }
        }
    }
}

#[test]
fn faults_in_what_suns_bring_are_found_out() {
    let Some(device) = Device::for_tests("faults in what suns bring") else { return };
    let [open, closed, once] =
        [(house(), 4), (closed_house(), 4), (closed_house(), 2)].map(|(house, bounces)| SunlitHouse::new(house, bounces));
    let ways = [(&open, options()), (&closed, options()), (&closed, both()), (&once, own_paths()), (&once, both())];
    for (lit, options) in ways {
        println!("{}", lit.check(&device, &options).unwrap_or_else(|e| panic!("without a fault: {e}")));
    }
    let mut survivors = Vec::new();
    for (path, from, to) in [
        ("coefficients/sun_starts", "(cosine * window.area / area * total)", "(cosine * total)"),
        ("coefficients/sun_starts", "light.weight * (total * PI)", "light.weight * total"),
        ("coefficients/sun_starts", "(f32(params.samples) / f32(count))", "1.0"),
        ("coefficients/sun_starts", "params.first_pane + w)", "params.first_pane)"),
        ("coefficients/sunlight", "(cosine * FRAC_1_PI)", "FRAC_1_PI"),
        ("coefficients/sunlight", "result.weight *= sum;", ""),
        ("coefficients/gather", "params.sunlit, (label", "OTHER, (label"),
        ("coefficients/sun_surfaces", "ray.weight / f32(params.straight)", "ray.weight / f32(params.samples)"),
        ("coefficients/sun_surfaces", "1.0 / f32(params.samples - params.straight)", "1.0 / f32(params.samples)"),
        ("coefficients/sun_surfaces", "path.near_share, share_of_sky(path)", "share_of_sky(path), share_of_sky(path)"),
        ("coefficients/sun_surfaces", "path.near_share, share_of_sky(path)", "path.near_share, path.near_share"),
        ("coefficients/sun_surfaces", "chosen.flux *= sum / chosen.strength;", ""),
        ("coefficients/sun_surfaces", "ray.weight * weight * path.near_share", "ray.weight * path.near_share"),
        ("coefficients/sun_surfaces", "params.most_bounces - path.bounces", "params.most_bounces"),
        ("coefficients/sun_surfaces", "step.weight * FRAC_1_PI, 0.0, 1.0, true", "step.weight * FRAC_1_PI, 1.0, 0.0, true"),
        ("coefficients/sun_gather", "counted * cosine * whole", "counted * whole"),
        ("coefficients/sun_gather", "select(surface.beside, surface.through,", "select(surface.beside, surface.beside,"),
        ("coefficients/sun_gather", "select(surface.beside, surface.through,", "select(surface.through, surface.through,"),
        ("coefficients/sun_gather", "sum <= threshold", "sum < 0.0"),
        ("coefficients/sun_gather", "passed * surface.flux", "surface.flux"),
        ("coefficients/from_sensor", "max(1.0 - ratio * ratio, 0.0)", "1.0"),
    ] {
        let all = || ways.iter().try_for_each(|(lit, options)| lit.check(&device, options).map(|_| ()));
        match mutation::with(path, from, to, all) {
            Ok(()) => survivors.push(format!("{path}: '{from}' may be '{to}'")),
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
        let [_, _, reference, _] =
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

/// How far other random numbers deviate from the truth, in stated errors.
#[derive(Default)]
struct Coverage {
    covered: f64,
    all: f64,
    squares: f64,
}

impl Coverage {
    fn add(&mut self, deviation: f64, error: f64) {
        self.covered += f64::from(u8::from(deviation.abs() < student_95(7) * error));
        self.squares += (deviation / error).powi(2);
        self.all += 1.0;
    }

    fn share(&self) -> f64 {
        self.covered / self.all
    }

    fn z2(&self) -> f64 {
        self.squares / self.all
    }
}

/// Of suns that bring light, of such that bring none, and of their sum, as a year has it.
#[test]
fn stated_errors_of_suns_cover_the_truth_and_are_not_larger_than_it() {
    let Some(device) = Device::for_tests("errors of what suns bring") else { return };
    let suns: Vec<Sun> = (0..12).map(|i| Sun::new(DVec3::new(-1.0 + 0.2 * f64::from(i), -1.0, 0.4 + 0.1 * f64::from(i)))).collect();
    let options = CoefficientOptions { bounces: None, batches: 8, visibility_rays: 4, near_radius: 0.4, sun_sets: 4, ..options() };
    for (name, house) in [("open", house()), ("closed", closed_house())] {
        let run = |seed: u32, paths: u32, batches: u32| {
            let options = CoefficientOptions { seed, sun_paths: Some(paths), batches, ..options };
            compute_suns(&device, &house.scene, &house.windows, &house.sensors, &suns, &options, &Silent).unwrap()
        };
        let truth = run(1000, 1024, 64);
        let truth_error = truth.standard_error();
        let of = |m: &Matrix<f32>, row: usize, sun: usize| f64::from(m.at(row, sun)[1]);
        let (mut lit, mut years, mut dark) = (Coverage::default(), Coverage::default(), 0.0f64);
        for seed in 1..=24 {
            let found = run(seed, 128, 8);
            let stated = found.standard_error();
            for row in 0..house.sensors.len() {
                let (mut year, mut own, mut shared) = (0.0, 0.0, [0.0; 4]);
                for sun in 0..suns.len() {
                    let (value, error, wanted) = (of(&found.total, row, sun), of(&stated, row, sun), of(&truth.total, row, sun));
                    let uncertain = of(&truth_error, row, sun);
                    if wanted > 4.0 * uncertain && wanted > 0.0 {
                        lit.add(value - wanted, error.hypot(uncertain));
                    } else if wanted == 0.0 {
                        dark = dark.max(error / (0..suns.len()).map(|s| of(&truth.total, row, s) / 12.0).sum::<f64>());
                    }
                    year += value - wanted;
                    own += of(&found.own_error, row, sun).powi(2) + uncertain.powi(2);
                    shared[sun % 4] += of(&found.shared_error, row, sun);
                }
                years.add(year, (own + shared.iter().map(|e| e * e).sum::<f64>()).sqrt());
            }
        }
        println!(
            "{name}: {} lit pairs: {:.3}, mean z² {:.2}; sums of suns: {:.3}, {:.2}; of none at most {dark:.3} of the mean sun",
            lit.all,
            lit.share(),
            lit.z2(),
            years.share(),
            years.z2()
        );
        // Student's distribution of seven degrees has a variance of 7/5; binomial noise of a thousand pairs is 0.7 %.
        assert!((0.93..0.985).contains(&lit.share()) && (0.6..2.0).contains(&lit.z2()), "{name}: {} {}", lit.share(), lit.z2());
        assert!(years.share() > 0.9 && (0.3..2.0).contains(&years.z2()), "{name}: {} {}", years.share(), years.z2());
    }
}

/// Form factor from a sensor to a polygon before it (Lambert).
fn form_factor(eye: DVec3, normal: DVec3, corners: [DVec3; 4]) -> f64 {
    let edge = |i: usize| {
        let (a, b) = (corners[i] - eye, corners[(i + 1) % 4] - eye);
        a.angle_between(b) * a.cross(b).normalize().dot(normal)
    };
    (0..4).map(edge).sum::<f64>().abs() / std::f64::consts::TAU
}

/// ρ·E·F: of the ground in the sun and of a floor on which it shines, through a pane that is nothing but an opening of a black room, and
/// of the ground in the open.
#[test]
fn ground_and_floor_in_the_sun_give_reflectance_times_irradiance_times_form_factor() {
    let Some(device) = Device::for_tests("surfaces in the sun") else { return };
    let nothing = Pane { transmissivity: [1.0; 3], refraction_index: 1.0 };
    let mut b = Builder::default();
    let (black, ground, floor) = (b.grey(0.0), b.grey(0.4), b.grey(0.5));
    b.room([0.0; 3], [1.0; 3], black, &[2, 4]);
    b.quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], floor);
    b.quad([[-400.0, -400.0, -0.2], [400.0, -400.0, -0.2], [400.0, 400.0, -0.2], [-400.0, 400.0, -0.2]], ground);
    let south = window([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    let windows = [GlazedWindow { window: south, pane: nothing }];
    let sun = Sun::new(DVec3::new(0.1, -1.0, 0.9));
    let on_ground = sun.direction.z;
    let sensors = [sensor([0.5, 0.5, 0.8], [0.0, -1.0, 0.0]), sensor([0.5, -2.0, 3.0], [0.0, -1.0, 0.0])];
    // Up to the ground's end.
    let top = 0.8 - 0.5 / 400.0;
    let below = form_factor(
        sensors[0].position,
        DVec3::NEG_Y,
        [[0.0, 0.0], [1.0, 0.0], [1.0, top], [0.0, top]].map(|[x, z]| DVec3::new(x, 0.0, z)),
    );
    let ahead = [[-400.0, -400.0], [400.0, -400.0], [400.0, -2.0], [-400.0, -2.0]].map(|[x, y]| DVec3::new(x, y, -0.2));
    // The floor, too, is seen by the first sensor: as far as the sun shines.
    let reach = 1.0 / 0.9;
    let in_sun = |y: f64| [0.0, 1.0].map(|x: f64| (x - 0.1 * y).clamp(0.0, 1.0));
    let n = 400;
    let of_floor = |eye: DVec3, normal: DVec3| -> f64 {
        (0..n)
            .map(|i| {
                let (y, width) = ((f64::from(i) + 0.5) / f64::from(n), 1.0 / f64::from(n));
                let [x0, x1] = in_sun(y);
                if y < reach { form_strip(eye, normal, [x0, x1], y, width) } else { 0.0 }
            })
            .sum()
    };
    let wanted = [
        0.4 * on_ground * below + 0.5 * on_ground * of_floor(sensors[0].position, DVec3::NEG_Y),
        0.4 * on_ground * form_factor(sensors[1].position, DVec3::NEG_Y, ahead),
    ];
    let options = CoefficientOptions { bounces: Some(2), near_radius: 0.4, sun_paths: Some(1024), batches: 64, ..options() };
    let found = compute_suns(&device, &b.scene, &windows, &sensors, &[sun], &options, &Silent).unwrap();
    for (row, wanted) in wanted.into_iter().enumerate() {
        let of = |m: &Matrix<f32>| f64::from(m.at(row, 0)[1]) / sun.solid_angle();
        let (value, error) = (of(&found.total), of(&found.standard_error()));
        println!("sensor {row}: {value:.5} ± {error:.5}, {wanted:.5}");
        assert!((value - wanted).abs() < 4.5 * error + 0.003 * wanted && error < 0.03 * wanted, "{value} ± {error}, not {wanted}");
    }
}

/// Form factor of a strip of the floor.
fn form_strip(eye: DVec3, normal: DVec3, [x0, x1]: [f64; 2], y: f64, width: f64) -> f64 {
    let n = 400;
    (0..n)
        .map(|i| {
            let to = DVec3::new(x0 + (x1 - x0) * (f64::from(i) + 0.5) / f64::from(n), y, 0.0) - eye;
            let d2 = to.length_squared();
            to.dot(normal).max(0.0) * to.z.abs() / (d2 * d2) / std::f64::consts::PI * (x1 - x0) * width / f64::from(n)
        })
        .sum()
}

//! The whole chain against Radiance's converged results for the tutorial room: a year of hours at
//! 100 sensors, four BSDFs, both at `-ab 4`.
//!
//! Two systems and every eleventh hour are part of the repository; all of it lies in the reference data
//! (`LUCARNE_SHARED`, else `../shared`).

mod device;

use device::device;
use lucarne::bins::ReinhartSky;
use lucarne::gpu::Device;
use lucarne::kernels::daylight_matrix::{self, DaylightOptions};
use lucarne::kernels::product::{Native, chain};
use lucarne::kernels::trace::WindowSurfaces;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::scene::{read_scene, read_windows};
use lucarne::simulate::{self, Inputs, Project};
use lucarne::sky::{SkyOptions, sky_matrix};
use lucarne::weather::Weather;
use lucarne::{Warnings, matrix::Matrix};
use std::fs;
use std::path::Path;

#[path = "../src/testing.rs"]
mod testing;
use testing::{measured, percent};

/// Runs the tutorial room with one BSDF; the folder keeps V and D for the next.
fn illuminance(device: &Device, data: &Path, folder: &Path, bsdf: &str, seed: u32) -> Matrix<f32> {
    let room = data.join("tutorial_room");
    let (room, weather) = (room.display(), testing::new_york().display().to_string());
    let text = format!(
        r#"
[weather]
file = "{weather}"
[scene]
files = ["{room}/materials.rad", "{room}/room.rad"]
[[window]]
name = "south"
surface = "{room}/objects/GlazingVmtx.rad"
bsdf = "{room}/bsdf/{bsdf}.xml"
[[sensors]]
name = "workplane"
points = "{room}/points.txt"
[method]
bounces = 4
sky_subdivision = 1
[quality]
preset = "standard"
seed = {seed}
"#
    );
    let file = folder.join("project.toml");
    fs::write(&file, text).unwrap();
    let out = folder.join(format!("out{seed}"));
    let mut warnings = Warnings::new();
    let project = Project::read(&file).unwrap();
    let inputs = Inputs::read(&project, &mut warnings).unwrap();
    simulate::run(device, &project, &inputs, &out, &Silent, &mut warnings).unwrap();
    read_matrix(&out.join("illuminance/workplane.mtx")).unwrap().matrix
}

/// (D of a window that is a hole − D of one that absorbs)·S, `[bin][hour]`: light that comes back to the window
/// from outside and goes on in the room, which a run leaves out and the references hold.
fn returned_light(device: &Device, data: &Path) -> Matrix<f32> {
    let (room, mut warnings) = (data.join("tutorial_room"), Warnings::new());
    let scene = read_scene(&["materials.rad".into(), "room.rad".into()], &room, &mut warnings).unwrap();
    let window = read_windows(Path::new("objects/GlazingVmtx.rad"), &room, &mut warnings).unwrap().remove(0);
    let sky = ReinhartSky::new(1).unwrap();
    let d = |own_window| {
        let options = DaylightOptions { bounces: Some(4), own_window, ..DaylightOptions::default() };
        daylight_matrix::compute(device, &scene, &window, sky, &options, &Silent).unwrap().total
    };
    let (hole, absorbing) = (d(WindowSurfaces::Open), d(WindowSurfaces::Absorb));
    let difference = hole.data().iter().zip(absorbing.data()).map(|(a, b)| a - b).collect();
    let difference = Matrix::from_data(hole.rows(), hole.cols(), 3, difference).unwrap();
    let weather = Weather::read(&testing::new_york(), &mut warnings).unwrap();
    chain(&Native, &[&difference, &sky_matrix(&weather, &SkyOptions::default(), &Silent).unwrap()]).unwrap()
}

const HOURS: usize = 8760;

/// How far results lie from the reference, as fractions.
struct Distance {
    bias: f64,
    largest_annual: f64,
    median_hourly: f64,
}

/// The reference holds each hour, or one of several from the first on.
fn distance(lux: &Matrix<f64>, reference: &Matrix<f32>) -> Distance {
    let (sensors, hours) = (lux.rows(), reference.rows());
    let step = HOURS.div_ceil(hours);
    let mut annual = Vec::new();
    let mut hourly = Vec::new();
    let (mut all, mut all_reference) = (0.0, 0.0);
    for s in 0..sensors {
        let (mut sum, mut wanted_sum, mut squares, mut wanted_squares) = (0.0, 0.0, 0.0, 0.0);
        for h in 0..hours {
            let (value, wanted) = (lux.at(s, h * step)[0], f64::from(reference.at(h, s)[0]));
            sum += value;
            wanted_sum += wanted;
            squares += (value - wanted).powi(2);
            wanted_squares += wanted.powi(2);
        }
        annual.push((sum / wanted_sum - 1.0).abs());
        hourly.push((squares / wanted_squares).sqrt());
        all += sum;
        all_reference += wanted_sum;
    }
    hourly.sort_by(f64::total_cmp);
    Distance {
        bias: (all / all_reference - 1.0).abs(),
        largest_annual: annual.into_iter().fold(0.0, f64::max),
        median_hourly: hourly[sensors / 2],
    }
}

/// The references were made with the weights 47.4 119.9 11.6 instead of 47.448 119.951 11.601;
/// the light is nearly that of the sky, 0.96 1.004 1.118.
const REFERENCE_WEIGHTS: f64 = (47.4 * 0.96 + 119.9 * 1.004 + 11.6 * 1.118) / (47.44827 * 0.96 + 119.95052 * 1.004 + 11.60121 * 1.118);

/// Bounds on the mean of [`SEEDS`]: of all light, of a sensor's annual sum.
const BIAS: f64 = 0.005;
const ANNUAL: f64 = 0.015;

/// Seeds whose mean is compared: the issue is bias, and the worst of 100 sensors must not decide
/// by its own noise.
const SEEDS: std::ops::RangeInclusive<u32> = 1..=3;

#[test]
fn a_year_in_the_tutorial_room_agrees_with_radiance() {
    let Some(device) = device("the whole chain") else { return };
    let data = testing::tutorial();
    let folder = tempfile::tempdir().unwrap();
    let returned = returned_light(&device, &data);
    // Hourly errors: 2 % where the glazing is clear, 1 % where it scatters. The references have
    // themselves 0.5 % and 0.23 %.
    let systems = [("clear", 0.02), ("blinds", 0.01), ("ven0", 0.02), ("ven45", 0.01)];
    let mut all = Vec::new();
    for (bsdf, hourly_limit) in systems {
        let file = data.join(format!("reference/sensors/annual_MF1_{bsdf}.ill"));
        if !file.exists() {
            testing::skip(testing::Need::Shared, &format_args!("no year through {bsdf}"));
            continue;
        }
        let reference = read_matrix(&file).unwrap().matrix;
        let mut mean = Matrix::<f64>::zeros(reference.cols(), HOURS, 1);
        for seed in SEEDS {
            let lux = illuminance(&device, &data, folder.path(), bsdf, seed);
            assert_eq!((lux.rows(), lux.cols(), lux.components()), (100, HOURS, 1));
            for (m, &v) in mean.data_mut().iter_mut().zip(lux.data()) {
                *m += f64::from(v) * REFERENCE_WEIGHTS / SEEDS.count() as f64;
            }
        }
        // Radiance's windows are holes for light that comes back to them from outside.
        let matrix = |name: &str| read_matrix(&folder.path().join(format!("out1/matrices/{name}.mtx"))).unwrap().matrix;
        let back = chain(&Native, &[&matrix("V_workplane"), &matrix("T_south"), &returned]).unwrap();
        for (m, rgb) in mean.data_mut().iter_mut().zip(back.data().chunks_exact(3)) {
            *m += rgb.iter().zip([47.4, 119.9, 11.6]).map(|(v, weight)| f64::from(*v) * weight).sum::<f64>();
        }
        let found = distance(&mean, &reference);
        eprintln!(
            "{bsdf}: bias {:.2} %, annual sums within {:.2} %, median hourly error {:.2} %",
            100.0 * found.bias,
            100.0 * found.largest_annual,
            100.0 * found.median_hourly
        );
        assert!(found.bias < BIAS && found.largest_annual < ANNUAL && found.median_hourly < hourly_limit, "{bsdf}");

        all.push(found);
        // The comparison can fail: with the room mirrored (sensors of a row in reverse order) the
        // hours no longer agree, though the annual sums nearly do. Blinds scatter too well for that.
        if bsdf != "clear" {
            continue;
        }
        let mut mirrored = mean.clone();
        for s in 0..100 {
            for h in 0..HOURS {
                // points.txt runs along y first: 10 rows of 10 with constant x.
                mirrored.at_mut(s, h)[0] = mean.at((9 - s / 10) * 10 + s % 10, h)[0];
            }
        }
        assert!(distance(&mirrored, &reference).median_hourly > 3.0 * hourly_limit, "{bsdf}");
    }
    let worst = |of: &[Distance]| {
        let most = |value: fn(&Distance) -> f64| percent(of.iter().map(value).fold(0.0, f64::max));
        let (bias, annual, hourly) = (most(|d| d.bias), most(|d| d.largest_annual), most(|d| d.median_hourly));
        format!("bias {bias}, annual sums within {annual}, median hourly error {hourly}")
    };
    let held = |limits: &str| format!("{}, {}, {limits}", percent(BIAS), percent(ANNUAL));
    let limits: Vec<String> = systems.iter().map(|(_, limit)| percent(*limit)).collect();
    // Part of the references is no year.
    if all.len() == systems.len() {
        measured("year-clear", &worst(&all[..1]), &held(&limits[0]));
        measured("year-blinds", &worst(&all[1..]), &held(&limits[1..].join(" / ")));
    }
    measured("device", &device.summary().name, "");
}

//! Annual glare with the terms of five phases: hour by hour against float pictures made from the
//! definition, against sensors in the eye's place, against Radiance's pictures, and over seeds.

mod device;

use device::device;
use lucarne::camera::{Raster, View};
use lucarne::glare::{Analyser, Disc, PixelGeometry, Settings};
use lucarne::gpu::Device;
use lucarne::image::{Picture, exr};
use lucarne::kernels::sun_matrix::pixels::{SeenDisc, SparsePicture};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::simulate::store::sun_pictures::SunPictures;
use lucarne::simulate::{Inputs, Project, run};
use lucarne::sky::{SkyOptions, sky_matrix};
use lucarne::weather::Weather;
use lucarne::{Warnings, glare};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

#[path = "../src/testing.rs"]
mod testing;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/blinds");

/// Days, clear but for the mornings, so far in the north that the low sun is seen between the slats.
fn weather(days: &[(u32, u32)]) -> String {
    let header = "place Test\nlatitude 62\nlongitude 75\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n";
    let hour = |(month, day): (u32, u32), h: u32| {
        let (direct, diffuse) = match h {
            8..11 => (200, 90),
            11..18 => (300, 110),
            _ => (0, 0),
        };
        format!("{month} {day} {h}.5 {direct} {diffuse}\n")
    };
    header.to_string() + &days.iter().flat_map(|&d| (0..24).map(move |h| hour(d, h))).collect::<String>()
}

/// What the sun is traced through in the room with blinds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Through {
    Slats,
    ScatteringData,
}

/// Runs a project of the room with blinds.
fn blinds(folder: &Path, days: &[(u32, u32)], through: Through, method: &str, size: usize, quality: &str) -> PathBuf {
    let through = match through {
        Through::Slats => format!("shade = \"{SCENE}/blinds.rad\""),
        Through::ScatteringData => format!("tensor_tree = \"{SCENE}/blind.xml\""),
    };
    std::fs::write(folder.join("w.wea"), weather(days)).unwrap();
    let text = format!(
        "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"{SCENE}/room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"{SCENE}/window.rad\"\n\
         bsdf = \"{SCENE}/blind.xml\"\n{through}\n[[view]]\nname = \"seat\"\nfile = \"{SCENE}/views/seat.vf\"\n\
         resolution = [{size}, {size}]\n{method}\n[quality]\n{quality}\n"
    );
    std::fs::write(folder.join("project.toml"), text).unwrap();
    run_project(&folder.join("project.toml"), &folder.join("out"));
    folder.join("out")
}

fn run_project(file: &Path, out: &Path) {
    let project = Project::read(file).unwrap();
    let mut warnings = Warnings::new();
    let inputs = Inputs::read(&project, &mut warnings).unwrap();
    let summary = run(&Device::shared().unwrap(), &project, &inputs, out, &Silent, &mut warnings).unwrap();
    assert_eq!(summary.phases, 5);
    // Nothing says any more that pictures or glare are three-phase.
    assert!(summary.warnings.iter().all(|w| !w.contains("three")), "{:?}", summary.warnings);
}

/// Columns of `glare/NAME.csv` by hour: DGP, its standard error, Ev, number of sources.
fn year(out: &Path, name: &str) -> Vec<[f64; 4]> {
    let text = std::fs::read_to_string(out.join("glare").join(format!("{name}.csv"))).unwrap();
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').skip(1).take(4).map(|c| c.parse().unwrap()).collect();
        cells.try_into().unwrap()
    };
    text.lines().skip(1).map(row).collect()
}

fn matrix(out: &Path, name: &str) -> Matrix<f32> {
    read_matrix(&out.join("matrices").join(format!("{name}.mtx"))).unwrap().matrix
}

/// The picture of an hour by its definition, I = V·T·D·S − Vd·T·Dd·Sds + C·Ssun, in f64.
struct Definition {
    views: [Matrix<f32>; 2],
    transmission: Matrix<f32>,
    daylight: [Matrix<f32>; 2],
    skies: [Matrix<f32>; 2],
    suns: SunPictures,
}

impl Definition {
    fn read(out: &Path, weather: &Path) -> Self {
        let weather = Weather::read(weather, &mut Warnings::new()).unwrap();
        let options = |sky: bool| SkyOptions { sky, ..SkyOptions::default() };
        Self {
            views: ["V_seat", "V_seat_direct"].map(|n| matrix(out, n)),
            transmission: matrix(out, "T_south"),
            daylight: ["D_south", "D_south_direct"].map(|n| matrix(out, n)),
            skies: [true, false].map(|sky| sky_matrix(&weather, &options(sky), &Silent).unwrap()),
            suns: SunPictures::open(&out.join("matrices/C_seat.suns")).unwrap().pictures,
        }
    }

    /// With the sun's disc on its pixels, or without it.
    fn picture(&self, hour: usize, with_disc: bool) -> Vec<[f32; 3]> {
        let pixels = self.views[0].rows();
        let mut picture = vec![[0.0f64; 3]; pixels];
        for (term, sign) in [1.0, -1.0].into_iter().enumerate() {
            let times = |m: &Matrix<f32>, v: &[[f64; 3]]| -> Vec<[f64; 3]> {
                let sum = |row: usize, c: usize| m.row(row).as_chunks::<3>().0.iter().zip(v).map(|(m, v)| f64::from(m[c]) * v[c]).sum();
                (0..m.rows()).map(|row| [0, 1, 2].map(|c| sum(row, c))).collect()
            };
            let sky: Vec<[f64; 3]> =
                (0..self.skies[term].rows()).map(|p| [0, 1, 2].map(|c| f64::from(self.skies[term].at(p, hour)[c]))).collect();
            let light = times(&self.transmission, &times(&self.daylight[term], &sky));
            for (sum, v) in picture.iter_mut().zip(times(&self.views[term], &light)) {
                (0..3).for_each(|c| sum[c] += sign * v[c]);
            }
        }
        let sun = self.suns.sun_picture_with_discs(hour).unwrap();
        let suns: SparsePicture = if with_disc { self.suns.sun_picture(hour).unwrap() } else { sun.pixels };
        for (pixel, value) in suns {
            (0..3).for_each(|c| picture[pixel as usize][c] += f64::from(value[c]));
        }
        picture.into_iter().map(|v| v.map(|v| v.max(0.0) as f32)).collect()
    }
}

impl Definition {
    fn discs(&self, hour: usize) -> Vec<Disc> {
        let weights = lucarne::units::ILLUMINANCE_WEIGHTS;
        let disc = |d: &SeenDisc| Disc {
            direction: d.direction.map(f64::from),
            luminance: (0..3).map(|c| weights[c] * f64::from(d.radiance[c])).sum(),
            solid_angle: f64::from(d.solid_angle),
            error: f64::from(d.error),
        };
        self.suns.sun_picture_with_discs(hour).unwrap().discs.iter().map(disc).collect()
    }
}

#[test]
fn the_fused_year_of_five_phases_is_that_of_float_pictures() {
    if device("fused glare of five phases").is_none() {
        return;
    }
    const SIZE: usize = 40;
    let days = [(1, 15), (3, 20), (6, 21)];
    for (suns, through) in [("\"hourly\"", Through::Slats), ("4", Through::Slats), ("\"hourly\"", Through::ScatteringData)] {
        let folder = tempfile::tempdir().unwrap();
        let method = format!("[glare]\n[images]\nhours = [348]\n[method]\nsky_subdivision = 1\nphases = 5\nsuns = {suns}");
        let out = blinds(folder.path(), &days, through, &method, SIZE, "preset = \"draft\"");
        let found = year(&out, "seat");
        let definition = Definition::read(&out, &folder.path().join("w.wea"));
        let lit: Vec<usize> = (0..found.len()).filter(|&h| found[h][2] > 0.0).collect();
        let mut files = Vec::new();
        let mut brightest = 0.0f32;
        let view = "-vta -vp 1.5 2.2 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180";
        let camera = View::parse(view).unwrap().camera().unwrap();
        let geometry = Arc::new(PixelGeometry::new(&Raster::new(camera, SIZE, SIZE).unwrap()).unwrap());
        let analyser = Analyser::new(geometry, Settings::default()).unwrap();
        let (mut with_discs, mut without) = (0, Vec::new());
        for &hour in &lit {
            // The disc is a source beside the pixels.
            let discs: Vec<Disc> = definition.discs(hour);
            let mut picture = Picture::new(SIZE, SIZE, definition.picture(hour, false)).unwrap();
            brightest = picture.luminance().into_iter().chain(discs.iter().map(|d| d.luminance as f32)).fold(brightest, f32::max);
            let whole = analyser.analyse_with_discs(&picture.luminance(), &discs, None).unwrap();
            let [dgp, _, ev, sources] = found[hour];
            assert!((whole.indices.dgp - dgp).abs() < 1e-4, "suns {suns}, hour {hour}: {} {dgp}", whole.indices.dgp);
            assert!((whole.vertical_illuminance / ev - 1.0).abs() < 1e-4, "suns {suns}, hour {hour}: {} {ev}", whole.vertical_illuminance);
            assert_eq!(whole.sources.len() as f64, sources, "suns {suns}, hour {hour}");
            if !discs.is_empty() {
                with_discs += 1;
                continue;
            }
            without.push(hour);
            picture.view = Some(view.into());
            let path = out.join(format!("hour_{hour:04}.exr"));
            let options = exr::Options { samples: exr::Samples::Float, channels: exr::Channels::Rgb };
            exr::write(&path, &picture, options, &mut Warnings::new()).unwrap();
            files.push(path);
        }
        let output = Command::new(env!("CARGO_BIN_EXE_lucarne")).arg("glare").args(&files).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let table = String::from_utf8(output.stdout).unwrap();
        let (mut worst, mut with_sources) = (0.0f64, 0);
        for (&hour, line) in without.iter().zip(table.lines().skip(1)) {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |i: usize| cells[i].parse::<f64>().unwrap();
            let [dgp, _, ev, sources] = found[hour];
            worst = worst.max((number(1) - dgp).abs());
            assert!((number(1) - dgp).abs() < 1e-4, "suns {suns}, hour {hour}: {} {dgp}", number(1));
            assert!((number(7) / ev - 1.0).abs() < 1e-4, "suns {suns}, hour {hour}: {} lx {ev}", number(7));
            assert_eq!(cells[10].parse::<f64>().unwrap(), sources, "suns {suns}, hour {hour}");
            with_sources += usize::from(sources > 0.0);
        }
        println!(
            "suns {suns}, {through:?}: {} hours, {with_discs} with the disc, {with_sources} others with sources, DGP within {worst:.1e}, brightest pixel {brightest:.0} cd/m²",
            lit.len()
        );
        // The sun itself is in some of them, seen between slats.
        let least = if through == Through::Slats { 1e5 } else { 2e3 };
        assert!(lit.len() > 20 && with_sources + with_discs > 5 && brightest > least && with_discs > 0);
        // The picture that was asked for shows the same light; and run again, the same bits.
        let pixels = |p: &Path| lucarne::image::hdr::read(p).unwrap().luminance().iter().map(|&l| f64::from(l)).sum::<f64>();
        let of_definition: f64 = definition.picture(12, true).iter().map(|&p| f64::from(lucarne::image::luminance(p))).sum();
        assert!((pixels(&out.join("images/seat/img_0348.hdr")) / of_definition - 1.0).abs() < 0.01);
        run_project(&folder.path().join("project.toml"), &out);
        assert_eq!(year(&out, "seat"), found);
    }
}

/// Ev of pictures with visible suns, and of sensors in the eye's place, and of the eyes that the ways
/// without whole pictures use. The once reflected light of other hours differs: the picture has the
/// patches of sun on floor and reveal as traced, the sensor as its Vd spreads them (Cds and Vd are
/// direct parts); most where the sun is low and comes from the side.
#[test]
fn eyes_of_all_ways_get_the_light_of_a_sensor_in_their_place() {
    const WITH_SUN: f64 = 0.02;
    const WITHOUT: f64 = 0.03;
    const ALL: f64 = 0.01;
    let mut texts = [const { Vec::new() }; 3];
    if device("glare of five phases at the eye").is_none() {
        return;
    }
    for through in [Through::Slats, Through::ScatteringData] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("eye.txt"), "1.5 2.2 1.2 0 -1 0\n").unwrap();
        let days = [(1, 15), (3, 20)];
        let all = ["image", "edgps", "dgps", "imageless"];
        // The eyes are the same whatever the sun comes through.
        let names = if through == Through::Slats { &all[..] } else { &all[..1] };
        let ways: Vec<_> = names.iter().map(|way| {
            let method = format!(
                "[[sensors]]\nname = \"eye\"\npoints = \"eye.txt\"\n[glare]\nmethod = \"{way}\"\n[method]\nsky_subdivision = 1\nphases = 5\nsuns = \"hourly\""
            );
            let out = blinds(folder.path(), &days, through, &method, 96, "preset = \"standard\"");
            let lux = read_matrix(&out.join("illuminance/eye.mtx")).unwrap().matrix.into_data();
            let sun = read_matrix(&out.join("illuminance/terms/eye_sun.mtx")).unwrap().matrix.into_data();
            (year(&out, "seat"), lux, sun)
        }).collect();
        let (mut sunny, mut discs, mut sums, mut worst) = (0, 0, [0.0; 2], [0.0f64; 2]);
        for hour in 0..48 {
            let (lux, sun) = (f64::from(ways[0].1[hour]), f64::from(ways[0].2[hour]));
            if lux < 1.0 {
                continue;
            }
            let illuminances: Vec<f64> = ways.iter().map(|way| way.0[hour][2]).collect();
            let (image, eyes) = (illuminances[0], &illuminances[1..]);
            println!("hour {hour}: sensor {lux:.0} lx, of which {sun:.0} lx from the traced sun; picture {image:.0} lx");
            let visible = sun > 1000.0;
            worst[usize::from(visible)] = worst[usize::from(visible)].max((image / lux - 1.0).abs());
            sums = [sums[0] + image, sums[1] + lux];
            // The sensor is the same eye.
            assert!(eyes.iter().all(|e| (e / lux - 1.0).abs() < 1e-3), "hour {hour}: {eyes:?} {lux}");
            assert!(eyes.iter().all(|e| (e / eyes[0] - 1.0).abs() < 1e-6));
            let [dgp, _, _, sources] = ways[ways.len() - 1].0[hour];
            assert!(dgp >= glare::DgpModel::EVALGLARE.dgp(0.0, 0.0) && dgp <= 1.0);
            discs += usize::from(sources > 0.0);
            sunny += usize::from(visible);
        }
        let all = sums[0] / sums[1];
        println!("{through:?}: all hours {all:.4} of the sensor; worst {:.4} with the sun in view, {:.4} without", worst[1], worst[0]);
        assert!(worst[1] < WITH_SUN && worst[0] < WITHOUT && (all - 1.0).abs() < ALL, "{through:?}: {worst:?} {all}");
        let found = [testing::percent(worst[1]), testing::percent(worst[0]), format!("{all:.3}")];
        texts.iter_mut().zip(found).for_each(|(texts, found)| texts.push(found));
        assert!(
            sunny >= 2 && (discs >= 4 || through == Through::ScatteringData),
            "{sunny} hours with sun at the eye, {discs} with sources"
        );
    }
    let [with, without, all] = texts.map(|t| t.join("; "));
    testing::measured("eye-with-sun", &format!("within {with}"), &testing::percent(WITH_SUN));
    let held = format!("{}, {}", testing::percent(WITHOUT), testing::percent(ALL));
    testing::measured("eye-without-sun", &format!("within {without}. {all}"), &held);
}

/// A low sun through clear glazing, as each way finds it: its disc is a source of its own, so that DGP is
/// the formula's with coarse pixels and with fine ones, and nearly the same whichever way Ev was found.
#[test]
fn dgp_of_the_sun_does_not_depend_on_the_size_of_pixels() {
    if device("glare of the sun's disc").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let days = weather(&[(1, 15)]).replace(" 200 90", " 40 60").replace(" 300 110", " 45 70");
    std::fs::write(folder.path().join("w.wea"), days).unwrap();
    let glazing = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/office/bsdf/double_clear.xml");
    let run_with = |method: &str, size: usize| {
        let text = format!(
            "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"{SCENE}/room.rad\"]\n[[window]]\nname = \"south\"\n\
             surface = \"{SCENE}/window.rad\"\nbsdf = \"{glazing}\"\ntensor_tree = \"{glazing}\"\n[[view]]\nname = \"seat\"\n\
             file = \"{SCENE}/views/seat.vf\"\nresolution = [{size}, {size}]\n[glare]\nmethod = \"{method}\"\n\
             [method]\nsky_subdivision = 1\nphases = 5\nsuns = \"hourly\"\n[quality]\npreset = \"draft\"\n"
        );
        let name = format!("{method}{size}");
        std::fs::write(folder.path().join(format!("{name}.toml")), text).unwrap();
        run_project(&folder.path().join(format!("{name}.toml")), &folder.path().join(&name));
        year(&folder.path().join(&name), "seat")
    };
    let reference = run_with("image", 128);
    let suns = SunPictures::open(&folder.path().join("image128/matrices/C_seat.suns")).unwrap().pictures;
    let seen: Vec<usize> = (0..24).filter(|&h| !suns.sun_picture_with_discs(h).unwrap().discs.is_empty()).collect();
    for (method, size, tolerance) in [("image", 24, 0.005), ("edgps", 24, 0.02), ("imageless", 8, 0.02)] {
        let found = run_with(method, size);
        for &hour in &seen {
            let ([a, _, ev, n], [b, error, lux, m]) = (reference[hour], found[hour]);
            println!("{method} {size}, hour {hour}: DGP {b:.4} ± {error:.4} and {a:.4}, Ev {lux:.0} and {ev:.0} lx, {m} and {n} sources");
            // The rest of the picture, and a sensor's light, differ by their noise.
            assert!((a - b).abs() < tolerance + 3.0 * error && (0.5..1.0).contains(&a), "{method} {size}, hour {hour}: {b} {a}");
        }
    }
    assert!(seen.len() >= 2, "{seen:?}");
}

/// Pictures of the tutorial's room through its real slats, of hours in which its eye sees no sun.
#[test]
fn five_phase_pictures_have_radiances_dgp() {
    let data = testing::tutorial();
    if device("five-phase glare of the tutorial's room").is_none() {
        return;
    }
    let (room, reference) = (data.join("tutorial_room"), data.join("reference"));
    let hours: Vec<usize> = lines(&reference.join("images/hours.txt")).iter().map(|l| l.parse().unwrap()).collect();
    let folder = tempfile::tempdir().unwrap();
    // Only these hours, each with its neighbours: the sun of an hour is where it is.
    let weather = lines(&testing::new_york());
    let (header, records) = weather.split_at(6);
    let chosen = hours.iter().map(|&h| records[h].clone());
    std::fs::write(folder.path().join("w.wea"), header.iter().cloned().chain(chosen).collect::<Vec<_>>().join("\n") + "\n").unwrap();
    let text = format!(
        "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"{room}/materials.rad\", \"{room}/room.rad\"]\n[[window]]\nname = \"w\"\n\
         surface = \"{room}/objects/GlazingVmtx.rad\"\nbsdf = \"{room}/bsdf/blinds_correct_klems.xml\"\n\
         shade = \"{reference}/fivephase/blindsGeometry.rad\"\n[[view]]\nname = \"fish\"\nfile = \"{room}/views/fish.vf\"\n\
         resolution = [128, 128]\n[glare]\n[method]\nsky_subdivision = 1\nphases = 5\nsuns = 6\nbounces = 4\n[quality]\npreset = \"standard\"\n",
        room = room.display(),
        reference = reference.display()
    );
    std::fs::write(folder.path().join("project.toml"), text).unwrap();
    run_project(&folder.path().join("project.toml"), &folder.path().join("out"));
    let found = year(&folder.path().join("out"), "fish");
    let table = lines(&reference.join("images/dgp.csv"));
    const DGP: f64 = 0.01;
    let (mut compared, mut worst) = (0, 0.0f64);
    for (i, hour) in hours.iter().enumerate() {
        let row = table.iter().find(|l| l.starts_with(&format!("fish5_geo_{i:02}.hdr,"))).expect("a row per hour");
        let cells: Vec<f64> = row.split(',').skip(1).map(|c| c.parse().unwrap()).collect();
        let [dgp, error, ev, sources] = found[i];
        println!(
            "hour {hour}: DGP {dgp:.4} ± {error:.4} and Radiance's {:.4}, Ev {ev:.0} and {:.0} lx, {sources} and {} sources",
            cells[0], cells[7], cells[6]
        );
        // Radiance's pictures of these hours show suns, with one ray to a pixel.
        let visible = cells[0] >= 1.0;
        if !visible {
            assert!((dgp - cells[0]).abs() < DGP, "hour {hour}: {dgp} {}", cells[0]);
            worst = worst.max((dgp - cells[0]).abs());
            compared += 1;
        }
    }
    assert!(compared >= 5, "{compared} hours");
    testing::measured("five-phase-dgp", &format!("{compared} hours within {}", testing::short(worst)), &testing::short(DGP));
}

fn lines(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.lines().map(str::to_string).filter(|l| !l.trim().is_empty()).collect()
}

#[test]
fn standard_errors_of_five_phases_are_the_spread_over_seeds() {
    const FACTOR: f64 = 2.0;
    let mut ratios = Vec::new();
    if device("standard errors of five-phase glare").is_none() {
        return;
    }
    const SEEDS: usize = 6;
    for (case, threshold) in [("Ev alone", 1e9), ("Ev and the luminance of sources", 2000.0)] {
        let method = format!("[glare]\nthreshold = {threshold:e}\n[method]\nsky_subdivision = 1\nphases = 5\nsuns = 4");
        let years: Vec<Vec<[f64; 4]>> = (0..SEEDS)
            .map(|seed| {
                let folder = tempfile::tempdir().unwrap();
                let quality = format!("preset = \"draft\"\nseed = {}", 21 + seed);
                year(&blinds(folder.path(), &[(3, 20), (6, 21)], Through::Slats, &method, 24, &quality), "seat")
            })
            .collect();
        let (mut predicted, mut spread, mut hours) = (0.0, 0.0, 0);
        for hour in 0..48 {
            let rows: Vec<[f64; 4]> = years.iter().map(|y| y[hour]).collect();
            if rows[0][2] == 0.0 {
                continue;
            }
            let mean = rows.iter().map(|r| r[0]).sum::<f64>() / SEEDS as f64;
            spread += rows.iter().map(|r| (r[0] - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
            predicted += rows.iter().map(|r| r[1].powi(2)).sum::<f64>() / SEEDS as f64;
            hours += 1;
        }
        let rms = |sum: f64| (sum / f64::from(hours)).sqrt();
        println!("{case}: {hours} hours: predicted {:.2e}, seen {:.2e}", rms(predicted), rms(spread));
        let ratio = (predicted / spread).sqrt();
        assert!(hours > 8 && (1.0 / FACTOR..FACTOR).contains(&ratio));
        ratios.push(testing::short(ratio));
    }
    let found = format!("{} of it for Ev alone, {} with sources, {SEEDS} seeds", ratios[0], ratios[1]);
    testing::measured("five-phase-glare-errors", &found, &format!("factor {FACTOR}"));
}

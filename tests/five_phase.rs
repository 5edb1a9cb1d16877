//! The five-phase method: suns through real slats against Radiance's results (reference data beside
//! the repository; its absence is said), and whole projects through the library.

use lucarne::bins::ReinhartSky;
use lucarne::gpu::Device;
use lucarne::kernels::sun_matrix::Sun;
use lucarne::kernels::sun_matrix::geometry::{Openings, SunMatrix, SunOptions, compute};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::scene::points::{Sensor, read_points};
use lucarne::scene::rad::read_scene;
use lucarne::simulate::suns::{SunScheme, SunSet};
use lucarne::simulate::{Inputs, Project, Summary, run};
use lucarne::weather::Weather;
use lucarne::{Result, Warnings};
use std::path::{Path, PathBuf};

#[path = "../src/testing.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod testing;

fn device(what: &str) -> Option<Device> {
    match Device::shared() {
        Ok(device) => Some(device),
        Err(error) => {
            assert!(std::env::var_os("LUCARNE_REQUIRE_GPU").is_none_or(|v| v != "1"), "LUCARNE_REQUIRE_GPU=1, but {error}");
            eprintln!("SKIPPED {what}: {error}");
            None
        }
    }
}

/// The black tutorial room with its blinds, its sensors and the folder of references.
struct Tutorial {
    scene: lucarne::scene::Scene,
    sensors: Vec<Sensor>,
    room: PathBuf,
    reference: PathBuf,
}

fn tutorial() -> Option<Tutorial> {
    let data = testing::shared()?.join("data");
    let room = data.join("tutorial_room");
    let files = ["materialBlack.rad", "roomBlack.rad", "../reference/fivephase/blindsGeometry.rad"].map(PathBuf::from);
    let scene = read_scene(&files, &room, &mut Warnings::new()).unwrap();
    let sensors = read_points(&room.join("points.txt")).unwrap();
    Some(Tutorial { scene, sensors, room, reference: data.join("reference/fivephase") })
}

fn at(m: &Matrix<f32>, row: usize, column: usize) -> f64 {
    f64::from(m.at(row, column)[0])
}

fn suns_of(file: &Path) -> Vec<Sun> {
    let scene = read_scene(&[file.to_path_buf()], Path::new("."), &mut Warnings::new()).unwrap();
    scene.sources.iter().map(|s| Sun { direction: s.direction, radius: (s.angle / 2.0).to_radians() }).collect()
}

#[test]
fn eight_suns_through_real_slats_are_radiances() {
    let Some(t) = tutorial() else { return };
    let Some(device) = device("the tutorial's suns") else { return };
    let suns: Vec<Sun> = suns_of(&t.reference.join("suns_sel.rad")).into_iter().map(Sun::as_point).collect();
    let run = |options: SunOptions| compute(&device, &t.scene, Openings::Anywhere, &t.sensors, &suns, &options, &Silent).unwrap();

    // Straight light of point suns: the same arithmetic, so the same numbers, shadow edges aside.
    let direct = run(SunOptions { disc_samples: 1, ..SunOptions::default() }.direct()).total;
    let wanted = read_matrix(&t.reference.join("CdsSelV_geo0.mtx")).unwrap().matrix;
    let (mut worst, mut lit, mut edges) = (0.0f64, 0, 0);
    for row in 0..wanted.rows() {
        for sun in 0..wanted.cols() {
            match (at(&direct, row, sun), at(&wanted, row, sun)) {
                (found, expected) if found > 0.0 && expected > 0.0 => {
                    lit += 1;
                    worst = worst.max((found / expected - 1.0).abs());
                }
                (found, expected) => edges += usize::from(found != expected),
            }
        }
    }
    println!("{lit} lit pairs of sensor and sun: worst {worst:.1e}; {edges} differ at shadow edges");
    assert!(lit > 100 && worst < 1e-5 && edges <= 1);

    // Scattered by the slats, as with -ab 4: sums over 100 sensors for suns that do not come straight.
    // The reference's own noise, unknown, is the larger the weaker the light.
    let options = SunOptions { disc_samples: 1, paths: 256, bounces: Some(4), ..SunOptions::default() };
    let windows = lucarne::scene::read_windows(Path::new("objects/GlazingVmtx.rad"), &t.room, &mut Warnings::new()).unwrap();
    let all = compute(&device, &t.scene, Openings::Windows(&windows), &t.sensors, &suns, &options, &Silent).unwrap();
    let wanted4 = read_matrix(&t.reference.join("CdsSelV_geo4.mtx")).unwrap().matrix;
    for sun in 0..5 {
        let sum = |m: &Matrix<f32>| (0..100).map(|row| at(m, row, sun)).sum::<f64>();
        let ratio = sum(&all.total) / sum(&wanted4);
        println!("sun {sun}: scattered light {ratio:.4} of Radiance's");
        assert!((ratio - 1.0).abs() < if sun < 3 { 0.01 } else { 0.06 }, "sun {sun}: {ratio}");
    }
}

/// Annual sum of illuminance per sensor for the suns of a year, by the reference's photometric weights.
fn annual(set: &SunSet, m: &SunMatrix) -> Vec<f64> {
    let year = |row| set.hours.iter().flatten().map(|(sun, radiance)| at(&m.total, row, *sun) * radiance * (47.4 + 119.9 + 11.6)).sum();
    (0..m.total.rows()).map(year).collect()
}

#[test]
fn a_year_of_sun_through_real_slats_is_radiances() {
    let Some(t) = tutorial() else { return };
    let Some(device) = device("the tutorial's year of sun") else { return };
    let weather = Weather::read(&t.room.join("weather/NYC.wea"), &mut Warnings::new()).unwrap();
    let set = SunSet::new(&weather, SunScheme::Patches(ReinhartSky::new(6).unwrap()), &[]).unwrap();
    println!("{:?}", set.census);
    assert_eq!((set.census.all, set.census.needed + set.census.never), (5185, 5185));
    let points: Vec<Sun> = set.suns.iter().map(|s| s.as_point()).collect();
    let reference = |name: &str| {
        let m = read_matrix(&t.reference.join(name)).unwrap().matrix;
        (0..m.cols()).map(|sensor| (0..m.rows()).map(|hour| at(&m, hour, sensor)).sum::<f64>()).collect::<Vec<_>>()
    };
    let run = |suns: &[Sun], options: &SunOptions| {
        annual(&set, &compute(&device, &t.scene, Openings::Anywhere, &t.sensors, suns, options, &Silent).unwrap())
    };
    let wanted = reference("annual_sun_geo0.ill");
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let bright = mean(&wanted) / 100.0;
    let worst = |found: &[f64], wanted: &[f64]| {
        let pairs = found.iter().zip(wanted).filter(|(_, w)| **w > bright);
        pairs.map(|(f, w)| (f / w - 1.0).abs()).fold(0.0, f64::max)
    };
    let found = run(&points, &SunOptions { disc_samples: 1, ..SunOptions::default() }.direct());
    println!("point suns: worst sensor {:.3} %", 100.0 * worst(&found, &wanted));
    // One sun in a hundred stands where a sensor is at a slat's edge.
    let off = found.iter().zip(&wanted).filter(|(f, w)| **w > bright && (*f / *w - 1.0).abs() > 0.02).count();
    assert!(off <= 25, "{off} sensors");
    assert!((mean(&found) / mean(&wanted) - 1.0).abs() < 0.01);
}

/// Eight real discs through the slats against Radiance's own shadow rays. Radiance spreads them over a
/// square of the disc's area, whose corners reach farther between the slats: a difference of up to
/// 2 % of a sun remains.
#[test]
fn discs_through_real_slats_are_radiances() {
    let Some(t) = tutorial() else { return };
    let Some(device) = device("the tutorial's discs") else { return };
    let (Some(mut oconv), Some(mut rcontrib)) = (testing::radiance("oconv"), testing::radiance("rcontrib")) else { return };
    const RAYS: usize = 512;
    let folder = tempfile::tempdir().unwrap();
    let files = ["materialBlack.rad", "roomBlack.rad", "../reference/fivephase/blindsGeometry.rad", "../reference/fivephase/suns_sel.rad"];
    let octree = folder.path().join("room.oct");
    std::fs::write(&octree, testing::output(oconv.arg("-f").args(files).current_dir(&t.room))).unwrap();
    let points = folder.path().join("points.txt");
    let line =
        |s: &Sensor| format!("{} {} {} {} {} {}\n", s.position.x, s.position.y, s.position.z, s.direction.x, s.direction.y, s.direction.z);
    std::fs::write(&points, t.sensors.iter().map(|s| line(s).repeat(RAYS)).collect::<String>()).unwrap();
    let options = format!("-h -V+ -I+ -ab 0 -dc 1 -dt 0 -dj 1 -ss 0 -c {RAYS} -y 100 -faf -M");
    rcontrib.args(options.split(' ')).arg(t.reference.join("suns_sel.mod")).arg(&octree).stdin(std::fs::File::open(&points).unwrap());
    let bytes = testing::output(&mut rcontrib);
    let theirs: Vec<f64> = bytes.chunks_exact(12).map(|v| f64::from(f32::from_le_bytes([v[0], v[1], v[2], v[3]])) / 1e6).collect();
    let suns = suns_of(&t.reference.join("suns_sel.rad"));
    let options = SunOptions { disc_samples: 128, ..SunOptions::default() }.direct();
    let ours = compute(&device, &t.scene, Openings::Anywhere, &t.sensors, &suns, &options, &Silent).unwrap();
    for sun in 5..8 {
        let (mut found, mut expected, mut variance) = (0.0, 0.0, 0.0);
        let most = (0..100).map(|row| theirs[row * 8 + sun]).fold(0.0, f64::max);
        for row in 0..100 {
            let value = theirs[row * 8 + sun];
            found += at(&ours.total, row, sun);
            expected += value;
            // A ray arrives or not.
            variance += value * (most - value) / RAYS as f64 + at(&ours.direct_error, row, sun).powi(2);
        }
        let sigmas = (found - expected).abs() / variance.sqrt();
        println!("sun {sun}: {:.4} of Radiance's ± {:.4}", found / expected, variance.sqrt() / expected);
        assert!(sigmas < 4.0 || (found / expected - 1.0).abs() < 0.02, "sun {sun}: {found} {expected}");
        assert!(variance.sqrt() < 0.01 * expected);
    }
}

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");

/// A project in the shipped room with blinds, over the given hours of weather, at draft quality.
fn blinds(folder: &Path, weather: &str, shade: &str, method: &str) -> Result<(Summary, PathBuf)> {
    let header = "place Test\nlatitude 40.78\nlongitude 73.97\ntime_zone 75\nsite_elevation 0\nweather_data_file_units 1\n";
    std::fs::write(folder.join("w.wea"), format!("{header}{weather}")).unwrap();
    let scene = format!("{SCENES}/blinds");
    let text = format!(
        "[weather]\nfile = \"w.wea\"\n[scene]\nfiles = [\"{scene}/room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"{scene}/window.rad\"\n\
         bsdf = \"{scene}/blind.xml\"\n{shade}\n[[sensors]]\nname = \"room\"\npoints = \"{scene}/points.txt\"\n[method]\n{method}\n[quality]\npreset = \"draft\"\n"
    );
    // Pictures are compared with sensors, both with little noise.
    let text = if method.contains("[images]") { text.replace("\"draft\"", "\"standard\"") } else { text };
    let file = folder.join("project.toml");
    std::fs::write(&file, text).unwrap();
    let project = Project::read(&file)?;
    let mut warnings = Warnings::new();
    let inputs = Inputs::read(&project, &mut warnings)?;
    let out = folder.join("out");
    let device = Device::shared()?;
    let summary = run(&device, &project, &inputs, &out, &Silent, &mut warnings)?;
    Ok((summary, out))
}

fn day(direct: f64) -> String {
    (0..24).map(|h| format!("1 15 {h}.5 {direct} {}\n", if (8..17).contains(&h) { 120 } else { 0 })).collect()
}

fn shade() -> String {
    format!("shade = \"{SCENES}/blinds/blinds.rad\"")
}

fn values(out: &Path, name: &str) -> Vec<f32> {
    read_matrix(&out.join("illuminance").join(name)).unwrap().matrix.into_data()
}

#[test]
fn without_sun_five_phases_are_three() {
    if device("five phases without sun").is_none() {
        return;
    }
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let (five, out5) = blinds(folders[0].path(), &day(0.0), &shade(), "phases = 5").unwrap();
    let (three, out3) = blinds(folders[1].path(), &day(0.0), "", "phases = 3").unwrap();
    assert_eq!((five.phases, three.phases), (5, 3));
    assert_eq!(values(&out5, "room.mtx"), values(&out3, "room.mtx"));
    assert!(values(&out5, "room.mtx").iter().any(|v| *v > 0.0));
    assert_eq!(five.suns.unwrap().needed, 0);
}

#[test]
fn the_terms_of_five_phases_add_up_and_nothing_is_negative() {
    if device("terms of five phases").is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (summary, out) = blinds(folder.path(), &day(700.0), &shade(), "phases = \"auto\"\nsuns = \"hourly\"").unwrap();
    assert_eq!(summary.phases, 5);
    let census = summary.suns.clone().unwrap();
    assert!(census.needed >= 8, "{census:?}");
    let all = values(&out, "room.mtx");
    let [three, direct, sun] = ["three_phase", "direct", "sun"].map(|term| values(&out, &format!("terms/room_{term}.mtx")));
    let largest = three.iter().copied().fold(0.0, f32::max);
    let (mut sunny, mut shadowed) = (0, 0);
    for i in 0..all.len() {
        assert!(all[i] >= 0.0 && direct[i] >= 0.0 && sun[i] >= 0.0 && three[i] >= direct[i] * 0.9999, "{i}");
        assert!((all[i] - (three[i] - direct[i] + sun[i])).abs() <= 1e-5 * largest, "{} {} {} {}", all[i], three[i], direct[i], sun[i]);
        sunny += usize::from(sun[i] > 5000.0);
        shadowed += usize::from(sun[i] < 500.0 && direct[i] > 1000.0);
    }
    println!("{sunny} sensor hours in a patch of sun, {shadowed} between patches that three phases blur");
    assert!(sunny > 0 && shadowed > 0);
    let error = summary.estimated_error.unwrap();
    assert!(error.hourly_median > 0.0 && error.hourly_median < 0.1);
    // A second run finds everything there.
    let (again, out) = blinds(folder.path(), &day(700.0), &shade(), "phases = \"auto\"\nsuns = \"hourly\"").unwrap();
    assert!(again.matrices.iter().all(|m| m.reused) && again.matrices.iter().any(|m| m.name == "C_room"), "{:?}", again.matrices);
    assert_eq!(values(&out, "room.mtx"), all);
    // Two phases keep the coefficients and give what three give.
    let (two, out) = blinds(folder.path(), &day(700.0), "", "phases = 2").unwrap();
    assert_eq!(two.phases, 2);
    assert_eq!(values(&out, "room.mtx"), three);
    assert!(out.join("matrices/DC_room.mtx").is_file());
}

#[test]
fn a_shade_must_be_at_its_window() {
    let folder = tempfile::tempdir().unwrap();
    let complaint = |text: &str| {
        std::fs::write(folder.path().join("shade.rad"), text).unwrap();
        let error = blinds(folder.path(), &day(0.0), "shade = \"shade.rad\"", "phases = 5").err().map(|e| e.to_string());
        error.unwrap_or_default()
    };
    let away = "void plastic slat 0 0 5 .5 .5 .5 0 0\nslat polygon p 0 0 9 10 0 0  11 0 0  10 0 1\n";
    let message = complaint(away);
    assert!(message.contains("not at its window") && message.contains("shade.rad") && message.contains("south"), "{message}");
    let message = complaint("# nothing\n");
    assert!(message.contains("no surface"), "{message}");
    let message = complaint("slat polygon p 0 0 9 1 0 0  2 0 0  1 0 1\n");
    assert!(message.contains("shade.rad") && message.contains("slat"), "{message}");
}

#[test]
fn direct_matrices_never_exceed_the_whole_on_any_shipped_scene() {
    let Some(device) = device("direct matrices of the shipped scenes") else { return };
    for scene in ["office", "asymmetric", "blinds"] {
        let folder = tempfile::tempdir().unwrap();
        let mut project = Project::read(&Path::new(SCENES).join(scene).join("project.toml")).unwrap();
        project.quality.preset = lucarne::simulate::project::Preset::Draft;
        project.views.clear();
        let mut warnings = Warnings::new();
        let mut inputs = Inputs::read(&project, &mut warnings).unwrap();
        inputs.weather.records.truncate(24);
        run(&device, &project, &inputs, folder.path(), &Silent, &mut warnings).unwrap();
        let names = (project.sensors.iter().map(|s| format!("V_{}", s.name))).chain(inputs.windows.iter().map(|w| format!("D_{}", w.name)));
        for name in names {
            let read = |suffix: &str| read_matrix(&folder.path().join(format!("matrices/{name}{suffix}.mtx"))).unwrap().matrix.into_data();
            let (total, direct) = (read(""), read("_direct"));
            assert!(direct.iter().any(|d| *d > 0.0), "{scene}: {name}");
            assert!(total.iter().zip(&direct).all(|(t, d)| t >= d && *d >= 0.0), "{scene}: {name}");
        }
    }
}

/// Illuminance at the eye from the picture of an hour.
fn seen_by_the_eye(out: &Path, size: usize, hour: usize) -> f64 {
    let camera = lucarne::camera::View::read(&Path::new(SCENES).join("blinds/views/seat.vf")).unwrap().camera().unwrap();
    let raster = lucarne::camera::Raster::fit(camera, size, size, 1.0).unwrap();
    let geometry = lucarne::glare::PixelGeometry::new(&raster).unwrap();
    let path = out.join(format!("images/seat/img_{hour:04}.hdr"));
    let picture = lucarne::image::hdr::read_with(&path, lucarne::image::hdr::Exposure::Undo).unwrap();
    let weights = lucarne::units::ILLUMINANCE_WEIGHTS;
    let values: Vec<f32> =
        picture.pixels.iter().map(|p| p.iter().zip(weights).map(|(v, w)| f64::from(*v) * w).sum::<f64>() as f32).collect();
    assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0));
    geometry.totals(&values).unwrap().vertical_illuminance
}

#[test]
fn pictures_with_suns_light_the_eye_as_the_sensor_in_its_place_is_lit() {
    if device("pictures of five phases").is_none() {
        return;
    }
    const SIZE: usize = 96;
    let hours = [9, 11, 12, 14];
    let folder = tempfile::tempdir().unwrap();
    let view = format!("[[view]]\nname = \"seat\"\nfile = \"{SCENES}/blinds/views/seat.vf\"\nresolution = [{SIZE}, {SIZE}]\n");
    let method = format!("phases = 5\nsuns = \"hourly\"\n{view}[images]\nhours = {hours:?}");
    let (_, out) = blinds(folder.path(), &day(700.0), &shade(), &method).unwrap();
    let lux = values(&out, "room.mtx");
    let sun = values(&out, "terms/room_sun.mtx");
    let count = lux.len() / 24;
    let (mut worst, mut sunny) = (0.0f64, 0.0f64);
    for hour in hours {
        // The last sensor is the eye.
        let (sensor, of_sun) = (f64::from(lux[(count - 1) * 24 + hour]), f64::from(sun[(count - 1) * 24 + hour]));
        let eye = seen_by_the_eye(&out, SIZE, hour);
        println!("hour {hour}: picture {eye:.0} lx, sensor {sensor:.0} lx, of which {of_sun:.0} lx from the traced sun");
        worst = worst.max((eye / sensor - 1.0).abs());
        sunny = sunny.max(of_sun);
    }
    assert!(sunny > 100.0, "no sun reaches the eye");
    // The sensor's hour alone has a standard error of 1 %.
    assert!(worst < 0.03, "{worst}");
    // Run again, nothing is traced and the pictures are the same.
    let before = std::fs::read(out.join("images/seat/img_0012.hdr")).unwrap();
    let (again, out) = blinds(folder.path(), &day(700.0), &shade(), &method).unwrap();
    assert_eq!(again.rays, 0);
    assert_eq!(std::fs::read(out.join("images/seat/img_0012.hdr")).unwrap(), before);
}

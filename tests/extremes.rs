//! Projects at the extremes, as users run them: no term of five phases drowns in another, no weather
//! and no material gives a number that is none. The kernels' own extremes are tested beside them
//! (`src/kernels/**/extremes.rs`), those of skies in `src/sky`.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the program says on both streams.
fn lucarne(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_lucarne")).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout) + &text(&output.stderr)
}

/// A folder with the shipped room behind blinds, all plastics of this reflectance.
fn blinds(reflectance: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/blinds");
    for name in ["room.rad", "blinds.rad", "window.rad", "blind.xml", "points.txt", "views/seat.vf"] {
        let text = std::fs::read_to_string(scene.join(name)).unwrap();
        let repaint = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["void", "plastic", name, ..] => format!("void plastic {name} 0 0 5 {reflectance} {reflectance} {reflectance} 0 0\n"),
            _ => format!("{line}\n"),
        };
        let text = if name.ends_with(".rad") { text.lines().map(repaint).collect() } else { text };
        let path = folder.path().join(Path::new(name).file_name().unwrap());
        std::fs::write(path, text).unwrap();
    }
    folder
}

/// Weather at a latitude: lines of month, day, hour, direct normal and diffuse horizontal irradiance.
fn write_weather(folder: &Path, latitude: f64, hours: impl IntoIterator<Item = (u32, u32, f64, f64, f64)>) {
    let mut text = format!("place Nowhere\nlatitude {latitude}\nlongitude 0\ntime_zone 0\nsite_elevation 0\nweather_data_file_units 1\n");
    for (month, day, hour, direct, diffuse) in hours {
        writeln!(text, "{month} {day} {hour} {direct} {diffuse}").unwrap();
    }
    std::fs::write(folder.join("weather.wea"), text).unwrap();
}

fn write_project(folder: &Path, scene: &str, bsdf: &str, more: &str) {
    let text = format!(
        "[weather]\nfile = \"weather.wea\"\n[scene]\nfiles = [\"{scene}\"]\n\
         [[window]]\nname = \"south\"\nsurface = \"window.rad\"\nbsdf = \"{bsdf}\"\n{more}\n\
         [[sensors]]\nname = \"room\"\npoints = \"points.txt\"\n[quality]\npreset = \"draft\"\n"
    );
    std::fs::write(folder.join("project.toml"), text).unwrap();
}

fn matrix(folder: &Path, name: &str) -> Matrix<f32> {
    read_matrix(&folder.join(name)).unwrap().matrix
}

/// Every number in every text and matrix of a folder of results.
fn assert_all_finite(folder: &Path) {
    let mut folders = vec![folder.to_path_buf()];
    let mut files: Vec<PathBuf> = Vec::new();
    while let Some(at) = folders.pop() {
        for entry in std::fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    assert!(files.len() > 5);
    for file in files {
        match file.extension().and_then(|e| e.to_str()) {
            Some("mtx") => {
                let m = read_matrix(&file).unwrap().matrix;
                // Replicates and batches deviate by what few hits leave open, to either side: their mean is not negative.
                let name = file.file_stem().unwrap().to_string_lossy();
                let deviates = name.starts_with("replicates_") || name.ends_with("_batches");
                assert!(m.data().iter().all(|v| v.is_finite() && (deviates || *v >= 0.0)), "{}", file.display());
            }
            Some("csv" | "json") => {
                let text = std::fs::read_to_string(&file).unwrap().to_lowercase();
                let words = || text.split(|c: char| !c.is_alphanumeric());
                assert!(!words().any(|w| ["nan", "inf", "infinity"].contains(&w)), "{}: {text}", file.display());
            }
            _ => {}
        }
    }
}

#[test]
fn what_a_black_room_receives_is_sky_and_sun_to_the_last_digits() {
    if device("extremes").is_none() {
        return;
    }
    // Where nothing reflects, V·T·D·S and Vd·T·Dd·Sds have the whole sun in common, many times the
    // sky's light: their difference must leave exactly what comes from the sky.
    let folder = blinds("0");
    let at = folder.path();
    write_weather(at, 40.0, [9.5, 10.5, 11.5, 12.5].map(|hour| (6, 21, hour, 950.0, 20.0)));
    write_project(at, "room.rad", "blind.xml", "shade = \"blinds.rad\"\n[method]\nsky_subdivision = 1\nphases = 5\nsuns = \"hourly\"");
    lucarne(at, &["run", "project.toml", "-o", "out"]);
    lucarne(at, &["sky", "-s", "weather.wea", "-o", "sky.mtx"]);
    let factors = ["out/matrices/V_room.mtx", "blind.xml", "out/matrices/D_south.mtx", "sky.mtx"];
    lucarne(at, &[&["multiply", "--illuminance"], &factors[..], &["-o", "sky_only.mtx"]].concat());
    let [all, three, sun] = ["room", "terms/room_three_phase", "terms/room_sun"].map(|n| matrix(at, &format!("out/illuminance/{n}.mtx")));
    let sky = matrix(at, "sky_only.mtx");
    let (mut largest, mut worst) = (0.0f64, 0.0f64);
    for k in 0..all.data().len() {
        let [all, three, sun, sky] = [&all, &three, &sun, &sky].map(|m| f64::from(m.data()[k]));
        largest = largest.max(three / sky);
        worst = worst.max((all - (sky + sun)).abs() / (sky + sun));
    }
    println!("three phases up to {largest:.1} times the sky alone; the rest differs by {worst:.1e} at most");
    assert!(largest > 5.0, "the sun does not dominate: {largest}");
    const SAME: f64 = 1e-5;
    assert!(worst < SAME, "{worst}");
    testing::measured("black-room", &testing::short(worst), &testing::short(SAME));
    assert_all_finite(&at.join("out"));
}

#[test]
fn polar_nights_leap_days_and_minutes_give_numbers() {
    if device("extremes").is_none() {
        return;
    }
    let folder = blinds("0.5");
    let at = folder.path();
    let glare = "[[view]]\nname = \"seat\"\nfile = \"seat.vf\"\nresolution = [24, 24]\n[glare]\nmethod = \"image\"";
    write_project(at, "room.rad", "blind.xml", glare);
    let hours = |month: u32, day: u32| (0..24).map(move |h| (month, day, f64::from(h) + 0.5, 300.0, 80.0));
    // Midnight sun: at every hour of the day there is light, at midnight too.
    write_weather(at, 78.0, hours(6, 21));
    lucarne(at, &["run", "project.toml", "-o", "summer"]);
    let lux = matrix(at, "summer/illuminance/room.mtx");
    assert!(lux.cols() == 24 && lux.data().iter().all(|v| *v > 0.0));
    // Polar night: whatever the file claims, there is no sun; the sky's light alone is left.
    write_weather(at, 78.0, (0..24).map(|h| (12, 21, f64::from(h) + 0.5, 0.0, 0.0)));
    lucarne(at, &["run", "project.toml", "-o", "winter"]);
    assert!(matrix(at, "winter/illuminance/room.mtx").data().iter().all(|v| *v == 0.0));
    // Six instants of an hour of the 29th of February.
    write_weather(at, 40.0, (0..6).map(|k| (2, 29, 12.0 + (f64::from(k) + 0.5) / 6.0, 700.0, 90.0)));
    lucarne(at, &["run", "project.toml", "-o", "leap"]);
    let lux = matrix(at, "leap/illuminance/room.mtx");
    assert!(lux.cols() == 6 && lux.data().iter().all(|v| *v > 0.0));
    for out in ["summer", "winter", "leap"] {
        assert_all_finite(&at.join(out));
    }
}

#[test]
fn windows_that_pass_nothing_and_surfaces_that_return_too_much() {
    if device("extremes").is_none() {
        return;
    }
    let folder = blinds("1.2");
    let at = folder.path();
    write_weather(at, 40.0, [(6, 21, 12.5, 800.0, 100.0)]);
    lucarne(at, &["bsdf", "isotropic", "--normal", "0,0,0.1,0", "-o", "shut.xml"]);
    let glare = "[[view]]\nname = \"seat\"\nfile = \"seat.vf\"\nresolution = [24, 24]\n[glare]\nmethod = \"image\"";
    write_project(at, "room.rad", "shut.xml", &format!("{glare}\n[method]\nbounces = 4"));
    let said = lucarne(at, &["run", "project.toml", "-o", "shut"]);
    assert!(said.contains("a reflectance is 1.2, more than 1; 1 is used"), "{said}");
    assert!(matrix(at, "shut/illuminance/room.mtx").data().iter().all(|v| *v == 0.0));
    assert_all_finite(&at.join("shut"));
    // Nothing is lost in a room of reflectance 1, so the number of reflections must be limited, or not:
    // either way there is an end.
    write_project(at, "room.rad", "blind.xml", "[method]\nbounces = 4");
    lucarne(at, &["run", "project.toml", "-o", "bright"]);
    assert!(matrix(at, "bright/illuminance/room.mtx").data().iter().all(|v| *v > 0.0));
    assert_all_finite(&at.join("bright"));
}

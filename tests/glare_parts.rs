//! Zones, band and bare illuminance of `lucarne glare`, against evalglare and against what they must be.

use lucarne::image::{Picture, hdr};
use std::path::Path;
use std::process::{Command, Output};

#[path = "../src/testing.rs"]
mod testing;

const FISHEYE: &str = "-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180";
const SIZE: usize = 150;

fn lucarne(arguments: &[&str], path: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lucarne")).arg("glare").args(arguments).arg(path).output().unwrap()
}

/// A fisheye whose luminance differs from pixel to pixel, with a bright disc.
fn picture(path: &Path) {
    let pixel = |i: usize| {
        let (x, y) = ((i % SIZE) as f32, (i / SIZE) as f32);
        let bright = if (x - 60.0).hypot(y - 50.0) < 9.0 { 40.0 } else { 0.0 };
        [1.0 + 0.02 * x + 0.03 * y + (i as f32 * 0.618_034).fract() + bright; 3]
    };
    let mut picture = Picture::new(SIZE, SIZE, (0..SIZE * SIZE).map(pixel).collect()).unwrap();
    picture.view = Some(FISHEYE.into());
    hdr::write(path, &picture).unwrap();
}

/// Lines of the table of parts: name and numbers.
fn parts(output: &Output) -> Vec<(String, Vec<f64>)> {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let table = text.split("\n\n").find(|t| t.starts_with("file,part,")).unwrap_or_else(|| panic!("no table in: {text}"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[1].to_string(), cells[2..].iter().map(|c| c.parse().unwrap()).collect())
    };
    table.lines().skip(1).map(row).collect()
}

#[test]
fn zones_and_band_have_evalglares_statistics() {
    const VALUE: f64 = 1e-3;
    const PERCENTILE: f64 = 2e-3;
    let mut worst = [0.0f64; 2];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.hdr");
    picture(&path);
    // (evalglare loses a zone's centre where rounding makes the cosine of its distance from itself exceed 1.)
    for (options, wanted) in [
        ("-B 0.3", vec!["band"]),
        ("-B 0.01", vec!["band"]),
        ("-l 60 90 0.6", vec!["zone 1"]),
        ("-L 70 80 0.4 1.2", vec!["zone 1", "zone 2"]),
        ("-B 0.2 -l 90 60 1", vec!["band", "zone 1"]),
    ] {
        let options: Vec<&str> = options.split(' ').collect();
        let found = parts(&lucarne(&options, &path));
        assert_eq!(found.iter().map(|f| f.0.as_str()).collect::<Vec<_>>(), wanted);
        let Some(mut evalglare) = testing::radiance("evalglare") else { return };
        let text = String::from_utf8_lossy(&evalglare.arg("-d").args(&options).arg(&path).output().unwrap().stdout).into_owned();
        let lines = text.lines().filter(|l| l.starts_with("band:") || l.starts_with("zoning:"));
        let theirs: Vec<Vec<f64>> =
            lines.map(|l| l.rsplit(':').next().unwrap().split_whitespace().map(|v| v.parse().unwrap()).collect()).collect();
        assert_eq!(theirs.len(), found.len(), "{text}");
        for ((name, ours), theirs) in found.iter().zip(&theirs) {
            let [_, omega, average, deviation, least, median, three_quarters, most, greatest, lux] = ours[..] else { panic!("{ours:?}") };
            let ours = [omega, average, median, deviation, three_quarters, most, least, greatest, lux];
            println!("{options:?} {name}\n{ours:.4?}\n{theirs:.4?}");
            // Solid angle, mean, median, deviation, percentiles, limits and, of zones, the illuminance. At a
            // percentile one pixel more or less may count.
            for (i, (a, b)) in ours.iter().zip(theirs).enumerate() {
                let is_percentile = matches!(i, 2 | 4 | 5);
                let limit = if is_percentile { PERCENTILE } else { VALUE };
                assert!((a - b).abs() <= limit * b.abs(), "{options:?} {name} {i}: {a} {b}");
                let most = &mut worst[usize::from(is_percentile)];
                *most = most.max((a - b).abs() / b.abs().max(1e-12));
            }
        }
    }
    let [values, percentiles] = worst.map(testing::short);
    let held = format!("{}, percentiles {}", testing::short(VALUE), testing::short(PERCENTILE));
    testing::measured("glare-parts", &format!("within {values}, percentiles {percentiles}"), &held);
}

#[test]
fn parts_leave_the_glare_as_it_is_and_an_even_field_has_one_luminance() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.hdr");
    picture(&path);
    let first = |options: &[&str]| String::from_utf8_lossy(&lucarne(options, &path).stdout).lines().nth(1).unwrap().to_string();
    assert_eq!(first(&[]), first(&["-B", "0.3", "-L", "60", "90", "0.2", "1"]));
    let lux = String::from_utf8_lossy(&lucarne(&["-V"], &path).stdout).into_owned();
    assert_eq!(lux.trim(), first(&[]).split(',').nth(7).unwrap());
    let mut even = Picture::new(SIZE, SIZE, vec![[2.0; 3]; SIZE * SIZE]).unwrap();
    even.view = Some(FISHEYE.into());
    hdr::write(&path, &even).unwrap();
    for (name, values) in parts(&lucarne(&["-B", "0.5", "-L", "75", "75", "1.0", "2.5"], &path)) {
        assert!(values[2..9].iter().enumerate().all(|(i, v)| (v - if i == 1 { 0.0 } else { 358.0 }).abs() < 1.5), "{name}: {values:?}");
        // A cap of half the opening angle.
        let cap = std::f64::consts::TAU * (1.0 - 0.5f64.cos());
        assert!(name != "zone 1" || (values[1] / cap - 1.0).abs() < 0.03, "{values:?}");
    }
    for (options, words) in [
        (&["-L", "75", "75", "2", "1"][..], "not larger than the inner"),
        (&["-l", "0", "0", "1"], "outside the view"),
        (&["-l", "750", "0", "1"], "is not a pixel"),
        (&["-B", "-1"], "not an angle"),
    ] {
        let output = lucarne(options, &path);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(1) && message.contains(words) && output.stdout.is_empty(), "{options:?}: {message}");
    }
}

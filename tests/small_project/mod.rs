//! A small five-phase project of one day with every kind of stored file, and what its results are compared by.
#![allow(dead_code, reason = "not every test that includes this file needs all of it")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

pub const PROJECT: &str = r#"
[weather]
file = "day.wea"
[scene]
files = ["room.rad"]
[[window]]
name = "south"
surface = "window.rad"
bsdf = "louvre.xml"
shade = "slat.rad"
[[sensors]]
name = "room"
points = "points.txt"
[[view]]
name = "eye"
file = "eye.vf"
resolution = [12, 12]
[images]
hours = [1909]
[glare]
method = "image"
[quality]
preset = "draft"
"#;

/// A five-phase project with every kind of stored file, of one day.
pub fn project() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/asymmetric");
    for file in ["room.rad", "window.rad", "louvre.xml", "points.txt"] {
        fs::copy(scenes.join(file), folder.path().join(file)).unwrap();
    }
    let mut wea =
        "place Test_USA\nlatitude 40.78\nlongitude 73.96\ntime_zone 75\nsite_elevation 40.0\nweather_data_file_units 1\n".to_string();
    for hour in 0..24 {
        let (direct, diffuse) = if (10..15).contains(&hour) { (500, 150) } else { (0, 0) };
        wea.push_str(&format!("3 21 {hour}.500 {direct} {diffuse}\n"));
    }
    let slat = "void plastic grey\n0\n0\n5 .5 .5 .5 0 0\n\ngrey polygon slat\n0\n0\n12\n1 -.05 1.5\n2 -.05 1.5\n2 -.15 1.4\n1 -.15 1.4\n";
    let view = "rvu -vta -vp 1.2 1.6 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180\n";
    for (name, text) in [("day.wea", wea.as_str()), ("eye.vf", view), ("slat.rad", slat), ("project.toml", PROJECT)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

pub fn lucarne(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lucarne"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    command
}

pub fn run(folder: &Path) -> Output {
    lucarne(folder, &["run", "project.toml", "-o", "out"]).output().unwrap()
}

pub fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { walk(&path, found) } else { found.push(path) }
    }
}

/// All results as they are.
pub fn results(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = Vec::new();
    walk(&folder.join("out"), &mut files);
    files.retain(|f| !f.ends_with("summary.json") && !f.ends_with(".lock"));
    files.into_iter().map(|f| (f.clone(), fs::read(f).unwrap())).collect()
}

/// The results without what tells of the run itself: the seconds that sampling took.
pub fn timeless(mut results: BTreeMap<PathBuf, Vec<u8>>) -> BTreeMap<PathBuf, Vec<u8>> {
    for (file, bytes) in &mut results {
        if file.file_name().unwrap().to_string_lossy().starts_with("replicates_") {
            bytes.drain(..header(bytes));
        }
    }
    results
}

/// Bytes of the header of a matrix.
pub fn header(bytes: &[u8]) -> usize {
    bytes.windows(2).position(|w| w == b"\n\n").map_or(200, |at| at + 2)
}

pub fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

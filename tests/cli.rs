//! The program as users run it: arguments, exit codes, messages, files, in a temporary folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

#[path = "../src/testing.rs"]
mod testing;

fn lucarne(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lucarne")).args(arguments).current_dir(folder).stdin(Stdio::null()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).to_string()
}

/// Whether kernels can run here, or a skip.
fn has_device() -> bool {
    testing::has_device(env!("CARGO_BIN_EXE_lucarne"))
}

/// A small room with a project: fast even on a processor. Everything a case does not change is sound.
struct Room {
    folder: tempfile::TempDir,
}

const PROJECT: &str = r#"
[weather]
file = "day.wea"
[scene]
files = ["room.rad"]
[[window]]
name = "south"
surface = "window.rad"
bsdf = "louvre.xml"
[[sensors]]
name = "room"
points = "points.txt"
[method]
bounces = 2
[quality]
preset = "draft"
"#;

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

fn day() -> String {
    let mut wea =
        "place Test_USA\nlatitude 40.78\nlongitude 73.96\ntime_zone 75\nsite_elevation 40.0\nweather_data_file_units 1\n".to_string();
    for hour in 0..24 {
        let sunny = (8..16).contains(&hour);
        let (direct, diffuse) = if sunny { (500, 150) } else { (0, 0) };
        wea.push_str(&format!("3 21 {hour}.500 {direct} {diffuse}\n"));
    }
    wea
}

impl Room {
    fn new() -> Self {
        let room = Self { folder: tempfile::tempdir().unwrap() };
        for file in ["room.rad", "window.rad", "louvre.xml", "points.txt"] {
            fs::copy(scenes().join("asymmetric").join(file), room.path(file)).unwrap();
        }
        room.write("day.wea", day());
        room.write("project.toml", PROJECT);
        room
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    fn replace(&self, name: &str, from: &str, to: &str) {
        let old = fs::read_to_string(self.path(name)).unwrap();
        assert!(old.contains(from), "{name} has no '{from}'");
        self.write(name, old.replacen(from, to, 1));
    }

    fn run(&self) -> Output {
        lucarne(self.folder.path(), &["run", "project.toml", "-o", "out"])
    }

    /// All files below the folder.
    fn files(&self) -> Vec<PathBuf> {
        fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() { walk(&path, found) } else { found.push(path) }
            }
        }
        let mut found = Vec::new();
        walk(self.folder.path(), &mut found);
        found
    }

    /// A run that must fail with exactly one error that holds all `words`, leaving nothing
    /// half-written and no result.
    fn fails(&self, words: &[&str]) {
        let output = self.run();
        let message = text(&output.stderr);
        // 5 for a file that cannot be read.
        assert!(matches!(output.status.code(), Some(1 | 5)), "{message}");
        assert_eq!(message.matches("lucarne: error: ").count(), 1, "{message}");
        assert!(!message.contains("panicked"), "{message}");
        for word in words {
            assert!(message.contains(word), "no '{word}' in: {message}");
        }
        for file in self.files() {
            let name = file.to_string_lossy();
            assert!(!name.contains("partial") && !name.contains("illuminance/"), "left behind: {name}");
        }
        assert!(!self.path("out/summary.json").exists());
    }
}

/// Values of a float matrix file and its sizes.
fn read_matrix(path: &Path) -> (usize, usize, usize, Vec<f32>) {
    let bytes = fs::read(path).unwrap();
    let end = bytes.windows(2).position(|w| w == b"\n\n").unwrap();
    let header = text(&bytes[..end]);
    let value = |key: &str| header.lines().find_map(|l| l.strip_prefix(key)).unwrap().trim().parse::<usize>().unwrap();
    let (rows, cols, components) = (value("NROWS="), value("NCOLS="), value("NCOMP="));
    let data = bytes[end + 2..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect::<Vec<_>>();
    assert_eq!(data.len(), rows * cols * components);
    (rows, cols, components, data)
}

#[test]
fn a_project_gives_its_illuminances_and_goes_on_where_it_was() {
    if !has_device() {
        return;
    }
    let room = Room::new();
    let first = room.run();
    assert!(first.status.success(), "{}", text(&first.stderr));
    assert!(text(&first.stdout).contains("out/illuminance/room.mtx: 11 sensors, 24 hours"), "{}", text(&first.stdout));
    let (rows, cols, components, lux) = read_matrix(&room.path("out/illuminance/room.mtx"));
    assert_eq!((rows, cols, components), (11, 24, 1));
    // Light by day at every sensor, none by night.
    assert!(lux.iter().all(|v| v.is_finite() && *v >= 0.0));
    assert!((0..11).all(|s| lux[s * 24 + 12] > 10.0 && lux[s * 24] == 0.0));
    for (name, wanted) in [("S", (2306, 24, 3)), ("V_room", (11, 41, 3)), ("D_south", (41, 2306, 3)), ("T_south", (41, 41, 3))] {
        let (rows, cols, components, _) = read_matrix(&room.path(&format!("out/matrices/{name}.mtx")));
        assert_eq!((rows, cols, components), wanted, "{name}");
    }
    let csv = fs::read_to_string(room.path("out/illuminance/room.csv")).unwrap();
    assert_eq!(csv.lines().count(), 25);
    assert!(csv.starts_with("month,day,hour,1 (0.5 1 0.8),") && csv.lines().nth(13).unwrap().starts_with("3,21,12.500,"));
    let summary: serde_json::Value = serde_json::from_slice(&fs::read(room.path("out/summary.json")).unwrap()).unwrap();
    assert!(summary["rays_per_second"].as_f64().unwrap() > 0.0);
    assert!(summary["estimated_error"]["annual_median"].as_f64().unwrap() > 0.0);
    assert_eq!((summary["seed"].as_u64(), summary["hours"].as_u64(), summary["bounces"].as_u64()), (Some(1), Some(24), Some(2)));
    assert!(summary["matrices"].as_array().unwrap().iter().all(|m| m["reused"] == false));
    assert!(summary["device"]["name"].as_str().is_some_and(|n| !n.is_empty()));

    // The same inputs: nothing is traced again, and the result is the same to the bit.
    let before = fs::read(room.path("out/illuminance/room.mtx")).unwrap();
    assert!(room.run().status.success());
    let summary: serde_json::Value = serde_json::from_slice(&fs::read(room.path("out/summary.json")).unwrap()).unwrap();
    assert!(summary["matrices"].as_array().unwrap().iter().all(|m| m["reused"] == true), "{summary}");
    assert_eq!(before, fs::read(room.path("out/illuminance/room.mtx")).unwrap());

    // A new window property touches neither V, D nor S; new sensors touch V only.
    room.replace("louvre.xml", "0.15/pi", "0.15 / pi");
    room.replace("points.txt", "1.5 3 1.2 1 0 0", "1.6 3 1.2 1 0 0");
    assert!(room.run().status.success());
    let summary: serde_json::Value = serde_json::from_slice(&fs::read(room.path("out/summary.json")).unwrap()).unwrap();
    let reused: Vec<_> =
        summary["matrices"].as_array().unwrap().iter().map(|m| (m["name"].as_str().unwrap(), m["reused"] == true)).collect();
    assert_eq!(reused, [("S", true), ("V_room", false), ("D_south", true)]);
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_seed_others() {
    if !has_device() {
        return;
    }
    let result = |seed: &str| {
        let room = Room::new();
        room.replace("project.toml", "preset = \"draft\"", &format!("preset = \"draft\"\nseed = {seed}"));
        assert!(room.run().status.success());
        read_matrix(&room.path("out/illuminance/room.mtx")).3
    };
    let (a, b, c) = (result("7"), result("7"), result("8"));
    assert_eq!(a, b);
    assert_ne!(a, c);
}

#[test]
fn faults_in_the_project_name_file_line_key_and_remedy() {
    let case = |from: &str, to: &str, words: &[&str]| {
        let room = Room::new();
        room.replace("project.toml", from, to);
        room.fails(words);
    };
    case("bounces", "bounses", &["project.toml:14: ", "'bounses'", "did you mean 'bounces'?"]);
    case("\"draft\"", "\"fast\"", &["project.toml:16: quality.preset: ", "choose"]);
    case("room.rad", "rooom.rad", &["project.toml:5: scene.files: ", "rooom.rad"]);
    let room = Room::new();
    room.write("project.toml", b"\x00\xff\xfe garbage");
    room.fails(&["project.toml:1: "]);
    fs::remove_file(room.path("project.toml")).unwrap();
    room.fails(&["project.toml: "]);
}

#[test]
fn faults_in_points_are_named_with_their_line() {
    for (points, words) in [
        ("1 1 0.8 0 0 1\n1 nan 0.8 0 0 1\n", &["points.txt:2: ", "'nan'"][..]),
        ("1 1 0.8 0 0 0\n", &["points.txt:1: ", "no length"]),
        ("1 1 0.8 0 0\n", &["points.txt:1: ", "5 numbers"]),
        ("", &["points.txt: ", "no sensor"]),
        ("\u{0}\u{1}\u{2}\n", &["points.txt:1: "]),
    ] {
        let room = Room::new();
        room.write("points.txt", points);
        room.fails(words);
    }
}

#[test]
fn a_sensor_without_light_is_zero_and_marked_and_no_reason_to_stop() {
    if !has_device() {
        return;
    }
    let room = Room::new();
    room.replace("points.txt", "0.5 1 0.8 0 0 1", "0.5 1 0.8 0 0 1\n-0.5 1 0.8 1 0 0");
    // A closed box around the second sensor.
    room.replace("room.rad", "light polygon floor", "!genbox light wall 0.4 0.4 0.4 | xform -t -0.7 0.8 0.6\n\nlight polygon floor");
    let output = room.run();
    let message = text(&output.stderr);
    assert!(output.status.success(), "{message}");
    let (warning, tracing) = (message.find("points.txt:3: ").expect(&message), message.find("matrix").unwrap_or(message.len()));
    assert!(warning < tracing, "told before tracing: {message}");
    assert_eq!(message.matches("points.txt:3: ").count(), 1, "told once: {message}");
    assert!(message.contains("1 of 12 sensors of 'room'") && message.contains("2 (at -0.5 1 0.8)"), "{message}");
    let (rows, steps, _, lux) = read_matrix(&room.path("out/illuminance/room.mtx"));
    assert_eq!(rows, 12);
    for sensor in 0..rows {
        assert_eq!(lux[sensor * steps + 12] > 10.0, sensor != 1, "sensor {}", sensor + 1);
    }
    let csv = fs::read_to_string(room.path("out/illuminance/room.csv")).unwrap();
    assert!(csv.starts_with("month,day,hour,1 (0.5 1 0.8),2 no light (-0.5 1 0.8),"), "{}", csv.lines().next().unwrap());
    let annual = fs::read_to_string(room.path("out/illuminance/room_annual.csv")).unwrap();
    let marked: Vec<usize> = annual.lines().enumerate().filter(|(_, l)| l.ends_with(",no light")).map(|(i, _)| i).collect();
    assert_eq!(marked, [2]);
    let summary: serde_json::Value = serde_json::from_slice(&fs::read(room.path("out/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["sensors"][0]["without_light"], 1);

    // All in the dark is a mistake.
    room.write("points.txt", "-0.5 1 0.8 1 0 0\n-0.5 1 0.85 1 0 0\n");
    fs::remove_dir_all(room.path("out")).unwrap();
    room.fails(&["points.txt:1: ", "no light of any window reaches any sensor"]);
}

#[test]
fn faults_in_the_scene_are_named_with_their_line() {
    for (from, to, words) in [
        ("0 0 0\n    3 0 0\n", "0 nan 0\n    3 0 0\n", &["room.rad:"][..]),
        ("light polygon floor", "lihgt polygon floor", &["room.rad:", "lihgt"]),
        ("light polygon floor", "!rm -rf everything\nlight polygon floor", &["room.rad:", "rm"]),
        ("light polygon floor", "!xform missing.rad\nlight polygon floor", &["room.rad:", "missing.rad"]),
        ("5 0.7 0.7 0.7 0 0", "5 0.7 0.7", &["room.rad:"]),
    ] {
        let room = Room::new();
        room.write("everything", "still here");
        room.replace("room.rad", from, to);
        room.fails(words);
        assert!(room.path("everything").exists());
    }
    let room = Room::new();
    let whole = fs::read(room.path("room.rad")).unwrap();
    room.write("room.rad", &whole[..whole.len() - 20]);
    room.fails(&["room.rad:"]);
    room.write("room.rad", b"\x7fELF\x02\x01\x01\x00\x00\x00");
    room.fails(&["room.rad"]);
}

#[test]
fn a_window_that_faces_the_wrong_way_is_named() {
    let room = Room::new();
    let lines = fs::read_to_string(room.path("window.rad")).unwrap();
    let mut lines: Vec<&str> = lines.lines().collect();
    let corners = lines.len() - 4;
    lines[corners..].reverse();
    room.write("window.rad", lines.join("\n"));
    room.fails(&["window.rad:", "wrong way", "reverse"]);
}

#[test]
fn bsdf_files_that_do_not_serve_are_named() {
    let room = Room::new();
    room.replace("window.rad", "h=kq", "h=kf");
    room.fails(&["window.rad:", "louvre.xml", "145 bins", "41", "h=kq"]);
    let room = Room::new();
    let whole = fs::read_to_string(room.path("louvre.xml")).unwrap();
    for part in [whole.len() / 2, 10, 0] {
        room.write("louvre.xml", &whole[..part]);
        room.fails(&["louvre.xml"]);
    }
    room.write("louvre.xml", whole.replacen("<ColumnAngleBasis>LBNL/Klems Quarter", "<ColumnAngleBasis>LBNL/Klems Full", 1));
    room.fails(&["louvre.xml:", "1681"]);
    room.write("louvre.xml", whole.replacen("<ScatteringData>\n", "<ScatteringData>\nNaN ", 1));
    room.fails(&["louvre.xml"]);
    room.write("louvre.xml", [0u8, 159, 146, 150]);
    room.fails(&["louvre.xml"]);
}

#[test]
fn weather_that_does_not_serve_is_named() {
    let year = fs::read_to_string(scenes().join("office/weather/new_york.wea")).unwrap();
    let room = Room::new();
    let gap: Vec<&str> = year.lines().enumerate().filter(|(i, _)| *i != 4000).map(|(_, l)| l).collect();
    room.write("day.wea", gap.join("\n"));
    room.fails(&["day.wea:4001: ", "missing"]);
    for (from, to, words) in [
        ("3 21 12.500 500 150", "3 21 12.500 500 -150", &["day.wea:19: "][..]),
        ("3 21 12.500 500 150", "3 21 12.500 nan 150", &["day.wea:19: "]),
        ("3 21 12.500 500 150", "3 21 12.500 500", &["day.wea:19: "]),
        ("3 21 12.500 500 150", "13 21 12.500 500 150", &["day.wea:19: "]),
        ("latitude 40.78", "latitude 140.78", &["day.wea:2: ", "latitude"]),
        ("place Test_USA", "garbage", &["day.wea:1: ", "neither"]),
    ] {
        let room = Room::new();
        room.replace("day.wea", from, to);
        room.fails(words);
    }
}

#[test]
fn an_output_folder_that_cannot_be_written_to_is_named() {
    if !has_device() {
        return;
    }
    let room = Room::new();
    room.write("out", "this is a file");
    let output = room.run();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(5));
    assert!(message.contains("out/matrices") && message.contains("output folder") && message.contains("-o"), "{message}");
    assert_eq!(fs::read_to_string(room.path("out")).unwrap(), "this is a file");
}

#[test]
fn matrices_that_do_not_fit_their_headers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, rows: usize, cols: usize, values: usize| {
        let mut file = format!("#?RADIANCE\nNROWS={rows}\nNCOLS={cols}\nNCOMP=3\nFORMAT=ascii\n\n");
        file.push_str(&"1 1 1\t".repeat(values));
        fs::write(folder.path().join(name), file).unwrap();
    };
    write("dc.mtx", 2, 3, 6);
    write("s.mtx", 3, 4, 12);
    let good = lucarne(folder.path(), &["multiply", "dc.mtx", "s.mtx", "-o", "e.mtx"]);
    assert!(good.status.success(), "{}", text(&good.stderr));
    assert!(folder.path().join("e.mtx").exists());
    fs::remove_file(folder.path().join("e.mtx")).unwrap();
    for (rows, cols, values, words) in [(3, 4, 11, "s.mtx"), (3, 4, 13, "s.mtx"), (4, 4, 16, "s.mtx"), (0, 4, 0, "s.mtx")] {
        write("s.mtx", rows, cols, values);
        let output = lucarne(folder.path(), &["multiply", "dc.mtx", "s.mtx", "-o", "e.mtx"]);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{rows} {cols} {values}: {message}");
        assert!(message.contains(words) && !message.contains("panicked"), "{message}");
    }
    for (name, code) in [("missing.mtx", 5), (".", 1)] {
        let output = lucarne(folder.path(), &["multiply", "dc.mtx", name, "-o", "e.mtx"]);
        assert_eq!(output.status.code(), Some(code));
        assert!(text(&output.stderr).contains("lucarne: error: "));
    }
    fs::write(folder.path().join("s.mtx"), b"#?RADIANCE\nNROWS=3\nNCOLS=4\nNCOMP=3\nFORMAT=float\n\n\x00\x01").unwrap();
    assert_eq!(lucarne(folder.path(), &["multiply", "dc.mtx", "s.mtx", "-o", "e.mtx"]).status.code(), Some(1));
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("day.wea"), day()).unwrap();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_lucarne"))
        .args(["sky", "day.wea"])
        .current_dir(folder.path())
        .stdout(Stdio::from(full))
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{message}");
    assert!(message.contains("lucarne: error: ") && message.contains("space left"), "{message}");
}

#[test]
fn help_and_version_are_there_and_nonsense_is_refused() {
    let here = Path::new(".");
    let help = lucarne(here, &["--help"]);
    assert!(help.status.success());
    for verb in ["matrix", "sky", "multiply", "bsdf", "falsecolor", "glare", "devices", "run"] {
        assert!(text(&help.stdout).contains(&format!("\n  {verb}")), "{verb}");
    }
    assert_eq!(text(&lucarne(here, &["--version"]).stdout), format!("lucarne {}\n", env!("CARGO_PKG_VERSION")));
    assert_eq!(lucarne(here, &["rnu", "x.toml"]).status.code(), Some(2));
    assert_eq!(lucarne(here, &[]).status.code(), Some(2));
    assert_eq!(lucarne(here, &["run"]).status.code(), Some(2));
}

#[test]
fn a_device_that_does_not_exist_is_refused() {
    let room = Room::new();
    let output = lucarne(room.folder.path(), &["run", "project.toml", "-o", "out", "--device", "no such device"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("lucarne: error: "), "{}", text(&output.stderr));
    assert!(!room.path("out").exists());
}

#[test]
#[cfg(unix)]
fn ctrl_c_stops_cleanly_and_the_run_goes_on_later() {
    if !has_device() {
        return;
    }
    let room = Room::new();
    room.replace("project.toml", "\"draft\"", "\"final\"");
    let mut child = Command::new(env!("CARGO_BIN_EXE_lucarne"))
        .args(["run", "project.toml", "-o", "out"])
        .current_dir(room.folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The sky matrix is the first file: from then on the program is at work.
    let start = std::time::Instant::now();
    while !room.path("out/matrices/S.mtx").exists() {
        assert!(start.elapsed().as_secs() < 60, "no matrix within a minute");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let code = child.wait().unwrap().code();
    assert_eq!(code, Some(4));
    assert!(room.files().iter().all(|f| !f.to_string_lossy().contains("partial")));
    assert!(!room.path("out/summary.json").exists());
}

#[test]
fn slats_and_screens_are_made_in_one_line_and_slips_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| lucarne(folder.path(), &[&["bsdf", "generate"], arguments].concat());
    let fails = |arguments: &[&str], words: &[&str]| {
        let output = run(arguments);
        let message = text(&output.stderr);
        assert!(!output.status.success() && words.iter().all(|w| message.contains(w)), "{arguments:?}: {message}");
    };
    fails(&[], &["no device", "--venetian"]);
    fails(&["--venetian", "width=25,spacing=20mm,reflectance=0.5"], &["--venetian", "width=25 has no unit", "25mm"]);
    fails(&["--venetian", "width=25mm,reflectance=0.5"], &["spacing is missing"]);
    fails(&["--venetian", "width=25mm,spacing=20mm,reflectance=1.5"], &["reflectance=1.5"]);
    fails(&["--venetian", "width=25mm,spacing=20mm,angle=90,reflectance=0.5"], &["cut each other"]);
    fails(&["--venetian", "wdth=25mm"], &["'wdth' is unknown", "width"]);
    fails(&["--woven", "diameter=2mm,spacing=1mm,reflectance=0.5"], &["overlap"]);
    fails(&["--woven", "diameter=1mm,spacing=2mm,reflectance=0.5", "-t4", "3"], &["convert"]);
    fails(&["-t4", "9", "device.rad"], &["-t4", "out of range"]);
    fails(&["--basis", "klems", "device.rad"], &["full, half or quarter"]);
    fails(&["absent.rad"], &["absent.rad"]);
    fs::write(folder.path().join("room.rad"), "void plastic p 0 0 5 .5 .5 .5 0 0\np polygon q 0 0 12 0 0 1 1 0 1 1 1 1 0 1 1\n").unwrap();
    if has_device() {
        fails(&["room.rad"], &["in the room", "xform"]);
    }
    for (kind, parameters) in
        [("--woven", "diameter=0.5mm,spacing=1mm,reflectance=0.6"), ("--perforated", "diameter=2mm,spacing=4mm,reflectance=0.6")]
    {
        assert!(run(&[kind, parameters, "-o", "screen.xml"]).status.success());
        assert!(lucarne(folder.path(), &["bsdf", "check", "screen.xml"]).status.success(), "{kind}");
    }
    if !has_device() {
        return;
    }
    let slats = ["--venetian", "width=25mm,spacing=20mm,angle=20,reflectance=0.5"];
    let small = ["-c", "256", "--basis", "quarter", "-o", "blind.xml", "--standard-error", "errors.mtx", "--geometry"];
    let output = run(&[&slats[..], &small].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let xml = fs::read_to_string(folder.path().join("blind.xml")).unwrap();
    assert!(xml.contains("Venetian Blind") && xml.contains("MGFblock") && xml.contains("Transmission Front"));
    assert!(!folder.path().join("blind.xml.resume").exists());
    let (rows, columns, _, errors) = read_matrix(&folder.path().join("errors.mtx"));
    assert_eq!((rows, columns), (4 * 41, 41));
    assert!(errors.iter().all(|e| e.is_finite()) && errors.iter().any(|&e| e > 0.0));
    assert!(run(&[&slats[..], &["-c", "256", "-t3", "3", "-f", "-o", "tree.xml"]].concat()).status.success());
    let xml = fs::read_to_string(folder.path().join("tree.xml")).unwrap();
    assert!(xml.contains("TensorTree3") && xml.contains("Transmission Back") && !xml.contains("Front</Wave"));
}

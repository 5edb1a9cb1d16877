//! Stored results that cannot be mistaken: damage is noticed, two runs do not share a folder, and what a
//! killed run left half-written goes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

#[path = "../src/testing.rs"]
mod testing;

const PROJECT: &str = r#"
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
fn project() -> tempfile::TempDir {
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

fn run(folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lucarne"))
        .args(["run", "project.toml", "-o", "out"])
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { walk(&path, found) } else { found.push(path) }
    }
}

/// All results as they are.
fn results(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = Vec::new();
    walk(&folder.join("out"), &mut files);
    files.retain(|f| !f.ends_with("summary.json") && !f.ends_with(".lock"));
    files.into_iter().map(|f| (f.clone(), fs::read(f).unwrap())).collect()
}

/// The results without what tells of the run itself: the seconds that sampling took.
fn timeless(mut results: BTreeMap<PathBuf, Vec<u8>>) -> BTreeMap<PathBuf, Vec<u8>> {
    for (file, bytes) in &mut results {
        if file.file_name().unwrap().to_string_lossy().starts_with("replicates_") {
            bytes.drain(..header(bytes));
        }
    }
    results
}

/// Bytes of the header of a matrix.
fn header(bytes: &[u8]) -> usize {
    bytes.windows(2).position(|w| w == b"\n\n").map_or(200, |at| at + 2)
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_flipped_byte_in_any_stored_file_is_noticed_and_the_results_are_the_same() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let first = run(folder.path());
    assert!(first.status.success(), "{}", text(&first));
    let whole = results(folder.path());
    let stored: Vec<&PathBuf> = whole.keys().filter(|f| f.parent().unwrap().ends_with("matrices") && !f.ends_with("suns.rad")).collect();
    assert!(stored.len() >= 19, "kinds of stored files: {stored:?}");

    // In the checksum, behind the header, in the middle, at the end; and a file that is cut.
    let checksum = |bytes: &[u8]| bytes.windows(9).position(|w| w == b"CHECKSUM=").unwrap() + 20;
    let places: [(&str, &dyn Fn(&[u8]) -> usize); 4] =
        [("checksum", &checksum), ("first value", &header), ("middle", &|b| (header(b) + b.len()) / 2), ("last byte", &|b| b.len() - 1)];
    for (name, place) in places {
        for (number, file) in stored.iter().enumerate() {
            let mut bytes = whole[*file].clone();
            let at = place(&bytes);
            bytes[at] ^= 1 << (number % 8);
            fs::write(file, bytes).unwrap();
        }
        let again = run(folder.path());
        let told = text(&again);
        assert!(again.status.success(), "{name}: {told}");
        assert!(told.contains("has changed since it was written") && told.contains("S.mtx"), "{name}: {told}");
        let now = timeless(results(folder.path()));
        assert_eq!(now.keys().collect::<Vec<_>>(), whole.keys().collect::<Vec<_>>(), "{name}");
        for (file, bytes) in &timeless(whole.clone()) {
            assert!(now[file] == *bytes, "{name}: {} differs", file.display());
        }
    }
    for file in &stored {
        fs::write(file, &whole[*file][..whole[*file].len() - 1]).unwrap();
    }
    let again = run(folder.path());
    assert!(again.status.success(), "{}", text(&again));
    assert!(timeless(results(folder.path())) == timeless(whole.clone()));
    // Results that are only looked at are checked too.
    let flip = |name: &str| {
        let file = folder.path().join("out").join(name);
        let good = fs::read(&file).unwrap();
        let mut bytes = good.clone();
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        fs::write(&file, bytes).unwrap();
        let open = || -> lucarne::Result<()> {
            let results = lucarne::simulate::Results::open(&folder.path().join("out"))?;
            results.year.picture("eye", 12).map(|_| ())
        };
        let error = open().expect_err(name).to_string();
        assert!(error.contains("has changed since it was written"), "{name}: {error}");
        fs::write(&file, good).unwrap();
        open().unwrap();
    };
    ["illuminance/room.mtx", "illuminance/room_standard_error.mtx", "matrices/S.mtx", "matrices/D_south_direct.mtx"]
        .into_iter()
        .for_each(flip);
    ["matrices/V_eye.mtx", "matrices/V_eye_direct.mtx", "matrices/C_eye.suns"].into_iter().for_each(flip);
    // Nothing is computed twice where nothing is wrong.
    let quiet = run(folder.path());
    assert!(quiet.status.success() && !text(&quiet).contains("has changed"), "{}", text(&quiet));
    assert!(timeless(results(folder.path())) == timeless(whole.clone()));
}

#[test]
fn two_runs_do_not_share_a_folder_and_leftovers_of_a_killed_one_go() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let out = folder.path().join("out");
    fs::create_dir_all(out.join("matrices")).unwrap();
    let leftover = out.join("matrices/V_room.mtx.123.partial");
    fs::write(&leftover, b"half").unwrap();
    let lock = fs::File::create(out.join(".lock")).unwrap();
    lock.try_lock().unwrap();
    let refused = run(folder.path());
    assert_eq!(refused.status.code(), Some(1), "{}", text(&refused));
    assert!(text(&refused).contains("another run writes into this folder"), "{}", text(&refused));
    assert!(leftover.exists(), "the other run may be writing it");
    drop(lock);
    let run = run(folder.path());
    assert!(run.status.success(), "{}", text(&run));
    assert!(results(folder.path()).keys().all(|f| !f.to_string_lossy().contains("partial")));
}

/// Random kills of one test; more of them by `LUCARNE_KILLS`.
const KILLS: usize = 6;

#[test]
fn runs_that_are_killed_end_in_the_same_results_and_leave_nothing_behind() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let project = PROJECT.replace("\"draft\"", "\"standard\"");
    fs::write(folder.path().join("project.toml"), &project).unwrap();
    let start = std::time::Instant::now();
    let undisturbed = run(folder.path());
    assert!(undisturbed.status.success(), "{}", text(&undisturbed));
    let whole = timeless(results(folder.path()));
    let length = start.elapsed();

    let kills = std::env::var("LUCARNE_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(KILLS);
    let out = folder.path().join("out");
    fs::remove_dir_all(&out).unwrap();
    // A Weyl sequence: moments all over the run, in no order.
    let mut moment = 0.37f64;
    for number in 0..kills {
        moment = (moment + 0.618_034) % 1.0;
        let mut child = Command::new(env!("CARGO_BIN_EXE_lucarne"))
            .args(["run", "project.toml", "-o", "out"])
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(length.mul_f64(moment));
        let signal = ["-KILL", "-TERM", "-INT"][number % 3];
        // It may have ended already.
        let _ = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status().unwrap();
        let code = child.wait().unwrap().code();
        assert!([None, Some(0), Some(4)].contains(&code), "{signal}: {code:?}");
        if number % 4 == 3 {
            let rest = run(folder.path());
            assert!(rest.status.success(), "{}", text(&rest));
            let now = timeless(results(folder.path()));
            assert!(now.keys().eq(whole.keys()), "{signal}: {:?}", now.keys());
            whole.iter().for_each(|(file, bytes)| assert!(now[file] == *bytes, "{signal}: {} differs", file.display()));
            fs::remove_dir_all(&out).unwrap();
        }
    }
    let rest = run(folder.path());
    assert!(rest.status.success(), "{}", text(&rest));
    assert!(timeless(results(folder.path())) == whole);
}

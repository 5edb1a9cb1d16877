//! What surrounds a run: full and read-only disks, links, files that vanish, closed pipes, odd names and locales.
//! Each ends in the right result or in one clear error, and never in damage to anything.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

mod small_project;
#[path = "../src/testing.rs"]
mod testing;

use small_project::{PROJECT, lucarne, project, results, run, text, timeless};

/// Runs are told apart by their seed.
fn with_seed(folder: &Path, seed: u32) {
    fs::write(folder.join("project.toml"), format!("{PROJECT}seed = {seed}\n")).unwrap();
}

fn errors(output: &Output) -> usize {
    text(output).lines().filter(|l| l.starts_with("lucarne: error:")).count()
}

/// Runs a script as root of a namespace of its own, where it may mount; nothing where that is not possible.
fn in_namespace(folder: &Path, script: &str) -> Option<Output> {
    let run = |script: &str| {
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", script]).current_dir(folder).stdin(Stdio::null());
        command.env("LUCARNE", env!("CARGO_BIN_EXE_lucarne")).output()
    };
    fs::create_dir_all(folder.join("probe")).unwrap();
    match run("mount -t tmpfs -o size=64k none probe") {
        Ok(output) if output.status.success() => Some(run(script).unwrap()),
        _ => {
            testing::note(&"no file system can be mounted in a namespace of one's own here");
            None
        }
    }
}

/// Levels of a full disk; more of them by `LUCARNE_SOAK`.
fn levels() -> usize {
    if std::env::var_os("LUCARNE_SOAK").is_some() { 24 } else { 5 }
}

#[test]
fn a_full_disk_is_one_clear_error_and_leaves_earlier_results_as_they_are() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let at = |name: &str| folder.path().join(name);
    with_seed(folder.path(), 1);
    assert!(run(folder.path()).status.success());
    let first = timeless(results(folder.path()));
    fs::rename(at("out"), at("first")).unwrap();
    with_seed(folder.path(), 2);
    assert!(run(folder.path()).status.success());
    let second = timeless(results(folder.path()));
    let size: u64 = second.values().map(|b| b.len() as u64).sum();
    fs::rename(at("out"), at("second")).unwrap();
    fs::create_dir(at("out")).unwrap();
    fs::create_dir(at("found")).unwrap();
    // The first results lie on a disk that has room for a part of the second ones: none at all to almost enough.
    let levels = levels();
    let script = format!(
        r#"set -e
        for level in $(seq 0 {last}); do
            mount -t tmpfs -o size={room}k none out
            cp -r first/. out/
            free=$(( {more} * level / {levels} ))
            used=$(du -sk out | cut -f1)
            mount -o remount,size=$(( used + free + 4 ))k out
            code=0; "$LUCARNE" run project.toml -o out 2> found/errors-$level > /dev/null || code=$?
            echo $code > found/code-$level
            cp -r out found/full-$level
            mount -o remount,size={room}k out
            "$LUCARNE" run project.toml -o out > /dev/null 2> found/again-$level
            cp -r out found/out-$level
            umount out
        done"#,
        last = levels - 1,
        room = 4 * size / 1024 + 8192,
        more = size / 1024,
    );
    let Some(output) = in_namespace(folder.path(), &script) else { return };
    assert!(output.status.success(), "{}", text(&output));
    let files = |folder: PathBuf| -> BTreeMap<PathBuf, Vec<u8>> {
        let mut found = Vec::new();
        small_project::walk(&folder, &mut found);
        let name = |f: &PathBuf| f.strip_prefix(&folder).unwrap().to_path_buf();
        timeless(found.iter().map(|f| (name(f), fs::read(f).unwrap())).collect())
    };
    let named = |results: &BTreeMap<PathBuf, Vec<u8>>| -> BTreeMap<PathBuf, Vec<u8>> {
        results.iter().map(|(path, bytes)| (path.strip_prefix(at("out")).unwrap().to_path_buf(), bytes.clone())).collect()
    };
    let (first, second) = (named(&first), named(&second));
    let mut full = 0;
    for level in 0..levels {
        let code = fs::read_to_string(at(&format!("found/code-{level}"))).unwrap();
        let told = fs::read_to_string(at(&format!("found/errors-{level}"))).unwrap();
        if code.trim() != "0" {
            full += 1;
            assert_eq!(code.trim(), "5", "level {level}: {told}");
            assert_eq!(told.lines().filter(|l| l.starts_with("lucarne: error:")).count(), 1, "level {level}: {told}");
            assert!(told.contains("No space left") && told.contains("free some disk space"), "level {level}: {told}");
        }
        // Each file is that of the first run or of the second, whole.
        for (name, bytes) in files(at(&format!("found/full-{level}"))) {
            let is = |all: &BTreeMap<PathBuf, Vec<u8>>| all.get(&name) == Some(&bytes);
            let other = name.ends_with("summary.json") || name.ends_with(".lock") || name.extension().is_some_and(|e| e == "units");
            assert!(other || is(&first) || is(&second), "level {level}: {} is neither", name.display());
        }
        let out = files(at(&format!("found/out-{level}")));
        for (name, bytes) in &second {
            assert!(out.get(name) == Some(bytes), "level {level}: {} differs after there was room", name.display());
        }
        assert!(out.keys().all(|n| second.contains_key(n) || n.ends_with("summary.json") || n.ends_with(".lock")), "level {level}");
    }
    assert!(full > levels / 2, "{full} of {levels} disks were full");
    if levels >= 20 {
        testing::measured(
            "full-disk",
            &format!("{full} full disks: one error each, every file whole, the rerun the same bits"),
            "0 damaged",
        );
    }
}

#[test]
fn a_folder_that_cannot_be_written_to_is_a_clear_error() {
    let folder = project();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("file"), b"mine").unwrap();
    let refused = lucarne(folder.path(), &["run", "project.toml", "-o", "file"]).output().unwrap();
    if testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        assert_eq!((refused.status.code(), errors(&refused)), (Some(5), 1), "{}", text(&refused));
        assert!(text(&refused).contains("output folder") && text(&refused).contains("-o"), "{}", text(&refused));
        fs::create_dir(at("out")).unwrap();
        let script = "mount -t tmpfs -o ro none out && \"$LUCARNE\" run project.toml -o out";
        if let Some(refused) = in_namespace(folder.path(), script) {
            assert_eq!((refused.status.code(), errors(&refused)), (Some(5), 1), "{}", text(&refused));
            assert!(text(&refused).contains("Read-only file system"), "{}", text(&refused));
        }
    }
    assert_eq!(fs::read(at("file")).unwrap(), b"mine");
}

#[cfg(unix)]
#[test]
fn what_links_lead_to_is_left_alone() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let at = |name: &str| folder.path().join(name);
    let plain = run(folder.path());
    assert!(plain.status.success(), "{}", text(&plain));
    let whole = timeless(results(folder.path()));
    fs::remove_dir_all(at("out")).unwrap();
    fs::create_dir_all(at("out/matrices")).unwrap();
    fs::create_dir_all(at("out/illuminance")).unwrap();
    let names = [
        ".lock",
        "matrices/V_room.mtx",
        "matrices/V.units",
        "matrices/V_eye.units",
        "matrices/D_south.units",
        "illuminance/room.csv",
        "summary.json",
    ];
    for (number, name) in names.iter().enumerate() {
        let outside = at(&format!("outside-{number}"));
        fs::write(&outside, b"not yours").unwrap();
        std::os::unix::fs::symlink(&outside, at("out").join(name)).unwrap();
    }
    let linked = run(folder.path());
    assert!(linked.status.success(), "{}", text(&linked));
    for number in 0..names.len() {
        assert_eq!(fs::read(at(&format!("outside-{number}"))).unwrap(), b"not yours", "{}", names[number]);
    }
    assert!(timeless(results(folder.path())) == whole);
}

#[test]
fn files_that_vanish_are_named() {
    let folder = project();
    for file in ["day.wea", "room.rad", "window.rad", "louvre.xml", "points.txt", "slat.rad", "eye.vf"] {
        let away = folder.path().join("away");
        fs::rename(folder.path().join(file), &away).unwrap();
        let refused = run(folder.path());
        fs::rename(&away, folder.path().join(file)).unwrap();
        // The project file names what is not there: that can be mended in it.
        assert_eq!((refused.status.code(), errors(&refused)), (Some(1), 1), "{file}: {}", text(&refused));
        assert!(text(&refused).contains(file), "{file}: {}", text(&refused));
    }
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    // The output folder goes while it is written into.
    let mut child =
        lucarne(folder.path(), &["run", "project.toml", "-o", "out"]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    while !folder.path().join("out/matrices/S.mtx").exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let _ = fs::remove_dir_all(folder.path().join("out"));
    let output = child.wait_with_output().unwrap();
    assert!(matches!(output.status.code(), Some(0 | 5)), "{:?}: {}", output.status, text(&output));
    assert!(output.status.success() || errors(&output) == 1, "{}", text(&output));
    // Times of files, which a clock may set anywhere, mean nothing.
    let again = run(folder.path());
    assert!(again.status.success(), "{}", text(&again));
    let whole = results(folder.path());
    for (number, file) in whole.keys().enumerate() {
        let time = std::time::UNIX_EPOCH + std::time::Duration::from_secs(number as u64 % 2 * 4_000_000_000);
        fs::File::options().append(true).open(file).unwrap().set_modified(time).unwrap();
    }
    assert!(run(folder.path()).status.success());
    assert!(timeless(results(folder.path())) == timeless(whole));
}

/// Runs with standard output or standard error closed by the reader at once.
fn with_closed(folder: &Path, arguments: &[&str], out: bool, err: bool) -> Option<i32> {
    let kind = |closed: bool| if closed { Stdio::piped() } else { Stdio::null() };
    let mut child = lucarne(folder, arguments).stdout(kind(out)).stderr(kind(err)).spawn().unwrap();
    drop((child.stdout.take(), child.stderr.take()));
    child.wait().unwrap().code()
}

#[test]
fn closed_outputs_end_quietly_and_lose_nothing() {
    let folder = project();
    assert_eq!(with_closed(folder.path(), &["plan", "project.toml"], true, false), Some(0));
    assert_eq!(with_closed(folder.path(), &["plan", "project.toml"], false, true), Some(0));
    assert_eq!(with_closed(folder.path(), &["sky", "day.wea"], true, true), Some(0));
    assert_eq!(with_closed(folder.path(), &["scene", "info", "room.rad"], true, true), Some(0));
    // Long output of which only the first line is read.
    let mut child = lucarne(folder.path(), &["sky", "day.wea", "-m", "2"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = [0; 10];
    child.stdout.take().unwrap().read_exact(&mut first).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output)), (Some(0), String::new()));
    // A disk that is full.
    if let Ok(full) = fs::File::options().write(true).open("/dev/full") {
        let output = lucarne(folder.path(), &["plan", "project.toml"]).stdout(full).output().unwrap();
        assert_eq!((output.status.code(), errors(&output)), (Some(5), 1), "{}", text(&output));
    }
    if testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        assert_eq!(with_closed(folder.path(), &["run", "project.toml", "-o", "out"], true, true), Some(0));
        assert!(folder.path().join("out/summary.json").exists());
        #[cfg(unix)]
        {
            let script = format!("exec {} run project.toml -o out >&- 2>&- <&-", env!("CARGO_BIN_EXE_lucarne"));
            let status = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).status().unwrap();
            assert_eq!(status.code(), Some(0));
        }
    }
}

#[cfg(unix)]
#[test]
fn odd_paths_line_ends_and_locales_change_nothing() {
    use std::os::unix::ffi::OsStrExt;
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let plain = run(folder.path());
    assert!(plain.status.success(), "{}", text(&plain));
    let tables = |out: &Path| {
        ["illuminance/room.csv", "illuminance/room_annual.csv", "glare/eye.csv", "glare/annual.csv"].map(|f| fs::read(out.join(f)).unwrap())
    };
    let whole = tables(&folder.path().join("out"));
    let copy = |to: &Path, windows: bool| {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_file()) {
            let mut bytes = fs::read(&entry).unwrap();
            if windows {
                bytes = bytes.iter().flat_map(|b| if *b == b'\n' { b"\r\n".to_vec() } else { vec![*b] }).collect();
            }
            fs::write(to.join(entry.file_name().unwrap()), bytes).unwrap();
        }
    };
    let odd: [(&[u8], bool); 4] =
        [(b"with blanks and 'quotes'", false), (b"latin \xfc 1", false), ("größe ☀".as_bytes(), true), (b"-dash", false)];
    for (name, windows) in odd {
        let there = folder.path().join(std::ffi::OsStr::from_bytes(name));
        copy(&there, windows);
        let out = there.join(std::ffi::OsStr::from_bytes(&[name, b" out"].concat()));
        let mut command = Command::new(env!("CARGO_BIN_EXE_lucarne"));
        command.arg("run").arg(there.join("project.toml")).arg("-o").arg(&out).stdin(Stdio::null());
        // Decimal commas are for people, not for files.
        command.env("LC_ALL", "de_DE.UTF-8").env("LANG", "de_DE.UTF-8").env("LC_NUMERIC", "de_DE.UTF-8");
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}: {}", out.display(), text(&output));
        assert!(tables(&out) == whole, "{}", out.display());
        let opened = lucarne::simulate::Results::open(&out).unwrap();
        assert_eq!(opened.year.times.len(), 24);
        assert!(opened.surroundings.is_some(), "{:?}", opened.year.notes);
        // Results elsewhere name the project by its path, as far as that is text.
        let elsewhere = folder.path().join("elsewhere");
        let output = Command::new(env!("CARGO_BIN_EXE_lucarne"))
            .arg("run")
            .arg(there.join("project.toml"))
            .arg("-o")
            .arg(&elsewhere)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}: {}", out.display(), text(&output));
        assert!(tables(&elsewhere) == whole);
        let opened = lucarne::simulate::Results::open(&elsewhere).unwrap();
        assert!(opened.surroundings.is_some() != (std::str::from_utf8(name).is_err()), "{:?}", opened.year.notes);
        fs::remove_dir_all(elsewhere).unwrap();
    }
}

//! Many runs in one process, and one long batch: memory and threads stay as they are.

use lucarne::Warnings;
use lucarne::progress::Silent;
use lucarne::simulate::{Plan, Project};
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

mod small_project;
#[path = "../src/testing.rs"]
mod testing;

use small_project::{lucarne, project};

/// A number of `/proc/PROCESS/status`; nothing where the system does not tell.
fn status(process: &str, key: &str) -> Option<u64> {
    let text = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    text.lines().find_map(|l| l.strip_prefix(key))?.trim_start_matches(':').split_whitespace().next()?.parse().ok()
}

fn is_long() -> bool {
    std::env::var_os("LUCARNE_SOAK").is_some()
}

/// Three phases, few bins, sensors and hours.
fn small(folder: &Path, seed: usize) -> String {
    let wea = fs::read_to_string(folder.join("day.wea")).unwrap();
    let kept: Vec<&str> =
        wea.lines().filter(|l| !l.starts_with("3 21") || ["3 21 11.500", "3 21 12.500"].iter().any(|h| l.starts_with(h))).collect();
    fs::write(folder.join("hours.wea"), kept.join("\n") + "\n").unwrap();
    format!(
        "[weather]\nfile = \"hours.wea\"\n[scene]\nfiles = [\"room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"window.rad\"\nbsdf = \"louvre.xml\"\n\
         [[sensors]]\nname = \"room\"\npoints = \"points.txt\"\n[method]\nphases = 3\nsky_subdivision = 1\n[quality]\npreset = \"draft\"\nseed = {seed}\n"
    )
}

#[test]
fn many_projects_in_one_process_leave_memory_and_threads_as_they_were() {
    let Some(device) = testing::device(lucarne::gpu::Device::open(None), "soak") else { return };
    let folder = project();
    let count = if is_long() { 500 } else { 24 };
    let file = folder.path().join("project.toml");
    // Allocators and drivers reach their level in the first ones.
    let settled = count / 3;
    let (mut before, mut after) = (Vec::new(), Vec::new());
    for number in 0..count {
        fs::write(&file, small(folder.path(), number)).unwrap();
        let mut warnings = Warnings::new();
        let plan = Plan::new(Project::read(&file).unwrap(), &mut warnings).unwrap();
        let year = plan.compute(&device, &Silent, &mut warnings).unwrap();
        assert_eq!(year.times.len(), 2);
        assert!(year.sensors[0].illuminance.at(0, 0)[0] > 0.0);
        drop(year);
        let Some(memory) = status("self", "VmRSS").zip(status("self", "Threads")) else { return };
        if number >= settled { after.push(memory) } else { before.push(memory) }
    }
    let most = |all: &[(u64, u64)]| (all.iter().map(|m| m.0).max().unwrap(), all.iter().map(|m| m.1).max().unwrap());
    let ((first, threads), (last, later)) = (most(&before), most(&after));
    let growth = last.saturating_sub(first);
    println!("{count} projects: {first} KiB and {threads} threads in the first third, {last} KiB and {later} threads later");
    assert!(growth < 16 << 10, "{growth} KiB more");
    assert!(later <= threads, "{later} threads after {threads}");
    if is_long() {
        let found = format!(
            "{count} projects: {} MiB in the first third, {:+.1} MiB later, {later} threads throughout",
            first >> 10,
            growth as f64 / 1024.0
        );
        testing::measured("soak", &found, "16 MiB");
    }
}

/// Projects of so many rooms, each with views and states of its façade.
fn batch(folder: &Path, rooms: usize, views: usize, states: usize) -> Vec<String> {
    let xml = fs::read_to_string(folder.join("louvre.xml")).unwrap();
    let names: Vec<String> = (0..states).map(|s| format!("state{s}.xml")).collect();
    names.iter().enumerate().for_each(|(s, name)| fs::write(folder.join(name), xml.replace("asymmetric", &format!("state {s}"))).unwrap());
    let listed = names.iter().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(", ");
    (0..rooms)
        .map(|room| {
            let mut text = format!(
                "[weather]\nfile = \"day.wea\"\n[scene]\nfiles = [\"room.rad\"]\n[[window]]\nname = \"south\"\nsurface = \"window.rad\"\nstates = [{listed}]\n\
                 [glare]\nmethod = \"image\"\n[method]\nphases = 3\nsky_subdivision = 1\n[quality]\npreset = \"draft\"\nseed = {room}\n"
            );
            for view in 0..views {
                let angle = std::f64::consts::TAU * view as f64 / views as f64;
                let file = format!("view{view}.vf");
                fs::write(folder.join(&file), format!("rvu -vta -vp 1.2 1.6 1.2 -vd {:.4} {:.4} 0 -vu 0 0 1 -vh 180 -vv 180\n", angle.sin(), -angle.cos())).unwrap();
                text.push_str(&format!("[[view]]\nname = \"view{view}\"\nfile = \"{file}\"\nresolution = [40, 40]\n"));
            }
            let name = format!("room{room}.toml");
            fs::write(folder.join(&name), text).unwrap();
            name
        })
        .collect()
}

#[test]
fn a_batch_of_rooms_views_and_states_stays_within_its_memory() {
    if !testing::has_device(env!("CARGO_BIN_EXE_lucarne")) {
        return;
    }
    let folder = project();
    let (rooms, views, states) = if is_long() { (10, 24, 5) } else { (2, 3, 2) };
    let names = batch(folder.path(), rooms, views, states);
    let mut arguments = vec!["run", "--memory", "2G", "--progress", "none", "-o", "out"];
    arguments.extend(names.iter().map(String::as_str));
    let mut child = lucarne(folder.path(), &arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let (process, mut peak) = (child.id().to_string(), 0);
    while child.try_wait().unwrap().is_none() {
        peak = peak.max(status(&process, "VmHWM").unwrap_or(0));
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", small_project::text(&output));
    for room in 0..rooms {
        let table = fs::read_to_string(folder.path().join(format!("out/room{room}/glare/annual.csv"))).unwrap();
        assert_eq!(table.lines().count(), 1 + views * states, "{table}");
    }
    println!("{views} views x {states} states x {rooms} rooms: {} MiB", peak >> 10);
    assert!(peak <= 2 << 20, "{peak} KiB");
    if is_long() && peak > 0 {
        testing::measured("batch", &format!("{views} views × {states} states × {rooms} rooms: {} MiB at most", peak >> 10), "2 GiB");
    }
}

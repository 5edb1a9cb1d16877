//! Readers of all formats on files that are damaged or hostile: no panic, no hang, no more memory than 1 GiB.
//!
//! All readers share ten seconds here, each has a minute by `make fuzz`; `LUCARNE_FUZZ_SECONDS`, `LUCARNE_FUZZ_SEED` and
//! `LUCARNE_FUZZ=READER,READER` say otherwise. An input that ends in a fault is kept in `target/fuzz`; made small, it
//! becomes a test beside the reader.

mod driver;
mod mutate;
mod targets;
#[path = "../../src/testing.rs"]
mod testing;

use driver::{MOST_MEMORY, fuzz, peak_memory};
use std::path::Path;
use std::time::Duration;

/// Seconds of all readers together, unless more are asked for.
const TOGETHER: f64 = 10.0;

fn setting(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|v| !v.is_empty())
}

#[test]
fn no_reader_fails_on_damaged_files() {
    let seconds: Option<f64> = setting("LUCARNE_FUZZ_SECONDS").map(|s| s.parse().expect("a number of seconds"));
    let seed: u64 = setting("LUCARNE_FUZZ_SEED").map_or(1, |s| s.parse().expect("a whole number"));
    let only = setting("LUCARNE_FUZZ");
    let time = Duration::from_secs_f64(seconds.unwrap_or(TOGETHER / targets::all().len() as f64));
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/fuzz");
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // Those of readers are counted, and told at the end.
        if !driver::is_reading() {
            usual(panic);
        }
    }));
    let (mut executions, mut readers, mut faults) = (0, 0, Vec::new());
    println!("seed {seed}, {} s for each reader", time.as_secs_f64());
    for target in targets::all() {
        if only.as_ref().is_some_and(|only| !only.split(',').any(|name| name == target.name)) {
            continue;
        }
        let found = fuzz(&target, seed, time, &kept);
        println!(
            "{:14} {:9} executions, {:3} answers, slowest {:6.1} ms, memory {} MiB, {} faults",
            target.name,
            found.executions,
            found.answers,
            found.slowest.as_secs_f64() * 1e3,
            peak_memory() >> 20,
            found.faults.len()
        );
        readers += 1;
        executions += found.executions;
        faults.extend(found.faults);
    }
    let _ = std::panic::take_hook();
    let peak = peak_memory();
    println!("{executions} executions, {readers} readers, memory {} MiB", peak >> 20);
    assert!(faults.is_empty(), "{}", faults.iter().map(|(path, message)| format!("{}: {message}\n", path.display())).collect::<String>());
    assert!(peak <= MOST_MEMORY, "{} MiB", peak >> 20);
    if seconds.is_some_and(|s| s >= 60.0) && only.is_none() {
        let millions = executions as f64 / 1e6;
        testing::measured(
            "fuzzing",
            &format!("{millions:.1} million files in {readers} readers: no panic, no hang, at most {} MiB", peak >> 20),
            "0 faults, 10 s, 1 GiB",
        );
    }
}

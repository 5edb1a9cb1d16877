//! What unit tests share: where the optional reference data and Radiance's programs are.
//!
//! Tests that need either call these and return when they are absent; the reason is then on
//! standard error, so that a skipped test is never silent.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// The folder of reference data: `LUCARNE_SHARED`, else `../shared` beside the repository.
#[allow(dead_code, reason = "used as soon as a test needs reference data")]
pub fn shared() -> Option<PathBuf> {
    let folder =
        std::env::var_os("LUCARNE_SHARED").map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared")), PathBuf::from);
    if folder.join("data").is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED a test: no reference data at {}", folder.display());
    None
}

/// Radiance's programs and library as installed by the Python package `pyradiance`.
pub fn radiance(program: &str) -> Option<Command> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let find = "import pyradiance,os;print(os.path.dirname(pyradiance.__file__),end='')";
        let out = Command::new("python3").args(["-c", find]).stderr(Stdio::null()).output().ok()?;
        let folder = PathBuf::from(String::from_utf8(out.stdout).ok()?);
        folder.join("bin").is_dir().then_some(folder)
    });
    let Some(folder) = folder else {
        eprintln!("SKIPPED a test: Radiance (pyradiance) is not installed, {program} is needed");
        return None;
    };
    let mut command = Command::new(folder.join("bin").join(program));
    command.env("RAYPATH", format!(".:{}", folder.join("lib").display()));
    let path = std::env::var("PATH").unwrap_or_default();
    command.env("PATH", format!("{}:{path}", folder.join("bin").display()));
    Some(command)
}

/// Runs a program to its end and gives its standard output.
///
/// # Panics
/// If it cannot be started or fails.
pub fn output(command: &mut Command) -> Vec<u8> {
    let out = command.output().expect("the program starts");
    assert!(out.status.success(), "{command:?}: {}", String::from_utf8_lossy(&out.stderr));
    out.stdout
}

/// Standard output of a Python script that uses `pywincalc` (the engine of WINDOW).
///
/// # Panics
/// If pywincalc is installed and the script fails.
#[allow(dead_code, reason = "not every test that includes this file needs it")]
pub fn pywincalc(script: &str) -> Option<Vec<u8>> {
    let installed =
        Command::new("python3").args(["-c", "import pywincalc, numpy"]).stderr(Stdio::null()).status().is_ok_and(|s| s.success());
    if !installed {
        eprintln!("SKIPPED a test: pywincalc is not installed");
        return None;
    }
    Some(output(Command::new("python3").args(["-c", script])))
}

//! Commands of a shell, their CPU time, and where Radiance's programs are.

use std::path::Path;
use std::process::Command;

/// Runs a shell command and gives its user CPU seconds, or what it said on failure.
pub fn timed(folder: &Path, command: &str) -> Result<f64, String> {
    let script = format!("{command} || exit 1\ntimes");
    let out = Command::new("sh").arg("-c").arg(&script).current_dir(folder).output().map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&out.stdout);
    let failed = || format!("{command}\n{}", String::from_utf8_lossy(&out.stderr));
    if !out.status.success() {
        return Err(failed());
    }
    // Its last line, "0m1.23s 0m0.04s": user and system time of the children. (Not through a pipe, whose
    // process has none.)
    let user = text.lines().last().and_then(|l| l.split_whitespace().next()).ok_or_else(failed)?;
    let (minutes, seconds) = user.trim_end_matches('s').split_once('m').ok_or_else(failed)?;
    Ok(minutes.parse::<f64>().map_err(|_| failed())? * 60.0 + seconds.parse::<f64>().map_err(|_| failed())?)
}

/// Environment in which Radiance's programs are found, if the Python package `pyradiance` is installed.
pub fn radiance_path() -> Option<String> {
    let find = "import pyradiance,os;print(os.path.dirname(pyradiance.__file__),end='')";
    let out = Command::new("python3").args(["-c", find]).output().ok()?;
    let folder = String::from_utf8(out.stdout).ok()?;
    Path::new(&folder).join("bin").is_dir().then(|| format!("PATH={folder}/bin:$PATH RAYPATH=.:{folder}/lib"))
}

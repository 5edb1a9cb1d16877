//! What tests share: whether a device, Radiance and the reference data are there, and the record of what
//! was not run for want of them.
//!
//! The unit tests have this file as a module, integration tests include it by its path. A test that
//! lacks something calls [`skip`] (or a function here that does) and returns. Every skip is a line in
//! `target/skipped.txt`, which `make test` counts and shows at its end: libtest swallows what passing
//! tests print. `LUCARNE_REQUIRE=gpu,swiftshader,validation,radiance,shared,pywincalc,honeybee` (or some of them) makes it a failure.
#![allow(dead_code, unused_imports, reason = "not every test that includes this file needs all of it")]

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// What a test may need that a machine may lack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// A device that kernels run on.
    Gpu,
    /// A second Vulkan driver, SwiftShader, of Debian's package `chromium-common`.
    Swiftshader,
    /// Khronos' validation layer for Vulkan, Debian's package `vulkan-validationlayers`.
    Validation,
    /// Radiance's programs, Python package `pyradiance`.
    Radiance,
    /// The folder of reference data.
    Shared,
    /// WINDOW's engine, Python package `pywincalc`.
    Pywincalc,
    /// Metrics of other hands, Python package `honeybee-radiance-postprocess`.
    Honeybee,
}

impl Need {
    /// Its word in `LUCARNE_REQUIRE`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Gpu => "gpu",
            Self::Swiftshader => "swiftshader",
            Self::Validation => "validation",
            Self::Radiance => "radiance",
            Self::Shared => "shared",
            Self::Pywincalc => "pywincalc",
            Self::Honeybee => "honeybee",
        }
    }

    /// Whether a list as `LUCARNE_REQUIRE` has it names it.
    pub fn is_in(self, list: &str) -> bool {
        list.split([',', ' ']).any(|word| word == self.word())
    }
}

/// Notes that the running test is not run.
///
/// # Panics
/// If `LUCARNE_REQUIRE` says that what it needs must be there.
pub fn skip(need: Need, why: &dyn Display) {
    let required = std::env::var("LUCARNE_REQUIRE").unwrap_or_default();
    assert!(!need.is_in(&required), "LUCARNE_REQUIRE names {}, but {why}", need.word());
    note(&format_args!("needs {}: {why}", need.word()));
}

/// Notes that a part of the running test was not run, for a reason that nothing can be required for.
pub fn note(why: &dyn Display) {
    let line = format!("{}: {why}\n", std::thread::current().name().unwrap_or("a test"));
    eprint!("SKIPPED {line}");
    let path = skipped_list();
    let written = std::fs::OpenOptions::new().append(true).create(true).open(&path).and_then(|mut f| f.write_all(line.as_bytes()));
    written.unwrap_or_else(|e| panic!("{}: {e}: a skipped test must be counted", path.display()));
}

/// Where skips are listed.
pub fn skipped_list() -> PathBuf {
    target().join("skipped.txt")
}

/// The folder of what is built, of the whole workspace.
fn target() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = if own.ends_with("viewer") { own.parent().unwrap_or(own) } else { own };
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let _ = std::fs::create_dir_all(&target);
    target
}

/// Notes what a test or benchmark found, and the bound beyond which the test fails (empty if there is none),
/// as VALIDATION.md shall show them in place of `{{key}}` and `{{key.held}}` of its template. `make validation` puts
/// them there. Call it where all is asserted: a failed test has nothing to show.
///
/// # Panics
/// If a text would break the table it stands in, or cannot be stored.
pub fn measured(key: &str, found: &str, held: &str) {
    let text = format!("{found}\n{held}\n");
    assert!(!text.contains('|') && text.lines().count() == 2, "{key}: no single cell of a table: {text}");
    assert!(key.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'), "{key}: small letters, digits, dashes");
    let folder = target().join("validation");
    // Whole or not at all: tests run side by side, in several processes and threads.
    static WRITTEN: AtomicU32 = AtomicU32::new(0);
    let own = folder.join(format!("{key}.{}-{}", std::process::id(), WRITTEN.fetch_add(1, Ordering::Relaxed)));
    let written =
        std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&own, text)).and_then(|()| std::fs::rename(&own, folder.join(key)));
    written.unwrap_or_else(|e| panic!("{}: {e}: what was measured must be kept", own.display()));
}

/// What [`measured`] noted of a key since the folder was last emptied: found, held.
pub fn measurement(key: &str) -> Option<[String; 2]> {
    let text = std::fs::read_to_string(target().join("validation").join(key)).ok()?;
    let (found, held) = text.split_once('\n')?;
    Some([found.to_string(), held.trim_end().to_string()])
}

/// A number to two digits, as a document shows it: 0.69, 1.2e-7, 1e-5.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let before = if size == 0.0 { 0 } else { size.log10().floor() as i32 };
    let text = format!("{value:.*}", usize::try_from(1 - before).unwrap_or(0));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// A share in percent, to two digits: 0.0069 is "0.69 %".
pub fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// The least and the largest of some shares in percent: "0.1…0.7 %".
pub fn percents(shares: &[f64]) -> String {
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let most = shares.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{}…{}", short(100.0 * least), percent(most))
}

/// The device that was found, or a skip of `what`.
pub fn device<D, E: Display>(found: Result<D, E>, what: &str) -> Option<D> {
    found.map_err(|error| skip(Need::Gpu, &format_args!("{what}: {error}"))).ok()
}

/// Whether the program finds a device to run on, or a skip.
pub fn has_device(program: &str) -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    let found = *FOUND.get_or_init(|| Command::new(program).arg("devices").output().is_ok_and(|out| out.status.success()));
    if !found {
        skip(Need::Gpu, &"no device was found");
    }
    found
}

/// What the Vulkan loader's `VK_DRIVER_FILES` must name for SwiftShader, or a skip: the file that the package installs,
/// or that `.ci/install-missing swiftshader` unpacked.
pub fn swiftshader() -> Option<PathBuf> {
    let file = "usr/lib/chromium/vk_swiftshader_icd.json";
    let found = [PathBuf::from("/").join(file), target().join("swiftshader").join(file)].into_iter().find(|f| f.is_file());
    if found.is_none() {
        skip(Need::Swiftshader, &"SwiftShader is not there: .ci/install-missing swiftshader");
    }
    found
}

/// Whether the Vulkan loader finds Khronos' validation layer, or a skip.
pub fn validation_layer() -> bool {
    let file = "vulkan/explicit_layer.d/VkLayer_khronos_validation.json";
    let found = ["/usr/share", "/usr/local/share", "/etc"].iter().any(|folder| Path::new(folder).join(file).is_file());
    if !found {
        skip(Need::Validation, &"Khronos' validation layer is not there: .ci/install-missing validation");
    }
    found
}

fn shared_folder() -> PathBuf {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    std::env::var_os("LUCARNE_SHARED").map_or_else(|| PathBuf::from(beside), PathBuf::from)
}

/// The folder of reference data: `LUCARNE_SHARED`, else `../shared` beside the repository.
pub fn shared() -> Option<PathBuf> {
    let folder = shared_folder();
    if folder.join("data").is_dir() {
        return Some(folder);
    }
    skip(Need::Shared, &format_args!("no reference data at {}", folder.display()));
    None
}

/// The public tutorial room and Radiance's results for it: the whole of the reference data, else the part in
/// `tests/data`, where a year is every eleventh hour.
pub fn tutorial() -> PathBuf {
    let whole = shared_folder().join("data");
    let folder = if whole.is_dir() { whole } else { Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data") };
    folder.canonicalize().unwrap_or(folder)
}

/// New York's weather, the tutorial's.
pub fn new_york() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office/weather/new_york.wea")
}

/// The folder of the Python package `pyradiance`, with `bin` and `lib`, or a skip.
pub fn radiance_folder() -> Option<&'static Path> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let find = "import pyradiance,os;print(os.path.dirname(pyradiance.__file__),end='')";
        let out = Command::new("python3").args(["-c", find]).stderr(Stdio::null()).output().ok()?;
        let folder = PathBuf::from(String::from_utf8(out.stdout).ok()?);
        folder.join("bin").is_dir().then_some(folder)
    });
    if folder.is_none() {
        skip(Need::Radiance, &"Radiance (pyradiance) is not installed");
    }
    folder.as_deref()
}

/// One of Radiance's programs, or a skip.
pub fn radiance(program: &str) -> Option<Command> {
    let folder = radiance_folder()?;
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

/// Irradiance that Radiance's `rtrace` finds at the points (lines of x y z dx dy dz) of a scene under a sky of radiance 1
/// on all sides, by up to eight diffuse reflections, or a skip. Its own noise is below 1 % behind a window.
///
/// # Panics
/// If the scene cannot be written or a program fails.
pub fn rtrace_under_even_sky(folder: &Path, scene: &str, points: &str) -> Option<Vec<f64>> {
    let (mut oconv, mut rtrace) = (radiance("oconv")?, radiance("rtrace")?);
    let [scene_file, octree, points_file] = ["even.rad", "even.oct", "even.txt"].map(|name| folder.join(name));
    let sky = "void glow even_sky 0 0 4 1 1 1 0\neven_sky source all_around 0 0 4 0 0 1 360\n";
    std::fs::write(&scene_file, format!("{scene}\n{sky}")).expect("the folder can be written to");
    std::fs::write(&points_file, points).expect("the folder can be written to");
    std::fs::write(&octree, output(oconv.arg(&scene_file))).expect("the folder can be written to");
    let options = "-h -I -ab 8 -ad 20000 -as 0 -aa 0 -lw 1e-6 -u+";
    let input = std::fs::File::open(&points_file).expect("the points were written");
    let text = String::from_utf8(output(rtrace.args(options.split(' ')).arg(&octree).stdin(input))).expect("numbers");
    Some(text.lines().map(|l| l.split_whitespace().nth(1).expect("three channels").parse().expect("a number")).collect())
}

/// Whether `pywincalc` (the engine of WINDOW) is there, or a skip.
pub fn has_pywincalc() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    let found = *FOUND.get_or_init(|| {
        Command::new("python3").args(["-c", "import pywincalc, numpy"]).stderr(Stdio::null()).status().is_ok_and(|s| s.success())
    });
    if !found {
        skip(Need::Pywincalc, &"pywincalc or numpy is not installed");
    }
    found
}

/// Standard output of a Python script that uses `pywincalc`, or a skip.
///
/// # Panics
/// If pywincalc is installed and the script fails.
pub fn pywincalc(script: &str) -> Option<Vec<u8>> {
    has_pywincalc().then(|| output(Command::new("python3").args(["-c", script])))
}

/// Standard output of a Python script that uses `honeybee-radiance-postprocess`, or a skip.
///
/// # Panics
/// If the package is installed and the script fails.
pub fn honeybee_postprocess(script: &str, arguments: &[&str]) -> Option<Vec<u8>> {
    let find = ["-c", "import importlib.util as u; exit(u.find_spec('honeybee_radiance_postprocess') is None)"];
    let found = Command::new("python3").args(find).stderr(Stdio::null()).status().is_ok_and(|s| s.success());
    if !found {
        skip(Need::Honeybee, &"honeybee-radiance-postprocess is not installed");
    }
    found.then(|| output(Command::new("python3").args(["-c", script]).args(arguments)))
}

#[cfg(test)]
mod tests {
    use super::{Need, percent, short};

    #[test]
    fn numbers_of_documents_have_two_digits() {
        let pairs = [
            (0.0069, "0.0069"),
            (0.5, "0.5"),
            (1.25e-7, "1.2e-7"),
            (1e-5, "1e-5"),
            (4496.0, "4496"),
            (0.0, "0"),
            (-1.53, "-1.5"),
            (2.0, "2"),
        ];
        for (value, text) in pairs {
            assert_eq!(short(value), text);
        }
        assert_eq!((percent(0.005), percent(0.01499)), ("0.5 %".to_string(), "1.5 %".to_string()));
    }

    #[test]
    fn what_must_be_there_is_told_by_its_word() {
        assert!(Need::Gpu.is_in("gpu") && Need::Shared.is_in("gpu,radiance,shared") && Need::Radiance.is_in("gpu, radiance"));
        assert!(!Need::Gpu.is_in("") && !Need::Gpu.is_in("gpus,radiance"));
    }
}

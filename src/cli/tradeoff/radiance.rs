//! Radiance's `rfluxmtx` on the same room, where it is installed.
//!
//! Programs are found on PATH by fixed names and get arguments made here, never any text of an input
//! file: the room is written anew, as plain polygons, so that no command in a scene file is run.

use lucarne::kernels::product::Native;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::{Progress, cancelled};
use lucarne::scene::{MaterialKind, Scene, Window};
use lucarne::simulate::Inputs;
use lucarne::simulate::tradeoff::{Measured, Point, Reference, illuminance};
use lucarne::{Error, Result};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Radiance's programs.
pub struct Programs {
    rfluxmtx: PathBuf,
}

/// Ambient divisions of V and rays per bin of D, from coarse to fine.
const SETTINGS: [(u32, u32); 3] = [(1000, 25), (5000, 100), (20_000, 250)];

impl Programs {
    /// What is on PATH.
    pub fn find() -> Option<Self> {
        let name = format!("rfluxmtx{}", std::env::consts::EXE_SUFFIX);
        let found = std::env::split_paths(&std::env::var_os("PATH")?).map(|folder| folder.join(&name)).find(|p| p.is_file())?;
        Some(Self { rfluxmtx: found })
    }

    /// Times and errors of V and D by `rfluxmtx`, with the sky of our finest settings, in our product.
    ///
    /// # Errors
    /// Failures of the programs and of the file system, or when stopped.
    pub fn measure(&self, inputs: &Inputs, folder: &Path, reference: &Reference<'_>, progress: &dyn Progress) -> Result<Vec<Point>> {
        let project = reference.project;
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, &e))?;
        let save = |name: &str, text: &str| std::fs::write(folder.join(name), text).map_err(|e| Error::io(folder.join(name), &e));
        let Some(room) = scene_text(&inputs.scene) else {
            return Ok(Vec::new());
        };
        save("room.rad", &room)?;
        save("sky.rad", &sky_text(inputs.sky(project).subdivision()))?;
        let sensors = inputs.sensors.iter().flat_map(|g| &g.sensors);
        let mut points = String::new();
        for s in sensors {
            let (p, d) = (s.position, s.direction);
            let _ = writeln!(points, "{} {} {} {} {} {}", p.x, p.y, p.z, d.x, d.y, d.z);
        }
        save("points.txt", &points)?;
        for (i, window) in inputs.windows.iter().enumerate() {
            let Some(text) = window_text(&window.window) else { return Ok(Vec::new()) };
            save(&format!("window{i}.rad"), &text)?;
        }
        // Unlimited reflections are what -ab 8 nearly is.
        let bounces = project.method.bounces.unwrap_or(8).to_string();
        let processes = std::thread::available_parallelism().map_or(1, usize::from).to_string();
        let mut found = Vec::new();
        for (number, (ad, c)) in SETTINGS.into_iter().enumerate() {
            let (ad_text, lw, c_text) = (ad.to_string(), format!("{:e}", 1.0 / f64::from(ad)), c.to_string());
            let clock = Instant::now();
            for i in 0..inputs.windows.len() {
                let stage = format!("Radiance, -ad {ad}, -c {c}");
                progress.update(&stage, (number * inputs.windows.len() + i) as f64 / (SETTINGS.len() * inputs.windows.len()) as f64);
                let (window, v, d) = (format!("window{i}.rad"), format!("v{i}.mtx"), format!("d{i}.mtx"));
                let view = [
                    "-I+",
                    "-ab",
                    &bounces,
                    "-ad",
                    &ad_text,
                    "-lw",
                    &lw,
                    "-n",
                    &processes,
                    "-y",
                    &points.lines().count().to_string(),
                    "-",
                    &window,
                    "room.rad",
                ]
                .map(String::from);
                self.call(folder, &view, Some("points.txt"), &v, progress)?;
                let daylight = ["-ab", &bounces, "-c", &c_text, "-n", &processes, &window, "sky.rad", "room.rad"].map(String::from);
                self.call(folder, &daylight, None, &d, progress)?;
            }
            let seconds = clock.elapsed().as_secs_f64();
            let read = |name: String| Ok::<Matrix<f32>, Error>(read_matrix(&folder.join(name))?.matrix);
            let matrices = (0..inputs.windows.len())
                .map(|i| Ok((read(format!("v{i}.mtx"))?, read(format!("d{i}.mtx"))?)))
                .collect::<Result<Vec<_>>>()?;
            let lux = illuminance(project, inputs, &matrices, &Native)?;
            let (hourly, annual) = reference.distance(&lux);
            found.push(Point {
                program: "Radiance".into(),
                knob: "-ad -c".into(),
                value: format!("{ad} {c}"),
                illuminance: Some(Measured { seconds, hourly, annual }),
                glare: None,
            });
        }
        std::fs::remove_dir_all(folder).map_err(|e| Error::io(folder, &e))?;
        Ok(found)
    }

    /// Runs `rfluxmtx` in the folder, so that no path needs quoting, until it ends or is stopped.
    fn call(&self, folder: &Path, arguments: &[String], input: Option<&str>, output: &str, progress: &dyn Progress) -> Result<()> {
        let fault = |e: std::io::Error| Error::io(&self.rfluxmtx, &e);
        let file = |name: &str| std::fs::File::open(folder.join(name)).map_err(|e| Error::io(folder.join(name), &e));
        let out = std::fs::File::create(folder.join(output)).map_err(|e| Error::io(folder.join(output), &e))?;
        let errors = std::fs::File::create(folder.join("errors.txt")).map_err(|e| Error::io(folder, &e))?;
        let stdin = match input {
            Some(name) => Stdio::from(file(name)?),
            None => Stdio::null(),
        };
        let mut child = Command::new(&self.rfluxmtx)
            .args(arguments)
            .current_dir(folder)
            .stdin(stdin)
            .stdout(out)
            .stderr(errors)
            .spawn()
            .map_err(fault)?;
        loop {
            if let Some(status) = child.try_wait().map_err(fault)? {
                if status.success() {
                    return Ok(());
                }
                let said = std::fs::read_to_string(folder.join("errors.txt")).unwrap_or_default();
                let last = said.lines().rev().find(|l| !l.trim().is_empty()).unwrap_or("it failed without a word").to_string();
                return Err(Error::new(last).file(&self.rfluxmtx).help("--no-radiance leaves Radiance out"));
            }
            if progress.stop_requested() {
                let _ = child.kill();
                let _ = child.wait();
                return Err(cancelled());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// The room as polygons of plain materials; nothing if a material has no counterpart.
fn scene_text(scene: &Scene) -> Option<String> {
    let mut text = String::new();
    for (i, material) in scene.materials.iter().enumerate() {
        let rgb = |c: [f64; 3]| format!("{} {} {}", c[0], c[1], c[2]);
        let line = match material.kind {
            MaterialKind::Plastic { color, specularity, roughness } => {
                format!("plastic m{i} 0 0 5 {} {specularity} {roughness}", rgb(color))
            }
            MaterialKind::Metal { color, specularity, roughness } => format!("metal m{i} 0 0 5 {} {specularity} {roughness}", rgb(color)),
            MaterialKind::Trans { color, specularity, roughness, transmissivity, transmitted_specularity } => {
                format!("trans m{i} 0 0 7 {} {specularity} {roughness} {transmissivity} {transmitted_specularity}", rgb(color))
            }
            MaterialKind::Glass { transmissivity, refraction_index } => {
                format!("glass m{i} 0 0 4 {} {refraction_index}", rgb(transmissivity))
            }
            MaterialKind::Mirror { color } => format!("mirror m{i} 0 0 3 {}", rgb(color)),
            MaterialKind::Light { .. } | MaterialKind::Glow { .. } => format!("plastic m{i} 0 0 5 0 0 0 0 0"),
            MaterialKind::Lobes(_) => return None,
            MaterialKind::Void => continue,
        };
        let _ = writeln!(text, "void {line}");
    }
    for (i, t) in scene.triangles.iter().enumerate() {
        let material = t.material.0 as usize;
        if scene.materials[material].kind == MaterialKind::Void {
            continue;
        }
        let _ = write!(text, "m{material} polygon t{i} 0 0 9");
        for v in t.vertices {
            let _ = write!(text, " {} {} {}", v.x, v.y, v.z);
        }
        text.push('\n');
    }
    Some(text)
}

/// A window as receiver and sender; nothing if Radiance does not know its basis.
fn window_text(window: &Window) -> Option<String> {
    let basis = match window.basis.len() {
        145 => "kf",
        73 => "kh",
        41 => "kq",
        _ => return None,
    };
    let up = window.frame.y;
    let mut text = format!("void glow w 0 0 4 1 1 1 0\n#@rfluxmtx h={basis} u={},{},{}\n", up.x, up.y, up.z);
    for (i, corners) in window.triangles.iter().enumerate() {
        let [a, b, c] = *corners;
        // The order of the corners gives the normal.
        let front = (b - a).cross(c - a).dot(window.frame.z) > 0.0;
        let _ = write!(text, "w polygon w{i} 0 0 9");
        for v in if front { [a, b, c] } else { [a, c, b] } {
            let _ = write!(text, " {} {} {}", v.x, v.y, v.z);
        }
        text.push('\n');
    }
    Some(text)
}

/// Ground and sky as receivers.
fn sky_text(subdivision: usize) -> String {
    format!(
        "#@rfluxmtx h=u u=Y\nvoid glow g 0 0 4 1 1 1 0\ng source ground 0 0 4 0 0 -1 180\n\
         #@rfluxmtx h=r{subdivision} u=Y\nvoid glow s 0 0 4 1 1 1 0\ns source sky 0 0 4 0 0 1 180\n"
    )
}

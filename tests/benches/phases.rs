//! Error against CPU time of the view and daylight matrices, beside Radiance's `rfluxmtx`, in one
//! run on the same room and at the same bounce limit.
//!
//! The error is that of hourly illuminance: per sensor, the root mean square over all daylit hours
//! of the difference to a converged result, divided by the sensor's mean; then the median over the
//! sensors. Only the matrix under test is noisy, the other phases are converged. The time is user
//! CPU time of the whole process and its children.
//!
//! The converged matrices are Lucarne's own with many samples, of another seed; that Radiance's
//! error goes on falling towards them is the check that they are right.
//!
//! `cargo bench --bench phases [-- SCENE_FOLDER [light]]`: the folder of the room (default: the
//! tutorial room in ../shared if it is there, else the office of scenes/); `light` leaves out
//! Radiance's costly levels.

#[path = "record.rs"]
mod record;
#[path = "shell.rs"]
mod shell;

use lucarne::bsdf;
use lucarne::matrix::file::read_matrix;
use lucarne::{Warnings, matrix::Matrix};
use shell::{radiance_path, timed};
use std::path::{Path, PathBuf};

/// What one room needs.
struct Room {
    folder: PathBuf,
    scene: Vec<&'static str>,
    window: &'static str,
    points: &'static str,
    bsdf: &'static str,
    weather: &'static str,
}

fn room() -> Room {
    let given = std::env::args().skip(1).find(|a| Path::new(a).is_dir()).map(PathBuf::from);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tutorial = root.join("../shared/data/tutorial_room");
    let folder = given.unwrap_or(if tutorial.is_dir() { tutorial } else { root.join("scenes/office") });
    if folder.join("objects/GlazingVmtx.rad").is_file() {
        let scene = vec!["materials.rad", "room.rad"];
        Room { folder, scene, window: "objects/GlazingVmtx.rad", points: "points.txt", bsdf: "bsdf/clear.xml", weather: "weather/NYC.wea" }
    } else {
        let scene = vec!["materials.rad", "office.rad"];
        Room {
            folder,
            scene,
            window: "windows/vision.rad",
            points: "workplane.txt",
            bsdf: "bsdf/double_clear.xml",
            weather: "weather/new_york.wea",
        }
    }
}

/// One channel of a matrix as f64, `[row][col]`.
fn channel(m: &Matrix<f32>) -> Vec<f64> {
    m.data().chunks_exact(m.components()).map(|e| f64::from(e[0])).collect()
}

fn multiply(a: &[f64], b: &[f64], rows: usize, inner: usize, cols: usize) -> Vec<f64> {
    let mut c = vec![0.0; rows * cols];
    for r in 0..rows {
        for k in 0..inner {
            let f = a[r * inner + k];
            for j in 0..cols {
                c[r * cols + j] += f * b[k * cols + j];
            }
        }
    }
    c
}

/// Median over sensors of the hourly relative error, percent.
fn error(result: &[f64], reference: &[f64], hours: usize) -> f64 {
    let mut per_sensor: Vec<f64> = result
        .chunks_exact(hours)
        .zip(reference.chunks_exact(hours))
        .map(|(a, b)| {
            let squares: f64 = a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum();
            (squares / hours as f64).sqrt() / (b.iter().sum::<f64>() / hours as f64)
        })
        .collect();
    per_sensor.sort_by(f64::total_cmp);
    per_sensor[per_sensor.len() / 2] * 100.0
}

/// CPU time at which a curve reaches an error, between or beyond its points (error ∝ time^slope).
fn time_at(curve: &[(f64, f64)], error: f64) -> Option<f64> {
    let pair = curve.windows(2).find(|w| w[1].1 <= error).or_else(|| curve.windows(2).last())?;
    let [(t0, e0), (t1, e1)] = [pair[0], pair[1]];
    let slope = (e1.ln() - e0.ln()) / (t1.ln() - t0.ln());
    Some((t0.ln() + (error.ln() - e0.ln()) / slope).exp())
}

/// Levels as a table shows them: "0.54 s, 4.9 % · 0.67 s, 2.8 %".
fn levels(labels: &[String], curve: &[(f64, f64)]) -> String {
    let level = |(label, (seconds, error)): (&String, &(f64, f64))| format!("{label}{} s, {error:.1} %", record::short(*seconds));
    labels.iter().zip(curve).map(level).collect::<Vec<_>>().join(" · ")
}

struct Phase<'a> {
    name: &'a str,
    ours: Vec<(String, String)>,
    peer: Vec<(String, String)>,
    output: PathBuf,
}

fn main() -> Result<(), String> {
    let room = room();
    let is_tutorial = room.folder.ends_with("data/tutorial_room");
    let temporary = tempfile::tempdir().map_err(|e| e.to_string())?;
    let at = |name: &str| temporary.path().join(name).display().to_string();
    let lucarne = env!("CARGO_BIN_EXE_lucarne");
    let scene = room.scene.join(" ");
    let ours = format!("{lucarne} matrix");
    let common = format!("--window {} -ab 4 {scene}", room.window);
    println!("room {}; user CPU seconds, hourly error in percent", room.folder.display());

    // Converged phases.
    timed(&room.folder, &format!("{lucarne} sky {} -m 1 -o {}", room.weather, at("S.mtx")))?;
    let reference_v = format!(
        "{ours} view --points {} -c 4096 --near-samples 8192 --direct-samples 4096 --seed 99 {common} -o {}",
        room.points,
        at("V.mtx")
    );
    timed(&room.folder, &reference_v)?;
    timed(&room.folder, &format!("{ours} daylight -m 1 -c 65536 --seed 99 {common} -o {}", at("D.mtx")))?;
    let read = |path: &Path| read_matrix(path).map(|m| m.matrix).map_err(|e| e.to_string());
    let (v, d, s) = (read(Path::new(&at("V.mtx")))?, read(Path::new(&at("D.mtx")))?, read(Path::new(&at("S.mtx")))?);
    let t = bsdf::read(&room.folder.join(room.bsdf), &mut Warnings::new())
        .and_then(|b| bsdf::transmission_matrix(&b))
        .map_err(|e| e.to_string())?;
    let t: Vec<f64> = t.data().chunks_exact(t.components()).map(|e| e[0]).collect();
    let (bins, patches) = (v.cols(), d.cols());
    let sky: Vec<f64> = channel(&s);
    let daylit: Vec<usize> = (0..s.cols()).filter(|&h| (0..patches).any(|p| sky[p * s.cols() + h] > 0.0)).collect();
    let hours = daylit.len();
    let sky: Vec<f64> = (0..patches).flat_map(|p| daylit.iter().map(move |&h| (p, h))).map(|(p, h)| sky[p * s.cols() + h]).collect();
    let illuminance = |v: &[f64], d: &[f64]| {
        let at_window = multiply(d, &sky, bins, patches, hours);
        multiply(v, &multiply(&t, &at_window, bins, bins, hours), v.len() / bins, bins, hours)
    };
    let (v, d) = (channel(&v), channel(&d));
    // Radiance's programs take no comments among the points.
    let points = std::fs::read_to_string(room.folder.join(room.points)).map_err(|e| e.to_string())?;
    let points: Vec<&str> = points.lines().filter(|line| !line.trim_start().starts_with('#')).collect();
    std::fs::write(at("points.txt"), points.join("\n") + "\n").map_err(|e| e.to_string())?;
    let converged = illuminance(&v, &d);

    let environment = radiance_path();
    let light = std::env::args().any(|a| a == "light");
    if let Some(environment) = &environment {
        timed(&room.folder, &format!("{environment} oconv -f {scene} > {}", at("room.oct")))?;
    } else {
        println!("SKIPPED: Radiance (pyradiance) is not installed; only Lucarne's curves follow");
    }
    let sensors = v.len() / bins;
    let peer = |command: String| environment.as_ref().map(|e| format!("{e} {command}")).unwrap_or_default();
    let sky_file = at("sky.rad");
    let glow = "void glow groundglow 0 0 4 1 1 1 0\n\ngroundglow source ground 0 0 4 0 0 -1 180\n";
    let text = format!("#@rfluxmtx u=+Y h=u\n{glow}\n#@rfluxmtx u=+Y h=r1\n{}", glow.replace("ground", "sky").replace("0 0 -1", "0 0 1"));
    std::fs::write(&sky_file, text).map_err(|e| e.to_string())?;

    let view_levels: &[u32] = if light { &[5_000, 20_000] } else { &[5_000, 20_000, 80_000, 320_000] };
    let daylight_levels: &[u32] = if light { &[250] } else { &[250, 1000] };
    let phases = [
        Phase {
            name: "view matrix V",
            ours: [16, 64, 256, 1024]
                .map(|c| {
                    (
                        format!("-c {c}"),
                        format!("{ours} view --points {} -c {c} --near-samples {} {common} -o {}", room.points, 2 * c, at("x.mtx")),
                    )
                })
                .to_vec(),
            peer: view_levels
                .iter()
                .map(|ad| {
                    let options = format!("-I+ -ab 4 -ad {ad} -lw {} -n 2 -y {sensors} -faf", 1.0 / f64::from(*ad));
                    let command =
                        format!("rfluxmtx {options} - {} -i {} < {} > {}", room.window, at("room.oct"), at("points.txt"), at("x.mtx"));
                    (format!("-ad {ad}"), peer(command))
                })
                .collect(),
            output: at("x.mtx").into(),
        },
        Phase {
            name: "daylight matrix D",
            ours: [32, 128, 512, 2048]
                .map(|c| (format!("-c {c}"), format!("{ours} daylight -m 1 -c {c} {common} -o {}", at("x.mtx"))))
                .to_vec(),
            peer: daylight_levels
                .iter()
                .map(|c| {
                    let options = format!("-ff -ab 4 -ad 1000 -lw .001 -c {c} -n 2");
                    (
                        format!("-c {c}"),
                        peer(format!("rfluxmtx {options} {} {sky_file} -i {} > {}", room.window, at("room.oct"), at("x.mtx"))),
                    )
                })
                .collect(),
            output: at("x.mtx").into(),
        },
    ];
    let mut record = record::Record::new("phases");
    for (number, phase) in phases.iter().enumerate() {
        println!("\n{}", phase.name);
        let curve = |who: &str, levels: &[(String, String)]| -> Result<Vec<(f64, f64)>, String> {
            let mut points = Vec::new();
            // Once before, so that the driver's cache of compiled shaders is warm.
            if who == "lucarne" {
                timed(&room.folder, &levels[0].1)?;
            }
            for (label, command) in levels {
                let seconds = timed(&room.folder, command)?;
                let x = channel(&read(&phase.output)?);
                let result = if number == 0 { illuminance(&x, &d) } else { illuminance(&v, &x) };
                let e = error(&result, &converged, hours);
                println!("  {who:9} {label:12} {seconds:8.2} s   {e:6.2} %");
                points.push((seconds, e));
            }
            Ok(points)
        };
        let own = curve("lucarne", &phase.ours)?;
        if let Some(seconds) = time_at(&own, 1.0) {
            record.add(format!("{} to 1 % of an hour", phase.name), 1.0 / seconds, "1/CPU-s");
        }
        if environment.is_none() {
            continue;
        }
        let peers = curve("rfluxmtx", &phase.peer)?;
        let mut ratios = Vec::new();
        for &(seconds, e) in &peers {
            if let Some(same) = time_at(&own, e) {
                record.add(format!("{}: rfluxmtx / lucarne at {e:.1} %", phase.name), seconds / same, "ratio of CPU time");
                println!("  at {e:.2} %: rfluxmtx {seconds:.1} s, lucarne {same:.2} s: {:.0} times less", seconds / same);
                ratios.push(format!("{} × at {e:.1} %", record::short(seconds / same)));
            }
        }
        if light || !is_tutorial {
            continue;
        }
        let named: Vec<String> = phase.peer.iter().map(|(label, _)| format!("`{label}` ")).collect();
        let rows = [levels(&vec![String::new(); own.len()], &own), levels(&named, &peers), ratios.join(", ")];
        if number == 0 {
            record::measured("speed-v", &rows[0], "");
            record::measured("speed-v-radiance", &rows[1], "");
            record::measured("speed-v-ratio", &rows[2], "");
        } else {
            record::measured("speed-d", &rows[0], "");
            record::measured("speed-d-radiance", &rows[1], "");
            record::measured("speed-d-ratio", &rows[2], "");
        }
    }
    record.finish();
    Ok(())
}

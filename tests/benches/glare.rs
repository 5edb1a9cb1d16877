//! A year of glare of one view, beside Radiance's way in the same run: `dctimestep` makes a picture
//! of each hour, `evalglare` judges it. CPU seconds of all processes and threads, so that other load
//! does not count; on a device that is no software the wall clock is what matters.
//!
//! `cargo bench --bench glare [-- SIDE [VIEWS]]`: pixels along a side (400), and how often the view
//! is judged. V, D and S are computed once and kept in target/tmp.

#[path = "record.rs"]
mod record;

use lucarne::Warnings;
use lucarne::camera::View;
use lucarne::glare::{Analyser, PixelGeometry, Settings};
use lucarne::gpu::{Device, DeviceKind};
use lucarne::image::{Picture, hdr};
use lucarne::kernels::glare::{Detector, InMemory, Native, OnDevice, PixelSource, ReadyView, Stack, StackOptions, Year, year};
use lucarne::kernels::product::{self, Arrangement, Multiplier};
use lucarne::matrix::Matrix;
use lucarne::matrix::file::{Format, read_matrix, write_matrix};
use lucarne::progress::Silent;
use lucarne::simulate::multiply::{Factor, lit_columns, product, select_columns};
use lucarne::simulate::{Inputs, Project, run};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;

/// Hours judged by Radiance's programs too.
const SAMPLES: usize = 12;
/// Wall seconds per picture of Radiance's newest `dctimestep` (6.1, AVX2, two processes) at 400 × 400,
/// measured once.
const NEWEST_DCTIMESTEP: f64 = 0.012;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

struct Room {
    folder: PathBuf,
    project: String,
    bsdf: &'static str,
}

fn room(side: usize) -> Room {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tutorial = root.join("../shared/data/tutorial_room");
    let sections = |weather: &str, scene: &str, window: &str, bsdf: &str, view: &str| {
        format!(
            "[weather]\nfile = \"{weather}\"\n[scene]\nfiles = {scene}\n[[window]]\nname = \"w\"\nsurface = \"{window}\"\n\
             bsdf = \"{bsdf}\"\n[[view]]\nname = \"eye\"\nfile = \"{view}\"\nresolution = [{side}, {side}]\n\
             [method]\nbounces = 4\n[quality]\npreset = \"draft\"\n"
        )
    };
    if tutorial.is_dir() {
        let scene = "[\"materials.rad\", \"room.rad\"]";
        let project = sections("weather/NYC.wea", scene, "objects/GlazingVmtx.rad", "bsdf/clear.xml", "views/fish.vf");
        Room { folder: tutorial, project, bsdf: "bsdf/clear.xml" }
    } else {
        let scene = "[\"materials.rad\", \"office.rad\"]";
        let project = sections("weather/new_york.wea", scene, "windows/vision.rad", "bsdf/double_clear.xml", "views/desk.vf");
        Room { folder: root.join("scenes/office"), project, bsdf: "bsdf/double_clear.xml" }
    }
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &target)?;
        } else if !target.exists() {
            std::fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

/// CPU seconds of this process and of its finished children (Linux), user and system.
fn cpu_seconds() -> [f64; 2] {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> =
        text.rsplit_once(')').map(|(_, rest)| rest.split_whitespace().map(|f| f.parse().unwrap_or(0.0)).collect()).unwrap_or_default();
    let at = |i: usize| fields.get(i).copied().unwrap_or(0.0) / 100.0;
    [at(11) + at(12), at(13) + at(14)]
}

/// CPU and wall seconds.
fn timed<T>(children: bool, f: impl FnOnce() -> Fallible<T>) -> Fallible<(T, f64, f64)> {
    let (cpu, start) = (cpu_seconds(), Instant::now());
    let result = f()?;
    let i = usize::from(children);
    Ok((result, cpu_seconds()[i] - cpu[i], start.elapsed().as_secs_f64()))
}

fn radiance() -> Option<PathBuf> {
    let find = "import pyradiance,os;print(os.path.dirname(pyradiance.__file__),end='')";
    let out = Command::new("python3").args(["-c", find]).output().ok()?;
    let bin = PathBuf::from(String::from_utf8(out.stdout).ok()?).join("bin");
    bin.join("dctimestep").is_file().then_some(bin)
}

fn main() -> Fallible<()> {
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let side = numbers.first().copied().unwrap_or(400);
    let repeats = numbers.get(1).copied().unwrap_or(1);
    let room = room(side);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("glare_{side}"));
    copy(&room.folder, &folder)?;
    let file = folder.join("bench.toml");
    std::fs::write(&file, &room.project)?;
    let project = Project::read(&file)?;
    let mut warnings = Warnings::new();
    let inputs = Inputs::read(&project, &mut warnings)?;
    let device = Device::open(None)?;
    let out = folder.join("out");
    println!("{} at {side} × {side}; V, D and S …", room.folder.display());
    let clock = Instant::now();
    run(&device, &project, &inputs, &out, &Silent, &mut warnings)?;
    println!("… {:.1} s (0 if kept from an earlier run)", clock.elapsed().as_secs_f64());

    let matrix = |name: &str| read_matrix(&out.join(format!("matrices/{name}.mtx"))).map(|m| m.matrix);
    let (v, t, d, s) = (matrix("V_eye")?, matrix("T_w")?, matrix("D_w")?, matrix("S")?);
    let hours = lit_columns(&s);
    let sky = select_columns(&s, &hours);
    let factor = |name: &str, matrix: Matrix<f32>| Factor { name: name.into(), matrix };
    let multiplier = product::for_device(&device)?;
    let (coefficients, cpu, _) =
        timed(false, || Ok(product(&*multiplier, vec![factor("T", t.clone()), factor("D", d.clone()), factor("S", sky)], None)?))?;
    println!("T·D·S of {} daylit hours: {cpu:.2} CPU-seconds", hours.len());
    let camera = View::read(&project.views[0].file)?;
    let raster = project.views[0].raster()?;
    let analyser = Arc::new(Analyser::new(Arc::new(PixelGeometry::new(&raster)?), Settings::default())?);

    let mut detectors: Vec<Box<dyn Detector>> = vec![Box::new(Native)];
    if device.summary().kind != DeviceKind::Cpu {
        detectors.push(Box::new(OnDevice::new(&device)?));
    }
    let mut own = (f64::INFINITY, f64::INFINITY, Vec::new());
    for detector in &detectors {
        let mut source = InMemory::new(&v);
        let (stack, cpu, wall) =
            timed(false, || Ok(Stack::new(analyser.clone(), vec![&mut source as &mut dyn PixelSource], StackOptions::default())?))?;
        println!(
            "{}: {} candidates of {} pixels, {} terms, made ready in {cpu:.2} CPU-seconds, {wall:.2} s",
            detector.description(),
            stack.candidates(),
            v.rows(),
            stack.terms()
        );
        let rights = [&coefficients];
        for skip in [true, false] {
            let request = Year { skip, ..Year::new(&rights) };
            for _ in 0..repeats {
                let (found, cpu, wall) = timed(false, || Ok(year(&ReadyView::new(&**detector, &stack)?, &request, &Silent)?))?;
                println!("  year, {}: {cpu:.2} CPU-seconds, {wall:.2} s", if skip { "dark tiles left out" } else { "every tile" });
                if wall < own.1 && skip {
                    own = (cpu, wall, found);
                }
            }
        }
        let flops = 2.0 * (stack.candidates() * stack.terms()) as f64 * hours.len() as f64;
        println!("  its product alone would be {:.0} GFLOP; rates of the product on {} hours:", flops / 1e9, 256.min(hours.len()));
        rate(&*multiplier, stack.candidates(), stack.terms(), 256.min(hours.len()))?;
    }
    let (cpu, wall, found) = own;
    let mut record = record::Record::new("glare");
    record.add(format!("hours of a year at {side} × {side}"), hours.len() as f64 / cpu, "hours/CPU-s");
    let Some(bin) = radiance() else {
        println!("SKIPPED Radiance: pyradiance is not installed");
        record.finish();
        return Ok(());
    };
    peer(&bin, &folder, &room, &v, &d, &s, &hours, &camera, &found, (cpu, wall), &mut record)?;
    record.finish();
    Ok(())
}

/// Rate of the product of one component that the fused way replaces.
fn rate(multiplier: &dyn Multiplier, rows: usize, terms: usize, columns: usize) -> Fallible<()> {
    let (a, b) = (vec![0.5f32; rows * terms], vec![0.25f32; terms * columns]);
    let left = multiplier.left(rows, terms, 1, (&a[..]).into())?;
    let right = multiplier.right(terms, columns, 1, (&b[..]).into())?;
    let mut c = vec![0.0f32; rows * columns];
    multiplier.multiply(&left, &right, 0, columns, Arrangement::Columns, &mut c)?;
    let ((), cpu, wall) = timed(false, || Ok(multiplier.multiply(&left, &right, 0, columns, Arrangement::Columns, &mut c)?))?;
    let flops = 2.0 * (rows * terms * columns) as f64 / 1e9;
    println!("    {:.0} GFLOP per CPU-second, {:.0} per second: {}", flops / cpu.max(0.01), flops / wall, multiplier.description());
    Ok(())
}

/// Radiance's programs on a few of the hours.
#[allow(clippy::too_many_arguments, reason = "everything measured so far")]
fn peer(
    bin: &Path,
    folder: &Path,
    room: &Room,
    v: &Matrix<f32>,
    d: &Matrix<f32>,
    s: &Matrix<f32>,
    hours: &[usize],
    camera: &View,
    found: &[lucarne::kernels::glare::HourGlare],
    (own_cpu, own_wall): (f64, f64),
    record: &mut record::Record,
) -> Fallible<()> {
    let work = folder.join("radiance");
    std::fs::create_dir_all(&work)?;
    let side = (v.rows() as f64).sqrt() as usize;
    for bin in 0..v.cols() {
        let path = work.join(format!("v{bin:03}.hdr"));
        if !path.exists() {
            let pixels = (0..v.rows()).map(|p| [0, 1, 2].map(|c| v.at(p, bin)[c])).collect();
            let mut picture = Picture::new(side, side, pixels)?;
            picture.view = Some(camera.to_options());
            hdr::write(&path, &picture)?;
        }
    }
    let chosen: Vec<usize> = (0..SAMPLES).map(|i| (2 * i + 1) * hours.len() / (2 * SAMPLES)).collect();
    let columns: Vec<usize> = chosen.iter().map(|&c| hours[c]).collect();
    write_matrix(Some(&work.join("D.mtx")), d, Format::Float, &[])?;
    write_matrix(Some(&work.join("S.mtx")), &select_columns(s, &columns), Format::Float, &[])?;
    let system = folder.join(room.bsdf);
    let ((), multiply_cpu, multiply_wall) = timed(true, || {
        let status = Command::new(bin.join("dctimestep"))
            .current_dir(&work)
            .args(["-o", "img%03d.hdr", "v%03d.hdr"])
            .arg(&system)
            .args(["D.mtx", "S.mtx"])
            .status()?;
        if status.success() { Ok(()) } else { Err("dctimestep failed".into()) }
    })?;
    let mut theirs = Vec::new();
    let (_, judge_cpu, judge_wall) = timed(true, || {
        for i in 0..SAMPLES {
            let options = camera.to_options();
            let picture = work.join(format!("img{i:03}.hdr"));
            let output = Command::new(bin.join("evalglare")).args(options.split_whitespace()).arg(&picture).output()?;
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            let dgp: f64 = text.split_once(':').and_then(|(_, v)| v.split_whitespace().next()).ok_or(text.clone())?.parse()?;
            theirs.push(dgp);
        }
        Ok(())
    })?;
    let squares: f64 = chosen.iter().zip(&theirs).map(|(&c, t)| (found[c].indices.dgp - t).powi(2)).sum();
    let worst = chosen.iter().zip(&theirs).map(|(&c, t)| (found[c].indices.dgp - t).abs()).fold(0.0, f64::max);
    let (n, count) = (SAMPLES as f64, hours.len() as f64);
    println!("per hour of the year:                    CPU-seconds      wall seconds, one process");
    println!("  dctimestep (pyradiance)                {:11.4}  {:16.4}", multiply_cpu / n, multiply_wall / n);
    println!("  evalglare                              {:11.4}  {:16.4}", judge_cpu / n, judge_wall / n);
    println!("  lucarne, both                          {:11.6}  {:16.6}", own_cpu / count, own_wall / count);
    println!("CPU time: {:.0} times less", (multiply_cpu + judge_cpu) / n / (own_cpu / count));
    record.add("dctimestep and evalglare / lucarne", (multiply_cpu + judge_cpu) / n / (own_cpu / count), "ratio of CPU time");
    let newest = 2.0 * NEWEST_DCTIMESTEP * (v.rows() as f64 / 160_000.0) + judge_cpu / n;
    println!(
        "against {NEWEST_DCTIMESTEP} s on two processors for the newest dctimestep at 400 × 400 (in proportion to the pixels) and this evalglare: {:.0} times less",
        newest / (own_cpu / count)
    );
    println!("DGP of the {SAMPLES} hours: RMSE {:.5}, largest difference {worst:.5}", (squares / n).sqrt());
    if side == 400 && room.folder.ends_with("tutorial_room") {
        let (multiply, judge, own) = (multiply_cpu / n, judge_cpu / n, own_cpu / count);
        let short = record::short;
        record::measured("glare-hours", &format!("{count}"), "");
        record::measured("glare-radiance-hour", &format!("{} s + {} s", short(multiply), short(judge)), "");
        record::measured("glare-radiance-year", &format!("{:.0} s", (multiply + judge) * count), "");
        record::measured("glare-lucarne-hour", &format!("{own:.5} s"), "");
        record::measured("glare-lucarne-year", &format!("{} s", short(own_cpu)), "");
        record::measured("glare-ratio", &short((multiply + judge) / own), "");
        record::measured("glare-ratio-newest", &short(newest / own), "");
        record::measured("glare-dgp", &short((squares / n).sqrt()), "");
    }
    Ok(())
}

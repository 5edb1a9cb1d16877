//! `[quality]` and `--no-prune` on whole projects: what is left out changes nothing, what is asked for
//! is met, whatever the resume point.

mod device;
#[path = "../src/testing.rs"]
mod testing;

use device::device;
use lucarne::Warnings;
use lucarne::gpu::Device;
use lucarne::matrix::Matrix;
use lucarne::matrix::file::read_matrix;
use lucarne::progress::{Progress, Silent, cancelled};
use lucarne::simulate::project::Preset;
use lucarne::simulate::{Inputs, Project, Summary, run, without_pruning};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");

/// A shipped scene without its pictures, on one day in March.
fn scene(name: &str) -> (Project, Inputs) {
    let mut project = Project::read(&Path::new(SCENES).join(name).join("project.toml")).unwrap();
    project.views.clear();
    project.glare = None;
    project.images.hours = lucarne::simulate::project::views::ImageHours::None;
    let mut inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
    inputs.weather.records = inputs.weather.records[79 * 24..80 * 24].to_vec();
    (project, inputs)
}

/// Lux and standard error of all sensors, and the summary.
fn results(device: &Device, project: &Project, inputs: &Inputs, out: &Path) -> (Matrix<f32>, Matrix<f32>, Summary) {
    let summary = run(device, project, inputs, out, &Silent, &mut Warnings::new()).unwrap();
    let read = |suffix: &str| {
        let parts: Vec<Matrix<f32>> =
            inputs.sensors.iter().map(|g| read_matrix(&out.join(format!("illuminance/{}{suffix}.mtx", g.name))).unwrap().matrix).collect();
        let (rows, cols) = (parts.iter().map(Matrix::rows).sum(), parts[0].cols());
        Matrix::from_data(rows, cols, 1, parts.into_iter().flat_map(Matrix::into_data).collect()).unwrap()
    };
    (read(""), read("_standard_error"), summary)
}

#[test]
fn leaving_out_what_is_not_needed_changes_no_more_than_the_plan_says() {
    let Some(device) = device("quality") else { return };
    let mut by_quadrature = 0;
    for (name, open) in [("office", false), ("asymmetric", false), ("asymmetric", true), ("blinds", false)] {
        let (mut project, mut inputs) = scene(name);
        project.quality.preset = Preset::Draft;
        if open {
            // Without what stands before its window, which is the plane y = 0.
            inputs.scene.triangles.retain(|t| t.vertices.iter().all(|v| v.y >= 0.0));
        }
        let plan = lucarne::simulate::plan::plan(&project, &inputs).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let (pruned, pruned_error, summary) = results(&device, &project, &inputs, &folder.path().join("a"));
        without_pruning(&mut project, &mut inputs);
        let (whole, whole_error, _) = results(&device, &project, &inputs, &folder.path().join("b"));
        // Where a quadrature stands for rays, or suns got other random numbers, the noise may differ.
        let changed = |words: &str| plan.omissions.iter().any(|o| o.what.contains(words));
        let (quadrature, suns) = (changed("rays of D"), changed("suns, in"));
        by_quadrature += usize::from(quadrature);
        let largest = pruned.data().iter().copied().fold(0.0, f32::max);
        let (mut squares, mut lit, mut most) = (0.0, 0, 0.0f32);
        for i in 0..pruned.data().len() {
            let (a, b) = (pruned.data()[i], whole.data()[i]);
            assert_eq!(a > 0.0, b > 0.0, "{name}");
            let error = pruned_error.data()[i].hypot(whole_error.data()[i]);
            if b > 0.0 {
                (squares, lit) = (squares + f64::from(((a - b) / error).powi(2)), lit + 1);
                most = most.max((a - b).abs() / b);
            }
            if !(quadrature || suns) {
                assert!((a - b).abs() <= 1e-5 * b + 1e-7 * largest, "{name}: {a} {b}");
            }
        }
        let rms = (squares / f64::from(lit)).sqrt();
        assert_eq!(quadrature, open, "{name}");
        eprintln!("{name}: pruned and whole differ by {most:.1e} at most, {rms:.2} standard errors; {:?}", summary.estimated_error);
        // Eight replicates: the ratio's own spread is far below 2.
        assert!(rms < 2.0, "{name}: {rms}");
        assert!(lit > 50);
    }
    assert_eq!(by_quadrature, 1);
}

#[test]
fn standard_quality_meets_two_percent_on_every_shipped_scene() {
    let Some(device) = device("quality") else { return };
    for name in ["office", "asymmetric", "blinds"] {
        let mut project = Project::read(&Path::new(SCENES).join(name).join("project.toml")).unwrap();
        assert_eq!(project.quality.preset, Preset::Standard);
        project.views.clear();
        project.glare = None;
        project.images.hours = lucarne::simulate::project::views::ImageHours::None;
        let inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let (_, _, summary) = results(&device, &project, &inputs, folder.path());
        let error = summary.estimated_error.unwrap();
        eprintln!(
            "{name}: {:.2} % at the worst sensor, {:.2} % at the median one",
            100.0 * error.annual_largest,
            100.0 * error.annual_median
        );
        assert_eq!((error.target, error.target_met), (Some(0.02), Some(true)), "{name}: {error:?}");
        let text = std::fs::read_to_string(folder.path().join("summary.json")).unwrap();
        assert!(text.contains("\"target_met\": true"), "{text}");
    }
}

#[test]
fn a_sweep_measures_error_against_time() {
    use lucarne::simulate::tradeoff::{Knob, Sweep, write};
    let Some(device) = device("quality") else { return };
    let (project, mut inputs) = scene("asymmetric");
    inputs.sensors[0].sensors.truncate(3);
    let folder = tempfile::tempdir().unwrap();
    let knobs = vec![Knob::Samples(1.0 / 64.0), Knob::Samples(0.25), Knob::Sky(1, 1.0 / 64.0)];
    let sweep = Sweep { device: &device, project: &project, inputs: &inputs, folder: folder.path(), knobs };
    // Stopped when all settings are measured: the next sweep measures none of them again.
    let stopped = sweep.run(&Silent, &mut Warnings::new(), &mut |_, _| Err(cancelled()));
    assert!(stopped.is_err_and(|e| e.to_string().contains("stopped")));
    let mut asked = 0;
    let stages = Stages::default();
    let points = sweep
        .run(&stages, &mut Warnings::new(), &mut |reference, _| {
            asked += 1;
            assert_eq!(reference.project.method.sky.map(|sky| sky.subdivision()), Some(4));
            Ok(Vec::new())
        })
        .unwrap();
    assert_eq!((points.len(), asked), (3, 1));
    let stages = stages.0.into_inner().unwrap();
    assert!(!stages.iter().any(|s| s.starts_with("samples 1/") || s.starts_with("sky")), "{stages:?}");
    assert!(stages.iter().any(|s| s.starts_with("warming up")), "{stages:?}");
    let error = |i: usize| points[i].illuminance.unwrap().hourly;
    eprintln!("1/64: {:.2} %, 1/4: {:.2} %, a coarse sky: {:.2} %", 100.0 * error(0), 100.0 * error(1), 100.0 * error(2));
    // Fewer samples are worse by the root of their number, or more; a coarse sky spreads the sun.
    assert!(error(0) > 2.0 * error(1) && error(1) > 0.0 && error(2) > error(1));
    let choice = write(folder.path(), "asymmetric", &points).unwrap();
    assert!(choice.front.contains(&1) && choice.recommended.is_some());
    let table = std::fs::read_to_string(folder.path().join("tradeoff.csv")).unwrap();
    assert_eq!(table.lines().count(), 4);
    assert!(table.lines().nth(2).unwrap().starts_with("lucarne,samples,1/4,"), "{table}");
    assert!(folder.path().join("tradeoff.png").is_file() && folder.path().join("tradeoff.svg").is_file());
    assert!(!folder.path().join("run").exists(), "the runs' files are removed");
    // Interrupted: nothing half-written stays.
    let stopped = sweep.run(&StopAfter(AtomicUsize::new(8)), &mut Warnings::new(), &mut |_, _| Ok(Vec::new()));
    assert!(stopped.is_err_and(|e| e.to_string().contains("stopped")));
    assert!(!folder.path().join("run").exists());
}

/// Remembers the names of all stages.
#[derive(Default)]
struct Stages(Mutex<Vec<String>>);

impl Progress for Stages {
    fn update(&self, stage: &str, _: f64) {
        self.0.lock().unwrap().push(stage.to_string());
    }
}

/// Stops after so many updates.
struct StopAfter(AtomicUsize);

impl Progress for StopAfter {
    fn update(&self, _: &str, _: f64) {}

    fn stop_requested(&self) -> bool {
        self.0.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |n| n.checked_sub(1)).is_err()
    }
}

#[test]
fn a_target_of_one_percent_is_met_against_the_converged_result() {
    let Some(device) = device("quality") else { return };
    let (mut project, mut inputs) = scene("asymmetric");
    inputs.sensors[0].sensors.truncate(4);
    let folder = tempfile::tempdir().unwrap();
    // Coarse rounds, so that several are needed.
    project.quality.preset = Preset::Draft;
    project.quality.target_error = Some(0.002);
    let (converged, _, _) = results(&device, &project, &inputs, &folder.path().join("converged"));
    let sums = |m: &Matrix<f32>| -> Vec<f64> { (0..m.rows()).map(|s| m.row(s).iter().map(|v| f64::from(*v)).sum()).collect() };
    let truth = sums(&converged);
    project.quality.target_error = Some(0.01);
    let (mut squares, mut count) = (0.0, 0);
    for seed in [11, 12, 13] {
        project.quality.seed = seed;
        let (lux, _, summary) = results(&device, &project, &inputs, &folder.path().join(format!("{seed}")));
        let error = summary.estimated_error.unwrap();
        assert_eq!((error.target, error.target_met), (Some(0.01), Some(true)), "{error:?}");
        for (found, wanted) in sums(&lux).iter().zip(&truth) {
            let distance = found / wanted - 1.0;
            // 2.36 standard errors hold 95 %; 12 sensors and seeds ask for a little more.
            assert!(distance.abs() < 3.5 * 0.01, "seed {seed}: {distance}");
            (squares, count) = (squares + distance.powi(2), count + 1);
        }
    }
    let rms = (squares / f64::from(count)).sqrt();
    eprintln!("target 1 %: annual sums lie {:.2} % (rms) from the converged ones", 100.0 * rms);
    assert!(rms < 0.01);

    // Stopped wherever, the same bits come out, and as many rounds.
    let whole = read_matrix(&folder.path().join("11/illuminance/room.mtx")).unwrap().matrix;
    project.quality.seed = 11;
    project.quality.target_error = Some(0.004);
    let (whole_finer, _, summary) = results(&device, &project, &inputs, &folder.path().join("finer"));
    assert!(summary.matrices.iter().filter_map(|m| m.rounds).sum::<u32>() > 2, "{:?}", summary.matrices);
    assert_ne!(whole_finer, whole);
    let whole = whole_finer;
    for after in [3, 15, 30] {
        let out = folder.path().join(format!("stopped{after}"));
        let stopped = run(&device, &project, &inputs, &out, &StopAfter(AtomicUsize::new(after)), &mut Warnings::new());
        assert!(stopped.is_err_and(|e| e.to_string().contains("stopped")), "after {after}");
        assert!(!out.join("summary.json").exists());
        assert_eq!(results(&device, &project, &inputs, &out).0, whole, "stopped after {after}");
    }
}

#[test]
fn sky_and_phases_follow_the_glazing() {
    use lucarne::bsdf::{Block, Blocks, Bsdf, TensorTree, write};
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let even = Blocks { transmission_front: Some(Block::Tree(TensorTree::constant(4, 0.1))), ..Blocks::default() };
    write(Some(&at("panel.xml")), &Bsdf { visible: even, ..Bsdf::default() }, "a test").unwrap();
    let blinds = Path::new(SCENES).join("blinds");
    for name in ["blind.xml", "window.rad", "points.txt", "room.rad"] {
        std::fs::copy(blinds.join(name), at(name)).unwrap();
    }
    std::fs::copy(Path::new(SCENES).join("office/weather/new_york.wea"), at("weather.wea")).unwrap();
    // The same data stand for the pane that suns are traced through.
    for (bsdf, sky, phases, suns) in [("panel.xml", 2, 3, ""), ("blind.xml", 4, 5, ""), ("panel.xml", 2, 5, "suns = 4")] {
        let text = format!(
            "[weather]\nfile = \"weather.wea\"\n[scene]\nfiles = [\"room.rad\"]\n[[window]]\nname = \"w\"\n\
             surface = \"window.rad\"\nbsdf = \"{bsdf}\"\ntensor_tree = \"{bsdf}\"\n[[sensors]]\nname = \"s\"\n\
             points = \"points.txt\"\n[method]\nsky_subdivision = \"auto\"\n{suns}\n"
        );
        std::fs::write(at("project.toml"), text).unwrap();
        let project = Project::read(&at("project.toml")).unwrap();
        let inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
        assert_eq!((inputs.sky(&project).subdivision(), inputs.choice(&project).phases), (sky, phases), "{bsdf} {suns}");
        let plan = lucarne::simulate::plan::plan(&project, &inputs).unwrap().to_string();
        assert!(plan.contains(&format!("MF:{sky} (as the glazing asks)")), "{plan}");
        assert!(phases == 5 || plan.contains("spread all light evenly"), "{plan}");
    }
}

/// A project of one view and nothing else, in the small room, with this `[quality]`.
fn eye_only(folder: &Path, quality: &str) -> (Summary, Vec<u8>) {
    let scene = format!("{SCENES}/asymmetric");
    std::fs::write(folder.join("eye.vf"), "rvu -vta -vp 1.5 1.5 1.2 -vd 0 -1 0 -vu 0 0 1 -vh 180 -vv 180\n").unwrap();
    let text = format!(
        "[weather]\nfile = \"{SCENES}/office/weather/new_york.wea\"\n[scene]\nfiles = [\"{scene}/room.rad\"]\n[[window]]\nname = \"south\"\n\
         surface = \"{scene}/window.rad\"\nbsdf = \"{scene}/louvre.xml\"\n[[view]]\nname = \"eye\"\nfile = \"eye.vf\"\nresolution = [24, 24]\n\
         [glare]\nmethod = \"image\"\n[method]\nsky_subdivision = 1\n[quality]\n{quality}\n"
    );
    std::fs::write(folder.join("project.toml"), text).unwrap();
    let project = Project::read(&folder.join("project.toml")).unwrap();
    let mut inputs = Inputs::read(&project, &mut Warnings::new()).unwrap();
    inputs.weather.records = inputs.weather.records[79 * 24..80 * 24].to_vec();
    let device = Device::shared().unwrap();
    let summary = run(&device, &project, &inputs, &folder.join("out"), &Silent, &mut Warnings::new()).unwrap();
    (summary, std::fs::read(folder.join("out/glare/eye.csv")).unwrap())
}

/// Ev of the day, lx·h, from a table of glare.
fn light(table: &[u8]) -> f64 {
    String::from_utf8_lossy(table).lines().skip(1).map(|l| l.split(',').nth(3).unwrap().parse::<f64>().unwrap()).sum()
}

#[test]
fn a_target_without_sensors_is_met_at_the_eye() {
    if device("a target at the eye").is_none() {
        return;
    }
    let run = |quality: &str| {
        let folder = tempfile::tempdir().unwrap();
        let (summary, table) = eye_only(folder.path(), quality);
        (summary.views[0].eye_error.unwrap(), summary, table, folder)
    };
    let rounds = |summary: &Summary| summary.matrices.iter().find(|m| m.name == "D_south").unwrap().rounds.unwrap();
    let (loose, ..) = run("target_error = 0.2");
    let (error, summary, table, folder) = run("target_error = 0.003");
    println!("20 % asked for: {:.2} %; 0.3 %: {:.2} %", 100.0 * loose, 100.0 * error);
    assert!(error <= 0.003 && loose > 0.005 && summary.warnings.iter().all(|w| !w.contains("at the eye")));
    // More than can be had is said; D is sampled as far as the target asks.
    let (least, summary, ..) = run("target_error = 2e-4");
    println!("0.02 %: {:.3} %, {} rounds of D", 100.0 * least, rounds(&summary));
    assert!(least < error && rounds(&summary) > 1);
    assert!(summary.warnings.iter().any(|w| w.contains("at the eye of view 'eye'")) == (least > 2e-4), "{:?}", summary.warnings);
    // Run again, it finds everything there.
    let (again, same) = eye_only(folder.path(), "target_error = 0.003");
    assert!(again.matrices.iter().all(|m| m.reused), "{:?}", again.matrices);
    assert!(same == table);
    // The error that is told is the spread over seeds.
    const SEEDS: u32 = 10;
    let results: Vec<(f64, f64)> = (0..SEEDS)
        .map(|seed| {
            let (error, _, table, _) = run(&format!("preset = \"draft\"\nseed = {}", 100 + seed));
            (light(&table), error)
        })
        .collect();
    let mean = results.iter().map(|r| r.0).sum::<f64>() / f64::from(SEEDS);
    let seen = (results.iter().map(|r| (r.0 / mean - 1.0).powi(2)).sum::<f64>() / f64::from(SEEDS - 1)).sqrt();
    let told = (results.iter().map(|r| r.1.powi(2)).sum::<f64>() / f64::from(SEEDS)).sqrt();
    println!("told {:.2} %, seen {:.2} % over {SEEDS} seeds", 100.0 * told, 100.0 * seen);
    // A pixel's batches are spread evenly over it and differ more than their mean errs, by up to √3; ten
    // seeds know their spread to a quarter.
    assert!((0.5..2.5).contains(&(told / seen)));
}

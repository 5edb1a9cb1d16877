//! The sun matrix beside Radiance's `rcontrib`: time and error of both in one run, in the tutorial room
//! with real slats in its window. Direct light and light scattered by the slats at 100 sensors, suns
//! in a fisheye, suns through panes of scattering data.
//!
//! The error is the noise: the root mean square difference of two runs with other random numbers,
//! divided by √2 and by the mean entry. Variance falls with time in both programs at least in
//! proportion, so error² × time says how they compare at equal error. The time is user CPU time, of
//! whole processes for sensors (`oconv` not counted), of the computation alone for pictures and panes.
//!
//! `cargo bench --bench suns [-- sensors pictures panes]` needs the reference data in ../shared, and
//! Radiance.

#[path = "record.rs"]
mod record;
#[path = "shell.rs"]
mod shell;

use lucarne::Warnings;
use lucarne::bins::ReinhartSky;
use lucarne::bsdf::{self, evaluate::Scattering};
use lucarne::camera::{Raster, View};
use lucarne::gpu::Device;
use lucarne::kernels::sun_matrix::pane::PaneBsdf;
use lucarne::kernels::sun_matrix::pixels::{self, Models, PixelOptions};
use lucarne::kernels::sun_matrix::{Openings, Sun, SunOptions, compute};
use lucarne::matrix::file::read_matrix;
use lucarne::progress::Silent;
use lucarne::scene::points::read_points;
use lucarne::scene::{MaterialKind, Scene, Window, read_scene, read_windows};
use lucarne::simulate::{inputs::suns::SunSet, project::method::SunScheme};
use lucarne::weather::Weather;
use shell::{radiance_path, timed};
use std::path::{Path, PathBuf};

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

const BLACK: &str = "materialBlack.rad roomBlack.rad ../reference/fivephase/blindsGeometry.rad";
/// Pixels along a side of the fisheye.
const SIDE: usize = 100;
/// Radiance of the suns, so that rcontrib drops no weak coefficient.
const BRIGHT: f64 = 1e6;

/// Time and noise of one way to compute something.
struct Cost {
    name: String,
    seconds: f64,
    error: f64,
}

/// Noise of one of two independent results.
fn noise(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    let sum: f64 = a.iter().chain(b).sum();
    (squares / 2.0 / a.len() as f64).sqrt() / (sum / 2.0 / a.len() as f64)
}

/// Runs twice what gives seconds and a result. Radiance draws by the clock's second: the runs begin in different ones.
fn twice(name: impl Into<String>, mut run: impl FnMut(u32) -> Fallible<(f64, Vec<f64>)>) -> Fallible<(Cost, f64)> {
    let (first, a) = run(1)?;
    std::thread::sleep(std::time::Duration::from_millis(1100));
    let (second, b) = run(2)?;
    let cost = Cost { name: name.into(), seconds: (first + second) / 2.0, error: noise(&a, &b) };
    Ok((cost, a.iter().chain(&b).sum::<f64>()))
}

/// Prints and records; gives the cells of a table: ours, Radiance's, and how they compare at equal error.
fn report(record: &mut record::Record, what: &str, own: &(Cost, f64), peers: &[(Cost, f64)]) -> [String; 3] {
    println!("\n{what}");
    for (c, sum) in std::iter::once(own).chain(peers) {
        println!("  {:52} {:8.2} s  {:8.3} %   sum {:.4} of ours", c.name, c.seconds, 100.0 * c.error, sum / own.1);
    }
    let figure = |c: &Cost| c.error * c.error * c.seconds;
    for (peer, _) in peers {
        let ratio = figure(peer) / figure(&own.0);
        println!("  at equal error {ratio:.1} times less time than {}", peer.name);
        record.add(format!("{what}: {} / lucarne at equal error", peer.name), ratio, "ratio of CPU time");
    }
    let cost = |c: &Cost| format!("{} s, {}", record::short(c.seconds), record::percent(c.error));
    let cells = peers.iter().map(|(c, _)| (format!("{}: {}", c.name, cost(c)), format!("{} ×", record::short(figure(c) / figure(&own.0)))));
    let (theirs, ratios): (Vec<String>, Vec<String>) = cells.unzip();
    [cost(&own.0), theirs.join(" · "), ratios.join(" · ")]
}

/// User CPU seconds of this process (Linux).
fn own_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let field = text.rsplit_once(')').and_then(|(_, rest)| rest.split_whitespace().nth(11)?.parse::<f64>().ok());
    field.unwrap_or(0.0) / 100.0
}

/// First channel of rcontrib's floats.
fn floats(path: &Path) -> Fallible<Vec<f64>> {
    let bytes = std::fs::read(path)?;
    Ok(bytes.chunks_exact(12).map(|v| f64::from(f32::from_le_bytes([v[0], v[1], v[2], v[3]])) / BRIGHT).collect())
}

struct Room {
    folder: PathBuf,
    environment: String,
    temporary: tempfile::TempDir,
    window: Vec<Window>,
}

impl Room {
    fn path(&self, name: &str) -> PathBuf {
        self.temporary.path().join(name)
    }

    fn at(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    fn run(&self, command: &str) -> Fallible<f64> {
        Ok(timed(&self.folder, command)?)
    }

    /// Suns, their names and the octree of a scene with them, as `NAME.rad`, `NAME.mod`, `NAME.oct`.
    fn suns(&self, name: &str, scene: &str, suns: &[Sun]) -> Fallible<()> {
        let (mut rad, mut names) = (String::new(), String::new());
        for (i, s) in suns.iter().enumerate() {
            let d = s.direction;
            rad += &format!("void light sol{i} 0 0 3 {BRIGHT} {BRIGHT} {BRIGHT}\nsol{i} source s{i} 0 0 4 {} {} {} 0.533\n", d.x, d.y, d.z);
            names += &format!("sol{i}\n");
        }
        std::fs::write(self.path(&format!("{name}.rad")), rad)?;
        std::fs::write(self.path(&format!("{name}.mod")), names)?;
        let [rad, octree] = ["rad", "oct"].map(|e| self.at(&format!("{name}.{e}")));
        self.run(&format!("{} oconv -f {scene} {rad} > {octree}", self.environment))?;
        Ok(())
    }

    /// `rcontrib` at the sensors, each of them `rays` times.
    fn rcontrib(&self, suns: &str, options: &str, rays: usize) -> Fallible<(f64, Vec<f64>)> {
        let points = std::fs::read_to_string(self.folder.join("points.txt"))?;
        let lines: Vec<&str> = points.lines().filter(|l| !l.trim().is_empty()).collect();
        std::fs::write(self.path("points"), lines.iter().map(|l| format!("{l}\n").repeat(rays)).collect::<String>())?;
        let [names, octree, input, output] =
            [format!("{suns}.mod"), format!("{suns}.oct"), "points".into(), "out".into()].map(|n| self.at(&n));
        let command = format!(
            "{} rcontrib -h -V+ -I+ {options} -dc 1 -dt 0 -ss 0 -c {rays} -y {} -faf -M {names} {octree} < {input} > {output}",
            self.environment,
            lines.len()
        );
        Ok((self.run(&command)?, floats(Path::new(&output))?))
    }

    fn lucarne(&self, options: &str, seed: u32) -> Fallible<(f64, Vec<f64>)> {
        let output = self.path("c.mtx");
        let command = format!(
            "{} matrix sun --points points.txt --suns {} {options} --seed {seed} {BLACK} -o {}",
            env!("CARGO_BIN_EXE_lucarne"),
            self.at("needed.rad"),
            output.display()
        );
        let seconds = self.run(&command)?;
        let matrix = read_matrix(&output)?.matrix;
        Ok((seconds, matrix.data().chunks_exact(3).map(|v| f64::from(v[0])).collect()))
    }
}

fn sensors(room: &Room, needed: &SunSet, record: &mut record::Record) -> Fallible<()> {
    let sky = ReinhartSky::new(6)?;
    let all: Vec<Sun> = (1..sky.len()).map(|patch| Sun::new(sky.centre(patch))).collect();
    room.suns("all", BLACK, &all)?;
    room.suns("needed", BLACK, &needed.suns)?;
    // Once before, so that the driver's cache of compiled shaders is warm.
    room.lucarne("--ab 4", 1)?;
    let own = twice("lucarne", |seed| room.lucarne("--ab 0", seed))?;
    let direct = "-ab 0 -dj 1";
    // Of all suns those that occur are compared.
    let chosen = |row: &[f64]| needed.columns.iter().map(|patch| row[patch - 1]).collect::<Vec<f64>>();
    let tutorial = twice(format!("rcontrib -c 16, {} suns", all.len()), |_| {
        let (seconds, found) = room.rcontrib("all", direct, 16)?;
        Ok((seconds, found.chunks_exact(all.len()).flat_map(chosen).collect()))
    })?;
    let few = twice(format!("rcontrib -c 64, the {} suns that occur", needed.suns.len()), |_| room.rcontrib("needed", direct, 64))?;
    let [ours, theirs, ratios] = report(record, "suns at sensors, direct", &own, &[tutorial, few]);
    record::measured("speed-suns", &ours, "");
    record::measured("speed-suns-radiance", &theirs, "");
    record::measured("speed-suns-ratio", &ratios, "");
    // Direct light of points has no noise: all of it is in what slats scatter.
    let own = twice("lucarne", |seed| room.lucarne("--ab 4 --point-suns", seed))?;
    let peer = twice("rcontrib -ab 4 -ad 256", |_| room.rcontrib("needed", "-ab 4 -ad 256 -lw 4e-3 -dj 0", 1))?;
    // The tutorial gives it every sun of the scheme; few rays are enough to see what that costs.
    let tutorial = twice(format!("rcontrib -ab 4 -ad 64, {} suns", all.len()), |_| {
        let (seconds, found) = room.rcontrib("all", "-ab 4 -ad 64 -lw 1.6e-2 -dj 0", 1)?;
        Ok((seconds, found.chunks_exact(all.len()).flat_map(chosen).collect()))
    })?;
    let [ours, theirs, ratios] = report(record, "suns at sensors, scattered by slats", &own, &[tutorial, peer]);
    record::measured("speed-scattered", &ours, "");
    record::measured("speed-scattered-radiance", &theirs, "");
    record::measured("speed-scattered-ratio", &ratios, "");
    Ok(())
}

/// The room with its slats as it looks and as a black model, and where the materials of the slats begin.
fn models(room: &Room) -> Fallible<(Scene, Scene, u32)> {
    let files: [PathBuf; 3] = ["materials.rad", "room.rad", "../reference/fivephase/blindsGeometry.rad"].map(PathBuf::from);
    let first = read_scene(&files[..2], &room.folder, &mut Warnings::new())?.materials.len();
    let lit = read_scene(&files, &room.folder, &mut Warnings::new())?;
    let mut black = lit.clone();
    for material in &mut black.materials[..first] {
        if !matches!(material.kind, MaterialKind::Glass { .. } | MaterialKind::Void) {
            material.kind = MaterialKind::Plastic { color: [0.0; 3], specularity: 0.0, roughness: 0.0 };
        }
    }
    Ok((lit, black, first as u32))
}

/// Suns in a fisheye. Radiance is given the suns of `peer`, of which `chosen` are ours, and `rays` rays a pixel.
struct Fisheye<'a> {
    what: &'a str,
    suns: &'a [Sun],
    peer: &'a [Sun],
    chosen: &'a [usize],
    rays: usize,
}

fn pictures(room: &Room, device: &Device, job: &Fisheye, record: &mut record::Record) -> Fallible<[String; 3]> {
    let (suns, rays) = (job.suns, job.rays);
    let (lit, black, first_shade) = models(room)?;
    let corners = lit.triangles.iter().filter(|t| t.material.0 >= first_shade).flat_map(|t| t.vertices).collect();
    let shaded = [(room.window[0].clone(), corners)];
    let models = Models { lit: &lit, black: &black, first_shade, shaded: &shaded, panes: &[] };
    let raster = Raster::fit(View::read(&room.folder.join("views/fish.vf"))?.camera()?, SIDE, SIDE, 1.0)?;
    // What shows the disc itself is left out (a ray hits it or not): brighter than a white surface.
    let white = suns[0].solid_angle() / std::f64::consts::PI;
    let surfaces = |v: f64| if v <= 1.05 * white { v } else { 0.0 };
    let own = |seed: u32| {
        let slats = SunOptions { batches: 16, disc_samples: 1, seed, ..SunOptions::default() }.direct();
        let options = PixelOptions { slats, panes: SunOptions { batches: slats.batches, ..SunOptions::default() } };
        let before = own_seconds();
        let found = pixels::compute(device, &models, &raster, suns, &options, &Silent, &mut Default::default())?;
        let seconds = own_seconds() - before;
        let mut all = vec![0.0; SIDE * SIDE * suns.len()];
        for (sun, picture) in found.iter().enumerate() {
            picture.pixels.iter().for_each(|(pixel, v)| all[*pixel as usize * suns.len() + sun] = surfaces(f64::from(v[0])));
        }
        Ok((seconds, all))
    };
    own(1)?;
    let own = twice("lucarne, 16 points of each pixel", own)?;
    // What stands outside is no part of ours.
    let inside = room.path("inside.rad");
    let parts = [("", "Floor"), ("", "InteriorWall"), ("", "Ceiling"), ("-m black ", "Ground"), ("-m black ", "ExteriorWalls")];
    std::fs::write(&inside, parts.map(|(how, part)| format!("!xform {how}objects/{part}.rad\n")).concat())?;
    let scene = format!("materials.rad materialBlack.rad {} ../reference/fivephase/blindsGeometry.rad", inside.display());
    room.suns("some", &scene, job.peer)?;
    let [names, octree, output] = ["some.mod", "some.oct", "out"].map(|n| room.at(n));
    let environment = &room.environment;
    // vwrays draws the same rays each time: two runs in turn are had from one of twice the rays.
    let view = format!("-vf views/fish.vf -x {SIDE} -y {SIDE}");
    let command = format!(
        "export {environment}; vwrays -ff {view} -c {} -pj 1 | rcontrib -h -V+ -ab 0 -dj 1 -dc 1 -dt 0 -ss 0 -c {rays} -y {} -fff -M {names} {octree} > {output}",
        2 * rays,
        2 * SIDE * SIDE
    );
    let seconds = room.run(&command)? / 2.0;
    let both: Vec<f64> =
        floats(Path::new(&output))?.chunks_exact(job.peer.len()).flat_map(|all| job.chosen.iter().map(|s| surfaces(all[*s]))).collect();
    let peer = twice(format!("vwrays -c {rays} into rcontrib -ab 0 -dj 1, {} suns", job.peer.len()), |run| {
        let one = both.chunks_exact(suns.len()).skip(run as usize - 1).step_by(2);
        let mut found: Vec<f64> = one.flatten().copied().collect();
        // Radiance looks beyond the circle of a fisheye too.
        let beyond = (0..SIDE * SIDE).filter(|p| !raster.is_seen(p % SIDE, p / SIDE));
        beyond.for_each(|p| found[p * suns.len()..][..suns.len()].fill(0.0));
        Ok((seconds, found))
    })?;
    Ok(report(record, job.what, &own, &[peer]))
}

fn panes(room: &Room, device: &Device, suns: &[Sun], record: &mut record::Record) -> Fallible<()> {
    let files: [PathBuf; 2] = ["materialBlack.rad", "roomBlack.rad"].map(PathBuf::from);
    let scene = read_scene(&files, &room.folder, &mut Warnings::new())?;
    let sensors = read_points(&room.folder.join("points.txt"))?;
    let mut cells: Vec<[String; 3]> = Vec::new();
    for (what, file, polygon) in [
        ("suns through a Klems pane", "blinds_correct_klems.xml", "GlazingKlems"),
        ("suns through a tensor tree", "blinds_correct_t4.xml", "GlazingT4"),
    ] {
        let data = bsdf::read(&room.folder.join("bsdf").join(file), &mut Warnings::new())?;
        let panes = [(room.window[0].clone(), PaneBsdf::Bsdf(Scattering::new(&data)?))];
        let own = |seed: u32| {
            let before = own_seconds();
            let found =
                compute(device, &scene, Openings::Panes(&panes), &sensors, suns, &SunOptions { seed, ..SunOptions::default() }, &Silent)?;
            Ok((own_seconds() - before, found.total.data().chunks_exact(3).map(|v| f64::from(v[0])).collect()))
        };
        own(1)?;
        let own = twice("lucarne", own)?;
        // The pane's file names its data relative to its own folder.
        let text = std::fs::read_to_string(room.folder.join(format!("../reference/fivephase/{polygon}.rad")))?;
        let pane = room.path("pane.rad");
        std::fs::write(&pane, text.replace("../../tutorial_room/", ""))?;
        room.suns("pane_suns", &format!("materialBlack.rad roomBlack.rad {}", pane.display()), suns)?;
        let peer = twice("rcontrib -ab 1 -ad 1024", |_| room.rcontrib("pane_suns", "-ab 1 -ad 1024 -lw 1e-4 -dj 1", 1))?;
        cells.push(report(record, what, &own, &[peer]));
    }
    let [ours, theirs, ratios] = std::array::from_fn(|k| cells.iter().map(|c| c[k].as_str()).collect::<Vec<_>>().join(" · "));
    record::measured("speed-panes", &ours, "");
    record::measured("speed-panes-radiance", &theirs, "");
    record::measured("speed-panes-ratio", &ratios, "");
    Ok(())
}

fn main() -> Fallible<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/tutorial_room");
    if !folder.is_dir() {
        println!("SKIPPED the sun matrix: there is no reference data at {}", folder.display());
        return Ok(());
    }
    let Some(environment) = radiance_path() else {
        println!("SKIPPED the sun matrix: Radiance (pyradiance) is not installed");
        return Ok(());
    };
    let window = read_windows(Path::new("objects/GlazingVmtx.rad"), &folder, &mut Warnings::new())?;
    let weather = Weather::read(&folder.join("weather/NYC.wea"), &mut Warnings::new())?;
    let set = SunSet::new(&weather, SunScheme::Patches(ReinhartSky::new(6)?), &[])?;
    let room = Room { folder, environment, temporary: tempfile::tempdir()?, window };
    println!("user CPU seconds, noise of an entry in percent of the mean entry");
    let device = Device::open(None)?;
    let mut record = record::Record::new("suns");
    let given: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let asked = |part: &str| given.is_empty() || given.iter().any(|g| g == part);
    if asked("sensors") {
        sensors(&room, &set, &mut record)?;
    }
    // Suns in the south, spread over the year.
    let south: Vec<Sun> = set.suns.iter().copied().filter(|s| s.direction.y < -0.3).collect();
    let some: Vec<Sun> = south.iter().copied().step_by(south.len().div_ceil(40).max(1)).collect();
    if asked("pictures") {
        let chosen: Vec<usize> = (0..some.len()).collect();
        let what = "suns in a fisheye, direct";
        let some = Fisheye { what, suns: &some, peer: &some, chosen: &chosen, rays: 16 };
        let [ours, theirs, ratio] = pictures(&room, &device, &some, &mut record)?;
        record::measured("speed-some-pictures", &ours, "");
        record::measured("speed-some-pictures-radiance", &theirs, "");
        record::measured("speed-some-pictures-ratio", &ratio, "");
        let sky = ReinhartSky::new(6)?;
        let all: Vec<Sun> = (1..sky.len()).map(|patch| Sun::new(sky.centre(patch))).collect();
        let chosen: Vec<usize> = set.columns.iter().map(|patch| patch - 1).collect();
        let what = "suns in a fisheye, direct, all suns of the year";
        let every = Fisheye { what, suns: &set.suns, peer: &all, chosen: &chosen, rays: 2 };
        let [ours, theirs, ratio] = pictures(&room, &device, &every, &mut record)?;
        record::measured("speed-all-pictures", &ours, "");
        record::measured("speed-all-pictures-radiance", &theirs, "");
        record::measured("speed-all-pictures-ratio", &ratio, "");
    }
    if asked("panes") {
        panes(&room, &device, &some, &mut record)?;
    }
    record.finish();
    Ok(())
}

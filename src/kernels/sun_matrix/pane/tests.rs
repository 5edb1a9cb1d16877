use super::*;
use crate::bins::{KlemsBasis, ReinhartSky};
use crate::bsdf::evaluate::Scattering;
use crate::bsdf::{Block, Blocks, TensorTree};
use crate::bsdf::{Bsdf, KlemsMatrix, read, resample, transmission_matrix, write};
use crate::error::Warnings;
use crate::kernels::daylight_matrix::{self, DaylightOptions};
use crate::kernels::trace::reference::Random;
use crate::kernels::trace::rooms::{Builder, sensor, window};
use crate::kernels::view_matrix::{self, ViewOptions, mean_and_error};
use crate::matrix::file::read_matrix;
use crate::progress::Silent;
use crate::scene::MaterialKind;
use crate::testing;
use std::f64::consts::PI;

pub(crate) fn klems(b: KlemsBasis) -> Block {
    Block::Klems(KlemsMatrix::from_fn(&b.into(), |o, i| 0.02 + ((o * 145 + i) as f64 * 0.618_034).fract().powi(4) * 0.3))
}

pub(crate) fn scattering(block: Block) -> Scattering {
    Scattering::of_blocks(&Blocks { transmission_front: Some(block), ..Blocks::default() }).unwrap()
}

fn sun(x: f64, y: f64, z: f64) -> Sun {
    Sun::new(DVec3::new(x, y, z))
}

/// A window in the south, 2 m × 1 m, with a shelf inside and a fin outside.
pub(crate) fn room() -> (Scene, Window) {
    let mut b = Builder::default();
    let grey = b.grey(0.5);
    b.quad([[-1.0, 0.1, 1.5], [0.4, 0.1, 1.5], [0.4, 0.6, 1.5], [-1.0, 0.6, 1.5]], grey);
    b.quad([[0.3, -0.7, 0.0], [0.3, -0.05, 0.0], [0.3, -0.05, 3.0], [0.3, -0.7, 3.0]], grey);
    let w = window([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 2.0], [-1.0, 0.0, 2.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    (b.scene, w)
}

fn sensors() -> Vec<Sensor> {
    vec![sensor([0.3, 1.0, 0.8], [0.0, 0.0, 1.0]), sensor([-0.6, 2.5, 0.0], [0.0, -0.5, 1.0]), sensor([1.5, 0.7, 1.2], [-1.0, -0.4, 0.0])]
}

fn suns() -> Vec<Sun> {
    vec![sun(0.3, -0.7, 0.5), sun(-0.5, -0.6, 0.4), sun(0.05, -0.3, 0.9), sun(0.2, 0.7, 0.3), sun(0.7, -0.5, 0.1)]
}

pub(crate) fn is_blocked(scene: &Scene, from: DVec3, direction: DVec3, most: f64) -> bool {
    scene.triangles.iter().any(|t| {
        let [a, b, c] = t.vertices;
        let p = direction.cross(c - a);
        let det = (b - a).dot(p);
        let s = from - a;
        let u = s.dot(p) / det;
        let q = s.cross(b - a);
        let v = direction.dot(q) / det;
        let distance = (c - a).dot(q) / det;
        det.abs() > 1e-14 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 1e-7 && distance < most
    })
}

/// The definition: a fine grid over the window (`n` columns) and the sun's disc.
pub(crate) fn reference(scene: &Scene, w: &Window, s: &Scattering, sensor: &Sensor, sun: &Sun, n: usize) -> f64 {
    let normal = sensor.direction.normalize();
    let mut random = Random(3);
    let mut sum = 0.0;
    for k in 0..n * n / 2 {
        let (u, v) = (((k % n) as f64 + random.next()) / n as f64, ((k / n) as f64 + random.next()) / (n / 2) as f64);
        let x = DVec3::new(-1.0 + 2.0 * u, 0.0, 1.0 + v);
        let (radius, phi) = (sun.chord() * random.next().sqrt(), std::f64::consts::TAU * random.next());
        let a = sun.direction.any_orthonormal_vector();
        let towards = (sun.direction + (a * phi.cos() + sun.direction.cross(a) * phi.sin()) * radius).normalize();
        let (incident, to) = (-w.frame.to_local(towards), sensor.position - x);
        let (distance, direction) = (to.length(), to.normalize());
        let outgoing = w.frame.to_local(direction);
        let cosine = -direction.dot(normal);
        if incident.z <= 0.0 || outgoing.z <= 0.0 || cosine <= 0.0 {
            continue;
        }
        if is_blocked(scene, x, towards, f64::INFINITY) || is_blocked(scene, x, direction, distance) {
            continue;
        }
        sum += s.evaluate(outgoing, incident) * incident.z * sun.solid_angle() * outgoing.z * cosine / (distance * distance);
    }
    sum * w.area() / (n * n / 2) as f64
}

#[test]
fn all_kinds_of_data_agree_with_the_definition() {
    let Some(device) = Device::for_tests("sun through panes") else { return };
    let (scene, w) = room();
    let trees = |rank, log2| Block::Tree(resample::to_tree(&klems(KlemsBasis::Half), rank, log2, 0.02).unwrap());
    let options = PaneOptions { cells: 1024, ..PaneOptions::default() };
    for (name, s) in [
        ("Klems", scattering(klems(KlemsBasis::Full))),
        ("rank 4", scattering(trees(4, 3))),
        ("rank 3", scattering(trees(3, 4))),
        ("by reciprocity", {
            let blocks = Blocks { transmission_back: Some(trees(3, 4)), ..Blocks::default() };
            Scattering::of_blocks(&blocks).unwrap()
        }),
    ] {
        let panes = [(w.clone(), PaneBsdf::Bsdf(s.clone()))];
        let found = compute(&device, &scene, &panes, &sensors(), &suns(), &options, &Silent).unwrap();
        for (i, sensor) in sensors().iter().enumerate() {
            for (j, sun) in suns().iter().enumerate() {
                let wanted = reference(&scene, &w, &s, sensor, sun, 160);
                let value = f64::from(found.total.at(i, j)[0]);
                let error = f64::from(found.standard_error.at(i, j)[0]);
                assert!((value - wanted).abs() <= 4.0 * error + 0.012 * wanted, "{name} {i} {j}: {value} ± {error}, {wanted}");
                assert!(wanted == 0.0 || error < 0.05 * wanted, "{name}: {error} of {wanted}");
                assert_eq!((value > 0.0), j != 3, "the sun behind the house brings nothing");
            }
        }
    }
}

#[test]
fn a_small_even_pane_and_a_clear_one_have_their_analytic_values() {
    let Some(device) = Device::for_tests("sun through panes") else { return };
    let scene = Scene::default();
    let half = 0.005;
    let small =
        window([[-half, 0.0, -half], [half, 0.0, -half], [half, 0.0, half], [-half, 0.0, half]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    let s = sensor([0.4, 2.0, -1.0], [0.0, -1.0, 0.0]);
    let to = s.position.length();
    let light = sun(0.2, -0.8, 0.5);
    let cosine = -light.direction.y;
    let trans =
        MaterialKind::Trans { color: [0.8, 0.6, 0.4], specularity: 0.0, roughness: 0.0, transmissivity: 0.5, transmitted_specularity: 0.0 };
    let even = PaneBsdf::of_material(&trans).unwrap();
    let found = compute(&device, &scene, &[(small, even)], &[s], &[light], &PaneOptions::default(), &Silent).unwrap();
    for (c, colour) in [0.8, 0.6, 0.4].into_iter().enumerate() {
        let wanted = colour * 0.5 / PI * cosine * light.solid_angle() * (2.0 * half).powi(2) * (2.0 / to).powi(2) / (to * to);
        let value = f64::from(found.total.at(0, 0)[c]);
        assert!((value / wanted - 1.0).abs() < 1e-3, "{value} {wanted}");
    }
    // The sun through glass, void and the clear part of trans, straight and not at all.
    let (_, w) = room();
    let s = sensor([0.0, 1.0, 0.75], [0.0, 0.0, 1.0]);
    let seen = Sun::new(DVec3::new(0.1, -1.0, 0.75));
    let missed = Sun::new(DVec3::new(0.1, -1.0, 3.0));
    let glass = MaterialKind::Glass { transmissivity: [0.96, 0.5, 0.96], refraction_index: 1.52 };
    let incidence = seen.direction.y.abs();
    let (pane, _) = crate::kernels::trace::reference::glass_pane([0.96, 0.5, 0.96], 1.52, incidence);
    let clear =
        MaterialKind::Trans { transmitted_specularity: 1.0, color: [1.0; 3], specularity: 0.0, roughness: 0.0, transmissivity: 0.3 };
    for (material, wanted) in [(glass, pane), (MaterialKind::Void, [1.0; 3]), (clear, [0.3; 3])] {
        let bsdf = PaneBsdf::of_material(&material).unwrap();
        let found =
            compute(&device, &Scene::default(), &[(w.clone(), bsdf)], &[s], &[seen, missed], &PaneOptions::default(), &Silent).unwrap();
        for (c, wanted) in wanted.into_iter().enumerate() {
            let full = wanted * seen.direction.z * seen.solid_angle();
            let value = f64::from(found.total.at(0, 0)[c]);
            assert!((value / full - 1.0).abs() < 1e-4, "{material:?}: {value} {full}");
            assert_eq!(found.total.at(0, 1)[c], 0.0);
            assert_eq!(found.total.at(0, 0)[c], found.clear.at(0, 0)[c]);
        }
    }
    let rough =
        MaterialKind::Trans { roughness: 0.1, transmitted_specularity: 0.5, color: [1.0; 3], specularity: 0.0, transmissivity: 0.3 };
    assert!(PaneBsdf::of_material(&rough).unwrap_err().to_string().contains("BSDF"));
    assert!(PaneBsdf::of_material(&MaterialKind::Mirror { color: [1.0; 3] }).is_err());
}

#[test]
fn cells_crossed_by_the_edge_of_a_shadow_bring_no_bias() {
    let Some(device) = Device::for_tests("sun through panes") else { return };
    let (_, w) = room();
    // A shelf outside shades all but the lowest part of the window, which the sensor sees from near.
    let mut b = Builder::default();
    let black = b.grey(0.0);
    b.quad([[-2.0, -0.65, 2.0], [2.0, -0.65, 2.0], [2.0, 0.0, 2.0], [-2.0, 0.0, 2.0]], black);
    let panes = [(w, PaneBsdf::Bsdf(scattering(Block::Tree(TensorTree::constant(4, 0.1)))))];
    let near = [sensor([0.3, 0.15, 0.95], [0.0, 0.0, 1.0])];
    let suns = [sun(0.1, -0.6, 0.75)];
    let scene = b.scene;
    let sums = |cells: u32, seeds: u32| {
        let one = |seed| {
            let options = PaneOptions { cells, seed, batches: 32, ..PaneOptions::default() };
            let found = compute(&device, &scene, &panes, &near, &suns, &options, &Silent).unwrap();
            (0..suns.len()).map(|column| sum(&found.total, column)).sum::<f64>()
        };
        mean_and_error(&(1..=seeds).map(one).collect::<Vec<_>>())
    };
    let ([coarse, coarse_error], [fine, fine_error]) = (sums(32, 100).into(), sums(1024, 6).into());
    let error: f64 = f64::hypot(coarse_error, fine_error);
    println!("few cells / many {:.4} ± {:.4}", coarse / fine, error / fine);
    assert!(error < 0.006 * fine && (coarse - fine).abs() < 5.0 * error, "{coarse} {fine} ± {error}");
}

/// 0.1 diffuse and 0.6 straight through, on 32 cells per side.
pub(crate) fn peaked() -> Scattering {
    let n = 32usize;
    let grid: Vec<f32> =
        (0..n.pow(4)).map(|k| (0.1 / PI + if k / (n * n) == k % (n * n) { 0.6 * (n * n) as f64 / PI } else { 0.0 }) as f32).collect();
    scattering(Block::Tree(TensorTree::from_grid(4, 5, &grid, 0.0)))
}

#[test]
fn the_peak_of_an_absdf_is_a_clear_view_and_is_not_counted_twice() {
    let Some(device) = Device::for_tests("sun through panes") else { return };
    let (_, w) = room();
    let s = sensor([0.0, 1.0, 0.75], [0.0, 0.0, 1.0]);
    let seen = Sun::new(DVec3::new(0.1, -1.0, 0.75));
    let run = |bsdf: PaneBsdf| {
        compute(&device, &Scene::default(), &[(w.clone(), bsdf)], &[s], &[seen], &PaneOptions::default(), &Silent).unwrap()
    };
    let clear = f64::from(run(PaneBsdf::PeakBsdf(peaked())).clear.at(0, 0)[0]);
    let peak = peaked().peak(-w.frame.to_local(seen.direction)).unwrap();
    let full = seen.direction.z * seen.solid_angle();
    assert!((clear / full - peak.transmittance).abs() < 1e-4 && (peak.transmittance - 0.6).abs() < 1e-4);
    // What is left is the diffuse tenth, the same as without any peak.
    let whole = f64::from(run(PaneBsdf::PeakBsdf(peaked())).total.at(0, 0)[0]);
    let even = f64::from(run(PaneBsdf::Bsdf(scattering(Block::Tree(TensorTree::constant(4, 0.1 / PI))))).total.at(0, 0)[0]);
    assert!((whole - clear - even).abs() < 1e-3 * even, "{} {even}", whole - clear);
}

#[test]
fn tiles_make_no_difference_and_work_can_be_stopped() {
    struct Stop;
    impl Progress for Stop {
        fn update(&self, _: &str, _: f64) {}
        fn stop_requested(&self) -> bool {
            true
        }
    }
    let Some(device) = Device::for_tests("sun through panes") else { return };
    let (scene, w) = room();
    let panes = [(w, PaneBsdf::PeakBsdf(peaked()))];
    let options = PaneOptions { cells: 64, ..PaneOptions::default() };
    let whole = compute(&device, &scene, &panes, &sensors(), &suns(), &options, &Silent).unwrap();
    let small = PaneOptions { memory: 3 * 64 * 8 * 32, ..options };
    let tiled = compute(&device, &scene, &panes, &sensors(), &suns(), &small, &Silent).unwrap();
    assert_eq!((&whole.total, &whole.standard_error), (&tiled.total, &tiled.standard_error));
    assert!(compute(&device, &scene, &panes, &sensors(), &suns(), &options, &Stop).is_err());
    let none = compute(&device, &scene, &panes, &[], &suns(), &options, &Silent).unwrap();
    assert_eq!(none.total.rows(), 0);
    let nowhere = sensor([f64::NAN, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert!(compute(&device, &scene, &panes, &[nowhere], &suns(), &options, &Silent).is_err());
}

/// Many cells are traced in several dispatches: more than a device takes along an axis, and with the same bits.
#[test]
fn there_may_be_more_cells_than_workgroups_along_an_axis() {
    let Some(device) = Device::for_tests("sun through panes") else { return };
    let (scene, w) = room();
    let even = scattering(Block::Tree(TensorTree::constant(4, 0.1)));
    let panes = [(w, PaneBsdf::Bsdf(even.clone()))];
    let run = |cells: u32, most: u32| {
        let options = PaneOptions { cells, batches: 2, part_angle: 1.0, ..PaneOptions::default() };
        let mut tracer = PaneTracer::new(&device, &scene, &panes, &suns(), &options).unwrap();
        tracer.most_cells = most;
        let mut result = tracer.empty(sensors().len(), suns().len());
        let records: Vec<Receiver> = sensors().iter().enumerate().map(|(i, s)| tracer.receiver(i, s)).collect();
        tracer.run(&records, &mut result, &Silent).map(|()| result)
    };
    let limit = device.limits().max_compute_workgroups_per_dimension;
    let few = run(512, u32::MAX).unwrap();
    let cut = run(512, 100).unwrap();
    assert_eq!((&few.total, &few.standard_error), (&cut.total, &cut.standard_error));
    assert!(few.total.data().iter().any(|v| *v > 0.0));
    // A device without such a limit would take millions; there is nothing to find then.
    if limit <= 65_535 {
        let many = run(limit / 2 + 100, u32::MAX).unwrap();
        for (i, sensor) in sensors().iter().enumerate() {
            for (j, sun) in suns().iter().enumerate() {
                let wanted = reference(&scene, &panes[0].0, &even, sensor, sun, 160);
                let value = f64::from(many.total.at(i, j)[0]);
                assert!((value - wanted).abs() <= 0.012 * wanted, "{i} {j}: {value}, {wanted}");
            }
        }
    }
}

#[test]
fn an_absdf_without_a_peak_is_a_plain_bsdf_with_a_warning() {
    let mut warnings = Warnings::new();
    assert!(matches!(PaneBsdf::with_peak(peaked(), "tree.xml", &mut warnings), PaneBsdf::PeakBsdf(_)) && warnings.is_empty());
    let even = scattering(Block::Tree(TensorTree::constant(4, 0.1)));
    assert!(matches!(PaneBsdf::with_peak(even, "tree.xml", &mut warnings), PaneBsdf::Bsdf(_)));
    let text = warnings.iter().next().unwrap().to_string();
    assert!(text.contains("tree.xml") && text.contains("no through-peak"), "{text}");
}

#[test]
fn the_facade_shows_what_receivers_gather() {
    let Some(device) = Device::for_tests("sun through panes") else { return };
    let (scene, w) = room();
    let s = scattering(klems(KlemsBasis::Full));
    let panes = [(w.clone(), PaneBsdf::Bsdf(s.clone()))];
    let points: Vec<FacadeView> = [(-0.7, 1.2), (0.1, 1.6), (0.9, 1.9), (0.35, 1.1)]
        .into_iter()
        .map(|(x, z)| {
            let position = DVec3::new(x, 0.0, z);
            FacadeView { position, window: 0, towards_eye: DVec3::new(0.2, 3.0, 1.2) - position }
        })
        .collect();
    let suns: Vec<Sun> = suns().into_iter().map(Sun::as_point).collect();
    let found = facade(&device, &scene, &panes, &points, &suns, &PaneOptions::default(), &Silent).unwrap();
    let mut lit = 0;
    for (i, p) in points.iter().enumerate() {
        for (j, sun) in suns.iter().enumerate() {
            let incident = -w.frame.to_local(sun.direction);
            let free = incident.z > 0.0 && !is_blocked(&scene, p.position, sun.direction, f64::INFINITY);
            let f = s.evaluate(w.frame.to_local(p.towards_eye.normalize()), incident);
            let wanted = if free { f * incident.z * sun.solid_angle() } else { 0.0 };
            let value = f64::from(found.total.at(i, j)[0]);
            assert!((value - wanted).abs() <= 1e-4 * wanted, "{i} {j}: {value} {wanted}");
            lit += usize::from(free);
        }
    }
    assert!((6..16).contains(&lit), "{lit} of 20 are lit");
    let wrong = FacadeView { window: 1, ..points[0] };
    assert!(facade(&device, &scene, &panes, &[wrong], &suns, &PaneOptions::default(), &Silent).is_err());
}

/// The tutorial's room and its window.
pub(crate) fn tutorial(folder: &std::path::Path) -> (Scene, Window, Vec<Sensor>) {
    let mut warnings = Warnings::new();
    let files = ["materials.rad", "room.rad"].map(std::path::PathBuf::from);
    let scene = crate::scene::read_scene(&files, folder, &mut warnings).unwrap();
    let window = crate::scene::read_windows("objects/GlazingVmtx.rad".as_ref(), folder, &mut warnings).unwrap().remove(0);
    let sensors = crate::scene::read_sensors(&folder.join("points.txt"), None, &mut warnings).unwrap();
    (scene, window, sensors)
}

/// The suns of the reference data.
pub(crate) fn reference_suns(shared: &std::path::Path) -> Vec<Sun> {
    let text = std::fs::read_to_string(shared.join("data/reference/fivephase/suns_sel.rad")).unwrap();
    let number = |w: &str| w.parse::<f64>().unwrap();
    let line = |l: &str| {
        let words: Vec<&str> = l.split_whitespace().collect();
        sun(number(words[6]), number(words[7]), number(words[8]))
    };
    text.lines().filter(|l| l.contains(" source ")).map(line).collect()
}

fn sum(m: &Matrix<f32>, column: usize) -> f64 {
    sum_of(m, column, &(0..m.rows()).collect::<Vec<_>>())
}

fn sum_of(m: &Matrix<f32>, column: usize, rows: &[usize]) -> f64 {
    rows.iter().map(|&r| f64::from(m.at(r, column)[0])).sum()
}

/// The tutorial's window cut into equal parts, `columns` × `rows`.
fn parts(w: &Window, columns: usize, rows: usize) -> Vec<Window> {
    let corner = w.triangles[0][0];
    let [low, high] = w.triangles.iter().flatten().fold([corner; 2], |[low, high], p| [low.min(*p), high.max(*p)]);
    let at = |i: usize, k: usize| {
        let share = DVec3::new(i as f64 / columns as f64, 0.0, k as f64 / rows as f64);
        (low + (high - low) * share).to_array()
    };
    let part = |n: usize| {
        let (i, k) = (n % columns, n / columns);
        let quad = [at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)];
        Window { basis: w.basis.clone(), frame: w.frame, ..window(quad, w.frame.z, DVec3::Z, KlemsBasis::Full) }
    };
    (0..columns * rows).map(part).collect()
}

/// Vd·T·Dd of patches of a sky of MF:1, summed over the sensors; V and D are sampled for each part of the
/// window on its own.
fn three_phase(device: &Device, scene: &Scene, windows: &[Window], t: &Matrix<f64>, sensors: &[Sensor], patches: &[usize]) -> Vec<f64> {
    // As many rays for any number of parts.
    let few = |all: u32| (all / windows.len() as u32).max(16);
    let straight =
        ViewOptions { bounces: Some(1), direct_samples: few(1 << 17), near_samples: 1, light_paths: 1, ..ViewOptions::default() };
    let v = view_matrix::compute(device, scene, windows, sensors, &straight, &Silent).unwrap().direct;
    let mut sums = vec![0.0; patches.len()];
    for (k, part) in windows.iter().enumerate() {
        let paths = DaylightOptions { bounces: Some(0), paths: few(1 << 14), seed: k as u32, ..DaylightOptions::default() };
        let d = daylight_matrix::compute(device, scene, part, ReinhartSky::new(1).unwrap(), &paths, &Silent).unwrap().direct;
        for (sum, patch) in sums.iter_mut().zip(patches) {
            for o in 0..145 {
                let through: f64 = (0..145).map(|i| t.at(o, i)[0] * f64::from(d.at(i, *patch)[0])).sum();
                *sum += through * (0..sensors.len()).map(|r| f64::from(v.at(r, k * 145 + o)[0])).sum::<f64>();
            }
        }
    }
    sums
}

/// V and D average over the window separately, and its deep reveal shades parts of it: 2 % for the window as a
/// whole (5 % with a pane that scatters evenly). It is the jambs that matter: a low or oblique sun leaves a
/// strip along one of them, and where that is all that lights a sensor, 2 columns of parts (and 24 rows) miss
/// it by 10 %, 8 by 7 %, 16 by 3 %. With 32 every patch agrees within what is noise.
#[test]
fn suns_that_fill_a_patch_give_the_three_phase_direct_part_of_a_klems_pane() {
    const SIDE: usize = 8;
    let (Some(device), Some(shared)) = (Device::for_tests("sun through panes"), testing::shared()) else { return };
    let folder = shared.join("data/tutorial_room");
    let (scene, w, sensors) = tutorial(&folder);
    // Every third sensor: 34 from the window to the back.
    let rows: Vec<usize> = (0..sensors.len()).step_by(3).collect();
    let sensors: Vec<Sensor> = rows.iter().map(|r| sensors[*r]).collect();
    let bsdf = read(&folder.join("bsdf/blinds_correct_klems.xml"), &mut Warnings::new()).unwrap();
    let t = transmission_matrix(&bsdf).unwrap();
    let theirs = read_matrix(&shared.join("data/reference/fivephase/CdsSelV_K.mtx")).unwrap().matrix;
    let sky = ReinhartSky::new(1).unwrap();
    let centres = reference_suns(&shared);
    let patches: Vec<usize> = centres.iter().map(|sun| sky.bin_of(sun.direction)).collect();
    let whole = three_phase(&device, &scene, std::slice::from_ref(&w), &t, &sensors, &patches);
    let in_parts = three_phase(&device, &scene, &parts(&w, 32, 12), &t, &sensors, &patches);
    let panes = [(w, PaneBsdf::Bsdf(Scattering::new(&bsdf).unwrap()))];
    let single = compute(&device, &scene, &panes, &sensors, &centres, &PaneOptions::default(), &Silent).unwrap();
    const SINGLE: f64 = 0.03;
    const TOGETHER: f64 = 0.01;
    let mut ratios = Vec::new();
    let mut sums = [0.0; 5];
    for (column, (sun, &patch)) in centres.iter().zip(&patches).enumerate() {
        let suns: Vec<Sun> = (0..SIDE * SIDE)
            .map(|k| {
                let at = |i: usize| (i as f64 + 0.5) / SIDE as f64;
                Sun::new(sky.direction(patch, at(k / SIDE), at(k % SIDE)))
            })
            .collect();
        assert!(suns.iter().all(|s| sky.bin_of(s.direction) == patch));
        let options = PaneOptions { seed: column as u32, ..PaneOptions::default() };
        let found = compute(&device, &scene, &panes, &sensors, &suns, &options, &Silent).unwrap();
        let ours = (0..suns.len()).map(|c| sum(&found.total, c)).sum::<f64>() / suns.len() as f64;
        let share = sun.solid_angle() / sky.solid_angle(patch);
        let [one, their] = [sum(&single.total, column), sum_of(&theirs, column, &rows)];
        let values = [ours, in_parts[column] * share, whole[column] * share, one, their];
        println!("sun {column}, patch {patch}: of Vd·T·Dd {:.4}; by parts of the window {:.4}", ours / values[2], ours / values[1]);
        sums = std::array::from_fn(|k| sums[k] + values[k]);
        assert!((ours / values[1] - 1.0).abs() < SINGLE, "patch {patch}: {values:?}");
        ratios.push(ours / values[1]);
    }
    let [ours, in_parts, whole, single, theirs] = sums;
    println!(
        "all: of Vd·T·Dd {:.4}, by parts {:.4}; single suns {:.3}, Radiance's {:.3}",
        ours / whole,
        ours / in_parts,
        single / whole,
        theirs / whole
    );
    assert!((ours / in_parts - 1.0).abs() < TOGETHER && (ours / whole - 1.0).abs() < 0.04, "{sums:?}");
    ratios.sort_by(f64::total_cmp);
    let found = format!("single patches {:.3}…{:.3}, together {:.3}", ratios[0], ratios[ratios.len() - 1], ours / in_parts);
    testing::measured("filled-patches", &found, &format!("{}; {}", testing::percent(SINGLE), testing::percent(TOGETHER)));
}

/// Independent repetitions, here and in `rcontrib`, whose spread is the error.
const REPEATS: usize = 12;

/// Writes the tutorial's room with the pane as a BSDF and the suns into `folder`: `room.oct`, `suns.mod`.
pub(crate) fn octree(shared: &std::path::Path, folder: &std::path::Path, room: [&str; 2], bsdf: &Bsdf, suns: &[Sun]) -> Option<()> {
    let data = shared.join("data");
    let file = |name: &str| folder.join(name);
    write(Some(&file("pane.xml")), bsdf, "").unwrap();
    let glazing = std::fs::read_to_string(data.join("reference/fivephase/GlazingT4.rad")).unwrap();
    let glazing = glazing.replace("../../tutorial_room/bsdf/blinds_correct_t4.xml", file("pane.xml").to_str().unwrap());
    std::fs::write(file("pane.rad"), glazing).unwrap();
    let (mut lights, mut names) = (String::new(), String::new());
    for (i, s) in suns.iter().enumerate() {
        let d = s.direction;
        lights += &format!("void light sol{i} 0 0 3 1e6 1e6 1e6\nsol{i} source sun{i} 0 0 4 {} {} {} .533\n", d.x, d.y, d.z);
        names += &format!("sol{i}\n");
    }
    std::fs::write(file("suns.rad"), lights).unwrap();
    std::fs::write(file("suns.mod"), names).unwrap();
    let mut oconv = testing::radiance("oconv")?;
    oconv.current_dir(data.join("tutorial_room")).arg("-f").args(room).arg(file("pane.rad")).arg(file("suns.rad"));
    std::fs::write(file("room.oct"), testing::output(&mut oconv)).unwrap();
    Some(())
}

/// What `rcontrib` finds for lines of `rays` in a room of [`octree`], RGB per unit radiance of the suns,
/// `[ray][sun][rgb]`. Its direct calculation without blurring (`-ss 0`), suns as points.
pub(crate) fn rcontrib_of(folder: &std::path::Path, rays: &str, options: &[&str], divisions: usize) -> Option<Vec<f64>> {
    let file = |name: &str| folder.join(name);
    std::fs::write(file("points"), rays).unwrap();
    let mut command = testing::radiance("rcontrib")?;
    command.args(["-h", "-V+", "-ab", "1", "-lw", "1e-8", "-dc", "1", "-dt", "0", "-dj", "0", "-st", "1", "-ss", "0"]);
    command.args(options).args(["-ad", &divisions.to_string(), "-M"]).arg(file("suns.mod")).arg(file("room.oct"));
    command.stdin(std::fs::File::open(file("points")).unwrap());
    let text = String::from_utf8(testing::output(&mut command)).unwrap();
    Some(text.split_whitespace().map(|w| w.parse::<f64>().unwrap() / 1e6).collect())
}

/// Sensors in the black room: `[repeat][sensor][sun]`.
fn rcontrib(shared: &std::path::Path, bsdf: &Bsdf, sensors: &[Sensor], suns: &[Sun], divisions: usize) -> Option<Vec<Vec<f64>>> {
    let folder = tempfile::tempdir().unwrap();
    octree(shared, folder.path(), ["materialBlack.rad", "roomBlack.rad"], bsdf, suns)?;
    let line = |s: &Sensor| {
        let (p, d) = (s.position, s.direction);
        format!("{} {} {} {} {} {}\n", p.x, p.y, p.z, d.x, d.y, d.z).repeat(REPEATS)
    };
    let values = rcontrib_of(folder.path(), &sensors.iter().map(line).collect::<String>(), &["-I+"], divisions)?;
    assert_eq!(values.len(), sensors.len() * REPEATS * suns.len() * 3);
    let cell = |repeat: usize, k: usize| values[((k / suns.len() * REPEATS + repeat) * suns.len() + k % suns.len()) * 3];
    Some((0..REPEATS).map(|r| (0..sensors.len() * suns.len()).map(|k| cell(r, k)).collect()).collect())
}

/// Errors of different suns go together, for the same rays serve all of them: only repetitions tell the error of a sum.
#[test]
fn panes_of_either_kind_agree_with_rcontrib() {
    // Suns and sensors of which Radiance knows no more than this are not judged one by one.
    const SURE: f64 = 0.02;
    let (Some(device), Some(shared)) = (Device::for_tests("sun through panes"), testing::shared()) else { return };
    let (scene, w, sensors) = tutorial(&shared.join("data/tutorial_room"));
    let sensors: Vec<Sensor> = sensors.into_iter().step_by(9).collect();
    let suns = reference_suns(&shared);
    for name in ["blinds_correct_klems.xml", "blinds_correct_t4.xml"] {
        let mut bsdf = read(&shared.join("data/tutorial_room/bsdf").join(name), &mut Warnings::new()).unwrap();
        // One transmission only, so that there is no choice between two that differ.
        bsdf.visible.transmission_back = None;
        bsdf.solar = Blocks::default();
        let Some(theirs) = rcontrib(&shared, &bsdf, &sensors, &suns, 16384) else { return };
        let panes = [(w.clone(), PaneBsdf::Bsdf(Scattering::new(&bsdf).unwrap()))];
        let ours: Vec<Vec<f64>> = (1..=REPEATS as u32)
            .map(|seed| {
                let options = PaneOptions { seed, ..PaneOptions::default() };
                let found = compute(&device, &scene, &panes, &sensors, &suns, &options, &Silent).unwrap();
                (0..sensors.len() * suns.len()).map(|k| f64::from(found.total.at(k / suns.len(), k % suns.len())[0])).collect()
            })
            .collect();
        // Distance in standard errors (of 12 repetitions each: Student's t of some 20 degrees of freedom).
        let distance = |what: &str, most: f64, take: &dyn Fn(usize) -> bool| {
            let sums = |of: &[Vec<f64>]| {
                let sum = |cells: &Vec<f64>| cells.iter().enumerate().filter(|(k, _)| take(*k)).map(|(_, v)| v).sum::<f64>();
                mean_and_error(&of.iter().map(sum).collect::<Vec<_>>())
            };
            let ([own, own_error], [their, their_error]) = (sums(&ours).into(), sums(&theirs).into());
            // Radiance moves its rays' origins and directions a little.
            let error = own_error.hypot(their_error).hypot(5e-4 * their);
            println!("{name}, {what}: ours / rcontrib {:.4} ± {:.4}", own / their, error / their);
            // A few of Radiance's rays meet a narrow peak, and where they all miss it their spread tells nothing:
            // one sensor came out as 1.07 ± 0.32 once and as 1.56 ± 0.08 another time.
            if error < most * their { (own - their).abs() / error } else { 0.0 }
        };
        assert!(distance("all", f64::INFINITY, &|_| true) < 6.0);
        for column in 0..suns.len() {
            assert!(distance(&format!("sun {column}"), SURE, &|k| k % suns.len() == column) < 7.0);
        }
        for row in 0..sensors.len() {
            assert!(distance(&format!("sensor {row}"), SURE, &|k| k / suns.len() == row) < 7.0);
        }
    }
}

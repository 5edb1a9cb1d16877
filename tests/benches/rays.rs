//! Path segments per CPU-second: the daylight matrix of a window behind a venetian blind (WGSL, all it
//! does included) beside a native tracer that only finds hits (the obvhs crate's own traversal of the
//! same kind of hierarchy, on all cores) for paths of the same kind, in one run.
//!
//! `cargo bench --bench rays [-- PATHS]`

#[path = "record.rs"]
mod record;

use glam::{DVec3, Vec3A};
use lucarne::Warnings;
use lucarne::bins::ReinhartSky;
use lucarne::gpu::Device;
use lucarne::kernels::daylight_matrix::{self, DaylightOptions};
use lucarne::progress::Silent;
use lucarne::scene::{Scene, Window, read_scene, read_windows};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use std::path::Path;
use std::time::{Duration, Instant};

const BOUNCES: u32 = 4;

fn cpu_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
}

/// What a run of so many segments took: segments per CPU-second and per second.
fn rates(run: impl FnOnce() -> u64) -> (f64, f64) {
    let (cpu, start) = (cpu_seconds(), Instant::now());
    let segments = run() as f64;
    let wall = start.elapsed().as_secs_f64();
    let cpu = cpu_seconds().zip(cpu).map_or(wall, |(after, before)| after - before);
    (segments / cpu.max(0.01), segments / wall)
}

/// Reproducible numbers in 0…1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A direction about `normal` with the density of the cosine.
    fn cosine(&mut self, normal: DVec3) -> DVec3 {
        let (radius, angle) = (self.next().sqrt(), std::f64::consts::TAU * self.next());
        let x = normal.any_orthonormal_vector();
        x * (radius * angle.cos()) + normal.cross(x) * (radius * angle.sin()) + normal * (1.0 - radius * radius).max(0.0).sqrt()
    }
}

/// Segments of one path from the window into the open.
fn path(bvh: &CwBvh, triangles: &[Triangle], window: &Window, random: &mut Random) -> u64 {
    let [a, b, c] = window.triangles[(random.next() * window.triangles.len() as f64) as usize];
    let (u, v) = (random.next().sqrt(), random.next());
    let mut at = a * (1.0 - u) + b * (u * (1.0 - v)) + c * (u * v);
    let mut direction = random.cosine(-window.frame.z);
    for segment in 0..=BOUNCES {
        let ray = Ray::new(at.as_vec3a(), direction.as_vec3a(), 0.0, f32::INFINITY);
        let mut hit = RayHit::none();
        let intersect = |ray: &Ray, id: usize| triangles[bvh.primitive_indices[id] as usize].intersect(ray);
        if !bvh.ray_traverse(ray, &mut hit, intersect) {
            return u64::from(segment) + 1;
        }
        let normal = triangles[bvh.primitive_indices[hit.primitive_id as usize] as usize].compute_normal().as_dvec3().normalize();
        let facing = if normal.dot(direction) < 0.0 { normal } else { -normal };
        at = at + direction * f64::from(hit.t) + facing * 1e-5;
        direction = random.cosine(facing);
    }
    u64::from(BOUNCES) + 1
}

fn native(scene: &Scene, window: &Window, paths: u64) -> u64 {
    let corner = |p: DVec3| Vec3A::from(p.as_vec3());
    let triangles: Vec<Triangle> = scene
        .triangles
        .iter()
        .map(|t| Triangle { v0: corner(t.vertices[0]), v1: corner(t.vertices[1]), v2: corner(t.vertices[2]) })
        .collect();
    let bvh = obvhs::cwbvh::builder::build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
    const CHUNK: u64 = 4096;
    (0..paths.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut random = Random(chunk * 7919 + 1);
            (0..CHUNK).map(|_| path(&bvh, &triangles, window, &mut random)).sum::<u64>()
        })
        .sum()
}

fn main() -> lucarne::Result<()> {
    let wanted: u64 = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(4_000_000);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/blinds");
    let mut warnings = Warnings::new();
    let scene = read_scene(&["room.rad".into(), "blinds.rad".into()], &folder, &mut warnings)?;
    let window = read_windows(Path::new("window.rad"), &folder, &mut warnings)?.remove(0);
    let device = Device::open(None)?;
    let batches = 8;
    let paths = (wanted / u64::from(batches) / window.basis.len() as u64).max(64) as u32;
    let options = DaylightOptions { bounces: Some(BOUNCES), paths, batches, roulette_weight: 0.0, ..DaylightOptions::default() };
    let ours = || {
        daylight_matrix::compute(&device, &scene, &window, ReinhartSky::new(1).expect("MF:1"), &options, &Silent)
            .map(|d| d.statistics.segments)
    };
    ours()?;
    let mut result = Ok(0);
    let (cpu, wall) = rates(|| {
        result = ours();
        *result.as_ref().unwrap_or(&0)
    });
    result?;
    let (native_cpu, native_wall) = rates(|| native(&scene, &window, wanted));
    println!("{} triangles, {wanted} paths of up to {BOUNCES} reflections", scene.triangles.len());
    println!(
        "{:8.2} million segments per CPU-second, {:8.2} per second   daylight matrix on {}",
        cpu / 1e6,
        wall / 1e6,
        device.summary().name
    );
    println!("{:8.2} million segments per CPU-second, {:8.2} per second   native tracer, hits only", native_cpu / 1e6, native_wall / 1e6);
    let mut record = record::Record::new("rays");
    record.add("daylight matrix", cpu / 1e6, "Msegments/CPU-s");
    record.add("native tracer, hits only", native_cpu / 1e6, "Msegments/CPU-s");
    record.add("daylight matrix / native tracer", cpu / native_cpu, "ratio");
    let million = |rate: f64| record::short(rate / 1e6);
    record::measured("rays", &format!("{} million path segments per CPU-second", million(cpu)), "");
    record::measured("rays-native", &million(native_cpu), "");
    record.finish();
    Ok(())
}

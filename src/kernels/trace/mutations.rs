//! Tests of the tests: each fault put into a shader must make the comparison with the f64
//! references fail.

use super::comparison::agrees;
use super::reference::Estimate;
use super::rooms::{Builder, asymmetric, sensor, street};
use crate::bins::{KlemsBasis, ReinhartSky};
use crate::gpu::{Device, mutation};
use crate::kernels::daylight_matrix::reference::daylight_row;
use crate::kernels::daylight_matrix::{self, DaylightOptions};
use crate::kernels::view_matrix::reference::view_row;
use crate::kernels::view_matrix::{self, ViewOptions};
use crate::progress::Silent;
use crate::scene::points::Sensor;
use crate::scene::{MaterialKind, Scene, Window};
use rayon::prelude::*;

const SAMPLES: usize = 200_000;

/// A room with a mirror and a pane, and its reference.
struct View {
    scene: Scene,
    window: Window,
    sensors: Vec<Sensor>,
    rows: Vec<Vec<[Estimate; 3]>>,
}

impl View {
    fn new() -> Self {
        let (scene, window) = asymmetric();
        let mut b = Builder { scene };
        let mirror = b.material(MaterialKind::Mirror { color: [0.8, 0.7, 0.6] });
        let glass = b.material(MaterialKind::Glass { transmissivity: [0.8, 0.7, 0.6], refraction_index: 1.52 });
        b.quad([[3.9, 0.5, 2.5], [3.9, 2.5, 2.5], [3.9, 2.5, 0.5], [3.9, 0.5, 0.5]], mirror);
        b.quad([[0.2, 1.0, 0.3], [2.5, 1.0, 0.3], [2.5, 1.0, 2.7], [0.2, 1.0, 2.7]], glass);
        // Images of images, which no ray is aimed at.
        b.quad([[2.0, 0.2, 0.05], [3.9, 0.2, 0.05], [3.9, 3.0, 0.05], [2.0, 3.0, 0.05]], mirror);
        // Towards the mirror; with the window behind; and in a corner, all of its light nearby.
        let sensors = vec![
            sensor([2.5, 1.4, 1.0], [1.0, 0.0, 0.2]),
            sensor([1.5, 2.0, 1.0], [0.0, 1.0, 0.0]),
            sensor([3.9, 4.8, 0.2], [0.0, -0.2, 1.0]),
            sensor([1.2, 2.0, 0.1], [0.1, 0.0, 1.0]),
        ];
        let rows =
            sensors.par_iter().map(|s| view_row(&b.scene, std::slice::from_ref(&window), s.position, s.direction, 3, SAMPLES, 3)).collect();
        Self { scene: b.scene, window, sensors, rows }
    }

    fn compare(&self, device: &Device) -> Result<String, String> {
        let options = ViewOptions { bounces: Some(3), light_paths: 96, near_samples: 8192, near_radius: 2.0, ..ViewOptions::default() };
        let v = view_matrix::compute(device, &self.scene, std::slice::from_ref(&self.window), &self.sensors, &options, &Silent)
            .map_err(|e| e.to_string())?;
        self.rows.iter().enumerate().map(|(row, r)| agrees(&v, row, r, SAMPLES)).collect()
    }
}

/// A street and its reference.
struct Daylight {
    scene: Scene,
    window: Window,
    rows: Vec<(usize, Vec<[Estimate; 3]>)>,
}

impl Daylight {
    fn new() -> Self {
        let (scene, mut window) = street();
        window.basis = KlemsBasis::Quarter.into();
        let sky = ReinhartSky::new(1).unwrap();
        let rows = [0, 7, 18, 26, 30].into_par_iter().map(|bin| (bin, daylight_row(&scene, &window, bin, sky, 2, SAMPLES, 3))).collect();
        Self { scene, window, rows }
    }

    fn compare(&self, device: &Device) -> Result<String, String> {
        let options = DaylightOptions { bounces: Some(2), paths: 8192, ..DaylightOptions::default() };
        let sky = ReinhartSky::new(1).unwrap();
        let d = daylight_matrix::compute(device, &self.scene, &self.window, sky, &options, &Silent).map_err(|e| e.to_string())?;
        self.rows.iter().map(|(bin, r)| agrees(&d, *bin, r, SAMPLES)).collect()
    }
}

/// File, text, and the fault put in its place.
const VIEW_FAULTS: &[(&str, &str, &str)] = &[
    ("light_paths/paths", "let flux = window.area *", "let flux = 1.5 * window.area *"),
    ("shared/window", "ring.cos2_low - ring.cos2_high", "ring.cos2_low + ring.cos2_high"),
    ("light_paths/paths", "path.flux /= survival;", ""),
    ("light_paths/compact", "light.strength > 0.0 &&", "light.strength > 0.05 &&"),
    ("light_paths/compact", "lights[row * params.room + kept]", "lights[row * params.room]"),
    ("shared/connection", "let cos_light = -dot(", "let cos_light = dot("),
    ("shared/connection", "distance2 * max(distance2, near2)", "distance2 * distance2"),
    ("view_matrix/gather", "arrived * weight", "arrived.zyx * weight"),
    ("shared/gathering", "passed * light.flux / light.strength", "passed * light.flux"),
    ("view_matrix/gather", "* FRAC_1_PI", "* 0.35"),
    ("shared/gathering", "distance * 0.999999", "distance * 1.5"),
    ("view_matrix/direct", "let value = passed * share + dither;", "let value = passed * passed * share + dither;"),
    ("light_paths/near", "1.0 - ratio * ratio", "1.0 - ratio"),
    ("light_paths/near", "specular_before = true;", "specular_before = false;"),
    ("light_paths/near", "specular_before && !imaged && front", "specular_before && front"),
    ("light_paths/images", "passed * parts[1] *", "passed * parts[1].zyx *"),
    ("shared/window", "sqrt(max(1.0 - z * z, 0.0))", "max(1.0 - z * z, 0.0)"),
    ("shared/bins", "azimuth / TAU * f32(bins) + 0.5", "azimuth / TAU * f32(bins) + 1.0"),
    ("shared/material", "let mirrored = incoming + 2.0 * cosine * facing;", "let mirrored = incoming + 1.5 * cosine * facing;"),
];

const DAYLIGHT_FAULTS: &[(&str, &str, &str)] = &[
    ("daylight_matrix/paths", "let direction = -window_bin_direction", "let direction = window_bin_direction"),
    ("daylight_matrix/paths", "path_outside.weight);", "path_outside.weight.zyx);"),
    ("shared/outside", "bounces > outdoors.most_bounces", "bounces >= outdoors.most_bounces"),
    ("shared/outside", "weight *= event.weight;", "weight *= event.weight.zyx;"),
    ("shared/sky", "atan2(direction.x, direction.y)", "atan2(direction.y, direction.x)"),
    ("shared/sky", "direction.z >= sky_rows[row + 1u].sin_low", "direction.z >= sky_rows[row].sin_low"),
    ("shared/window", "f32(bin - r.first) + random.y - 0.5", "f32(bin - r.first) + random.y"),
    ("shared/material", "let radius = sqrt(random.x);", "let radius = random.x;"),
    ("shared/material", "let s = (cosine - index * inside)", "let s = (cosine - inside)"),
    ("shared/material", "exp(-FRESNEL_DECAY * cosine) - FRESNEL_GRAZING", "exp(-FRESNEL_DECAY * cosine) + 0.6"),
    ("shared/bvh", "(b - a) * shares.y", "(b - a) * shares.z"),
    ("shared/bvh", "select(n2.xyzw, n2.zwxy, inverse.x < 0.0)", "select(n2.xyzw, n2.zwxy, inverse.x > 0.0)"),
    ("shared/bvh", "let w = edge_area(b, a);", "let w = edge_area(a, b);"),
    ("shared/frame", "let b = n.x * n.y * a;", "let b = -n.x * n.y * a;"),
];

fn survivors(device: &Device, faults: &[(&str, &str, &str)], compare: &dyn Fn(&Device) -> Result<String, String>) -> Vec<String> {
    compare(device).unwrap_or_else(|e| panic!("without a fault: {e}"));
    let mut survivors = Vec::new();
    for (path, from, to) in faults {
        match mutation::with(path, from, to, || compare(device)) {
            Ok(found) => survivors.push(format!("{path}: '{from}' may be '{to}': {found}")),
            Err(found) => println!("{path}: '{to}' is found out: {found}"),
        }
    }
    survivors
}

#[test]
fn faults_in_the_shaders_of_the_view_matrix_are_found_out() {
    let Some(device) = Device::for_tests("faults in view matrix shaders") else { return };
    let view = View::new();
    let survivors = survivors(&device, VIEW_FAULTS, &|device| view.compare(device));
    assert!(survivors.is_empty(), "{}", survivors.join("\n"));
}

#[test]
fn faults_in_the_shaders_of_the_daylight_matrix_are_found_out() {
    let Some(device) = Device::for_tests("faults in daylight matrix shaders") else { return };
    let daylight = Daylight::new();
    let survivors = survivors(&device, DAYLIGHT_FAULTS, &|device| daylight.compare(device));
    assert!(survivors.is_empty(), "{}", survivors.join("\n"));
}

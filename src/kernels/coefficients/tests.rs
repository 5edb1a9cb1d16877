use super::*;
use crate::bins::KlemsBasis;
use crate::gpu::mutation;
use crate::kernels::coefficients::reference::coefficient_row;
use crate::kernels::trace::comparison::agrees;
use crate::kernels::trace::reference::Estimate;
use crate::kernels::trace::rooms::{Builder, sensor, window};
use crate::kernels::view_matrix::mean_and_error;
use crate::progress::Silent;
use crate::scene::{MaterialKind, Window};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

fn tregenza() -> ReinhartSky {
    ReinhartSky::new(1).unwrap()
}

/// Glass that absorbs nothing.
const CLEAR: Pane = Pane { transmissivity: [1.0; 3], refraction_index: 1.52 };

/// A unit cube with its south face a pane.
fn cube(reflectance: f64, pane: Pane) -> (Scene, GlazedWindow) {
    let mut b = Builder::default();
    let wall = b.grey(reflectance);
    b.room([0.0; 3], [1.0; 3], wall, &[2]);
    let south = window([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
    (b.scene, GlazedWindow { window: south, pane })
}

fn sum(row: &[f32]) -> f64 {
    row.iter().map(|v| f64::from(*v)).sum::<f64>() / 3.0
}

/// Sum of a sensor's row, and its standard error.
fn row_sum(c: &TracedMatrix, sensor: usize) -> (f64, f64) {
    mean_and_error(&c.batches.iter().map(|b| sum(b.total.row(sensor))).collect::<Vec<_>>())
}

#[test]
fn under_an_even_sky_everything_that_absorbs_nothing_gives_pi() {
    let Some(device) = Device::for_tests("furnace of the coefficients") else { return };
    let (scene, pane) = cube(1.0, CLEAR);
    let options = CoefficientOptions { keep_batches: true, ..CoefficientOptions::default() };
    let sensors =
        [sensor([0.5, 0.5, 1e-3], [0.0, 0.0, 1.0]), sensor([0.2, 0.95, 0.7], [0.3, -1.0, 0.2]), sensor([0.5, -0.4, 0.5], [0.0, 1.0, 0.0])];
    let c = compute(&device, &scene, &[pane], &sensors, tregenza(), &options, &Silent).unwrap();
    for row in 0..sensors.len() {
        let (found, error) = row_sum(&c, row);
        println!("sensor {row}: {found} ± {error}, {:.1e} from π", found - PI);
        assert!((found - PI).abs() < 4.0 * error + 1e-4 && error < 0.03 * PI, "{found} ± {error}");
    }
    // No window, nothing at all: each path brings its π, and each patch the cosine over it.
    let c = compute(&device, &Scene::default(), &[], &sensors[..1], tregenza(), &options, &Silent).unwrap();
    assert!((row_sum(&c, 0).0 - PI).abs() < 1e-5);
    assert_eq!(c.total, c.direct);
    let (sky, n) = (tregenza(), 40);
    let mut squares = 0.0;
    for patch in 1..sky.len() {
        let mean = (0..n * n)
            .map(|i| sky.direction(patch, (f64::from(i / n) + 0.5) / f64::from(n), (f64::from(i % n) + 0.5) / f64::from(n)).z)
            .sum::<f64>()
            / f64::from(n * n);
        // Batches may agree by their stratification; a path stands for π.
        let error = f64::from(c.standard_error.at(0, patch)[1]).hypot(PI / 4096.0);
        squares += ((f64::from(c.total.at(0, patch)[1]) - mean * sky.solid_angle(patch)) / error).powi(2) / 145.0;
    }
    assert!(squares < 1.8 && c.total.at(0, 0)[1] == 0.0, "mean z² {squares}");
}

/// Irradiance through a square pane that nothing hides, by the midpoint rule.
fn of_square(glazed: &GlazedWindow, eye: DVec3, normal: DVec3) -> [f64; 3] {
    let n = 1500;
    let [a, b, c] = glazed.window.triangles[0];
    let cell = (b - a).cross(c - b).length() / f64::from(n * n);
    let share = |i: i32| {
        let q = a + (b - a) * ((f64::from(i / n) + 0.5) / f64::from(n)) + (c - b) * ((f64::from(i % n) + 0.5) / f64::from(n)) - eye;
        let (to, d2) = (q.normalize(), q.length_squared());
        let cosine = -to.dot(glazed.window.frame.z);
        glazed.pane.transmittance(cosine).map(|t| t * to.dot(normal.normalize()).max(0.0) * cosine / d2 * cell)
    };
    (0..n * n).into_par_iter().map(share).reduce(|| [0.0; 3], |a, b| std::array::from_fn(|i| a[i] + b[i]))
}

#[test]
fn a_pane_in_a_black_room_gives_the_integral_of_its_transmittance() {
    let Some(device) = Device::for_tests("a pane in a black room") else { return };
    let pane = Pane { transmissivity: [0.9, 0.7, 0.5], refraction_index: 1.52 };
    let (scene, glazed) = cube(0.0, pane);
    let options = CoefficientOptions { keep_batches: true, ..CoefficientOptions::default() };
    for (position, normal) in
        [([0.4, 0.6, 0.1], [0.0, 0.0, 1.0]), ([0.7, 0.9, 0.5], [0.1, -1.0, 0.2]), ([0.3, 0.02, 0.4], [0.0, -1.0, 0.0])]
    {
        let s = sensor(position, normal);
        let c = compute(&device, &scene, std::slice::from_ref(&glazed), &[s], tregenza(), &options, &Silent).unwrap();
        assert_eq!(c.total, c.direct);
        let exact = of_square(&glazed, s.position, s.direction);
        for (channel, exact) in exact.into_iter().enumerate() {
            let of = |m: &Matrix<f32>| m.row(0).iter().skip(channel).step_by(3).map(|v| f64::from(*v)).sum::<f64>();
            let (found, error) = mean_and_error(&c.batches.iter().map(|b| of(&b.total)).collect::<Vec<_>>());
            println!("{position:?} channel {channel}: {found:.6} ± {error:.1e}, {exact:.6}");
            assert!((found - exact).abs() < 4.0 * error + 2e-5 * exact && error < 5e-3 * exact, "{found} ± {error}, not {exact}");
        }
    }
}

/// A room with a deep reveal to the south and a window to the west, a mirror inside, a pane as partition, before it ground, a
/// house, a mirror façade and a canopy; everything coloured and nothing symmetric. The west wall has a hole.
pub(super) struct House {
    pub scene: Scene,
    pub windows: Vec<GlazedWindow>,
    pub sensors: Vec<Sensor>,
}

fn opening(corners: [[f64; 3]; 4], normal: DVec3) -> Window {
    window(corners, normal, DVec3::Z, KlemsBasis::Quarter)
}

pub(super) fn house() -> House {
    build(true)
}

/// The same without a hole, and without what mirrors inside but the panes.
pub(super) fn closed_house() -> House {
    build(false)
}

fn build(open: bool) -> House {
    let mut b = Builder::default();
    let walls = b.grey(0.6);
    let plaster = b.material(MaterialKind::Plastic { color: [0.7, 0.6, 0.5], specularity: 0.05, roughness: 0.0 });
    let floor = b.material(MaterialKind::Plastic { color: [0.5, 0.3, 0.2], specularity: 0.0, roughness: 0.0 });
    let mirror = b.material(MaterialKind::Mirror { color: [0.8, 0.75, 0.7] });
    let glass = b.material(MaterialKind::Glass { transmissivity: [0.9, 0.8, 0.7], refraction_index: 1.52 });
    let trans = b.material(MaterialKind::Trans {
        color: [0.7, 0.7, 0.6],
        specularity: 0.04,
        roughness: 0.0,
        transmissivity: 0.5,
        transmitted_specularity: 0.3,
    });
    let ground = b.material(MaterialKind::Plastic { color: [0.4, 0.5, 0.3], specularity: 0.0, roughness: 0.0 });
    b.room([0.0, 0.0, 0.0], [4.0, 5.0, 3.0], walls, &[0, 2, 4]);
    b.quad([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 5.0, 0.0], [0.0, 5.0, 0.0]], floor);
    // South: x 0.5…2, z 1…2.5, inside and outside of the wall, and the reveal between.
    for y in [0.0, -0.4] {
        for (x0, x1, z0, z1) in [(-0.4, 4.4, 0.0, 1.0), (-0.4, 4.4, 2.5, 3.4), (-0.4, 0.5, 1.0, 2.5), (2.0, 4.4, 1.0, 2.5)] {
            b.quad([[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]], if y == 0.0 { walls } else { plaster });
        }
    }
    b.quad([[0.5, 0.0, 1.0], [0.5, -0.4, 1.0], [0.5, -0.4, 2.5], [0.5, 0.0, 2.5]], walls);
    b.quad([[2.0, 0.0, 1.0], [2.0, -0.4, 1.0], [2.0, -0.4, 2.5], [2.0, 0.0, 2.5]], walls);
    b.quad([[0.5, 0.0, 1.0], [0.5, -0.4, 1.0], [2.0, -0.4, 1.0], [2.0, 0.0, 1.0]], plaster);
    b.quad([[0.5, 0.0, 2.5], [0.5, -0.4, 2.5], [2.0, -0.4, 2.5], [2.0, 0.0, 2.5]], walls);
    // West: a window y 3…4.5, and a hole y 0.5…1, both z 0.5…2.
    for (y0, y1, z0, z1) in [(0.0, 5.0, 0.0, 0.5), (0.0, 5.0, 2.0, 3.0), (0.0, 0.5, 0.5, 2.0), (1.0, 3.0, 0.5, 2.0), (4.5, 5.0, 0.5, 2.0)] {
        b.quad([[0.0, y0, z0], [0.0, y1, z0], [0.0, y1, z1], [0.0, y0, z1]], walls);
    }
    // Inside: a mirror to the east, a pane across, a screen.
    if open {
        b.quad([[3.9, 2.5, 2.5], [3.9, 0.5, 2.5], [3.9, 0.5, 0.5], [3.9, 2.5, 0.5]], mirror);
        b.quad([[0.2, 1.0, 0.3], [2.5, 1.0, 0.3], [2.5, 1.0, 2.7], [0.2, 1.0, 2.7]], glass);
    } else {
        b.quad([[0.0, 0.5, 0.5], [0.0, 1.0, 0.5], [0.0, 1.0, 2.0], [0.0, 0.5, 2.0]], walls);
    }
    b.quad([[0.5, 2.9, 0.0], [1.5, 2.9, 0.0], [1.5, 2.9, 2.0], [0.5, 2.9, 2.0]], trans);
    // Outside: ground, which ends, a house to the south-east, a mirror to the south-west, a canopy, a fin.
    b.quad([[-20.0, -30.0, 0.0], [20.0, -30.0, 0.0], [20.0, -0.4, 0.0], [-20.0, -0.4, 0.0]], ground);
    b.quad([[-9.0, -0.4, 0.0], [-0.01, -0.4, 0.0], [-0.01, 9.0, 0.0], [-9.0, 9.0, 0.0]], ground);
    b.quad([[2.5, -4.0, 0.0], [8.0, -4.0, 0.0], [8.0, -4.0, 6.0], [2.5, -4.0, 6.0]], plaster);
    b.quad([[-2.0, -6.0, 0.0], [-2.0, -0.8, 0.0], [-2.0, -0.8, 4.0], [-2.0, -6.0, 4.0]], mirror);
    b.quad([[0.0, -1.6, 2.7], [2.2, -1.6, 2.7], [2.2, -0.4, 2.9], [0.0, -0.4, 2.9]], trans);
    b.quad([[2.1, -0.9, 0.8], [2.1, -0.41, 0.8], [2.1, -0.41, 2.6], [2.1, -0.9, 2.6]], walls);
    let south = opening([[0.5, -0.25, 1.0], [2.0, -0.25, 1.0], [2.0, -0.25, 2.5], [0.5, -0.25, 2.5]], DVec3::Y);
    let west = opening([[0.0, 3.0, 0.5], [0.0, 4.5, 0.5], [0.0, 4.5, 2.0], [0.0, 3.0, 2.0]], DVec3::X);
    let glazed = |window, transmissivity| GlazedWindow { window, pane: Pane { transmissivity, refraction_index: 1.52 } };
    House {
        scene: b.scene,
        windows: vec![glazed(south, [0.9, 0.8, 0.6]), glazed(west, [0.6, 0.7, 0.8])],
        sensors: vec![
            sensor([1.0, 2.0, 0.8], [0.0, 0.0, 1.0]),
            sensor([2.5, 1.4, 1.0], [1.0, 0.0, 0.2]),
            sensor([3.8, 4.8, 0.2], [0.0, -0.2, 1.0]),
            // Close to the south window, seeing it; in the open, towards the façade, and up before the west window.
            sensor([1.2, -0.1, 1.02], [0.0, -0.1, 1.0]),
            sensor([1.0, -2.0, 1.0], [0.1, 1.0, 0.3]),
            sensor([-0.5, 3.5, 1.0], [0.0, 0.0, 1.0]),
        ],
    }
}

/// A sensor's row, its direct part and those of suns in f64.
type Row = [Vec<[Estimate; 3]>; 4];

impl House {
    fn reference(&self, bounces: u32, samples: usize) -> Vec<Row> {
        let row = |(i, s): (usize, &Sensor)| {
            coefficient_row(&self.scene, &self.windows, s.position, s.direction, tregenza(), bounces, samples, 7 + i as u64)
        };
        self.sensors.par_iter().enumerate().map(row).collect()
    }

    fn compare(
        &self,
        device: &Device,
        bounces: u32,
        light_paths: u32,
        samples: usize,
        reference: &[Row],
    ) -> std::result::Result<String, String> {
        // As many as the reference has hits of its rarest patches.
        let near_samples = 4096;
        let options = CoefficientOptions {
            bounces: Some(bounces),
            light_paths,
            near_samples,
            direct_samples: 2048,
            // So many that each patch has many.
            visibility_rays: 32,
            batches: 16,
            keep_batches: true,
            ..CoefficientOptions::default()
        };
        let c = compute(device, &self.scene, &self.windows, &self.sensors, tregenza(), &options, &Silent).map_err(|e| e.to_string())?;
        // The direct part with the errors of its own batches.
        let mut direct = TracedMatrix { total: c.direct.clone(), ..c.clone() };
        for row in 0..self.sensors.len() {
            for patch in 0..tregenza().len() {
                for channel in 0..3 {
                    let values: Vec<f64> = c.batches.iter().map(|b| f64::from(b.direct.at(row, patch)[channel])).collect();
                    direct.standard_error.at_mut(row, patch)[channel] = mean_and_error(&values).1 as f32;
                }
            }
        }
        let mut found = String::new();
        for (row, [total, unreflected, ..]) in reference.iter().enumerate() {
            let named = |what: &str, e: String| format!("-ab {bounces}, {light_paths} light paths, sensor {row}, {what}: {e}\n");
            found += &named("total", agrees(&c, row, total, samples).map_err(|e| named("total", e))?);
            found += &named("direct", agrees(&direct, row, unreflected, samples).map_err(|e| named("direct", e))?);
        }
        Ok(found)
    }
}

#[test]
fn a_house_with_reveal_mirrors_and_a_hole_agrees_with_the_reference_patch_by_patch() {
    let Some(device) = Device::for_tests("daylight coefficients of a house") else { return };
    let house = house();
    let samples = 400_000;
    for (bounces, ways) in [(1, &[0][..]), (3, &[0, 256])] {
        let reference = house.reference(bounces, samples);
        for light_paths in ways {
            println!("{}", house.compare(&device, bounces, *light_paths, samples, &reference).unwrap_or_else(|e| panic!("{e}")));
        }
    }
}

/// What must come out exactly, in units of its error: a white cube with a mirror, a hole and a lossless pane before a
/// white wall, which gives π; its direct part, by the reference; a black cube with two different panes.
struct Exact {
    white: Scene,
    pane: GlazedWindow,
    direct: [f64; 2],
    black: Scene,
    panes: [GlazedWindow; 2],
    of_panes: f64,
}

impl Exact {
    const SENSORS: [([f64; 3], [f64; 3]); 2] = [([0.5, 0.5, 0.01], [0.0, -0.2, 1.0]), ([0.3, 0.9, 0.6], [0.3, -1.0, 0.2])];

    fn new() -> Self {
        let mut b = Builder::default();
        let (white, mirror) = (b.grey(1.0), b.material(MaterialKind::Metal { color: [1.0; 3], specularity: 1.0, roughness: 0.0 }));
        b.room([0.0; 3], [1.0; 3], white, &[0, 2, 5]);
        b.quad([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]], mirror);
        b.quad([[0.0, 0.3, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.3, 1.0]], white);
        b.quad([[0.3, 0.0, 1.0], [0.3, 0.3, 1.0], [1.0, 0.3, 1.0], [1.0, 0.0, 1.0]], white);
        b.quad([[-0.5, -0.3, -0.5], [1.5, -0.3, -0.5], [1.5, -0.3, 1.3], [-0.5, -0.3, 1.3]], white);
        let (white, (_, pane)) = (b.scene, cube(1.0, CLEAR));
        let samples = 400_000;
        let direct = Self::SENSORS.map(|(p, d)| {
            let [_, row, ..] = coefficient_row(&white, std::slice::from_ref(&pane), p.into(), d.into(), tregenza(), 1, samples, 3);
            row.iter().map(|cell| cell[0].mean(samples)).sum()
        });
        let (mut black, mut south) = cube(0.0, Pane { transmissivity: [0.7; 3], ..CLEAR });
        black.triangles.retain(|t| t.vertices.iter().any(|v| v.z < 1.0));
        south.pane = Pane { transmissivity: [0.5; 3], ..CLEAR };
        let above = window([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 0.0, 1.0]], DVec3::NEG_Z, DVec3::Y, KlemsBasis::Full);
        let panes = [GlazedWindow { window: above, pane: Pane { transmissivity: [0.9; 3], ..CLEAR } }, south];
        // What comes by the one pane and is mirrored by the other included.
        let (p, d) = Self::SENSORS[1];
        let [row, ..] = coefficient_row(&black, &panes, p.into(), d.into(), tregenza(), 1, samples, 5);
        let of_panes = row.iter().map(|cell| cell[0].mean(samples)).sum();
        Self { white, pane, direct, black, panes, of_panes }
    }

    fn check(&self, device: &Device) -> std::result::Result<String, String> {
        // By paths from the sensors alone, and with light paths.
        let found = [(0, 2048), (64, 512)].map(|(light_paths, near_samples)| {
            let options = CoefficientOptions { light_paths, near_samples, keep_batches: true, ..CoefficientOptions::default() };
            self.check_with(device, &options).map_err(|e| format!("{light_paths} light paths: {e}"))
        });
        let [paths, lights] = found;
        Ok(paths? + &lights?)
    }

    fn check_with(&self, device: &Device, options: &CoefficientOptions) -> std::result::Result<String, String> {
        let sensors = Self::SENSORS.map(|(p, d)| sensor(p, d));
        let run = |scene, windows: &[GlazedWindow]| {
            compute(device, scene, windows, &sensors, tregenza(), options, &Silent).map_err(|e| e.to_string())
        };
        let white = run(&self.white, std::slice::from_ref(&self.pane))?;
        let black = run(&self.black, &self.panes)?;
        let direct = |row: usize| mean_and_error(&white.batches.iter().map(|b| sum(b.direct.row(row))).collect::<Vec<_>>());
        let mut found = String::new();
        for (what, (value, error), wanted, margin) in [
            ("white, up", row_sum(&white, 0), PI, 0.0),
            ("white, to the pane", row_sum(&white, 1), PI, 0.0),
            ("direct, up", direct(0), self.direct[0], 0.02 * self.direct[0]),
            ("direct, to the pane", direct(1), self.direct[1], 0.02 * self.direct[1]),
            ("black", row_sum(&black, 1), self.of_panes, 0.01 * self.of_panes),
        ] {
            let text = format!("{what} {value:.4} ± {error:.4}, {wanted:.4}; ");
            // Eight batches: 5 standard errors are as rare as 3.3 of a normal distribution.
            if !((value - wanted).abs() < 5.0 * error + margin && (error < 0.02 * wanted || what.starts_with("direct"))) {
                return Err(text);
            }
            found += &text;
        }
        Ok(found)
    }
}

#[test]
fn faults_in_the_shaders_of_the_coefficients_are_found_out() {
    let Some(device) = Device::for_tests("faults in the coefficients' shaders") else { return };
    let exact = Exact::new();
    println!("{}", exact.check(&device).unwrap_or_else(|e| panic!("without a fault: {e}")));
    let mut survivors = Vec::new();
    for (path, from, to) in [
        ("coefficients/direct", "select(select(OTHER, SUNLIT, found.plain), DIRECT, found.direct)", "DIRECT"),
        ("coefficients/direct", "found.patch_index, found.weight, unit_f32", "found.patch_index, 0.9 * found.weight, unit_f32"),
        ("coefficients/from_sensor", "counts = (*path).mirrored;", "counts = true;"),
        ("coefficients/from_sensor", "counts = (*path).mirrored;", "counts = false;"),
        ("coefficients/paths", "select(SUNLIT, OTHER, path.mirrored), DIRECT, path.first", "SUNLIT, DIRECT, true"),
        ("coefficients/paths", "path.near_share * FRAC_1_PI", "path.near_share * 0.4"),
        ("coefficients/window_ray", "pane.roughness, max(-dot(", "pane.roughness, 1.0 + 0.0 * max(-dot("),
        ("coefficients/window_ray", "first_pane + to_window.window", "first_pane"),
        (
            "coefficients/window_ray",
            "to_window.direction * to_window.distance, -window.z",
            "to_window.direction * to_window.distance, window.z",
        ),
        (
            "coefficients/deposit",
            "part * params.batches * params.sensors + row",
            "(1u - min(part, 1u)) * params.batches * params.sensors + row",
        ),
        ("coefficients/starts", "emitted * through *", "2.0 * emitted * through *"),
        ("coefficients/starts", "offset_from_surface(point, -window.z)", "offset_from_surface(point, window.z)"),
        ("coefficients/gather", "let weight = step * FRAC_1_PI;", "let weight = step * 0.5;"),
        ("coefficients/gather", "share * weight, unit_f32", "share * step, unit_f32"),
        ("shared/outside", "(passed_pane && front && material.window > 0u)", "false"),
    ] {
        match mutation::with(path, from, to, || exact.check(&device)) {
            Ok(found) => survivors.push(format!("{path}: '{from}' may be '{to}': {found}")),
            Err(found) => println!("{path}: '{to}' is found out: {found}"),
        }
    }
    assert!(survivors.is_empty(), "{}", survivors.join("\n"));
}

#[test]
fn equal_seeds_give_equal_bits_whatever_the_tile() {
    let Some(device) = Device::for_tests("tiles of the coefficients") else { return };
    let house = house();
    let sensors: Vec<Sensor> = (0..23).map(|i| sensor([0.1 + 0.15 * f64::from(i), 2.0, 0.8], [0.0, 0.0, 1.0])).collect();
    let options = CoefficientOptions {
        bounces: Some(3),
        direct_samples: 32,
        light_paths: 8,
        near_samples: 16,
        keep_batches: true,
        ..CoefficientOptions::default()
    };
    let run =
        |options: &CoefficientOptions| compute(&device, &house.scene, &house.windows, &sensors, tregenza(), options, &Silent).unwrap();
    let whole = run(&options);
    // Four sensors' sums of two kernels.
    let tiled = run(&CoefficientOptions { memory: 4 * 2 * 2 * 8 * 146 * 12, ..options });
    // Each tile has its own light paths.
    assert!(tiled.statistics.paths > whole.statistics.paths);
    assert_eq!((&whole.total, &whole.direct, &whole.standard_error), (&tiled.total, &tiled.direct, &tiled.standard_error));
    assert_eq!(whole.batches, tiled.batches);
    assert_ne!(whole.total, run(&CoefficientOptions { seed: 2, ..options }).total);
}

//! Analytic cases in the manner of CIE 171:2006 (Test cases to assess the accuracy of lighting computer
//! programs): sky component through unglazed openings under the CIE skies, obstructions inside, masks
//! outside, diffuse reflection. What is expected is computed here, from the formulas.

use super::rooms::{Builder, polygon_irradiance, sensor, window};
use crate::bins::{KlemsBasis, ReinhartSky};
use crate::gpu::Device;
use crate::kernels::daylight_matrix::{self, DaylightOptions};
use crate::kernels::view_matrix::{self, ViewOptions};
use crate::matrix::Matrix;
use crate::progress::Silent;
use crate::testing::{measured, percent, percents};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// What CIE 171 allows itself.
const TOLERANCE: f64 = 0.01;

/// A rectangle in space: a corner and two edges.
#[derive(Clone, Copy)]
struct Rectangle {
    corner: DVec3,
    edges: [DVec3; 2],
}

impl Rectangle {
    fn new(corner: [f64; 3], a: [f64; 3], b: [f64; 3]) -> Self {
        Self { corner: DVec3::from_array(corner), edges: [DVec3::from_array(a), DVec3::from_array(b)] }
    }

    fn corners(&self) -> [[f64; 3]; 4] {
        let [a, b] = self.edges;
        [self.corner, self.corner + a, self.corner + a + b, self.corner + b].map(|p| p.to_array())
    }

    /// Whether it stands between two points.
    fn hides(&self, from: DVec3, to: DVec3) -> bool {
        let normal = self.edges[0].cross(self.edges[1]);
        let (d0, d1) = ((from - self.corner).dot(normal), (to - self.corner).dot(normal));
        if d0 * d1 >= 0.0 {
            return false;
        }
        let p = from + (to - from) * (d0 / (d0 - d1)) - self.corner;
        self.edges.iter().all(|e| (0.0..=1.0).contains(&(p.dot(*e) / e.length_squared())))
    }

    /// ∫ of radiance × cosθ_receiver × cosθ / d² over it, by the midpoint rule.
    fn irradiance(&self, eye: DVec3, normal: DVec3, radiance: impl Fn(DVec3) -> f64) -> f64 {
        const N: usize = 600;
        let [a, b] = self.edges;
        let own = a.cross(b);
        let mut sum = 0.0;
        for k in 0..N * N {
            let place = |i: usize| (i as f64 + 0.5) / N as f64;
            let p = self.corner + a * place(k / N) + b * place(k % N);
            let to = p - eye;
            let d2 = to.length_squared();
            sum += to.dot(normal).max(0.0) * to.dot(own).abs() / (d2 * d2) * radiance(p);
        }
        sum / (N * N) as f64
    }
}

/// The fifteen CIE standard general skies (ISO 15469): gradation a, b and indicatrix c, d, e; then the
/// traditional overcast sky.
const SKIES: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.0],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.80, 0.0, -1.0, 0.0],
    [1.1, -0.80, 2.0, -1.5, 0.15],
    [0.0, -1.0, 0.0, -1.0, 0.0],
    [0.0, -1.0, 2.0, -1.5, 0.15],
    [0.0, -1.0, 5.0, -2.5, 0.30],
    [0.0, -1.0, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];

/// Relative luminance of sky `kind` (15 is the traditional overcast one), the sun at 60° in the south.
fn sky_luminance(kind: usize, direction: DVec3) -> f64 {
    let sin = direction.z.max(0.0);
    let Some([a, b, c, d, e]) = SKIES.get(kind) else { return (1.0 + 2.0 * sin) / 3.0 };
    let sun = DVec3::new(0.0, -0.5, 0.75f64.sqrt());
    let angle = direction.dot(sun).clamp(-1.0, 1.0).acos();
    let gradation = 1.0 + a * if sin > 0.0 { (b / sin).exp() } else { 0.0 };
    gradation * (1.0 + c * ((d * angle).exp() - (d * FRAC_PI_2).exp()) + e * angle.cos().powi(2))
}

/// A luminance as one column over the patches: their means.
fn patches(sky: ReinhartSky, ground: f64, luminance: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let mean = |bin: usize| {
        (0..16).map(|k| luminance(sky.direction(bin, f64::from(k / 4) / 4.0 + 0.125, f64::from(k % 4) / 4.0 + 0.125))).sum::<f64>() / 16.0
    };
    (0..sky.len()).map(|bin| if bin == 0 { ground } else { mean(bin) }).collect()
}

/// What a sensor sees of each patch (sr of projected solid angle): the rows of D of a tiny window in
/// its place, and the standard error of the sum over all patches.
fn coefficients(device: &Device, b: &Builder, eye: DVec3, normal: DVec3, bounces: u32) -> (Vec<f64>, f64) {
    let x = normal.any_orthonormal_vector() * 5e-4;
    let y = normal.cross(x);
    let corners = [eye - x - y, eye + x - y, eye + x + y, eye - x + y].map(|p| p.to_array());
    let up = if normal.z.abs() > 0.9 { DVec3::Y } else { DVec3::Z };
    let w = window(corners, -normal, up, KlemsBasis::Full);
    let options = DaylightOptions { bounces: Some(bounces), paths: 4096, ..DaylightOptions::default() };
    let d = daylight_matrix::compute(device, &b.scene, &w, ReinhartSky::new(4).unwrap(), &options, &Silent).unwrap();
    let weighted = |m: &Matrix<f32>, patch: usize, power: i32| -> f64 {
        (0..m.rows()).map(|bin| (f64::from(m.at(bin, patch)[0]) * w.basis.projected_solid_angle(bin)).powi(power)).sum()
    };
    let row = (0..d.total.cols()).map(|patch| weighted(&d.total, patch, 1)).collect();
    let variance: f64 = (0..d.total.cols()).map(|patch| weighted(&d.standard_error, patch, 2)).sum();
    (row, variance.sqrt())
}

/// Compares what `coefficients` give under all skies with a quadrature over an opening; the largest relative difference.
fn compare(
    device: &Device,
    what: &str,
    b: &Builder,
    opening: &Rectangle,
    eye: [f64; 3],
    normal: DVec3,
    seen: impl Fn(DVec3) -> bool,
) -> f64 {
    let mut worst = 0.0f64;
    let sky = ReinhartSky::new(4).unwrap();
    let eye = DVec3::from_array(eye);
    let (row, error) = coefficients(device, b, eye, normal, 0);
    let whole: f64 = row.iter().sum();
    assert!(error < TOLERANCE / 2.0 * whole, "{what}: so uncertain that it says nothing, {error} of {whole}");
    for kind in 0..=SKIES.len() {
        let column = patches(sky, 0.0, |d| sky_luminance(kind, d));
        let found: f64 = row.iter().zip(&column).map(|(v, l)| v * l).sum();
        let exact = opening.irradiance(eye, normal, |p| {
            let direction = (p - eye).normalize();
            if direction.z > 0.0 && seen(p) { sky_luminance(kind, direction) } else { 0.0 }
        });
        if [0, 4, 12, 15].contains(&kind) {
            println!("{what}, sky {}: {found:.5} of {exact:.5} ({:+.2} %)", kind + 1, 100.0 * (found / exact - 1.0));
        }
        assert!((found / exact - 1.0).abs() < TOLERANCE, "{what}, sky {}: {found}, not {exact}", kind + 1);
        worst = worst.max((found / exact - 1.0).abs());
    }
    worst
}

/// A black room, 4 m × 4 m × 3 m, without the face of this number.
fn room(without: usize) -> Builder {
    let mut b = Builder::default();
    let black = b.grey(0.0);
    b.room([0.0; 3], [4.0, 4.0, 3.0], black, &[without]);
    b
}

/// A wall of the room around an opening in the plane y = 0, or in the roof.
fn frame_wall(b: &mut Builder, [x0, x1]: [f64; 2], [v0, v1]: [f64; 2], height: f64, place: impl Fn(f64, f64) -> [f64; 3]) {
    let black = b.grey(0.0);
    for [a0, a1, c0, c1] in [[0.0, x0, 0.0, height], [x1, 4.0, 0.0, height], [x0, x1, 0.0, v0], [x0, x1, v1, height]] {
        if a1 > a0 && c1 > c0 {
            b.quad([place(a0, c0), place(a1, c0), place(a1, c1), place(a0, c1)], black);
        }
    }
}

#[test]
fn sky_component_through_a_roof_opening() {
    let Some(device) = Device::for_tests("roof openings under the CIE skies") else { return };
    let mut worst = 0.0f64;
    for (half, sensors) in [
        (0.5, vec![([2.0, 2.0, 0.01], DVec3::Z), ([1.0, 3.5, 0.01], DVec3::Z), ([0.01, 2.0, 1.5], DVec3::X)]),
        (2.0, vec![([0.5, 0.5, 0.01], DVec3::Z), ([3.99, 1.0, 1.0], DVec3::NEG_X)]),
    ] {
        let mut b = room(5);
        frame_wall(&mut b, [2.0 - half, 2.0 + half], [2.0 - half, 2.0 + half], 4.0, |x, y| [x, y, 3.0]);
        let opening = Rectangle::new([2.0 - half, 2.0 - half, 3.0], [2.0 * half, 0.0, 0.0], [0.0, 2.0 * half, 0.0]);
        for (eye, normal) in sensors {
            worst = worst.max(compare(&device, &format!("roof opening of {} m, {eye:?}", 2.0 * half), &b, &opening, eye, normal, |_| true));
        }
    }
    measured("cie171-roof", &format!("within {}", percent(worst)), &percent(TOLERANCE));
}

#[test]
fn sky_component_through_a_facade_opening_with_masks_and_obstructions() {
    let Some(device) = Device::for_tests("façade openings under the CIE skies") else { return };
    let opening = Rectangle::new([1.0, 0.0, 1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let facade = || {
        let mut b = room(2);
        frame_wall(&mut b, [1.0, 3.0], [1.0, 2.0], 3.0, |x, z| [x, 0.0, z]);
        b
    };
    let overhang = Rectangle::new([-200.0, -1.0, 2.3], [404.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let opposite = Rectangle::new([-200.0, -6.0, -20.0], [404.0, 0.0, 0.0], [0.0, 0.0, 24.5]);
    let partition = Rectangle::new([1.5, 0.7, 0.0], [0.8, 0.0, 0.0], [0.0, 0.0, 1.3]);
    let cases = [
        ("façade opening", None),
        ("under a horizontal mask", Some(overhang)),
        ("behind a vertical mask", Some(opposite)),
        ("behind a partition inside", Some(partition)),
    ];
    let mut worst = 0.0f64;
    for (what, mask) in cases {
        let mut b = facade();
        if let Some(mask) = mask {
            let black = b.grey(0.0);
            b.quad(mask.corners(), black);
        }
        for (eye, normal) in [([2.0, 2.8, 0.01], DVec3::Z), ([2.5, 1.0, 0.8], DVec3::NEG_Y)] {
            let eye_at = DVec3::from_array(eye);
            let seen = |p: DVec3| mask.is_none_or(|m| !m.hides(eye_at, eye_at + (p - eye_at) * 1e3));
            worst = worst.max(compare(&device, &format!("{what}, {eye:?}"), &b, &opening, eye, normal, seen));
        }
    }
    measured("cie171-facade", &format!("within {}", percent(worst)), &percent(TOLERANCE));
}

#[test]
fn light_of_the_ground_reflected_by_a_mask_outside() {
    let Some(device) = Device::for_tests("externally reflected component") else { return };
    // A horizontal mask without end before an endless façade receives the light of the ground from one
    // half of its view, wherever on it: its luminance is ρ/2 of the ground's.
    let (reflectance, far) = (0.7, 400.0);
    let mut b = room(2);
    frame_wall(&mut b, [1.0, 3.0], [1.0, 2.0], 3.0, |x, z| [x, 0.0, z]);
    let black = b.grey(0.0);
    for [x0, x1, z0, z1] in [[-far, 0.0, -far, 3.0], [4.0, far, -far, 3.0], [0.0, 4.0, -far, 0.0]] {
        b.quad([[x0, 0.0, z0], [x1, 0.0, z0], [x1, 0.0, z1], [x0, 0.0, z1]], black);
    }
    let mask = Rectangle::new([-far, -1.5, 2.3], [2.0 * far, 0.0, 0.0], [0.0, 1.5, 0.0]);
    let bright = b.grey(reflectance);
    b.quad(mask.corners(), bright);
    let opening = Rectangle::new([1.0, 0.0, 1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let mut off = Vec::new();
    for (eye, normal) in [([2.0, 1.5, 0.01], DVec3::Z), ([2.5, 0.8, 0.4], DVec3::NEG_Y)] {
        let at = DVec3::from_array(eye);
        let (row, error) = coefficients(&device, &b, at, normal, 1);
        let exact = opening.irradiance(at, normal, |p| match (p - at).normalize() {
            d if d.z <= 0.0 => 1.0,
            _ if mask.hides(at, at + (p - at) * 1e3) => reflectance / 2.0,
            _ => 0.0,
        });
        println!("ground and mask, {eye:?}: {:.5} ± {error:.5} of {exact:.5}", row[0]);
        assert!((row[0] / exact - 1.0).abs() < TOLERANCE, "{eye:?}: {}, not {exact}", row[0]);
        off.push((row[0] / exact - 1.0).abs());
    }
    measured("cie171-ground", &percents(&off), &percent(TOLERANCE));
}

#[test]
fn diffuse_reflection_with_and_without_an_obstruction() {
    let Some(device) = Device::for_tests("diffuse reflection") else { return };
    // Light of an opening, reflected once by the floor, onto a sensor above the opening that looks down
    // and cannot see it; then with a partition between the sensor and a part of the floor.
    let opening = [[1.0, 0.0, 1.0], [1.0, 0.0, 2.0], [3.0, 0.0, 2.0], [3.0, 0.0, 1.0]];
    let floor = Rectangle::new([0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]);
    let partition = Rectangle::new([0.3, 1.2, 2.2], [1.3, 0.0, 0.0], [0.0, 0.9, 0.0]);
    let reflectance = 0.6;
    const SIGMAS: f64 = 3.0;
    let mut texts = Vec::new();
    for obstructed in [false, true] {
        let (mut worst, mut noise) = (0.0f64, 0.0f64);
        let mut b = Builder::default();
        let grey = b.grey(reflectance);
        b.quad(floor.corners(), grey);
        if obstructed {
            let black = b.grey(0.0);
            b.quad(partition.corners(), black);
        }
        let w = window(opening, DVec3::Y, DVec3::Z, KlemsBasis::Full);
        let sensors = [([2.0, 0.3, 2.9], DVec3::NEG_Z), ([1.5, 2.0, 2.8], DVec3::NEG_Z)];
        let probes: Vec<_> = sensors.iter().map(|(p, n)| sensor(*p, n.to_array())).collect();
        let options = ViewOptions { bounces: Some(2), visibility_rays: 32, ..ViewOptions::default() };
        let v = view_matrix::compute(&device, &b.scene, &[w], &probes, &options, &Silent).unwrap();
        for (row, (eye, normal)) in sensors.iter().enumerate() {
            let at = DVec3::from_array(*eye);
            let lit = |p: DVec3| polygon_irradiance(&opening.map(DVec3::from_array), p, DVec3::Z);
            let dark = |p: DVec3| obstructed && (partition.hides(at, p));
            let reflected = floor.irradiance(at, *normal, |p| if dark(p) { 0.0 } else { reflectance / PI * lit(p) });
            let direct: f64 = (0..v.direct.cols()).map(|bin| f64::from(v.direct.at(row, bin)[1])).sum();
            let total: f64 = (0..v.total.cols()).map(|bin| f64::from(v.total.at(row, bin)[1])).sum();
            let error = (0..v.total.cols()).map(|bin| f64::from(v.standard_error.at(row, bin)[1]).powi(2)).sum::<f64>().sqrt();
            println!("diffuse reflection, obstructed {obstructed}, {eye:?}: {:.6} ± {error:.6} of {reflected:.6}", total - direct);
            assert!(
                (total - direct - reflected).abs() < TOLERANCE * reflected + SIGMAS * error,
                "{eye:?}: {}, not {reflected}",
                total - direct
            );
            assert!(error < 0.02 * reflected, "so uncertain that it says nothing");
            (worst, noise) = (worst.max(((total - direct) / reflected - 1.0).abs()), noise.max(error / reflected));
        }
        texts.push(format!("{} ± {}", percent(worst), percent(noise)));
    }
    let held = format!("{} and {SIGMAS} standard errors", percent(TOLERANCE));
    measured("cie171-floor", &format!("{}, hidden {}", texts[0], texts[1]), &held);
}

//! Direct view matrix without anything in the way, by quadrature instead of rays.
//!
//! Seen from a sensor, the rings of a window's basis are circles on the window's plane around the
//! foot of the perpendicular from the sensor, and its azimuths are rays from that foot. The
//! irradiance from a bin is the integral of cosθ_sensor cosθ_window / d² over the part of the
//! window inside its annular sector; its radial half has a closed form, the azimuthal half is
//! smooth between breakpoints and is done by Gauss-Legendre quadrature.

use crate::scene::Window;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Gauss-Legendre nodes and weights on [-1, 1], four points.
const NODES: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// Irradiance at a sensor from each bin of a window of radiance 1, sr: `row[bin]` is added to.
/// `normal` must have unit length.
pub(crate) fn add_unobstructed_row(window: &Window, position: DVec3, normal: DVec3, row: &mut [f64]) {
    let frame = &window.frame;
    let n = frame.to_local(normal);
    for triangle in &window.triangles {
        let local = triangle.map(|q| frame.to_local(q - position));
        // The window lies in the plane z = -height below the sensor.
        let height = -(local[0].z + local[1].z + local[2].z) / 3.0;
        if height <= 0.0 {
            continue;
        }
        let mut corners: Vec<DVec2> = local.iter().map(|q| q.truncate()).collect();
        if (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]) < 0.0 {
            corners.reverse();
        }
        let corners = above_horizon(&corners, n, height);
        for (i, &from) in corners.iter().enumerate() {
            add_edge(window, from, corners[(i + 1) % corners.len()], n, height, row);
        }
    }
    // Signed sums of edges leave rounding where a bin is empty.
    let noise = 1e-12 * row.iter().copied().fold(0.0, f64::max);
    for value in row {
        if *value < noise {
            *value = 0.0;
        }
    }
}

/// The part of a polygon on the window's plane that the sensor faces.
fn above_horizon(corners: &[DVec2], n: DVec3, height: f64) -> Vec<DVec2> {
    let facing = |q: DVec2| n.x * q.x + n.y * q.y - n.z * height;
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (fa, fb) = (facing(a), facing(b));
        if fa >= 0.0 {
            kept.push(a);
        }
        if (fa >= 0.0) != (fb >= 0.0) {
            kept.push(a + (b - a) * (fa / (fa - fb)));
        }
    }
    kept
}

/// Adds the signed integral over the triangle between the foot of the perpendicular and one edge.
fn add_edge(window: &Window, from: DVec2, to: DVec2, n: DVec3, height: f64, row: &mut [f64]) {
    let along = to - from;
    let cross = from.perp_dot(to);
    if cross.abs() <= 1e-14 * (from.length_squared() + to.length_squared()) {
        return;
    }
    // The edge in polar form: ρ(φ) = distance / cos(φ − towards).
    let distance = cross.abs() / along.length();
    let foot = from - along * (from.dot(along) / along.length_squared());
    let towards = foot.y.atan2(foot.x);
    let (mut start, mut end) = (relative(from.y.atan2(from.x), towards), relative(to.y.atan2(to.x), towards));
    let sign = cross.signum();
    if start > end {
        std::mem::swap(&mut start, &mut end);
    }
    for ring in window.basis.rings() {
        let near = height * ring.theta_min.to_radians().tan();
        let far = if ring.theta_max >= 90.0 { f64::INFINITY } else { height * ring.theta_max.to_radians().tan() };
        // Where the edge leaves the ring, the integrand has a kink.
        let mut breaks = vec![start, end];
        for radius in [near, far] {
            if radius > distance && radius.is_finite() {
                let angle = (distance / radius).acos();
                breaks.extend([-angle, angle].into_iter().filter(|a| *a > start && *a < end));
            }
        }
        // Light travels from the window to the sensor, so a bin's azimuth is opposite to that of
        // the window's point.
        let width = TAU / ring.bins as f64;
        let turned = towards + TAU / 2.0;
        let towards = towards.sin_cos();
        let bin_at = |angle: f64| ((angle + turned) / width + 0.5).floor();
        if ring.bins > 1 {
            let (first, last) = (bin_at(start) as i64, bin_at(end) as i64);
            breaks.extend((first + 1..=last).map(|k| (k as f64 - 0.5) * width - turned).filter(|a| *a > start && *a < end));
        }
        breaks.sort_by(f64::total_cmp);
        for piece in breaks.windows(2) {
            let middle = f64::midpoint(piece[0], piece[1]);
            if piece[1] <= piece[0] || distance / middle.cos() < near {
                continue;
            }
            let bin = ring.first + if ring.bins > 1 { (bin_at(middle) as i64).rem_euclid(ring.bins as i64) as usize } else { 0 };
            // ∫ tilt dφ and ∫ dφ, exact: what edges have in common must cancel.
            let tilt = |sin: f64, cos: f64| n.x * (cos * towards.1 - sin * towards.0) + n.y * (sin * towards.1 + cos * towards.0);
            let tilts = tilt(-piece[1].cos(), piece[1].sin()) - tilt(-piece[0].cos(), piece[0].sin());
            let even = |[skew, straight]: [f64; 2]| 0.5 * (tilts * skew - n.z * (piece[1] - piece[0]) * straight);
            let inner = even(radial(near, height));
            let outer = if distance / middle.cos() >= far {
                even(radial(far, height))
            } else if distance / piece[0].cos().max(piece[1].cos()) > height {
                // As what is missing from the whole half space, which is little.
                even([FRAC_PI_2, 1.0])
                    - integral(piece[0], piece[1], |sin, cos| {
                        let [skew, straight] = beyond(distance / cos, height);
                        0.5 * (tilt(sin, cos) * skew - n.z * straight)
                    })
            } else {
                integral(piece[0], piece[1], |sin, cos| {
                    let [skew, straight] = radial(distance / cos, height);
                    0.5 * (tilt(sin, cos) * skew - n.z * straight)
                })
            };
            row[bin] += sign * (outer - inner);
        }
    }
}

/// ∫ f(sin φ, cos φ) dφ within (−π/2, π/2) of a function of the edge's distance, which grows as
/// 1/cos φ: with tanh u = sin φ its nearest singularity keeps π/2 away from all real u, wherever the
/// edge lies, so that steps of 0.7 leave an error of 10⁻⁷.
fn integral(start: f64, end: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
    const STEP: f64 = 0.7;
    const LARGEST: f64 = 30.0;
    let [from, to] = [start, end].map(|angle| angle.sin().atanh().clamp(-LARGEST, LARGEST));
    let steps = ((to - from) / STEP).ceil().max(1.0);
    let half = (to - from) / steps / 2.0;
    (0..steps as usize)
        .map(|k| {
            let middle = from + half * (2.0 * k as f64 + 1.0);
            let value = |node: f64| {
                let u = middle + half * node;
                let cos = 1.0 / u.cosh();
                cos * f(u.tanh(), cos)
            };
            half * NODES.iter().map(|(node, weight)| weight * value(*node)).sum::<f64>()
        })
        .sum()
}

/// ∫₀^ρ of 2 ρ h/(h² + ρ²)² times ρ and times h: with these the radial half of the integral of
/// (tilt ρ − n_z h) h ρ/(h² + ρ²)² is (tilt · first − n_z · second)/2.
fn radial(rho: f64, height: f64) -> [f64; 2] {
    let x = rho / height;
    if x > 1.0 {
        let [skew, straight] = beyond(rho, height);
        return [FRAC_PI_2 - skew, 1.0 - straight];
    }
    let straight = x * x / (1.0 + x * x);
    // The difference of two nearly equal numbers close to the foot.
    let skew = if x < 0.01 { x.powi(3) * (2.0 / 3.0 - x * x * (4.0 / 5.0 - x * x * 6.0 / 7.0)) } else { x.atan() - x / (1.0 + x * x) };
    [skew, straight]
}

/// As [`radial`], from ρ to infinity.
fn beyond(rho: f64, height: f64) -> [f64; 2] {
    let y = height / rho;
    [y.atan() + y / (1.0 + y * y), y * y / (1.0 + y * y)]
}

/// Angle from `towards`, in (−π, π].
fn relative(angle: f64, towards: f64) -> f64 {
    let a = (angle - towards).rem_euclid(TAU);
    if a > TAU / 2.0 { a - TAU } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::kernels::trace::reference::Random;
    use crate::kernels::trace::rooms::{polygon_irradiance, window};

    fn row(w: &Window, position: DVec3, normal: DVec3) -> Vec<f64> {
        let mut row = vec![0.0; w.basis.len()];
        add_unobstructed_row(w, position, normal.normalize(), &mut row);
        row
    }

    #[test]
    fn sums_are_the_analytic_configuration_factors() {
        let w = window([[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
        // One metre square, three metres in front, facing it.
        let sum: f64 = row(&w, DVec3::new(0.0, 3.0, 0.0), DVec3::NEG_Y).iter().sum();
        assert!((sum / std::f64::consts::PI - 0.0341068).abs() < 5e-8, "{sum}");
        // The whole half space.
        let huge = window([[-1e6, 0.0, -1e6], [-1e6, 0.0, 1e6], [1e6, 0.0, 1e6], [1e6, 0.0, -1e6]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
        let r = row(&huge, DVec3::Y, DVec3::NEG_Y);
        for (bin, value) in r.iter().enumerate() {
            assert!((value / huge.basis.projected_solid_angle(bin) - 1.0).abs() < 1e-5, "{bin} {value}");
        }
        // Perpendicular to the window: half of it is below the horizon.
        let sum: f64 = row(&huge, DVec3::Y, DVec3::Z).iter().sum();
        assert!((sum / std::f64::consts::PI - 0.5).abs() < 1e-5, "{sum}");
        assert!(row(&w, DVec3::NEG_Y, DVec3::Y).iter().all(|&v| v == 0.0), "nothing is seen from outside");
    }

    #[test]
    fn sums_are_lamberts_formula_near_and_far() {
        let corners = [[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]];
        for basis in [KlemsBasis::Full, KlemsBasis::Quarter] {
            let w = window(corners, DVec3::Y, DVec3::Z, basis);
            for height in [1e-3, 1e-2, 0.3, 3.0, 40.0, 1e3] {
                for (x, z) in [(0.0, 0.0), (0.1, -0.3), (0.499, 0.2), (3.0, 0.7)] {
                    for normal in [DVec3::NEG_Y, DVec3::new(0.3, -1.0, -0.2), DVec3::new(-1.0, -0.4, 0.1)] {
                        let eye = DVec3::new(x, height, z);
                        let ahead = corners.iter().all(|c| (DVec3::from_array(*c) - eye).dot(normal) > 0.0);
                        if !ahead {
                            continue;
                        }
                        let exact = polygon_irradiance(&corners.map(DVec3::from_array), eye, normal.normalize());
                        let sum: f64 = row(&w, eye, normal).iter().sum();
                        assert!((sum / exact - 1.0).abs() < 1e-6, "{eye} {normal}: {sum}, not {exact}");
                    }
                }
            }
        }
    }

    #[test]
    fn bins_agree_with_sampling_of_the_area() {
        let w = window([[0.5, 0.0, 1.0], [0.5, 0.0, 2.5], [2.0, 0.0, 2.5], [2.0, 0.0, 1.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
        for (position, normal) in [
            (DVec3::new(1.0, 1.5, 0.8), DVec3::Z),
            (DVec3::new(1.2, 0.7, 1.6), DVec3::new(0.3, -1.0, 0.2).normalize()),
            (DVec3::new(3.5, 0.2, 2.9), DVec3::new(-1.0, 0.0, -0.2).normalize()),
        ] {
            let exact = row(&w, position, normal);
            let mut sampled = vec![0.0; 145];
            let mut random = Random(1);
            let n = 2_000_000;
            for _ in 0..n {
                let q = DVec3::new(0.5 + 1.5 * random.next(), 0.0, 1.0 + 1.5 * random.next());
                let to = q - position;
                let (d2, cos) = (to.length_squared(), to.normalize().dot(normal));
                if cos > 0.0 {
                    let cos_window = -to.normalize().y;
                    sampled[w.basis.bin_of(w.frame.to_local(-to.normalize()))] += cos * cos_window / d2 * 2.25 / n as f64;
                }
            }
            let largest = exact.iter().copied().fold(0.0, f64::max);
            for bin in 0..145 {
                // A bin with a share p of the samples has a relative error of about 1/√(p n).
                let tolerance = 6.0 * (exact[bin] * largest).sqrt() / (n as f64 / 100.0).sqrt() + 1e-7;
                assert!((exact[bin] - sampled[bin]).abs() < tolerance, "bin {bin}: {} and {}", exact[bin], sampled[bin]);
            }
        }
    }
}

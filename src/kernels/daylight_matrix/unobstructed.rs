//! D of a window before which nothing stands, by quadrature instead of rays: the share of each of its
//! bins that each patch of the sky, or the ground, fills.
//!
//! Along a circle of constant polar angle around the window's normal, the borders of the sky's patches
//! (circles of constant altitude, meridians) are met at azimuths in closed form, so the shares along
//! it are exact lengths of arcs. Only the integral over polar angles is a sum, over equal parts of
//! projected solid angle. Row sums are 1 as they should be.

use crate::bins::ReinhartSky;
use crate::matrix::Matrix;
use crate::scene::{MaterialKind, Scene, Window};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Circles per ring of the basis. Where a border is tangent to a ring's circles, a share changes as a
/// root of the polar angle, so errors are about this to the power of −3/2, relative to the bin.
const CIRCLES: usize = 1024;
/// Largest error of an entry (each row sums to 1), as tested.
#[cfg(test)]
const TOLERANCE: f64 = 2e-4;
/// What lies before the plane of a window by less than this, relative to its size, is in the plane.
const IN_PLANE: f64 = 1e-6;

/// Whether nothing that light could meet, other windows included, lies outside the plane of the window.
pub(crate) fn nothing_before(scene: &Scene, window: &Window) -> bool {
    let outside = -window.frame.z;
    let corners = || window.triangles.iter().flatten();
    let plane = corners().map(|c| c.dot(outside)).fold(f64::INFINITY, f64::min);
    let limit = plane + IN_PLANE * window.area().sqrt();
    let before = |p: &DVec3| p.dot(outside) > limit;
    // A bent window could stand before itself.
    !corners().any(before)
        && !scene.windows.iter().flat_map(|w| &w.triangles).flatten().any(before)
        && !scene
            .triangles
            .iter()
            .filter(|t| scene.materials[t.material.0 as usize].kind != MaterialKind::Void)
            .any(|t| t.vertices.iter().any(before))
}

/// D of a window before which nothing stands, `[bin][patch]`, RGB: grey.
pub fn compute(window: &Window, sky: ReinhartSky) -> Matrix<f32> {
    let mut rows = vec![vec![0.0f64; sky.len()]; window.basis.len()];
    for ring in window.basis.rings() {
        let width = TAU / ring.bins as f64;
        let cos2 = |degrees: f64| if degrees >= 90.0 { 0.0 } else { degrees.to_radians().cos().powi(2) };
        let (from, to) = (cos2(ring.theta_min), cos2(ring.theta_max));
        let circles: Vec<Vec<(usize, usize, f64)>> = (0..CIRCLES)
            .into_par_iter()
            .map(|i| {
                let cos = (from + (to - from) * (i as f64 + 0.5) / CIRCLES as f64).sqrt();
                arcs(window, sky, cos, ring.bins).into_iter().map(|(bin, patch, arc)| (ring.first + bin, patch, arc / width)).collect()
            })
            .collect();
        // In order, so that the sums do not depend on the threads.
        for (bin, patch, share) in circles.into_iter().flatten() {
            rows[bin][patch] += share / CIRCLES as f64;
        }
    }
    let data = rows.iter().flatten().flat_map(|&v| [v as f32; 3]).collect();
    Matrix::from_data(window.basis.len(), sky.len(), 3, data).expect("a row per bin")
}

/// The circle of directions at this cosine to the window's normal, cut at the borders of `bins` bins
/// and of the sky's patches: bin within the ring, patch, and length of the arc.
fn arcs(window: &Window, sky: ReinhartSky, cos: f64, bins: usize) -> Vec<(usize, usize, f64)> {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    // Towards the light: against its travel.
    let [x, y, z] = [window.frame.x * -sin, window.frame.y * -sin, window.frame.z * -cos];
    let direction = |phi: f64| x * phi.cos() + y * phi.sin() + z;
    let mut cuts: Vec<f64> = (0..bins).map(|b| (b as f64 + 0.5) * TAU / bins as f64).collect();
    // Azimuths at which the direction's component along `axis` is `value`.
    let mut cut = |axis: DVec3, value: f64| {
        let (a, b) = (x.dot(axis), y.dot(axis));
        let (length, rest) = (a.hypot(b), value - z.dot(axis));
        if rest.abs() < length {
            let (middle, half) = (b.atan2(a), (rest / length).acos());
            cuts.extend([middle - half, middle + half].map(|phi| phi.rem_euclid(TAU)));
        }
    };
    let mut counts: Vec<usize> = sky.rows().map(|(_, patches)| patches).collect();
    for row in 0..=counts.len() {
        cut(DVec3::Z, (row as f64 * sky.row_height()).sin());
    }
    counts.sort_unstable();
    counts.dedup();
    for patches in counts {
        for patch in 0..patches {
            let azimuth = (patch as f64 + 0.5) * TAU / patches as f64;
            // The meridian's normal.
            cut(DVec3::new(azimuth.cos(), -azimuth.sin(), 0.0), 0.0);
        }
    }
    cuts.sort_by(f64::total_cmp);
    let last = cuts.last().copied().unwrap_or(0.0) - TAU;
    std::iter::once(last)
        .chain(cuts.iter().copied())
        .collect::<Vec<_>>()
        .windows(2)
        .filter(|pair| pair[1] > pair[0])
        .map(|pair| {
            let middle = (pair[0] + pair[1]) / 2.0;
            let bin = (middle / TAU * bins as f64 + 0.5).floor() as i64;
            (bin.rem_euclid(bins as i64) as usize, sky.bin_of(direction(middle)), pair[1] - pair[0])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::kernels::daylight_matrix::reference::daylight_row;
    use crate::kernels::trace::rooms::{Builder, window};

    fn tilted() -> Window {
        let corners = [[0.0, 0.0, 3.0], [1.0, 0.0, 3.2], [1.0, 1.0, 3.7], [0.0, 1.0, 3.5]];
        window(corners, DVec3::new(0.2, 0.5, -1.0).normalize(), DVec3::Z, KlemsBasis::Quarter)
    }

    #[test]
    fn shares_are_those_that_sampling_finds() {
        let w = tilted();
        for subdivision in [1, 2] {
            let sky = ReinhartSky::new(subdivision).unwrap();
            let d = compute(&w, sky);
            for bin in 0..w.basis.len() {
                let sum: f64 = (0..sky.len()).map(|p| f64::from(d.at(bin, p)[1])).sum();
                assert!((sum - 1.0).abs() < 1e-6, "{bin}: {sum}");
            }
            let n = 200_000;
            for bin in [0, 3, 11, 20, 29, 40] {
                let row = daylight_row(&Scene::default(), &w, bin, sky, 0, n, 7 + bin as u64);
                for (patch, wanted) in row.iter().enumerate() {
                    let found = f64::from(d.at(bin, patch)[1]);
                    let wanted = wanted[1].mean(n);
                    let error = (found.max(1e-5) / n as f64).sqrt();
                    assert!((found - wanted).abs() < 5.0 * error, "MF:{subdivision}, bin {bin}, patch {patch}: {found} {wanted} ± {error}");
                }
            }
        }
    }

    #[test]
    fn finer_circles_change_less_than_the_tolerance() {
        // Against ring by ring sums with 16 times the circles, which differ by a 64th of the error.
        let (w, sky) = (tilted(), ReinhartSky::new(1).unwrap());
        let d = compute(&w, sky);
        let mut largest: f64 = 0.0;
        for ring in w.basis.rings() {
            let cos2 = |degrees: f64| degrees.to_radians().cos().powi(2);
            let (from, to) = (cos2(ring.theta_min), cos2(ring.theta_max));
            let fine = 16 * CIRCLES;
            let mut shares = vec![vec![0.0; sky.len()]; ring.bins];
            for i in 0..fine {
                let cos = (from + (to - from) * (i as f64 + 0.5) / fine as f64).max(0.0).sqrt();
                for (bin, patch, arc) in arcs(&w, sky, cos, ring.bins) {
                    shares[bin][patch] += arc * ring.bins as f64 / TAU / fine as f64;
                }
            }
            for (bin, row) in shares.iter().enumerate() {
                for (patch, wanted) in row.iter().enumerate() {
                    largest = largest.max((f64::from(d.at(ring.first + bin, patch)[0]) - wanted).abs());
                }
            }
        }
        eprintln!("quadrature of an unobstructed D: entries within {largest:.1e}");
        assert!(largest < TOLERANCE / 2.0 && largest > 0.0, "{largest}");
    }

    #[test]
    fn what_stands_before_a_window_is_seen() {
        let w = tilted();
        let mut b = Builder::default();
        b.material(MaterialKind::Plastic { color: [0.5; 3], specularity: 0.0, roughness: 0.0 });
        assert!(nothing_before(&b.scene, &w));
        let with = |z: f64| {
            let vertices = [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]].map(DVec3::from_array);
            let triangle = crate::scene::Triangle { vertices, material: crate::scene::MaterialIndex(0), surface: 0 };
            Scene { triangles: vec![triangle], ..b.scene.clone() }
        };
        assert!(nothing_before(&with(0.0), &w), "the room below");
        assert!(!nothing_before(&with(10.0), &w), "a roof above");
        let mut air = with(10.0);
        air.materials[0].kind = MaterialKind::Void;
        assert!(nothing_before(&air, &w));
        // Windows absorb: the own one does not stand before itself, another one may.
        let beside =
            |z: f64| window([[3.0, 0.0, z], [4.0, 0.0, z], [4.0, 1.0, z], [3.0, 1.0, z]], DVec3::NEG_Z, DVec3::Y, KlemsBasis::Full);
        let windows = |z: f64| Scene { windows: vec![w.clone(), beside(z)], ..b.scene.clone() };
        assert!(nothing_before(&windows(0.0), &w) && !nothing_before(&windows(10.0), &w));
    }
}

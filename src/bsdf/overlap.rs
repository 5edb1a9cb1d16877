//! How bins of one division of the hemisphere overlap those of another, measured in projected
//! solid angle.
//!
//! In the Shirley-Chiu square a ring of constant polar angle is the region between two concentric
//! squares and a line of constant azimuth is straight, while areas are projected solid angles / π.
//! So every bin of a ring basis is made of trapezoids there, and its overlap with a cell of a
//! tensor tree is the area of a clipped polygon: exact, without sampling.

use crate::bins::AngleBasis;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// For every bin of a division, the bins of another that it overlaps and by how much, sr.
pub(super) type Overlaps = Vec<Vec<(usize, f64)>>;

/// Overlaps of the cells of an n × n grid over the square, `cell = ix * n + iy`, with the bins.
pub(super) fn grid_with_basis(n: usize, basis: &AngleBasis) -> Overlaps {
    let mut overlaps = vec![Vec::new(); n * n];
    for bin in 0..basis.len() {
        for piece in trapezoids(basis, bin) {
            let bound = |axis: usize, end: fn(f64, f64) -> f64| piece.iter().map(|p| p[axis]).reduce(end).unwrap_or(0.0) * n as f64;
            let first = |axis| (bound(axis, f64::min) - 1e-9).floor().max(0.0) as usize;
            let last = |axis| (bound(axis, f64::max) + 1e-9).floor().min(n as f64 - 1.0) as usize;
            for ix in first(0)..=last(0) {
                for iy in first(1)..=last(1) {
                    let area = clipped_area(&piece, ix as f64 / n as f64, iy as f64 / n as f64, 1.0 / n as f64) * PI;
                    if area > 1e-14 {
                        add(&mut overlaps[ix * n + iy], bin, area);
                    }
                }
            }
        }
    }
    overlaps
}

/// Overlaps of the bins of `from` with those of `to`.
pub(super) fn basis_with_basis(from: &AngleBasis, to: &AngleBasis) -> Overlaps {
    let interval = |basis: &AngleBasis, bin: usize| {
        let (ring, position) = basis.ring_of(bin);
        let width = TAU / ring.bins as f64;
        let middle = position as f64 * width;
        let sin2 = |deg: f64| if deg >= 90.0 { 1.0 } else { deg.to_radians().sin().powi(2) };
        (sin2(ring.theta_min), sin2(ring.theta_max), middle - width / 2.0, middle + width / 2.0)
    };
    let others: Vec<_> = (0..to.len()).map(|b| interval(to, b)).collect();
    (0..from.len())
        .map(|bin| {
            let (s0, s1, a0, a1) = interval(from, bin);
            let mut row = Vec::new();
            for (other, &(t0, t1, b0, b1)) in others.iter().enumerate() {
                let rings = s1.min(t1) - s0.max(t0);
                if rings <= 1e-13 {
                    continue;
                }
                // The same azimuth may appear a turn away.
                let azimuths: f64 = [-TAU, 0.0, TAU].iter().map(|turn| (a1.min(b1 + turn) - a0.max(b0 + turn)).max(0.0)).sum();
                let overlap = rings * azimuths / 2.0;
                if overlap > 1e-14 {
                    row.push((other, overlap));
                }
            }
            row
        })
        .collect()
}

fn add(row: &mut Vec<(usize, f64)>, bin: usize, amount: f64) {
    match row.iter_mut().find(|(b, _)| *b == bin) {
        Some((_, sum)) => *sum += amount,
        None => row.push((bin, amount)),
    }
}

/// The convex pieces of a bin in the unit square, counter-clockwise.
fn trapezoids(basis: &AngleBasis, bin: usize) -> Vec<Vec<[f64; 2]>> {
    let (ring, position) = basis.ring_of(bin);
    let sin = |deg: f64| if deg >= 90.0 { 1.0 } else { deg.to_radians().sin() };
    let (r0, r1) = (sin(ring.theta_min), sin(ring.theta_max));
    let width = TAU / ring.bins as f64;
    let start = (position as f64 - 0.5) * width;
    let end = start + width;
    // Cut where the square turns a corner.
    let mut cuts = vec![start];
    let first = ((start - FRAC_PI_4) / FRAC_PI_2).floor() as i64 + 1;
    cuts.extend((first..first + 5).map(|k| FRAC_PI_4 + k as f64 * FRAC_PI_2).filter(|c| *c > start + 1e-12 && *c < end - 1e-12));
    cuts.push(end);
    let piece = |w: &[f64]| {
        let sector = ((w[0] + w[1]) / 2.0 / FRAC_PI_2).round();
        let mut corners = vec![point(r0, w[0], sector), point(r1, w[0], sector), point(r1, w[1], sector)];
        if r0 > 0.0 {
            corners.push(point(r0, w[1], sector));
        }
        corners
    };
    cuts.windows(2).map(piece).collect()
}

/// Radius and azimuth to the unit square, in the sector centred on `sector` · 90°.
fn point(r: f64, phi: f64, sector: f64) -> [f64; 2] {
    let along = (phi - sector * FRAC_PI_2) / FRAC_PI_4 * r;
    let (a, b) = match (sector as i64).rem_euclid(4) {
        0 => (r, along),
        1 => (-along, r),
        2 => (-r, -along),
        _ => (along, -r),
    };
    [(a + 1.0) / 2.0, (b + 1.0) / 2.0]
}

/// Area of a convex polygon inside the square with this lower corner and side.
fn clipped_area(polygon: &[[f64; 2]], x: f64, y: f64, side: f64) -> f64 {
    let mut points = polygon.to_vec();
    for (axis, limit, keep_above) in [(0, x, true), (0, x + side, false), (1, y, true), (1, y + side, false)] {
        let distance = |p: &[f64; 2]| if keep_above { p[axis] - limit } else { limit - p[axis] };
        let mut kept = Vec::with_capacity(points.len() + 2);
        for (i, p) in points.iter().enumerate() {
            let q = &points[(i + 1) % points.len()];
            let (dp, dq) = (distance(p), distance(q));
            if dp >= 0.0 {
                kept.push(*p);
            }
            if dp * dq < 0.0 {
                let t = dp / (dp - dq);
                kept.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
        }
        if kept.len() < 3 {
            return 0.0;
        }
        points = kept;
    }
    let twice: f64 = (0..points.len())
        .map(|i| {
            let (p, q) = (points[i], points[(i + 1) % points.len()]);
            p[0] * q[1] - q[0] * p[1]
        })
        .sum();
    twice.abs() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::bins::shirley_chiu::disk_from_square;
    use glam::DVec3;

    #[test]
    fn overlaps_with_a_grid_add_up_on_both_sides() {
        for basis in KlemsBasis::ALL.map(AngleBasis::from) {
            for n in [1, 2, 7, 16] {
                let overlaps = grid_with_basis(n, &basis);
                let mut per_bin = vec![0.0; basis.len()];
                for row in &overlaps {
                    let sum: f64 = row.iter().map(|(_, a)| a).sum();
                    assert!((sum - PI / (n * n) as f64).abs() < 1e-10, "{sum}");
                    for (bin, a) in row {
                        per_bin[*bin] += a;
                    }
                }
                for (bin, sum) in per_bin.iter().enumerate() {
                    assert!((sum - basis.projected_solid_angle(bin)).abs() < 1e-10, "{} bin {bin}: {sum}", basis.name());
                }
            }
        }
    }

    #[test]
    fn overlaps_with_a_grid_agree_with_counting_points() {
        let basis = AngleBasis::from(KlemsBasis::Full);
        let (n, sub) = (8, 60);
        let overlaps = grid_with_basis(n, &basis);
        for cell in [0, 9, 27, 36, 63] {
            let mut counted = vec![0.0; basis.len()];
            for k in 0..sub * sub {
                let u = ((cell / n) as f64 + ((k / sub) as f64 + 0.5) / sub as f64) / n as f64;
                let v = ((cell % n) as f64 + ((k % sub) as f64 + 0.5) / sub as f64) / n as f64;
                let [x, y] = disk_from_square(u, v);
                let direction = DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
                counted[basis.bin_of(direction)] += PI / (n * n * sub * sub) as f64;
            }
            for (bin, count) in counted.iter().enumerate() {
                let exact = overlaps[cell].iter().find(|(b, _)| *b == bin).map_or(0.0, |(_, a)| *a);
                // Points along the edges: about 1/60 of the cell at most.
                assert!((exact - count).abs() < 0.02 * PI / 64.0, "cell {cell} bin {bin}: {exact} {count}");
            }
        }
    }

    #[test]
    fn overlaps_of_two_bases_add_up() {
        for a in KlemsBasis::ALL.map(AngleBasis::from) {
            for b in KlemsBasis::ALL.map(AngleBasis::from) {
                let overlaps = basis_with_basis(&a, &b);
                let mut per_bin = vec![0.0; b.len()];
                for (bin, row) in overlaps.iter().enumerate() {
                    assert!((row.iter().map(|(_, s)| s).sum::<f64>() - a.projected_solid_angle(bin)).abs() < 1e-12);
                    row.iter().for_each(|(other, s)| per_bin[*other] += s);
                }
                for (bin, sum) in per_bin.iter().enumerate() {
                    assert!((sum - b.projected_solid_angle(bin)).abs() < 1e-12);
                }
                if a == b {
                    assert!(overlaps.iter().enumerate().all(|(i, row)| row.len() == 1 && row[0].0 == i));
                }
            }
        }
    }
}

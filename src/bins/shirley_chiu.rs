//! The concentric map between the unit square and the unit disk (Shirley and Chiu 1997), with disk
//! radius = sin θ, so that equal areas of the square are equal *projected* solid angles. The
//! coordinates of Radiance's tensor trees (`disk2square.c`).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Unit disk to unit square. The +x axis of the disk leads to large first coordinates.
pub fn square_from_disk(x: f64, y: f64) -> [f64; 2] {
    let r = x.hypot(y).min(1.0);
    let mut phi = y.atan2(x);
    if phi < -FRAC_PI_4 {
        phi += 2.0 * PI;
    }
    let (a, b) = if phi < FRAC_PI_4 {
        (r, phi * r / FRAC_PI_4)
    } else if phi < 3.0 * FRAC_PI_4 {
        (-(phi - FRAC_PI_2) * r / FRAC_PI_4, r)
    } else if phi < 5.0 * FRAC_PI_4 {
        (-r, -(phi - PI) * r / FRAC_PI_4)
    } else {
        ((phi - 3.0 * FRAC_PI_2) * r / FRAC_PI_4, -r)
    };
    // Strictly inside the square, so that an index floor(coordinate × n) is always below n.
    let inside = |c: f64| ((c + 1.0) / 2.0).clamp(0.0, 1.0 - 1e-12);
    [inside(a), inside(b)]
}

/// Unit square to unit disk.
pub fn disk_from_square(u: f64, v: f64) -> [f64; 2] {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    let (r, phi) = if a.abs() > b.abs() { (a, FRAC_PI_4 * (b / a)) } else { (b, FRAC_PI_2 - FRAC_PI_4 * (a / b)) };
    [r * phi.cos(), r * phi.sin()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_maps_are_inverse_to_each_other() {
        for i in 0..40 {
            for j in 0..40 {
                let (u, v) = ((i as f64 + 0.5) / 40.0, (j as f64 + 0.3) / 40.0);
                let [x, y] = disk_from_square(u, v);
                assert!(x * x + y * y <= 1.0 + 1e-12);
                let [u2, v2] = square_from_disk(x, y);
                assert!((u - u2).abs() < 1e-9 && (v - v2).abs() < 1e-9, "{u} {v} -> {x} {y} -> {u2} {v2}");
            }
        }
        assert!(square_from_disk(1.0, 0.0)[0] > 0.999);
    }

    #[test]
    fn every_cell_has_the_same_area_on_the_disk() {
        // Midpoint sampling of the disk: each of 4 × 4 cells receives π/16 of the area.
        let n = 1000;
        let mut hits = [0usize; 16];
        let mut total = 0usize;
        for i in 0..n {
            for j in 0..n {
                let (x, y) = ((i as f64 + 0.5) / n as f64 * 2.0 - 1.0, (j as f64 + 0.5) / n as f64 * 2.0 - 1.0);
                if x * x + y * y < 1.0 {
                    let [u, v] = square_from_disk(x, y);
                    hits[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
                    total += 1;
                }
            }
        }
        for h in hits {
            assert!((h as f64 / total as f64 * 16.0 - 1.0).abs() < 0.01);
        }
    }
}

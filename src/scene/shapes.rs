//! Curved surfaces, cut into triangles.
//!
//! Corners lie on the true surface. A chord departs from its arc by at most `1 - cos(π/n)` of the
//! radius: 2.4e-4 around cylinders, cones and rings, 9.5e-4 on spheres. Spheres take every second
//! corner of a circle, and circles about the same axis share their corners, so that a cylinder and
//! the ring that closes it leave no gap.

use crate::error::{Error, Result};
use glam::DVec3;
use std::f64::consts::TAU;

/// Segments of a full circle around cylinders, cones and rings (a multiple of 8).
pub(crate) const CIRCLE_SEGMENTS: usize = 144;

/// Segments of a sphere's equator; half as many from pole to pole.
pub(crate) const SPHERE_SEGMENTS: usize = CIRCLE_SEGMENTS / 2;

/// Triangles of a sphere, seen from outside counter-clockwise. Poles along z.
pub(crate) fn sphere(centre: DVec3, radius: f64) -> Vec<[DVec3; 3]> {
    let stacks = SPHERE_SEGMENTS / 2;
    let circle = unit_circle(SPHERE_SEGMENTS);
    let at = |stack: usize, segment: usize| {
        let [sin, cos] = match stack {
            0 => [0.0, 1.0],
            s if s == stacks => [0.0, -1.0],
            // The meridian takes the same corners as the equator.
            s => [circle[s][1], circle[s][0]],
        };
        let [x, y] = circle[segment % SPHERE_SEGMENTS];
        centre + DVec3::new(x * sin, y * sin, cos) * radius
    };
    let mut triangles = Vec::with_capacity(2 * SPHERE_SEGMENTS * (stacks - 1));
    for stack in 0..stacks {
        for segment in 0..SPHERE_SEGMENTS {
            let (a, b) = (at(stack, segment), at(stack, segment + 1));
            let (c, d) = (at(stack + 1, segment + 1), at(stack + 1, segment));
            if stack > 0 {
                triangles.push([a, c, b]);
            }
            if stack + 1 < stacks {
                triangles.push([a, d, c]);
            }
        }
    }
    triangles
}

/// Triangles of a truncated cone's mantle (radius `r0` around `p0`, `r1` around `p1`), seen from
/// outside counter-clockwise. Equal radii make a cylinder.
///
/// # Errors
/// If the ends coincide.
pub(crate) fn cone(p0: DVec3, p1: DVec3, r0: f64, r1: f64) -> Result<Vec<[DVec3; 3]>> {
    let axis = (p1 - p0).try_normalize().ok_or_else(|| Error::new("its ends coincide, so that it has no direction"))?;
    let circle = circle_about(axis);
    let mut triangles = Vec::with_capacity(2 * CIRCLE_SEGMENTS);
    for i in 0..CIRCLE_SEGMENTS {
        let (u, v) = (circle[i], circle[(i + 1) % CIRCLE_SEGMENTS]);
        let (a, b, c, d) = (p0 + u * r0, p0 + v * r0, p1 + v * r1, p1 + u * r1);
        if r0 > 0.0 {
            triangles.push([a, b, c]);
        }
        if r1 > 0.0 {
            triangles.push([a, c, d]);
        }
    }
    Ok(triangles)
}

/// Triangles of a disk or annulus whose front is towards `normal`.
///
/// # Errors
/// If the normal has no direction.
pub(crate) fn ring(centre: DVec3, normal: DVec3, inner: f64, outer: f64) -> Result<Vec<[DVec3; 3]>> {
    let normal = normal.try_normalize().ok_or_else(|| Error::new("its normal is zero, so that it has no direction"))?;
    let circle = circle_about(normal);
    let mut triangles = Vec::with_capacity(2 * CIRCLE_SEGMENTS);
    for i in 0..CIRCLE_SEGMENTS {
        let (u, v) = (circle[i], circle[(i + 1) % CIRCLE_SEGMENTS]);
        let (a, b, c, d) = (centre + u * inner, centre + u * outer, centre + v * outer, centre + v * inner);
        triangles.push([a, b, c]);
        if inner > 0.0 {
            triangles.push([a, c, d]);
        }
    }
    Ok(triangles)
}

/// Unit vectors around an axis, counter-clockwise seen against it. Both directions of an axis give
/// the same vectors (in opposite order), and rounding errors of the axis do not turn them.
fn circle_about(axis: DVec3) -> Vec<DVec3> {
    let leading = axis.to_array().into_iter().find(|c| c.abs() > 1e-9).unwrap_or(1.0);
    let main = if leading < 0.0 { -axis } else { axis };
    // At least one coordinate axis is this far from any direction (1/√3 at worst); usual axes are
    // far from the limit.
    let helper = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().find(|h| h.dot(main).abs() < 0.5873).unwrap_or(DVec3::Z);
    let v = main.cross(helper).normalize();
    let u = v.cross(main);
    let mut circle: Vec<DVec3> = unit_circle(CIRCLE_SEGMENTS).into_iter().map(|[x, y]| u * x + v * y).collect();
    if main != axis {
        circle.reverse();
    }
    circle
}

/// Cosines and sines around the circle, exact at quarter turns.
fn unit_circle(segments: usize) -> Vec<[f64; 2]> {
    let quarter = segments / 4;
    let first: Vec<[f64; 2]> = (0..quarter)
        .map(|i| {
            let (sin, cos) = (TAU * i as f64 / segments as f64).sin_cos();
            [cos, sin]
        })
        .collect();
    let turned = |turns: usize, [x, y]: [f64; 2]| [[x, y], [-y, x], [-x, -y], [y, -x]][turns];
    (0..4).flat_map(|turns| first.iter().map(move |&p| turned(turns, p))).collect()
}

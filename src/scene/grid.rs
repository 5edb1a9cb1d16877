//! Sensors in even rows over surfaces: nobody writes a work plane by hand.

use super::points::Sensor;
use crate::error::{Error, Result};
use crate::limits;
use glam::{DVec2, DVec3};

/// How sensors are spread over surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Distance between sensors.
    pub spacing: f64,
    /// Height above the surface.
    pub height: f64,
    /// Least distance from the surface's edge.
    pub margin: f64,
}

/// Planes that are nearer than this to each other are one.
const SAME_PLANE: f64 = 1e-3;

/// Directions in which the edge is looked for: the margin is kept to 0.1 %.
const AROUND: usize = 64;

/// A plane with its triangles, all counter-clockwise about `facing`.
struct Plane {
    facing: DVec3,
    offset: f64,
    triangles: Vec<[DVec3; 3]>,
}

/// Sensors over triangles, plane by plane, at the centres of squares that lie along its longest edge. Over
/// surfaces that lie flat they face up, whichever side is their front; over others they face as the front does.
/// Of planes above each other the uppermost below a sensor counts.
///
/// # Errors
/// Triangles without area, more sensors than [`limits::GRID_POINTS`], none at all.
pub(crate) fn over(triangles: &[[DVec3; 3]], spread: &Spread) -> Result<Vec<Sensor>> {
    let planes = planes(triangles);
    if planes.is_empty() {
        return Err(Error::new("the surface has no area").help("name a surface or material that covers the floor"));
    }
    let mut sensors: Vec<Sensor> = Vec::new();
    for plane in &planes {
        for foot in feet(plane, spread)? {
            let position = foot + plane.facing * spread.height;
            // A slab has an upper and a lower face.
            if triangles.iter().any(|t| lies_between(t, foot, plane.facing, spread.height)) {
                continue;
            }
            sensors.push(Sensor { position, direction: plane.facing, line: sensors.len() + 1 });
        }
    }
    if sensors.is_empty() {
        return Err(Error::new(format!("no point keeps a margin of {} from the edge", spread.margin)).help("give a smaller margin"));
    }
    Ok(sensors)
}

fn planes(triangles: &[[DVec3; 3]]) -> Vec<Plane> {
    let mut planes: Vec<Plane> = Vec::new();
    for &[a, b, c] in triangles {
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        let flat = normal.truncate().length() <= 1f64.to_radians().sin();
        let turned = flat && normal.z < 0.0;
        let facing = if flat { DVec3::Z } else { normal };
        let triangle = if turned { [a, c, b] } else { [a, b, c] };
        let offset = facing.dot((a + b + c) / 3.0);
        match planes.iter_mut().find(|p| p.facing.dot(facing) > 1.0 - 1e-6 && (p.offset - offset).abs() < SAME_PLANE) {
            Some(plane) => plane.triangles.push(triangle),
            None => planes.push(Plane { facing, offset, triangles: vec![triangle] }),
        }
    }
    planes
}

/// Points of a plane below its sensors.
fn feet(plane: &Plane, spread: &Spread) -> Result<Vec<DVec3>> {
    let along = longest_edge(plane);
    let across = plane.facing.cross(along);
    let flat = |p: DVec3| DVec2::new(p.dot(along), p.dot(across));
    let triangles: Vec<[DVec2; 3]> = plane.triangles.iter().map(|t| t.map(flat)).collect();
    let corners = || triangles.iter().flatten();
    let low = corners().fold(DVec2::INFINITY, |a, b| a.min(*b));
    let high = corners().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
    let [columns, rows] = (high - low).to_array().map(|extent| ((extent - 2.0 * spread.margin) / spread.spacing + 1e-6).floor().max(1.0));
    if columns * rows > limits::GRID_POINTS as f64 {
        return Err(limits::exceeded("the surface has room for", limits::GRID_POINTS, "sensors").help("give a larger spacing"));
    }
    let tolerance = 1e-9 * (high - low).max_element();
    let covers = |p: DVec2| triangles.iter().any(|t| holds(t, p, tolerance));
    let around: Vec<DVec2> =
        (0..AROUND).map(|k| DVec2::from_angle(std::f64::consts::TAU * k as f64 / AROUND as f64) * spread.margin).collect();
    let first = (low + high) / 2.0 - DVec2::new(columns - 1.0, rows - 1.0) / 2.0 * spread.spacing;
    let mut feet = Vec::new();
    for row in 0..rows as usize {
        for column in 0..columns as usize {
            let p = first + DVec2::new(column as f64, row as f64) * spread.spacing;
            if covers(p) && (spread.margin == 0.0 || around.iter().all(|d| covers(p + *d))) {
                feet.push(along * p.x + across * p.y + plane.facing * plane.offset);
            }
        }
    }
    Ok(feet)
}

/// Direction of the longest edge that no two triangles share.
fn longest_edge(plane: &Plane) -> DVec3 {
    let bits = |p: DVec3| p.to_array().map(f64::to_bits);
    let edges = || plane.triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    let shared: std::collections::HashSet<_> = edges().map(|[a, b]| (bits(a), bits(b))).collect();
    let mut longest = DVec3::ZERO;
    for [a, b] in edges().filter(|[a, b]| !shared.contains(&(bits(*b), bits(*a)))) {
        // Of edges of the same length the first, but for rounding.
        if (b - a).length() > longest.length() * (1.0 + 1e-9) {
            longest = b - a;
        }
    }
    let edge = longest - plane.facing * longest.dot(plane.facing);
    let unit = edge.try_normalize().unwrap_or_else(|| plane.facing.any_orthonormal_vector());
    // One of the two ways along it, whichever way the outline was drawn.
    let leading = unit.to_array().into_iter().find(|c| c.abs() > 1e-9).unwrap_or(1.0);
    if leading < 0.0 { -unit } else { unit }
}

fn holds([a, b, c]: &[DVec2; 3], p: DVec2, tolerance: f64) -> bool {
    [(a, b), (b, c), (c, a)].iter().all(|(from, to)| {
        let edge = **to - **from;
        edge.perp_dot(p - **from) >= -tolerance * edge.length()
    })
}

/// Whether a triangle lies above a foot and below its sensor.
fn lies_between([a, b, c]: &[DVec3; 3], foot: DVec3, facing: DVec3, height: f64) -> bool {
    let (ab, ac) = (*b - *a, *c - *a);
    let normal = ab.cross(ac);
    let slope = normal.dot(facing);
    if slope.abs() <= 1e-12 * normal.length() {
        return false;
    }
    let distance = normal.dot(*a - foot) / slope;
    if !(distance > SAME_PLANE && distance <= height) {
        return false;
    }
    let at = foot + facing * distance;
    let side = |p: DVec3, q: DVec3| (q - p).cross(at - p).dot(normal) >= 0.0;
    side(*a, *b) && side(*b, *c) && side(*c, *a)
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: DVec3 = DVec3::new(0.0, 0.0, 1.0);
    const C: DVec3 = DVec3::new(4.0, 3.0, 1.0);
    const FOUR_BY_THREE: [[DVec3; 3]; 2] = [[A, DVec3::new(4.0, 0.0, 1.0), C], [A, C, DVec3::new(0.0, 3.0, 1.0)]];

    fn spread(spacing: f64, height: f64, margin: f64) -> Spread {
        Spread { spacing, height, margin }
    }

    fn places(sensors: &[Sensor]) -> Vec<[f64; 3]> {
        sensors.iter().map(|s| s.position.to_array().map(|v| (v * 1e9).round() / 1e9)).collect()
    }

    #[test]
    fn sensors_stand_at_the_centres_of_squares_and_keep_the_margin() {
        let s = over(&FOUR_BY_THREE, &spread(1.0, 0.8, 0.0)).unwrap();
        assert_eq!(s.len(), 12);
        assert_eq!(places(&s)[..5], [[0.5, 0.5, 1.8], [1.5, 0.5, 1.8], [2.5, 0.5, 1.8], [3.5, 0.5, 1.8], [0.5, 1.5, 1.8]]);
        assert!(s.iter().enumerate().all(|(i, s)| s.direction == DVec3::Z && s.line == i + 1));
        // Half a metre from every wall: 3 by 2 metres are left, with 6 by 4 squares.
        let s = over(&FOUR_BY_THREE, &spread(0.5, 0.8, 0.5)).unwrap();
        assert_eq!((s.len(), places(&s)[0], places(&s)[23]), (24, [0.75, 0.75, 1.8], [3.25, 2.25, 1.8]));
        // What does not divide evenly lies in the middle.
        let s = over(&FOUR_BY_THREE, &spread(1.5, 0.0, 0.0)).unwrap();
        assert_eq!(places(&s), [[1.25, 0.75, 1.0], [2.75, 0.75, 1.0], [1.25, 2.25, 1.0], [2.75, 2.25, 1.0]]);
        assert!(over(&FOUR_BY_THREE, &spread(0.5, 0.8, 1.6)).unwrap_err().message().contains("margin"));
        assert!(over(&FOUR_BY_THREE, &spread(1e-4, 0.8, 0.0)).unwrap_err().message().contains("room for"));
        assert!(over(&[[DVec3::ZERO; 3]], &spread(0.5, 0.8, 0.0)).unwrap_err().message().contains("no area"));
    }

    #[test]
    fn rows_lie_along_the_longest_wall_and_face_up_from_either_side() {
        let turn = glam::DMat3::from_rotation_z(0.4);
        let turned = FOUR_BY_THREE.map(|t| t.map(|p| turn * p));
        let back = FOUR_BY_THREE.map(|[a, b, c]| [a, c, b]);
        let straight = places(&over(&FOUR_BY_THREE, &spread(1.0, 0.8, 0.0)).unwrap());
        assert_eq!(places(&over(&back, &spread(1.0, 0.8, 0.0)).unwrap()), straight);
        let s = over(&turned, &spread(1.0, 0.8, 0.0)).unwrap();
        for (a, b) in s.iter().zip(&straight) {
            assert!((turn.transpose() * a.position - DVec3::from_array(*b)).length() < 1e-9);
        }
        // A wall's sensors face as its front does.
        let wall = FOUR_BY_THREE.map(|t| t.map(|p| DVec3::new(p.x, 0.0, p.y)));
        let s = over(&wall, &spread(1.0, 0.1, 0.0)).unwrap();
        assert!(s.iter().all(|s| (s.direction - DVec3::NEG_Y).length() < 1e-12 && (s.position.y + 0.1).abs() < 1e-12) && s.len() == 12);
    }

    #[test]
    fn holes_stay_empty_and_the_lower_face_of_a_slab_has_no_sensors() {
        // A frame around a hole of 2 by 1, as four rectangles that share no corners.
        let box_of = |x0: f64, x1: f64, y0: f64, y1: f64, z: f64| {
            let p = |x, y| DVec3::new(x, y, z);
            [[p(x0, y0), p(x1, y0), p(x1, y1)], [p(x0, y0), p(x1, y1), p(x0, y1)]]
        };
        let frame: Vec<[DVec3; 3]> =
            [box_of(0., 4., 0., 1., 0.), box_of(0., 4., 2., 3., 0.), box_of(0., 1., 1., 2., 0.), box_of(3., 4., 1., 2., 0.)].concat();
        let s = over(&frame, &spread(1.0, 0.8, 0.0)).unwrap();
        assert_eq!(s.len(), 10);
        assert!(s.iter().all(|s| !(s.position.x > 1.0 && s.position.x < 3.0 && s.position.y > 1.0 && s.position.y < 2.0)));
        // Seams are no edges.
        let s = over(&frame, &spread(0.9, 0.8, 0.2)).unwrap();
        assert_eq!(places(&s), [[0.65, 1.05, 0.8], [3.35, 1.05, 0.8], [0.65, 1.95, 0.8], [3.35, 1.95, 0.8]]);
        let slab: Vec<[DVec3; 3]> = [box_of(0., 4., 0., 3., 0.), box_of(0., 4., 0., 3., -0.2)].concat();
        let s = over(&slab, &spread(1.0, 0.8, 0.0)).unwrap();
        assert_eq!(s.len(), 12);
        assert!(s.iter().all(|s| s.position.z == 0.8));
        // Two storeys are two planes.
        let storeys: Vec<[DVec3; 3]> = [box_of(0., 4., 0., 3., 0.), box_of(0., 4., 0., 3., 3.)].concat();
        assert_eq!(over(&storeys, &spread(1.0, 0.8, 0.0)).unwrap().len(), 24);
    }
}

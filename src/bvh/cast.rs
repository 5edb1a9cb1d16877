//! Rays on the host: for checks that need a few thousand, before any device is opened.

use super::PaddedTriangle;
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::ray::{Ray, RayHit};

/// The least part of a direction along an axis by which boxes are searched; triangles are met along the direction itself.
const STILL: f64 = 1e-9;

/// Triangles that rays can meet. The search is in f32 near the triangles' middle, distances are in f64.
pub(crate) struct Caster {
    bvh: CwBvh,
    triangles: Vec<[DVec3; 3]>,
    middle: DVec3,
}

impl Caster {
    /// Nothing without triangles.
    pub(crate) fn new(triangles: Vec<[DVec3; 3]>) -> Option<Self> {
        if triangles.is_empty() {
            return None;
        }
        let corners = || triangles.iter().flatten();
        let low = corners().fold(DVec3::INFINITY, |a, b| a.min(*b));
        let high = corners().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b));
        let middle = (low + high) / 2.0;
        let padded: Vec<PaddedTriangle> = triangles.iter().map(|t| PaddedTriangle(t.map(|p| (p - middle).as_vec3()))).collect();
        let bvh = build_cwbvh(&padded, BvhBuildParams::medium_build(), &mut std::time::Duration::default());
        Some(Self { bvh, triangles, middle })
    }

    /// Distance to the nearest triangle farther than `least`, and its number.
    pub(crate) fn nearest(&self, origin: DVec3, direction: DVec3, least: f64) -> Option<(f64, usize)> {
        let at = |v: DVec3| Vec3A::from(v.as_vec3());
        // Boxes of no depth are missed by a ray that stands still along one axis: 0 times its endless inverse is no number.
        let moving = DVec3::from(direction.to_array().map(|c| if c.abs() < STILL { STILL.copysign(c) } else { c }));
        let ray = Ray::new(at(origin - self.middle), at(moving), 0.0, f32::MAX);
        let mut found: Option<(f64, usize)> = None;
        self.bvh.ray_traverse(ray, &mut RayHit::none(), |_, place| {
            let number = self.bvh.primitive_indices[place] as usize;
            match intersect(&self.triangles[number], origin, direction) {
                Some(d) if d > least && found.is_none_or(|(nearest, _)| d < nearest) => {
                    found = Some((d, number));
                    // Rounded up, so that the search never ends too early.
                    (d as f32).next_up()
                }
                _ => f32::MAX,
            }
        });
        found
    }
}

/// Distance along a ray to a triangle (Möller and Trumbore 1997); behind the origin none.
fn intersect([a, b, c]: &[DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (e1, e2) = (*b - *a, *c - *a);
    let p = direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - *a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e1);
    let v = direction.dot(q) / determinant;
    let distance = e2.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_nearest_of_many_is_found_far_from_the_origin_too() {
        let mut random = Random(5);
        for shift in [DVec3::ZERO, DVec3::new(450_000.0, 5_300_000.0, 300.0)] {
            let mut point = |size: f64| DVec3::new(random.next(), random.next(), random.next()) * size;
            let triangles: Vec<[DVec3; 3]> = (0..300)
                .map(|_| {
                    let p = shift + point(10.0);
                    [p, p + point(2.0), p + point(2.0)]
                })
                .collect();
            let caster = Caster::new(triangles.clone()).unwrap();
            let mut hits = 0;
            for _ in 0..500 {
                let (origin, direction) = (shift + point(10.0), (point(2.0) - DVec3::ONE).normalize());
                let plain = |least: f64| {
                    let distances = triangles.iter().enumerate().filter_map(|(i, t)| Some((intersect(t, origin, direction)?, i)));
                    distances.filter(|(d, _)| *d > least).min_by(|a, b| a.0.total_cmp(&b.0))
                };
                let found = caster.nearest(origin, direction, 0.0);
                assert_eq!(found, plain(0.0));
                if let Some((d, _)) = found {
                    assert_eq!(caster.nearest(origin, direction, d), plain(d));
                    hits += 1;
                }
            }
            assert!(hits > 100);
        }
        assert!(Caster::new(Vec::new()).is_none());
    }

    #[test]
    fn rays_along_axes_meet_surfaces_square_to_them() {
        for axis in 0..3 {
            let at = |u: f64, v: f64| {
                let mut p = [0.0; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
                DVec3::from(p)
            };
            let square = vec![[at(0., 0.), at(4., 0.), at(4., 6.)], [at(0., 0.), at(4., 6.), at(0., 6.)]];
            let caster = Caster::new(square).unwrap();
            for side in [1.0, -1.0] {
                let mut away = [0.0; 3];
                away[axis] = side;
                let (away, point) = (DVec3::from(away), at(2.001, 3.0));
                assert_eq!(caster.nearest(point + 0.75 * away, -away, 0.0).map(|(d, _)| d), Some(0.75), "axis {axis}");
                assert_eq!(caster.nearest(point + 0.75 * away, away, 0.0), None);
            }
        }
    }
}

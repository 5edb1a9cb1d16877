//! Planes in which smooth surfaces lie: a plane mirror shows images that rays can be aimed at.

use super::normalization::Normalization;
use super::records::{Material, material_record};
use crate::scene::{MaterialKind, Scene, Window};
use glam::{DVec2, DVec3};

/// Planes that are looked at, at most: those of the largest triangles.
pub(crate) const MOST_PLANES: usize = 64;
/// Corners this far from a plane lie in it, as a part of the windows' size.
const BESIDE: f64 = 1e-4;
/// Cosine from which normals are parallel (a thousandth of a radian).
const PARALLEL: f64 = 1.0 - 5e-7;

/// A plane with smooth surfaces in it. Its number is its place in the list + 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SmoothPlane {
    /// A point of it, in the user's coordinates.
    pub point: DVec3,
    /// Unit length.
    pub normal: DVec3,
    /// Two directions in it, perpendicular to each other, unit length.
    pub axes: [DVec3; 2],
    /// Limits of its surfaces along the axes, from `point`.
    pub low: DVec2,
    /// See `low`.
    pub high: DVec2,
    /// Material of its largest triangle.
    pub material: u32,
}

impl SmoothPlane {
    fn of([a, b, c]: [DVec3; 3], material: u32) -> Option<Self> {
        let normal = (b - a).cross(c - a).try_normalize()?;
        let x = normal.any_orthonormal_vector();
        Some(Self { point: a, normal, axes: [x, normal.cross(x)], low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, material })
    }

    fn holds(&self, triangle: &[DVec3; 3], beside: f64) -> bool {
        let [a, b, c] = *triangle;
        let parallel = (b - a).cross(c - a).try_normalize().is_some_and(|n| n.dot(self.normal).abs() > PARALLEL);
        parallel && triangle.iter().all(|p| (*p - self.point).dot(self.normal).abs() <= beside)
    }

    /// A point of the plane by its axes.
    pub fn flat(&self, p: DVec3) -> DVec2 {
        let from = p - self.point;
        DVec2::new(from.dot(self.axes[0]), from.dot(self.axes[1]))
    }

    /// Signed distance from the plane.
    pub fn height(&self, p: DVec3) -> f64 {
        (p - self.point).dot(self.normal)
    }
}

/// Whether a surface of this material reflects as a mirror does, on one side at least.
pub(super) fn reflects(material: &Material) -> bool {
    match material.kind {
        super::MATERIAL_GLASS => true,
        super::MATERIAL_MIRROR => material.specular != [0.0; 3],
        super::MATERIAL_SURFACE => material.is_smooth() && material.specular != [0.0; 3],
        _ => false,
    }
}

/// The planes of these triangles of smooth surfaces with their materials, and for each the number of its plane;
/// 0 for those beyond the limit. `size` is that of the windows.
pub(super) fn find(triangles: &[([DVec3; 3], u32)], size: f64) -> (Vec<SmoothPlane>, Vec<u32>) {
    let mut planes: Vec<SmoothPlane> = Vec::new();
    let mut numbers = vec![0; triangles.len()];
    let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length();
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&a, &b| area(&triangles[b].0).total_cmp(&area(&triangles[a].0)).then(a.cmp(&b)));
    for i in order {
        let (triangle, material) = triangles[i];
        let mut number = planes.iter().position(|p| p.holds(&triangle, BESIDE * size));
        if number.is_none() && planes.len() < MOST_PLANES {
            planes.extend(SmoothPlane::of(triangle, material));
            number = Some(planes.len() - 1);
        }
        let Some(plane) = number.and_then(|n| planes.get_mut(n)) else { continue };
        for p in triangle {
            let flat = plane.flat(p);
            (plane.low, plane.high) = (plane.low.min(flat), plane.high.max(flat));
        }
        numbers[i] = number.map_or(0, |n| n as u32 + 1);
    }
    (planes, numbers)
}

/// Triangles of a scene's smooth surfaces that lie in none of the planes: images in them are left to chance.
pub(crate) fn left_out(scene: &Scene, windows: &[Window]) -> Vec<usize> {
    let kind = |i: usize| scene.materials[scene.triangles[i].material.0 as usize].kind;
    let has_area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() > 0.0;
    let counts =
        |i: &usize| kind(*i) != MaterialKind::Void && reflects(&material_record(&kind(*i))) && has_area(scene.triangles[*i].vertices);
    let smooth: Vec<usize> = (0..scene.triangles.len()).filter(counts).collect();
    let triangles: Vec<_> = smooth.iter().map(|i| (scene.triangles[*i].vertices, scene.triangles[*i].material.0)).collect();
    let (_, numbers) = find(&triangles, 1.0 / Normalization::of(windows).scale);
    smooth.into_iter().zip(numbers).filter(|(_, number)| *number == 0).map(|(i, _)| i).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(x: f64, y: f64, z: f64, tilt: f64) -> [DVec3; 3] {
        [DVec3::new(x, y, z), DVec3::new(x + 1.0, y, z), DVec3::new(x, y + 1.0, z + tilt)]
    }

    #[test]
    fn coplanar_triangles_share_a_plane_whatever_their_order_and_orientation() {
        let mut turned = tile(7.0, 3.0, 2.0, 0.0);
        turned.swap(1, 2);
        // The same plane twice, one 1 mm above it, one tilted, in survey coordinates too.
        for far in [DVec3::ZERO, DVec3::new(4.5e5, 5.4e6, 30.0)] {
            let all: Vec<_> = [tile(0.0, 0.0, 2.0, 0.0), turned, tile(0.0, 0.0, 2.001, 0.0), tile(0.0, 0.0, 2.0, 0.1)]
                .into_iter()
                .map(|t| (t.map(|p| p + far), 0))
                .collect();
            let (planes, numbers) = find(&all, 1.0);
            assert_eq!(planes.len(), 3);
            assert_eq!(numbers[0], numbers[1]);
            assert!(numbers[2] != numbers[0] && numbers[3] != numbers[0] && numbers[2] != numbers[3] && numbers[3] > 0);
            let floor = &planes[numbers[0] as usize - 1];
            assert!((floor.high - floor.low).min_element() > 3.9, "{floor:?}");
        }
    }

    #[test]
    fn of_a_curved_surface_the_largest_facets_count() {
        let facets: Vec<_> = (0..200).map(|i| (tile(0.0, 0.0, 0.0, 0.02 * f64::from(i)), 0)).collect();
        let (planes, numbers) = find(&facets, 1.0);
        assert_eq!((planes.len(), numbers.iter().filter(|n| **n > 0).count()), (MOST_PLANES, MOST_PLANES));
        assert!(numbers[199] > 0 && numbers[0] == 0);
    }
}

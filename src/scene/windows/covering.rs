//! What of a triangle lies before or behind another one, by cutting it along the other's edges.

use glam::{DVec2, DVec3};

/// Corners nearer to an edge than this, relative to the triangle's size, are on it: f64 keeps so many
/// digits of windows in survey coordinates.
const ON_EDGE: f64 = 1e-8;
/// Overlaps smaller than this share of either triangle are rounding.
const LEAST_SHARE: f64 = 1e-7;

/// A triangle seen from its front, along its normal.
pub(super) struct Base {
    origin: DVec3,
    axes: [DVec3; 3],
    corners: [DVec2; 3],
    low: DVec2,
    high: DVec2,
    area: f64,
}

/// The overlap of a triangle with a [`Base`].
pub(super) struct Overlap {
    /// As seen along the base's normal.
    pub area: f64,
    /// How far before the base it begins and ends; negative behind it.
    pub depth: [f64; 2],
    /// Cosine between the two normals.
    pub cosine: f64,
    /// The triangle without it.
    pub rest: Vec<[DVec3; 3]>,
}

/// A corner as the base sees it (z along its normal), and in the scene.
#[derive(Clone, Copy)]
struct Corner {
    local: DVec3,
    place: DVec3,
}

impl Base {
    /// Nothing if the triangle has no area.
    pub(super) fn new(triangle: &[DVec3; 3]) -> Option<Self> {
        let [a, b, c] = *triangle;
        let across = (b - a).cross(c - a);
        let z = across.try_normalize()?;
        let x = (b - a).try_normalize()?;
        let axes = [x, z.cross(x), z];
        let corners = [a, b, c].map(|p| DVec2::new((p - a).dot(axes[0]), (p - a).dot(axes[1])));
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        Some(Self { origin: a, axes, corners, low, high, area: across.length() / 2.0 })
    }

    fn local(&self, p: DVec3) -> DVec3 {
        let from = p - self.origin;
        DVec3::from_array(self.axes.map(|axis| from.dot(axis)))
    }

    /// The part of a triangle that lies before or behind the base by no more than `reach`, if there is one
    /// and none of it lies farther.
    pub(super) fn overlap(&self, triangle: &[DVec3; 3], reach: f64) -> Option<Overlap> {
        let corners = triangle.map(|place| Corner { local: self.local(place), place });
        let [a, b, c] = corners.map(|c| c.local);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let apart = low.truncate().cmpgt(self.high) | high.truncate().cmplt(self.low);
        if apart.any() || low.z > reach || high.z < -reach {
            return None;
        }
        let seen = seen_area(&corners).abs();
        let least = LEAST_SHARE * seen.min(self.area);
        // Across the base, or nearly.
        if seen <= LEAST_SHARE * self.area.min(longest_edge2(triangle)) {
            return None;
        }
        let mut inside = corners.to_vec();
        let eps = ON_EDGE * (self.high - self.low).length();
        let mut rest = Vec::new();
        for (i, &from) in self.corners.iter().enumerate() {
            let along = (self.corners[(i + 1) % 3] - from).normalize();
            let side = |c: &Corner| {
                let distance = along.perp_dot(c.local.truncate() - from);
                if distance.abs() <= eps { 0.0 } else { distance }
            };
            let (kept, cut) = split(&inside, side);
            if seen_area(&kept).abs() <= least {
                return None;
            }
            if seen_area(&cut).abs() > 0.0 {
                rest.push(cut);
            }
            inside = kept;
        }
        let depth = inside.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], c| [l.min(c.local.z), h.max(c.local.z)]);
        if depth[0] < -reach || depth[1] > reach {
            return None;
        }
        let [a, b, c] = *triangle;
        Some(Overlap {
            area: seen_area(&inside).abs(),
            depth,
            cosine: (b - a).cross(c - a).normalize_or_zero().dot(self.axes[2]),
            rest: rest.iter().flat_map(|part| fan(part)).collect(),
        })
    }
}

/// The parts of a convex polygon where `side` is not negative, and not positive.
fn split(part: &[Corner], side: impl Fn(&Corner) -> f64) -> (Vec<Corner>, Vec<Corner>) {
    let (mut left, mut right) = (Vec::new(), Vec::new());
    for (i, a) in part.iter().enumerate() {
        let b = &part[(i + 1) % part.len()];
        let (at_a, at_b) = (side(a), side(b));
        if at_a >= 0.0 {
            left.push(*a);
        }
        if at_a <= 0.0 {
            right.push(*a);
        }
        if at_a * at_b < 0.0 {
            let t = at_a / (at_a - at_b);
            let between = Corner { local: a.local.lerp(b.local, t), place: a.place.lerp(b.place, t) };
            left.push(between);
            right.push(between);
        }
    }
    (left, right)
}

/// Area as the base sees it, negative from behind.
fn seen_area(part: &[Corner]) -> f64 {
    let Some(first) = part.first() else { return 0.0 };
    let from = |c: &Corner| c.local.truncate() - first.local.truncate();
    part.windows(2).map(|w| from(&w[0]).perp_dot(from(&w[1]))).sum::<f64>() / 2.0
}

fn longest_edge2([a, b, c]: &[DVec3; 3]) -> f64 {
    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared())
}

/// Triangles of a convex polygon.
fn fan(part: &[Corner]) -> impl Iterator<Item = [DVec3; 3]> {
    (1..part.len().max(2) - 1)
        .map(|i| [part[0].place, part[i].place, part[i + 1].place])
        .filter(|[a, b, c]| (*b - *a).cross(*c - *a) != DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::trace::reference::Random;

    fn area(t: &[DVec3; 3]) -> f64 {
        (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0
    }

    fn contains(t: &[DVec3; 3], p: DVec3) -> bool {
        let n = (t[1] - t[0]).cross(t[2] - t[0]);
        (0..3).all(|i| (t[(i + 1) % 3] - t[i]).cross(p - t[i]).dot(n) >= 0.0)
    }

    #[test]
    fn overlap_and_rest_are_the_triangle_and_keep_its_front() {
        let mut random = Random(7);
        let origin = DVec3::new(583_960.4, 4_507_523.7, 31.6);
        let mut overlaps = 0;
        for _ in 0..500 {
            // Both in one tilted plane, the second from either side, and a little before it.
            let (x, y) = (DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.48, 0.36, 0.8));
            let mut point = |z: f64| origin + x * (2.0 * random.next()) + y * (2.0 * random.next()) + x.cross(y) * z;
            let base = [point(0.0), point(0.0), point(0.0)];
            let triangle = [point(1e-3), point(1e-3), point(1e-3)];
            let Some(found) = Base::new(&base).unwrap().overlap(&triangle, 0.1) else { continue };
            overlaps += 1;
            let rest: f64 = found.rest.iter().map(area).sum();
            assert!((found.area + rest - area(&triangle)).abs() < 1e-7, "{} and {rest} of {}", found.area, area(&triangle));
            let front = (base[1] - base[0]).cross(base[2] - base[0]).dot(x.cross(y)).signum();
            assert!(found.depth.iter().all(|d| (d * front - 1e-3).abs() < 1e-8), "{:?}", found.depth);
            assert!((found.cosine.abs() - 1.0).abs() < 1e-9);
            let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
            assert!(found.rest.iter().all(|[a, b, c]| (*b - *a).cross(*c - *a).dot(normal) > 0.0));
            for _ in 0..20 {
                let (u, v) = (random.next().sqrt(), random.next());
                let p = triangle[0] * (1.0 - u) + triangle[1] * (u * (1.0 - v)) + triangle[2] * (u * v);
                let near_edge = |t: &[DVec3; 3]| (0..3).any(|i| (p - t[i]).cross((t[(i + 1) % 3] - t[i]).normalize()).length() < 2e-3);
                if !near_edge(&base) && !found.rest.iter().any(near_edge) {
                    assert_eq!(found.rest.iter().filter(|t| contains(t, p)).count(), usize::from(!contains(&base, p)));
                }
            }
        }
        assert!(overlaps > 200, "{overlaps}");
    }

    #[test]
    fn what_only_touches_or_stands_across_overlaps_nothing() {
        let base = Base::new(&[DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap();
        let overlap = |t: [[f64; 3]; 3]| base.overlap(&t.map(DVec3::from_array), 0.1);
        assert!(overlap([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]).is_none(), "the other half of the square");
        assert!(overlap([[0.0, 0.3, -1.0], [1.0, 0.3, -1.0], [0.5, 0.3, 1.0]]).is_none(), "perpendicular");
        assert!(overlap([[0.0, 0.0, 0.2], [1.0, 0.0, 0.2], [0.0, 1.0, 0.2]]).is_none(), "too far");
        assert!(overlap([[0.0, 0.0, 0.05], [1.0, 0.0, 0.5], [0.0, 1.0, 0.05]]).is_none(), "partly too far");
        let whole = overlap([[-9.0, -9.0, 0.05], [9.0, -9.0, 0.05], [0.0, 9.0, 0.05]]).unwrap();
        assert!((whole.area - 0.5).abs() < 1e-12 && (whole.cosine - 1.0).abs() < 1e-12);
    }
}

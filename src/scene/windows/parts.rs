//! Windows cut into parts: V and D are averages over a window, or over each of its parts.

use crate::scene::Window;
use glam::{DVec2, DVec3};

/// A part smaller than this share of its window is rounding.
const LEAST_SHARE: f64 = 1e-9;

impl Window {
    /// Lower and upper corner of the rectangle in the window's frame (x to the right of somebody inside who looks
    /// out, y up) that holds it.
    pub(crate) fn extent(&self) -> [DVec2; 2] {
        let flat = |p: &DVec3| DVec2::new(p.dot(self.frame.x), p.dot(self.frame.y));
        let corners = || self.triangles.iter().flatten().map(flat);
        [corners().fold(DVec2::INFINITY, DVec2::min), corners().fold(DVec2::NEG_INFINITY, DVec2::max)]
    }

    /// Whether another one is cut out of it.
    pub(crate) fn has_as_part(&self, other: &Window) -> bool {
        self.origin == other.origin && other.triangles.iter().all(|[a, b, c]| self.holds((a + b + c) / 3.0))
    }

    /// Whether a point lies on the window.
    fn holds(&self, point: DVec3) -> bool {
        self.triangles.iter().any(|&[a, b, c]| {
            let normal = (b - a).cross(c - a);
            let area2 = normal.length_squared();
            let inside = |p: DVec3, q: DVec3| (q - p).cross(point - p).dot(normal) >= -1e-9 * area2;
            let off_plane = (point - a).dot(normal).powi(2);
            inside(a, b) && inside(b, c) && inside(c, a) && off_plane <= 1e-12 * area2 * area2.sqrt()
        })
    }

    /// The window cut along the lines of a grid over its [`extent`](Self::extent): the parts in their order from
    /// the left, row by row from below. Fields of the grid in which nothing of the window lies make no part. Frame,
    /// basis and name are the window's. Of one field it is the window itself.
    pub(crate) fn in_parts(&self, [columns, rows]: [usize; 2]) -> Vec<Window> {
        if columns * rows == 1 {
            return vec![self.clone()];
        }
        let [low, high] = self.extent();
        let size = self.area();
        let strips = |window: Vec<Vec<DVec3>>, axis: DVec3, (from, to): (f64, f64), count: usize| -> Vec<Vec<Vec<DVec3>>> {
            let mut rest = window;
            let mut strips = Vec::with_capacity(count);
            for i in 1..count {
                let line = from + (to - from) * i as f64 / count as f64;
                let (below, above) = rest.iter().map(|polygon| cut(polygon, |p| p.dot(axis) - line)).unzip();
                strips.push(below);
                rest = above;
            }
            strips.push(rest);
            strips
        };
        let whole = self.triangles.iter().map(|t| t.to_vec()).collect();
        let of_row = |row| strips(row, self.frame.x, (low.x, high.x), columns);
        let fields = strips(whole, self.frame.y, (low.y, high.y), rows).into_iter().flat_map(of_row);
        let part = |polygons: Vec<Vec<DVec3>>| Window { triangles: polygons.iter().flat_map(|p| fan(p)).collect(), ..self.clone() };
        fields.map(part).filter(|part| part.area() > LEAST_SHARE * size).collect()
    }
}

/// The parts of a convex polygon where `side` is not positive, and not negative.
fn cut(polygon: &[DVec3], side: impl Fn(DVec3) -> f64) -> (Vec<DVec3>, Vec<DVec3>) {
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (at_a, at_b) = (side(a), side(b));
        if at_a <= 0.0 {
            below.push(a);
        }
        if at_a >= 0.0 {
            above.push(a);
        }
        if at_a * at_b < 0.0 {
            let between = a.lerp(b, at_a / (at_a - at_b));
            below.push(between);
            above.push(between);
        }
    }
    (below, above)
}

/// Triangles of a convex polygon that have an area.
fn fan(polygon: &[DVec3]) -> impl Iterator<Item = [DVec3; 3]> {
    (1..polygon.len().max(2) - 1)
        .map(|i| [polygon[0], polygon[i], polygon[i + 1]])
        .filter(|[a, b, c]| (*b - *a).cross(*c - *a).length_squared() > 0.0)
}

/// Columns and rows of so many fields, as square as they can be over a window of this extent.
pub(crate) fn grid_of(count: usize, [low, high]: [DVec2; 2]) -> [usize; 2] {
    let size = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
    let lengthened = |columns: &usize| (size.x / size.y * (count / columns) as f64 / *columns as f64).ln().abs();
    let columns = (1..=count).filter(|c| count.is_multiple_of(*c)).min_by(|a, b| lengthened(a).total_cmp(&lengthened(b))).unwrap_or(1);
    [columns, count / columns]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;
    use crate::kernels::trace::rooms::window;
    use crate::scene::polygon::triangulate;

    fn corners(points: &[[f64; 2]]) -> Vec<DVec3> {
        points.iter().map(|p| DVec3::new(p[0], 0.0, p[1])).collect()
    }

    /// An L with a hole, and a pane of its own beside it.
    fn crooked() -> Window {
        let mut w = window([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [4.0, 0.0, 2.0], [4.0, 0.0, 0.0]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
        let outline = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
            [0.0, 0.0],
            [0.2, 0.2],
            [0.2, 0.8],
            [0.8, 0.8],
            [0.8, 0.2],
            [0.2, 0.2],
        ];
        w.triangles = triangulate(&corners(&outline)).triangles;
        w.triangles.extend(triangulate(&corners(&[[6.0, 0.5], [7.0, 0.5], [7.0, 1.5], [6.0, 1.5]])).triangles);
        w
    }

    #[test]
    fn parts_are_the_window_whatever_its_outline() {
        let whole = crooked();
        assert!((whole.area() - (5.0 - 0.36 + 1.0)).abs() < 1e-12);
        for grid in [[1, 1], [1, 2], [7, 1], [3, 5], [16, 16]] {
            let parts = whole.in_parts(grid);
            let areas: f64 = parts.iter().map(Window::area).sum();
            assert!((areas - whole.area()).abs() < 1e-12, "{grid:?}: {areas}");
            assert!(parts.len() <= grid[0] * grid[1]);
            let size = (whole.extent()[1] - whole.extent()[0]) / DVec2::new(grid[0] as f64, grid[1] as f64);
            for part in &parts {
                let [low, high] = part.extent();
                assert!((high - low).cmple(size + 1e-12).all(), "{grid:?}: {low} {high}");
                let normal = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).y;
                assert!(part.triangles.iter().all(|t| normal(t) * normal(&whole.triangles[0]) > 0.0), "all face the same way");
            }
        }
        assert_eq!(whole.in_parts([1, 1])[0], whole);
        for part in whole.in_parts([3, 2]) {
            assert!(whole.is_in_place_of(&part) && part.is_in_place_of(&part) && !part.is_in_place_of(&whole));
            let mut elsewhere = part.clone();
            elsewhere.triangles.iter_mut().flatten().for_each(|p| p.y += 0.01);
            assert!(!whole.is_in_place_of(&elsewhere), "1 cm before it");
        }
        // 7 m by 2 m in fields of a metre: 5 of the L (its hole fills none), 2 that the pane crosses.
        assert_eq!(whole.in_parts([7, 2]).len(), 7);
    }

    #[test]
    fn parts_are_ordered_from_the_left_of_somebody_inside_and_from_below() {
        let w = window([[0.0, 0.0, 1.0], [0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [4.0, 0.0, 1.0]], DVec3::Y, DVec3::Z, KlemsBasis::Quarter);
        let middles: Vec<DVec3> =
            w.in_parts([2, 2]).iter().map(|p| p.triangles.iter().flatten().copied().fold(DVec3::INFINITY, DVec3::min)).collect();
        // The room is north of it: whoever looks out south has the east on the left.
        assert_eq!(middles, [[2.0, 0.0, 1.0], [0.0, 0.0, 1.0], [2.0, 0.0, 2.0], [0.0, 0.0, 2.0]].map(DVec3::from_array));
    }

    #[test]
    fn fields_are_as_square_as_their_number_allows() {
        let extent = |x: f64, y: f64| [DVec2::ZERO, DVec2::new(x, y)];
        assert_eq!(grid_of(16, extent(2.0, 2.0)), [4, 4]);
        assert_eq!(grid_of(16, extent(4.0, 1.0)), [8, 2]);
        assert_eq!((grid_of(7, extent(4.0, 1.0)), grid_of(7, extent(1.0, 4.0))), ([7, 1], [1, 7]));
        assert_eq!((grid_of(1, extent(4.0, 1.0)), grid_of(4, extent(3.0, 0.0))), ([1, 1], [4, 1]));
    }
}

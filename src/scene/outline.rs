//! Plans and sections: sensors as cells, contours between them, where a plane cuts the scene, its edges.

use super::Scene;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Sensors as cells of a plan, each as wide as the distance to its neighbours.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// Middle of each, m.
    pub middles: Vec<DVec2>,
    /// Side lengths, m; the smallest where they differ.
    pub size: DVec2,
    /// Corners of the box around each: towards other sensors it reaches as far as gaps are wide.
    boxes: Vec<[DVec2; 2]>,
}

/// Box of a sensor's cell: half a cell to each side, towards other sensors up to one and a half.
fn reach(middle: DVec2, all: &[DVec2], size: DVec2) -> [DVec2; 2] {
    let half = size * 0.5;
    let has = |towards: &dyn Fn(DVec2) -> bool| all.iter().any(|o| towards(*o - middle));
    let length = |near: f64, neighbour: bool| if neighbour { 3.0 * near } else { near };
    let beside = |d: DVec2| d.y.abs() < half.y;
    let below = |d: DVec2| d.x.abs() < half.x;
    let (x, y) = (size.x * 0.25, size.y * 0.25);
    let left = length(half.x, has(&|d| d.x < -x && beside(d)));
    let right = length(half.x, has(&|d| d.x > x && beside(d)));
    let down = length(half.y, has(&|d| d.y < -y && below(d)));
    let up = length(half.y, has(&|d| d.y > y && below(d)));
    [middle - DVec2::new(left, down), middle + DVec2::new(right, up)]
}

impl Cells {
    /// Cells around positions: the smallest distances between different x and y.
    pub fn around(positions: &[DVec3]) -> Self {
        let step = |values: Vec<f64>| {
            let mut sorted = values;
            sorted.sort_by(f64::total_cmp);
            let gaps = sorted.windows(2).map(|w| w[1] - w[0]).filter(|g| *g > 1e-3);
            gaps.fold(f64::MAX, f64::min)
        };
        let x = step(positions.iter().map(|p| p.x).collect());
        let y = step(positions.iter().map(|p| p.y).collect());
        let known = |a: f64, b: f64| {
            if a < f64::MAX {
                a
            } else if b < f64::MAX {
                b
            } else {
                0.5
            }
        };
        let size = DVec2::new(known(x, y), known(y, x));
        // Scattered sensors would get slivers.
        let size = size.max(DVec2::splat(size.max_element() * 0.35)).min(DVec2::splat(2.0));
        let middles: Vec<DVec2> = positions.iter().map(|p| p.truncate()).collect();
        let boxes = middles.iter().map(|m| reach(*m, &middles, size)).collect();
        Self { middles, size, boxes }
    }

    /// Corners of the box around all cells, without what reaches into gaps.
    pub fn range(&self) -> [DVec2; 2] {
        let half = self.size * 0.5;
        self.middles.iter().fold([DVec2::MAX, DVec2::MIN], |[low, high], m| [low.min(*m - half), high.max(*m + half)])
    }

    /// Corners of a cell: the part of its box that is nearer to it than to any other.
    pub fn outline(&self, index: usize) -> Vec<DVec2> {
        let (m, [low, high]) = (self.middles[index], self.boxes[index]);
        let mut outline = vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        for other in self.middles.iter().filter(|o| **o != m) {
            // Positive on the other's side of the line in the middle.
            let across = |p: DVec2| (p - (m + *other) * 0.5).dot(*other - m);
            let sides: Vec<(DVec2, f64)> = outline.iter().map(|p| (*p, across(*p))).collect();
            if sides.iter().all(|s| s.1 <= 1e-9) {
                continue;
            }
            outline.clear();
            for (i, (p, a)) in sides.iter().enumerate() {
                let (q, b) = sides[(i + 1) % sides.len()];
                if *a <= 0.0 {
                    outline.push(*p);
                }
                if (*a < 0.0 && b > 0.0) || (*a > 0.0 && b < 0.0) {
                    outline.push(*p + (q - *p) * (*a / (*a - b)));
                }
            }
        }
        outline
    }

    /// The cell at a place.
    pub fn at(&self, place: DVec2) -> Option<usize> {
        let inside = |i: usize| place.cmpge(self.boxes[i][0]).all() && place.cmple(self.boxes[i][1]).all();
        let near = self.middles.iter().enumerate().filter(|(i, _)| inside(*i));
        near.min_by(|a, b| a.1.distance(place).total_cmp(&b.1.distance(place))).map(|(i, _)| i)
    }

    /// Lines of equal value between the middles of neighbouring cells (marching squares); none where the
    /// sensors stand unevenly.
    pub fn contour(&self, values: &[f64], level: f64) -> Vec<[DVec2; 2]> {
        let index = |m: DVec2| {
            let g = (m / self.size).round();
            (g.x as i64, g.y as i64)
        };
        let origin = self.middles.first().copied().unwrap_or(DVec2::ZERO);
        // Between uneven rows neighbours are missed, and lines would break off.
        let place = |m: &DVec2| (*m - origin) / self.size;
        if self.middles.iter().any(|m| (place(m) - place(m).round()).abs().max_element() > 0.2) {
            return Vec::new();
        }
        let table: HashMap<(i64, i64), usize> = self.middles.iter().enumerate().map(|(i, m)| (index(*m - origin), i)).collect();
        let mut lines = Vec::new();
        for (&(x, y), &a) in &table {
            let corner = |dx: i64, dy: i64| table.get(&(x + dx, y + dy)).copied();
            let (Some(b), Some(c), Some(d)) = (corner(1, 0), corner(1, 1), corner(0, 1)) else { continue };
            let ring = [a, b, c, d];
            let cut: Vec<DVec2> = (0..4)
                .filter_map(|k| {
                    let (i, j) = (ring[k], ring[(k + 1) % 4]);
                    let (p, q) = (values[i], values[j]);
                    ((p < level) != (q < level)).then(|| self.middles[i].lerp(self.middles[j], (level - p) / (q - p)))
                })
                .collect();
            for pair in cut.chunks_exact(2) {
                lines.push([pair[0], pair[1]]);
            }
        }
        lines
    }
}

/// A plane that cuts the scene, with the axes of its drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// A point of the plane, m: 0, 0 of the drawing.
    pub origin: DVec3,
    /// To the right, of unit length.
    pub right: DVec3,
    /// Upwards, of unit length and square to `right`.
    pub up: DVec3,
}

impl Cut {
    /// A plan: the horizontal plane at a height, x to the right and y upwards.
    pub fn plan(height: f64) -> Self {
        Self { origin: DVec3::Z * height, right: DVec3::X, up: DVec3::Y }
    }

    /// Place of a point in the drawing, seen square to the plane.
    pub fn place(&self, point: DVec3) -> DVec2 {
        let d = point - self.origin;
        DVec2::new(d.dot(self.right), d.dot(self.up))
    }

    /// Lines where the plane cuts triangles: walls and furniture.
    pub fn lines<'a>(&self, triangles: impl IntoIterator<Item = &'a [DVec3; 3]>) -> Vec<[DVec2; 2]> {
        let normal = self.right.cross(self.up);
        let mut lines = Vec::new();
        for v in triangles {
            let above = v.map(|p| (p - self.origin).dot(normal));
            let cut: Vec<DVec2> = (0..3)
                .filter_map(|k| {
                    let (i, j) = (k, (k + 1) % 3);
                    ((above[i] < 0.0) != (above[j] < 0.0)).then(|| self.place(v[i].lerp(v[j], above[i] / (above[i] - above[j]))))
                })
                .collect();
            if let [a, b] = cut[..] {
                lines.push([a, b]);
            }
        }
        lines
    }

    /// Lines where the plane cuts a scene.
    pub fn section(&self, scene: &Scene) -> Vec<[DVec2; 2]> {
        self.lines(scene.triangles.iter().map(|t| &t.vertices))
    }
}

/// Range of a drawing, lower left and upper right corner: around a box (sensors), with the lines near it and a margin.
/// Walls that reach far beyond the box are those of the house, not of the room.
pub fn extent([low, high]: [DVec2; 2], lines: &[[DVec2; 2]]) -> [DVec2; 2] {
    let near = (high - low).max_element().max(2.0) * 0.35;
    let (l, h) = (low - near, high + near);
    let (mut low, mut high) = (low, high);
    for p in lines.iter().filter(|line| line.iter().all(|p| p.cmpge(l).all() && p.cmple(h).all())).flatten() {
        low = low.min(*p);
        high = high.max(*p);
    }
    let margin = (high - low).max_element() * 0.04;
    [low - margin, high + margin]
}

/// Edges of the scene's surfaces: those of one triangle only, or between different planes.
pub fn edges(scene: &Scene) -> Vec<[DVec3; 2]> {
    let key = |p: DVec3| (p * 1e4).round().as_i64vec3();
    let mut seen: HashMap<_, (usize, DVec3, [DVec3; 2], bool)> = HashMap::new();
    for t in &scene.triangles {
        let normal = t.normal();
        for k in 0..3 {
            let (a, b) = (t.vertices[k], t.vertices[(k + 1) % 3]);
            let (p, q) = (key(a), key(b));
            let name = if p.to_array() < q.to_array() { (p, q) } else { (q, p) };
            let entry = seen.entry(name).or_insert((0, normal, [a, b], false));
            entry.0 += 1;
            entry.3 |= entry.1.dot(normal).abs() < 0.999;
        }
    }
    let mut edges: Vec<[DVec3; 2]> = seen.into_values().filter(|(count, _, _, bent)| *count == 1 || *bent).map(|e| e.2).collect();
    edges.sort_by(|a, b| a[0].to_array().partial_cmp(&b[0].to_array()).unwrap_or(std::cmp::Ordering::Equal));
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_fill_a_grid_and_find_the_pointer() {
        let positions: Vec<DVec3> = (0..12).map(|i| DVec3::new(f64::from(i % 4) * 0.6, f64::from(i / 4) * 0.5, 0.8)).collect();
        let cells = Cells::around(&positions);
        assert!((cells.size - DVec2::new(0.6, 0.5)).length() < 1e-9);
        assert_eq!(cells.at(DVec2::new(0.61, 0.52)), Some(5));
        assert_eq!(cells.at(DVec2::new(-0.4, 0.0)), None);
        let one = Cells::around(&positions[..1]);
        assert_eq!(one.size, DVec2::splat(0.5));
    }

    #[test]
    fn cells_of_uneven_rows_touch_and_do_not_overlap() {
        // Rows at different distances, and one sensor between two of them.
        let mut positions: Vec<DVec3> =
            [0.0, 0.5, 1.1, 1.9].iter().flat_map(|&y| (0..3).map(move |x| DVec3::new(f64::from(x), y, 0.8))).collect();
        positions.push(DVec3::new(1.0, 1.7, 1.2));
        let cells = Cells::around(&positions);
        let area = |corners: &[DVec2]| -> f64 {
            (0..corners.len()).map(|i| corners[i].perp_dot(corners[(i + 1) % corners.len()])).sum::<f64>() * 0.5
        };
        let sum: f64 = (0..positions.len()).map(|i| area(&cells.outline(i))).sum();
        let half = cells.size * 0.5;
        let whole = (2.0 + 2.0 * half.x) * (1.9 + 2.0 * half.y);
        // Beside the odd one some corners are nobody's.
        assert!(sum <= whole + 1e-9 && sum > 0.99 * whole, "{sum} of {whole}");
        // Between the first two rows, and on both sides of the line to the odd one.
        assert_eq!((cells.at(DVec2::new(0.0, 0.24)), cells.at(DVec2::new(0.0, 0.26))), (Some(0), Some(3)));
        assert_eq!((cells.at(DVec2::new(1.0, 1.79)), cells.at(DVec2::new(1.0, 1.81))), (Some(12), Some(10)));
        assert!(cells.contour(&vec![1.0; positions.len()], 0.5).is_empty());
        // Even ones have the boxes that they always had.
        let even = Cells::around(&positions[..6]);
        assert!((area(&even.outline(4)) - even.size.x * even.size.y).abs() < 1e-12);
    }

    #[test]
    fn a_plane_cuts_walls_where_they_stand() {
        // A wall at y = 2 from x = 0 to 4, 3 m high, of two triangles.
        let corner = |x: f64, z: f64| DVec3::new(x, 2.0, z);
        let wall = [[corner(0.0, 0.0), corner(4.0, 0.0), corner(4.0, 3.0)], [corner(0.0, 0.0), corner(4.0, 3.0), corner(0.0, 3.0)]];
        let plan = Cut::plan(1.0).lines(&wall);
        let length = |lines: &[[DVec2; 2]]| lines.iter().map(|[a, b]| a.distance(*b)).sum::<f64>();
        assert!((length(&plan) - 4.0).abs() < 1e-12 && plan.iter().flatten().all(|p| (p.y - 2.0).abs() < 1e-12), "{plan:?}");
        let across = Cut { origin: DVec3::new(1.0, 0.0, 0.0), right: DVec3::Y, up: DVec3::Z };
        let section = across.lines(&wall);
        assert!((length(&section) - 3.0).abs() < 1e-12 && section.iter().flatten().all(|p| (p.x - 2.0).abs() < 1e-12), "{section:?}");
        // What lies near a box belongs to its drawing, a wall that runs far beyond it does not.
        let [low, high] = extent([DVec2::new(1.0, 0.5), DVec2::new(3.0, 1.5)], &plan[..1]);
        assert!(low.x < 1.0 && high.y < 2.5, "{low} {high}");
        let far = extent([DVec2::ZERO, DVec2::ONE], &[[DVec2::new(-50.0, 0.5), DVec2::new(50.0, 0.5)]]);
        assert!((far[1] - DVec2::splat(1.04)).length() < 1e-12);
    }

    #[test]
    fn contours_cross_where_the_value_is() {
        let positions: Vec<DVec3> = (0..12).map(|i| DVec3::new(f64::from(i % 4), f64::from(i / 4), 0.0)).collect();
        let cells = Cells::around(&positions);
        let values: Vec<f64> = positions.iter().map(|p| p.x * 10.0).collect();
        let lines = cells.contour(&values, 12.5);
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().flatten().all(|p| (p.x - 1.25).abs() < 1e-12));
    }
}

//! Polygons, cut into triangles as Radiance understands them.
//!
//! Radiance tests hits in the polygon's mean plane by the even-odd rule. So holes by seams, holes
//! wound either way, overlaps and crossing edges all have one meaning: a point is inside if a ray
//! from it crosses the outline an odd number of times.

use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// A polygon whose corners leave its mean plane by more than this fraction of its size (the root of
/// its area) is flattened into that plane, as Radiance does. Below it, corners stay where they
/// are, so that neighbours keep sharing them.
pub(crate) const PLANARITY_TOLERANCE: f64 = 1e-3;

/// Area, as a fraction of the squared extent, below which a polygon has no area.
const DEGENERATE_AREA: f64 = 1e-12;

/// Triangles of a polygon.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Triangulation {
    /// Triangles, counter-clockwise seen from the front. Empty if the polygon has no area.
    pub triangles: Vec<[DVec3; 3]>,
    /// Largest distance of a corner from the mean plane.
    pub departure: f64,
    /// Whether the departure exceeded [`PLANARITY_TOLERANCE`] and the polygon was flattened.
    pub flattened: bool,
}

/// Cuts a polygon, given by its corners counter-clockwise seen from the front, into triangles.
pub(crate) fn triangulate(corners: &[DVec3]) -> Triangulation {
    let mut corners: Vec<DVec3> = corners.to_vec();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    let empty = Triangulation { triangles: Vec::new(), departure: 0.0, flattened: false };
    if corners.len() < 3 {
        return empty;
    }
    let origin = corners[0];
    let doubled: DVec3 = corners.windows(2).map(|w| (w[0] - origin).cross(w[1] - origin)).sum();
    let extent = corners.iter().map(|c| (c - origin).length()).fold(0.0, f64::max);
    let area = doubled.length() / 2.0;
    // Coordinates that overflow make an area that compares with nothing.
    if area.is_nan() || area <= DEGENERATE_AREA * extent * extent {
        return empty;
    }
    let normal = doubled / (2.0 * area);
    let offset = corners.iter().map(|c| (c - origin).dot(normal)).sum::<f64>() / corners.len() as f64;
    let departure = corners.iter().map(|c| ((c - origin).dot(normal) - offset).abs()).fold(0.0, f64::max);
    let flattened = departure > PLANARITY_TOLERANCE * area.sqrt();
    // Along the normal's main axis, so that the kept coordinates are the corners' own.
    let dropped = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(2);
    let (mut u, mut v) = ((dropped + 1) % 3, (dropped + 2) % 3);
    if normal[dropped] < 0.0 {
        std::mem::swap(&mut u, &mut v);
    }
    let flat = |p: DVec3| DVec2::new(p[u], p[v]);
    let lifted = |p: DVec2| {
        let mut q = DVec3::ZERO;
        q[u] = p.x;
        q[v] = p.y;
        q[dropped] = origin[dropped] + (offset - normal[u] * (p.x - origin[u]) - normal[v] * (p.y - origin[v])) / normal[dropped];
        q
    };
    let outline: Vec<DVec2> = corners.iter().map(|&c| flat(c)).collect();
    let solid: Vec<DVec3> = if flattened { outline.iter().map(|&p| lifted(p)).collect() } else { corners };
    let by_corners = |triangles: Vec<[usize; 3]>| triangles.into_iter().map(|t| t.map(|i| solid[i])).collect();
    let triangles = if let Some(fan) = convex_fan(&outline) {
        by_corners(fan)
    } else {
        let decomposition = Decomposition::of(&outline);
        match if decomposition.is_simple { clip_ears(&outline) } else { None } {
            Some(ears) => by_corners(ears),
            None => {
                let key = |p: DVec2| [p.x.to_bits(), p.y.to_bits()];
                let known: HashMap<[u64; 2], DVec3> = outline.iter().zip(&solid).map(|(&p, &s)| (key(p), s)).collect();
                let solid = |p: DVec2| known.get(&key(p)).copied().unwrap_or_else(|| lifted(p));
                decomposition.triangles().into_iter().map(|t| t.map(solid)).collect()
            }
        }
    };
    Triangulation { triangles, departure, flattened }
}

/// Twice the signed area of a triangle, positive counter-clockwise. Exactly antisymmetric in its
/// last two points.
fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (ab, ac) = (b - a, c - a);
    ab.x * ac.y - ab.y * ac.x
}

/// A fan, if the outline turns left at every corner and goes around once.
fn convex_fan(outline: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let n = outline.len();
    let at = |i: usize| outline[i % n];
    let turns_left = (0..n).all(|i| orientation(at(i), at(i + 1), at(i + 2)) > 0.0);
    // An outline that only turns left and goes around once changes its vertical sense twice.
    let rises = |i: usize| (at(i + 1).y, at(i + 1).x) > (at(i).y, at(i).x);
    let changes = (0..n).filter(|&i| rises(i) != rises((i + 1) % n)).count();
    (turns_left && changes == 2).then(|| (1..n - 1).map(|i| [0, i, i + 1]).collect())
}

/// Ear clipping of an outline whose winding number is 0 or 1 everywhere; edges may touch (seams).
///
/// The indicator functions of the clipped triangles always sum to the outline's winding number; so
/// if all triangles are counter-clockwise, they cover the inside exactly once, whatever the
/// order of clipping was. `None` if no such order was found.
fn clip_ears(outline: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let n = outline.len();
    let mut ring: Vec<usize> = (0..n).collect();
    let mut triangles = Vec::with_capacity(n - 2);
    let extent = outline.iter().map(|p| (p - outline[0]).length_squared()).fold(0.0, f64::max);
    let flat = 1e-14 * extent;
    let mut start = 0;
    while ring.len() > 2 {
        let m = ring.len();
        let triple = |i: usize| [ring[(i + m - 1) % m], ring[i % m], ring[(i + 1) % m]];
        let size = |i: usize| {
            let [a, b, c] = triple(i).map(|k| outline[k]);
            orientation(a, b, c)
        };
        // Corners that turn right or not at all are the only ones that can lie inside an ear.
        let blocking: Vec<usize> = (0..m).filter(|&i| size(i) <= flat).map(|i| ring[i]).collect();
        let is_ear = |i: usize| {
            let [a, b, c] = triple(i).map(|k| outline[k]);
            orientation(a, b, c) > flat
                && !blocking.iter().map(|&k| outline[k]).any(|p| {
                    p != a && p != b && p != c && orientation(a, b, p) >= 0.0 && orientation(b, c, p) >= 0.0 && orientation(c, a, p) >= 0.0
                })
        };
        let ear = (start..start + m).map(|i| i % m).find(|&i| is_ear(i));
        // Without an ear: a corner without area (the end of a used-up seam) carries nothing.
        let found = ear.or_else(|| (0..m).find(|&i| size(i).abs() <= flat))?;
        if ear.is_some() {
            triangles.push(triple(found));
        }
        ring.remove(found);
        // Going on two corners further gives rounder triangles than a fan from one corner.
        start = found + 1;
    }
    Some(triangles)
}

/// An outline cut along horizontals into trapezoids by the even-odd rule.
struct Decomposition {
    trapezoids: Vec<Trapezoid>,
    /// Whether the winding number is 0 or 1 almost everywhere.
    is_simple: bool,
}

struct Trapezoid {
    edges: [usize; 2],
    bottom: [DVec2; 2],
    top: [DVec2; 2],
}

impl Decomposition {
    fn of(outline: &[DVec2]) -> Self {
        let n = outline.len();
        let edges: Vec<[DVec2; 2]> = (0..n).map(|i| [outline[i], outline[(i + 1) % n]]).filter(|[p, q]| p.y != q.y).collect();
        let span = |e: &[DVec2; 2]| (e[0].y.min(e[1].y), e[0].y.max(e[1].y));
        let mut levels: Vec<f64> = outline.iter().map(|p| p.y).collect();
        let mut by_start: Vec<usize> = (0..edges.len()).collect();
        by_start.sort_by(|&a, &b| span(&edges[a]).0.total_cmp(&span(&edges[b]).0));
        for (k, &i) in by_start.iter().enumerate() {
            for &j in by_start[k + 1..].iter().take_while(|&&j| span(&edges[j]).0 < span(&edges[i]).1) {
                levels.extend(crossing_level(edges[i], edges[j]));
            }
        }
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        let height = levels[levels.len() - 1] - levels[0];
        let width = outline.iter().map(|p| p.x).fold(f64::MIN, f64::max) - outline.iter().map(|p| p.x).fold(f64::MAX, f64::min);
        let mut trapezoids: Vec<Trapezoid> = Vec::new();
        let mut open: HashMap<[usize; 2], usize> = HashMap::new();
        let mut active: Vec<usize> = Vec::new();
        let mut waiting = by_start.iter().copied().peekable();
        let mut excess = 0.0;
        for slab in levels.windows(2) {
            let [low, high] = [slab[0], slab[1]];
            active.retain(|&e| span(&edges[e]).1 >= high);
            while let Some(e) = waiting.next_if(|&e| span(&edges[e]).0 <= low) {
                if span(&edges[e]).1 >= high {
                    active.push(e);
                }
            }
            let ends = |e: usize| [x_at(edges[e], low), x_at(edges[e], high)];
            let middle = |e: usize| ends(e)[0] + ends(e)[1];
            active.sort_by(|&a, &b| middle(a).total_cmp(&middle(b)));
            let mut winding = 0;
            let mut still_open = HashMap::new();
            for pair in active.windows(2) {
                // Going right, an edge that leads down opens a counter-clockwise inside.
                winding += if edges[pair[0]][1].y < edges[pair[0]][0].y { 1 } else { -1 };
                let ([l0, l1], [r0, r1]) = (ends(pair[0]), ends(pair[1]));
                let area = ((r0 - l0) + (r1 - l1)) / 2.0 * (high - low);
                if winding != 0 && winding != 1 {
                    excess += area;
                }
                if winding % 2 == 0 || area <= 0.0 {
                    continue;
                }
                let key = [pair[0], pair[1]];
                let top = [DVec2::new(l1, high), DVec2::new(r1, high)];
                let index = match open.get(&key) {
                    Some(&index) => {
                        trapezoids[index].top = top;
                        index
                    }
                    None => {
                        trapezoids.push(Trapezoid { edges: key, bottom: [DVec2::new(l0, low), DVec2::new(r0, low)], top });
                        trapezoids.len() - 1
                    }
                };
                still_open.insert(trapezoids[index].edges, index);
            }
            open = still_open;
        }
        Self { trapezoids, is_simple: excess <= 1e-12 * height * width }
    }

    fn triangles(&self) -> Vec<[DVec2; 3]> {
        self.trapezoids
            .iter()
            .flat_map(|t| [[t.bottom[0], t.bottom[1], t.top[1]], [t.bottom[0], t.top[1], t.top[0]]])
            .filter(|t| orientation(t[0], t[1], t[2]) > 0.0)
            .collect()
    }
}

/// x of an edge at a level it spans, exact at its ends.
fn x_at([p, q]: [DVec2; 2], y: f64) -> f64 {
    if y == p.y {
        p.x
    } else if y == q.y {
        q.x
    } else {
        p.x + (y - p.y) / (q.y - p.y) * (q.x - p.x)
    }
}

/// Level at which two edges properly cross.
fn crossing_level(a: [DVec2; 2], b: [DVec2; 2]) -> Option<f64> {
    let (p, q) = (orientation(b[0], b[1], a[0]), orientation(b[0], b[1], a[1]));
    let (r, s) = (orientation(a[0], a[1], b[0]), orientation(a[0], a[1], b[1]));
    // Touching ends are levels already.
    (p * q < 0.0 && r * s < 0.0).then(|| a[0].y + (a[1].y - a[0].y) * (p / (p - q)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area inside by sampling the even-odd rule, against the area of the triangles.
    fn triangles_of(outline: &[[f64; 2]]) -> Vec<[DVec3; 3]> {
        triangulate(&outline.iter().map(|p| DVec3::new(p[0], p[1], 0.0)).collect::<Vec<_>>()).triangles
    }

    fn area(triangles: &[[DVec3; 3]]) -> f64 {
        triangles.iter().map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
    }

    #[test]
    fn crossing_edges_follow_the_even_odd_rule() {
        let bow_tie = [[0., 0.], [1., 1.], [1., 0.1], [0., 0.4]];
        // The edges cross at x = y = 4/13: triangles of base 0.4 and height 4/13, base 0.9 and height 9/13.
        let triangles = triangles_of(&bow_tie);
        assert!((area(&triangles) - (0.4 * 4.0 + 0.9 * 9.0) / 26.0).abs() < 1e-14, "{triangles:?}");
    }

    #[test]
    fn simple_outlines_keep_to_their_corners_and_cover_their_area() {
        // A spiral and a star with many corners, and a frame of many seams.
        let spiral = |n: usize| -> Vec<[f64; 2]> {
            let at = |i: usize, r: f64| {
                let a = i as f64 * 0.1;
                [(r + 0.05 * a) * a.cos(), (r + 0.05 * a) * a.sin()]
            };
            (0..n).map(|i| at(i, 1.0)).chain((0..n).rev().map(|i| at(i, 0.85))).collect()
        };
        let star: Vec<[f64; 2]> = (0..3000)
            .map(|i| {
                let (sin, cos) = (i as f64 / 3000.0 * std::f64::consts::TAU).sin_cos();
                let r = 1.0 + 0.5 * ((i * 7919 % 101) as f64 / 101.0);
                [r * cos, r * sin]
            })
            .collect();
        let mut frame = vec![[0.0, 0.0], [41.0, 0.0], [41.0, 2.0], [0.0, 2.0], [0.0, 0.0]];
        for i in 0..20 {
            let x = 0.5 + 2.0 * i as f64;
            frame.extend([[x, 0.5], [x, 1.5], [x + 1.0, 1.5], [x + 1.0, 0.5], [x, 0.5], [0.0, 0.0]]);
        }
        for (name, outline) in [("spiral", spiral(400)), ("star", star), ("frame", frame)] {
            let triangles = triangles_of(&outline);
            let n = outline.len();
            let signed: f64 =
                (0..n).map(|i| outline[i][0] * outline[(i + 1) % n][1] - outline[i][1] * outline[(i + 1) % n][0]).sum::<f64>() / 2.0;
            assert!((area(&triangles) - signed.abs()).abs() < 1e-9 * signed.abs(), "{name}");
            let corner = |v: &DVec3| outline.iter().any(|p| p[0] == v.x && p[1] == v.y);
            assert!(triangles.iter().flatten().all(corner), "{name}");
        }
    }
}

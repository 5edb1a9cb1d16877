//! Edges of a scene's triangles: which are open, which join surfaces that face opposite ways.
//!
//! An edge is closed where it ends at another triangle: at one with the same edge, or at the middle of one, as
//! where a wall meets a floor that goes on beyond it.

use crate::scene::{SurfaceOrigin, Triangle};
use glam::DVec3;
use serde::Serialize;
use std::collections::HashMap;

/// What was found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Edges {
    /// Edges of exactly two triangles.
    pub shared: usize,
    /// Of these, edges whose triangles face opposite ways.
    pub turned: usize,
    /// Edges of one triangle alone.
    pub open: usize,
    /// Their length, in the scene's unit.
    pub open_length: f64,
    /// Surfaces with open edges, the longest first.
    pub open_surfaces: Vec<OpenSurface>,
    /// Half of all edges are longer.
    pub median_length: f64,
    /// Corners nearer than this are one.
    pub tolerance: f64,
}

/// A surface with open edges.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OpenSurface {
    /// Its name.
    pub name: String,
    /// Length of its open edges.
    pub length: f64,
}

/// Corners nearer than this part of the median edge are one.
const WELD: f64 = 1e-4;
/// A triangle nearer than this part of the median edge closes it.
const NEAR: f64 = 1e-3;
/// Places along an edge that are looked at.
const PLACES: usize = 5;
/// Cells of the grid along an axis, at most.
const MOST_CELLS: f64 = 48.0;

impl Edges {
    /// Looks at all triangles; `surfaces` are those that they name.
    pub fn of(triangles: &[Triangle], surfaces: &[SurfaceOrigin]) -> Self {
        let sides = |t: &Triangle| [[t.vertices[0], t.vertices[1]], [t.vertices[1], t.vertices[2]], [t.vertices[2], t.vertices[0]]];
        let mut lengths: Vec<f64> = triangles.iter().flat_map(|t| sides(t).map(|[a, b]| (b - a).length())).collect();
        if lengths.is_empty() {
            return Self::default();
        }
        lengths.sort_by(f64::total_cmp);
        let median_length = lengths[lengths.len() / 2];
        let tolerance = WELD * median_length;
        let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
        let mut number = |p: DVec3| {
            let next = numbers.len() as u32;
            *numbers.entry(p.to_array().map(|c| (c / tolerance).round() as i64)).or_insert(next)
        };
        // By its corners, the lower number first: triangles, how many go along it upwards, and the first of them.
        let mut found: HashMap<[u32; 2], (usize, usize, usize)> = HashMap::new();
        for (i, t) in triangles.iter().enumerate() {
            let [a, b, c] = t.vertices.map(&mut number);
            if a == b || b == c || c == a {
                continue;
            }
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let entry = found.entry([from.min(to), from.max(to)]).or_insert((0, 0, i));
                entry.0 += 1;
                entry.1 += usize::from(from < to);
            }
        }
        let mut edges = Self { median_length, tolerance, ..Self::default() };
        let grid = Grid::new(triangles, NEAR * median_length);
        let mut open: HashMap<u32, f64> = HashMap::new();
        for (i, t) in triangles.iter().enumerate() {
            for [from, to] in sides(t) {
                let [a, b] = [number(from), number(to)];
                let Some(&(count, upwards, first)) = found.get(&[a.min(b), a.max(b)]) else { continue };
                if count == 2 && first == i {
                    edges.shared += 1;
                    edges.turned += usize::from(upwards != 1);
                }
                if count != 1 {
                    continue;
                }
                let free = (0..PLACES).filter(|k| !grid.touches(from.lerp(to, (*k as f64 + 0.5) / PLACES as f64), i)).count();
                if free > 0 {
                    let length = (to - from).length() * free as f64 / PLACES as f64;
                    edges.open += 1;
                    edges.open_length += length;
                    *open.entry(t.surface).or_default() += length;
                }
            }
        }
        let named = |(surface, length): (u32, f64)| OpenSurface {
            name: surfaces.get(surface as usize).map_or(String::new(), |s| s.name.clone()),
            length,
        };
        edges.open_surfaces = open.into_iter().map(named).collect();
        edges.open_surfaces.sort_by(|a, b| b.length.total_cmp(&a.length).then_with(|| a.name.cmp(&b.name)));
        edges
    }
}

/// Triangles by the cells of a grid that their boxes touch.
struct Grid<'t> {
    triangles: &'t [Triangle],
    cells: HashMap<[i32; 3], Vec<u32>>,
    low: DVec3,
    size: DVec3,
    near: f64,
}

impl<'t> Grid<'t> {
    fn new(triangles: &'t [Triangle], near: f64) -> Self {
        let corners = || triangles.iter().flat_map(|t| t.vertices);
        let (low, high) = corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
        let count = (2.0 * (triangles.len() as f64).cbrt()).clamp(1.0, MOST_CELLS);
        let size = ((high - low) / count).max(DVec3::splat(4.0 * near).max(DVec3::splat(f64::MIN_POSITIVE)));
        let mut grid = Self { triangles, cells: HashMap::new(), low, size, near };
        for (i, t) in triangles.iter().enumerate() {
            let [a, b, c] = t.vertices;
            let [from, to] = [a.min(b).min(c) - near, a.max(b).max(c) + near].map(|p| grid.cell(p));
            for x in from[0]..=to[0] {
                for y in from[1]..=to[1] {
                    for z in from[2]..=to[2] {
                        grid.cells.entry([x, y, z]).or_default().push(i as u32);
                    }
                }
            }
        }
        grid
    }

    fn cell(&self, p: DVec3) -> [i32; 3] {
        ((p - self.low) / self.size).to_array().map(|c| c.floor() as i32)
    }

    /// Whether a point lies on a triangle other than this one.
    fn touches(&self, p: DVec3, own: usize) -> bool {
        let Some(cell) = self.cells.get(&self.cell(p)) else { return false };
        cell.iter().any(|&i| i as usize != own && is_near(p, &self.triangles[i as usize].vertices, self.near))
    }
}

/// Whether a point is nearer to a triangle than a length.
fn is_near(p: DVec3, &[a, b, c]: &[DVec3; 3], near: f64) -> bool {
    let normal = (b - a).cross(c - a);
    let length = normal.length();
    if length == 0.0 || (p - a).dot(normal).abs() > near * length {
        return false;
    }
    // Inside, or beyond a side by less than that.
    [[a, b], [b, c], [c, a]].iter().all(|[from, to]| {
        let side = *to - *from;
        normal.cross(side).dot(p - *from) >= -near * length * side.length()
    })
}

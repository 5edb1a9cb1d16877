//! Surfaces that scatter sunlight, cut into cells, and which receivers may share points on them.

use crate::gpu_struct;
use crate::kernels::light_paths::Receiver;
use crate::kernels::trace::{MATERIAL_MIRROR, MATERIAL_SURFACE, Material, TraceTables};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

gpu_struct! {
    /// A part of one side of a parallelogram, points corner + u edge1 + v edge2, or of a triangle, points corner +
    /// √u ((1 − v) edge1 + v edge2); both uniform in u and v.
    pub(crate) struct ShadeCell {
        corner: [f32; 3],
        /// Index + 1.
        material: u32,
        edge1: [f32; 3],
        /// Cells up to this one, it included, have this probability, in units of 2⁻²⁴.
        limit: u32,
        edge2: [f32; 3],
        /// Area that a point stands for, by probability and number of points.
        weight: f32,
        /// Unit normal of its side.
        facing: [f32; 3],
        is_triangle: u32,
        /// Least u (√u of a triangle) and v, and how far they reach.
        low: [f32; 2],
        size: [f32; 2],
    }
}

/// Cells of one side of all surfaces together, about.
const CELLS: f64 = 1024.0;
/// Length of the cells of a narrow strip, by that of other cells.
const SLENDER: f32 = 3.0;
/// Strips that a narrow surface is cut into, at most: slats hide each other, and shade each other, lengthwise.
const STRIPS: f32 = 4.0;
/// Cells beyond which there are too many to look at each.
const MOST_CELLS: usize = 60_000;
/// A receiver is near a cell within so many of its radii: cosines and distance are not those of its centre.
const NEAR: f32 = 2.5;
/// Halvings of cells that are near. After as many the receiver lies on the surface or next to it, and
/// the squared distance to a point there may be next to nothing.
const HALVINGS: u32 = 6;
/// Receivers by which the points are laid out, at most.
const MOST_LOOKING: usize = 256;
/// Share of the points that is spread evenly, wherever receivers look: before a first look, and after.
const EVEN: f64 = 0.25;
const EVEN_AFTER_LOOK: f64 = 0.1;
/// What the first look does not tell about a strip.
const LEAST_OPEN: f64 = 0.05;
const LEAST_BRIGHT: f64 = 0.1;

crate::gpu_constants! {
    pub(super) const NUMBERS = {
        /// Random numbers have as many steps.
        const PROBABILITY_STEPS: u32 = 1 << 24;
    }
}

/// A part of one side of a parallelogram, points `corner + u edge1 + v edge2`, or of a triangle, points `corner +
/// √u ((1 − v) edge1 + v edge2)`; both uniform in u and v.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cell {
    corner: Vec3,
    edges: [Vec3; 2],
    is_triangle: bool,
    /// Least u (√u of a triangle) and v, and how far they reach.
    low: Vec2,
    size: Vec2,
    /// Unit normal of the side.
    facing: Vec3,
    /// Strip of a side that it belongs to.
    strip: u32,
    material: u32,
    area: f32,
    centre: Vec3,
    /// Squared distance of its farthest corner.
    radius2: f32,
}

impl Cell {
    /// The front of a triangle or parallelogram.
    fn whole(corner: Vec3, edges: [Vec3; 2], is_triangle: bool, material: u32) -> Self {
        let normal = edges[0].cross(edges[1]);
        let area = normal.length() * if is_triangle { 0.5 } else { 1.0 };
        let (low, size, facing) = (Vec2::ZERO, Vec2::ONE, normal.normalize());
        Self { corner, edges, is_triangle, low, size, facing, strip: 0, material, area, centre: corner, radius2: 0.0 }
    }

    /// The part of it from `low` on, of this size, both as its own.
    fn part(&self, low: Vec2, size: Vec2) -> Self {
        let share = |low: Vec2, size: Vec2| size.x * size.y * if self.is_triangle { 2.0 * low.x + size.x } else { 1.0 };
        let mut part = Self { low: self.low + low * self.size, size: size * self.size, ..*self };
        part.area = self.area * share(part.low, part.size) / share(self.low, self.size);
        part.centre = part.at(Vec2::splat(0.5));
        part.radius2 = part.corners().iter().map(|c| c.distance_squared(part.centre)).fold(0.0, f32::max);
        part
    }

    /// Cut along its first edge, or both if it is no narrow strip.
    fn cut(&self, length: f32) -> impl Iterator<Item = Self> {
        let [e1, e2] = self.edges;
        let width = if self.is_triangle { e1.distance(e2) } else { e2.length() };
        let pieces = |edge: f32, length: f32| (edge / length).ceil().clamp(1.0, 64.0) as u32;
        let narrow = width < length;
        let along =
            pieces(e1.length().max(if self.is_triangle { e2.length() } else { 0.0 }), if narrow { SLENDER * length } else { length });
        let across = if narrow { pieces(width * STRIPS, length).min(STRIPS as u32) } else { pieces(width, length) };
        let size = Vec2::new(1.0 / along as f32, 1.0 / across as f32);
        let whole = *self;
        (0..along * across).map(move |i| Self {
            strip: whole.strip + i % across,
            ..whole.part(Vec2::new((i / across) as f32, (i % across) as f32) * size, size)
        })
    }

    fn at(&self, place: Vec2) -> Vec3 {
        let (at, [e1, e2]) = (self.low + self.size * place, self.edges);
        self.corner + if self.is_triangle { (e1 * (1.0 - at.y) + e2 * at.y) * at.x } else { e1 * at.x + e2 * at.y }
    }

    fn corners(&self) -> [Vec3; 4] {
        [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].map(|place| self.at(place))
    }

    /// Two halves across its longer side.
    fn halves(&self) -> [Self; 2] {
        let [a, b, c, d] = self.corners();
        let along = a.distance_squared(b).max(c.distance_squared(d)) > b.distance_squared(d);
        let size = if along { Vec2::new(0.5, 1.0) } else { Vec2::new(1.0, 0.5) };
        [Vec2::ZERO, Vec2::ONE - size].map(|low| self.part(low, size))
    }

    /// Whether some of it is before the receiver and the receiver before it.
    fn is_before(&self, receiver: &Receiver) -> bool {
        let (eye, normal) = (Vec3::from(receiver.position), Vec3::from(receiver.normal));
        if self.facing.dot(eye - self.corner) <= 0.0 {
            return false;
        }
        let height = normal.dot(self.centre - eye);
        height > 0.0 || (height * height < self.radius2 && self.corners().iter().any(|c| normal.dot(*c - eye) > 0.0))
    }

    fn is_near(&self, receiver: &Receiver) -> bool {
        self.centre.distance_squared(Vec3::from(receiver.position)) < NEAR * NEAR * self.radius2
    }

    /// What a receiver sees of a unit of its area if nothing is in the way: cosines by squared distance.
    fn seen_from(&self, receiver: &Receiver) -> f64 {
        let way = self.centre - Vec3::from(receiver.position);
        let below = -way.dot(self.facing);
        let height = way.dot(Vec3::from(receiver.normal));
        if below <= 0.0 || height <= 0.0 {
            return 0.0;
        }
        f64::from(below * height / way.length_squared().powi(2))
    }
}

/// All cells of a scene.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    cells: Vec<Cell>,
    /// What receivers would see of each if nothing were in the way.
    seen: Vec<f64>,
}

/// Whether a surface scatters in the same way to all directions, or not at all. Panes may reflect: paths
/// see to that.
fn is_plain(material: &Material) -> bool {
    match material.kind {
        MATERIAL_SURFACE => material.specular == [0.0; 3] && (material.is_smooth() || material.specular_transmitted == [0.0; 3]),
        kind => kind != MATERIAL_MIRROR,
    }
}

fn scatters(material: &Material) -> bool {
    material.kind == 1 && material.diffuse.iter().chain(&material.diffuse_transmitted).any(|v| *v > 0.0)
}

impl Cells {
    /// Nothing if points cannot stand for all that the scene's surfaces scatter.
    pub fn of(tables: &TraceTables) -> Option<Self> {
        let material = |t: usize| &tables.materials[tables.triangle_materials[t] as usize];
        let all = 0..tables.triangles.len();
        if !all.clone().all(|t| is_plain(material(t))) {
            return None;
        }
        let area = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(*c - *a).length() / 2.0;
        let lit: Vec<usize> = all.filter(|&t| scatters(material(t)) && area(&tables.triangles[t]) > 0.0).collect();
        if lit.is_empty() || 2 * lit.len() > MOST_CELLS {
            return None;
        }
        let length = (lit.iter().map(|&t| f64::from(area(&tables.triangles[t]))).sum::<f64>() / CELLS).sqrt() as f32;
        let (mut cells, mut strips) = (Vec::new(), 0);
        let mut rest = &lit[..];
        while let [t, others @ ..] = rest {
            let material = tables.triangle_materials[*t];
            let next = others.first().filter(|n| **n == t + 1 && tables.triangle_materials[**n] == material);
            let quad = next.and_then(|n| parallelogram(&tables.triangles[*t], &tables.triangles[*n]));
            rest = if quad.is_some() { &others[1..] } else { others };
            let front = quad.map_or_else(
                || {
                    let [a, b, c] = pointed(tables.triangles[*t]);
                    Cell::whole(a, [b - a, c - a], true, material)
                },
                |[a, e1, e2]| Cell::whole(a, [e1, e2], false, material),
            );
            for facing in [front.facing, -front.facing] {
                cells.extend(Cell { facing, strip: strips, ..front }.cut(length));
                strips = cells.last().map_or(0, |c| c.strip + 1);
            }
            if cells.len() > MOST_CELLS {
                return None;
            }
        }
        Some(Self { cells, seen: Vec::new() })
    }

    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Which receivers may share points: those who are near no cell, and to whom as many as stand for each path
    /// of their own tell no less than it. Leaves only cells that these can see.
    pub fn choose(&mut self, receivers: &[Receiver], points_per_path: f64) -> Vec<bool> {
        self.refine(receivers);
        let near = |r: &Receiver| self.cells.iter().any(|c| c.is_near(r) && c.is_before(r));
        let sum = |r: &Receiver| self.cells.iter().map(|c| c.seen_from(r) * f64::from(c.area)).sum::<f64>();
        // Cosines by squared distance of all, nothing for those who are near.
        let whole: Vec<Option<f64>> = receivers.par_iter().map(|r| (!near(r)).then(|| sum(r))).collect();
        let looking: Vec<(&Receiver, f64)> =
            strided(receivers.len(), MOST_LOOKING).filter_map(|r| Some((&receivers[r], whole[r]?.max(1e-30)))).collect();
        // Between errors of the same size at all receivers and the same share of their light.
        let square = |c: &Cell, r: &Receiver, whole: f64| (c.seen_from(r) * f64::from(c.area)).powi(2) / whole;
        let seen = |c: &Cell| looking.iter().map(|(r, whole)| square(c, r, *whole)).sum::<f64>().sqrt();
        self.seen = self.cells.par_iter().map(seen).collect();
        let probabilities = self.probabilities(&self.seen, EVEN);
        let suited: Vec<bool> = receivers
            .par_iter()
            .zip(&whole)
            .map(|(r, whole)| {
                let Some(whole) = whole else { return false };
                // Variance of one point's light, relative to the square of its mean.
                let square = |(c, q): (&Cell, &f64)| (c.seen_from(r) * f64::from(c.area)).powi(2) / q.max(1e-30);
                let squares: f64 = self.cells.iter().zip(&probabilities).map(square).sum();
                squares <= whole * whole * points_per_path
            })
            .collect();
        let chosen: Vec<&Receiver> = receivers.iter().zip(&suited).filter(|(_, s)| **s).map(|(r, _)| r).collect();
        let before: Vec<bool> = self.cells.par_iter().map(|c| chosen.iter().any(|r| c.is_before(r))).collect();
        self.seen = self.seen.iter().zip(&before).filter(|(_, b)| **b).map(|(s, _)| *s).collect();
        self.cells = self.cells.iter().zip(&before).filter(|(_, b)| **b).map(|(c, _)| *c).collect();
        suited
    }

    /// Halves cells that receivers are near, until none is or it would lead nowhere.
    fn refine(&mut self, receivers: &[Receiver]) {
        for _ in 0..HALVINGS {
            let near: Vec<bool> = self.cells.par_iter().map(|c| receivers.iter().any(|r| c.is_near(r) && c.is_before(r))).collect();
            let more = near.iter().filter(|n| **n).count();
            if more == 0 || self.cells.len() + more > MOST_CELLS {
                return;
            }
            let parts = |(c, near): (&Cell, &bool)| if *near { c.halves().to_vec() } else { vec![*c] };
            self.cells = self.cells.iter().zip(&near).flat_map(parts).collect();
        }
    }

    /// Every so many of the cells, a record for a point in each.
    pub fn samples(&self, step: usize) -> Vec<ShadeCell> {
        self.cells.iter().step_by(step).map(|c| record(c, 0, c.area)).collect()
    }

    /// Probabilities by what receivers would see of the cells, how much of this they see, and how bright it is,
    /// the latter two as found for every `step`th: means over each strip.
    pub(crate) fn after_look(&self, step: usize, open: &[[f64; 2]], bright: &[f64]) -> Vec<f64> {
        let strips = self.cells.iter().map(|c| c.strip as usize + 1).max().unwrap_or(0);
        let mut sums = vec![[0.0f64; 4]; strips];
        for (i, cell) in self.cells.iter().step_by(step).enumerate() {
            let sum = &mut sums[cell.strip as usize];
            let area = f64::from(cell.area);
            let values = [open[i][0], open[i][1], area * bright[i], area];
            sum.iter_mut().zip(values).for_each(|(s, v)| *s += v);
        }
        let all = sums.iter().fold([0.0; 2], |all, s| [all[0] + s[2], all[1] + s[3]]);
        let mean = all[0] / all[1].max(1e-30);
        let of = |(cell, seen): (&Cell, &f64)| {
            let [seen_open, seen_all, light, area] = sums[cell.strip as usize];
            // What a few receivers and suns leave hidden or dark others may see.
            let open = if seen_all > 0.0 { seen_open / seen_all } else { 0.0 };
            let bright = if area > 0.0 { light / area } else { mean };
            seen * (open + LEAST_OPEN) * (bright + LEAST_BRIGHT * mean)
        };
        let wanted: Vec<f64> = self.cells.iter().zip(&self.seen).map(of).collect();
        self.probabilities(&wanted, EVEN_AFTER_LOOK)
    }

    /// What a receiver would see of every `step`th cell.
    pub(crate) fn seen_by(&self, receiver: &Receiver, step: usize) -> Vec<f64> {
        self.cells.iter().step_by(step).map(|c| c.seen_from(receiver) * f64::from(c.area)).collect()
    }

    /// Probability of each cell for a point: what is wanted, and an even part.
    fn probabilities(&self, wanted: &[f64], even: f64) -> Vec<f64> {
        let area: f64 = self.cells.iter().map(|c| f64::from(c.area)).sum();
        let all: f64 = wanted.iter().sum();
        let even = if all > 0.0 { even } else { 1.0 };
        let of = |(c, w): (&Cell, &f64)| even * f64::from(c.area) / area + (1.0 - even) * w / all.max(1e-30);
        self.cells.iter().zip(wanted).map(of).collect()
    }

    /// Records for `points`, drawn with these probabilities.
    pub fn records(&self, probabilities: &[f64], points: u32) -> Vec<ShadeCell> {
        // Every cell has a step; probabilities are those of the steps, exactly.
        let free = f64::from(PROBABILITY_STEPS - self.cells.len() as u32);
        let whole: f64 = probabilities.iter().sum();
        let (mut sum, mut before) = (0.0, 0);
        let mut records = Vec::with_capacity(self.cells.len());
        for (i, (cell, probability)) in self.cells.iter().zip(probabilities).enumerate() {
            sum += probability;
            let last = i + 1 == self.cells.len();
            let limit = if last { PROBABILITY_STEPS } else { (sum / whole * free) as u32 + i as u32 + 1 };
            let weight = f64::from(cell.area) * f64::from(PROBABILITY_STEPS) / (f64::from(limit - before) * f64::from(points));
            records.push(record(cell, limit, weight as f32));
            before = limit;
        }
        records
    }
}

/// Every so many of `count`, at most `most`.
pub(super) fn strided(count: usize, most: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(most).max(1))
}

fn record(cell: &Cell, limit: u32, weight: f32) -> ShadeCell {
    ShadeCell {
        corner: cell.corner.to_array(),
        material: cell.material + 1,
        edge1: cell.edges[0].to_array(),
        limit,
        edge2: cell.edges[1].to_array(),
        weight,
        facing: cell.facing.to_array(),
        is_triangle: u32::from(cell.is_triangle),
        low: cell.low.to_array(),
        size: cell.size.to_array(),
    }
}

/// A corner of the parallelogram that two triangles make and the edges that meet there, the longer one first.
fn parallelogram(first: &[Vec3; 3], second: &[Vec3; 3]) -> Option<[Vec3; 3]> {
    let [[a, b, c], [p, q, d]] = [*first, *second];
    let small = 1e-5 * (b - a).abs().max((d - a).abs()).max_element();
    if p != a || q != c || (a + c - b - d).abs().max_element() > small {
        return None;
    }
    let (e1, e2) = (b - a, d - a);
    Some(if e1.length_squared() >= e2.length_squared() { [a, e1, e2] } else { [a + e2, -e2, e1] })
}

/// The triangle with its shortest edge opposite to the first corner.
fn pointed([a, b, c]: [Vec3; 3]) -> [Vec3; 3] {
    let (ab, bc, ca) = (a.distance_squared(b), b.distance_squared(c), c.distance_squared(a));
    if bc <= ab && bc <= ca {
        [a, b, c]
    } else if ca <= ab {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

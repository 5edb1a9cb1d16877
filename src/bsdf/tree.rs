//! Tensor trees: scattering functions over the Shirley-Chiu square, finer where they change.
//!
//! Dimensions, each 0…1 (Radiance `bsdf_t.c`):
//! * rank 4: incident square (x, y), outgoing square (x, y);
//! * rank 3 (isotropic): 0.5 − 0.5 sin θ of the incident light (so 0.5 is normal, 0 grazing; the
//!   upper half is unused), then the outgoing square after turning the incident azimuth to 0.

mod grid;
mod text;

pub(super) use text::TreeParser;

use crate::bins::shirley_chiu::square_from_disk;
use glam::DVec3;
use std::f64::consts::PI;

/// Keeps normal incidence in the lower half of dimension 0 of rank 3, as Radiance does.
const RANK3_OFFSET: f64 = 1e-6;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Node {
    /// Index of the first of 2^rank consecutive nodes.
    Branch(u32),
    /// Grid of (2^log2)^rank values from `first`.
    Leaf { log2: u8, first: u32 },
}

/// Second word of a packed branch, see [`TensorTree::packed`].
pub(crate) const PACKED_BRANCH: u32 = u32::MAX;

/// A scattering function in 1/sr on an adaptive grid.
#[derive(Debug, Clone, PartialEq)]
pub struct TensorTree {
    rank: usize,
    nodes: Vec<Node>,
    values: Vec<f32>,
}

/// One cell of constant value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Lower corner; the fourth coordinate is unused at rank 3.
    pub corner: [f64; 4],
    /// Length of every side.
    pub side: f64,
    /// Value, 1/sr.
    pub value: f64,
}

impl TensorTree {
    /// A tree of one value everywhere.
    ///
    /// # Panics
    /// If `rank` is neither 3 nor 4.
    pub fn constant(rank: usize, value: f64) -> Self {
        assert!(rank == 3 || rank == 4);
        Self { rank, nodes: vec![Node::Leaf { log2: 0, first: 0 }], values: vec![value as f32] }
    }

    /// 3 (isotropic) or 4.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Cells per side of the finest part.
    pub fn resolution(&self) -> usize {
        let mut finest = 1.0f64;
        self.for_each_cell(|c| finest = finest.min(c.side));
        (1.0 / finest).round() as usize
    }

    /// Number of stored values.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether no value is stored; never the case for a tree that was read.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The value at a point of the unit cube, `point[..rank]`.
    pub(crate) fn lookup(&self, point: [f64; 4]) -> f64 {
        self.cell(point).value
    }

    /// The cell around a point of the unit cube, `point[..rank]`.
    pub fn cell(&self, point: [f64; 4]) -> Cell {
        let mut p = point.map(|c| c.clamp(0.0, 1.0 - 1e-12));
        let mut node = self.nodes[0];
        let (mut corner, mut side) = ([0.0; 4], 1.0);
        loop {
            match node {
                Node::Branch(first) => {
                    let mut child = 0;
                    side /= 2.0;
                    for (i, (c, low)) in p.iter_mut().zip(&mut corner).take(self.rank).enumerate() {
                        *c *= 2.0;
                        if *c >= 1.0 {
                            *c -= 1.0;
                            *low += side;
                            child |= 1 << i;
                        }
                    }
                    node = self.nodes[first as usize + child];
                }
                Node::Leaf { log2, first } => {
                    let n = 1usize << log2;
                    side /= n as f64;
                    let mut index = 0;
                    for (c, low) in p.iter().zip(&mut corner).take(self.rank) {
                        let place = ((c * n as f64) as usize).min(n - 1);
                        *low += place as f64 * side;
                        index = index * n + place;
                    }
                    return Cell { corner, side, value: f64::from(self.values[first as usize + index]) };
                }
            }
        }
    }

    /// Calls `f` with every cell that holds this incident position (`point[..rank - 2]`): what
    /// light from there meets, over all outgoing directions.
    pub(crate) fn for_each_outgoing_cell(&self, point: [f64; 4], mut f: impl FnMut(Cell)) {
        let fixed = self.rank - 2;
        self.visit(self.nodes[0], [0.0; 4], 1.0, &|corner, side| (0..fixed).all(|i| holds(corner[i], side, point[i])), &mut f);
    }

    /// The tree with every value changed.
    pub fn map(&self, f: impl Fn(f32) -> f32) -> Self {
        Self { rank: self.rank, nodes: self.nodes.clone(), values: self.values.iter().map(|v| f(*v)).collect() }
    }

    /// Nodes and values for a device: a node is (first child, [`PACKED_BRANCH`]) or (first value,
    /// log2 of the cells per side of its grid); children and grids are ordered as in the text.
    pub(crate) fn packed(&self) -> (Vec<[u32; 2]>, &[f32]) {
        let packed = |node: &Node| match *node {
            Node::Branch(first) => [first, PACKED_BRANCH],
            Node::Leaf { log2, first } => [first, u32::from(log2)],
        };
        (self.nodes.iter().map(packed).collect(), &self.values)
    }

    /// The tree of light that travels the same paths backwards (Helmholtz reciprocity); only at
    /// rank 4, where incident and outgoing square can be exchanged.
    pub fn reversed(&self) -> Option<Self> {
        if self.rank != 4 {
            return None;
        }
        // −direction lies at 1 − coordinate of the square: both squares are exchanged and mirrored.
        let exchanged = |bits: usize| (bits >> 2 | (bits & 3) << 2) ^ 15;
        let mut nodes = Vec::with_capacity(self.nodes.len());
        let mut values = self.values.clone();
        for node in &self.nodes {
            nodes.push(*node);
            if let Node::Leaf { log2, first } = *node {
                let n = 1usize << log2;
                let grid = &self.values[first as usize..first as usize + n.pow(4)];
                for (k, value) in values[first as usize..].iter_mut().take(grid.len()).enumerate() {
                    let digit = |d: u32| k / n.pow(3 - d) % n;
                    let from = [2, 3, 0, 1].iter().fold(0, |index, &d| index * n + (n - 1 - digit(d)));
                    *value = grid[from];
                }
            }
        }
        for node in &self.nodes {
            if let Node::Branch(first) = *node {
                let first = first as usize;
                for child in 0..16 {
                    nodes[first + child] = self.nodes[first + exchanged(child)];
                }
            }
        }
        Some(Self { rank: 4, nodes, values })
    }

    /// The point of the unit cube for two directions of travel.
    pub fn point(&self, outgoing: DVec3, incident: DVec3) -> [f64; 4] {
        if self.rank == 4 {
            let [a, b] = square_from_disk(incident.x, incident.y);
            let [c, d] = square_from_disk(outgoing.x, outgoing.y);
            return [a, b, c, d];
        }
        let sin = incident.x.hypot(incident.y).min(1.0);
        // At normal incidence an isotropic scatterer has no azimuth; 0 is as good as any.
        let (cos_phi, sin_phi) = if sin > 1e-12 { (incident.x / sin, incident.y / sin) } else { (1.0, 0.0) };
        let [c, d] = square_from_disk(outgoing.x * cos_phi + outgoing.y * sin_phi, outgoing.y * cos_phi - outgoing.x * sin_phi);
        [0.5 - RANK3_OFFSET - 0.5 * sin, c, d, 0.0]
    }

    /// The value in 1/sr for two directions of travel: that of the cell, not interpolated.
    pub fn evaluate(&self, outgoing: DVec3, incident: DVec3) -> f64 {
        self.lookup(self.point(outgoing, incident))
    }

    /// Direct-hemispherical value of light travelling along `incident`: the exact integral over
    /// the cells.
    pub fn direct_hemispherical(&self, incident: DVec3) -> f64 {
        let mut sum = 0.0;
        self.for_each_outgoing_cell(self.point(DVec3::Z, incident), |c| sum += c.value * PI * c.side * c.side);
        sum
    }

    /// Hemispherical-hemispherical value (uniform diffuse incidence): the exact integral over the
    /// cells.
    pub fn hemispherical(&self) -> f64 {
        let mut sum = 0.0;
        self.for_each_cell(|c| {
            let outgoing = PI * c.side * c.side;
            let incident = if self.rank == 4 { c.side * c.side } else { Self::diffuse_share(&c) };
            sum += c.value * outgoing * incident;
        });
        sum
    }

    /// The share of uniform diffuse light that arrives in the incident range of a rank 3 cell.
    pub(super) fn diffuse_share(cell: &Cell) -> f64 {
        // sin θ = 1 − 2 x on the lower half; the share is the difference of sin²θ.
        let sin = |x: f64| (1.0 - 2.0 * x).clamp(0.0, 1.0);
        sin(cell.corner[0]).powi(2) - sin(cell.corner[0] + cell.side).powi(2)
    }

    /// Calls `f` with every cell.
    pub(crate) fn for_each_cell(&self, mut f: impl FnMut(Cell)) {
        self.visit(self.nodes[0], [0.0; 4], 1.0, &|_, _| true, &mut f);
    }

    /// Visits the cells of nodes, and the cells inside leaf grids, that `wanted(corner, side)`
    /// accepts.
    fn visit(&self, node: Node, corner: [f64; 4], side: f64, wanted: &dyn Fn(&[f64; 4], f64) -> bool, f: &mut dyn FnMut(Cell)) {
        if !wanted(&corner, side) {
            return;
        }
        match node {
            Node::Branch(first) => {
                let half = side / 2.0;
                for child in 0..1usize << self.rank {
                    let mut c = corner;
                    for (i, x) in c.iter_mut().take(self.rank).enumerate() {
                        *x += if child >> i & 1 == 1 { half } else { 0.0 };
                    }
                    self.visit(self.nodes[first as usize + child], c, half, wanted, f);
                }
            }
            Node::Leaf { log2, first } => {
                let n = 1usize << log2;
                let cell = side / n as f64;
                for index in 0..n.pow(self.rank as u32) {
                    let mut rest = index;
                    let mut c = corner;
                    for x in c.iter_mut().take(self.rank).rev() {
                        *x += (rest % n) as f64 * cell;
                        rest /= n;
                    }
                    if wanted(&c, cell) {
                        f(Cell { corner: c, side: cell, value: f64::from(self.values[first as usize + index]) });
                    }
                }
            }
        }
    }
}

fn holds(lower: f64, side: f64, coordinate: f64) -> bool {
    lower <= coordinate && coordinate < lower + side
}

#[cfg(test)]
mod tests;

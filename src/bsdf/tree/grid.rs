//! Tensor trees from full grids of cells, and back.

use super::{Cell, Node, TensorTree};

impl TensorTree {
    /// A tree over a full grid of (2^log2)^rank values, the last dimension running fastest; cells
    /// that differ by no more than `tolerance` times the largest of them are joined to their mean.
    ///
    /// # Panics
    /// If the number of values does not fit.
    pub fn from_grid(rank: usize, log2: u32, grid: &[f32], tolerance: f64) -> Self {
        assert_eq!(grid.len(), 1usize << (log2 as usize * rank));
        let mut tree = Self { rank, nodes: vec![Node::Leaf { log2: 0, first: 0 }], values: Vec::new() };
        let joined = tree.build(0, log2, [0; 4], 1 << log2, grid, tolerance);
        if let Some(value) = joined {
            tree.set_leaf(0, &[value]);
        }
        tree
    }

    /// The means over a full grid of (2^log2)^rank cells, the last dimension running fastest.
    ///
    /// At rank 3 the mean along the first dimension is weighted by the light that arrives there.
    pub fn to_grid(&self, log2: u32) -> Vec<f32> {
        let n = 1usize << log2;
        let mut grid = vec![0f64; n.pow(self.rank as u32)];
        let mut weights = vec![0f64; if self.rank == 3 { grid.len() } else { 0 }];
        self.for_each_cell(|cell| {
            // A cell covers whole grid cells, or lies inside one.
            let span = (cell.side * n as f64).round().max(1.0) as usize;
            let part = (cell.side * n as f64).min(1.0);
            let start = cell.corner.map(|c| (c * n as f64 + 1e-9) as usize);
            for k in 0..span.pow(self.rank as u32) {
                let digit = |d: usize| start[d] + k / span.pow((self.rank - 1 - d) as u32) % span;
                let index = (0..self.rank).fold(0, |index, d| index * n + digit(d));
                if self.rank == 4 {
                    grid[index] += cell.value * part.powi(4);
                } else {
                    let side = cell.side.min(1.0 / n as f64);
                    let corner = [cell.corner[0].max(digit(0) as f64 / n as f64), 0.0, 0.0, 0.0];
                    let weight = Self::diffuse_share(&Cell { corner, side, value: 0.0 }) * part.powi(2);
                    grid[index] += cell.value * weight;
                    weights[index] += weight;
                }
            }
        });
        for (value, weight) in grid.iter_mut().zip(&weights) {
            *value = if *weight > 0.0 { *value / weight } else { 0.0 };
        }
        grid.into_iter().map(|v| v as f32).collect()
    }

    /// Builds the cube of side 2^log2 at `origin` into node `slot`; a cube of one value is not
    /// stored but returned.
    fn build(&mut self, slot: usize, log2: u32, origin: [usize; 4], n: usize, grid: &[f32], tolerance: f64) -> Option<f32> {
        if log2 == 0 {
            return Some(grid[origin.iter().take(self.rank).fold(0, |k, d| k * n + d)]);
        }
        let count = 1usize << self.rank;
        let (nodes, values) = (self.nodes.len(), self.values.len());
        self.nodes.resize(nodes + count, Node::Leaf { log2: 0, first: 0 });
        let half = 1usize << (log2 - 1);
        let mut children = [None; 16];
        for (child, slot_value) in children.iter_mut().take(count).enumerate() {
            let corner = std::array::from_fn(|d| origin[d] + if child >> d & 1 == 1 { half } else { 0 });
            *slot_value = self.build(nodes + child, log2 - 1, corner, n, grid, tolerance);
        }
        let children = &children[..count];
        if children.iter().all(Option::is_some) {
            let known = || children.iter().flatten().copied();
            let (low, high) = (known().fold(f32::MAX, f32::min), known().fold(f32::MIN, f32::max));
            self.nodes.truncate(nodes);
            self.values.truncate(values);
            if f64::from(high - low) <= tolerance * f64::from(high.abs()) {
                return Some((known().map(f64::from).sum::<f64>() / count as f64) as f32);
            }
            // A grid of 2^rank numbers, in which the last dimension runs fastest.
            let ordered: Vec<f32> =
                (0..count).map(|k| children[k.reverse_bits() >> (usize::BITS as usize - self.rank)].unwrap_or(0.0)).collect();
            self.set_leaf(slot, &ordered);
            return None;
        }
        for (child, value) in children.iter().enumerate() {
            if let Some(value) = value {
                self.set_leaf(nodes + child, &[*value]);
            }
        }
        self.nodes[slot] = Node::Branch(nodes as u32);
        None
    }

    fn set_leaf(&mut self, slot: usize, values: &[f32]) {
        self.nodes[slot] = Node::Leaf { log2: u8::from(values.len() > 1), first: self.values.len() as u32 };
        self.values.extend_from_slice(values);
    }
}

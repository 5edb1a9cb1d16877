//! Tensor trees: scattering functions over the Shirley-Chiu square, finer where they change.
//!
//! Dimensions, each 0…1 (Radiance `bsdf_t.c`):
//! * rank 4: incident square (x, y), outgoing square (x, y);
//! * rank 3 (isotropic): 0.5 − 0.5 sin θ of the incident light (so 0.5 is normal, 0 grazing; the
//!   upper half is unused), then the outgoing square after turning the incident azimuth to 0.
//!
//! Text: a group `{…}` is either 2^rank groups, in which bit i of the position selects the upper
//! half of dimension i, or a grid of (2^k)^rank numbers, in which the last dimension runs fastest.

use super::numbers::WORD_LIMIT;
use crate::bins::shirley_chiu::square_from_disk;
use crate::error::{Error, Result};
use glam::DVec3;
use std::f64::consts::PI;

/// Deepest nesting read: cells of 1/65536 per side.
const DEPTH_LIMIT: usize = 16;
/// Most numbers read: 512 MiB of them, a full rank 4 grid of 2^6 per side eight times over.
const VALUE_LIMIT: usize = 1 << 27;
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
pub const PACKED_BRANCH: u32 = u32::MAX;

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

    /// Reads the nested text.
    ///
    /// # Errors
    /// What is wrong and in which line of the text.
    pub fn parse(text: &str, rank: usize) -> Result<Self> {
        let mut parser = TreeParser::new(rank);
        parser.feed(text.as_bytes(), 1)?;
        parser.finish()
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
    pub fn lookup(&self, point: [f64; 4]) -> f64 {
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
    pub fn for_each_outgoing_cell(&self, point: [f64; 4], mut f: impl FnMut(Cell)) {
        let fixed = self.rank - 2;
        self.visit(self.nodes[0], [0.0; 4], 1.0, &|corner, side| (0..fixed).all(|i| holds(corner[i], side, point[i])), &mut f);
    }

    /// The tree with every value changed.
    pub fn map(&self, f: impl Fn(f32) -> f32) -> Self {
        Self { rank: self.rank, nodes: self.nodes.clone(), values: self.values.iter().map(|v| f(*v)).collect() }
    }

    /// Nodes and values for a device: a node is (first child, [`PACKED_BRANCH`]) or (first value,
    /// log2 of the cells per side of its grid); children and grids are ordered as in the text.
    pub fn packed(&self) -> (Vec<[u32; 2]>, &[f32]) {
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

    /// The nested text of the tree, as in a file.
    ///
    /// # Errors
    /// What `out` returns.
    pub fn write_text(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        self.write_node(self.nodes[0], 0, out)
    }

    fn write_node(&self, node: Node, depth: usize, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        let indent = "  ".repeat(depth);
        match node {
            Node::Branch(first) => {
                writeln!(out, "{indent}{{")?;
                for child in 0..1usize << self.rank {
                    self.write_node(self.nodes[first as usize + child], depth + 1, out)?;
                }
                writeln!(out, "{indent}}}")
            }
            Node::Leaf { log2, first } => {
                write!(out, "{indent}{{")?;
                let count = 1usize << (usize::from(log2) * self.rank);
                for (i, v) in self.values[first as usize..first as usize + count].iter().enumerate() {
                    // Short lines: Radiance's reader has fixed buffers.
                    write!(out, "{}{v:e}", if i % 16 == 15 { '\n' } else { ' ' })?;
                }
                writeln!(out, " }}")
            }
        }
    }

    /// The share of uniform diffuse light that arrives in the incident range of a rank 3 cell.
    pub(super) fn diffuse_share(cell: &Cell) -> f64 {
        // sin θ = 1 − 2 x on the lower half; the share is the difference of sin²θ.
        let sin = |x: f64| (1.0 - 2.0 * x).clamp(0.0, 1.0);
        sin(cell.corner[0]).powi(2) - sin(cell.corner[0] + cell.side).powi(2)
    }

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

    /// Calls `f` with every cell.
    pub fn for_each_cell(&self, mut f: impl FnMut(Cell)) {
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

/// Reads a tree's text piece by piece.
pub(super) struct TreeParser {
    tree: TensorTree,
    word: String,
    /// Open branches: first child and how many children have come.
    branches: Vec<(u32, usize)>,
    state: State,
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    /// Nothing read.
    Start,
    /// A brace was opened for this node, its content is not known.
    Opened(u32),
    /// Numbers of this leaf are read; its first value.
    InLeaf(u32, u32),
    /// Between the children of the innermost branch.
    InBranch,
    /// The outermost brace is closed.
    Done,
}

impl TreeParser {
    pub fn new(rank: usize) -> Self {
        assert!(rank == 3 || rank == 4);
        let tree = TensorTree { rank, nodes: Vec::new(), values: Vec::new() };
        Self { tree, word: String::new(), branches: Vec::new(), state: State::Start }
    }

    pub fn feed(&mut self, text: &[u8], mut line: usize) -> Result<()> {
        for &byte in text {
            match byte {
                b'{' | b'}' => {
                    self.end_word().map_err(|e| e.line(line))?;
                    if byte == b'{' { self.open() } else { self.close() }.map_err(|e| e.line(line))?;
                }
                b',' | b';' => self.end_word().map_err(|e| e.line(line))?,
                b if b.is_ascii_whitespace() => {
                    self.end_word().map_err(|e| e.line(line))?;
                    line += usize::from(b == b'\n');
                }
                _ if self.word.len() >= WORD_LIMIT => return Err(not_a_number(&self.word).line(line)),
                b => self.word.push(b as char),
            }
        }
        Ok(())
    }

    pub fn finish(mut self) -> Result<TensorTree> {
        self.end_word()?;
        match self.state {
            State::Done => Ok(self.tree),
            State::Start => Err(Error::new("the tensor tree is empty")),
            state => {
                let open = self.branches.len() + usize::from(state != State::InBranch);
                Err(Error::new(format!("the tensor tree ends inside {open} open brace(s)"))
                    .help("closing braces are missing, or the file is cut off: generate it again"))
            }
        }
    }

    fn children(&self) -> usize {
        1 << self.tree.rank
    }

    fn open(&mut self) -> Result<()> {
        let slot = match self.state {
            State::Start => {
                self.tree.nodes.push(Node::Leaf { log2: 0, first: 0 });
                0
            }
            State::Opened(slot) => {
                if self.branches.len() >= DEPTH_LIMIT {
                    return Err(Error::new(format!("the tensor tree is nested deeper than {DEPTH_LIMIT} levels"))
                        .help("trees of 2^7 by 2^7 directions have 7; closing braces may be missing"));
                }
                let first = self.tree.nodes.len() as u32;
                self.tree.nodes.resize(self.tree.nodes.len() + self.children(), Node::Leaf { log2: 0, first: 0 });
                self.tree.nodes[slot as usize] = Node::Branch(first);
                self.branches.push((first, 1));
                first
            }
            State::InBranch => {
                let wanted = self.children();
                let (first, count) = self.branches.last_mut().expect("a branch is open");
                if *count == wanted {
                    return Err(Error::new(format!("more than {wanted} groups in a brace of a rank {} tensor tree", self.tree.rank))
                        .help("is IncidentDataStructure (TensorTree3 or TensorTree4) right?"));
                }
                *count += 1;
                *first + *count as u32 - 1
            }
            State::InLeaf(..) => {
                return Err(Error::new("an opening brace among numbers of a tensor tree")
                    .help("a group holds either numbers or groups; a closing brace may be missing before"));
            }
            State::Done => {
                return Err(
                    Error::new("more text after the tensor tree").help("a block holds one group in braces: is there a brace too many?")
                );
            }
        };
        self.state = State::Opened(slot);
        Ok(())
    }

    fn close(&mut self) -> Result<()> {
        match self.state {
            State::Opened(_) => {
                return Err(
                    Error::new("an empty brace in the tensor tree").help("a group holds numbers or groups; generate the file again")
                );
            }
            State::InLeaf(slot, first) => {
                let count = self.tree.values.len() - first as usize;
                let log2 = (0..=DEPTH_LIMIT).find(|k| 1usize.checked_shl((k * self.tree.rank) as u32) == Some(count)).ok_or_else(|| {
                    Error::new(format!("a brace of the tensor tree has {count} values; it must be a power of {}", self.children()))
                        .help("values are numbers with decimal points, separated by blanks or commas")
                })?;
                self.tree.nodes[slot as usize] = Node::Leaf { log2: log2 as u8, first };
            }
            State::InBranch => {
                let (_, count) = self.branches.pop().expect("a branch is open");
                if count != self.children() {
                    return Err(Error::new(format!(
                        "{count} groups in a brace of a rank {} tensor tree; {} are needed",
                        self.tree.rank,
                        self.children()
                    ))
                    .help("is IncidentDataStructure (TensorTree3 or TensorTree4) right?"));
                }
            }
            State::Start | State::Done => {
                return Err(Error::new("a closing brace without its opening one")
                    .help("a tensor tree is one group in braces; there is one brace too many here or a missing one before"));
            }
        }
        self.state = if self.branches.is_empty() { State::Done } else { State::InBranch };
        Ok(())
    }

    fn end_word(&mut self) -> Result<()> {
        if self.word.is_empty() {
            return Ok(());
        }
        let value: f32 = self.word.parse().map_err(|_| not_a_number(&self.word))?;
        if !value.is_finite() {
            return Err(
                Error::new(format!("a value of the tensor tree is '{}'", self.word)).help("a scattering value must be a finite number")
            );
        }
        self.word.clear();
        match self.state {
            State::Opened(slot) => self.state = State::InLeaf(slot, self.tree.values.len() as u32),
            State::InLeaf(..) => {}
            _ => {
                return Err(Error::new("a number outside the innermost braces of the tensor tree")
                    .help("a group holds either numbers or groups: a brace is missing or too many"));
            }
        }
        if self.tree.values.len() >= VALUE_LIMIT {
            return Err(Error::new(format!("the tensor tree has more than {VALUE_LIMIT} values")));
        }
        self.tree.values.push(value);
        Ok(())
    }
}

fn not_a_number(word: &str) -> Error {
    Error::new(format!("'{}' is not a number", word.escape_debug())).help("a tensor tree consists of braces and numbers")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = .1 + .1 ix + .01 iy + .001 ox + .0001 oy on 8⁴ cells, one level of branches.
    pub(crate) fn text_of_rank4() -> String {
        let f = |i: [usize; 4]| 0.1 + 0.1 * i[0] as f64 + 0.01 * i[1] as f64 + 0.001 * i[2] as f64 + 0.0001 * i[3] as f64;
        let mut text = String::from("{\n");
        for child in 0..16usize {
            text.push('{');
            for index in 0..256usize {
                let digit = |d: usize| (child >> d & 1) * 4 + index / 4usize.pow(3 - d as u32) % 4;
                text.push_str(&format!(" {:.4}", f([digit(0), digit(1), digit(2), digit(3)])));
            }
            text.push_str(" }\n");
        }
        text + "}\n"
    }

    fn direction(x: f64, y: f64) -> DVec3 {
        DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
    }

    #[test]
    fn rank_4_has_the_values_that_radiance_finds() {
        // rtrace of such a tree, see bsdf_t.c; incident along the second argument.
        let tree = TensorTree::parse(&text_of_rank4(), 4).unwrap();
        assert_eq!(tree.resolution(), 8);
        for (out, incident, wanted) in [
            ((0.0, 0.0), (0.0, 0.0), 0.5444),
            ((0.6, 0.0), (0.0, 0.0), 0.5464),
            ((0.0, 0.6), (0.0, 0.0), 0.5446),
            ((0.0, 0.0), (-0.3, 0.0), 0.3444),
            ((0.6, 0.0), (-0.3, 0.0), 0.3464),
            ((0.0, 0.6), (0.309, -0.206), 0.6246),
        ] {
            let value = tree.evaluate(direction(out.0, out.1), direction(incident.0, incident.1));
            assert!((value - wanted).abs() < 1e-6, "{out:?} {incident:?}: {value} {wanted}");
        }
    }

    #[test]
    fn rank_3_turns_with_the_incident_azimuth() {
        // Values .1 i + .01 ox + .001 oy on 2 × 4² … a 4³ grid whose upper half is never used.
        let mut text = String::from("{");
        for i in 0..64 {
            text.push_str(&format!(" {}", 0.1 * (i / 16) as f64 + 0.01 * (i / 4 % 4) as f64 + 0.001 * (i % 4) as f64));
        }
        let tree = TensorTree::parse(&(text + "}"), 3).unwrap();
        // Normal incidence lies in slice 1, grazing in slice 0; straight through lies on +x.
        assert!((tree.evaluate(direction(0.7, 0.01), direction(1e-9, 0.0)) - 0.132).abs() < 1e-6);
        for azimuth in [0.3f64, 1.0, 2.5, -2.0] {
            let incident = direction(0.9 * azimuth.cos(), 0.9 * azimuth.sin());
            let out = direction(0.9 * (azimuth + 0.1).cos(), 0.9 * (azimuth + 0.1).sin());
            assert!((tree.evaluate(out, incident) - 0.032).abs() < 1e-6);
        }
    }

    #[test]
    fn integrals_of_a_constant_are_pi_times_it_at_both_ranks() {
        for rank in [3, 4] {
            let leaf = "{ 0.1 }".to_string();
            let level1 = format!("{{ {} }}", vec![leaf; 1 << rank].join(" "));
            let mixed = format!("{{ {} {} }}", level1, vec!["{ 0.1 }"; (1 << rank) - 1].join(", "));
            let tree = TensorTree::parse(&mixed, rank).unwrap();
            assert_eq!(tree.resolution(), 4);
            assert!((tree.hemispherical() - 0.1 * PI).abs() < 1e-6, "{}", tree.hemispherical());
            for x in [0.0, 0.3, -0.9] {
                assert!((tree.direct_hemispherical(direction(x, -x / 3.0)) - 0.1 * PI).abs() < 1e-6);
            }
            assert!((TensorTree::constant(rank, 0.1).hemispherical() - tree.hemispherical()).abs() < 1e-12);
        }
    }

    #[test]
    fn direct_hemispherical_is_the_sum_over_outgoing_cells() {
        let tree = TensorTree::parse(&text_of_rank4(), 4).unwrap();
        let incident = direction(-0.3, 0.5);
        let n = 64;
        let mut sum = 0.0;
        for i in 0..n * n {
            let (u, v) = ((i / n) as f64 + 0.5, (i % n) as f64 + 0.5);
            let [x, y] = crate::bins::shirley_chiu::disk_from_square(u / n as f64, v / n as f64);
            sum += tree.evaluate(direction(x, y), incident) * PI / (n * n) as f64;
        }
        assert!((tree.direct_hemispherical(incident) - sum).abs() < 1e-6);
    }

    #[test]
    fn broken_trees_are_refused_and_never_panic() {
        let bad = [
            "",
            "{",
            "}",
            "{}",
            "{ 1 2 }",
            "{ 1 } 2",
            "{ 1 } { 1 }",
            "1",
            "{ x }",
            "{ nan }",
            "{ { 1 } }",
            "{ 1 { 1 } }",
            "{ { 1 } 1 }",
            "{1e99}",
        ];
        for text in bad {
            for rank in [3, 4] {
                assert!(TensorTree::parse(text, rank).is_err(), "{text:?}");
            }
        }
        assert!(TensorTree::parse(&"{".repeat(1_000_000), 4).unwrap_err().to_string().contains("nested deeper"));
        let good = text_of_rank4();
        for cut in (0..good.len()).step_by(97) {
            assert!(TensorTree::parse(&good[..cut], 4).is_err());
        }
        assert!(TensorTree::parse(&good, 3).is_err());
    }
}

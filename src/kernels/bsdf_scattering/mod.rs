//! Scattering functions of panes on the device: `bsdf/scattering` evaluates them,
//! `bsdf/scattering_sample` draws directions. The f64 reference is [`crate::bsdf::evaluate`] with
//! [`crate::bsdf::sample`].
//!
//! All data are words of one buffer, `bsdf_words`. A pane begins with four lobes of 16 words each, in
//! the order of [`Component::ALL`]; tables follow, and are addressed by their first word.
//!
//! | word | Klems matrix | tensor tree |
//! |---|---|---|
//! | `LOBE_KIND` (0) | `KIND_KLEMS` | `KIND_TREE4` … |
//! | 1 | Lambertian part, 1/sr (f32) | the same |
//! | 2 | values `[out][in]` (f32) | values (f32) |
//! | 3 | – | nodes, two words each ([`crate::bsdf::TensorTree::packed`]) |
//! | 4, 5 | rings of incident and outgoing basis, four words each | – |
//! | 6, 7; 8, 9 | numbers of rings; numbers of bins | – |
//! | 10 | cumulative flux `[in][out]` (f32) | per incident cell: first word, number and flux of its outgoing cells, which are (cumulative flux, packed place) |
//! | 11 | – | incident cells per side |

#[cfg(test)]
mod extremes;
#[cfg(test)]
mod tests;

use crate::bins::AngleBasis;
use crate::bsdf::evaluate::{Lobe, Residue, Scattering};
use crate::bsdf::{Block, Component, KlemsMatrix, TensorTree, projected_solid_angles};
use crate::error::{Error, Result};
use crate::gpu::Shader;
use crate::gpu_struct;
use crate::kernels::trace;
use std::f64::consts::PI;

crate::gpu_constants! {
    pub(crate) const NUMBERS = {
        const TRANSMISSION_FRONT: u32 = Component::TransmissionFront as u32;
        const TRANSMISSION_BACK: u32 = Component::TransmissionBack as u32;
        const REFLECTION_FRONT: u32 = Component::ReflectionFront as u32;
        const REFLECTION_BACK: u32 = Component::ReflectionBack as u32;
        /// Words of a lobe, and which is which.
        const LOBE_WORDS: u32 = 16;
        const LOBE_KIND: u32 = 0;
        const LOBE_LAMBERTIAN: u32 = 1;
        const LOBE_VALUES: u32 = 2;
        const LOBE_NODES: u32 = 3;
        const LOBE_RINGS_IN: u32 = 4;
        const LOBE_RINGS_OUT: u32 = 5;
        const LOBE_RING_COUNT_IN: u32 = 6;
        const LOBE_RING_COUNT_OUT: u32 = 7;
        const LOBE_BINS_IN: u32 = 8;
        const LOBE_BINS_OUT: u32 = 9;
        const LOBE_SAMPLING: u32 = 10;
        const LOBE_SAMPLING_SIDE: u32 = 11;
        /// Kinds of lobes.
        const KIND_BLACK: u32 = 0;
        const KIND_KLEMS: u32 = 1;
        const KIND_TREE4: u32 = 2;
        const KIND_TREE3: u32 = 3;
        /// The opposite transmission's tree, by reciprocity.
        const KIND_TREE3_REVERSED: u32 = 4;
        /// Words of a ring.
        const RING_WORDS: u32 = 4;
        const PACKED_BRANCH: u32 = crate::bsdf::PACKED_BRANCH;
    }
}

/// The words of a lobe.
#[derive(Default)]
struct LobeWords([u32; LOBE_WORDS as usize]);

impl LobeWords {
    fn set(&mut self, word: u32, value: u32) {
        self.0[word as usize] = value;
    }
}

/// Largest table for drawing directions, words: what every device binds (128 MiB).
const MOST_WORDS: usize = 1 << 25;

gpu_struct! {
    /// One question of `diagnostic/probe_bsdf`.
    pub(crate) struct BsdfProbe {
        outgoing: [f32; 3],
        /// First word of the pane.
        pane: u32,
        incident: [f32; 3],
        padding0: u32,
        random: [f32; 3],
        padding1: u32,
    }
}

gpu_struct! {
    /// Its answer.
    pub(crate) struct BsdfAnswer {
        /// Drawn in the component of the two directions.
        direction: [f32; 3],
        weight: f32,
        value: f32,
        direct_hemispherical: f32,
        padding0: u32,
        padding1: u32,
    }
}

/// Shaders of this module, for the tests.
pub fn registered() -> Vec<Shader> {
    vec![PROBE]
}

const PROBE: Shader = trace::shader("diagnostic/probe_bsdf", &[NUMBERS, &[BsdfProbe::DECLARED, BsdfAnswer::DECLARED]]);

/// Words for the device, of one or several panes.
#[derive(Debug, Clone, Default)]
pub struct PackedBsdfs {
    words: Vec<u32>,
}

/// Whether the tables for drawing directions are built; they are large for trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tables {
    /// Only what evaluation needs.
    Evaluate,
    /// Also what `bsdf/scattering_sample` needs.
    Sample,
}

impl PackedBsdfs {
    /// No pane yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The words to upload as `bsdf_words`; at least one.
    pub fn words(&self) -> &[u32] {
        if self.words.is_empty() { &[0] } else { &self.words }
    }

    /// Adds a pane and gives its first word.
    ///
    /// # Errors
    /// If its tables are too large for a device.
    pub fn push(&mut self, scattering: &Scattering, tables: Tables) -> Result<u32> {
        let pane = self.words.len();
        const WORDS: usize = LOBE_WORDS as usize;
        self.words.resize(pane + 4 * WORDS, 0);
        for component in Component::ALL {
            if let Some(lobe) = scattering.lobe(component) {
                let words = self.lobe(lobe, tables)?;
                self.words[pane + component as usize * WORDS..][..WORDS].copy_from_slice(&words.0);
            }
        }
        Ok(pane as u32)
    }

    fn lobe(&mut self, lobe: &Lobe, tables: Tables) -> Result<LobeWords> {
        let mut words = LobeWords::default();
        words.set(LOBE_LAMBERTIAN, ((lobe.lambertian / PI) as f32).to_bits());
        match &lobe.residue {
            Residue::Block(Block::Klems(m)) => {
                words.set(LOBE_KIND, KIND_KLEMS);
                words.set(LOBE_VALUES, self.numbers(m.values().iter().copied()));
                words.set(LOBE_RINGS_IN, self.rings(m.incident()));
                words.set(LOBE_RING_COUNT_IN, m.incident().rings().len() as u32);
                words.set(LOBE_RINGS_OUT, self.rings(m.outgoing()));
                words.set(LOBE_RING_COUNT_OUT, m.outgoing().rings().len() as u32);
                words.set(LOBE_BINS_IN, m.incident().len() as u32);
                words.set(LOBE_BINS_OUT, m.outgoing().len() as u32);
                if tables == Tables::Sample {
                    words.set(LOBE_SAMPLING, self.cumulative(m));
                }
            }
            Residue::Block(Block::Tree(t)) => {
                words.set(LOBE_KIND, if t.rank() == 4 { KIND_TREE4 } else { KIND_TREE3 });
                self.tree(t, &mut words);
                if tables == Tables::Sample {
                    words.set(LOBE_SAMPLING, self.outgoing_cells(t)?);
                    words.set(LOBE_SAMPLING_SIDE, t.resolution() as u32);
                }
            }
            Residue::ReversedIsotropic(t) => {
                words.set(LOBE_KIND, KIND_TREE3_REVERSED);
                self.tree(t, &mut words);
            }
        }
        if self.words.len() > MOST_WORDS {
            return Err(Error::new(format!("the BSDF needs {} MiB on the device", self.words.len() >> 18))
                .help("convert it to a coarser tree or a Klems matrix with `lucarne bsdf convert`"));
        }
        Ok(words)
    }

    fn numbers(&mut self, numbers: impl Iterator<Item = f64>) -> u32 {
        let first = self.words.len() as u32;
        self.words.extend(numbers.map(|v| (v as f32).to_bits()));
        first
    }

    fn rings(&mut self, basis: &AngleBasis) -> u32 {
        let first = self.words.len() as u32;
        for ring in basis.rings() {
            let cos2 = |degrees: f64| if degrees >= 90.0 { 0.0f32 } else { degrees.to_radians().cos().powi(2) as f32 };
            self.words.extend([cos2(ring.theta_min).to_bits(), cos2(ring.theta_max).to_bits(), ring.first as u32, ring.bins as u32]);
        }
        first
    }

    fn cumulative(&mut self, m: &KlemsMatrix) -> u32 {
        let lambda = projected_solid_angles(m.outgoing());
        let first = self.words.len() as u32;
        for i in 0..m.incident().len() {
            let mut sum = 0.0;
            for (o, l) in lambda.iter().enumerate() {
                sum += m.at(o, i) * l;
                self.words.push((sum as f32).to_bits());
            }
        }
        first
    }

    fn tree(&mut self, tree: &TensorTree, words: &mut LobeWords) {
        let (nodes, values) = tree.packed();
        words.set(LOBE_NODES, self.words.len() as u32);
        self.words.extend(nodes.into_iter().flatten());
        words.set(LOBE_VALUES, self.numbers(values.iter().map(|v| f64::from(*v))));
    }

    /// Outgoing cells of every incident cell, with their cumulative flux.
    fn outgoing_cells(&mut self, tree: &TensorTree) -> Result<u32> {
        let side = tree.resolution();
        let incident_cells = if tree.rank() == 4 { side * side } else { side };
        let first = self.words.len();
        self.words.resize(first + 3 * incident_cells, 0);
        for cell in 0..incident_cells {
            let at = |k: usize| (k as f64 + 0.5) / side as f64;
            let point = if tree.rank() == 4 { [at(cell / side), at(cell % side), 0.0, 0.0] } else { [at(cell), 0.0, 0.0, 0.0] };
            let list = self.words.len();
            let mut sum = 0.0;
            tree.for_each_outgoing_cell(point, |c| {
                if c.value > 0.0 {
                    sum += c.value * PI * c.side * c.side;
                    let log2 = (1.0 / c.side).log2().round() as u32;
                    let place = |x: f64| (x / c.side).round() as u32;
                    let packed = log2 | place(c.corner[tree.rank() - 2]) << 5 | place(c.corner[tree.rank() - 1]) << 18;
                    self.words.extend([(sum as f32).to_bits(), packed]);
                }
            });
            if self.words.len() > MOST_WORDS {
                return Err(Error::new("the tables for drawing directions from this tensor tree are too large for a device")
                    .help("convert it to a coarser tree with `lucarne bsdf convert`"));
            }
            let count = ((self.words.len() - list) / 2) as u32;
            self.words[first + 3 * cell..][..3].copy_from_slice(&[list as u32, count, (sum as f32).to_bits()]);
        }
        Ok(first as u32)
    }
}

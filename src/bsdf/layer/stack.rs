//! Layers at one wavelength, put together.

use super::operator::Operator;
use crate::bins::AngleBasis;
use crate::bsdf::glass::{Normal, Pane};
use crate::bsdf::resample::to_klems;
use crate::bsdf::{Blocks, Component, KlemsMatrix, projected_solid_angles};
use crate::error::{Error, Result};

/// What a layer or stack does with radiance: f Λ of the four components.
#[derive(Debug, Clone)]
pub(super) struct Operators {
    pub tf: Operator,
    pub tb: Operator,
    pub rf: Operator,
    pub rb: Operator,
}

/// The four components of a layer over a basis: values in 1/sr, in the order of [`Component::ALL`].
pub(super) struct Matrices([KlemsMatrix; 4]);

impl Matrices {
    pub(super) fn new(blocks: &Blocks, basis: &AngleBasis) -> Result<Self> {
        let get = |component: Component| -> Result<KlemsMatrix> {
            if let Some(block) = blocks.get(component) {
                return Ok(to_klems(block, basis, basis));
            }
            match blocks.get(component.reciprocal()) {
                Some(block) if component.is_transmission() => Ok(to_klems(block, basis, basis).reversed()),
                _ => Err(Error::new(format!("{} is missing", component.xml_name()))
                    .help("layering needs reflection from both sides; use a file with all four blocks")),
            }
        };
        let [tf, tb, rf, rb] = Component::ALL;
        Ok(Self([get(tf)?, get(tb)?, get(rf)?, get(rb)?]))
    }

    /// Entry by entry from two bands, e.g. of what is not visible.
    pub(super) fn combined(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|k| {
            let mut m = self.0[k].clone();
            m.values_mut().iter_mut().zip(other.0[k].values()).for_each(|(a, b)| *a = f(*a, *b));
            m
        }))
    }

    pub(super) fn operators(&self) -> Operators {
        let lambda = projected_solid_angles(self.0[0].incident());
        let n = lambda.len();
        let [tf, tb, rf, rb] = self
            .0
            .each_ref()
            .map(|m| Operator::Full { n, data: m.values().iter().enumerate().map(|(k, f)| f.max(0.0) * lambda[k % n]).collect() });
        Operators { tf, tb, rf, rb }
    }
}

impl Operators {
    /// A pane: all light on the diagonal, evaluated at the middle angle of each ring (the normal for
    /// the cap), as WINDOW does.
    pub(super) fn of_pane(pane: &Pane, normal: &Normal, basis: &AngleBasis) -> Self {
        let mut columns: [Vec<f64>; 4] = Default::default();
        for ring in basis.rings() {
            let theta = if ring.first == 0 && ring.bins == 1 { 0.0 } else { (ring.theta_min + ring.theta_max) / 2.0 };
            for (column, value) in columns.iter_mut().zip(pane.at(normal, theta)) {
                column.extend(std::iter::repeat_n(value, ring.bins));
            }
        }
        let [tf, tb, rf, rb] = columns.map(Operator::Diagonal);
        Self { tf, tb, rf, rb }
    }

    /// Empty space.
    fn nothing(n: usize) -> Self {
        let (one, zero) = (Operator::uniform(n, 1.0), Operator::uniform(n, 0.0));
        Self { tf: one.clone(), tb: one, rf: zero.clone(), rb: zero }
    }

    /// Share of the light of each incident bin, from the front and from the back, that is absorbed.
    fn absorptance(&self, lambda: &[f64]) -> [Vec<f64>; 2] {
        [(&self.tf, &self.rf), (&self.tb, &self.rb)].map(|(t, r)| {
            let (through, back) = (t.weighted_rows(lambda), r.weighted_rows(lambda));
            (0..lambda.len()).map(|b| 1.0 - (through[b] + back[b]) / lambda[b]).collect()
        })
    }
}

/// Radiance in the gap between two stacks per radiance from outside (front) or from the room (back).
struct Gap {
    inward_from_front: Operator,
    outward_from_front: Operator,
    inward_from_back: Operator,
    outward_from_back: Operator,
}

impl Gap {
    fn between(outer: &Operators, inner: &Operators) -> Result<Self> {
        let inward_from_front = outer.rb.times(&inner.rf).resolve(&outer.tf)?;
        let outward_from_back = inner.rf.times(&outer.rb).resolve(&inner.tb)?;
        Ok(Self {
            outward_from_front: inner.rf.times(&inward_from_front),
            inward_from_back: outer.rb.times(&outward_from_back),
            inward_from_front,
            outward_from_back,
        })
    }

    /// The two stacks as one.
    fn joined(&self, outer: &Operators, inner: &Operators) -> Operators {
        Operators {
            tf: inner.tf.times(&self.inward_from_front),
            rf: outer.rf.clone().plus(&outer.tb.times(&self.outward_from_front)),
            tb: outer.tb.times(&self.outward_from_back),
            rb: inner.rb.clone().plus(&inner.tf.times(&self.inward_from_back)),
        }
    }
}

/// The system of these layers, outermost first, and for each layer what it absorbs of the light of
/// each incident bin, from the front and from the back.
pub(super) fn stack(layers: &[&Operators], basis: &AngleBasis) -> Result<(Operators, Vec<[Vec<f64>; 2]>)> {
    let lambda = projected_solid_angles(basis);
    let n = lambda.len();
    let count = layers.len();
    // inner[k]: layers from k on; outer: layers before the gap in front of layer k.
    let mut inner = vec![Operators::nothing(n); count + 1];
    for k in (1..count).rev() {
        inner[k] = Gap::between(layers[k], &inner[k + 1])?.joined(layers[k], &inner[k + 1]);
    }
    let mut outer = Operators::nothing(n);
    let mut gaps: Vec<Gap> = Vec::with_capacity(count + 1);
    let mut whole = None;
    for k in 1..count {
        // The gap before layer k; the stack before it grows by layer k − 1.
        outer = if k == 1 { layers[0].clone() } else { Gap::between(&outer, layers[k - 1])?.joined(&outer, layers[k - 1]) };
        let gap = Gap::between(&outer, &inner[k])?;
        if k == 1 {
            whole = Some(gap.joined(&outer, &inner[k]));
        }
        gaps.push(gap);
    }
    let whole = whole.unwrap_or_else(|| layers[0].clone());
    // Outside and room: light comes in undisturbed, the rest is the system's own.
    let (one, zero) = (Operator::uniform(n, 1.0), Operator::uniform(n, 0.0));
    let outside = Gap {
        inward_from_front: one.clone(),
        outward_from_front: whole.rf.clone(),
        inward_from_back: zero.clone(),
        outward_from_back: whole.tb.clone(),
    };
    let room =
        Gap { inward_from_front: whole.tf.clone(), outward_from_front: zero, inward_from_back: whole.rb.clone(), outward_from_back: one };
    gaps.insert(0, outside);
    gaps.push(room);
    let absorbed = layers
        .iter()
        .zip(gaps.windows(2))
        .map(|(layer, gaps)| {
            let shares = layer.absorptance(&lambda);
            let [front, back] = shares.map(|s| s.iter().zip(&lambda).map(|(s, l)| s * l).collect::<Vec<_>>());
            let sum = |inward: &Operator, outward: &Operator| -> Vec<f64> {
                let (a, b) = (inward.weighted_rows(&front), outward.weighted_rows(&back));
                a.iter().zip(&b).zip(&lambda).map(|((a, b), l)| (a + b) / l).collect()
            };
            [sum(&gaps[0].inward_from_front, &gaps[1].outward_from_front), sum(&gaps[0].inward_from_back, &gaps[1].outward_from_back)]
        })
        .collect();
    Ok((whole, absorbed))
}

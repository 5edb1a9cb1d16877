//! What the examination measures on blocks.

use crate::bins::{AngleBasis, KlemsBasis};
use crate::bsdf::resample::to_klems;
use crate::bsdf::{Block, Blocks, Component, KlemsMatrix, projected_solid_angles};

/// Mean absolute difference between a matrix and its reverse, relative to their mean. Traced
/// files of ordinary quality reach 3 %, text files of few digits 0.1 %.
const RECIPROCITY: f64 = 0.06;
/// A component below this hemispherical value is too dark to be judged by relative differences.
pub(super) const DARK: f64 = 2e-3;

pub(super) const SIDES: [(&str, Component, Component); 2] =
    [("Front", Component::TransmissionFront, Component::ReflectionFront), ("Back", Component::TransmissionBack, Component::ReflectionBack)];

pub(super) fn other_side(reflection: Component) -> Component {
    if reflection == Component::ReflectionFront { Component::ReflectionBack } else { Component::ReflectionFront }
}

/// Why a block is a placeholder, if it is one.
pub(super) fn dummy(blocks: &Blocks, component: Component) -> Option<&'static str> {
    let own = blocks.get(component)?;
    let partner = if component.is_transmission() { component.reciprocal() } else { other_side(component) };
    let other = blocks.get(partner)?;
    let (h, other_h) = (own.hemispherical(), other.hemispherical());
    if h == 0.0 && other_h > 0.01 {
        let passes = blocks.transmission_front.as_ref().is_some_and(|t| t.hemispherical() > 0.0);
        // A black side of an opaque layer is possible; a transmission from one side only is not.
        if component.is_transmission() || passes {
            return Some("all values are 0 while the other side's are not: a placeholder");
        }
    }
    if component == Component::TransmissionBack && own == other && !leaves_lambertian(own) {
        let matrix = coarse(own);
        if relative_distance(&matrix, &matrix.reversed()) > tolerance(own) {
            return Some("a copy of Transmission Front; reciprocity demands the reverse");
        }
    }
    None
}

/// Number of negative values, the least value, and the largest negative share of the light of one
/// incident direction.
pub(super) fn negatives(block: &Block) -> (usize, f64, f64) {
    let (mut count, mut least, mut flux) = (0, 0.0f64, 0.0f64);
    match block {
        Block::Klems(m) => {
            let lambda = projected_solid_angles(m.outgoing());
            let n = m.incident().len();
            let mut sums = vec![0.0; n];
            for (k, f) in m.values().iter().enumerate().filter(|(_, f)| **f < 0.0) {
                count += 1;
                least = least.min(*f);
                sums[k % n] -= f * lambda[k / n];
            }
            flux = sums.into_iter().fold(flux, f64::max);
        }
        Block::Tree(t) => t.for_each_cell(|c| {
            if c.value < 0.0 {
                count += 1;
                least = least.min(c.value);
                flux = flux.max(-c.value * c.side * c.side * std::f64::consts::PI);
            }
        }),
    }
    (count, least, flux)
}

/// Largest transmittance + reflectance over the incident bins, and that bin.
pub(super) fn largest_sum(t: Option<&Block>, r: Option<&Block>) -> (f64, usize) {
    let full = AngleBasis::from(KlemsBasis::Full);
    let basis = t.or(r).and_then(Block::as_klems).map_or(full, |m| m.incident().clone());
    let sums = |block: &Block| match block {
        Block::Klems(m) if *m.incident() == basis => m.all_direct_hemispherical(),
        other => (0..basis.len()).map(|i| other.direct_hemispherical(basis.centre(i))).collect(),
    };
    let mut total = vec![0.0; basis.len()];
    for block in [t, r].into_iter().flatten() {
        total.iter_mut().zip(sums(block)).for_each(|(sum, v)| *sum += v);
    }
    total.into_iter().enumerate().fold((0.0, 0), |worst, (bin, v)| if v > worst.0 { (v, bin) } else { worst })
}

/// Where the sharp peaks of a block lie.
pub(super) struct Peaks {
    pub peaked: usize,
    pub diagonal: usize,
    pub opposite: usize,
}

/// Counts the incident bins whose largest value stands out, and where it lies; `None` if few have
/// one, or the block is no square matrix.
pub(super) fn through_peak(block: &Block) -> Option<Peaks> {
    let half = AngleBasis::from(KlemsBasis::Half);
    let resampled;
    let m = match block {
        Block::Klems(m) if m.incident() == m.outgoing() => m,
        other => {
            resampled = to_klems(other, &half, &half);
            &resampled
        }
    };
    let basis = m.incident();
    let lambda = projected_solid_angles(basis);
    let sums = m.all_direct_hemispherical();
    let mut peaks = Peaks { peaked: 0, diagonal: 0, opposite: 0 };
    let mut judged = 0;
    for i in (0..basis.len()).filter(|i| basis.opposite(*i) != *i && sums[*i] > DARK) {
        judged += 1;
        let (o, f) = (0..basis.len()).map(|o| (o, m.at(o, i))).max_by(|a, b| a.1.total_cmp(&b.1)).expect("a basis has bins");
        // A tenth of the light in one bin of a hundred, and well above the mean.
        if f * lambda[o] > 0.1 * sums[i] && f > 5.0 * sums[i] / std::f64::consts::PI {
            peaks.peaked += 1;
            peaks.diagonal += usize::from(o == i);
            peaks.opposite += usize::from(o == basis.opposite(i));
        }
    }
    (peaks.peaked > 0 && 4 * peaks.peaked > judged).then_some(peaks)
}

/// How far a block may be from reciprocity. Trees of rank 3 divide incident and outgoing angles
/// differently: a sharp peak is cut differently before and after reversing (7 % at 2^4 cells).
pub(super) fn tolerance(block: &Block) -> f64 {
    if matches!(block, Block::Tree(t) if t.rank() == 3) { 2.0 * RECIPROCITY } else { RECIPROCITY }
}

/// Whether, apart from the diagonal, light of every incident bin leaves evenly, and how much of it
/// depends on the incidence. (A scatterer that is Lambertian throughout is reciprocal.)
pub(super) fn leaves_lambertian(block: &Block) -> bool {
    let Block::Klems(m) = block else { return false };
    let sums = m.all_direct_hemispherical();
    let (low, high) = (sums.iter().copied().fold(f64::MAX, f64::min), sums.iter().copied().fold(0.0, f64::max));
    if high - low <= 0.01 * high {
        return false;
    }
    let even = |i: usize| {
        let values = || (0..m.outgoing().len()).filter(|o| *o != i).map(|o| m.at(o, i));
        let (low, high) = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
        high - low <= 0.01 * high.abs()
    };
    let count = (0..m.incident().len()).filter(|i| even(*i)).count();
    count * 20 >= m.incident().len() * 19
}

/// Means over the Klems quarter basis: less noise.
pub(super) fn coarse(block: &Block) -> KlemsMatrix {
    let quarter = AngleBasis::from(KlemsBasis::Quarter);
    to_klems(block, &quarter, &quarter)
}

/// Σ |a − b| ΛΛ / Σ (|a| + |b|)/2 ΛΛ.
pub(super) fn relative_distance(a: &KlemsMatrix, b: &KlemsMatrix) -> f64 {
    let lambda = projected_solid_angles(a.incident());
    let n = lambda.len();
    let (mut difference, mut mean) = (0.0, 0.0);
    for (k, (x, y)) in a.values().iter().zip(b.values()).enumerate() {
        let weight = lambda[k / n] * lambda[k % n];
        difference += (x - y).abs() * weight;
        mean += (x.abs() + y.abs()) / 2.0 * weight;
    }
    if mean > 0.0 { difference / mean } else { 0.0 }
}

pub(super) fn transposed(m: &KlemsMatrix) -> KlemsMatrix {
    KlemsMatrix::from_fn(m.incident(), |o, i| m.at(i, o))
}

/// Outgoing directions turned by 180°.
pub(super) fn turned(m: &KlemsMatrix) -> KlemsMatrix {
    let basis = m.outgoing().clone();
    let n = m.incident().len();
    let values = (0..basis.len() * n).map(|k| m.at(basis.opposite(k / n), k % n)).collect();
    KlemsMatrix::new(m.incident().clone(), basis, values).expect("the same size")
}

/// Incident and outgoing directions mirrored in x.
pub(super) fn mirrored(m: &KlemsMatrix) -> KlemsMatrix {
    let basis = m.incident();
    let mirror = |bin: usize| {
        let c = basis.centre(bin);
        basis.bin_of(glam::DVec3::new(-c.x, c.y, c.z))
    };
    KlemsMatrix::from_fn(basis, |o, i| m.at(mirror(o), mirror(i)))
}

//! How two BSDF files differ.

use super::resample::to_klems;
use super::{Block, Bsdf, Component, KlemsMatrix, projected_solid_angles};
use crate::bins::{AngleBasis, KlemsBasis};
use std::f64::consts::PI;

/// Comparison of one component of one band.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Band, as in the file.
    pub band: &'static str,
    /// Component.
    pub component: Component,
    /// What was compared.
    pub result: Comparison,
}

/// The numbers of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub enum Comparison {
    /// Only the first file has the component.
    OnlyFirst,
    /// Only the second file has it.
    OnlySecond,
    /// Both have it.
    Both {
        /// Hemispherical values of the two.
        hemispherical: [f64; 2],
        /// Largest difference of direct-hemispherical values, and the incident bin it occurs at.
        direct_hemispherical: (f64, usize),
        /// Largest difference of two values, 1/sr, and its (outgoing, incident) bins.
        largest: (f64, usize, usize),
        /// Root mean square difference, weighted by projected solid angle, 1/sr.
        rms: f64,
        /// Whether one had to be brought to the other's basis.
        resampled: bool,
        /// Basis of the incident bins.
        incident: AngleBasis,
        /// Basis of the outgoing bins.
        outgoing: AngleBasis,
    },
}

impl Comparison {
    /// Whether the two agree: no value differs by more than `tolerance` times the largest value of
    /// either, and no hemispherical value by more than `tolerance`.
    pub fn agrees(&self, tolerance: f64) -> bool {
        match self {
            Comparison::Both { hemispherical: [a, b], direct_hemispherical, largest, .. } => {
                (a - b).abs() <= tolerance && direct_hemispherical.0 <= tolerance && largest.0 <= tolerance * largest_scale(largest.0)
            }
            _ => false,
        }
    }
}

/// Values in 1/sr of sharp peaks are large; their differences are judged on the scale of a
/// Lambertian value at least.
fn largest_scale(difference: f64) -> f64 {
    difference.max(1.0)
}

/// Compares all components of all bands. The second file is brought to the basis of the first
/// where they differ; tensor trees are compared over the Klems full basis.
pub fn compare(first: &Bsdf, second: &Bsdf) -> Vec<Difference> {
    let mut differences = Vec::new();
    for ((band, a), (_, b)) in first.bands().into_iter().zip(second.bands()) {
        for component in Component::ALL {
            let result = match (a.get(component), b.get(component)) {
                (None, None) => continue,
                (Some(_), None) => Comparison::OnlyFirst,
                (None, Some(_)) => Comparison::OnlySecond,
                (Some(a), Some(b)) => compare_blocks(a, b),
            };
            differences.push(Difference { band, component, result });
        }
    }
    differences
}

fn compare_blocks(a: &Block, b: &Block) -> Comparison {
    let full = AngleBasis::from(KlemsBasis::Full);
    let (incident, outgoing) = match a {
        Block::Klems(m) => (m.incident().clone(), m.outgoing().clone()),
        Block::Tree(_) => (full.clone(), full),
    };
    let fits = |block: &Block| block.as_klems().is_some_and(|m| *m.incident() == incident && *m.outgoing() == outgoing);
    let resampled = !(fits(a) && fits(b));
    let (x, y) = (to_klems(a, &incident, &outgoing), to_klems(b, &incident, &outgoing));
    let n = incident.len();
    let (lambda_in, lambda_out) = (projected_solid_angles(&incident), projected_solid_angles(&outgoing));
    let mut largest = (0.0, 0, 0);
    let mut square = 0.0;
    for (k, (p, q)) in x.values().iter().zip(y.values()).enumerate() {
        let difference = (p - q).abs();
        square += difference * difference * lambda_out[k / n] * lambda_in[k % n];
        if difference > largest.0 {
            largest = (difference, k / n, k % n);
        }
    }
    let sums = |m: &KlemsMatrix| m.all_direct_hemispherical();
    let mut direct = (0.0, 0);
    for (i, (p, q)) in sums(&x).into_iter().zip(sums(&y)).enumerate() {
        if (p - q).abs() > direct.0 {
            direct = ((p - q).abs(), i);
        }
    }
    Comparison::Both {
        hemispherical: [a.hemispherical(), b.hemispherical()],
        direct_hemispherical: direct,
        largest,
        rms: square.sqrt() / PI,
        resampled,
        incident,
        outgoing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bsdf(f: impl FnMut(usize, usize) -> f64, basis: KlemsBasis) -> Bsdf {
        let mut bsdf = Bsdf::default();
        bsdf.visible.transmission_front = Some(Block::Klems(KlemsMatrix::from_fn(&AngleBasis::from(basis), f)));
        bsdf
    }

    #[test]
    fn a_changed_value_is_found_and_equal_files_agree() {
        let a = bsdf(|o, i| (o + i) as f64 * 1e-3, KlemsBasis::Quarter);
        let b = bsdf(|o, i| (o + i) as f64 * 1e-3 + if (o, i) == (3, 7) { 0.5 } else { 0.0 }, KlemsBasis::Quarter);
        assert!(compare(&a, &a).iter().all(|d| d.result.agrees(0.0)));
        let found = compare(&a, &b);
        let Comparison::Both { largest, direct_hemispherical, rms, resampled, .. } = &found[0].result else { panic!() };
        assert!((largest.0 - 0.5).abs() < 1e-12 && (largest.1, largest.2) == (3, 7) && direct_hemispherical.1 == 7 && !resampled);
        let basis = AngleBasis::from(KlemsBasis::Quarter);
        let wanted = 0.5 * (basis.projected_solid_angle(3) * basis.projected_solid_angle(7)).sqrt() / PI;
        assert!((rms - wanted).abs() < 1e-12);
        assert!(!found[0].result.agrees(1e-3) && found[0].result.agrees(0.6));
    }

    #[test]
    fn other_bases_are_brought_together_and_missing_blocks_reported() {
        let (a, mut b) = (bsdf(|_, _| 0.25, KlemsBasis::Quarter), bsdf(|_, _| 0.25, KlemsBasis::Full));
        let found = compare(&a, &b);
        assert!(found[0].result.agrees(1e-9), "{found:?}");
        b.solar = std::mem::take(&mut b.visible);
        let found: Vec<Comparison> = compare(&a, &b).into_iter().map(|d| d.result).collect();
        assert_eq!(found, [Comparison::OnlyFirst, Comparison::OnlySecond]);
    }
}

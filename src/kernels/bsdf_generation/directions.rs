//! Cells of directions in which a BSDF is tabulated while it is generated.

use crate::bins::{AngleBasis, KlemsBasis};
use std::f64::consts::PI;

crate::gpu_constants! {
    pub(super) const NUMBERS = {
        /// The rings of a Klems basis.
        const DIRECTIONS_RINGS: u32 = 0;
        /// The Shirley-Chiu square, for incident and outgoing light.
        const DIRECTIONS_SQUARE: u32 = 1;
        /// Outgoing square; incident slices of equal width in sin θ at azimuth 0, grazing first.
        const DIRECTIONS_SLICES: u32 = 2;
    }
}

/// What the entries of a generated BSDF stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Directions {
    /// A matrix over a Klems basis.
    Klems(KlemsBasis),
    /// A tensor tree of rank 4 with 2^n cells per side.
    Tree4(u32),
    /// An isotropic tensor tree of rank 3 with 2^n cells per side.
    Tree3(u32),
}

impl Directions {
    /// Cells along a side of the square; 2 for matrices, which have none.
    pub fn side(self) -> usize {
        match self {
            Directions::Klems(_) => 2,
            Directions::Tree4(n) | Directions::Tree3(n) => 1 << n,
        }
    }

    /// Incident cells of one side of the sample.
    pub fn incident(self) -> usize {
        match self {
            Directions::Klems(basis) => AngleBasis::from(basis).len(),
            Directions::Tree4(_) => self.side() * self.side(),
            // The lower half of the tree's first dimension: grazing to normal.
            Directions::Tree3(_) => self.side() / 2,
        }
    }

    /// Outgoing cells of one side of the sample.
    pub fn outgoing(self) -> usize {
        match self {
            Directions::Klems(basis) => AngleBasis::from(basis).len(),
            Directions::Tree4(_) | Directions::Tree3(_) => self.side() * self.side(),
        }
    }

    /// Entries of the whole table: both sides, incident times outgoing.
    pub fn entries(self) -> usize {
        4 * self.incident() * self.outgoing()
    }

    /// Projected solid angles of the outgoing cells, sr.
    pub(crate) fn outgoing_projected(self) -> Vec<f64> {
        match self {
            Directions::Klems(basis) => crate::bsdf::projected_solid_angles(&basis.into()),
            _ => vec![PI / self.outgoing() as f64; self.outgoing()],
        }
    }

    /// Projected solid angles of the incident cells over π: their shares of uniform diffuse light.
    pub(crate) fn incident_shares(self) -> Vec<f64> {
        match self {
            Directions::Klems(basis) => crate::bsdf::projected_solid_angles(&basis.into()).iter().map(|l| l / PI).collect(),
            Directions::Tree4(_) => vec![1.0 / self.incident() as f64; self.incident()],
            Directions::Tree3(_) => {
                let n = self.incident() as f64;
                (0..self.incident()).map(|s| (1.0 - s as f64 / n).powi(2) - (1.0 - (s + 1) as f64 / n).powi(2)).collect()
            }
        }
    }

    /// The cell of light that travels the other way along the same line; matrices and rank 4 only.
    pub fn opposite(self) -> Vec<usize> {
        match self {
            Directions::Klems(basis) => {
                let basis = AngleBasis::from(basis);
                (0..basis.len()).map(|bin| basis.opposite(bin)).collect()
            }
            _ => (0..self.outgoing()).rev().collect(),
        }
    }

    /// Code of `shaders/bsdf_generation/directions.wgsl`.
    pub(super) fn code(self) -> u32 {
        match self {
            Directions::Klems(_) => DIRECTIONS_RINGS,
            Directions::Tree4(_) => DIRECTIONS_SQUARE,
            Directions::Tree3(_) => DIRECTIONS_SLICES,
        }
    }

    /// The basis whose rings the device needs.
    pub(super) fn basis(self) -> AngleBasis {
        match self {
            Directions::Klems(basis) => basis.into(),
            _ => KlemsBasis::Quarter.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_diffuse_light_sum_to_one_and_opposites_pair_up() {
        for d in [Directions::Klems(KlemsBasis::Full), Directions::Tree4(3), Directions::Tree3(4)] {
            assert!((d.incident_shares().iter().sum::<f64>() - 1.0).abs() < 1e-12, "{d:?}");
            assert!((d.outgoing_projected().iter().sum::<f64>() - PI).abs() < 1e-12, "{d:?}");
            let opposite = d.opposite();
            assert!((0..d.outgoing()).all(|c| opposite[opposite[c]] == c));
        }
        assert_eq!(Directions::Klems(KlemsBasis::Full).entries(), 290 * 290);
    }
}

//! BSDF matrices over angle bases.

use super::projected_solid_angles;
use crate::bins::AngleBasis;
use crate::error::{Error, Result};
use std::f64::consts::PI;

/// A scattering function tabulated over bins: values in 1/sr, `[outgoing bin][incident bin]`, each
/// the mean over both bins. Values are as in the file, so they may be negative.
#[derive(Debug, Clone, PartialEq)]
pub struct KlemsMatrix {
    incident: AngleBasis,
    outgoing: AngleBasis,
    values: Vec<f64>,
}

impl KlemsMatrix {
    /// A matrix around its values, `values[out * incident.len() + in]`.
    ///
    /// # Errors
    /// If the number of values does not fit the bases.
    pub fn new(incident: AngleBasis, outgoing: AngleBasis, values: Vec<f64>) -> Result<Self> {
        if incident.len().checked_mul(outgoing.len()) != Some(values.len()) {
            return Err(Error::new(format!(
                "{} values do not fill a matrix of {} outgoing × {} incident bins",
                values.len(),
                outgoing.len(),
                incident.len()
            )));
        }
        Ok(Self { incident, outgoing, values })
    }

    /// A square matrix from a function of (outgoing bin, incident bin).
    pub fn from_fn(basis: &AngleBasis, mut f: impl FnMut(usize, usize) -> f64) -> Self {
        let n = basis.len();
        let values = (0..n * n).map(|i| f(i / n, i % n)).collect();
        Self { incident: basis.clone(), outgoing: basis.clone(), values }
    }

    /// Basis of the incident directions.
    pub fn incident(&self) -> &AngleBasis {
        &self.incident
    }

    /// Basis of the outgoing directions.
    pub fn outgoing(&self) -> &AngleBasis {
        &self.outgoing
    }

    /// All values, `[outgoing][incident]`.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All values, for changing them in place.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// One value, 1/sr.
    pub fn at(&self, outgoing: usize, incident: usize) -> f64 {
        self.values[outgoing * self.incident.len() + incident]
    }

    /// Σₒ f Λₒ of one incident bin: the transmittance or reflectance of light from there.
    pub fn direct_hemispherical(&self, incident: usize) -> f64 {
        (0..self.outgoing.len()).map(|o| self.at(o, incident) * self.outgoing.projected_solid_angle(o)).sum()
    }

    /// Direct-hemispherical values of all incident bins.
    pub fn all_direct_hemispherical(&self) -> Vec<f64> {
        let lambda = projected_solid_angles(&self.outgoing);
        let mut sums = vec![0.0; self.incident.len()];
        for (row, l) in self.values.chunks_exact(self.incident.len()).zip(&lambda) {
            for (sum, f) in sums.iter_mut().zip(row) {
                *sum += f * l;
            }
        }
        sums
    }

    /// Σ f Λₒ Λᵢ / π: transmittance or reflectance of uniform diffuse light.
    pub fn hemispherical(&self) -> f64 {
        let lambda = projected_solid_angles(&self.incident);
        self.all_direct_hemispherical().iter().zip(&lambda).map(|(t, l)| t * l).sum::<f64>() / PI
    }

    /// The matrix of light that travels the same paths backwards: incident and outgoing exchanged,
    /// every bin replaced by its opposite (Helmholtz reciprocity).
    pub fn reversed(&self) -> Self {
        let (incident, outgoing) = (self.outgoing.clone(), self.incident.clone());
        let opposite_in: Vec<usize> = (0..incident.len()).map(|i| incident.opposite(i)).collect();
        let values = (0..outgoing.len())
            .flat_map(|o| {
                let from = self.incident.opposite(o);
                opposite_in.iter().map(move |&i| self.at(i, from))
            })
            .collect();
        Self { incident, outgoing, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;

    #[test]
    fn a_lambertian_scatterer_and_a_hole_have_their_analytic_values() {
        let basis = AngleBasis::from(KlemsBasis::Half);
        let lambertian = KlemsMatrix::from_fn(&basis, |_, _| 0.4 / PI);
        let hole = KlemsMatrix::from_fn(&basis, |o, i| if o == i { 1.0 / basis.projected_solid_angle(i) } else { 0.0 });
        assert!((lambertian.hemispherical() - 0.4).abs() < 1e-12);
        assert!((hole.hemispherical() - 1.0).abs() < 1e-12);
        for i in 0..basis.len() {
            assert!((lambertian.direct_hemispherical(i) - 0.4).abs() < 1e-12);
            assert!((hole.direct_hemispherical(i) - 1.0).abs() < 1e-12);
        }
        assert_eq!(hole.reversed(), hole);
    }

    #[test]
    fn reversing_twice_changes_nothing_and_exchanges_opposite_bins() {
        let (a, b) = (AngleBasis::from(KlemsBasis::Full), AngleBasis::from(KlemsBasis::Quarter));
        let m = KlemsMatrix::new(a.clone(), b.clone(), (0..145 * 41).map(|i| i as f64).collect()).unwrap();
        let r = m.reversed();
        assert_eq!(r.reversed(), m);
        assert_eq!(r.at(a.opposite(17), b.opposite(3)), m.at(3, 17));
        assert!(KlemsMatrix::new(a, b, vec![0.0; 3]).is_err());
    }
}

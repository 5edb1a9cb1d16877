//! Radiance's material `glass`: one pane with Fresnel reflection at both faces; windows that have it.

use super::{MaterialKind, Window};
use crate::error::{Error, Result};

/// Refraction index of Radiance's `glass` unless a fourth argument says otherwise.
pub const REFRACTION_INDEX: f64 = 1.52;

/// One clear pane (Radiance `glass`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pane {
    /// Transmissivity per colour: of the material for one pass at normal incidence, not transmittance.
    pub transmissivity: [f64; 3],
    /// Refraction index.
    pub refraction_index: f64,
}

impl Pane {
    /// The pane of refraction index 1.52 with these transmittances at normal incidence.
    ///
    /// # Errors
    /// If there is no such pane: outside 0 to 0.918.
    pub fn of_transmittance(transmittance: [f64; 3]) -> Result<Self> {
        let transmissivity = transmittance.map(|t| transmissivity(t, REFRACTION_INDEX));
        if !transmissivity.iter().all(|t| (0.0..=1.0).contains(t)) {
            let most = glass_pane([1.0; 3], REFRACTION_INDEX, 1.0).0[0];
            return Err(Error::new(format!("no pane of glass has the transmittances {transmittance:?} at normal incidence"))
                .help(format!("give 0 to {most:.3}; both faces of a pane reflect")));
        }
        Ok(Self { transmissivity, refraction_index: REFRACTION_INDEX })
    }

    /// The pane that a material is, if it is glass.
    pub fn of_material(material: &MaterialKind) -> Option<Self> {
        match *material {
            MaterialKind::Glass { transmissivity, refraction_index } => Some(Self { transmissivity, refraction_index }),
            _ => None,
        }
    }

    /// The material that it is of.
    pub fn material(&self) -> MaterialKind {
        MaterialKind::Glass { transmissivity: self.transmissivity, refraction_index: self.refraction_index }
    }

    /// Transmittance per colour at this cosine of the angle of incidence.
    pub fn transmittance(&self, cosine: f64) -> [f64; 3] {
        glass_pane(self.transmissivity, self.refraction_index, cosine).0
    }
}

/// A window that is a pane of clear glass.
#[derive(Debug, Clone, PartialEq)]
pub struct GlazedWindow {
    /// The opening; its polygons are the pane.
    pub window: Window,
    /// What it is glazed with.
    pub pane: Pane,
}

/// Transmittance and reflectance of a pane at an angle of incidence: Fresnel's equations by angles, then
/// the sum over all internal reflections, both polarisations averaged. `transmissivity` is that of the
/// material for one pass at normal incidence.
pub(crate) fn glass_pane(transmissivity: [f64; 3], refraction_index: f64, cosine: f64) -> ([f64; 3], [f64; 3]) {
    let sin_in = (1.0 - cosine * cosine).max(0.0).sqrt();
    let cos_out = (1.0 - (sin_in / refraction_index).powi(2)).sqrt();
    let rs = ((cosine - refraction_index * cos_out) / (cosine + refraction_index * cos_out)).powi(2);
    let rp = ((refraction_index * cosine - cos_out) / (refraction_index * cosine + cos_out)).powi(2);
    let pass = transmissivity.map(|t| t.powf(1.0 / cos_out));
    let mix = |f: &dyn Fn(f64, f64) -> f64| pass.map(|d| (f(rs, d) + f(rp, d)) / 2.0);
    let t = mix(&|r, d| (1.0 - r).powi(2) * d / (1.0 - (r * d).powi(2)));
    let r = mix(&|r, d| r + (1.0 - r).powi(2) * r * d * d / (1.0 - (r * d).powi(2)));
    (t, r)
}

/// The transmissivity of a pane of this transmittance at normal incidence: the root of
/// T r² t² + (1 − r)² t − T = 0 with the faces' reflectance r. More than 1 if there is no such pane.
pub(crate) fn transmissivity(transmittance: f64, refraction_index: f64) -> f64 {
    let r = ((refraction_index - 1.0) / (refraction_index + 1.0)).powi(2);
    let passed = (1.0 - r).powi(2);
    // The other form of the root, which does not lose digits where r is small.
    2.0 * transmittance / (passed + (passed * passed + 4.0 * (transmittance * r).powi(2)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transmissivity_and_transmittance_belong_together() {
        for refraction_index in [1.0, 1.3, 1.52, 2.0] {
            for t in [0.0, 0.3, 0.88, 1.0] {
                let transmittance = glass_pane([t; 3], refraction_index, 1.0).0[0];
                assert!((transmissivity(transmittance, refraction_index) - t).abs() < 1e-12);
            }
        }
        let pane = Pane::of_transmittance([0.88, 0.6, 0.0]).unwrap();
        assert!((0..3).all(|c| (pane.transmittance(1.0)[c] - [0.88, 0.6, 0.0][c]).abs() < 1e-12));
        assert_eq!(Pane::of_material(&pane.material()), Some(pane));
        assert!(Pane::of_transmittance([0.93; 3]).is_err() && Pane::of_transmittance([-0.1; 3]).is_err());
        // Radiance's manual: transmissivity 0.96 of a pane of transmittance 0.88.
        assert!((transmissivity(0.88, 1.52) - 0.96).abs() < 2e-3);
    }
}

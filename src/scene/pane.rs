//! Radiance's material `glass`: one pane with Fresnel reflection at both faces; windows that have it; the rise of
//! reflection of other smooth surfaces towards grazing incidence.

use super::{MaterialKind, Window};
use crate::error::{Error, Result};

/// Squared roughness up to which surfaces are smooth.
pub(crate) const SMOOTH_ROUGHNESS2: f64 = 1e-6;

/// Specular fraction from which Radiance applies its Fresnel approximation to smooth surfaces (FRESTHRESH).
pub(crate) const FRESNEL_THRESHOLD: f64 = 0.018;

/// See [`smooth_fresnel`].
pub(crate) const FRESNEL_DECAY: f64 = 5.85;

/// Radiance's approximation to Fresnel's law for smooth surfaces: what they add to their specular
/// reflection at this cosine of incidence, as a share of the rest. 0 at normal incidence.
pub(crate) fn smooth_fresnel(cosine: f64) -> f64 {
    (-FRESNEL_DECAY * cosine).exp() - (-FRESNEL_DECAY).exp()
}

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
    /// The pane of refraction index 1.52 with these transmittances at normal incidence: the values of a data sheet,
    /// reflection at both faces included.
    ///
    /// # Errors
    /// Transmittances that no such pane has: 0 or less, or more than a pane without any absorption (0.918).
    pub fn of_transmittance(transmittance: [f64; 3]) -> Result<Self> {
        let most = glass_pane([1.0; 3], REFRACTION_INDEX, 1.0).0[0];
        for t in transmittance {
            if !(t > 0.0) {
                return Err(Error::new(format!("a pane of transmittance {t} lets no light through"))
                    .help("give the visible transmittance of the data sheet, above 0; leave the window out if it is none"));
            }
            if t > most + 1e-9 {
                return Err(Error::new(format!(
                    "a pane of transmittance {t} would have to reflect less than glass does: {most:.3} is the most"
                ))
                .help("of glass with an antireflective coating give layers, glazing = [\"glass:tvis=…,rvis=…,tsol=…,rsol=…,coated\"]"));
            }
        }
        let transmissivity = transmittance.map(|t| transmissivity(t, REFRACTION_INDEX).min(1.0));
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

    /// Transmittance and reflectance, RGB, of light at this cosine of the angle of incidence; all internal
    /// reflections included, both polarisations averaged.
    pub fn at(&self, cosine: f64) -> ([f64; 3], [f64; 3]) {
        glass_pane(self.transmissivity, self.refraction_index, cosine)
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
    // Along the pane the series of reflections has no sum where nothing is absorbed.
    let cosine = cosine.max(1e-6);
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
    fn panes_of_a_data_sheet_s_transmittance_have_it_and_others_are_refused() {
        for t in [0.05, 0.3, 0.65, 0.88, 0.918] {
            let (passed, mirrored) = Pane::of_transmittance([t; 3]).unwrap().at(1.0);
            assert!((passed[1] - t).abs() < 1e-12 && passed[1] + mirrored[1] <= 1.0, "{t}: {passed:?}");
        }
        for (wrong, word) in [(0.0, "no light"), (f64::NAN, "no light"), (0.93, "0.918 is the most"), (1.2, "0.918 is the most")] {
            let error = Pane::of_transmittance([wrong; 3]).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("help:"), "{error}");
        }
    }

    #[test]
    fn transmissivity_and_transmittance_belong_together() {
        for refraction_index in [1.0, 1.3, 1.52, 2.0] {
            for t in [0.0, 0.3, 0.88, 1.0] {
                let transmittance = glass_pane([t; 3], refraction_index, 1.0).0[0];
                assert!((transmissivity(transmittance, refraction_index) - t).abs() < 1e-12);
            }
        }
        let pane = Pane::of_transmittance([0.88, 0.6, 0.1]).unwrap();
        assert!((0..3).all(|c| (pane.transmittance(1.0)[c] - [0.88, 0.6, 0.1][c]).abs() < 1e-12));
        assert_eq!(Pane::of_material(&pane.material()), Some(pane));
        // Radiance's manual: transmissivity 0.96 of a pane of transmittance 0.88.
        assert!((transmissivity(0.88, 1.52) - 0.96).abs() < 2e-3);
    }
}

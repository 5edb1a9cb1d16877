//! Kinds of panes: what they scatter and what they let pass directly.

use crate::bsdf::evaluate::Scattering;
use crate::bsdf::{Block, Blocks, TensorTree};
use crate::error::{Error, Result, Warnings};
use crate::kernels::trace::{FRESNEL_THRESHOLD, SMOOTH_ROUGHNESS2, smooth_fresnel};
use crate::scene::MaterialKind;
use glam::DVec3;
use std::f64::consts::PI;

/// How a pane lets the sun in.
#[derive(Debug, Clone, PartialEq)]
pub enum PaneBsdf {
    /// Scattering data, all of it scattered (Radiance's `BSDF`).
    Bsdf(Scattering),
    /// Scattering data whose through-peak is a clear view (Radiance's `aBSDF`). Without a peak it is
    /// the same as [`Bsdf`](Self::Bsdf).
    PeakBsdf(Scattering),
    /// A clear pane.
    Glass {
        /// Transmissivity, as of Radiance's `glass`.
        transmissivity: [f64; 3],
        /// Refraction index.
        refraction_index: f64,
    },
    /// Radiance's smooth `trans`.
    Trans {
        /// Transmittance of the part that is scattered evenly.
        diffuse: [f64; 3],
        /// Transmittance of the part that is not scattered.
        clear: [f64; 3],
        /// Specular reflectance; from `FRESNEL_THRESHOLD` on it rises towards grazing angles.
        specularity: f64,
        /// The even scattering as data; black without it.
        lobe: Scattering,
    },
}

impl PaneBsdf {
    /// The pane of a window surface's material.
    ///
    /// # Errors
    /// If the material lets no sun through in a way that is known: others than glass, smooth trans
    /// and void.
    pub fn of_material(material: &MaterialKind) -> Result<Self> {
        match *material {
            MaterialKind::Glass { transmissivity, refraction_index } => Ok(Self::Glass { transmissivity, refraction_index }),
            MaterialKind::Void => Ok(Self::Trans { diffuse: [0.0; 3], clear: [1.0; 3], specularity: 0.0, lobe: even()? }),
            MaterialKind::Trans { color, specularity, roughness, transmissivity, transmitted_specularity } => {
                if roughness * roughness > SMOOTH_ROUGHNESS2 && transmitted_specularity > 0.0 {
                    return Err(Error::new("a rough trans spreads the sun; as a window's pane only a smooth one is known")
                        .field("trans")
                        .help("give its scattering data as a BSDF file, or roughness 0"));
                }
                let through = transmissivity * (1.0 - specularity);
                Ok(Self::Trans {
                    diffuse: color.map(|c| c * through * (1.0 - transmitted_specularity)),
                    clear: color.map(|c| c * through * transmitted_specularity),
                    specularity,
                    lobe: even()?,
                })
            }
            MaterialKind::Lobes(l) if l.roughness * l.roughness <= SMOOTH_ROUGHNESS2 => Ok(Self::Trans {
                diffuse: l.diffuse_transmitted,
                clear: l.specular_transmitted,
                specularity: l.specular.into_iter().fold(0.0, f64::max),
                lobe: even()?,
            }),
            _ => Err(Error::new("the sun does not pass through the window's material")
                .help("give a BSDF, glass, trans or void for the window's surface")),
        }
    }

    /// An aBSDF. Data without a through-peak are a plain BSDF, with a warning.
    pub fn with_peak(scattering: Scattering, name: &str, warnings: &mut Warnings) -> Self {
        if scattering.has_peak() {
            return Self::PeakBsdf(scattering);
        }
        warnings.push(
            Error::new("the BSDF has no through-peak: nothing is seen clearly through it, and all sunlight is scattered")
                .field(name)
                .help("use data of higher resolution (a tensor tree of 2^6 cells per side), or a plain BSDF"),
        );
        Self::Bsdf(scattering)
    }

    pub(super) fn scattering(&self) -> Option<&Scattering> {
        match self {
            Self::Bsdf(s) | Self::PeakBsdf(s) => Some(s),
            Self::Trans { diffuse, lobe, .. } => (*diffuse != [0.0; 3]).then_some(lobe),
            Self::Glass { .. } => None,
        }
    }

    pub(super) fn tint(&self) -> [f64; 3] {
        if let Self::Trans { diffuse, .. } = self { *diffuse } else { [1.0; 3] }
    }

    /// Transmittance (RGB) of the clear view for light that travels along `incident` (the window's
    /// frame, z into the room).
    pub fn clear(&self, incident: DVec3) -> [f64; 3] {
        if incident.z <= 0.0 {
            return [0.0; 3];
        }
        match self {
            Self::Bsdf(_) => [0.0; 3],
            Self::PeakBsdf(s) => [s.peak(incident).map_or(0.0, |p| p.transmittance); 3],
            Self::Glass { transmissivity, refraction_index } => {
                transmissivity.map(|t| glass_transmittance(t, *refraction_index, incident.z.min(1.0)))
            }
            Self::Trans { clear, .. } => clear.map(|c| c * self.scale(incident)),
        }
    }

    /// Factor on the scattering function for this incidence.
    pub(super) fn scale(&self, incident: DVec3) -> f64 {
        match self {
            Self::Trans { specularity, .. } if *specularity >= FRESNEL_THRESHOLD => 1.0 - smooth_fresnel(incident.z),
            _ => 1.0,
        }
    }
}

/// Even scattering of transmittance 1.
fn even() -> Result<Scattering> {
    Scattering::of_blocks(&Blocks { transmission_front: Some(Block::Tree(TensorTree::constant(4, 1.0 / PI))), ..Blocks::default() })
}

/// Transmittance of a pane, internal reflections included, both polarisations averaged.
fn glass_transmittance(transmissivity: f64, index: f64, cosine: f64) -> f64 {
    let inside = (1.0 - (1.0 - cosine * cosine) / (index * index)).max(0.0).sqrt();
    let pass = transmissivity.powf(1.0 / inside);
    let polarised = |amplitude: f64| {
        let r = amplitude * amplitude;
        (1.0 - r) * (1.0 - r) * pass / (1.0 - r * r * pass * pass)
    };
    let s = (cosine - index * inside) / (cosine + index * inside);
    let p = (inside - index * cosine) / (inside + index * cosine);
    (polarised(s) + polarised(p)) / 2.0
}

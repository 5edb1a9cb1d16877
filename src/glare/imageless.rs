//! Glare without pictures: the patches of the sky that reach the eye directly are the sources.
//!
//! N. L. Jones, "Fast climate-based glare analysis and spatial mapping", Building Simulation 2019;
//! Radiance's `dcglare` works this way. For the same patches, illuminance and position index the
//! result equals that of a picture whose sources are the patches.

use super::geometry::{ViewFrame, dot};
use super::{DgpModel, PositionIndex};

/// A patch of the sky (or the sun) as seen from the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Unit vector from the eye.
    pub direction: [f64; 3],
    /// Solid angle, sr.
    pub solid_angle: f64,
}

/// Patches as glare sources of one view; position indices are computed once.
#[derive(Debug, Clone, PartialEq)]
pub struct PatchSources {
    /// Solid angle, cosine and position index of each patch; `None` behind the viewer.
    patches: Vec<Option<[f64; 3]>>,
}

impl PatchSources {
    /// Patches seen in a view.
    pub fn new(frame: &ViewFrame, patches: &[Patch], position_index: PositionIndex) -> Self {
        let seen = |p: &Patch| {
            let cosine = dot(p.direction, frame.forward);
            (cosine > 0.0 && p.solid_angle > 0.0).then(|| [p.solid_angle, cosine, position_index.of(frame, p.direction)])
        };
        Self { patches: patches.iter().map(seen).collect() }
    }

    /// Sum of DGP's contrast term from the illuminance at the eye (lx) each patch gives directly.
    /// A patch's luminance is this illuminance over its projected solid angle; below `threshold`
    /// (cd/m²) it is no source.
    ///
    /// # Panics
    /// If the number of illuminances is not that of the patches.
    pub fn contrast_sum(&self, direct_illuminance: &[f64], threshold: f64, model: &DgpModel) -> f64 {
        model.contrast_sum(self.sources(direct_illuminance, threshold))
    }

    /// Number of patches that are sources.
    ///
    /// # Panics
    /// If the number of illuminances is not that of the patches.
    pub fn count(&self, direct_illuminance: &[f64], threshold: f64) -> usize {
        self.sources(direct_illuminance, threshold).count()
    }

    /// Luminance, solid angle and position index of the patches above the threshold.
    fn sources(&self, direct_illuminance: &[f64], threshold: f64) -> impl Iterator<Item = (f64, f64, f64)> {
        assert_eq!(direct_illuminance.len(), self.patches.len(), "one illuminance per patch");
        self.patches.iter().zip(direct_illuminance).filter_map(move |(patch, &e)| {
            let [solid_angle, cosine, position_index] = (*patch)?;
            let luminance = e / (solid_angle * cosine);
            (luminance > threshold).then_some((luminance, solid_angle, position_index))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_is_a_source_of_its_luminance() {
        let frame = ViewFrame::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
        let direction = [0.6, 0.8, 0.0];
        let patches = [
            Patch { direction, solid_angle: 0.02 },
            Patch { direction: [0.0, -1.0, 0.0], solid_angle: 0.02 },
            Patch { direction: [0.0, 0.8, 0.6], solid_angle: 0.03 },
        ];
        let sources = PatchSources::new(&frame, &patches, PositionIndex::Guth);
        let direct = [9000.0 * 0.02 * 0.8, 1e6, 1500.0 * 0.03 * 0.8];
        let sum = sources.contrast_sum(&direct, 2000.0, &DgpModel::ORIGINAL);
        let expected = 9000.0f64.powi(2) * 0.02 / PositionIndex::Guth.of(&frame, direction).powi(2);
        assert!((sum / expected - 1.0).abs() < 1e-12);
    }
}

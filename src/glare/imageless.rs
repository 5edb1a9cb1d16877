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

    /// DGP of patches by the published formulas alone (Wienold and Christoffersen 2006 with today's
    /// constants; Guth's position index above the line of sight as printed there, at most 16
    /// as in evalglare).
    fn reference(patches: &[Patch], luminance: &[f64], illuminance: f64) -> f64 {
        let mut sum = 0.0;
        for (p, l) in patches.iter().zip(luminance) {
            let [x, y, z] = p.direction;
            if *l <= 2000.0 || y <= 0.0 {
                continue;
            }
            // The view is towards +y: angle from the vertical plane, and from the line of sight.
            let (tau, sigma) = (x.abs().atan2(z.abs()).to_degrees(), y.acos().to_degrees());
            let position = ((35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp()) / 1000.0 * sigma
                + (21.0 + 0.26667 * tau - 0.002963 * tau * tau) / 100_000.0 * sigma * sigma)
                .exp()
                .min(16.0);
            sum += l * l * p.solid_angle / (illuminance.powf(1.87) * position * position);
        }
        5.87e-5 * illuminance + 0.092 * (1.0 + sum).log10() + 0.159
    }

    /// An eye outdoors sees patches of the sky as discs: the same by patches, by a picture of them, and
    /// by the formula.
    #[test]
    fn patches_are_sources_as_in_a_picture_and_as_published() {
        use crate::camera::{Raster, View};
        use crate::glare::{Analyser, PixelGeometry, Settings};
        const SKY: f64 = 800.0;
        let camera = View::parse("-vta -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh 180 -vv 180").unwrap().camera().unwrap();
        let geometry = std::sync::Arc::new(PixelGeometry::new(&Raster::new(camera, 500, 500).unwrap()).unwrap());
        let frame = ViewFrame::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
        let settings = Settings { search_radius: 0.05, peak_limit: None, ..Settings::default() };
        let analyser = Analyser::new(geometry.clone(), settings.clone()).unwrap();
        // Azimuth, altitude, radius (degrees), luminance; the last is below the threshold.
        let cases: [&[[f64; 4]]; 4] = [
            &[[0.0, 20.0, 5.0, 9000.0]],
            &[[-40.0, 30.0, 6.0, 6000.0], [35.0, 12.0, 4.0, 20_000.0]],
            &[[60.0, 5.0, 5.0, 30_000.0], [10.0, 60.0, 7.0, 5000.0], [-20.0, 40.0, 3.0, 12_000.0]],
            &[[25.0, 25.0, 6.0, 1900.0]],
        ];
        for discs in cases {
            let towards = |a: f64, h: f64| {
                let (a, h) = (a.to_radians(), h.to_radians());
                [a.sin() * h.cos(), a.cos() * h.cos(), h.sin()]
            };
            let mut picture = vec![SKY as f32; geometry.pixel_count()];
            let mut patches = Vec::new();
            for &[azimuth, altitude, radius, luminance] in discs {
                let direction = towards(azimuth, altitude);
                let radius = radius.to_radians();
                patches.push(Patch { direction, solid_angle: std::f64::consts::TAU * (1.0 - radius.cos()) });
                for (l, d) in picture.iter_mut().zip(&geometry.directions) {
                    if dot(*d, direction) > radius.cos() {
                        *l = luminance as f32;
                    }
                }
            }
            let luminance: Vec<f64> = discs.iter().map(|d| d[3]).collect();
            let direct: Vec<f64> = patches.iter().zip(&luminance).map(|(p, l)| l * p.solid_angle * p.direction[1]).collect();
            // Ev: a hemisphere of the sky's luminance, and what the discs have more; their cosine is nearly
            // that of their middle.
            let more: f64 = direct.iter().zip(&luminance).map(|(e, l)| e * (1.0 - SKY / l)).sum();
            let illuminance = std::f64::consts::PI * SKY + more;
            let sources = PatchSources::new(&frame, &patches, PositionIndex::Guth);
            let found = settings.dgp.dgp(illuminance, sources.contrast_sum(&direct, 2000.0, &settings.dgp));
            let whole = analyser.analyse(&picture, None).unwrap();
            let published = reference(&patches, &luminance, illuminance);
            assert!((found - published).abs() < 1e-9, "{found} {published}");
            assert!((whole.vertical_illuminance / illuminance - 1.0).abs() < 0.01);
            assert!((whole.indices.dgp - found).abs() < 0.005, "{} {found}", whole.indices.dgp);
            assert_eq!(whole.sources.len(), sources.count(&direct, 2000.0));
        }
    }
}

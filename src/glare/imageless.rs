//! Glare without pictures: the patches of the sky that reach the eye directly are the sources.
//!
//! N. L. Jones, "Fast climate-based glare analysis and spatial mapping", Building Simulation 2019;
//! Radiance's `dcglare` works this way. For the same patches, luminances, illuminance and position index
//! the result equals that of a picture whose sources are the patches.

use super::geometry::{ViewFrame, dot, normalise};
use super::{DgpModel, Settings};

/// A patch of the sky as seen from the eye.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Patch {
    /// Unit vectors from the eye to the middles of equally large parts of it; one if it is small.
    pub parts: Vec<[f64; 3]>,
    /// Solid angle, sr.
    pub solid_angle: f64,
}

/// Patches as glare sources of one view; position indices are computed once.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PatchSources {
    /// Solid angle and position index of what is before the eye of each patch; `None` if nothing is, or it
    /// is outside the field of view.
    patches: Vec<Option<[f64; 2]>>,
}

impl PatchSources {
    /// Patches seen in a view. A patch that the eye's plane cuts is a source as far as it is before the eye,
    /// in the middle of this part.
    pub(crate) fn new(frame: &ViewFrame, patches: &[Patch], settings: &Settings) -> Self {
        let seen = |p: &Patch| {
            let before: Vec<_> = p.parts.iter().filter(|d| dot(**d, frame.forward) > 0.0).collect();
            let middle = normalise(before.iter().fold([0.0; 3], |sum, d| [sum[0] + d[0], sum[1] + d[1], sum[2] + d[2]]))?;
            let solid_angle = p.solid_angle * before.len() as f64 / p.parts.len() as f64;
            let is_seen = solid_angle > 0.0 && settings.field_of_view.contains(frame, middle);
            is_seen.then(|| [solid_angle, settings.position_index.of(frame, middle)])
        };
        Self { patches: patches.iter().map(seen).collect() }
    }

    /// Sum of DGP's contrast term from the luminance of each patch, cd/m²; up to `threshold` (cd/m²) it is no
    /// source.
    ///
    /// # Panics
    /// If the number of luminances is not that of the patches.
    pub(crate) fn contrast_sum(&self, luminance: &[f64], threshold: f64, model: &DgpModel) -> f64 {
        model.contrast_sum(self.sources(luminance, threshold))
    }

    /// Number of patches that are sources.
    ///
    /// # Panics
    /// If the number of luminances is not that of the patches.
    pub fn count(&self, luminance: &[f64], threshold: f64) -> usize {
        self.sources(luminance, threshold).count()
    }

    /// Luminance, solid angle and position index of the patches above the threshold.
    fn sources(&self, luminance: &[f64], threshold: f64) -> impl Iterator<Item = (f64, f64, f64)> {
        assert_eq!(luminance.len(), self.patches.len(), "one luminance per patch");
        self.patches.iter().zip(luminance).filter_map(move |(patch, &luminance)| {
            let [solid_angle, position_index] = (*patch)?;
            (luminance > threshold).then_some((luminance, solid_angle, position_index))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glare::{FieldOfView, PositionIndex};

    fn patch(direction: [f64; 3], solid_angle: f64) -> Patch {
        Patch { parts: vec![direction], solid_angle }
    }

    #[test]
    fn a_patch_is_a_source_of_its_luminance() {
        let frame = ViewFrame::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
        let direction = [0.6, 0.8, 0.0];
        let patches = [patch(direction, 0.02), patch([0.0, -1.0, 0.0], 0.02), patch([0.0, 0.8, 0.6], 0.03)];
        let sources = PatchSources::new(&frame, &patches, &Settings::default());
        let sum = sources.contrast_sum(&[9000.0, 1e6, 1500.0], 2000.0, &DgpModel::ORIGINAL);
        let expected = 9000.0f64.powi(2) * 0.02 / PositionIndex::Guth.of(&frame, direction).powi(2);
        assert!((sum / expected - 1.0).abs() < 1e-12);
        // Guth's field of view with both eyes ends at about 60°.
        let aside = [patch([0.9, 0.19f64.sqrt(), 0.0], 0.02)];
        let narrow = Settings { field_of_view: FieldOfView::Binocular, ..Settings::default() };
        assert_eq!([Settings::default(), narrow].map(|s| PatchSources::new(&frame, &aside, &s).count(&[1e5], 2000.0)), [1, 0]);
    }

    /// A patch that slides behind the eye: its part before the eye shrinks evenly, and no cosine that is
    /// rounding noise makes it bright.
    #[test]
    fn a_patch_across_the_eyes_plane_counts_as_far_as_it_is_before_the_eye() {
        let patch = |turn: f64| {
            let part = |i: i32| f64::from(i) * 0.002 + turn;
            Patch { parts: (-20..20).map(|i| part(i) + 0.001).map(|a| [a.cos(), a.sin(), 0.0]).collect(), solid_angle: 0.08 }
        };
        let frame = ViewFrame::new([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
        let settings = Settings::default();
        let sum = |turn: f64| PatchSources::new(&frame, &[patch(turn)], &settings).contrast_sum(&[1e4], 2000.0, &DgpModel::ORIGINAL);
        // The middle of what is before the eye.
        let expected = |share: f64, middle: f64| {
            let position = PositionIndex::Guth.of(&frame, [f64::cos(middle), f64::sin(middle), 0.0]);
            1e8 * 0.08 * share / position.powi(2)
        };
        assert!((sum(0.0) / expected(0.5, 0.02) - 1.0).abs() < 1e-9 && (sum(0.02) / expected(0.75, 0.03) - 1.0).abs() < 1e-9);
        assert_eq!([sum(-0.041), sum(-0.5)], [0.0, 0.0]);
        let mut last = f64::INFINITY;
        for turn in [0.04, 0.02, 0.01, 1e-3, 1e-17, -1e-17, -1e-3, -0.02, -0.04] {
            assert!(sum(turn) <= last, "{turn}: {} {last}", sum(turn));
            last = sum(turn);
        }
    }

    /// DGP of patches by the published formulas alone (Wienold and Christoffersen 2006 with today's
    /// constants; Guth's position index above the line of sight as printed there, at most 16
    /// as in evalglare).
    fn reference(patches: &[Patch], luminance: &[f64], illuminance: f64) -> f64 {
        let mut sum = 0.0;
        for (p, l) in patches.iter().zip(luminance) {
            let [x, y, z] = p.parts[0];
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
        use crate::glare::{Analyser, PixelGeometry};
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
                patches.push(patch(direction, std::f64::consts::TAU * (1.0 - radius.cos())));
                for (l, d) in picture.iter_mut().zip(&geometry.directions) {
                    if dot(*d, direction) > radius.cos() {
                        *l = luminance as f32;
                    }
                }
            }
            let luminance: Vec<f64> = discs.iter().map(|d| d[3]).collect();
            let direct: Vec<f64> = patches.iter().zip(&luminance).map(|(p, l)| l * p.solid_angle * p.parts[0][1]).collect();
            // Ev: a hemisphere of the sky's luminance, and what the discs have more; their cosine is nearly
            // that of their middle.
            let more: f64 = direct.iter().zip(&luminance).map(|(e, l)| e * (1.0 - SKY / l)).sum();
            let illuminance = std::f64::consts::PI * SKY + more;
            let sources = PatchSources::new(&frame, &patches, &settings);
            let found = settings.dgp.dgp(illuminance, sources.contrast_sum(&luminance, 2000.0, &settings.dgp));
            let whole = analyser.analyse(&picture, None).unwrap();
            let published = reference(&patches, &luminance, illuminance);
            assert!((found - published).abs() < 1e-9, "{found} {published}");
            assert!((whole.vertical_illuminance / illuminance - 1.0).abs() < 0.01);
            assert!((whole.indices.dgp - found).abs() < 0.005, "{} {found}", whole.indices.dgp);
            assert_eq!(whole.sources.len(), sources.count(&luminance, 2000.0));
        }
    }
}

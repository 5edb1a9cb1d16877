//! The sun's disc, or an image of it in a mirror, as a glare source of its own.
//!
//! The disc is half a degree wide; a pixel of a usual fisheye is wider. A pixel that carries the disc has
//! its light but not its luminance, and DGP counts luminance squared times solid angle: at 100 × 100
//! pixels it misses 0.13 of it. So whoever knows where the sun is (a run, not a picture that was read)
//! keeps it out of the pixels and hands it over as a direction, a luminance and a solid angle. The
//! result depends on the pixels no more.

use super::geometry::{PixelGeometry, Totals, ViewFrame, dot};
use super::position::angles;
use super::sources::Source;
use super::{Analyser, Glare, Settings};
use crate::error::{Error, Result};
use crate::units::{SUN_DIAMETER_DEG, cap_solid_angle};

/// A disc, or the part of it that is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Unit vector from the eye to the middle of what is seen.
    pub direction: [f64; 3],
    /// Mean luminance of what is seen, cd/m².
    pub luminance: f64,
    /// Solid angle of what is seen, sr.
    pub solid_angle: f64,
    /// Standard error of the solid angle, relative to it.
    pub error: f64,
}

impl Disc {
    /// Luminance times solid angle, cd·sr/m².
    pub fn flux(&self) -> f64 {
        self.luminance * self.solid_angle
    }

    /// Illuminance at the eye across its view direction, lx; 0 behind it.
    pub fn illuminance(&self, frame: &ViewFrame) -> f64 {
        self.flux() * dot(self.direction, frame.forward).max(0.0)
    }

    /// The disc if one standard error more of it were seen.
    #[must_use]
    pub(crate) fn with_more_seen(self) -> Self {
        Self { solid_angle: self.solid_angle * (1.0 + self.error), ..self }
    }

    /// Whether it is a source for an eye: before it, in the field of view, and brighter than the threshold.
    pub(crate) fn is_source(&self, frame: &ViewFrame, threshold: f64, settings: &Settings) -> bool {
        self.luminance > threshold && dot(self.direction, frame.forward) > 0.0 && settings.field_of_view.contains(frame, self.direction)
    }

    /// The disc as a source. It has no pixels, and so neither column nor row.
    pub(super) fn source(&self, frame: &ViewFrame, settings: &Settings) -> Source {
        let (sigma, tau) = angles(frame, self.direction);
        Source {
            pixels: Vec::new(),
            x: f64::NAN,
            y: f64::NAN,
            direction: self.direction,
            luminance: self.luminance,
            peak_luminance: self.luminance,
            solid_angle: self.solid_angle,
            illuminance: self.illuminance(frame),
            position_index: settings.position_index.of(frame, self.direction),
            sigma,
            tau,
            is_peak: true,
        }
    }
}

/// DGP's contrast sum of the discs that are sources, Σ L^a1 ω^a2 / P^a4, and their number.
pub(crate) fn contrast(discs: &[Disc], frame: &ViewFrame, threshold: f64, settings: &Settings) -> (f64, usize) {
    let seen = discs.iter().filter(|d| d.is_source(frame, threshold, settings));
    let of = |d: &Disc| settings.dgp.contrast_of((d.luminance, d.solid_angle, settings.position_index.of(frame, d.direction)));
    seen.fold((0.0, 0), |(sum, count), d| (sum + of(d), count + 1))
}

/// Luminance from which something as large as the sun's disc may be the sun, cd/m²: a hundredth of the
/// sun's, as it is near the horizon or through a dense fabric.
const SUNLIKE: f64 = 1e7;
/// Share of the greatest luminance from which pixels show the same disc.
const SAME_DISC: f64 = 0.1;
/// Most pixels over which one disc is spread: it lies on the corner of four, or a little finer ones.
const MOST_PIXELS: usize = 9;
/// Change of DGP that is worth a word.
const MUCH: f64 = 0.01;

impl Analyser {
    /// Adds the light of discs to the sums of a picture without them.
    pub(crate) fn add_discs(&self, discs: &[Disc], totals: &mut Totals, task_luminance: &mut Option<f64>) {
        let frame = &self.geometry.frame;
        for disc in discs.iter().filter(|d| dot(d.direction, frame.forward) > 0.0) {
            totals.vertical_illuminance += disc.illuminance(frame);
            totals.average_luminance += disc.flux() / totals.solid_angle;
            if let (Some(luminance), Some((centre, cosine))) = (task_luminance.as_mut(), self.task_cap)
                && dot(disc.direction, centre) >= cosine
            {
                *luminance += disc.flux() / task_solid_angle(&self.geometry, &self.task_pixels);
            }
        }
    }

    /// A warning if a picture seems to hold the sun on pixels that are too coarse for it, with what DGP would
    /// be if the brightest of them were the sun's disc.
    ///
    /// `luminance` is the picture that `glare` was found in, cd/m²; `vertical_illuminance` what DGP took in place
    /// of the picture's own.
    pub fn doubt_of_coarse_sun(&self, luminance: &[f32], glare: &Glare, vertical_illuminance: Option<f64>) -> Option<Error> {
        let source = glare.sources.iter().max_by(|a, b| a.peak_luminance.total_cmp(&b.peak_luminance))?;
        let of = |p: &u32| (f64::from(luminance[*p as usize]), self.geometry.solid_angles[*p as usize]);
        let (mut flux, mut solid_angle, mut pixels) = (0.0, 0.0, 0);
        for (l, omega) in source.pixels.iter().map(of).filter(|(l, _)| *l >= SAME_DISC * source.peak_luminance) {
            (flux, solid_angle, pixels) = (flux + l * omega, solid_angle + omega, pixels + 1);
        }
        let of_sun = cap_solid_angle(SUN_DIAMETER_DEG.to_radians() / 2.0);
        let sun = Disc { direction: source.direction, luminance: flux / of_sun, solid_angle: of_sun, error: 0.0 };
        if pixels == 0 || pixels > MOST_PIXELS || solid_angle <= sun.solid_angle || sun.luminance < SUNLIKE {
            return None;
        }
        let (dgp, frame) = (&self.settings.dgp, self.settings.convention.frame(&self.geometry));
        let of = |s: &Source| dgp.contrast_of((s.luminance, s.solid_angle, s.position_index));
        let whole: f64 = glare.sources.iter().map(of).sum();
        let rest = source.solid_angle - solid_angle;
        let rest_luminance = if rest > 0.0 { (source.luminance * source.solid_angle - flux).max(0.0) / rest } else { 0.0 };
        let without = whole - of(source) + dgp.contrast_of((rest_luminance, rest.max(0.0), source.position_index));
        let sum = without.max(0.0) + contrast(&[sun], &frame, 0.0, &self.settings).0;
        let with_disc = dgp.dgp(vertical_illuminance.unwrap_or(glare.vertical_illuminance), sum);
        if with_disc - glare.indices.dgp <= MUCH {
            return None;
        }
        let pixel = (solid_angle / pixels as f64).sqrt().to_degrees();
        Some(
            Error::new(format!(
                "the brightest spot may be the sun, on pixels of {pixel:.2}° (the sun is {SUN_DIAMETER_DEG}° wide): its luminance is spread, and DGP depends on the size of the pixels; as the sun's disc it would give a DGP of {with_disc:.3}, not {:.3}",
                glare.indices.dgp
            ))
            .help("use a picture of 0.1° per pixel (1800 × 1800 for a fisheye of 180°), or let a run find the glare: there the sun is a source of its own"),
        )
    }
}

/// Solid angle of a task area, sr.
pub(crate) fn task_solid_angle(geometry: &PixelGeometry, pixels: &[u32]) -> f64 {
    pixels.iter().map(|&p| geometry.solid_angles[p as usize]).sum()
}

pub(super) fn check(discs: &[Disc]) -> Result<()> {
    let sound = |d: &Disc| {
        d.direction.iter().chain([&d.luminance, &d.solid_angle]).all(|v| v.is_finite()) && d.luminance >= 0.0 && d.solid_angle >= 0.0
    };
    if discs.iter().all(sound) { Ok(()) } else { Err(Error::new("a disc's direction, luminance or solid angle is negative or not finite")) }
}

//! Camera and eye do not see the sun as a sharp disc: its light is spread by a Gaussian.

use super::Disc;
use super::geometry::{PixelGeometry, cross, dot, normalise};
use crate::error::{Error, Result};
use crate::units::cap_solid_angle;

/// Standard deviations to which the Gaussian is followed.
const REACH: f64 = 4.0;

/// Steps of the integrals over a disc and over what it is spread to.
const STEPS: usize = 64;

/// What a Gaussian of full width at half maximum `fwhm_deg` makes of a disc, as [`spread_peaks`] does in the
/// limit of fine pixels: the part of at least `peak_limit` (cd/m²), then the ring around it that is brighter
/// than `threshold`. Either may be missing; what is dimmer is no source. What is seen of the disc is spread
/// as a round disc of the same solid angle.
///
/// # Errors
/// If the width is not a number between 0 and 45 degrees.
pub(crate) fn spread_disc(disc: &Disc, fwhm_deg: f64, peak_limit: f64, threshold: f64) -> Result<Vec<Disc>> {
    check_width(fwhm_deg)?;
    if disc.flux() <= 0.0 {
        return Ok(Vec::new());
    }
    let profile = Profile { radius: (disc.solid_angle / std::f64::consts::PI).sqrt(), sigma: sigma(fwhm_deg), luminance: disc.luminance };
    let part = |[from, to]: [f64; 2]| {
        let solid_angle = cap_solid_angle(to) - cap_solid_angle(from);
        let step = (to - from) / STEPS as f64;
        let rings = (0..STEPS).map(|i| from + (i as f64 + 0.5) * step);
        let flux: f64 = rings.map(|t| profile.at(t) * std::f64::consts::TAU * t.sin() * step).sum();
        (solid_angle > 0.0).then(|| Disc { luminance: flux / solid_angle, solid_angle, ..*disc })
    };
    let core = profile.radius_of(peak_limit.max(threshold));
    let ring = profile.radius_of(threshold);
    Ok([[0.0, core], [core, ring]].into_iter().filter_map(part).collect())
}

/// A uniform disc under a Gaussian.
struct Profile {
    /// Radius of the disc, rad.
    radius: f64,
    /// Standard deviation of the Gaussian, rad.
    sigma: f64,
    /// Luminance of the disc, cd/m².
    luminance: f64,
}

impl Profile {
    /// Luminance at an angle from the centre, cd/m²: the disc's rings, each over the Gaussian's part around
    /// the axis, e^(−(r² + t²)/2σ²) I₀(rt/σ²).
    fn at(&self, t: f64) -> f64 {
        let (s, reach) = (self.sigma, 8.0 * self.sigma);
        let (from, to) = ((t - reach).max(0.0), (t + reach).min(self.radius));
        if to <= from {
            return 0.0;
        }
        let step = (to - from) / STEPS as f64;
        let ring = |r: f64| r / (s * s) * (-0.5 * ((r - t) / s).powi(2)).exp() * scaled_bessel(r * t / (s * s));
        self.luminance * step * (0..STEPS).map(|i| ring(from + (i as f64 + 0.5) * step)).sum::<f64>()
    }

    /// Angle up to which the luminance is at least so much; 0 if nowhere.
    fn radius_of(&self, luminance: f64) -> f64 {
        if self.at(0.0) < luminance {
            return 0.0;
        }
        let (mut inside, mut outside) = (0.0, (self.radius + 8.0 * self.sigma).min(std::f64::consts::FRAC_PI_2));
        for _ in 0..40 {
            let middle = (inside + outside) / 2.0;
            *(if self.at(middle) >= luminance { &mut inside } else { &mut outside }) = middle;
        }
        inside
    }
}

/// e^(−x) I₀(x) for x ≥ 0 (Abramowitz and Stegun 9.8.1 and 9.8.2, to 2·10⁻⁷).
fn scaled_bessel(x: f64) -> f64 {
    let series = |coefficients: &[f64], t: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if x < 3.75 {
        let of = [1.0, 3.515_622_9, 3.089_942_4, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];
        return series(&of, (x / 3.75).powi(2)) * (-x).exp();
    }
    let of =
        [0.398_942_28, 0.013_285_92, 0.002_253_19, -0.001_575_65, 0.009_162_81, -0.020_577_06, 0.026_355_37, -0.016_476_33, 0.003_923_77];
    series(&of, 3.75 / x) / x.sqrt()
}

/// Spreads the light of all pixels of at least `limit` (cd/m²), each by a Gaussian of full width at
/// half maximum `fwhm_deg`; the others stay. Σ L·ω is conserved.
///
/// # Errors
/// If the width is not a positive finite number or the image does not fit.
pub fn spread_peaks(luminance: &mut [f32], geometry: &PixelGeometry, limit: f64, fwhm_deg: f64) -> Result<()> {
    check(luminance, geometry, fwhm_deg)?;
    let peaks: Vec<usize> = (0..luminance.len()).filter(|&i| geometry.is_inside(i) && f64::from(luminance[i]) >= limit).collect();
    let mut added = std::collections::BTreeMap::<usize, f64>::new();
    for &peak in &peaks {
        let flux = f64::from(luminance[peak]) * geometry.solid_angles[peak];
        for (i, share) in spread(geometry, peak, geometry.directions[peak], fwhm_deg) {
            *added.entry(i).or_default() += flux * share;
        }
    }
    peaks.iter().for_each(|&peak| luminance[peak] = 0.0);
    for (i, l) in added {
        luminance[i] = (f64::from(luminance[i]) + l) as f32;
    }
    Ok(())
}

fn check(luminance: &[f32], geometry: &PixelGeometry, fwhm_deg: f64) -> Result<()> {
    if luminance.len() != geometry.pixel_count() {
        return Err(Error::new(format!("{} luminances do not fit {} pixels", luminance.len(), geometry.pixel_count())));
    }
    check_width(fwhm_deg)
}

fn check_width(fwhm_deg: f64) -> Result<()> {
    if !(fwhm_deg > 0.0 && fwhm_deg < 45.0) {
        return Err(Error::new(format!("{fwhm_deg} is not a width between 0 and 45 degrees")).field("veil"));
    }
    Ok(())
}

/// Standard deviation of a Gaussian, rad.
fn sigma(fwhm_deg: f64) -> f64 {
    fwhm_deg.to_radians() / (8.0 * std::f64::consts::LN_2).sqrt()
}

/// Pixels and their luminance per unit of flux: weights normalised so that Σ weight·ω = 1.
fn spread(geometry: &PixelGeometry, nearest: usize, direction: [f64; 3], fwhm_deg: f64) -> Vec<(usize, f64)> {
    let sigma = sigma(fwhm_deg);
    let (x, y) = (nearest % geometry.width, nearest / geometry.width);
    let mut weights = Vec::new();
    // Rings of pixels around the nearest one, until a ring lies wholly beyond reach.
    for ring in 0..geometry.width.max(geometry.height) {
        let mut reached = false;
        let (left, right) = (x.saturating_sub(ring), (x + ring).min(geometry.width - 1));
        let (top, bottom) = (y.saturating_sub(ring), (y + ring).min(geometry.height - 1));
        for j in top..=bottom {
            let whole_row = j + ring == y || j == y + ring;
            let columns = (left..=right).filter(|&i| whole_row || i + ring == x || i == x + ring);
            for i in columns {
                let pixel = j * geometry.width + i;
                if !geometry.is_inside(pixel) {
                    continue;
                }
                let margin = geometry.solid_angles[pixel].sqrt();
                let apart = angle(geometry.directions[pixel], direction);
                if apart <= REACH * sigma + margin {
                    reached = true;
                    let w = mean_over_pixel(geometry, pixel, direction, sigma);
                    if w > 0.0 {
                        weights.push((pixel, w));
                    }
                }
            }
        }
        if !reached {
            break;
        }
    }
    let total: f64 = weights.iter().map(|&(i, w)| w * geometry.solid_angles[i]).sum();
    if total <= 0.0 {
        return vec![(nearest, 1.0 / geometry.solid_angles[nearest])];
    }
    weights.iter_mut().for_each(|(_, w)| *w /= total);
    weights
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let c = cross(a, b);
    dot(c, c).sqrt().atan2(dot(a, b))
}

/// Mean of the Gaussian over a pixel, which may be larger than it: sampled at points between the
/// pixel's centre and those of its neighbours.
fn mean_over_pixel(geometry: &PixelGeometry, pixel: usize, direction: [f64; 3], sigma: f64) -> f64 {
    let (w, h) = (geometry.width, geometry.height);
    let (x, y) = (pixel % w, pixel / w);
    let centre = geometry.directions[pixel];
    let step = |before: Option<usize>, after: Option<usize>| {
        let to = |n: usize| geometry.directions[n];
        let inside = |n: &usize| geometry.is_inside(*n);
        match (before.filter(inside), after.filter(inside)) {
            (Some(a), Some(b)) => [0, 1, 2].map(|k| (to(b)[k] - to(a)[k]) / 2.0),
            (Some(a), None) => [0, 1, 2].map(|k| centre[k] - to(a)[k]),
            (None, Some(b)) => [0, 1, 2].map(|k| to(b)[k] - centre[k]),
            (None, None) => [0.0; 3],
        }
    };
    let across = step((x > 0).then(|| pixel - 1), (x + 1 < w).then(|| pixel + 1));
    let down = step((y > 0).then(|| pixel.wrapping_sub(w)), (y + 1 < h).then(|| pixel + w));
    let size = dot(across, across).max(dot(down, down)).sqrt();
    let n = ((3.0 * size / sigma).ceil() as usize).clamp(1, 16);
    let mut sum = 0.0;
    for j in 0..n {
        for i in 0..n {
            let (u, v) = ((i as f64 + 0.5) / n as f64 - 0.5, (j as f64 + 0.5) / n as f64 - 0.5);
            let place = normalise([0, 1, 2].map(|k| centre[k] + u * across[k] + v * down[k])).unwrap_or(centre);
            let t = angle(place, direction) / sigma;
            if t <= REACH {
                sum += (-0.5 * t * t).exp();
            }
        }
    }
    sum / (n * n) as f64
}

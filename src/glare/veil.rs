//! Camera and eye do not see the sun as a sharp disc: its light is spread by a Gaussian.

use super::geometry::{PixelGeometry, cross, dot, normalise};
use crate::error::{Error, Result};
use crate::units::SUN_DIAMETER_DEG;

/// Full width at half maximum of the spread, degrees: the sun's diameter.
pub const SUN_SPREAD_DEG: f64 = SUN_DIAMETER_DEG;

/// Standard deviations to which the Gaussian is followed.
const REACH: f64 = 4.0;

/// Adds a point source of `flux` = luminance × solid angle (cd/m²·sr) in `direction` (unit vector),
/// spread by a Gaussian of full width at half maximum `fwhm_deg`. Σ L·ω over the picture grows by
/// exactly `flux`, also where the Gaussian is narrower than a pixel; a source at the view's rim
/// keeps all of its light inside. Outside the view nothing is added; returns whether it was.
///
/// # Errors
/// If the width or the flux is not a positive finite number, or the image does not fit.
pub fn add_spread_source(luminance: &mut [f32], geometry: &PixelGeometry, direction: [f64; 3], flux: f64, fwhm_deg: f64) -> Result<bool> {
    check(luminance, geometry, fwhm_deg)?;
    if !(flux.is_finite() && flux >= 0.0) {
        return Err(Error::new(format!("{flux} is not an amount of light")).field("veil"));
    }
    let nearest = (0..geometry.pixel_count())
        .filter(|&i| geometry.is_inside(i))
        .max_by(|&a, &b| dot(geometry.directions[a], direction).total_cmp(&dot(geometry.directions[b], direction)));
    let Some(nearest) = nearest else { return Ok(false) };
    // Half a pixel's diagonal beyond the nearest centre is outside.
    let apart = dot(geometry.directions[nearest], direction).clamp(-1.0, 1.0).acos();
    if apart > geometry.solid_angles[nearest].sqrt() {
        return Ok(false);
    }
    for (i, share) in spread(geometry, nearest, direction, fwhm_deg) {
        luminance[i] += (flux * share) as f32;
    }
    Ok(true)
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
    if !(fwhm_deg > 0.0 && fwhm_deg < 45.0) {
        return Err(Error::new(format!("{fwhm_deg} is not a width between 0 and 45 degrees")).field("veil"));
    }
    Ok(())
}

/// Pixels and their luminance per unit of flux: weights normalised so that Σ weight·ω = 1.
fn spread(geometry: &PixelGeometry, nearest: usize, direction: [f64; 3], fwhm_deg: f64) -> Vec<(usize, f64)> {
    let sigma = fwhm_deg.to_radians() / (8.0 * std::f64::consts::LN_2).sqrt();
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

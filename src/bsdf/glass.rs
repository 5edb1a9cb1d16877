//! Panes of glass from values at normal incidence, of two bands or over the wavelength.
//!
//! Uncoated: one slab with Fresnel reflection at both faces and absorption between, whose index and
//! absorption follow from transmittance and reflectance at the normal (Rubin, Solar Energy 34,
//! 1985). Coated or laminated: the regression of Finlayson, Arasteh et al. 1993 (WINDOW 4.0,
//! LBL-33943) for clear (τ > 0.645) or bronze coated glass. Both are applied wavelength by
//! wavelength to measured spectra, and band by band (visible, rest of the sun's) where only the
//! means are known; the middle angle of a ring stands for it. All this is WINDOW's way.

use super::spectrum::{self, Spectrum, VISIBLE_RANGE, beyond_visible};
use crate::error::{Error, Result};
use std::path::Path;

/// Transmittance and reflectance at normal incidence in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// Transmittance, the same from both sides.
    pub transmittance: f64,
    /// Reflectance for light from the outside.
    pub reflectance_front: f64,
    /// Reflectance for light from the room.
    pub reflectance_back: f64,
}

/// What is known of a pane at normal incidence.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Means over the visible and the solar spectrum.
    Bands {
        /// Visible values.
        visible: Normal,
        /// Solar values.
        solar: Normal,
    },
    /// Measurements over the wavelength.
    Spectral(Spectrum),
}

/// A pane.
#[derive(Debug, Clone, PartialEq)]
pub struct Pane {
    /// Name for messages.
    pub name: String,
    /// Thickness, m.
    pub thickness: f64,
    /// Whether it is coated, laminated or has a film.
    pub coated: bool,
    /// Optical properties.
    pub values: Values,
}

/// Named panes: generic clear glass as NFRC lists it (ids 102 and 103; W5_NFRC_2003 weighting).
pub fn named(name: &str) -> Option<Pane> {
    let clear = |thickness, visible: [f64; 2], solar: [f64; 2]| {
        let both = |[t, r]: [f64; 2]| Normal { transmittance: t, reflectance_front: r, reflectance_back: r };
        let values = Values::Bands { visible: both(visible), solar: both(solar) };
        Pane { name: name.into(), thickness, coated: false, values }
    };
    match name {
        "clear_3mm" => Some(clear(0.003_048, [0.8993, 0.0826], [0.8338, 0.0748])),
        "clear_6mm" => Some(clear(0.005_715, [0.8836, 0.0804], [0.7707, 0.0700])),
        _ => None,
    }
}

impl Pane {
    /// Reads `clear_6mm`, a file of spectral data (`pane.dat`, `pane.json`), or
    /// `tvis=.7,rvis=.1[,rvis_back=.12],tsol=.4,rsol=.3[,rsol_back=.35][,coated][,thickness=6mm]`.
    ///
    /// # Errors
    /// Unknown names and keys, missing or impossible values, faulty files.
    pub fn parse(text: &str) -> Result<Self> {
        Self::parse_in(Path::new(""), text)
    }

    /// The same with files relative to a folder.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn parse_in(folder: &Path, text: &str) -> Result<Self> {
        if let Some(pane) = named(text) {
            return Ok(pane);
        }
        let path = folder.join(text);
        if !text.contains('=') && (path.exists() || path.extension().is_some()) {
            let measured = spectrum::read_pane(&path)?;
            let name = if measured.name.is_empty() { text.to_string() } else { measured.name };
            return Ok(Self { name, thickness: measured.thickness, coated: measured.coated, values: Values::Spectral(measured.spectrum) });
        }
        let known = "clear_3mm, clear_6mm, a file of spectral data (.dat, .txt, .json), or \
                     tvis=…,rvis=…,tsol=…,rsol=…[,rvis_back=…][,rsol_back=…][,thickness=6mm][,coated]";
        let wrong = |what: String| Error::new(what).field(format!("glass:{text}")).help(known);
        let mut values: [Option<f64>; 6] = [None; 6];
        let (mut coated, mut thickness) = (false, 0.0);
        const KEYS: [&str; 6] = ["tvis", "rvis", "rvis_back", "tsol", "rsol", "rsol_back"];
        for part in text.split(',').map(str::trim) {
            match part.split_once('=') {
                None if part == "coated" => coated = true,
                Some(("thickness", text)) => thickness = length(text)?,
                Some((key, value)) => {
                    let slot = KEYS.iter().position(|k| *k == key).ok_or_else(|| wrong(format!("'{key}' is not a property of glass")))?;
                    let value = value.parse().ok().filter(|v| (0.0..=1.0).contains(v));
                    values[slot] = Some(value.ok_or_else(|| wrong(format!("{part}: a value within 0…1 is needed")))?);
                }
                None => return Err(wrong(format!("'{part}' is not a known glass"))),
            }
        }
        let band = |first: usize| -> Result<Normal> {
            let get = |i: usize| values[i].ok_or_else(|| wrong(format!("{} is missing", KEYS[i])));
            let normal = Normal {
                transmittance: get(first)?,
                reflectance_front: get(first + 1)?,
                reflectance_back: values[first + 2].or(values[first + 1]).unwrap_or_default(),
            };
            if normal.transmittance + normal.reflectance_front.max(normal.reflectance_back) > 1.0 {
                return Err(wrong("transmittance and reflectance sum to more than 1".into()));
            }
            Ok(normal)
        };
        Ok(Self { name: text.into(), thickness, coated, values: Values::Bands { visible: band(0)?, solar: band(3)? } })
    }

    /// The pane turned around.
    pub fn flipped(&self) -> Self {
        let turn = |n: &Normal| Normal { reflectance_front: n.reflectance_back, reflectance_back: n.reflectance_front, ..*n };
        let values = match &self.values {
            Values::Bands { visible, solar } => Values::Bands { visible: turn(visible), solar: turn(solar) },
            Values::Spectral(spectrum) => Values::Spectral(spectrum.flipped()),
        };
        Self { name: format!("{} (flipped)", self.name), values, ..self.clone() }
    }

    /// Values at normal incidence at a wavelength, µm.
    pub fn normal(&self, wavelength: f64) -> Normal {
        match &self.values {
            Values::Bands { visible, .. } if (VISIBLE_RANGE[0]..=VISIBLE_RANGE[1]).contains(&wavelength) => *visible,
            Values::Bands { visible, solar } => {
                let t = beyond_visible(visible.transmittance, solar.transmittance).min(1.0);
                let r = |v: f64, s: f64| beyond_visible(v, s).min(1.0 - t);
                Normal {
                    transmittance: t,
                    reflectance_front: r(visible.reflectance_front, solar.reflectance_front),
                    reflectance_back: r(visible.reflectance_back, solar.reflectance_back),
                }
            }
            Values::Spectral(spectrum) => {
                let [transmittance, reflectance_front, reflectance_back] = spectrum.at(wavelength);
                Normal { transmittance, reflectance_front, reflectance_back }
            }
        }
    }

    /// Front and back transmittance, front and back reflectance at an angle of incidence, degrees,
    /// from these values at normal incidence. The slab's two transmittances differ as much as
    /// measured reflectances of its two sides do.
    pub fn at(&self, normal: &Normal, theta: f64) -> [f64; 4] {
        let model = if self.coated { coated } else { slab };
        let [front, back] = [normal.reflectance_front, normal.reflectance_back].map(|r| model(normal.transmittance, r, theta));
        [front[0], back[0], front[1], back[1]]
    }
}

/// Transmittance and reflectance of an uncoated slab with these values at normal incidence.
fn slab(t: f64, r: f64, theta: f64) -> [f64; 2] {
    // One face reflects r₀ at the normal; inside, the share a passes.
    let beta = t * t - r * r + 2.0 * r + 1.0;
    let r0 = ((beta - (beta * beta - 4.0 * (2.0 - r) * r).max(0.0).sqrt()) / (2.0 * (2.0 - r))).clamp(0.0, 0.99);
    let index = (1.0 + r0.sqrt()) / (1.0 - r0.sqrt());
    let a0 = if r0 * t > 0.0 && r > r0 {
        ((r - r0) / (r0 * t)).clamp(0.0, 1.0)
    } else {
        // Without reflection from the far side the slab is opaque or black.
        (t / ((1.0 - r0) * (1.0 - r0))).clamp(0.0, 1.0)
    };
    let cos = theta.to_radians().cos().max(0.0);
    let cos_inside = (1.0 - (1.0 - cos * cos) / (index * index)).sqrt();
    let a = a0.powf(1.0 / cos_inside);
    let mut sum = [0.0; 2];
    for (x, y) in [(cos, index * cos_inside), (index * cos, cos_inside)] {
        let face = if x + y > 0.0 { ((x - y) / (x + y)).powi(2) } else { 1.0 };
        let denominator = 1.0 - (face * a).powi(2);
        if denominator > 1e-15 {
            let through = (1.0 - face).powi(2) * a / denominator;
            sum[0] += through / 2.0;
            sum[1] += (face + face * a * through) / 2.0;
        } else {
            sum[1] += 0.5;
        }
    }
    sum
}

/// Transmittance and reflectance of coated glass with these values at normal incidence.
///
/// The coefficients as published give the values at the normal only within 1.2 %, so these are
/// taken as they are at 0°, and energy is kept.
fn coated(t: f64, r: f64, theta: f64) -> [f64; 2] {
    const CLEAR: [[f64; 5]; 2] = [[-0.0015, 3.355, -3.840, 1.460, 0.0288], [0.999, -0.563, 2.043, -2.532, 1.054]];
    const BRONZE: [[f64; 5]; 2] = [[-0.002, 2.813, -2.341, -0.05725, 0.599], [0.997, -1.868, 6.513, -7.862, 3.225]];
    if theta == 0.0 {
        return [t, r];
    }
    let cos = theta.to_radians().cos().max(0.0);
    let polynomial = |k: &[f64; 5]| k.iter().rev().fold(0.0, |sum, k| sum * cos + k);
    let [transmitted, kept] = if t > 0.645 { &CLEAR } else { &BRONZE };
    // The regression tabulates the sum of transmittance and the share of the way from R₀ to 1.
    let tau = polynomial(transmitted);
    let rho = polynomial(kept) - tau;
    let (t, r) = ((tau * t).clamp(0.0, 1.0), (r * (1.0 - rho) + rho).clamp(0.0, 1.0));
    match () {
        () if t + r <= 1.0 => [t, r],
        () if r >= t => [t, 1.0 - t],
        () => [1.0 - r, r],
    }
}

/// A length such as `16mm`, `1.2cm` or `0.016` (m).
///
/// # Errors
/// If it is none.
pub fn length(text: &str) -> Result<f64> {
    let (number, metres) = [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("m", 1.0)]
        .into_iter()
        .find_map(|(unit, metres)| Some((text.strip_suffix(unit)?, metres)))
        .unwrap_or((text, 1.0));
    number
        .trim()
        .parse::<f64>()
        .ok()
        .map(|v| v * metres)
        .filter(|v| v.is_finite() && *v >= 0.0)
        .ok_or_else(|| Error::new(format!("'{text}' is not a length")).help("for instance 16mm or 0.016 (metres)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bands(pane: &Pane) -> [Normal; 2] {
        let Values::Bands { visible, solar } = &pane.values else { panic!("two bands") };
        [*visible, *solar]
    }

    #[test]
    fn normal_incidence_gives_back_what_was_put_in_and_energy_is_kept() {
        for pane in ["clear_3mm", "clear_6mm"].map(|n| named(n).unwrap()) {
            for normal in bands(&pane) {
                let [t, _, f, b] = pane.at(&normal, 0.0);
                assert!((t - normal.transmittance).abs() < 1e-9 && (f - normal.reflectance_front).abs() < 1e-9 && f == b);
                for theta in 0..=90 {
                    let [t, _, f, _] = pane.at(&normal, f64::from(theta));
                    assert!(t >= 0.0 && f >= 0.0 && t + f <= 1.0 + 1e-12);
                }
                assert!(pane.at(&normal, 90.0)[2] > 0.999);
            }
        }
    }

    #[test]
    fn coated_glass_starts_at_its_normal_values_and_keeps_energy() {
        for t in [0.75, 0.3] {
            let normal = Normal { transmittance: t, reflectance_front: 0.12, reflectance_back: 0.1 };
            let values = Values::Bands { visible: normal, solar: normal };
            let pane = Pane { name: String::new(), thickness: 0.006, coated: true, values };
            assert_eq!(pane.at(&normal, 0.0), [t, t, 0.12, 0.1]);
            // The regression's own values near the normal are within its published 1.2 %.
            assert!((pane.at(&normal, 1.0)[0] - t).abs() < 0.012 * t);
            for theta in 0..=90 {
                let [t, _, f, b] = pane.at(&normal, f64::from(theta));
                assert!(t >= 0.0 && t + f.max(b) <= 1.0 + 1e-9, "{theta}: {t} {f} {b}");
            }
            assert!(pane.at(&normal, 90.0)[2] > 0.99 && pane.at(&normal, 60.0)[0] < 0.96 * t);
        }
    }

    #[test]
    fn an_absorption_free_slab_follows_fresnel() {
        // n = 1.5: one face 0.04, slab 2r/(1+r); at Brewster's angle half of the light passes freely.
        let r = 2.0 * 0.04 / 1.04;
        let brewster = 1.5f64.atan().to_degrees();
        let [t, reflected] = slab(1.0 - r, r, brewster);
        let s = ((1.5 * (brewster.to_radians().sin() / 1.5).asin().cos() - brewster.to_radians().cos())
            / (1.5 * (brewster.to_radians().sin() / 1.5).asin().cos() + brewster.to_radians().cos()))
        .powi(2);
        assert!((reflected - s / (1.0 + s)).abs() < 1e-9, "{reflected}");
        assert!((t + reflected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn descriptions_are_read_or_refused() {
        let pane = Pane::parse("tvis=.7,rvis=.1,rvis_back=.12,tsol=.4,rsol=.3,coated,thickness=6mm").unwrap();
        let [visible, solar] = bands(&pane);
        assert!(pane.coated && (pane.thickness - 0.006).abs() < 1e-12 && visible.reflectance_back == 0.12 && solar.reflectance_back == 0.3);
        assert_eq!(bands(&pane.flipped())[0].reflectance_front, 0.12);
        // Where the sun is not visible: (0.4 - 0.49 · 0.7) / 0.51.
        assert!((pane.normal(1.0).transmittance - 0.111_764_7).abs() < 1e-6 && pane.normal(0.5) == visible);
        for wrong in [
            "clear_7mm",
            "tvis=.7",
            "tvis=2,rvis=.1,tsol=.4,rsol=.3",
            "tvis=.9,rvis=.2,tsol=.4,rsol=.3",
            "x=1",
            "",
            "thickness=6furlongs",
            "no.dat",
        ] {
            assert!(Pane::parse(wrong).is_err(), "{wrong}");
        }
    }
}

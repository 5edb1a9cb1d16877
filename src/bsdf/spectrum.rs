//! Means over wavelengths as WINDOW and NFRC 300-2003 define them, and measured spectra of glass.
//!
//! *Visible* is weighted with illuminant D65 times the luminous efficiency of the CIE 1931 observer,
//! *Solar* with the direct irradiance of ASTM E891 at air mass 1.5; both by trapezoids. A layer of
//! which only the two means are known is split into a visible part, 0.38 to 0.78 µm, and the rest,
//! which then has `(solar − 0.49 visible) / 0.51`: WINDOW's way (`f` = 0.49 in its engine).

mod tables;

use super::transmission::xyz_to_rgb;
use crate::error::{Error, Result};
use crate::limits::GLASS_BYTES;
use crate::text;
use serde_json::Value;
use std::path::Path;
use tables::{D65, PHOTOPIC, RED_AND_BLUE, SOLAR, VISIBLE_START, VISIBLE_STEP};

/// Limits of the visible range, µm.
pub(crate) const VISIBLE_RANGE: [f64; 2] = [0.38, 0.78];
/// Share of solar energy that WINDOW takes to be visible when it splits two-band data.
pub(crate) const VISIBLE_SHARE: f64 = 0.49;

/// Value outside the visible range of a quantity with these visible and solar means.
pub(crate) fn beyond_visible(visible: f64, solar: f64) -> f64 {
    ((solar - VISIBLE_SHARE * visible) / (1.0 - VISIBLE_SHARE)).max(0.0)
}

/// Share of each of the ascending `wavelengths` (µm) in the visible and the solar mean of a quantity
/// that is known there, is linear between them and constant beyond them. Both sum to 1.
pub(crate) fn weights(wavelengths: &[f64]) -> [Vec<f64>; 2] {
    let visible: Vec<[f64; 2]> =
        D65.iter().zip(&PHOTOPIC).enumerate().map(|(k, (s, v))| [VISIBLE_START + k as f64 * VISIBLE_STEP, s * v]).collect();
    [visible.as_slice(), SOLAR.as_slice()].map(|spectrum| {
        let mut shares = vec![0.0; wavelengths.len()];
        for pair in spectrum.windows(2) {
            let half = (pair[1][0] - pair[0][0]) / 2.0;
            for [wavelength, power] in pair {
                let [(a, share_a), (b, share_b)] = between(wavelengths, *wavelength);
                shares[a] += half * power * share_a;
                shares[b] += half * power * share_b;
            }
        }
        let sum: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|s| *s /= sum);
        shares
    })
}

/// RGB of Radiance's primaries, as the CIE 1931 observer sees a surface of this spectrum under light of equal
/// energy: white is 1 1 1. `value` is that at a wavelength in nm, sampled at every nanometre of the visible range.
pub(crate) fn rgb(value: impl Fn(f64) -> f64) -> [f64; 3] {
    let observer = |k: usize| [RED_AND_BLUE[k][0], PHOTOPIC[2 * k], RED_AND_BLUE[k][1]];
    let (mut sum, mut white) = ([0.0; 3], [0.0; 3]);
    for nanometre in 380..=780 {
        let (k, share) = ((nanometre - 380) / 10, f64::from((nanometre - 380) % 10) / 10.0);
        let (below, above) = (observer(k as usize), observer(40.min(k as usize + 1)));
        let seen = value(f64::from(nanometre));
        for c in 0..3 {
            let response = below[c] + share * (above[c] - below[c]);
            sum[c] += response * seen;
            white[c] += response;
        }
    }
    let xyz: [f64; 3] = std::array::from_fn(|c| sum[c] / white[c]);
    xyz_to_rgb().map(|row| row.iter().zip(xyz).map(|(a, b)| a * b).sum())
}

/// The two neighbours of a wavelength and their shares in the value there.
fn between(wavelengths: &[f64], x: f64) -> [(usize, f64); 2] {
    let above = wavelengths.partition_point(|w| *w <= x);
    if above == 0 || above == wavelengths.len() {
        let end = above.saturating_sub(1);
        return [(end, 1.0), (end, 0.0)];
    }
    let (low, high) = (wavelengths[above - 1], wavelengths[above]);
    let share = (x - low) / (high - low);
    [(above - 1, 1.0 - share), (above, share)]
}

/// Measured transmittance and reflectances of a pane at normal incidence over the wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    wavelengths: Vec<f64>,
    /// Transmittance, reflectance of the front, of the back.
    values: Vec<[f64; 3]>,
}

impl Spectrum {
    /// A spectrum from rows of wavelength (µm), transmittance, front and back reflectance.
    ///
    /// # Errors
    /// Wavelengths that do not ascend or do not span the visible and solar ranges; values outside
    /// 0…1 or that sum to more than 1.
    pub fn new(rows: &[[f64; 4]]) -> Result<Self> {
        let wrong = |k: usize, what: String| Error::new(format!("row {} of the spectrum ({} µm): {what}", k + 1, rows[k][0]));
        for (k, row) in rows.iter().enumerate() {
            let [wavelength, t, front, back] = *row;
            if !(wavelength.is_finite() && wavelength > 0.0) || (k > 0 && wavelength <= rows[k - 1][0]) {
                return Err(wrong(k, "the wavelengths do not ascend".into()));
            }
            // Measurements overshoot by a per mille or two.
            if [t, front, back].iter().any(|v| !(-2e-3..=1.002).contains(v)) {
                return Err(wrong(k, "transmittance and reflectance must lie within 0…1".into()));
            }
            if t + front.max(back) > 1.01 {
                return Err(wrong(k, format!("transmittance and reflectance sum to {:.4}, more than 1", t + front.max(back))));
            }
        }
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
            return Err(Error::new("the spectrum has no rows"));
        };
        if first[0] > 0.3005 || last[0] < 2.4995 {
            return Err(Error::new(format!("the spectrum spans {} to {} µm", first[0], last[0]))
                .help("0.3 to 2.5 µm are needed for visible and solar values (NFRC 300)"));
        }
        let values = rows.iter().map(|r| [r[1], r[2], r[3]].map(|v| v.clamp(0.0, 1.0))).collect();
        Ok(Self { wavelengths: rows.iter().map(|r| r[0]).collect(), values })
    }

    /// Wavelengths of the rows, µm.
    pub fn wavelengths(&self) -> &[f64] {
        &self.wavelengths
    }

    /// Transmittance, front and back reflectance at a wavelength (µm), linear between rows.
    pub fn at(&self, wavelength: f64) -> [f64; 3] {
        let [(a, share_a), (b, share_b)] = between(&self.wavelengths, wavelength);
        std::array::from_fn(|k| share_a * self.values[a][k] + share_b * self.values[b][k])
    }

    /// Visible and solar means of transmittance, front and back reflectance.
    pub fn means(&self) -> [[f64; 3]; 2] {
        weights(&self.wavelengths)
            .map(|shares| std::array::from_fn(|k| self.values.iter().zip(&shares).map(|(v, s)| v[k] * s).sum::<f64>()))
    }

    /// The pane turned around.
    pub fn flipped(&self) -> Self {
        Self { wavelengths: self.wavelengths.clone(), values: self.values.iter().map(|[t, f, b]| [*t, *b, *f]).collect() }
    }
}

/// A spectrum with what its file says about the pane.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeasuredPane {
    /// Name of the product.
    pub name: String,
    /// Thickness, m.
    pub thickness: f64,
    /// Whether it is coated, laminated or has a film: not a slab of one glass.
    pub coated: bool,
    /// The measurements.
    pub spectrum: Spectrum,
}

/// Reads a spectral data file: the text format of Optics (LBNL, the IGDB's), or the JSON of the
/// IGSDB (versions 1 and 2).
///
/// # Errors
/// File and line of what is wrong.
pub(crate) fn read_pane(path: &Path) -> Result<MeasuredPane> {
    let size = std::fs::metadata(path).map_err(|e| Error::io(path, &e))?.len();
    if size > GLASS_BYTES {
        return Err(Error::new(format!("{} MiB are too much for the spectrum of a pane", size >> 20)).file(path));
    }
    let text = text::read(path, "the spectrum of a pane")?;
    let pane = if text.trim_start().starts_with('{') && serde_json::from_str::<Value>(&text).is_ok() {
        from_json(&text)
    } else {
        from_text(&text)
    };
    pane.map_err(|e| e.file(path))
}

/// Reads the text format of Optics: header lines `{ Key } value` or `{ Key: value }`, then rows of
/// wavelength, transmittance, front and back reflectance.
///
/// # Errors
/// The line of what is wrong.
pub(crate) fn from_text(text: &str) -> Result<MeasuredPane> {
    let mut pane = (String::new(), 0.0, false);
    let mut nanometres = false;
    let mut rows = Vec::new();
    for (number, line) in text.lines().enumerate().map(|(k, l)| (k + 1, l.trim())) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        if let Some((inside, after)) = line.strip_prefix('{').and_then(|l| l.split_once('}')) {
            let (key, value) = inside.split_once(':').map_or((inside, after), |(k, v)| (k, v));
            let (key, value) = (key.trim().to_ascii_lowercase(), value.trim());
            match key.as_str() {
                "thickness" => {
                    pane.1 = value
                        .parse::<f64>()
                        .ok()
                        .filter(|v| v.is_finite() && *v > 0.0)
                        .ok_or_else(|| Error::new(format!("'{value}' is not a thickness in mm")).line(number))?
                        / 1000.0;
                }
                "product name" => pane.0 = value.to_string(),
                "type" => pane.2 |= !is_monolithic(value),
                "coated side" => pane.2 |= !is_uncoated(value),
                k if k.contains("units") => nanometres |= value.to_ascii_lowercase().contains("nano"),
                _ => {}
            }
            continue;
        }
        let words = text::words(line).map_err(|e| e.line(number))?;
        let words: Vec<f64> = words.iter().map_while(|w| w.parse().ok().filter(|v: &f64| v.is_finite())).collect();
        let [wavelength, t, front, back] = words[..] else {
            return Err(Error::new(format!("'{}' is not a row of four numbers", line.chars().take(60).collect::<String>().escape_debug()))
                .line(number)
                .help("rows are: wavelength, transmittance, front and back reflectance"));
        };
        rows.push([wavelength, t, front, back]);
    }
    finish(pane, nanometres, rows)
}

/// Reads the JSON of the IGSDB.
///
/// # Errors
/// What is missing.
pub(crate) fn from_json(text: &str) -> Result<MeasuredPane> {
    let root: Value = serde_json::from_str(text).map_err(|e| Error::new(format!("damaged JSON: {e}")).line(e.line()))?;
    let text_of = |key: &str| root[key].as_str().unwrap_or_default().to_string();
    let measured = ["measured_data", "physical_properties"].into_iter().map(|k| &root[k]).find(|v| v.is_object()).unwrap_or(&Value::Null);
    let coated = !is_monolithic(&text_of("subtype")) || !is_uncoated(&text_of("coated_side"));
    let pane = (text_of("name"), number(&measured["thickness"]).unwrap_or(0.0) / 1000.0, coated);
    let nested = &measured["optical_properties"]["optical_data"]["angle_blocks"];
    let blocks = [&root["spectral_data"]["spectral_data"], &root["spectral_data"], &nested[0]["wavelength_data"]];
    let entries = blocks.into_iter().find_map(Value::as_array).ok_or_else(|| {
        Error::new("the file has no spectral data").field("spectral_data").help("download the product with its measurements from the IGSDB")
    })?;
    let row = |(k, entry): (usize, &Value)| -> Result<[f64; 4]> {
        let specular = &entry["specular"];
        let get = |keys: [&Value; 2]| {
            let wrong = || Error::new(format!("entry {} of the spectrum is incomplete or not a number", k + 1)).field("spectral_data");
            keys.into_iter().find_map(number).ok_or_else(wrong)
        };
        if ["tf", "tb", "rf", "rb"].iter().any(|k| number(&entry["diffuse"][*k]).unwrap_or(0.0) > 1e-3) {
            return Err(Error::new("the pane scatters light: its spectrum has diffuse parts")
                .field("spectral_data")
                .help("use its BSDF (XML) as a layer"));
        }
        Ok([
            get([&entry["wavelength"], &entry["w"]])?,
            get([&entry["T"], &specular["tf"]])?,
            get([&entry["Rf"], &specular["rf"]])?,
            get([&entry["Rb"], &specular["rb"]])?,
        ])
    };
    let rows: Vec<[f64; 4]> = entries.iter().enumerate().map(row).collect::<Result<_>>()?;
    finish(pane, false, rows)
}

fn finish((name, thickness, coated): (String, f64, bool), nanometres: bool, mut rows: Vec<[f64; 4]>) -> Result<MeasuredPane> {
    if nanometres || rows.last().is_some_and(|r| r[0] > 100.0) {
        rows.iter_mut().for_each(|r| r[0] /= 1000.0);
    }
    Ok(MeasuredPane { name, thickness, coated, spectrum: Spectrum::new(&rows)? })
}

/// A number, or a text that is one.
fn number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.as_str()?.trim().parse().ok()).filter(|v: &f64| v.is_finite())
}

fn is_monolithic(kind: &str) -> bool {
    ["", "monolithic", "interlayer"].iter().any(|k| kind.trim().eq_ignore_ascii_case(k))
}

fn is_uncoated(side: &str) -> bool {
    ["", "neither", "na", "n/a", "none"].iter().any(|k| side.trim().eq_ignore_ascii_case(k))
}

#[cfg(test)]
mod tests;

//! Window systems of several layers by the matrix layer calculation (Klems, ASHRAE Transactions
//! 100(1) 1994, "A new method for predicting the solar heat gain of complex fenestration
//! systems"; what WINDOW does).
//!
//! Layers are given from the outside to the inside. Between two neighbours light is reflected back
//! and forth; with matrices M = f Λ that map radiance per bin, the sum over all reflections is the
//! inverse of I − R R'. Because bins are indexed by the direction of travel, transmission and
//! reflection multiply without any renumbering.
//!
//! Layers select wavelengths, so the calculation is done wavelength by wavelength and averaged
//! afterwards ([`spectrum`]): at the wavelengths of measured panes; or, where all
//! layers have two bands only, for visible and for other light.

mod operator;
mod stack;
mod words;

pub use words::{LayerWords, read_layers};

use super::glass::{Pane, Values};
use super::spectrum::{self, VISIBLE_RANGE, VISIBLE_SHARE, beyond_visible};
use super::{Block, Blocks, Bsdf, Component, KlemsMatrix, projected_solid_angles};
use crate::bins::AngleBasis;
use crate::error::{Error, Result, Warnings};
use rayon::prelude::*;
use stack::{Matrices, Operators, stack};
use std::borrow::Cow;

/// One layer of a system.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// Glass.
    Pane(Pane),
    /// Anything with a BSDF: a shade, a film, a system.
    Scatterer(Box<Bsdf>),
}

impl From<Bsdf> for Layer {
    fn from(bsdf: Bsdf) -> Self {
        Layer::Scatterer(Box::new(bsdf))
    }
}

impl From<Pane> for Layer {
    fn from(pane: Pane) -> Self {
        Layer::Pane(pane)
    }
}

impl Layer {
    /// Name for messages.
    pub fn name(&self) -> &str {
        match self {
            Layer::Pane(pane) if !pane.name.is_empty() => &pane.name,
            Layer::Scatterer(bsdf) if !bsdf.name.is_empty() => &bsdf.name,
            _ => "layer",
        }
    }

    /// Thickness, m.
    pub fn thickness(&self) -> Option<f64> {
        match self {
            Layer::Pane(pane) => Some(pane.thickness),
            Layer::Scatterer(bsdf) => bsdf.thickness,
        }
    }

    /// The layer turned around, see [`flipped`].
    ///
    /// # Errors
    /// If it is a tensor tree.
    pub fn flipped(&self) -> Result<Self> {
        match self {
            Layer::Pane(pane) => Ok(Layer::Pane(pane.flipped())),
            Layer::Scatterer(bsdf) => flipped(bsdf).map(Layer::from),
        }
    }

    /// Whether there are visible and solar data.
    fn has(&self) -> [bool; 2] {
        match self {
            Layer::Pane(_) => [true; 2],
            Layer::Scatterer(bsdf) => [!bsdf.visible.is_empty(), !bsdf.solar.is_empty()],
        }
    }
}

/// A system made of layers.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// Scattering data of the whole, visible and solar.
    pub bsdf: Bsdf,
    /// Absorptance of each layer, from outside to inside, for visible and solar light.
    pub absorptance: [Vec<Absorptance>; 2],
}

/// Share of the light that one layer of a system absorbs.
#[derive(Debug, Clone, PartialEq)]
pub struct Absorptance {
    /// Per incident bin, light from the outside.
    pub front: Vec<f64>,
    /// Per incident bin, light from the room.
    pub back: Vec<f64>,
    /// Uniform diffuse light from the outside and from the room.
    pub hemispherical: [f64; 2],
}

/// Combines layers, outermost first, in the bands that all of them have. A band that only some
/// have is left out, with a warning. Other bases are brought to `basis`.
///
/// # Errors
/// No layers; a layer without transmission or reflection data in every band; layers whose
/// reflections would make up energy.
pub fn combine(layers: &[Layer], basis: &AngleBasis, warnings: &mut Warnings) -> Result<System> {
    let mut wanted = [true; 2];
    for (k, band) in BANDS.into_iter().enumerate() {
        if let Some(missing) = layers.iter().position(|l| !l.has()[k]) {
            wanted[k] = false;
            if layers.iter().any(|l| l.has()[k]) {
                let name = layers[missing].name();
                let message = format!("layer {} ({name}) has no {band} data; the system gets none", missing + 1);
                warnings.push(Error::new(message).field(band));
            }
        }
    }
    if wanted == [false; 2] {
        return Err(Error::new("no band is complete in all layers"));
    }
    combine_bands(layers, basis, wanted)
}

/// Combines layers, outermost first, for visible light alone.
///
/// # Errors
/// As [`combine`], and a layer without visible data.
pub fn combine_visible(layers: &[Layer], basis: &AngleBasis) -> Result<System> {
    if let Some(missing) = layers.iter().position(|l| !l.has()[0]) {
        return Err(Error::new(format!("layer {} ({}) has no data of wavelength Visible", missing + 1, layers[missing].name()))
            .help("use a file with Visible data"));
    }
    combine_bands(layers, basis, [true, false])
}

fn combine_bands(layers: &[Layer], basis: &AngleBasis, wanted: [bool; 2]) -> Result<System> {
    if layers.is_empty() {
        return Err(Error::new("a system needs at least one layer").help("name its layers from outside to inside"));
    }
    let prepared: Vec<Prepared> = layers
        .iter()
        .enumerate()
        .map(|(n, layer)| {
            Prepared::new(layer, basis, wanted).map_err(|(band, e)| e.field(format!("layer {} ({}), {band}", n + 1, layer.name())))
        })
        .collect::<Result<_>>()?;
    let mut sums = [0, 1].map(|_| Sums::new(basis.len(), layers.len()));
    // Few at a time bound the memory; their order is fixed, so the result is the same each time.
    for samples in samples(layers, wanted).chunks(16) {
        let found: Vec<_> = samples
            .par_iter()
            .map(|sample| {
                let operators: Vec<Cow<Operators>> = prepared.iter().map(|p| p.at(sample, basis)).collect();
                stack(&operators.iter().map(AsRef::as_ref).collect::<Vec<_>>(), basis)
            })
            .collect::<Result<_>>()?;
        for (sample, (whole, absorbed)) in samples.iter().zip(&found) {
            for (sum, share) in sums.iter_mut().zip(sample.shares).filter(|(_, share)| *share != 0.0) {
                sum.add(share, whole, absorbed);
            }
        }
    }
    let names: Vec<&str> = layers.iter().map(Layer::name).collect();
    let mut system = System { bsdf: Bsdf { name: names.join(" | "), ..Bsdf::default() }, absorptance: [Vec::new(), Vec::new()] };
    for (k, sum) in sums.into_iter().enumerate().filter(|(k, _)| wanted[*k]) {
        let (blocks, absorptance) = sum.finish(basis);
        *system.bsdf.band_mut(BANDS[k]).expect("a band's name") = blocks;
        system.absorptance[k] = absorptance;
    }
    Ok(system)
}

const BANDS: [&str; 2] = ["Visible", "Solar"];

/// A wavelength at which the system is calculated.
struct Sample {
    /// µm.
    wavelength: f64,
    /// In the visible and the solar mean.
    shares: [f64; 2],
}

impl Sample {
    fn is_visible(&self) -> bool {
        (VISIBLE_RANGE[0]..=VISIBLE_RANGE[1]).contains(&self.wavelength)
    }
}

/// Wavelengths, with their shares in the bands that are wanted.
fn samples(layers: &[Layer], wanted: [bool; 2]) -> Vec<Sample> {
    let mut wavelengths: Vec<f64> = Vec::new();
    let mut bands = false;
    for layer in layers {
        match layer {
            Layer::Pane(Pane { values: Values::Spectral(spectrum), .. }) => wavelengths.extend(spectrum.wavelengths()),
            _ => bands = true,
        }
    }
    let masked = |shares: [f64; 2]| [0, 1].map(|k| if wanted[k] { shares[k] } else { 0.0 });
    if wavelengths.is_empty() {
        let [visible, beyond] = [(0.55, [1.0, VISIBLE_SHARE]), (1.0, [0.0, 1.0 - VISIBLE_SHARE])];
        let all = [visible, beyond].map(|(wavelength, shares)| Sample { wavelength, shares: masked(shares) });
        return all.into_iter().filter(|s| s.shares != [0.0; 2]).collect();
    }
    if bands {
        // Steps where two-band layers have them.
        let step = 1e-6;
        wavelengths.extend([VISIBLE_RANGE[0] - step, VISIBLE_RANGE[0], VISIBLE_RANGE[1], VISIBLE_RANGE[1] + step]);
    }
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let [visible, solar] = spectrum::weights(&wavelengths);
    let all = wavelengths
        .into_iter()
        .zip(visible.into_iter().zip(solar))
        .map(|(wavelength, (v, s))| Sample { wavelength, shares: masked([v, s]) });
    all.filter(|s| s.shares != [0.0; 2]).collect()
}

/// A layer, ready for any wavelength.
enum Prepared<'a> {
    /// Calculated anew for each wavelength.
    Spectral(&'a Pane),
    /// In and out of the visible range.
    Bands(Box<[Operators; 2]>),
}

impl<'a> Prepared<'a> {
    fn new(layer: &'a Layer, basis: &AngleBasis, wanted: [bool; 2]) -> std::result::Result<Self, (&'static str, Error)> {
        let bands = match layer {
            Layer::Pane(pane) if matches!(pane.values, Values::Spectral(_)) => return Ok(Prepared::Spectral(pane)),
            Layer::Pane(pane) => [0.55, 1.0].map(|w| Operators::of_pane(pane, &pane.normal(w), basis)),
            Layer::Scatterer(bsdf) => {
                let matrices = |k: usize| Matrices::new(bsdf.bands()[k].1, basis).map_err(|e| (BANDS[k], e));
                let has = layer.has();
                match wanted {
                    [_, true] if has[0] => {
                        let (visible, solar) = (matrices(0)?, matrices(1)?);
                        [visible.operators(), visible.combined(&solar, beyond_visible).operators()]
                    }
                    [_, true] => {
                        let solar = matrices(1)?.operators();
                        [solar.clone(), solar]
                    }
                    _ => {
                        let visible = matrices(0)?.operators();
                        [visible.clone(), visible]
                    }
                }
            }
        };
        Ok(Prepared::Bands(Box::new(bands)))
    }

    fn at(&self, sample: &Sample, basis: &AngleBasis) -> Cow<'_, Operators> {
        match self {
            Prepared::Spectral(pane) => Cow::Owned(Operators::of_pane(pane, &pane.normal(sample.wavelength), basis)),
            Prepared::Bands(bands) => Cow::Borrowed(&bands[usize::from(!sample.is_visible())]),
        }
    }
}

/// Weighted sums over wavelengths.
struct Sums {
    /// f Λ in the order of [`Component::ALL`].
    matrices: [Vec<f64>; 4],
    /// Per layer and side.
    absorbed: Vec<[Vec<f64>; 2]>,
}

impl Sums {
    fn new(n: usize, layers: usize) -> Self {
        Self { matrices: std::array::from_fn(|_| vec![0.0; n * n]), absorbed: vec![[vec![0.0; n], vec![0.0; n]]; layers] }
    }

    fn add(&mut self, share: f64, whole: &Operators, absorbed: &[[Vec<f64>; 2]]) {
        for (sum, operator) in self.matrices.iter_mut().zip([&whole.tf, &whole.tb, &whole.rf, &whole.rb]) {
            operator.add_to(share, sum);
        }
        for (sums, values) in self.absorbed.iter_mut().flatten().zip(absorbed.iter().flatten()) {
            sums.iter_mut().zip(values).for_each(|(s, v)| *s += share * v);
        }
    }

    fn finish(self, basis: &AngleBasis) -> (Blocks, Vec<Absorptance>) {
        let lambda = projected_solid_angles(basis);
        let mut blocks = Blocks::default();
        for (component, mut values) in Component::ALL.into_iter().zip(self.matrices) {
            values.iter_mut().enumerate().for_each(|(k, v)| *v /= lambda[k % lambda.len()]);
            let matrix = KlemsMatrix::new(basis.clone(), basis.clone(), values).expect("square");
            *blocks.slot(component) = Some(Block::Klems(matrix));
        }
        let mean = |v: &[f64]| v.iter().zip(&lambda).map(|(a, l)| a * l).sum::<f64>() / std::f64::consts::PI;
        let absorptance = self
            .absorbed
            .into_iter()
            .map(|[front, back]| Absorptance { hemispherical: [mean(&front), mean(&back)], front, back })
            .collect();
        (blocks, absorptance)
    }
}

/// A layer turned around: what was outside is inside. Light that travelled into the room now
/// travels out; seen in the window's frame the layer is turned about the vertical axis, so the x
/// of every direction changes sign.
pub fn flipped(layer: &Bsdf) -> Result<Bsdf> {
    let mut turned = Bsdf { geometry: None, name: format!("{} (flipped)", layer.name), ..layer.clone() };
    for (band, blocks) in layer.bands() {
        let mut new = Blocks::default();
        for (component, block) in blocks.iter() {
            let Block::Klems(m) = block else {
                return Err(
                    Error::new("a tensor tree cannot be flipped").help("convert it first: lucarne bsdf convert FILE.xml --to klems:full")
                );
            };
            let target = match component {
                Component::TransmissionFront => Component::TransmissionBack,
                Component::TransmissionBack => Component::TransmissionFront,
                Component::ReflectionFront => Component::ReflectionBack,
                Component::ReflectionBack => Component::ReflectionFront,
            };
            let mirror = |basis: &AngleBasis| -> Vec<usize> {
                let mirrored = |bin| {
                    let c = basis.centre(bin);
                    basis.bin_of(glam::DVec3::new(-c.x, c.y, c.z))
                };
                (0..basis.len()).map(mirrored).collect()
            };
            let (on_in, on_out) = (mirror(m.incident()), mirror(m.outgoing()));
            let n = m.incident().len();
            let values = (0..m.values().len()).map(|k| m.at(on_out[k / n], on_in[k % n])).collect();
            *new.slot(target) = Some(Block::Klems(KlemsMatrix::new(m.incident().clone(), m.outgoing().clone(), values)?));
        }
        if let Some(slot) = turned.band_mut(band) {
            *slot = new;
        }
    }
    Ok(turned)
}

#[cfg(test)]
mod pywincalc;

#[cfg(test)]
mod tests;

//! Layers in words, as `lucarne bsdf layer` and project files name them.

use super::Layer;
use crate::bsdf::glass::{Pane, length};
use crate::error::{Error, Result, Warnings};
use std::path::Path;

/// Layers that words name.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerWords {
    /// From outside to inside, without the gaps.
    pub layers: Vec<Layer>,
    /// Of all layers and gaps, m; `None` if one of them is not known.
    pub thickness: Option<f64>,
}

/// Reads layers from outside to inside: BSDF files, glass (`glass:clear_6mm`, `glass:FILE`, `glass:tvis=…`; see
/// [`Pane::parse`]) and gaps (`gap=16mm`, which add to the thickness alone). `flip:` turns a layer around. Files are
/// relative to `folder`.
///
/// # Errors
/// Faulty words and files, and words without a layer.
pub fn read_layers(words: &[String], folder: &Path, warnings: &mut Warnings) -> Result<LayerWords> {
    let (mut layers, mut thickness) = (Vec::new(), Some(0.0));
    let mut add = |t: Option<f64>| thickness = thickness.zip(t).map(|(a, b): (f64, f64)| a + b);
    for word in words {
        if let Some(gap) = word.strip_prefix("gap=") {
            add(Some(length(gap).map_err(|e| e.field(word.clone()))?));
            continue;
        }
        let (plain, turn) = word.strip_prefix("flip:").map_or((word.as_str(), false), |w| (w, true));
        let layer: Layer = match plain.strip_prefix("glass:") {
            Some(glass) => Pane::parse_in(folder, glass)?.into(),
            None => crate::bsdf::read(&folder.join(plain), warnings)?.into(),
        };
        add(layer.thickness());
        layers.push(if turn { layer.flipped().map_err(|e| e.field(word.clone()))? } else { layer });
    }
    if layers.is_empty() {
        let what = if words.is_empty() { "there are no layers" } else { "there are only gaps" };
        return Err(Error::new(what).help("name at least one layer"));
    }
    Ok(LayerWords { layers, thickness })
}

//! Saving the hemispheres as PNG or SVG: the drawing of `lucarne bsdf plot`.

use super::disc::{direction, limits};
use super::model::{BsdfFile, View, largest};
use lucarne::bsdf::Block;
use lucarne::image::hemisphere::{Content, Hemisphere, HemispherePlot, Patch};
use lucarne::{Error, Result};
use std::path::Path;

/// Writes the shown component of all files, side by side.
pub fn write(files: &[&BsdfFile], view: &View, path: &Path) -> Result<()> {
    let incident = direction(view.incident);
    let shown: Vec<(&BsdfFile, &Block)> = files.iter().filter_map(|f| Some((*f, view.block(f)?))).collect();
    if shown.is_empty() {
        return Err(Error::new("there is no distribution to save"));
    }
    let top = shown.iter().map(|(_, b)| largest(b, view.incident)).fold(0.0, f64::max);
    let functions: Vec<_> = shown.iter().map(|(f, b)| (*f, *b, move |t: f64, p: f64| b.evaluate(direction([t, p]), incident))).collect();
    let hemispheres = functions
        .iter()
        .map(|(file, block, function)| Hemisphere {
            title: format!("{}: {:.4} of the light", file.name(), block.direct_hemispherical(incident)),
            content: match block {
                Block::Klems(m) => {
                    let from = m.incident().bin_of(incident);
                    let patch = |o: usize| {
                        let (theta, phi) = limits(m.outgoing(), o);
                        Patch { theta, phi, value: m.at(o, from) }
                    };
                    Content::Patches((0..m.outgoing().len()).map(patch).collect())
                }
                Block::Tree(_) => Content::Function(function),
            },
            mark: Some(view.incident),
        })
        .collect();
    let [theta, phi] = view.incident;
    let plot = HemispherePlot {
        hemispheres,
        columns: 2,
        title: format!("{}: light travelling along θ {theta:.1}°, φ {phi:.1}°", view.component.xml_name()),
        label: "1/sr".into(),
        palette: view.palette,
        scale: view.scale.scale(top),
    };
    plot.draw()?.write(path, 2.0)
}

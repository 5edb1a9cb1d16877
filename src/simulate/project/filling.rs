//! What a window, or a state of one, is made of, and what suns pass in it.

use super::table::{Place, Table};
use crate::error::Result;
use crate::scene::Pane;
use std::path::PathBuf;

/// What fills a window.
#[derive(Debug, Clone, PartialEq)]
pub enum Filling {
    /// Scattering data, XML.
    Bsdf(PathBuf),
    /// A clear pane of this visible transmittance at normal incidence.
    Glass(f64),
    /// The glass that the window's surface has in the scene files.
    SceneGlass,
    /// A pane of a model.
    Pane(Pane),
    /// Layers from outside to inside, in the words of `lucarne bsdf layer`.
    Layers(Vec<String>),
    /// Scattering data so far (0…1) on the way from one file's to another's, in every value.
    Interpolated([PathBuf; 2], f64),
}

impl Filling {
    /// Its files of scattering data; none of glass and layers.
    pub fn files(&self) -> &[PathBuf] {
        match self {
            Self::Bsdf(file) => std::slice::from_ref(file),
            Self::Interpolated(files, _) => files,
            Self::Glass(_) | Self::SceneGlass | Self::Pane(_) | Self::Layers(_) => &[],
        }
    }

    /// Whether it is a pane whose light is that of a formula.
    pub fn is_glass(&self) -> bool {
        matches!(self, Self::Glass(_) | Self::SceneGlass | Self::Pane(_))
    }

    /// Whether it mirrors light and lets it pass, but does not scatter: panes of glass alone.
    pub fn is_clear(&self) -> bool {
        let of_glass = |word: &String| word.strip_prefix("flip:").unwrap_or(word).starts_with("glass:") || word.starts_with("gap=");
        match self {
            Self::Layers(words) => words.iter().all(of_glass),
            other => other.is_glass(),
        }
    }
}

/// Scattering data that the sun is traced through in place of a shade.
#[derive(Debug, Clone, PartialEq)]
pub struct SunData {
    /// Their file, XML of any kind; `None`: the data that the window is made of.
    pub file: Option<PathBuf>,
    /// Whether a through-peak is a clear view, as of Radiance's `aBSDF`; else it fills its bin or cell, as of `BSDF`.
    pub sees_peak: bool,
}

impl SunData {
    /// Data of a file, with the clear view through their peak.
    pub fn of_file(file: PathBuf) -> Self {
        Self { file: Some(file), sees_peak: true }
    }
}

/// What the sun is traced through, of a window or one of its states.
pub(super) fn ways(table: &mut Table<'_, '_>) -> Result<(Option<PathBuf>, Option<SunData>)> {
    let shade = table.path("shade")?;
    let tree = table.path_or_word::<()>("tensor_tree", "own")?.map(|way| SunData { file: way.ok(), sees_peak: true });
    let data = match (tree, table.boolean("peak")?) {
        (Some(data), Some(sees_peak)) => Some(SunData { sees_peak, ..data }),
        (None, Some(_)) => {
            return Err(table
                .error("peak", "says how the sun passes a 'tensor_tree', but there is none")
                .help("add tensor_tree = \"own\", the window's own scattering data, or the name of a file; or take 'peak' out"));
        }
        (data, None) => data,
    };
    Ok((shade, data))
}

/// Ways of the sun that contradict each other, or what the window is made of.
pub(super) fn check_ways(table: &Table<'_, '_>, filling: &Filling, shade: bool, tensor_tree: bool) -> Result<()> {
    if shade && tensor_tree {
        return Err(table
            .error("tensor_tree", "the sun is traced either through a 'shade' or through a 'tensor_tree'")
            .help("keep the shade if there are slats or panes to trace, the tensor tree if there are only measured data"));
    }
    match [("shade", shade), ("tensor_tree", tensor_tree)].iter().find(|(_, given)| *given) {
        Some((key, _)) if filling.is_glass() => {
            Err(table.error(key, format!("the sun is traced through the pane of 'glass' itself, so there is no '{key}' beside it")).help(
                "take it out; for blinds behind the pane give the BSDF of both together (lucarne bsdf generate, lucarne bsdf layer) and their shade",
            ))
        }
        _ => Ok(()),
    }
}

/// What a `[[window]]` or a state of one is made of, by the one of its keys that says so; of a window with states they do.
pub(super) fn filling(table: &mut Table<'_, '_>, has_states: bool) -> Result<(Filling, Place)> {
    // All keys are asked for, so that they are known.
    let given = [
        ("bsdf", table.path("bsdf")?.map(Filling::Bsdf)),
        ("glass", table.number_or_choice("glass", 0.0..=1.0, &["scene"])?.map(|g| g.map_or(Filling::SceneGlass, Filling::Glass))),
        ("glazing", table.strings("glazing", "[\"glass:clear_6mm\", \"gap=16mm\", \"film.xml\"]")?.map(Filling::Layers)),
        ("interpolate", table.files_and_fraction("interpolate")?.map(|(files, fraction)| Filling::Interpolated(files, fraction))),
        (if table.has("state") { "state" } else { "states" }, has_states.then_some(Filling::Layers(Vec::new()))),
    ];
    let mut given = given.into_iter().filter_map(|(key, filling)| Some((key, filling?)));
    const HELP: &str = "glass = 0.65 is a clear pane of that transmittance (\"scene\": that of the scene's glass), bsdf = \"….xml\" scattering \
                        data, glazing = [\"glass:clear_6mm\", …] layers, interpolate = [\"a.xml\", \"b.xml\", 0.5] data between two";
    let keys = ["bsdf", "glass", "glazing", "interpolate", "states"];
    let Some((key, filling)) = given.next() else {
        return Err(table.missing_all(&keys, "does not say what the window is made of", HELP));
    };
    if let Some((other, _)) = given.next() {
        let error = table.error(key, format!("a window has either '{key}' or '{other}'"));
        return Err(match other {
            "states" if key == "bsdf" => error.help("put this file first in 'states' and take 'bsdf' out"),
            "state" => error.help("make it a [[window.state]] of its own"),
            _ => error.help(format!("keep the one that tells what the window is made of: {HELP}")),
        });
    }
    if let Filling::Glass(transmittance) = filling {
        let place = table.place(key);
        Pane::of_transmittance([transmittance; 3]).map_err(|e| place.of(e))?;
    }
    Ok((filling, table.place(key)))
}

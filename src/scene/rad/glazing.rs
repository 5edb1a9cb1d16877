//! Panes that are not `glass`: `BRTDfunc` of constants and of the published function files for glazing, and the
//! faces of refracting solids.
//!
//! They come to lobes whose shares are those at normal incidence. Towards grazing their reflection rises by
//! exp(−5.85 cos θ) of the rest, as Radiance's files for fritted and low-E glazing have it.

use super::patterns::constant;
use super::shares::{bounded, needs, two_faced};
use super::syntax::{Object, shortened};
use crate::error::{Error, Result};
use crate::scene::{Lobes, MaterialKind};

/// Published files that `BRTDfunc` uses for panes.
const PUBLISHED: [&str; 3] = ["window.cal", "glaze1.cal", "glaze2.cal"];

/// What a ray along the normal from the front or the back meets.
struct Incidence<'a> {
    object: &'a Object,
    file: &'a str,
    front: bool,
    pattern: [f64; 3],
}

impl Incidence<'_> {
    /// Value of a formula.
    fn value(&self, formula: &str) -> Result<Option<f64>> {
        constant(self.object, formula, &|name, arguments| self.known(name, arguments))
    }

    /// Names that Radiance gives every material, and those of the published files, at normal incidence: there
    /// nothing is added to reflection.
    fn known(&self, name: &str, arguments: &[f64]) -> Option<f64> {
        let argument = |n: usize| self.object.reals.get(n - 1).copied();
        let channel = |name: &str| ["r", "g", "b"].iter().position(|c| name.to_ascii_lowercase().starts_with(c));
        match (name, arguments) {
            ("Rdot" | "RdotP", []) if self.file != "." => return Some(if self.front { 1.0 } else { -1.0 }),
            ("CrP" | "CgP" | "CbP", []) => return ["CrP", "CgP", "CbP"].iter().position(|n| *n == name).map(|c| self.pattern[c]),
            _ => {}
        }
        match (self.file, name, arguments) {
            ("window.cal", _, []) => {
                let (letter, kind) = name.split_once(['_'])?;
                let c = channel(letter.strip_prefix(['r', 't'])?)?;
                match (letter.as_bytes().first()?, kind) {
                    (b't', "clear" | "bronze") => Some(self.pattern[c]),
                    (b'r', "clear" | "bronze") => Some(self.pattern[c] * argument(if self.front { 10 } else { 13 } + c)?),
                    _ => None,
                }
            }
            ("glaze1.cal", _, []) => {
                let clear_side = argument(10)? * if self.front { 1.0 } else { -1.0 } > 0.0;
                let mut words = name.split('_');
                let (way, kind, c) = (words.next()?, words.next()?, channel(words.next()?)?);
                match (way, kind) {
                    ("sr", "frit") => Some(GLASS_REFLECTANCE * if clear_side { 1.0 } else { 1.0 - argument(11)? }),
                    ("st", "frit") => Some(GLASS_TRANSMITTANCE * (1.0 - argument(11)?)),
                    ("sr", "clear") => argument(if clear_side { 11 } else { 14 } + c),
                    ("st", "clear") => argument(17 + c),
                    _ => None,
                }
            }
            ("glaze2.cal", "rclr", []) => Some(GLASS_REFLECTANCE),
            ("glaze2.cal", "tclr", []) => Some(GLASS_TRANSMITTANCE),
            ("glaze2.cal", "fr" | "ft", [share]) => Some(*share),
            ("glaze2.cal", "cr", [front, through, behind]) => Some(front + through * through * behind),
            _ => None,
        }
    }
}

/// Clear glass of 6 mm, as the published files have it.
const GLASS_REFLECTANCE: f64 = 0.076;
const GLASS_TRANSMITTANCE: f64 = 0.883;

/// `BRTDfunc`, if its shares are constant or those of a published file for glazing.
///
/// # Errors
/// Other function files; scattering of its own; faces that differ in diffuse reflection.
pub(super) fn of_functions(object: &Object, pattern: [f64; 3], warn: &mut dyn FnMut(Error)) -> Result<MaterialKind> {
    needs(
        object,
        10,
        9,
        "strings: specular reflectance (3), transmittance (3), scattering (3), functions; reals: diffuse reflectance of front and back, diffuse transmittance (3 each)",
    )?;
    if let Some(other) = object.strings[6..9].iter().find(|s| s.parse() != Ok(0.0)) {
        return Err(Error::new(format!("its scattering '{}' towards light sources is not known here", shortened(other)))
            .help("replace it by a `plastic`, `metal` or `trans` that fits its mean behaviour, or make it a window with a BSDF file"));
    }
    let named = object.strings[9].rsplit('/').next().unwrap_or_default();
    let file = PUBLISHED.into_iter().find(|p| *p == named).unwrap_or(".");
    let shares = |front: bool, from: usize| -> Result<[f64; 3]> {
        let incidence = Incidence { object, file, front, pattern };
        let mut shares = [0.0; 3];
        for (share, formula) in shares.iter_mut().zip(&object.strings[from..]) {
            *share = incidence.value(formula)?.ok_or_else(|| {
                Error::new(format!("'{}' is neither constant nor of a function file that is known here", shortened(formula))).help(format!(
                    "write numbers for its normal incidence, or use one of {}; or make it a window with a BSDF file",
                    PUBLISHED.join(", ")
                ))
            })?;
        }
        Ok(shares)
    };
    let mean = |[a, b]: [[f64; 3]; 2]| -> [f64; 3] { std::array::from_fn(|c| (a[c] + b[c]) / 2.0) };
    let reflected = [shares(true, 0)?, shares(false, 0)?];
    let transmitted = mean([shares(true, 3)?, shares(false, 3)?]);
    let colored = |from: usize| -> [f64; 3] { std::array::from_fn(|c| object.reals[from + c] * pattern[c]) };
    if object.reals[0..3] != object.reals[3..6] {
        return Err(two_faced());
    }
    let lobes = Lobes {
        diffuse: colored(0),
        diffuse_transmitted: colored(6),
        specular: mean(reflected),
        specular_transmitted: transmitted,
        roughness: 0.0,
    };
    let kind = bounded(lobes)?;
    if lobes.specular != [0.0; 3] || lobes.specular_transmitted != [0.0; 3] {
        let faces = if reflected[0] == reflected[1] {
            String::new()
        } else {
            format!(", the mean of its front's {} and its back's {}", triple(reflected[0]), triple(reflected[1]))
        };
        warn(
            Error::new(format!(
                "it is taken as a pane that transmits {} and reflects {}{faces} at normal incidence",
                triple(transmitted),
                triple(lobes.specular)
            ))
            .help("towards grazing incidence its reflection rises as that of glass; a BSDF file tells it exactly"),
        );
    }
    Ok(kind)
}

fn triple(c: [f64; 3]) -> String {
    format!("{:.3} {:.3} {:.3}", c[0], c[1], c[2])
}

/// A face of a `dielectric` or `interface`: it reflects as Fresnel has it and lets the rest pass undeflected. Two
/// parallel faces are a pane of the right transmittance.
///
/// # Errors
/// Missing arguments, refraction indices below 1.
pub(super) fn refracting(object: &Object, pattern: [f64; 3], warn: &mut dyn FnMut(Error)) -> Result<MaterialKind> {
    let between = object.kind.word() == "interface";
    let meaning = if between {
        "transmittance per length (3) and index of the material in front, the same of the one behind"
    } else {
        "transmittance per length (3), refraction index, Hartmann's constant"
    };
    needs(object, 0, if between { 8 } else { 5 }, meaning)?;
    let r = &object.reals;
    let (index, behind) = (r[3], if between { r[7] } else { 1.0 });
    if !(index >= 1.0 && behind >= 1.0) {
        return Err(Error::new(format!("the refraction index is {}", index.min(behind))).help("give an index of 1 or more"));
    }
    let reflectance = ((index - behind) / (index + behind)).powi(2);
    let tinted = |from: usize| r[from..from + 3].iter().any(|t| *t < 1.0);
    let absorbs = tinted(0) || (between && tinted(4));
    let lost = if absorbs { ", and its absorption is left out" } else { "" };
    warn(
        Error::new(format!("each of its faces is taken as a sheet that reflects {:.2} % and lets the rest pass undeflected{lost}", 100.0 * reflectance))
            .help("panes of it transmit as they should; replace lenses, prisms and thick or tinted bodies by a window with a BSDF file, and panes by one polygon of `glass`"),
    );
    bounded(Lobes { specular: [reflectance; 3], specular_transmitted: pattern.map(|p| p * (1.0 - reflectance)), ..Lobes::default() })
}

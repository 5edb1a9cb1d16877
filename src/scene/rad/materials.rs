//! What the materials of `.rad` files come to.

use super::definition::{Definition, Meaning};
use super::glazing;
use super::shares::{bounded, needs, two_faced};
use super::syntax::Object;
use super::types::MaterialType;
use crate::error::{Error, Result, Warnings};
use crate::scene::{Lobes, MaterialKind};

/// How a name among a material's arguments is looked up.
pub(super) type Named<'a> = &'a mut dyn FnMut(&str, &mut Warnings) -> Result<Meaning>;

/// The material of a definition, whose colour patterns have multiplied by `pattern`.
///
/// # Errors
/// Arguments that are missing or out of range; what only function files tell.
pub(super) fn kind(
    kind: MaterialType,
    definition: &Definition,
    pattern: [f64; 3],
    named: Named,
    warnings: &mut Warnings,
) -> Result<MaterialKind> {
    let object = definition.object();
    match kind {
        MaterialType::Plastic2 | MaterialType::Metal2 | MaterialType::Trans2 | MaterialType::Ashik2 => {
            isotropic(kind, definition, pattern, warnings)
        }
        MaterialType::BrtdFunc => glazing::of_functions(object, pattern, &mut |e| warnings.push(object.at(e, definition.file()))),
        MaterialType::WgmdFunc => separate_lobes(definition, pattern, named, warnings),
        MaterialType::Dielectric | MaterialType::Interface => {
            glazing::refracting(object, pattern, &mut |e| warnings.push(object.at(e, definition.file())))
        }
        MaterialType::Spotlight => {
            needs(object, 0, 7, "red green blue angle and the direction (3)")?;
            Ok(MaterialKind::Light { radiance: [0, 1, 2].map(|i| object.reals[i].max(0.0)) })
        }
        MaterialType::Illum | MaterialType::MixFunc => Ok(MaterialKind::Void),
        common_kind => common(common_kind, definition, pattern, warnings),
    }
}

/// Materials whose highlight is longer one way than the other, with the round one of the same height.
fn isotropic(kind: MaterialType, definition: &Definition, pattern: [f64; 3], warnings: &mut Warnings) -> Result<MaterialKind> {
    let object = definition.object();
    let orientation = "strings ux uy uz functions; reals ";
    let (count, meaning) = match kind {
        MaterialType::Ashik2 => (8, "diffuse colour (3), specular colour (3), u-power, v-power"),
        MaterialType::Trans2 => (8, "red green blue specularity u-roughness v-roughness transmissivity transmitted-specularity"),
        _ => (6, "red green blue specularity u-roughness v-roughness"),
    };
    needs(object, 4, count, &format!("{orientation}{meaning}"))?;
    let r = &object.reals;
    if let Some(v) = r[3..count].iter().find(|v| **v < 0.0) {
        return Err(Error::new(format!("the argument {v} is negative")).help("fractions, roughness and powers start at 0"));
    }
    let fraction = |v: f64| v.clamp(0.0, 1.0);
    let color = |from: usize| -> [f64; 3] { std::array::from_fn(|c| fraction(r[from + c] * pattern[c])) };
    // A lobe of cos^n about the mirror's half vector has the spread of slopes √(2 / n).
    let (alike, roughness) = if kind == MaterialType::Ashik2 {
        let power = ((r[6] + 1.0) * (r[7] + 1.0)).sqrt() - 1.0;
        (r[6] == r[7], (2.0 / power.max(0.1)).sqrt())
    } else {
        (r[4] == r[5], (r[4] * r[5]).sqrt())
    };
    if !alike {
        let message =
            format!("its highlight is taken as round, of roughness {roughness:.4}: the same peak, spread alike in all directions");
        warnings.push(
            object.at(
                Error::new(message).help("the amount of light is right; brushed surfaces throw it across their grain"),
                definition.file(),
            ),
        );
    }
    Ok(match kind {
        MaterialType::Ashik2 => bounded(Lobes { diffuse: color(0), specular: color(3), roughness, ..Lobes::default() })?,
        MaterialType::Trans2 => MaterialKind::Trans {
            color: color(0),
            specularity: fraction(r[3]),
            roughness,
            transmissivity: fraction(r[6]),
            transmitted_specularity: fraction(r[7]),
        },
        MaterialType::Metal2 => MaterialKind::Metal { color: color(0), specularity: fraction(r[3]), roughness },
        _ => MaterialKind::Plastic { color: color(0), specularity: fraction(r[3]), roughness },
    })
}

/// `WGMDfunc` of constants: a trans of which each part has a pattern of its own.
fn separate_lobes(definition: &Definition, pattern: [f64; 3], named: Named, warnings: &mut Warnings) -> Result<MaterialKind> {
    let object = definition.object();
    needs(
        object,
        13,
        9,
        "strings: pattern, share and two roughnesses of specular reflection, the same of specular transmission, \
        pattern of diffuse transmission, ux uy uz functions; reals: diffuse reflection of front and back and diffuse transmission (3 each)",
    )?;
    let number = |i: usize| -> Result<f64> {
        let value = super::patterns::constant(object, &object.strings[i], &|_, _| None)?;
        value.filter(|v| *v >= 0.0).ok_or_else(|| {
            Error::new(format!("'{}' is not a constant of 0 or more", super::syntax::shortened(&object.strings[i])))
                .help("what depends on the direction needs its function file, which is not read; write its value at normal incidence, or use a BSDF file")
        })
    };
    let (reflected, transmitted) = (number(1)?, number(5)?);
    let [ru, rv, tu, tv] = [number(2)?, number(3)?, number(6)?, number(7)?];
    let mut part = |i: usize| -> Result<[f64; 3]> {
        if object.strings[i] == "inherit" {
            return Ok(pattern);
        }
        let meaning = named(&object.strings[i], warnings)?;
        if meaning.material.is_some() {
            return Err(Error::new(format!("'{}' is a material, where a pattern should stand", object.strings[i]))
                .help("name a pattern, `void` or `inherit`"));
        }
        Ok(meaning.pattern)
    };
    let (specular, through, diffuse_through) = (part(0)?, part(4)?, part(8)?);
    let times = |c: [f64; 3], f: f64| c.map(|v| v * f);
    let reals = |i: usize, by: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| object.reals[i + c] * by[c]) };
    if object.reals[0..3] != object.reals[3..6] {
        return Err(two_faced());
    }
    // Each part may have its own roughness, if both have something to scatter.
    let [rough_reflection, rough_transmission] = [(ru * rv).sqrt(), (tu * tv).sqrt()];
    let (has_reflection, has_transmission) = (reflected > 0.0, transmitted > 0.0);
    if has_reflection && has_transmission && rough_reflection != rough_transmission {
        return Err(Error::new(format!(
            "specular reflection of roughness {rough_reflection} and transmission of roughness {rough_transmission} in one material are not known here"
        ))
        .help("give both the same roughness, or use a BSDF file"));
    }
    if (has_reflection && ru != rv) || (has_transmission && tu != tv) {
        let message = "its highlight is taken as round: the same peak, spread alike in all directions";
        warnings.push(
            object.at(
                Error::new(message).help("the amount of light is right; brushed surfaces throw it across their grain"),
                definition.file(),
            ),
        );
    }
    bounded(Lobes {
        diffuse: reals(0, pattern),
        diffuse_transmitted: reals(6, diffuse_through),
        specular: times(specular, reflected),
        specular_transmitted: times(through, transmitted),
        roughness: if has_transmission { rough_transmission } else { rough_reflection },
    })
}

/// # Errors
/// Counts of arguments that a material of the common kinds cannot have; others are checked where they are used.
pub(super) fn check_counts(kind: MaterialType, object: &Object) -> Result<()> {
    let (strings, reals, meaning): (&[usize], &[usize], &str) = match kind {
        MaterialType::Plastic | MaterialType::Metal => (&[0], &[5], "red green blue specularity roughness"),
        MaterialType::Trans => (&[0], &[7], "red green blue specularity roughness transmissivity transmitted-specularity"),
        MaterialType::Glass => (&[0], &[3, 4], "red green blue [refraction-index]"),
        MaterialType::Mirror => (&[0, 1], &[3], "red green blue"),
        MaterialType::Light => (&[0], &[3], "red green blue"),
        MaterialType::Glow => (&[0], &[4], "red green blue maximum-radius"),
        _ => return Ok(()),
    };
    if !reals.contains(&object.reals.len()) {
        return Err(Error::new(format!("{} real arguments, but {} are needed", object.reals.len(), reals[0]))
            .help(format!("the real arguments are: {meaning}")));
    }
    if !strings.contains(&object.strings.len()) {
        return Err(
            Error::new(format!("{} string arguments, but none is expected", object.strings.len())).help("write 0 as the first count")
        );
    }
    Ok(())
}

fn check_range(kind: MaterialType, object: &Object) -> Result<()> {
    // Colours, which come first, are held at 0; the radius of a glow may be negative.
    let end = if kind == MaterialType::Glow { COLORS } else { object.reals.len() };
    if let Some(v) = object.reals[COLORS..end].iter().find(|v| **v < 0.0) {
        return Err(Error::new(format!("the argument {v} is negative")).help("fractions and roughness start at 0"));
    }
    if kind == MaterialType::Glass && object.reals.get(3).is_some_and(|n| *n < 1.0) {
        return Err(
            Error::new(format!("the refraction index is {}", object.reals[3])).help("give an index of 1 or more, or leave it out for 1.52")
        );
    }
    Ok(())
}

/// Real arguments that are a colour: they come first in every material.
const COLORS: usize = 3;

/// Radiance lets reflectances above 1 pass and create light; interreflection then has no limit. So
/// they are held at 1 here, with a warning. Colours below 0, as measured spectra outside the gamut of
/// RGB give them, are held at 0.
fn common(kind: MaterialType, definition: &Definition, pattern: [f64; 3], warnings: &mut Warnings) -> Result<MaterialKind> {
    let object = definition.object();
    check_range(kind, object)?;
    let mut held = |i: usize, what: &str, most: f64| {
        let v = object.reals[i] * pattern.get(i).copied().unwrap_or(1.0);
        // Spectra of white come to 1 but for rounding.
        let fault = if v > most * (1.0 + 1e-9) {
            Some((format!("{what} is {v}, more than 1; 1 is used"), "a surface cannot send back or pass on more light than it receives"))
        } else if v < 0.0 && i < COLORS {
            Some((format!("{what} is {v}, less than 0; 0 is used"), "no surface takes more light away than it receives"))
        } else {
            None
        };
        if let Some((message, help)) = fault {
            warnings.push(object.at(Error::new(message).help(help), definition.file()));
        }
        if i < COLORS { v.clamp(0.0, most) } else { v.min(most) }
    };
    let r = &object.reals;
    let radiance = [0, 1, 2]
        .map(|i| if matches!(kind, MaterialType::Light | MaterialType::Glow) { held(i, "a radiance", f64::INFINITY) } else { 0.0 });
    let mut fraction = |i: usize, what: &str| held(i, what, 1.0);
    Ok(match kind {
        MaterialType::Plastic => MaterialKind::Plastic {
            color: [0, 1, 2].map(|i| fraction(i, "a reflectance")),
            specularity: fraction(3, "the specularity"),
            roughness: r[4],
        },
        MaterialType::Metal => MaterialKind::Metal {
            color: [0, 1, 2].map(|i| fraction(i, "a reflectance")),
            specularity: fraction(3, "the specularity"),
            roughness: r[4],
        },
        MaterialType::Trans => MaterialKind::Trans {
            color: [0, 1, 2].map(|i| fraction(i, "a colour")),
            specularity: fraction(3, "the specularity"),
            roughness: r[4],
            transmissivity: fraction(5, "the transmissivity"),
            transmitted_specularity: fraction(6, "the transmitted specularity"),
        },
        MaterialType::Glass => MaterialKind::Glass {
            transmissivity: [0, 1, 2].map(|i| fraction(i, "a transmissivity")),
            refraction_index: r.get(3).copied().unwrap_or(1.52),
        },
        MaterialType::Mirror => MaterialKind::Mirror { color: [0, 1, 2].map(|i| fraction(i, "a reflectance")) },
        MaterialType::Glow => MaterialKind::Glow { radiance, max_radius: r[3] * definition.scale() },
        _ => MaterialKind::Light { radiance },
    })
}

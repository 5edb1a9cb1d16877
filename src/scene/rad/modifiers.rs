//! Definitions that surfaces name as their modifier, and the materials they come to.
//!
//! As in Radiance a name means its latest definition *before* the place where it is used.

use super::proxies::ThickBsdf;
use super::syntax::Object;
use super::types::{MaterialType, ObjectType};
use crate::error::{Error, Result, Warnings};
use crate::scene::{Material, MaterialIndex, MaterialKind};
use std::cell::Cell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

/// Name of the absent modifier.
pub(super) const VOID: &str = "void";

/// Keyword of an alias that keeps the modifiers of its target.
const INHERIT: &str = "inherit";

/// A definition as it stood when it was read.
#[derive(Debug)]
pub(super) struct Definition {
    name: String,
    object: Object,
    file: Rc<Path>,
    /// Scale of lengths by the `xform`s around it.
    scale: f64,
    modifier: Option<Rc<Definition>>,
    material: Cell<Option<MaterialIndex>>,
}

impl Definition {
    /// The string arguments, if this is scattering data.
    pub(super) fn scattering_data(&self) -> Option<&[String]> {
        ["BSDF", "aBSDF"].contains(&self.object.kind.word()).then_some(self.object.strings.as_slice())
    }

    /// The `BSDF` with a thickness that this is, if it is one.
    ///
    /// # Errors
    /// Arguments that are missing, or that only a function file would give.
    pub(super) fn thick_bsdf(&self) -> Result<Option<ThickBsdf>> {
        if self.object.kind.word() != "BSDF" {
            return Ok(None);
        }
        ThickBsdf::read(&self.object.strings, self.scale).map_err(|e| self.object.at(e, &self.file))
    }
}

/// All definitions so far.
#[derive(Debug, Default)]
pub(super) struct Modifiers {
    latest: HashMap<String, Rc<Definition>>,
    void: Option<MaterialIndex>,
}

impl Modifiers {
    /// The latest definition of a name; `None` for `void`.
    ///
    /// # Errors
    /// If the name is not defined yet.
    pub(super) fn find(&self, name: &str) -> Result<Option<Rc<Definition>>> {
        if name == VOID {
            return Ok(None);
        }
        self.latest.get(name).cloned().map(Some).ok_or_else(|| {
            Error::new(format!("the modifier '{name}' is not defined before this line"))
                .help("give the file with the materials first, or correct the name")
        })
    }

    /// Adds a material, texture or mixture.
    ///
    /// # Errors
    /// If its own modifier is not defined yet, or a material's arguments are too few or many.
    pub(super) fn define(&mut self, object: &Object, file: &Rc<Path>, scale: f64) -> Result<()> {
        let at = |e| object.at(e, file);
        let modifier = self.find(&object.modifier).map_err(at)?;
        if let ObjectType::Material(kind) = object.kind {
            check_counts(kind, object).map_err(at)?;
        }
        let name = object.name.clone();
        self.insert(name, object.clone(), file, scale, modifier);
        Ok(())
    }

    /// Adds another name for a definition.
    ///
    /// # Errors
    /// If the target or modifier is not defined yet.
    pub(super) fn alias(&mut self, modifier: &str, name: &str, target: &str, file: &Rc<Path>, line: usize) -> Result<()> {
        let at = |e: Error| e.file(file).line(line).field(format!("alias '{name}'"));
        let original = match self.find(target) {
            Ok(Some(original)) => original,
            Ok(None) => {
                return Err(at(Error::new("an alias cannot stand for `void`").help("write `void` as the modifier of the surfaces")));
            }
            Err(_) => {
                return Err(at(Error::new(format!("'{target}' is not defined before this line"))
                    .help("an alias reads `modifier alias name material`; define the material first")));
            }
        };
        let own = if modifier == INHERIT { None } else { self.find(modifier).map_err(at)? };
        let modifier = own.or_else(|| original.modifier.clone());
        let (object, source, scale) = (original.object.clone(), Rc::clone(&original.file), original.scale);
        self.insert(name.to_string(), object, &source, scale, modifier);
        Ok(())
    }

    fn insert(&mut self, name: String, object: Object, file: &Rc<Path>, scale: f64, modifier: Option<Rc<Definition>>) {
        let definition = Definition { name: name.clone(), object, file: Rc::clone(file), scale, modifier, material: Cell::new(None) };
        self.latest.insert(name, Rc::new(definition));
    }

    /// The material a surface of this modifier has, added to `materials` on first use.
    ///
    /// # Errors
    /// If the material is of a type this program does not know, or two materials are combined.
    pub(super) fn material(
        &mut self,
        modifier: Option<&Rc<Definition>>,
        materials: &mut Vec<Material>,
        warnings: &mut Warnings,
    ) -> Result<MaterialIndex> {
        let add = |name: &str, kind: MaterialKind, materials: &mut Vec<Material>| {
            materials.push(Material { name: name.to_string(), kind });
            MaterialIndex((materials.len() - 1) as u32)
        };
        let Some(definition) = modifier else {
            return Ok(*self.void.get_or_insert_with(|| add(VOID, MaterialKind::Void, materials)));
        };
        if let Some(index) = definition.material.get() {
            return Ok(index);
        }
        let kind = self.kind(definition, warnings)?;
        let index = add(&definition.name, kind, materials);
        definition.material.set(Some(index));
        Ok(index)
    }

    /// What a chain of modifiers comes to.
    ///
    /// # Errors
    /// As [`material`](Self::material).
    pub(super) fn kind(&self, definition: &Rc<Definition>, warnings: &mut Warnings) -> Result<MaterialKind> {
        let mut found: Option<(MaterialKind, &Definition)> = None;
        let mut next = Some(definition);
        while let Some(d) = next {
            let at = |e| d.object.at(e, &d.file);
            match d.object.kind {
                ObjectType::Texture(word) => {
                    warnings.push(at(Error::new(format!("this {word} is ignored: '{}' is used without it", definition.name))
                        .help("where the variation matters, divide the surface among several materials")))
                }
                ObjectType::Unsupported(word, help) => {
                    return Err(at(Error::new(format!("the material type `{word}` is not supported")).help(help)));
                }
                ObjectType::Material(kind) => {
                    if let Some((_, first)) = found {
                        return Err(at(Error::new(format!("the materials '{}' and '{}' modify each other", first.name, d.name))
                            .help("give each surface one material; write `void` as the modifier of materials")));
                    }
                    if let Some(substitute) = self.substitute(d, kind)? {
                        return match substitute {
                            Some(other) => self.kind(&other, warnings),
                            None => Ok(MaterialKind::Void),
                        };
                    }
                    found = Some((material_kind(kind, d, warnings), d));
                    check_range(kind, &d.object).map_err(at)?;
                }
                ObjectType::Surface(_) => {}
            }
            next = d.modifier.as_ref();
        }
        Ok(found.map_or(MaterialKind::Void, |(kind, _)| kind))
    }

    /// The alternate material of a mirror: what all rays but those to light sources see.
    fn substitute(&self, mirror: &Definition, kind: MaterialType) -> Result<Option<Option<Rc<Definition>>>> {
        match mirror.object.strings.first() {
            Some(name) if kind == MaterialType::Mirror && *name != mirror.name => {
                self.find(name).map(Some).map_err(|e| mirror.object.at(e, &mirror.file))
            }
            _ => Ok(None),
        }
    }
}

fn check_counts(kind: MaterialType, object: &Object) -> Result<()> {
    let (strings, reals, meaning): (&[usize], &[usize], &str) = match kind {
        MaterialType::Plastic | MaterialType::Metal => (&[0], &[5], "red green blue specularity roughness"),
        MaterialType::Trans => (&[0], &[7], "red green blue specularity roughness transmissivity transmitted-specularity"),
        MaterialType::Glass => (&[0], &[3, 4], "red green blue [refraction-index]"),
        MaterialType::Mirror => (&[0, 1], &[3], "red green blue"),
        MaterialType::Light => (&[0], &[3], "red green blue"),
        MaterialType::Glow => (&[0], &[4], "red green blue maximum-radius"),
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
fn material_kind(kind: MaterialType, definition: &Definition, warnings: &mut Warnings) -> MaterialKind {
    let object = &definition.object;
    let mut held = |i: usize, what: &str, most: f64| {
        let v = object.reals[i];
        let fault = if v > most {
            Some((format!("{what} is {v}, more than 1; 1 is used"), "a surface cannot send back or pass on more light than it receives"))
        } else if v < 0.0 && i < COLORS {
            Some((format!("{what} is {v}, less than 0; 0 is used"), "no surface takes more light away than it receives"))
        } else {
            None
        };
        if let Some((message, help)) = fault {
            warnings.push(object.at(Error::new(message).help(help), &definition.file));
        }
        if i < COLORS { v.clamp(0.0, most) } else { v.min(most) }
    };
    let r = &object.reals;
    let radiance = [0, 1, 2]
        .map(|i| if matches!(kind, MaterialType::Light | MaterialType::Glow) { held(i, "a radiance", f64::INFINITY) } else { 0.0 });
    let mut fraction = |i: usize, what: &str| held(i, what, 1.0);
    match kind {
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
        MaterialType::Light => MaterialKind::Light { radiance },
        MaterialType::Glow => MaterialKind::Glow { radiance, max_radius: r[3] * definition.scale },
    }
}

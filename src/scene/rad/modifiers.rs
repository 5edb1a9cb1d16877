//! Definitions that surfaces name as their modifier, and the materials they come to.
//!
//! As in Radiance a name means its latest definition *before* the place where it is used.

use super::definition::{Definition, Meaning};
use super::syntax::Object;
use super::types::{MaterialType, ObjectType};
use super::{materials, mixtures, patterns};
use crate::error::{Error, Result, Warnings};
use crate::limits;
use crate::scene::{Material, MaterialIndex, MaterialKind};
use std::cell::Cell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Name of the absent modifier.
pub(super) const VOID: &str = "void";

/// Keyword of an alias that keeps the modifiers of its target.
const INHERIT: &str = "inherit";

/// All definitions so far.
#[derive(Debug, Default)]
pub(super) struct Modifiers {
    latest: HashMap<String, Rc<Definition>>,
    void: Option<MaterialIndex>,
    /// Folder of files that patterns name.
    base: PathBuf,
}

impl Modifiers {
    /// No definitions yet; patterns find their files in `base`, too.
    pub(super) fn new(base: &Path) -> Self {
        Self { base: base.to_path_buf(), ..Self::default() }
    }

    /// The latest definition of a name; `None` for `void`.
    ///
    /// # Errors
    /// If the name is not defined yet.
    pub(super) fn find(&self, name: &str) -> Result<Option<Rc<Definition>>> {
        if name == VOID {
            return Ok(None);
        }
        self.latest.get(name).cloned().map(Some).ok_or_else(|| undefined(name))
    }

    /// Adds a material, texture or mixture.
    ///
    /// # Errors
    /// If its own modifier is not defined yet, or a material's arguments are too few or many.
    pub(super) fn define(&mut self, object: &Object, file: &Rc<Path>, scale: f64) -> Result<()> {
        let at = |e| object.at(e, file);
        let modifier = self.find(&object.modifier).map_err(at)?;
        if let ObjectType::Material(kind) = object.kind {
            materials::check_counts(kind, object).map_err(at)?;
        }
        let name = object.name.clone();
        self.insert(name, object.clone(), file, scale, modifier).map_err(at)
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
        self.insert(name.to_string(), object, &source, scale, modifier).map_err(at)
    }

    fn insert(&mut self, name: String, object: Object, file: &Rc<Path>, scale: f64, modifier: Option<Rc<Definition>>) -> Result<()> {
        let named: Vec<(String, Option<Rc<Definition>>)> =
            object.named().filter(|n| *n != VOID).map(|n| (n.to_string(), self.latest.get(n).cloned())).collect();
        let depth = 1 + modifier.iter().chain(named.iter().filter_map(|(_, d)| d.as_ref())).map(|d| d.depth).max().unwrap_or(0);
        if depth > limits::NESTED_MODIFIERS {
            return Err(limits::exceeded("modifiers stand behind each other", limits::NESTED_MODIFIERS, "deep")
                .help("put the patterns together into fewer"));
        }
        let definition = Definition {
            name: name.clone(),
            object,
            file: Rc::clone(file),
            scale,
            modifier,
            named,
            depth,
            material: Cell::new(None),
            meaning: Cell::new(None),
        };
        self.latest.insert(name, Rc::new(definition));
        Ok(())
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
        Ok(self.meaning(definition, warnings)?.material.unwrap_or(MaterialKind::Void))
    }

    /// Whether patterns or textures are part of a chain of modifiers.
    ///
    /// # Errors
    /// As [`material`](Self::material).
    pub(super) fn is_patterned(&self, definition: &Rc<Definition>, warnings: &mut Warnings) -> Result<bool> {
        Ok(self.meaning(definition, warnings)?.patterned)
    }

    /// What a name comes to that `user` has as an argument.
    fn named(&self, user: &Definition, name: &str, warnings: &mut Warnings) -> Result<Meaning> {
        match user.named.iter().find(|(n, _)| n == name) {
            None => Ok(Meaning::VOID),
            Some((_, Some(other))) => self.meaning(other, warnings),
            Some((_, None)) => Err(undefined(name)).map_err(|e| user.at(e)),
        }
    }

    fn meaning(&self, definition: &Rc<Definition>, warnings: &mut Warnings) -> Result<Meaning> {
        if let Some(known) = definition.meaning.get() {
            return Ok(known);
        }
        let chain: Vec<&Definition> = std::iter::successors(Some(&**definition), |d| d.modifier.as_deref()).collect();
        let material = chain.iter().position(|d| matches!(d.object.kind, ObjectType::Material(kind) if kind != MaterialType::MixFunc));
        let emits = material.is_some_and(|i| chain[i].object.kind.emits());
        let mut meaning = Meaning::VOID;
        let mut owner: Option<&Definition> = None;
        let mut patterns = false;
        for (place, &d) in chain.iter().enumerate() {
            match d.object.kind {
                ObjectType::Surface(_) => {}
                ObjectType::Unsupported(word, help) => {
                    return Err(d.at(Error::new(format!("the material type `{word}` is not supported")).help(help)));
                }
                // The light that the scene's own sources give is no daylight.
                ObjectType::Texture(_) if emits => patterns = true,
                ObjectType::Texture(_) => {
                    let factor = patterns::factor(&d.object, &d.file, &self.base, warnings).map_err(|e| d.at(e))?;
                    meaning.pattern = times(meaning.pattern, factor);
                    patterns = true;
                }
                ObjectType::Material(MaterialType::MixFunc) => {
                    let mixed = self.mixture(d, warnings)?;
                    if let Some(kind) = mixed.material {
                        if let Some(first) = owner {
                            return Err(d.at(both(first, d)));
                        }
                        if place > 0 || d.modifier.is_some() {
                            return Err(d
                                .at(Error::new("a mixture of materials with a modifier, or as one of a pattern, is not known here")
                                    .help("write `void` as its modifier, and put patterns on the materials that it mixes")));
                        }
                        (meaning.material, owner) = (Some(kind), Some(d));
                    }
                    meaning.pattern = times(meaning.pattern, mixed.pattern);
                    patterns = true;
                }
                ObjectType::Material(kind) => {
                    if let Some(first) = owner {
                        return Err(d.at(both(first, d)));
                    }
                    owner = Some(d);
                    // As in Radiance the other material replaces this one and what modifies it.
                    let alternate = match (kind, d.object.strings.first()) {
                        (MaterialType::Mirror, Some(name)) if *name != d.name => Some(name.as_str()),
                        (MaterialType::Illum, name) => Some(name.map_or(VOID, String::as_str)),
                        _ => None,
                    };
                    if let Some(name) = alternate {
                        let other = self.named(d, name, warnings)?;
                        meaning.material = Some(other.material.unwrap_or(MaterialKind::Void));
                        definition.meaning.set(Some(meaning));
                        return Ok(meaning);
                    }
                }
            }
        }
        if let Some(d) = material.map(|i| chain[i])
            && let ObjectType::Material(kind) = d.object.kind
        {
            let named = &mut |name: &str, warnings: &mut Warnings| self.named(d, name, warnings);
            let folded = materials::kind(kind, d, meaning.pattern, named, warnings).map_err(|e| d.at(e))?;
            meaning = Meaning { material: Some(folded), ..Meaning::VOID };
        }
        meaning.patterned = patterns;
        definition.meaning.set(Some(meaning));
        Ok(meaning)
    }

    /// A `mixfunc` of a constant share.
    fn mixture(&self, d: &Definition, warnings: &mut Warnings) -> Result<Meaning> {
        let [first, second, formula, function_file, ..] = d.object.strings.as_slice() else {
            return Err(d.at(Error::new(format!("{} string arguments do not make a mixfunc", d.object.strings.len()))
                .help("it needs: foreground background formula functions")));
        };
        let share = mixtures::share(&d.object, formula, function_file, &mut |e| warnings.push(d.at(e))).map_err(|e| d.at(e))?;
        let [first, second] = [self.named(d, first, warnings)?, self.named(d, second, warnings)?];
        if first.material.is_none() && second.material.is_none() {
            let pattern = std::array::from_fn(|c| share * first.pattern[c] + (1.0 - share) * second.pattern[c]);
            return Ok(Meaning { pattern, ..Meaning::VOID });
        }
        let [first, second] = [first, second].map(|m| m.material.unwrap_or(MaterialKind::Void));
        let kind = mixtures::mixed(first, second, share, &mut |e| warnings.push(d.at(e))).map_err(|e| d.at(e))?;
        Ok(Meaning { material: Some(kind), ..Meaning::VOID })
    }
}

fn times(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] * b[c])
}

fn undefined(name: &str) -> Error {
    Error::new(format!("the modifier '{name}' is not defined before this line"))
        .help("give the file with the materials first, or correct the name")
}

fn both(first: &Definition, second: &Definition) -> Error {
    Error::new(format!("the materials '{}' and '{}' modify each other", first.name, second.name))
        .help("give each surface one material; write `void` as the modifier of materials")
}

//! A definition that surfaces and other definitions name, and what it comes to.

use super::proxies::ThickBsdf;
use super::syntax::Object;
use crate::error::{Error, Result};
use crate::scene::{MaterialIndex, MaterialKind};
use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

/// A definition as it stood when it was read.
#[derive(Debug)]
pub(super) struct Definition {
    /// Identifier.
    pub name: String,
    /// Its type and arguments.
    pub object: Object,
    /// The file that holds it.
    pub file: Rc<Path>,
    /// Scale of lengths by the `xform`s around it.
    pub scale: f64,
    /// What modifies it.
    pub modifier: Option<Rc<Definition>>,
    /// Other definitions that its arguments name, as they stood; `None` for what was not defined.
    pub named: Vec<(String, Option<Rc<Definition>>)>,
    /// Definitions that stand behind each other.
    pub depth: usize,
    /// Its place among the scene's materials, once a surface uses it.
    pub material: Cell<Option<MaterialIndex>>,
    /// What it comes to, once that is known.
    pub meaning: Cell<Option<Meaning>>,
}

impl Definition {
    /// The error with its place and name.
    pub(super) fn at(&self, error: Error) -> Error {
        self.object.at(error, &self.file)
    }

    /// Its arguments.
    pub(super) fn object(&self) -> &Object {
        &self.object
    }

    /// The file that holds it.
    pub(super) fn file(&self) -> &Path {
        &self.file
    }

    /// Scale of lengths by the `xform`s around it.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

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

/// What a modifier comes to: a material, or a pattern alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meaning {
    /// The material, if there is one.
    pub material: Option<MaterialKind>,
    /// RGB factor of what it modifies.
    pub pattern: [f64; 3],
    /// Whether patterns or textures are part of it.
    pub patterned: bool,
}

impl Meaning {
    /// Nothing at all.
    pub(super) const VOID: Self = Self { material: None, pattern: [1.0; 3], patterned: false };
}

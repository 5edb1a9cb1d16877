//! Polygons with what their modifiers come to, for readers that make windows of them.

use super::modifiers::Modifiers;
use super::reader::{Reader, Sink};
use super::syntax::Object;
use super::types::{ObjectType, Surface};
use super::xform::Placement;
use crate::error::{Error, Result, Warnings};
use crate::scene::{MaterialKind, SurfaceOrigin};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A polygon of a file.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::scene) struct Polygon {
    pub origin: SurfaceOrigin,
    pub modifier: String,
    pub made_of: MadeOf,
    /// Counter-clockwise seen from the front.
    pub corners: Vec<DVec3>,
}

/// What a polygon's modifier comes to.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::scene) enum MadeOf {
    Material(MaterialKind),
    /// Scattering data: the file as it is named, and the up vector.
    Bsdf {
        file: String,
        up: DVec3,
    },
}

/// Reads the polygons of files, definitions among them.
///
/// # Errors
/// Anything wrong in the files, and surfaces other than polygons.
pub(in crate::scene) fn read_polygons(files: &[PathBuf], base: &Path, warnings: &mut Warnings) -> Result<Vec<Polygon>> {
    let mut sink = PolygonSink::default();
    let mut reader = Reader::new(base);
    for file in files {
        reader.read(file, &mut sink, warnings)?;
    }
    Ok(sink.polygons)
}

#[derive(Default)]
struct PolygonSink {
    modifiers: Modifiers,
    polygons: Vec<Polygon>,
}

impl Sink for PolygonSink {
    fn object(&mut self, object: &Object, placement: &Placement, file: &Rc<Path>, warnings: &mut Warnings) -> Result<()> {
        if object.kind.is_modifier() {
            return self.modifiers.define(object, file, placement.scale);
        }
        let at = |e| object.at(e, file);
        if !matches!(object.kind, ObjectType::Surface(Surface::Polygon)) {
            return Err(at(Error::new(format!("a {} cannot be an aperture", object.kind.word())).help("apertures are polygons")));
        }
        if object.reals.len() < 9 || !object.reals.len().is_multiple_of(3) {
            return Err(at(Error::new("this is no polygon").help("it needs three coordinates for each of three or more corners")));
        }
        let modifier = placement.modifier.as_deref().unwrap_or(&object.modifier).to_string();
        let made_of = match self.modifiers.find(&modifier).map_err(at)? {
            None => MadeOf::Material(MaterialKind::Void),
            Some(definition) => match definition.scattering_data() {
                Some(strings) => bsdf(strings).map_err(at)?,
                None => MadeOf::Material(self.modifiers.kind(&definition, warnings).map_err(at)?),
            },
        };
        let mut corners: Vec<DVec3> = object.reals.chunks_exact(3).map(|p| placement.point(DVec3::new(p[0], p[1], p[2]))).collect();
        if placement.inverted {
            corners.reverse();
        }
        let origin = SurfaceOrigin { name: format!("{}{}", placement.prefix, object.name), file: file.to_path_buf(), line: object.line };
        self.polygons.push(Polygon { origin, modifier, made_of, corners });
        Ok(())
    }

    fn alias(&mut self, modifier: &str, name: &str, target: &str, file: &Rc<Path>, line: usize) -> Result<()> {
        self.modifiers.alias(modifier, name, target, file, line)
    }

    fn size(&self) -> usize {
        self.polygons.len()
    }

    fn parameters(&mut self, _: &str, _: &Rc<Path>, _: usize) -> Result<()> {
        Ok(())
    }
}

/// The arguments of a `BSDF` (thickness file ux uy uz function) or `aBSDF` (without thickness).
fn bsdf(strings: &[String]) -> Result<MadeOf> {
    let numbers = |words: &[String]| words.iter().map(|w| w.parse().ok()).collect::<Option<Vec<f64>>>();
    let with_thickness = strings.first().is_some_and(|s| s.parse::<f64>().is_ok());
    let rest = &strings[usize::from(with_thickness)..];
    match (rest.first(), rest.get(1..4).and_then(numbers)) {
        (Some(file), Some(up)) => Ok(MadeOf::Bsdf { file: file.clone(), up: DVec3::new(up[0], up[1], up[2]) }),
        _ => Err(Error::new("its arguments are not known here").help("write: thickness file up-x up-y up-z .")),
    }
}

//! Radiance scene files.
//!
//! ```text
//! files ── syntax ──▶ statements ── reader ──▶ objects + placement ──▶ Sink: scene or windows
//!                        ▲    │ `!xform file`, `!genbox`, `!gensurf`, pipes
//!                        └────┘ command, xform, generators, sweeps (nothing is executed)
//! ```
//!
//! | type | read as |
//! |---|---|
//! | polygon, ring, sphere, bubble, cylinder, tube, cone, cup | triangles |
//! | source | [`DistantSource`]; the scene's own sky is left out with a warning, as are `!gensky` and `!gendaylit` |
//! | plastic, metal, trans, glass, mirror, light, glow, spotlight, void, alias | [`MaterialKind`] |
//! | plastic2, metal2, trans2, ashik2 | the same with a round highlight, with a warning |
//! | illum | its alternate material; without one, nothing |
//! | mixfunc of a constant share, `perforate.cal` | the mean material, or an error |
//! | BRTDfunc, WGMDfunc of constants; `window.cal`, `glaze1.cal`, `glaze2.cal` | [`Lobes`](super::Lobes) of normal incidence |
//! | dielectric, interface | faces that reflect by Fresnel and let the rest pass undeflected, with a warning |
//! | spectrum, specfile | RGB as the CIE 1931 observer sees them under light of equal energy |
//! | brightfunc, colorfunc of constants; colorpict | their value; the picture's mean, with a warning |
//! | other patterns | an error where a surface uses them |
//! | texfunc, texdata | left out with a warning |
//! | `BSDF`, `aBSDF` of a project without windows | windows ([`windows`](super::windows)), if indoors lies on one side |
//! | `BSDF` with a thickness, in a shade | `ProxiedPane` |
//! | antimatter, instance, mesh, any other material or mixture | an error where a surface uses it |
//!
//! Of commands `xform`, `cat`, `genbox`, `genblinds`, `genprism`, `gensurf`, `genrev` and `genworm` are
//! interpreted.

mod command;
mod definition;
mod expression;
mod generators;
mod glazing;
mod materials;
mod mixtures;
mod modifiers;
mod patterns;
mod polygons;
mod proxies;
mod reader;
mod scattering;
mod shares;
mod surfaces;
mod sweeps;
mod syntax;
mod types;
mod windows;
mod xform;

pub(super) use polygons::{MadeOf, Polygon, read_polygons};
pub(crate) use proxies::ProxiedPane;
pub(crate) use scattering::ScatteringData;
pub(super) use syntax::shortened;
pub use windows::read_windows;

use super::{DistantSource, Material, MaterialIndex, MaterialKind, Scene, SurfaceOrigin, Triangle};
use crate::error::{Error, Result, Warnings};
use crate::limits;
use modifiers::Modifiers;
use reader::{Reader, Sink};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use surfaces::Geometry;
use syntax::{Object, Statement};
use types::ObjectType;
use xform::Placement;

/// As [`read_scene`], for what the sun is traced through. Surfaces of a `BSDF` with a thickness are not part
/// of the scene but told apart: the sun and the eye pass them and meet the geometry they stand for.
///
/// # Errors
/// As [`read_scene`]; a `BSDF` without thickness, which scatters the sun itself.
pub(crate) fn read_shade(files: &[PathBuf], base: &Path, warnings: &mut Warnings) -> Result<(Scene, Vec<ProxiedPane>)> {
    let mut sink = SceneSink { proxies: Some(Vec::new()), ..SceneSink::new(base) };
    let mut reader = Reader::new(base);
    for file in files {
        reader.read(file, &mut sink, warnings)?;
    }
    Ok((sink.scene, sink.proxies.unwrap_or_default()))
}

/// Reads scene files in the given order, as `oconv` would: a modifier means its latest definition
/// before the place of use, also across files. Paths are relative to `base`; so are those in
/// commands, or else to the folder of the file that names them (first to that folder, where that
/// file was itself placed by `xform`, as in Radiance). Lengths keep the files' unit.
///
/// # Errors
/// Anything wrong in the files, with file, line and object; commands that are not known here;
/// materials this program does not know, where a surface uses them.
pub fn read_scene(files: &[PathBuf], base: &Path, warnings: &mut Warnings) -> Result<Scene> {
    read_scene_and_definitions(files, base, false, warnings).map(|read| read.scene)
}

/// A scene with what other readers need of it.
pub(super) struct Read {
    pub scene: Scene,
    /// Modifiers that stand at the end of the last file, for surfaces of other formats.
    pub definitions: Definitions,
    /// Scattering data of surfaces, if they were asked for; else a surface of them is an error.
    pub scattering: Vec<ScatteringData>,
}

/// As [`read_scene`], with what other readers need of it.
///
/// # Errors
/// As [`read_scene`].
pub(super) fn read_scene_and_definitions(files: &[PathBuf], base: &Path, scattering: bool, warnings: &mut Warnings) -> Result<Read> {
    let mut sink = SceneSink { scattering: scattering.then(Vec::new), ..SceneSink::new(base) };
    let mut reader = Reader::new(base);
    for file in files {
        reader.read(file, &mut sink, warnings)?;
    }
    Ok(Read { scene: sink.scene, definitions: Definitions(sink.modifiers), scattering: sink.scattering.unwrap_or_default() })
}

/// Modifiers that files define.
pub(super) struct Definitions(Modifiers);

impl Definitions {
    /// The material of a modifier, added to `materials` on first use; `None` if nothing defines it.
    ///
    /// # Errors
    /// Materials that are not known here.
    pub(super) fn material(&mut self, name: &str, materials: &mut Vec<Material>, warnings: &mut Warnings) -> Result<Option<MaterialIndex>> {
        let Ok(definition) = self.0.find(name) else { return Ok(None) };
        self.0.material(definition.as_ref(), materials, warnings).map(Some)
    }
}

/// The material that a text of definitions ends with; `void` stands for none.
///
/// # Errors
/// As [`read_scene`], and if there is no material, or anything but materials, in the text.
pub(super) fn material(text: &str, file: &Path, warnings: &mut Warnings) -> Result<MaterialKind> {
    let no_material = || Error::new("this is no material").help("write one as in a .rad file: `void plastic wall 0 0 5 .5 .5 .5 0 0`");
    if text.trim() == modifiers::VOID {
        return Ok(MaterialKind::Void);
    }
    let file: Rc<Path> = file.into();
    let mut known = Modifiers::new(Path::new(""));
    let mut last = None;
    for statement in syntax::parse(text.as_bytes(), &file)? {
        match statement {
            Statement::Object(object) if object.kind.is_modifier() => {
                known.define(&object, &file, 1.0)?;
                last = Some(object.name);
            }
            Statement::Alias { modifier, name, target, line } => {
                known.alias(&modifier, &name, &target, &file, line)?;
                last = Some(name);
            }
            _ => return Err(no_material()),
        }
    }
    let definition = known.find(&last.ok_or_else(no_material)?)?;
    definition.map_or(Ok(MaterialKind::Void), |d| known.kind(&d, warnings))
}

struct SceneSink {
    scene: Scene,
    modifiers: Modifiers,
    /// Where panes that stand for geometry go, if they are known here.
    proxies: Option<Vec<ProxiedPane>>,
    /// Where scattering data of surfaces go, if they are known here.
    scattering: Option<Vec<ScatteringData>>,
    /// Folder of files that definitions name.
    base: PathBuf,
    /// Whether it was said that the scene's sky is left out.
    sky_told: bool,
}

impl SceneSink {
    fn new(base: &Path) -> Self {
        let (modifiers, base) = (Modifiers::new(base), base.to_path_buf());
        Self { scene: Scene::default(), modifiers, proxies: None, scattering: None, base, sky_told: false }
    }

    /// The material that stands for the scattering data of a definition, if it is one and they are known here.
    fn scattering(&mut self, definition: Option<&Rc<definition::Definition>>, placement: &Placement) -> Result<Option<MaterialIndex>> {
        let (Some(known), Some(definition)) = (&mut self.scattering, definition) else { return Ok(None) };
        if definition.scattering_data().is_none() {
            return Ok(None);
        }
        let data = scattering::read(definition, &self.base, placement).map_err(|e| definition.at(e))?;
        let same = |k: &&ScatteringData| ScatteringData { material: data.material, ..(*k).clone() } == data;
        if let Some(k) = known.iter().find(same) {
            return Ok(Some(k.material));
        }
        let material = MaterialIndex(self.scene.materials.len() as u32);
        self.scene.materials.push(Material { name: definition.name.clone(), kind: MaterialKind::Void });
        known.push(ScatteringData { material, ..data });
        Ok(Some(material))
    }
}

impl Sink for SceneSink {
    fn object(&mut self, object: &Object, placement: &Placement, file: &Rc<Path>, warnings: &mut Warnings) -> Result<()> {
        if object.kind.is_modifier() {
            return self.modifiers.define(object, file, placement.scale);
        }
        let at = |e| object.at(e, file);
        let surface = match object.kind {
            ObjectType::Surface(surface) => surface,
            ObjectType::Unsupported(word, help) => {
                return Err(at(Error::new(format!("the surface type `{word}` is not supported")).help(help)));
            }
            ObjectType::Material(_) | ObjectType::Texture(_) => return Ok(()),
        };
        let modifier_name = placement.modifier.as_deref().unwrap_or(&object.modifier);
        let modifier = self.modifiers.find(modifier_name).map_err(at)?;
        let name = format!("{}{}", placement.prefix, object.name);
        match surfaces::geometry(surface, object, placement, file, warnings)? {
            Geometry::Distant(direction, angle) => {
                let kind = match &modifier {
                    Some(definition) if self.modifiers.is_patterned(definition, warnings).map_err(at)? => {
                        self.sky(file, object.line, warnings);
                        return Ok(());
                    }
                    Some(definition) => self.modifiers.kind(definition, warnings).map_err(at)?,
                    None => MaterialKind::Void,
                };
                let radiance = match kind {
                    MaterialKind::Light { radiance } | MaterialKind::Glow { radiance, .. } => radiance,
                    MaterialKind::Void => return Ok(()),
                    // Radiance takes it for a surface at infinity, which sends back nothing to speak of.
                    _ => {
                        let message = format!("this source is left out: its modifier '{modifier_name}' gives no light");
                        warnings.push(at(Error::new(message).help("use `light` or `glow`")));
                        return Ok(());
                    }
                };
                self.scene.sources.push(DistantSource { name, modifier: modifier_name.to_string(), direction, angle, radiance });
            }
            Geometry::Triangles(triangles) => {
                if triangles.is_empty() {
                    return Ok(());
                }
                if let (Some(proxies), Some(definition)) = (&mut self.proxies, &modifier)
                    && let Some(bsdf) = definition.thick_bsdf()?
                {
                    let origin = SurfaceOrigin { name, file: file.to_path_buf(), line: object.line };
                    proxies.push(ProxiedPane::new(&bsdf, triangles, placement, origin).map_err(at)?);
                    return Ok(());
                }
                if let Some(word) = modifier.as_ref().map(|d| d.object().kind.word()).filter(|w| *w == "antimatter") {
                    return Err(at(Error::new(format!("it is made of `{word}` ('{modifier_name}'), which takes other surfaces away"))
                        .help("cut the opening into the polygons that it takes away from (write the hole as a seam), and leave this surface out")));
                }
                let material = match self.scattering(modifier.as_ref(), placement)? {
                    Some(material) => material,
                    None => self.modifiers.material(modifier.as_ref(), &mut self.scene.materials, warnings).map_err(at)?,
                };
                if self.scene.triangles.len() + triangles.len() > limits::TRIANGLES {
                    return Err(at(limits::exceeded("the scene has", limits::TRIANGLES, "triangles")
                        .help("use smaller arrays and fewer curved surfaces")));
                }
                let surface = self.scene.surfaces.len() as u32;
                self.scene.surfaces.push(SurfaceOrigin { name, file: file.to_path_buf(), line: object.line });
                self.scene.triangles.extend(triangles.into_iter().map(|vertices| Triangle { vertices, material, surface }));
            }
        }
        Ok(())
    }

    fn alias(&mut self, modifier: &str, name: &str, target: &str, file: &Rc<Path>, line: usize) -> Result<()> {
        self.modifiers.alias(modifier, name, target, file, line)
    }

    fn size(&self) -> usize {
        self.scene.triangles.len()
    }

    fn parameters(&mut self, _: &str, _: &Rc<Path>, _: usize) -> Result<()> {
        Ok(())
    }

    fn sky(&mut self, file: &Path, line: usize, warnings: &mut Warnings) {
        if !std::mem::replace(&mut self.sky_told, true) {
            let told = Error::new("the scene's own sky is left out: the sky comes from the weather");
            warnings.push(told.file(file).line(line).help("leave sky files out of the scene"));
        }
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod material_tests;

#[cfg(test)]
mod oracle;

//! glTF 2.0 scenes (`.gltf` with its buffers, or `.glb`).
//!
//! **Axes and units.** glTF has +Y up and metres. Scenes here have +Z up: (x, y, z) becomes
//! (x, −z, y), so that glTF's −Z is north. Files that do not keep to that say so in the `extras` of
//! their scene or asset: `"up_axis": "Z"`, `"scale": 0.001` (metres per unit; any length unit may
//! serve as metre); [`Options`] say it for them.
//!
//! **Geometry.** Triangles, strips and fans of the nodes of the default scene, placed by the
//! nodes' transformations, once for each instance of `EXT_mesh_gpu_instancing`. All surfaces have two
//! sides. Skins, morph targets, animations, cameras and lights are left out.
//!
//! **Extensions.** Those of [`extensions::OBEYED`] are obeyed. Of any other that a file uses a warning
//! tells; one that it requires is refused.
//!
//! **Materials.** An exact Radiance material by the material's `extras`: `"radiance": "void plastic
//! wall 0 0 5 .5 .5 .5 0 0"`. Otherwise see [`materials`].
//!
//! **Windows and sensors** are marked in the `extras` of a node, mesh or (windows) material, or by
//! its name; a node's mark holds for all below it:
//!
//! | `extras` | name | meaning |
//! |---|---|---|
//! | `"window": "south"` | `window:south` | the triangles are the window `south`, fronts into the room |
//! | `"rfluxmtx": "h=kf u=+Z"` | | beside `window`: basis and up vector (axes of the scene, +Z up) |
//! | `"sensors": "workplane"` | `sensors:workplane` | each vertex is a sensor that faces along its normal |

mod buffers;
pub(crate) mod extensions;
mod instances;
pub(crate) mod materials;
mod write;

pub use write::write;

use super::points::Sensor;
use super::windows::WindowBuilder;
use super::{Material, MaterialIndex, Scene, SurfaceOrigin, Triangle, Window};
use crate::error::{Error, Result, Warnings};
use crate::{files, limits, text};
use buffers::Buffers;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::mesh::Mode;
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Which axis of the file points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// As glTF prescribes.
    #[default]
    Y,
    /// Already as in this field.
    Z,
}

/// What a file does not say about itself. Its own `extras` take precedence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Which axis points up.
    pub up: UpAxis,
    /// Metres per unit of length.
    pub scale: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { up: UpAxis::Y, scale: 1.0 }
    }
}

/// Sensors that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorGrid {
    /// Its name.
    pub name: String,
    /// Its sensors, in the order of the vertices; their `line` counts from 1.
    pub sensors: Vec<Sensor>,
}

/// What a glTF file holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Contents {
    /// Surfaces other than windows and sensors.
    pub scene: Scene,
    /// Windows, in order of first appearance.
    pub windows: Vec<Window>,
    /// Grids of sensors, in order of first appearance.
    pub sensors: Vec<SensorGrid>,
}

/// Whether a file's name says that it is glTF.
pub(crate) fn is_gltf(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf") || e.eq_ignore_ascii_case("glb"))
}

/// Reads a file. Its buffers must lie in its own folder or below.
///
/// # Errors
/// Broken files, missing or short buffers, buffers outside the folder, required extensions this
/// program does not know, coordinates that are not finite, materials or windows that make no sense:
/// with the file and the object.
pub fn read(file: &Path, options: &Options, warnings: &mut Warnings) -> Result<Contents> {
    let bytes = files::read(file)?;
    read_bytes(&bytes, file, options, warnings).map_err(|e| e.file(file))
}

fn read_bytes(bytes: &[u8], file: &Path, options: &Options, warnings: &mut Warnings) -> Result<Contents> {
    let broken = |message: String| Error::new(message).help("export the file again, as glTF 2.0");
    if bytes.starts_with(b"glTF") {
        let announced = bytes.get(8..12).map_or(0, |l| u32::from_le_bytes([l[0], l[1], l[2], l[3]]) as usize);
        if announced < 20 || announced > bytes.len() {
            return Err(broken(format!("the file is cut off: it has {} bytes and announces {announced}", bytes.len())));
        }
    } else if let Some(other) = text::Other::of(bytes) {
        return Err(other.instead_of("a glTF scene"));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let unreadable = |e: gltf::Error| broken(format!("this is not glTF: {e}"));
    let gltf = gltf::Gltf::from_slice_without_validation(bytes).map_err(unreadable)?;
    validate(&gltf)?;
    let version = &gltf.document.as_json().asset.version;
    if !version.starts_with("2.") {
        return Err(broken(format!("this is glTF {}, not 2.0", super::rad::shortened(version))));
    }
    let buffers = Buffers::load(&gltf, file)?;
    let json = extensions::json(bytes).map_err(broken)?;
    extensions::warn(&json, &mut |e| warnings.push(e.file(file)));
    let scene = gltf.default_scene().or_else(|| gltf.scenes().next()).ok_or_else(|| broken("the file has no scene".into()))?;
    let asset = extras(&gltf.document.as_json().asset.extras)?;
    let own = extras(scene.extras())?;
    let world = orientation(options, &[&own, &asset])?;
    let mut reader = Reader {
        file,
        gltf: &gltf,
        json: &json,
        buffers: &buffers,
        warnings,
        contents: Contents::default(),
        windows: Vec::new(),
        materials: HashMap::new(),
        nodes: 0,
        vertices: 0,
    };
    for node in scene.nodes() {
        reader.node(&node, world, None, 0)?;
    }
    let windows = reader.windows.into_iter().map(|w| w.finish(reader.warnings)).collect::<Result<_>>()?;
    Ok(Contents { windows, ..reader.contents })
}

/// Checks all that the crate checks, and before that what it takes for granted meanwhile.
fn validate(gltf: &gltf::Gltf) -> Result<()> {
    use gltf::json::validation::{Checked, Error as Fault, Validate};
    let root = gltf.document.as_json();
    let mut faults = Vec::new();
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let position = primitive.attributes.get(&Checked::Valid(gltf::Semantic::Positions));
            if position.is_some_and(|index| index.value() >= root.accessors.len()) {
                faults.push((format!("meshes[{m}].primitives[{p}].attributes[\"POSITION\"]"), Fault::IndexOutOfBounds));
            }
        }
    }
    if faults.is_empty() {
        root.validate(root, gltf::json::Path::new, &mut |path, fault| {
            let place = path().to_string();
            if !extensions::OBEYED.iter().any(|e| place.starts_with("extensionsRequired") && place.contains(e)) {
                faults.push((place, fault));
            }
        });
    }
    let Some((place, fault)) = faults.first() else { return Ok(()) };
    Err(if place.starts_with("extensionsRequired") {
        Error::new(format!("the file requires an extension this program does not know: {place}"))
            .help("export without it (extensions that compress meshes are the usual ones)")
    } else {
        Error::new(format!("{place}: {fault} ({} faults)", faults.len())).help("export the file again, as glTF 2.0")
    })
}

/// The scene's axes and unit.
fn orientation(options: &Options, extras: &[&Value]) -> Result<DAffine3> {
    let said = |key: &str| extras.iter().map(|e| &e[key]).find(|v| !v.is_null());
    let up = match said("up_axis") {
        None => options.up,
        Some(v) => match v.as_str() {
            Some("Y" | "y") => UpAxis::Y,
            Some("Z" | "z") => UpAxis::Z,
            _ => return Err(Error::new(format!("up_axis is {v}")).help("write \"up_axis\": \"Y\" or \"Z\"")),
        },
    };
    let scale = match said("scale") {
        None => options.scale,
        Some(v) => v.as_f64().unwrap_or(f64::NAN),
    };
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(Error::new("the scale is not a positive number").help("write the metres per unit, for instance \"scale\": 0.001"));
    }
    let axes = match up {
        UpAxis::Y => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
        UpAxis::Z => DMat3::IDENTITY,
    };
    Ok(DAffine3::from_mat3(axes * scale))
}

fn extras(raw: &gltf::json::Extras) -> Result<Value> {
    raw.as_ref().map_or(Ok(Value::Null), |raw| {
        serde_json::from_str(raw.get()).map_err(|e| Error::new(format!("extras are not JSON: {e}")).help("export the file again"))
    })
}

/// What a node, mesh or material is marked as.
#[derive(Debug, Clone, PartialEq)]
enum Mark {
    Window { name: String, parameters: String },
    Sensors { name: String },
}

impl Mark {
    fn of(name: Option<&str>, raw: &gltf::json::Extras) -> Result<Option<Self>> {
        let extras = extras(raw)?;
        let named = |prefix: &str| name.and_then(|n| n.strip_prefix(prefix)).map(str::trim).filter(|n| !n.is_empty());
        let marked = |key: &str| match &extras[key] {
            Value::Null | Value::Bool(false) => Ok(None),
            Value::String(s) if !s.trim().is_empty() => Ok(Some(s.trim().to_string())),
            other => Err(Error::new(format!("the extras entry \"{key}\" is {other}")).help(format!("write a name: \"{key}\": \"south\""))),
        };
        let parameters = match &extras["rfluxmtx"] {
            Value::String(s) => s.clone(),
            Value::Null => String::new(),
            other => return Err(Error::new(format!("the extras entry \"rfluxmtx\" is {other}")).help("write \"rfluxmtx\": \"h=kf u=+Z\"")),
        };
        if let Some(name) = marked("window")?.or_else(|| named("window:").map(str::to_string)) {
            return Ok(Some(Self::Window { name, parameters }));
        }
        Ok(marked("sensors")?.or_else(|| named("sensors:").map(str::to_string)).map(|name| Self::Sensors { name }))
    }
}

struct Reader<'a> {
    file: &'a Path,
    gltf: &'a gltf::Gltf,
    /// The whole file, for extensions that the crate does not know.
    json: &'a Value,
    buffers: &'a Buffers,
    warnings: &'a mut Warnings,
    contents: Contents,
    windows: Vec<WindowBuilder>,
    /// Materials used so far by their index in the file.
    materials: HashMap<usize, MaterialIndex>,
    /// Nodes and instances so far.
    nodes: usize,
    /// Vertices so far.
    vertices: usize,
}

impl Reader<'_> {
    fn node(&mut self, node: &gltf::Node, parent: DAffine3, inherited: Option<&Mark>, depth: usize) -> Result<()> {
        let label = format!("node {} '{}'", node.index(), super::rad::shortened(node.name().unwrap_or("")));
        let at = |e: Error| e.field(label.clone());
        if depth > limits::NESTED_NODES {
            return Err(at(
                limits::exceeded("nodes are nested", limits::NESTED_NODES, "deep, or in a circle").help("export the file again")
            ));
        }
        self.count_nodes(1).map_err(at)?;
        let local = match node.transform() {
            gltf::scene::Transform::Matrix { matrix } => DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix.map(|c| c.map(f64::from)))),
            gltf::scene::Transform::Decomposed { translation, rotation, scale } => {
                let rotation = DQuat::from_array(rotation.map(f64::from));
                let length = rotation.length();
                if !(length > 0.5 && length < 2.0) {
                    return Err(at(Error::new("the rotation is not a unit quaternion").help("export the file again")));
                }
                DAffine3::from_scale_rotation_translation(
                    DVec3::from_array(scale.map(f64::from)),
                    rotation.normalize(),
                    DVec3::from_array(translation.map(f64::from)),
                )
            }
        };
        let world = parent * local;
        if !world.is_finite() {
            return Err(at(
                Error::new("the transformation is not finite").help("correct the node's matrix, rotation, translation or scale")
            ));
        }
        let own = Mark::of(node.name(), node.extras()).map_err(at)?;
        let mark = own.as_ref().or(inherited);
        if let Some(mesh) = node.mesh() {
            match instances::of(node, self.gltf, self.json, self.buffers).map_err(at)? {
                None => self.mesh(node, &mesh, world, mark).map_err(at)?,
                Some(instances) => {
                    self.count_nodes(instances.len()).map_err(at)?;
                    for instance in instances {
                        self.mesh(node, &mesh, world * instance, mark).map_err(at)?;
                    }
                }
            }
        }
        for child in node.children() {
            self.node(&child, world, mark, depth + 1)?;
        }
        Ok(())
    }

    fn count_nodes(&mut self, more: usize) -> Result<()> {
        self.nodes = self.nodes.saturating_add(more);
        if self.nodes > limits::NODES {
            return Err(limits::exceeded("the scene consists of", limits::NODES, "nodes and instances")
                .help("give each node one parent, and merge small meshes"));
        }
        Ok(())
    }

    fn mesh(&mut self, node: &gltf::Node, mesh: &gltf::Mesh, world: DAffine3, mark: Option<&Mark>) -> Result<()> {
        let own = Mark::of(mesh.name(), mesh.extras())?;
        let mark = mark.or(own.as_ref());
        let name = node.name().or(mesh.name()).map_or_else(|| format!("node{}", node.index()), str::to_string);
        if node.skin().is_some() || mesh.weights().is_some() {
            let message = "skin and morph targets are left out: the mesh keeps its shape at rest";
            self.warn(&name, message, "apply them before exporting");
        }
        for primitive in mesh.primitives() {
            self.primitive(&name, &primitive, world, mark).map_err(|e| e.field(format!("mesh {}", mesh.index())))?;
        }
        Ok(())
    }

    fn warn(&mut self, name: &str, message: &str, help: &str) {
        self.warnings.push(Error::new(message).file(self.file).field(format!("node '{name}'")).help(help));
    }

    fn primitive(&mut self, name: &str, primitive: &gltf::Primitive, world: DAffine3, mark: Option<&Mark>) -> Result<()> {
        let positions = primitive
            .get(&gltf::Semantic::Positions)
            .ok_or_else(|| Error::new(format!("primitive {} has no positions", primitive.index())).help("export the file again"))?;
        let positions: Vec<DVec3> = self.buffers.vectors(&positions)?;
        self.vertices += positions.len();
        if self.vertices > limits::VERTICES {
            return Err(limits::exceeded("the scene consists of", limits::VERTICES, "vertices").help("simplify the meshes"));
        }
        if let Some(i) = positions.iter().position(|p| !p.is_finite()) {
            return Err(Error::new(format!("vertex {i} has coordinates that are not finite")).help("repair the mesh"));
        }
        let placed: Vec<DVec3> = positions.iter().map(|&p| world.transform_point3(p)).collect();
        let indices: Vec<u32> = match primitive.indices() {
            Some(accessor) => self.buffers.indices(&accessor)?,
            None => (0..placed.len() as u32).collect(),
        };
        if let Some(i) = indices.iter().find(|i| **i as usize >= placed.len()) {
            return Err(Error::new(format!("a triangle names vertex {i} of {}", placed.len())).help("export the file again"));
        }
        let corners = triangle_indices(primitive.mode(), &indices, world.matrix3.determinant() < 0.0);
        if let Some(Mark::Sensors { name }) = mark {
            let normals = match primitive.get(&gltf::Semantic::Normals) {
                Some(accessor) => self.buffers.vectors(&accessor)?,
                None => vertex_normals(&positions, &triangle_indices(primitive.mode(), &indices, false)),
            };
            let turn = world.matrix3.inverse().transpose();
            return self.sensors(name, &placed, &normals.iter().map(|n| turn * n).collect::<Vec<_>>());
        }
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.warn(name, "points and lines are left out", "mark sensors by \"sensors\" in the extras of their node");
            return Ok(());
        }
        if primitive.get(&gltf::Semantic::Colors(0)).is_some() {
            self.warn(name, "vertex colours are left out", "give surfaces of different colour different materials");
        }
        let all = corners.len();
        let triangles: Vec<[DVec3; 3]> =
            corners.into_iter().map(|t| t.map(|i| placed[i as usize])).filter(|[a, b, c]| (b - a).cross(c - a) != DVec3::ZERO).collect();
        if triangles.len() < all {
            self.warn(name, &format!("{} triangles without area are left out", all - triangles.len()), "remove them from the mesh");
        }
        if triangles.is_empty() {
            return Ok(());
        }
        let material = primitive.material();
        let of_material = Mark::of(material.name(), material.extras())?;
        let origin = SurfaceOrigin { name: name.to_string(), file: self.file.to_path_buf(), line: 1 };
        if let Some(Mark::Window { name, parameters }) = mark.or(of_material.as_ref()) {
            let index = self.windows.iter().position(|w| w.name() == name).unwrap_or_else(|| {
                self.windows.push(WindowBuilder::new(name.clone(), origin.clone()));
                self.windows.len() - 1
            });
            self.windows[index].parameters(parameters)?;
            self.windows[index].add(origin, triangles);
            return Ok(());
        }
        let material = self.material(&material)?;
        let scene = &mut self.contents.scene;
        if scene.triangles.len() + triangles.len() > limits::TRIANGLES {
            return Err(limits::exceeded("the scene has", limits::TRIANGLES, "triangles").help("simplify the meshes"));
        }
        let surface = scene.surfaces.len() as u32;
        scene.surfaces.push(origin);
        scene.triangles.extend(triangles.into_iter().map(|vertices| Triangle { vertices, material, surface }));
        Ok(())
    }

    fn material(&mut self, material: &gltf::Material) -> Result<MaterialIndex> {
        let Some(index) = material.index() else {
            return Err(Error::new("the mesh has no material, so nothing says how much light it reflects")
                .help("assign a material to every surface"));
        };
        if let Some(&known) = self.materials.get(&index) {
            return Ok(known);
        }
        let name = material.name().map_or_else(|| format!("material{index}"), str::to_string);
        let at = |e: Error| e.file(self.file).field(format!("material {index} '{name}'"));
        let exact = extras(material.extras()).map_err(at)?;
        let mut heard = Warnings::new();
        let kind = match &exact["radiance"] {
            Value::String(text) => super::rad::material(text, Path::new("extras"), &mut heard).map_err(|e| at(Error::new(e.to_string()))),
            Value::Null => materials::kind(material, &mut heard).map_err(at),
            other => Err(at(Error::new(format!("the extras entry \"radiance\" is {other}"))
                .help("write a material as in a .rad file: \"radiance\": \"void plastic wall 0 0 5 .5 .5 .5 0 0\""))),
        }?;
        for warning in heard.iter() {
            self.warnings.push(at(warning.clone()));
        }
        let known = MaterialIndex(self.contents.scene.materials.len() as u32);
        self.contents.scene.materials.push(Material { name, kind });
        self.materials.insert(index, known);
        Ok(known)
    }

    fn sensors(&mut self, name: &str, positions: &[DVec3], normals: &[DVec3]) -> Result<()> {
        let grids = &mut self.contents.sensors;
        let index = grids.iter().position(|g| g.name == name).unwrap_or_else(|| {
            grids.push(SensorGrid { name: name.to_string(), sensors: Vec::new() });
            grids.len() - 1
        });
        let sensors = &mut grids[index].sensors;
        if positions.len() != normals.len() {
            return Err(Error::new(format!("{} positions, but {} normals", positions.len(), normals.len())).help("export the file again"));
        }
        for (&position, normal) in positions.iter().zip(normals) {
            let line = sensors.len() + 1;
            let direction = normal
                .try_normalize()
                .ok_or_else(|| Error::new(format!("sensor {line} has no normal to face along")).help("export the mesh with normals"))?;
            sensors.push(Sensor { position, direction, line });
        }
        Ok(())
    }
}

/// Corners of the triangles, counter-clockwise seen from the front in the scene.
fn triangle_indices(mode: Mode, indices: &[u32], mirrored: bool) -> Vec<[u32; 3]> {
    let mut triangles: Vec<[u32; 3]> = match mode {
        Mode::Triangles => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        Mode::TriangleStrip => {
            indices.windows(3).enumerate().map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] }).collect()
        }
        Mode::TriangleFan => indices.windows(2).skip(1).map(|t| [indices[0], t[0], t[1]]).collect(),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    };
    if mirrored {
        for t in &mut triangles {
            t.swap(1, 2);
        }
    }
    triangles
}

/// Area-weighted mean of the triangles' normals at each vertex.
fn vertex_normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        for i in t {
            normals[*i as usize] += (b - a).cross(c - a);
        }
    }
    normals
}

/// Splits `room.gltf#south` into the file and the name of the part that is meant.
pub(crate) fn split_part(path: &Path) -> (PathBuf, Option<String>) {
    let text = path.to_string_lossy();
    match text.rsplit_once('#') {
        Some((file, part)) if is_gltf(Path::new(file)) && !path.exists() => (PathBuf::from(file), Some(part.to_string())),
        _ => (path.to_path_buf(), None),
    }
}

#[cfg(test)]
mod tests;

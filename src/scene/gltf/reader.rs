//! Nodes, meshes and materials of a glTF file as surfaces, windows and sensors.

use super::buffers::Buffers;
use super::marks::{Mark, extras};
use super::{Contents, SensorGrid, instances, materials};
use crate::error::{Error, Result, Warnings};
use crate::limits;
use crate::scene::points::Sensor;
use crate::scene::windows::WindowBuilder;
use crate::scene::{Material, MaterialIndex, SurfaceOrigin, Triangle, rad};
use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::mesh::Mode;
use serde_json::Value;
use std::collections::HashMap;
use std::path::Path;

/// Walks through the nodes of a file.
pub(super) struct Reader<'a> {
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

impl<'a> Reader<'a> {
    /// Nothing read yet.
    pub fn new(file: &'a Path, gltf: &'a gltf::Gltf, json: &'a Value, buffers: &'a Buffers, warnings: &'a mut Warnings) -> Self {
        Self {
            file,
            gltf,
            json,
            buffers,
            warnings,
            contents: Contents::default(),
            windows: Vec::new(),
            materials: HashMap::new(),
            nodes: 0,
            vertices: 0,
        }
    }

    /// All that was read.
    pub fn finish(self) -> Result<Contents> {
        let windows = self.windows.into_iter().map(|w| w.finish(self.warnings)).collect::<Result<_>>()?;
        Ok(Contents { windows, ..self.contents })
    }

    /// Reads a node and those below it.
    pub fn node(&mut self, node: &gltf::Node, parent: DAffine3, inherited: Option<&Mark>, depth: usize) -> Result<()> {
        let label = format!("node {} '{}'", node.index(), rad::shortened(node.name().unwrap_or("")));
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
            Value::String(text) => rad::material(text, Path::new("extras"), &mut heard).map_err(|e| at(Error::new(e.to_string()))),
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
pub(super) fn triangle_indices(mode: Mode, indices: &[u32], mirrored: bool) -> Vec<[u32; 3]> {
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

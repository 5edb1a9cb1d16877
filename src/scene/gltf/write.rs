//! Scenes as glTF, with exact materials in the extras.

use super::SensorGrid;
use crate::bins::{AngleBasis, KlemsBasis};
use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::scene::{Lobes, MaterialKind, Scene, Window};
use glam::DVec3;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::Path;

/// Writes a scene, its windows and sensors: one mesh per material, window and grid, with the marks
/// and materials of [`super`] in the extras, so that [`super::read`] gives them back (coordinates to
/// 32 bits). `.glb` files are binary, others hold their buffer as text. Distant sources have no
/// place in glTF.
///
/// # Errors
/// Windows of a basis that has no name, too much data for one buffer, and failures of the file
/// system.
pub fn write(path: &Path, scene: &Scene, windows: &[Window], sensors: &[SensorGrid]) -> Result<()> {
    let mut file = Document::default();
    for (index, material) in scene.materials.iter().enumerate() {
        let triangles = scene.triangles.iter().filter(|t| t.material.0 as usize == index).map(|t| t.vertices);
        let (color, alpha) = preview(&material.kind);
        let number = file.materials.len();
        file.materials.push(json!({
            "name": material.name,
            "pbrMetallicRoughness": { "baseColorFactor": [color[0], color[1], color[2], alpha], "metallicFactor": 0, "roughnessFactor": 1 },
            "alphaMode": if alpha < 1.0 { "BLEND" } else { "OPAQUE" },
            "doubleSided": true,
            "extras": { "radiance": radiance_text(&material.name, &material.kind) },
        }));
        file.mesh(&material.name, triangles, Some(number), json!({}));
    }
    for window in windows {
        let basis = basis_parameter(&window.basis).ok_or_else(|| {
            Error::new(format!("window '{}' has a basis without a name in rfluxmtx's comments", window.name)).help("use a Klems basis")
        })?;
        let hand = if window.frame.x.cross(window.frame.y).dot(window.frame.z) < 0.0 { "-" } else { "" };
        let up = window.frame.y;
        let extras = json!({ "window": window.name, "rfluxmtx": format!("h={hand}{basis} u={},{},{}", up.x, up.y, up.z) });
        file.mesh(&window.name, window.triangles.iter().copied(), None, extras);
    }
    for grid in sensors {
        file.points(grid);
    }
    let (json, buffer) = file.finish(path)?;
    write_atomically(path, |out| {
        let binary = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
        let parts: Vec<Vec<u8>> = if binary {
            let mut json = serde_json::to_vec(&json).map_err(|e| Error::new(e.to_string()))?;
            json.resize(json.len().next_multiple_of(4), b' ');
            let chunk = |kind: &[u8; 4], data: Vec<u8>| [&(data.len() as u32).to_le_bytes()[..], kind, &data].concat();
            let chunks = [chunk(b"JSON", json), chunk(b"BIN\0", buffer)];
            let length = 12 + chunks.iter().map(Vec::len).sum::<usize>() as u32;
            let header = [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes()].concat();
            std::iter::once(header).chain(chunks).collect()
        } else {
            let mut json = json;
            json["buffers"][0]["uri"] = Value::String(format!("data:application/octet-stream;base64,{}", base64(&buffer)));
            vec![serde_json::to_vec_pretty(&json).map_err(|e| Error::new(e.to_string()))?, b"\n".to_vec()]
        };
        parts.iter().try_for_each(|p| out.write_all(p)).map_err(|e| Error::io(path, &e))
    })
}

#[derive(Default)]
struct Document {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

impl Document {
    fn mesh(&mut self, name: &str, triangles: impl Iterator<Item = [DVec3; 3]>, material: Option<usize>, extras: Value) {
        let mut known: HashMap<[u32; 3], u32> = HashMap::new();
        let (mut vertices, mut indices) = (Vec::new(), Vec::new());
        for corner in triangles.flatten() {
            let vertex = file_axes(corner);
            let index = *known.entry(vertex.map(f32::to_bits)).or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() as u32 - 1
            });
            indices.push(index);
        }
        if indices.is_empty() {
            return;
        }
        let position = self.vectors(&vertices, true);
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.accessor(&bytes, json!({ "componentType": 5125, "type": "SCALAR", "count": indices.len() }));
        let mut primitive = json!({ "attributes": { "POSITION": position }, "indices": indices, "mode": 4 });
        if let Some(material) = material {
            primitive["material"] = json!(material);
        }
        self.node(name, primitive, extras);
    }

    fn points(&mut self, grid: &SensorGrid) {
        if grid.sensors.is_empty() {
            return;
        }
        let positions: Vec<[f32; 3]> = grid.sensors.iter().map(|s| file_axes(s.position)).collect();
        let normals: Vec<[f32; 3]> = grid.sensors.iter().map(|s| file_axes(s.direction)).collect();
        let (positions, normals) = (self.vectors(&positions, true), self.vectors(&normals, false));
        let primitive = json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "mode": 0 });
        self.node(&grid.name, primitive, json!({ "sensors": grid.name }));
    }

    fn node(&mut self, name: &str, primitive: Value, extras: Value) {
        self.meshes.push(json!({ "name": name, "primitives": [primitive] }));
        self.nodes.push(json!({ "name": name, "mesh": self.meshes.len() - 1, "extras": extras }));
    }

    fn vectors(&mut self, vectors: &[[f32; 3]], limits: bool) -> usize {
        let mut description = json!({ "componentType": 5126, "type": "VEC3", "count": vectors.len() });
        if limits {
            // Required for positions.
            let extreme = |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|a| vectors.iter().map(|v| v[a]).reduce(pick).unwrap_or(0.0));
            description["min"] = json!(extreme(f32::min));
            description["max"] = json!(extreme(f32::max));
        }
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
        self.accessor(&bytes, description)
    }

    fn accessor(&mut self, bytes: &[u8], mut description: Value) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() }));
        description["bufferView"] = json!(self.views.len() - 1);
        self.buffer.extend_from_slice(bytes);
        self.accessors.push(description);
        self.accessors.len() - 1
    }

    fn finish(self, path: &Path) -> Result<(Value, Vec<u8>)> {
        if u32::try_from(self.buffer.len()).is_err() {
            return Err(Error::new("the scene is too large for one glTF file").file(path).help("write parts of it"));
        }
        let mut json = json!({
            "asset": { "version": "2.0", "generator": format!("Lucarne {}", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.buffer.len() }],
        });
        if !self.materials.is_empty() {
            json["materials"] = json!(self.materials);
        }
        Ok((json, self.buffer))
    }
}

/// +Z up to glTF's +Y up.
fn file_axes(p: DVec3) -> [f32; 3] {
    // Adding zero makes -0 a plain 0, so that equal corners have equal bits.
    [p.x, p.z, -p.y].map(|c| c as f32 + 0.0)
}

/// A colour and opacity for programs that know nothing of the extras.
fn preview(kind: &MaterialKind) -> ([f64; 3], f64) {
    match *kind {
        MaterialKind::Plastic { color, .. } | MaterialKind::Metal { color, .. } | MaterialKind::Mirror { color } => (color, 1.0),
        MaterialKind::Trans { color, transmissivity, .. } => (color, 1.0 - transmissivity / 2.0),
        MaterialKind::Glass { transmissivity, .. } => (transmissivity, 0.3),
        MaterialKind::Lobes(l) => {
            let through = l.specular_transmitted.into_iter().fold(0.0, f64::max);
            (std::array::from_fn(|c| l.diffuse[c] + l.diffuse_transmitted[c] + l.specular[c]), 1.0 - through)
        }
        MaterialKind::Light { .. } | MaterialKind::Glow { .. } => ([1.0; 3], 1.0),
        MaterialKind::Void => ([1.0; 3], 0.0),
    }
}

/// A material as in a `.rad` file; numbers keep all their digits.
fn radiance_text(name: &str, kind: &MaterialKind) -> String {
    // Blanks and quotes would end the identifier.
    let name: String = name.chars().map(|c| if c.is_whitespace() || c == '"' || c == '\'' { '_' } else { c }).collect();
    let numbers = |values: &[f64]| values.iter().map(|v| format!(" {v}")).collect::<String>();
    let (word, values) = match *kind {
        MaterialKind::Plastic { color: [r, g, b], specularity, roughness } => ("plastic", vec![r, g, b, specularity, roughness]),
        MaterialKind::Metal { color: [r, g, b], specularity, roughness } => ("metal", vec![r, g, b, specularity, roughness]),
        MaterialKind::Trans { color: [r, g, b], specularity, roughness, transmissivity, transmitted_specularity } => {
            ("trans", vec![r, g, b, specularity, roughness, transmissivity, transmitted_specularity])
        }
        MaterialKind::Glass { transmissivity: [r, g, b], refraction_index } => ("glass", vec![r, g, b, refraction_index]),
        MaterialKind::Mirror { color } => ("mirror", color.to_vec()),
        MaterialKind::Light { radiance } => ("light", radiance.to_vec()),
        MaterialKind::Glow { radiance: [r, g, b], max_radius } => ("glow", vec![r, g, b, max_radius]),
        MaterialKind::Lobes(l) => return lobes_text(&name, &l),
        MaterialKind::Void => return "void".to_string(),
    };
    format!("void {word} {name} 0 0 {}{}", values.len(), numbers(&values))
}

/// As a `WGMDfunc` of constants, whose specular colours are patterns of their own.
fn lobes_text(name: &str, lobes: &Lobes) -> String {
    let numbers = |values: &[f64]| values.iter().map(|v| format!(" {v}")).collect::<String>();
    let pattern = |part: &str, [r, g, b]: [f64; 3]| format!("void colorfunc {name}-{part} 4 {r} {g} {b} . 0 0\n");
    let (reflected, transmitted) = (pattern("reflected", lobes.specular), pattern("transmitted", lobes.specular_transmitted));
    let (diffuse, through, roughness) = (numbers(&lobes.diffuse), numbers(&lobes.diffuse_transmitted), lobes.roughness);
    let specular = |part: &str| format!("{name}-{part} 1 {roughness} {roughness}");
    let strings = format!("{} {} void 0 0 1 .", specular("reflected"), specular("transmitted"));
    format!("{reflected}{transmitted}void WGMDfunc {name} 13 {strings} 0 9{diffuse}{diffuse}{through}")
}

fn basis_parameter(basis: &AngleBasis) -> Option<&'static str> {
    let named = [(KlemsBasis::Full, "kf"), (KlemsBasis::Half, "kh"), (KlemsBasis::Quarter, "kq")];
    let klems = named.into_iter().find(|(b, _)| AngleBasis::from(*b) == *basis).map(|(_, name)| name);
    klems.or((basis.len() == 1).then_some("u"))
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().fold(0u32, |n, &b| n << 8 | u32::from(b)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize] as char;
            text.push(if i <= chunk.len() { digit } else { '=' });
        }
    }
    text
}

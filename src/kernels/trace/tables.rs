//! A scene and its windows as tables, on the host and on the device.

use super::normalization::Normalization;
use super::planes;
use super::records::{
    MATERIAL_ABSORBER, MATERIAL_GLASS, MATERIAL_MIRROR, MATERIAL_SURFACE, Material, Ring, SceneParts, Window, absorber, material_record,
    pane_kind,
};
use crate::bins::AngleBasis;
use crate::bvh::Bvh;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Device};
use crate::scene::{self, MaterialKind, Scene};
use glam::{DVec3, Vec3};

/// Which of a scene's features its shaders need.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SceneFeatures {
    /// All reflectances and transmittances are grey.
    pub grey: bool,
    /// There are panes of glass.
    pub glass: bool,
    /// Something reflects or transmits other than diffusely.
    pub specular: bool,
}

/// Tables of a scene in the tracer's units, still on the host. The f64 references use the same.
#[derive(Debug, Clone)]
pub(crate) struct TraceTables {
    /// Coordinates.
    pub normalization: Normalization,
    /// Triangles in the tracer's units.
    pub triangles: Vec<[Vec3; 3]>,
    /// Index into `materials` of each triangle.
    pub triangle_materials: Vec<u32>,
    /// Materials, the windows' absorbers last.
    pub materials: Vec<Material>,
    /// Windows.
    pub windows: Vec<Window>,
    /// Rings of all windows.
    pub rings: Vec<Ring>,
    /// Corners of the windows' triangles: xyz and w as in `shared/scene.wgsl`.
    pub window_triangles: Vec<[f32; 4]>,
    /// What the shaders need.
    pub features: SceneFeatures,
    /// Planes of smooth surfaces.
    pub planes: Vec<planes::SmoothPlane>,
    /// Number of each triangle's plane, 0 if there is none.
    triangle_planes: Vec<u32>,
    /// As in the scene: the shaders get everything.
    unpruned: bool,
}

/// Whether the surfaces of the windows that a computation is about stop rays. Those of all other windows of
/// the scene do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowSurfaces {
    /// They end every path that meets them (view and daylight matrix).
    Absorb,
    /// They are holes, which light may leave by (suns); shaders ask for themselves what enters there.
    Open,
}

impl TraceTables {
    /// Tables of `scene` seen through `windows`. All other windows of the scene absorb.
    ///
    /// # Errors
    /// If there is no window, or one has no area.
    pub fn new(scene: &Scene, windows: &[scene::Window], surfaces: WindowSurfaces) -> Result<Self> {
        if windows.is_empty() {
            return Err(Error::new("there is no window").help("name at least one window surface"));
        }
        check_areas(windows.iter())?;
        let mut tables = Self::of_scene(scene, Normalization::of(windows));
        for window in windows {
            tables.push_window(window, surfaces);
        }
        tables.push_others(scene, windows);
        Ok(tables.finished())
    }

    /// Tables of a scene whose openings are wherever its geometry leaves them. Digits are kept near
    /// the points `around`; shaders must not ask for windows.
    pub(crate) fn without_windows(scene: &Scene, around: &[DVec3]) -> Self {
        let mut tables = Self::of_scene(scene, Normalization::around(around));
        tables.push_no_window();
        tables.finished()
    }

    /// Tables of `scene` with the panes of these windows, of which there may be none, among its surfaces: glass with
    /// the number of its window, front into the room. All other windows of the scene absorb. Where there is no
    /// window, digits are kept near the points `around`, and shaders must not ask for windows.
    ///
    /// # Errors
    /// If a window has no area.
    pub fn with_panes(scene: &Scene, windows: &[scene::GlazedWindow], around: &[DVec3]) -> Result<Self> {
        check_areas(windows.iter().map(|w| &w.window))?;
        let openings: Vec<scene::Window> = windows.iter().map(|w| w.window.clone()).collect();
        let normalization = if windows.is_empty() { Normalization::around(around) } else { Normalization::of(&openings) };
        let mut tables = Self::of_scene(scene, normalization);
        for (number, glazed) in windows.iter().enumerate() {
            tables.push_window(&glazed.window, WindowSurfaces::Open);
            let pane = Material { window: number as u32 + 1, ..material_record(&glazed.pane.material()) };
            tables.push_window_surface(&glazed.window, pane);
        }
        if windows.is_empty() {
            tables.push_no_window();
        }
        tables.push_others(scene, &openings);
        Ok(tables.finished())
    }

    /// Index of the material of the first window's pane; those of the others follow.
    pub fn first_pane(&self) -> Option<u32> {
        self.materials.iter().position(|m| m.kind == MATERIAL_GLASS && m.window == 1).map(|i| i as u32)
    }

    /// Tables of length 0 cannot be bound.
    fn push_no_window(&mut self) {
        self.windows.push(bytemuck::Zeroable::zeroed());
        self.rings.push(bytemuck::Zeroable::zeroed());
        self.window_triangles.push([0.0; 4]);
    }

    /// All windows of the scene but these, which absorb.
    fn push_others(&mut self, scene: &Scene, windows: &[scene::Window]) {
        for other in scene.windows.iter().filter(|w| !windows.iter().any(|own| own.is_in_place_of(w))) {
            self.push_window_surface(other, absorber(0));
        }
    }

    fn of_scene(scene: &Scene, normalization: Normalization) -> Self {
        let mut tables = Self {
            normalization,
            triangles: Vec::with_capacity(scene.triangles.len()),
            triangle_materials: Vec::with_capacity(scene.triangles.len()),
            materials: scene.materials.iter().map(|m| material_record(&m.kind)).collect(),
            windows: Vec::new(),
            rings: Vec::new(),
            window_triangles: Vec::new(),
            features: SceneFeatures { grey: true, glass: false, specular: false },
            planes: Vec::new(),
            triangle_planes: Vec::new(),
            unpruned: scene.unpruned,
        };
        let (mut smooth, mut places) = (Vec::new(), Vec::new());
        for triangle in &scene.triangles {
            if scene.materials[triangle.material.0 as usize].kind != MaterialKind::Void {
                let place = tables.triangles.len();
                tables.push_triangle(triangle.vertices, triangle.material.0);
                if place < tables.triangles.len() && planes::reflects(&tables.materials[triangle.material.0 as usize]) {
                    smooth.push((triangle.vertices, triangle.material.0));
                    places.push(place);
                }
            }
        }
        let (planes, numbers) = planes::find(&smooth, 1.0 / normalization.scale);
        tables.planes = planes;
        places.into_iter().zip(numbers).for_each(|(place, number)| tables.triangle_planes[place] = number);
        tables
    }

    fn finished(mut self) -> Self {
        if self.triangles.is_empty() {
            // A scene without surfaces: something far behind every ray keeps the BVH well formed.
            self.materials.push(absorber(0));
            let far = Vec3::new(0.0, 0.0, -1e6);
            self.triangles.push([far, far + Vec3::X * 1e-3, far + Vec3::Y * 1e-3]);
            self.triangle_materials.push(self.materials.len() as u32 - 1);
            self.triangle_planes.push(0);
        }
        self.features = if self.unpruned { SceneFeatures { grey: false, glass: true, specular: true } } else { self.find_features() };
        self
    }

    /// Whether light may be reflected (or pass other than through panes) in ways that no single one of the
    /// `planes` stands for: several reflections, rough, curved and translucent surfaces.
    pub(crate) fn has_other_reflections(&self) -> bool {
        let other = |(&material, &plane): (&u32, &u32)| {
            let m = &self.materials[material as usize];
            (plane == 0 && m.kind != MATERIAL_ABSORBER && m.specular != [0.0; 3])
                || (m.kind == MATERIAL_SURFACE && m.specular_transmitted != [0.0; 3])
        };
        self.planes.len() > 1 || self.triangle_materials.iter().zip(&self.triangle_planes).any(other)
    }

    /// Bins of all windows.
    pub fn bins(&self) -> usize {
        self.windows.last().map_or(0, |w| (w.first_bin + w.bins) as usize)
    }

    fn push_triangle(&mut self, vertices: [DVec3; 3], material: u32) {
        let t = vertices.map(|p| self.normalization.point(p));
        // Triangles that have no extent in f32 can neither be hit nor cast shadows.
        if (t[1] - t[0]).cross(t[2] - t[0]).length_squared() > 0.0 {
            self.triangles.push(t);
            self.triangle_materials.push(material);
            self.triangle_planes.push(0);
        }
    }

    fn push_window(&mut self, window: &scene::Window, surfaces: WindowSurfaces) {
        let first_triangle = (self.window_triangles.len() / 3) as u32;
        let (first_bin, first_ring) = (self.bins() as u32, self.rings.len() as u32);
        let scale2 = self.normalization.scale * self.normalization.scale;
        let total = window.area();
        let mut cumulative = 0.0;
        for corners in &window.triangles {
            let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() / 2.0;
            if area <= 0.0 {
                continue;
            }
            cumulative += area / total;
            let [a, b, c] = corners.map(|p| self.normalization.point(p));
            self.window_triangles.push([a.x, a.y, a.z, cumulative as f32]);
            self.window_triangles.push([b.x, b.y, b.z, (area * scale2) as f32]);
            self.window_triangles.push([c.x, c.y, c.z, 0.0]);
        }
        push_rings(&mut self.rings, &window.basis);
        self.windows.push(Window {
            x: window.frame.x.as_vec3().to_array(),
            first_triangle,
            y: window.frame.y.as_vec3().to_array(),
            triangles: (self.window_triangles.len() / 3) as u32 - first_triangle,
            z: window.frame.z.as_vec3().to_array(),
            area: (total * scale2) as f32,
            first_bin,
            bins: window.basis.len() as u32,
            first_ring,
            rings: self.rings.len() as u32 - first_ring,
        });
        if surfaces == WindowSurfaces::Absorb {
            self.push_window_surface(window, absorber(self.windows.len() as u32));
        }
    }

    /// The surface of a window.
    fn push_window_surface(&mut self, window: &scene::Window, material: Material) {
        self.materials.push(material);
        let material = self.materials.len() as u32 - 1;
        for corners in &window.triangles {
            // Front side into the room, whatever the order of the file's vertices.
            let [a, b, c] = *corners;
            let front = (b - a).cross(c - a).dot(window.frame.z) > 0.0;
            self.push_triangle(if front { [a, b, c] } else { [a, c, b] }, material);
        }
    }

    fn find_features(&self) -> SceneFeatures {
        let mut features = SceneFeatures { grey: true, glass: false, specular: false };
        let mut used: Vec<u32> = self.triangle_materials.clone();
        used.sort_unstable();
        used.dedup();
        for material in used.into_iter().map(|m| &self.materials[m as usize]) {
            let colours = [material.diffuse, material.specular, material.diffuse_transmitted, material.specular_transmitted];
            features.grey &= colours.iter().all(|c| c[0] == c[1] && c[1] == c[2]);
            features.glass |= material.kind == MATERIAL_GLASS;
            features.specular |= material.kind == MATERIAL_GLASS
                || material.kind == MATERIAL_MIRROR
                || (material.kind == MATERIAL_SURFACE && (material.specular != [0.0; 3] || material.specular_transmitted != [0.0; 3]));
        }
        features
    }

    /// Uploads the tables and builds the acceleration structure.
    ///
    /// # Errors
    /// If the device lacks memory or the scene exceeds its limits.
    pub(crate) fn upload(&self, device: &Device) -> Result<TraceScene> {
        let bvh = Bvh::build(&self.triangles);
        let mut corners: Vec<[f32; 4]> = Vec::with_capacity(bvh.order.len() * 3);
        for &index in &bvh.order {
            let [a, b, c] = self.triangles[index as usize];
            let number = self.triangle_materials[index as usize];
            let pane = pane_kind(&self.materials[number as usize]);
            let plane = self.triangle_planes[index as usize];
            corners.extend([[a.x, a.y, a.z, f32::from_bits(number)], [b.x, b.y, b.z, pane], [c.x, c.y, c.z, f32::from_bits(plane)]]);
        }
        let tables: [&[u8]; 6] = [
            bytemuck::cast_slice(&bvh.nodes),
            bytemuck::cast_slice(&corners),
            bytemuck::cast_slice(&self.materials),
            bytemuck::cast_slice(&self.windows),
            bytemuck::cast_slice(&self.rings),
            bytemuck::cast_slice(&self.window_triangles),
        ];
        let bytes: usize = tables.iter().map(|t| t.len()).sum();
        let most = device.limits().max_storage_buffer_binding_size.min(device.limits().max_buffer_size).min(u64::from(u32::MAX) * 16);
        if bytes as u64 > most {
            let mib = |bytes: u64| bytes.div_ceil(1 << 20);
            return Err(Error::device(format!(
                "the scene's {} triangles need {} MiB; '{}' binds at most {} MiB at once",
                self.triangles.len(),
                mib(bytes as u64),
                device.summary().name,
                mib(most)
            ))
            .help("leave out what no light reaches, simplify curved surfaces, or choose another device with --device (lucarne devices)"));
        }
        let mut end = 0;
        let [triangles, materials, windows, rings, window_triangles, _] = tables.map(|table| {
            end += (table.len() / QUAD_BYTES) as u32;
            end
        });
        let parts = SceneParts { triangles, materials, windows, rings, window_triangles, window_count: self.windows.len() as u32 };
        Ok(TraceScene { words: device.upload_tables("scene", &tables)?, parts: device.uniform("parts of the scene", &parts)? })
    }
}

/// Bytes of a quad of words, of which all tables of a scene are made.
const QUAD_BYTES: usize = 16;

/// A scene on the device: the bindings that every tracing kernel shares.
pub(crate) struct TraceScene {
    words: Buffer,
    parts: Buffer,
}

impl TraceScene {
    /// Shared bindings by their WGSL names, with those of one kernel added.
    pub(crate) fn bindings<'a>(&'a self, own: &[(&'a str, &'a Buffer)]) -> Vec<(&'a str, &'a Buffer)> {
        [&[("scene_words", &self.words), ("scene_parts", &self.parts)], own].concat()
    }
}

fn check_areas<'w>(windows: impl Iterator<Item = &'w scene::Window>) -> Result<()> {
    for window in windows {
        if !(window.area() > 0.0) || window.triangles.iter().flatten().any(|p| !p.is_finite()) {
            return Err(Error::new(format!("window '{}' has no area", window.name))
                .file(&window.origin.file)
                .line(window.origin.line)
                .help("its polygon is degenerate or not finite"));
        }
    }
    Ok(())
}

fn push_rings(rings: &mut Vec<Ring>, basis: &AngleBasis) {
    for ring in basis.rings() {
        let cos2 = |degrees: f64| if degrees >= 90.0 { 0.0 } else { degrees.to_radians().cos().powi(2) as f32 };
        rings.push(Ring {
            cos2_low: cos2(ring.theta_min),
            cos2_high: cos2(ring.theta_max),
            first: ring.first as u32,
            bins: ring.bins as u32,
        });
    }
}

//! What all tracing kernels share: the scene, its windows and their tables on the device.

use crate::bins::AngleBasis;
use crate::bvh::Bvh;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Declared, Device, Shader};
use crate::gpu_struct;
use crate::matrix::Matrix;
use crate::scene::{self, MaterialKind, Scene};
use glam::{DVec3, Vec3};

#[cfg(test)]
mod cie171;
#[cfg(test)]
pub(crate) mod comparison;
pub mod doubt;
#[cfg(test)]
mod extremes;
#[cfg(test)]
mod mutations;
pub(crate) mod planes;
pub(crate) mod probes;
#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
pub(crate) mod rooms;

gpu_struct! {
    /// Optical properties of a surface (`shared/material.wgsl`).
    pub struct Material {
        /// Diffuse reflectance.
        pub diffuse: [f32; 3],
        /// `MATERIAL_ABSORBER`, `MATERIAL_SURFACE`, `MATERIAL_GLASS` or `MATERIAL_MIRROR`.
        pub kind: u32,
        /// Specular reflectance (of the front for mirrors); transmissivity for glass.
        pub specular: [f32; 3],
        /// RMS facet slope; refraction index for glass.
        pub roughness: f32,
        /// Diffuse transmittance.
        pub diffuse_transmitted: [f32; 3],
        /// Index + 1 of the window that this absorber is; 0 otherwise.
        pub window: u32,
        /// Specular (direct) transmittance.
        pub specular_transmitted: [f32; 3],
        /// Unused.
        pub padding: u32,
    }
}

gpu_struct! {
    /// A window (`shared/window.wgsl`).
    pub struct Window {
        /// Local frame in world coordinates: z points into the room, y up.
        pub x: [f32; 3],
        /// Index of its first triangle.
        pub first_triangle: u32,
        /// Local y (up).
        pub y: [f32; 3],
        /// Number of triangles.
        pub triangles: u32,
        /// Normal, into the room.
        pub z: [f32; 3],
        /// In the tracer's units.
        pub area: f32,
        /// Index of the first bin among all windows' bins.
        pub first_bin: u32,
        /// Number of bins.
        pub bins: u32,
        /// Index of its first ring.
        pub first_ring: u32,
        /// Number of rings.
        pub rings: u32,
    }
}

gpu_struct! {
    /// One ring of a window's basis. Squared cosines, because acos is inexact on some devices.
    pub struct Ring {
        /// At the lower polar limit (1 at the pole).
        pub cos2_low: f32,
        /// At the upper polar limit (0 at the horizon).
        pub cos2_high: f32,
        /// First bin, counted within the window.
        pub first: u32,
        /// Number of bins.
        pub bins: u32,
    }
}

gpu_struct! {
    /// Paths finished and failed, paths still alive, segments traced (`shared/counters.wgsl`).
    pub struct Counters: atomic {
        /// Paths that ended properly.
        pub finished: u32,
        /// Paths the device cut off.
        pub failed: u32,
        /// Paths that go on in the next dispatch.
        pub alive: u32,
        /// Segments traced.
        pub segments: u32,
    }
}

crate::gpu_constants! {
    const NUMBERS = {
        const PI: f64 = std::f64::consts::PI;
        const TAU: f64 = std::f64::consts::TAU;
        const FRAC_1_PI: f64 = std::f64::consts::FRAC_1_PI;
        const FRAC_PI_4: f64 = std::f64::consts::FRAC_PI_4;
        /// Where rays end that nothing stops, in the tracer's units.
        pub(crate) const FAR_AWAY: f64 = 1e30;
        /// Windows, light and glow: end a path.
        pub(crate) const MATERIAL_ABSORBER: u32 = 0;
        /// Plastic, metal and trans.
        pub(crate) const MATERIAL_SURFACE: u32 = 1;
        pub(crate) const MATERIAL_GLASS: u32 = 2;
        pub(crate) const MATERIAL_MIRROR: u32 = 3;
        /// Squared roughness up to which surfaces are smooth.
        pub(crate) const SMOOTH_ROUGHNESS2: f64 = 1e-6;
        /// Specular fraction from which Radiance applies its Fresnel approximation to smooth surfaces
        /// (FRESTHRESH).
        pub(crate) const FRESNEL_THRESHOLD: f64 = 0.018;
        /// See [`smooth_fresnel`].
        const FRESNEL_DECAY: f64 = 5.85;
        /// exp(−`FRESNEL_DECAY`).
        const FRESNEL_GRAZING: f64 = 0.002_879_899_16;
        /// Ends paths that wander between mirrors.
        const MOST_PATH_SEGMENTS: u32 = 256;
    }
}

/// Radiance's approximation to Fresnel's law for smooth surfaces: what they add to their specular
/// reflection at this cosine of incidence, as a share of the rest. 0 at normal incidence.
pub(crate) fn smooth_fresnel(cosine: f64) -> f64 {
    (-FRESNEL_DECAY * cosine).exp() - (-FRESNEL_DECAY).exp()
}

/// Path weight below which Russian roulette decides, unless a caller says otherwise (Radiance's `-lw`).
pub const ROULETTE_WEIGHT: f32 = 0.05;

/// Fixed-point units that a dispatch may add to a cell; half the range, since area sampling of small
/// windows exceeds their mean solid angle a little.
pub(crate) const CELL_CAPACITY: f32 = (1u32 << 31) as f32;

const STRUCTS: &[Declared] = &[Material::DECLARED, Window::DECLARED, Ring::DECLARED, Counters::DECLARED];

/// A shader that traces rays: what is declared here is shared by all of them.
pub(crate) const fn shader(path: &'static str, declared: &'static [&'static [Declared]]) -> Shader {
    Shader::new(path, declared).sharing(&[NUMBERS, STRUCTS])
}

/// From the user's coordinates to the tracer's: the origin in the middle of the windows, lengths
/// in units of their size, so that f32 keeps its digits where they matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normalization {
    /// The tracer's origin in the user's coordinates.
    pub origin: DVec3,
    /// Tracer's units per user's unit.
    pub scale: f64,
}

impl Normalization {
    /// The normalisation for these windows.
    pub fn of(windows: &[scene::Window]) -> Self {
        let area: f64 = windows.iter().map(scene::Window::area).sum();
        let corners = || windows.iter().flat_map(|w| w.triangles.iter().flatten());
        let low = corners().fold(DVec3::INFINITY, |a, &b| a.min(b));
        let high = corners().fold(DVec3::NEG_INFINITY, |a, &b| a.max(b));
        Self { origin: (low + high) / 2.0, scale: 1.0 / (area / windows.len().max(1) as f64).sqrt().max(1e-12) }
    }

    /// The normalisation for a scene without windows that is looked at from these points.
    pub fn around(points: &[DVec3]) -> Self {
        let low = points.iter().fold(DVec3::INFINITY, |a, &b| a.min(b));
        let high = points.iter().fold(DVec3::NEG_INFINITY, |a, &b| a.max(b));
        if points.is_empty() {
            return Self { origin: DVec3::ZERO, scale: 1.0 };
        }
        // Half the diagonal: a room is about as large as the grid of its sensors, a unit at least.
        Self { origin: (low + high) / 2.0, scale: 1.0 / ((high - low).length() / 2.0).max(1.0) }
    }

    /// A point in the tracer's coordinates.
    pub fn point(&self, p: DVec3) -> Vec3 {
        ((p - self.origin) * self.scale).as_vec3()
    }

    /// A point of the tracer's in the user's coordinates.
    pub fn back(&self, p: Vec3) -> DVec3 {
        self.origin + p.as_dvec3() / self.scale
    }
}

/// Which of a scene's features its shaders need.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SceneFeatures {
    /// All reflectances and transmittances are grey.
    pub grey: bool,
    /// There are panes of glass.
    pub glass: bool,
    /// Something reflects or transmits other than diffusely.
    pub specular: bool,
}

/// Tables of a scene in the tracer's units, still on the host. The f64 references use the same.
#[derive(Debug, Clone)]
pub struct TraceTables {
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
    /// Corners of the windows' triangles: xyz and w as in `shared/window.wgsl`.
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
        for window in windows {
            if !(window.area() > 0.0) || window.triangles.iter().flatten().any(|p| !p.is_finite()) {
                return Err(Error::new(format!("window '{}' has no area", window.name))
                    .file(&window.origin.file)
                    .line(window.origin.line)
                    .help("its polygon is degenerate or not finite"));
            }
        }
        let mut tables = Self::of_scene(scene, Normalization::of(windows));
        for window in windows {
            tables.push_window(window, surfaces);
        }
        for other in scene.windows.iter().filter(|w| !windows.iter().any(|own| own.is_in_place_of(w))) {
            tables.push_absorber(other, 0);
        }
        Ok(tables.finished())
    }

    /// Tables of a scene whose openings are wherever its geometry leaves them. Digits are kept near
    /// the points `around`; shaders must not ask for windows.
    pub fn without_windows(scene: &Scene, around: &[DVec3]) -> Self {
        let mut tables = Self::of_scene(scene, Normalization::around(around));
        // Tables of length 0 cannot be bound.
        tables.windows.push(bytemuck::Zeroable::zeroed());
        tables.rings.push(bytemuck::Zeroable::zeroed());
        tables.window_triangles.push([0.0; 4]);
        tables.finished()
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
    pub fn has_other_reflections(&self) -> bool {
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
            self.push_absorber(window, self.windows.len() as u32);
        }
    }

    /// The surface of a window as a black one; `number` is its index among the windows + 1, or 0.
    fn push_absorber(&mut self, window: &scene::Window, number: u32) {
        self.materials.push(absorber(number));
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
    /// If the device lacks memory or one table exceeds its limits.
    pub fn upload(&self, device: &Device) -> Result<TraceScene> {
        let bvh = Bvh::build(&self.triangles);
        let mut corners: Vec<[f32; 4]> = Vec::with_capacity(bvh.order.len() * 3);
        for &index in &bvh.order {
            let [a, b, c] = self.triangles[index as usize];
            let number = self.triangle_materials[index as usize];
            let pane = pane_kind(&self.materials[number as usize]);
            let plane = self.triangle_planes[index as usize];
            corners.extend([[a.x, a.y, a.z, f32::from_bits(number)], [b.x, b.y, b.z, pane], [c.x, c.y, c.z, f32::from_bits(plane)]]);
        }
        Ok(TraceScene {
            nodes: device.upload("BVH nodes", &bvh.nodes)?,
            triangles: device.upload("triangles", &corners)?,
            materials: device.upload("materials", &self.materials)?,
            windows: device.upload("windows", &self.windows)?,
            rings: device.upload("rings of the windows' bases", &self.rings)?,
            window_triangles: device.upload("window triangles", &self.window_triangles)?,
        })
    }
}

/// A scene on the device: the bindings that every tracing kernel shares.
pub struct TraceScene {
    nodes: Buffer,
    triangles: Buffer,
    materials: Buffer,
    windows: Buffer,
    rings: Buffer,
    window_triangles: Buffer,
}

impl TraceScene {
    /// Shared bindings by their WGSL names, with those of one kernel added.
    pub fn bindings<'a>(&'a self, own: &[(&'a str, &'a Buffer)]) -> Vec<(&'a str, &'a Buffer)> {
        let mut all = vec![
            ("bvh_nodes", &self.nodes),
            ("bvh_triangles", &self.triangles),
            ("materials", &self.materials),
            ("windows", &self.windows),
            ("rings", &self.rings),
            ("window_triangles", &self.window_triangles),
        ];
        all.extend_from_slice(own);
        all
    }
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

fn absorber(window: u32) -> Material {
    Material { kind: MATERIAL_ABSORBER, window, ..bytemuck::Zeroable::zeroed() }
}

/// Radiance's material parameters as the shares of light that the shaders use.
impl Material {
    /// Whether it reflects and transmits as a mirror and a pane do.
    pub fn is_smooth(&self) -> bool {
        self.roughness * self.roughness <= SMOOTH_ROUGHNESS2 as f32
    }

    /// The largest share of light that it scatters, other than as mirrors and panes do.
    pub fn scattered(&self) -> f32 {
        let largest = |c: [f32; 3]| c.into_iter().fold(0.0, f32::max);
        let rough = if self.is_smooth() { 0.0 } else { largest(self.specular).max(largest(self.specular_transmitted)) };
        if self.kind == MATERIAL_SURFACE { largest(self.diffuse).max(largest(self.diffuse_transmitted)).max(rough) } else { 0.0 }
    }
}

/// How a material lets light through directly, as `shared/bvh.wgsl` has it.
fn pane_kind(material: &Material) -> f32 {
    match material.kind {
        2 => 1.0,
        1 if material.is_smooth() && material.specular_transmitted.iter().any(|v| *v > 0.0) => 2.0,
        _ => 0.0,
    }
}

fn material_record(kind: &MaterialKind) -> Material {
    let scaled = |c: [f64; 3], f: f64| c.map(|v| (v * f) as f32);
    let surface = Material { kind: MATERIAL_SURFACE, ..bytemuck::Zeroable::zeroed() };
    match *kind {
        MaterialKind::Plastic { color, specularity, roughness } => Material {
            diffuse: scaled(color, 1.0 - specularity),
            specular: [specularity as f32; 3],
            roughness: roughness as f32,
            ..surface
        },
        MaterialKind::Metal { color, specularity, roughness } => Material {
            diffuse: scaled(color, 1.0 - specularity),
            specular: scaled(color, specularity),
            roughness: roughness as f32,
            ..surface
        },
        MaterialKind::Trans { color, specularity, roughness, transmissivity, transmitted_specularity } => {
            let transmitted = transmissivity * (1.0 - specularity);
            Material {
                diffuse: scaled(color, 1.0 - specularity - transmitted),
                specular: [specularity as f32; 3],
                roughness: roughness as f32,
                diffuse_transmitted: scaled(color, transmitted * (1.0 - transmitted_specularity)),
                specular_transmitted: scaled(color, transmitted * transmitted_specularity),
                ..surface
            }
        }
        MaterialKind::Glass { transmissivity, refraction_index } => {
            Material { kind: MATERIAL_GLASS, specular: scaled(transmissivity, 1.0), roughness: refraction_index as f32, ..surface }
        }
        MaterialKind::Mirror { color } => Material { kind: MATERIAL_MIRROR, specular: scaled(color, 1.0), ..surface },
        MaterialKind::Light { .. } | MaterialKind::Glow { .. } | MaterialKind::Void => absorber(0),
    }
}

/// What a computation did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TraceStatistics {
    /// Paths started, all of them finished.
    pub paths: u64,
    /// Path segments and connections, at least.
    pub segments: u64,
}

impl TraceStatistics {
    /// Adds the work of another computation.
    pub fn add(&mut self, other: Self) {
        self.paths += other.paths;
        self.segments += other.segments;
    }
}

/// One independent estimate of a matrix: all its entries come from the same rays, so their errors are
/// correlated in ways that only the whole batch shows.
#[derive(Debug, Clone, PartialEq)]
pub struct TracedBatch {
    /// The matrix.
    pub total: Matrix<f32>,
    /// Only what arrives directly.
    pub direct: Matrix<f32>,
}

/// A matrix, its part without diffuse reflections, and its standard error, all of one shape.
#[derive(Debug, Clone, PartialEq)]
pub struct TracedMatrix {
    /// The matrix.
    pub total: Matrix<f32>,
    /// Only what arrives directly, through openings and panes (Vd, Dd); never larger than `total`.
    pub direct: Matrix<f32>,
    /// Standard error of each entry of `total`.
    pub standard_error: Matrix<f32>,
    /// The independent batches that the three above come from, if they were asked for.
    pub batches: Vec<TracedBatch>,
    /// Work done.
    pub statistics: TraceStatistics,
}

/// Checks that every path started was finished: some drivers end long loops silently.
///
/// # Errors
/// If paths were lost.
pub fn check_finished(counters: &Counters, started: u64, what: &str) -> Result<()> {
    if u64::from(counters.finished) == started && counters.failed == 0 {
        return Ok(());
    }
    Err(Error::new(format!(
        "{what}: {started} paths were started but {} finished and {} were cut off by the device",
        counters.finished, counters.failed
    ))
    .help("the scene is too deep for this device's limit on loops; use another device, or simplify the geometry"))
}

/// A seed for one stream of random numbers: different for every seed, batch and purpose.
pub fn stream_seed(seed: u32, batch: u32, purpose: u32) -> u32 {
    let mut x = (u64::from(seed) << 32 | u64::from(batch)) ^ u64::from(purpose).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x ^ (x >> 31)) as u32
}

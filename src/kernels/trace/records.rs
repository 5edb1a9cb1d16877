//! What tracing kernels read and write on the device: materials, windows, counters and their numbers.

use crate::gpu::{Declared, Shader};
use crate::gpu_struct;
pub(crate) use crate::scene::pane::smooth_fresnel;
use crate::scene::{MaterialKind, pane};

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
        /// Index + 1 of the window that this absorber or pane is; 0 otherwise.
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
    /// Where the parts of a scene begin in its buffer, in quads of words, the nodes first (`shared/scene.wgsl`).
    pub(crate) struct SceneParts {
        /// Triangles of the surfaces.
        pub triangles: u32,
        /// Materials.
        pub materials: u32,
        /// Windows.
        pub windows: u32,
        /// Rings of the windows' bases.
        pub rings: u32,
        /// Triangles of the windows.
        pub window_triangles: u32,
        /// Number of windows.
        pub window_count: u32,
    }
}

gpu_struct! {
    /// Paths finished and failed, paths still alive, segments traced (`shared/counters.wgsl`).
    pub(crate) struct Counters: atomic {
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
        pub(crate) const SMOOTH_ROUGHNESS2: f64 = pane::SMOOTH_ROUGHNESS2;
        /// See [`pane::FRESNEL_THRESHOLD`].
        pub(crate) const FRESNEL_THRESHOLD: f64 = pane::FRESNEL_THRESHOLD;
        /// See [`pane::smooth_fresnel`].
        const FRESNEL_DECAY: f64 = pane::FRESNEL_DECAY;
        /// exp(−`FRESNEL_DECAY`).
        const FRESNEL_GRAZING: f64 = 0.002_879_899_16;
        /// Ends paths that wander between mirrors.
        const MOST_PATH_SEGMENTS: u32 = 256;
    }
}

const STRUCTS: &[Declared] = &[
    Material::DECLARED,
    Material::OF_WORDS,
    Window::DECLARED,
    Window::OF_WORDS,
    Ring::DECLARED,
    Ring::OF_WORDS,
    SceneParts::DECLARED,
    Counters::DECLARED,
];

/// A shader that traces rays: what is declared here is shared by all of them.
pub(crate) const fn shader(path: &'static str, declared: &'static [&'static [Declared]]) -> Shader {
    Shader::new(path, declared).sharing(&[NUMBERS, STRUCTS])
}

pub(super) fn absorber(window: u32) -> Material {
    Material { kind: MATERIAL_ABSORBER, window, ..bytemuck::Zeroable::zeroed() }
}

/// Radiance's material parameters as the shares of light that the shaders use.
impl Material {
    /// Whether it reflects and transmits as a mirror and a pane do.
    pub(crate) fn is_smooth(&self) -> bool {
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
pub(super) fn pane_kind(material: &Material) -> f32 {
    match material.kind {
        2 => 1.0,
        1 if material.is_smooth() && material.specular_transmitted.iter().any(|v| *v > 0.0) => 2.0,
        _ => 0.0,
    }
}

pub(super) fn material_record(kind: &MaterialKind) -> Material {
    let single = |c: [f64; 3]| c.map(|v| v as f32);
    let surface = Material { kind: MATERIAL_SURFACE, ..bytemuck::Zeroable::zeroed() };
    if let Some(lobes) = kind.lobes() {
        return Material {
            diffuse: single(lobes.diffuse),
            specular: single(lobes.specular),
            roughness: lobes.roughness as f32,
            diffuse_transmitted: single(lobes.diffuse_transmitted),
            specular_transmitted: single(lobes.specular_transmitted),
            ..surface
        };
    }
    match *kind {
        MaterialKind::Glass { transmissivity, refraction_index } => {
            Material { kind: MATERIAL_GLASS, specular: single(transmissivity), roughness: refraction_index as f32, ..surface }
        }
        MaterialKind::Mirror { color } => Material { kind: MATERIAL_MIRROR, specular: single(color), ..surface },
        _ => absorber(0),
    }
}

//! What the tracer sees: triangles with materials, and the windows between inside and outside.
//!
//! Readers ([`rad`], [`gltf`], [`obj`], [`honeybee`]) produce a [`Scene`]; coordinates stay in f64 and in the user's frame until the
//! acceleration structure rebases them near the origin.

mod files;
pub mod gltf;
pub mod grid;
pub mod honeybee;
pub mod info;
pub mod obj;
pub mod outline;
pub(crate) mod pane;
pub mod points;
pub(crate) mod polygon;
pub mod rad;
pub(crate) mod shapes;
pub mod windows;

pub(crate) use files::{Format, read_model_view, read_scene_and_scattering, split_part};
pub use files::{read_scene, read_scene_with, read_sensors, read_windows};
pub use pane::{GlazedWindow, Pane};
pub(crate) use rad::ScatteringData;

use crate::bins::{AngleBasis, Frame};
use glam::DVec3;

/// Index into [`Scene::materials`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, bytemuck::NoUninit)]
#[repr(transparent)]
pub struct MaterialIndex(pub u32);

/// How a surface answers to light. Colours are RGB in 0…1, radiances W/m²sr; parameters as in
/// Radiance's reference manual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MaterialKind {
    /// Diffuse of the given colour and an uncoloured specular part.
    Plastic {
        /// Colour.
        color: [f64; 3],
        /// Specular fraction.
        specularity: f64,
        /// RMS facet slope; 0 is a perfect mirror component.
        roughness: f64,
    },
    /// As plastic, with the specular part coloured too.
    Metal {
        /// Colour.
        color: [f64; 3],
        /// Specular fraction.
        specularity: f64,
        /// RMS facet slope.
        roughness: f64,
    },
    /// Translucent: diffuse and specular, reflected and transmitted.
    Trans {
        /// Colour.
        color: [f64; 3],
        /// Specular fraction.
        specularity: f64,
        /// RMS facet slope.
        roughness: f64,
        /// Fraction of the non-specular light that is transmitted.
        transmissivity: f64,
        /// Fraction of the transmitted light that is not scattered.
        transmitted_specularity: f64,
    },
    /// A thin pane.
    Glass {
        /// Transmissivity (of the material for one pass at normal incidence, not transmittance).
        transmissivity: [f64; 3],
        /// Refraction index (1.52 by default).
        refraction_index: f64,
    },
    /// A perfect mirror.
    Mirror {
        /// Reflectance.
        color: [f64; 3],
    },
    /// A light source: absorbs rays, emits `radiance`.
    Light {
        /// Emitted radiance.
        radiance: [f64; 3],
    },
    /// A glowing surface: absorbs rays, emits `radiance`.
    Glow {
        /// Emitted radiance.
        radiance: [f64; 3],
        /// Distance within which it is treated as a light source (Radiance's `maxrad`).
        max_radius: f64,
    },
    /// Any other mixture of these ways to scatter light, the same on both sides.
    Lobes(Lobes),
    /// No interaction at all: rays go on (an `alias` or surface of modifier `void`).
    Void,
}

/// Shares of light that a surface sends on, each RGB in 0…1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lobes {
    /// Reflected to all directions alike (Lambert).
    pub diffuse: [f64; 3],
    /// Transmitted to all directions alike.
    pub diffuse_transmitted: [f64; 3],
    /// Reflected as by a mirror.
    pub specular: [f64; 3],
    /// Transmitted without deflection.
    pub specular_transmitted: [f64; 3],
    /// RMS facet slope of the specular parts. Where it is 0 the shares are those at normal incidence, and
    /// reflection rises towards grazing as that of a smooth plastic does.
    pub roughness: f64,
}

impl MaterialKind {
    /// The shares of light of plastic, metal, trans and mixtures of them.
    pub fn lobes(&self) -> Option<Lobes> {
        let scaled = |c: [f64; 3], f: f64| c.map(|v| v * f);
        match *self {
            Self::Plastic { color, specularity, roughness } => {
                Some(Lobes { diffuse: scaled(color, 1.0 - specularity), specular: [specularity; 3], roughness, ..Lobes::default() })
            }
            Self::Metal { color, specularity, roughness } => Some(Lobes {
                diffuse: scaled(color, 1.0 - specularity),
                specular: scaled(color, specularity),
                roughness,
                ..Lobes::default()
            }),
            Self::Trans { color, specularity, roughness, transmissivity, transmitted_specularity } => {
                let transmitted = transmissivity * (1.0 - specularity);
                Some(Lobes {
                    diffuse: scaled(color, 1.0 - specularity - transmitted),
                    diffuse_transmitted: scaled(color, transmitted * (1.0 - transmitted_specularity)),
                    specular: [specularity; 3],
                    specular_transmitted: scaled(color, transmitted * transmitted_specularity),
                    roughness,
                })
            }
            Self::Lobes(lobes) => Some(lobes),
            Self::Glass { .. } | Self::Mirror { .. } | Self::Light { .. } | Self::Glow { .. } | Self::Void => None,
        }
    }
}

/// A named material.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Identifier in the scene file.
    pub name: String,
    /// Behaviour.
    pub kind: MaterialKind,
}

/// One triangle. Its front is the side from which the vertices run counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// Corners.
    pub vertices: [DVec3; 3],
    /// Material.
    pub material: MaterialIndex,
    /// Index into [`Scene::surfaces`].
    pub surface: u32,
}

impl Triangle {
    /// Unit normal of its front; zero of one without area.
    pub(crate) fn normal(&self) -> DVec3 {
        let [a, b, c] = self.vertices;
        (b - a).cross(c - a).normalize_or_zero()
    }
}

/// Where a group of triangles came from, for messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SurfaceOrigin {
    /// Identifier of the surface in its file.
    pub name: String,
    /// File it was read from.
    pub file: std::path::PathBuf,
    /// Line of its first word.
    pub line: usize,
}

/// Infinitely distant source (`source` primitive): the sky, the ground or a sun.
#[derive(Debug, Clone, PartialEq)]
pub struct DistantSource {
    /// Identifier in its file.
    pub name: String,
    /// Name of its modifier (for instance `sol2933`).
    pub modifier: String,
    /// Direction towards the source, unit length.
    pub direction: DVec3,
    /// Full opening angle, degrees.
    pub angle: f64,
    /// Emitted radiance.
    pub radiance: [f64; 3],
}

/// Everything read from the scene files.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scene {
    /// All surfaces, cut into triangles.
    pub triangles: Vec<Triangle>,
    /// All materials in use.
    pub materials: Vec<Material>,
    /// Origin of each surface.
    pub surfaces: Vec<SurfaceOrigin>,
    /// Distant sources.
    pub sources: Vec<DistantSource>,
    /// All windows of the building, of which each absorbs what light of others meets it (see [`windows`]). Set
    /// by [`Scene::set_windows`]; empty if only those count that a computation is given.
    pub windows: Vec<Window>,
    /// Shaders are made for every feature a scene could have, not for those it has: a check that what
    /// is left out changes nothing.
    pub unpruned: bool,
}

/// A window: the receiver of view rays and sender of daylight rays. All its polygons share one
/// modifier, one normal (area-weighted mean, pointing **into the room**) and one basis.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Modifier of its polygons in the file, or the project's name for it.
    pub name: String,
    /// Its area, cut into triangles.
    pub triangles: Vec<[DVec3; 3]>,
    /// Local frame (normal into the room, up vector).
    pub frame: Frame,
    /// Directional basis of V's columns and D's rows.
    pub basis: AngleBasis,
    /// Where it was read from.
    pub origin: SurfaceOrigin,
}

impl Window {
    /// Area in m².
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
    }

    /// Where it faces: of its outward normal the azimuth, degrees clockwise from north (+y), and the altitude, degrees;
    /// 90 is a roof light.
    pub fn faces(&self) -> [f64; 2] {
        let out = -self.frame.z;
        let level = out.x.hypot(out.y) < 1e-9;
        // Rounded, so that a wall of rounded corners faces where it is drawn to face.
        let round = |degrees: f64| (degrees * 100.0).round() / 100.0 + 0.0;
        let azimuth = if level { 0.0 } else { round(out.x.atan2(out.y).to_degrees().rem_euclid(360.0)) % 360.0 };
        [azimuth, round(out.z.clamp(-1.0, 1.0).asin().to_degrees())]
    }

    /// Whether it is the same opening, or has the other as a part, whatever their names and bases.
    pub(crate) fn is_in_place_of(&self, other: &Self) -> bool {
        self.triangles == other.triangles || self.has_as_part(other)
    }
}

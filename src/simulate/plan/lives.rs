//! How long paths live, from a few walks on the host.

use crate::bvh::Caster;
use crate::random::Random;
use crate::scene::{MaterialKind, Triangle};
use crate::simulate::inputs::Inputs;

/// How long paths live in a scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lives {
    /// Share of its weight that a path keeps at a surface.
    pub kept: f64,
    /// Radiance's `-ab`.
    bounces: Option<u32>,
    /// Weight below which Russian roulette begins.
    roulette: f64,
}

impl Lives {
    pub fn new(inputs: &Inputs, bounces: Option<u32>, roulette: f32) -> Self {
        Self { kept: mean_kept(inputs).clamp(0.05, 0.95), bounces, roulette: f64::from(roulette) }
    }

    pub fn most(&self) -> f64 {
        self.bounces.map_or(f64::INFINITY, |b| f64::from(b.saturating_sub(1)))
    }

    /// Reflections before roulette begins.
    pub fn certain(&self) -> f64 {
        self.roulette.ln() / self.kept.ln()
    }

    /// Vertices of the longest of so many paths.
    pub fn most_vertices(&self, paths: f64) -> f64 {
        (self.certain() + paths.max(1.0).ln() / (1.0 / self.kept).ln()).min(self.most())
    }
}

/// What a path that starts in a window keeps of its weight at a surface, on average: by walks of some
/// reflections on the host, as far as they are alive. What meets a window or nothing keeps nothing.
fn mean_kept(inputs: &Inputs) -> f64 {
    const WALKS: usize = 512;
    const MOST: usize = 8;
    let scene = &inputs.scene;
    let kind = |t: &Triangle| scene.materials[t.material.0 as usize].kind;
    // Paths pass panes of glass; they are no vertices.
    let solid: Vec<&Triangle> =
        scene.triangles.iter().filter(|t| !matches!(kind(t), MaterialKind::Glass { .. } | MaterialKind::Void)).collect();
    let (Some(surfaces), Some(windows)) = (
        Caster::new(solid.iter().map(|t| t.vertices).collect()),
        Caster::new(inputs.windows.iter().flat_map(|w| w.window.triangles.clone()).collect()),
    ) else {
        return 0.0;
    };
    let (mut alive, mut kept) = (0.0, 0.0);
    for walk in 0..WALKS {
        let mut random = Random(walk as u64);
        let window = &inputs.windows[walk % inputs.windows.len()].window;
        let mut origin = random.point_on(&window.triangles);
        let mut direction = random.cosine_direction(window.frame.z);
        let mut weight = 1.0;
        for _ in 0..MOST {
            alive += weight;
            let Some((distance, number)) = surfaces.nearest(origin, direction, 1e-6) else { break };
            if windows.nearest(origin, direction, 1e-6).is_some_and(|(d, _)| d < distance) {
                break;
            }
            weight *= match kind(solid[number]) {
                MaterialKind::Plastic { color, .. } | MaterialKind::Metal { color, .. } => largest(color),
                MaterialKind::Trans { color, .. } | MaterialKind::Mirror { color } => largest(color),
                MaterialKind::Lobes(l) => {
                    largest(std::array::from_fn(|c| l.diffuse[c] + l.diffuse_transmitted[c] + l.specular[c] + l.specular_transmitted[c]))
                }
                _ => 0.0,
            };
            kept += weight;
            let [a, b, c] = solid[number].vertices;
            let normal = (b - a).cross(c - a).normalize_or(direction);
            origin += distance * direction;
            direction = random.cosine_direction(if normal.dot(direction) < 0.0 { normal } else { -normal });
        }
    }
    if alive > 0.0 { kept / alive } else { 0.0 }
}

fn largest(color: [f64; 3]) -> f64 {
    color.into_iter().fold(0.0, f64::max)
}

//! What the f64 references of tracing kernels share: plain analog path tracing against every triangle, with
//! nothing in common with the shaders but the scene and the bins. Slow and noisy, but plainly right; results
//! come with their standard error.

use super::{FRESNEL_THRESHOLD, SMOOTH_ROUGHNESS2, smooth_fresnel};
use crate::scene::{MaterialKind, Scene, Window};
use glam::DVec3;

/// Sum and sum of squares of a Monte-Carlo estimate.
#[derive(Debug, Clone, Copy, Default)]
pub struct Estimate {
    sum: f64,
    squares: f64,
}

impl Estimate {
    pub fn add(&mut self, value: f64) {
        self.sum += value;
        self.squares += value * value;
    }

    /// The sum of two estimates of which each sample adds to one.
    pub fn with(self, other: &Self) -> Self {
        Self { sum: self.sum + other.sum, squares: self.squares + other.squares }
    }

    pub fn mean(&self, samples: usize) -> f64 {
        self.sum / samples as f64
    }

    pub fn standard_error(&self, samples: usize) -> f64 {
        let n = samples as f64;
        ((self.squares / n - (self.sum / n).powi(2)).max(0.0) / n).sqrt()
    }
}

pub(crate) use crate::random::Random;
pub(crate) use crate::scene::pane::glass_pane;

/// What a ray meets.
pub(crate) enum Met {
    Nothing,
    Window(usize),
    Surface { distance: f64, normal: DVec3, material: MaterialKind },
}

/// Distance to a triangle.
pub(crate) fn intersect(t: &[DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (e1, e2) = (t[1] - t[0], t[2] - t[0]);
    let p = direction.cross(e2);
    let det = e1.dot(p);
    if det.abs() < 1e-14 {
        return None;
    }
    let s = origin - t[0];
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let v = direction.dot(q) / det;
    let distance = e2.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 1e-6).then_some(distance)
}

/// What a ray meets first. Windows count only if given.
pub(crate) fn meet(scene: &Scene, windows: &[Window], origin: DVec3, direction: DVec3) -> Met {
    let mut nearest = f64::INFINITY;
    let mut met = Met::Nothing;
    for t in &scene.triangles {
        if let Some(distance) = intersect(&t.vertices, origin, direction).filter(|&d| d < nearest) {
            nearest = distance;
            let [a, b, c] = t.vertices;
            met =
                Met::Surface { distance, normal: (b - a).cross(c - a).normalize(), material: scene.materials[t.material.0 as usize].kind };
        }
    }
    for (i, w) in windows.iter().enumerate() {
        for t in &w.triangles {
            if let Some(distance) = intersect(t, origin, direction).filter(|&d| d < nearest) {
                nearest = distance;
                met = Met::Window(i);
            }
        }
    }
    met
}

/// Where light goes on.
pub(crate) struct Scattered {
    pub direction: DVec3,
    pub weight: [f64; 3],
    pub diffuse: bool,
}

fn largest(c: [f64; 3]) -> f64 {
    c[0].max(c[1]).max(c[2])
}

/// Radiance's material models for smooth and rough surfaces, one lobe chosen at random.
pub(crate) fn scatter(material: &MaterialKind, incoming: DVec3, normal: DVec3, random: &mut Random) -> Option<Scattered> {
    let front = incoming.dot(normal) < 0.0;
    let facing = if front { normal } else { -normal };
    let cosine = -incoming.dot(facing);
    let mirrored = incoming + facing * (2.0 * cosine);
    let scale = |c: [f64; 3], f: f64| c.map(|v| v * f);
    // Lobes: weight, and what to do.
    let (diffuse, transmitted, specular, through, rough) = match *material {
        MaterialKind::Plastic { color, specularity, roughness } => {
            (scale(color, 1.0 - specularity), [0.0; 3], [specularity; 3], [0.0; 3], roughness)
        }
        MaterialKind::Metal { color, specularity, roughness } => {
            (scale(color, 1.0 - specularity), [0.0; 3], scale(color, specularity), [0.0; 3], roughness)
        }
        MaterialKind::Trans { color, specularity, roughness, transmissivity, transmitted_specularity } => {
            let t = transmissivity * (1.0 - specularity);
            (
                scale(color, 1.0 - specularity - t),
                scale(color, t * (1.0 - transmitted_specularity)),
                [specularity; 3],
                scale(color, t * transmitted_specularity),
                roughness,
            )
        }
        MaterialKind::Lobes(l) => (l.diffuse, l.diffuse_transmitted, l.specular, l.specular_transmitted, l.roughness),
        MaterialKind::Mirror { color } => {
            return front.then_some(Scattered { direction: mirrored, weight: color, diffuse: false });
        }
        MaterialKind::Glass { transmissivity, refraction_index } => {
            let (t, r) = glass_pane(transmissivity, refraction_index, cosine);
            let p = largest(t) / (largest(t) + largest(r));
            return Some(if random.next() < p {
                Scattered { direction: incoming, weight: scale(t, 1.0 / p), diffuse: false }
            } else {
                Scattered { direction: mirrored, weight: scale(r, 1.0 / (1.0 - p)), diffuse: false }
            });
        }
        _ => return None,
    };
    let smooth = rough * rough <= SMOOTH_ROUGHNESS2;
    let (specular, rest) = if smooth && largest(specular) >= FRESNEL_THRESHOLD {
        let f = smooth_fresnel(cosine);
        (specular.map(|s| s + f * (1.0 - s)), 1.0 - f)
    } else {
        (specular, 1.0)
    };
    let lobes = [scale(diffuse, rest), scale(transmitted, rest), specular, scale(through, rest)];
    let total: f64 = lobes.iter().map(|&l| largest(l)).sum();
    if total <= 0.0 {
        return None;
    }
    let mut pick = random.next() * total;
    let mut chosen = 0;
    while chosen < 3 && pick >= largest(lobes[chosen]) {
        pick -= largest(lobes[chosen]);
        chosen += 1;
    }
    let weight = scale(lobes[chosen], total / largest(lobes[chosen]));
    match chosen {
        0 => Some(Scattered { direction: random.cosine_direction(facing), weight, diffuse: true }),
        1 => Some(Scattered { direction: random.cosine_direction(-facing), weight, diffuse: true }),
        _ => {
            assert!(smooth, "the reference covers smooth surfaces only");
            Some(Scattered { direction: if chosen == 2 { mirrored } else { incoming }, weight, diffuse: false })
        }
    }
}

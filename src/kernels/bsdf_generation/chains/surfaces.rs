//! The surfaces on which chains begin.

use crate::kernels::bsdf_generation::Job;
use crate::kernels::trace::MATERIAL_SURFACE;
use glam::DVec3;

/// Steps of normals' components, and of depth in the sample, within which sides count as alike.
const NORMAL_STEPS: f64 = 4.0;
const LAYERS: f64 = 16.0;

/// A side of a diffuse triangle.
pub(super) struct Side {
    /// With the material's number in the second's last place.
    pub corners: [[f32; 4]; 3],
    /// Area times albedo.
    pub strength: f64,
    /// Sides of one group are alike: as to material, normal and depth in the sample.
    pub group: usize,
}

/// The diffuse surfaces of a job, and how many chains begin on each.
pub(in crate::kernels::bsdf_generation) struct Surfaces {
    pub(super) sides: Vec<Side>,
    pub(super) groups: usize,
    /// Area of all sides times albedo, over the area of the sample.
    strength: f64,
    /// Share of each side in all chains; they sum to 1.
    pub(super) shares: Vec<f64>,
}

impl Surfaces {
    /// Finds them among the first `count` triangles: the copies that follow belong to neighbours.
    pub fn of(job: &Job, count: usize) -> Self {
        let (tables, size) = (&job.tables, job.high - job.low);
        let mut found = Vec::new();
        for (corners, &number) in tables.triangles.iter().zip(&tables.triangle_materials).take(count) {
            let material = &tables.materials[number as usize];
            let largest = |c: [f32; 3]| f64::from(c[0].max(c[1]).max(c[2]));
            let albedo = largest(material.diffuse) + largest(material.diffuse_transmitted);
            if material.kind != MATERIAL_SURFACE || albedo <= 0.0 {
                continue;
            }
            // Cut into layers, since light fades with depth.
            for (layer, [a, b, c]) in layers(corners.map(|p| p.as_dvec3()), f64::from(job.low.z), f64::from(size.z) / LAYERS) {
                let area = (b - a).cross(c - a);
                for (normal, corners) in [(area, [a, b, c]), (-area, [a, c, b])] {
                    let step = (normal.normalize_or_zero() * NORMAL_STEPS).round().as_ivec3();
                    let mut corners = corners.map(|p| [p.x as f32, p.y as f32, p.z as f32, 0.0]);
                    corners[1][3] = f32::from_bits(number);
                    found.push(((number, step.x, step.y, step.z, layer), area.length() / 2.0 * albedo, corners));
                }
            }
        }
        // Alike sides side by side, so that evenly spread numbers treat all kinds evenly.
        found.sort_by_key(|(key, ..)| *key);
        let mut group = 0;
        let mut sides: Vec<Side> = Vec::with_capacity(found.len());
        for k in 0..found.len() {
            let (key, strength, corners) = found[k];
            group += usize::from(k > 0 && found[k - 1].0 != key);
            sides.push(Side { corners, strength, group });
        }
        let sum: f64 = sides.iter().map(|s| s.strength).sum();
        let shares = sides.iter().map(|s| s.strength / sum).collect();
        Self { sides, groups: group + 1, strength: sum / f64::from(size.x * size.y), shares }
    }

    /// Whether nothing scatters diffusely.
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// The table `diffuse_triangles` of `chain_start.wgsl`.
    pub fn table(&self) -> Vec<[f32; 4]> {
        let mut limit = 0.0;
        let mut table = Vec::with_capacity(3 * self.sides.len());
        for (side, share) in self.sides.iter().zip(&self.shares) {
            limit += share;
            let mut corners = side.corners;
            corners[0][3] = limit as f32;
            table.extend(corners);
        }
        table
    }

    /// Strength of a chain from a side: of all surfaces, over the density of its first point.
    pub fn factors(&self) -> Vec<f64> {
        let sum: f64 = self.sides.iter().map(|s| s.strength).sum();
        self.sides.iter().zip(&self.shares).map(|(side, share)| self.strength * side.strength / sum / share).collect()
    }
}

/// The pieces of a triangle between planes z = `bottom` + k `height`, with the number of their layer.
fn layers(triangle: [DVec3; 3], bottom: f64, height: f64) -> Vec<(i32, [DVec3; 3])> {
    let layer = |z: f64| ((z - bottom) / height).floor() as i32;
    let (low, high) = triangle.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.z), b.max(p.z)));
    if layer(low) == layer(high) || !(height > 0.0) {
        return vec![(layer(low), triangle)];
    }
    let mut pieces = Vec::new();
    for k in layer(low)..=layer(high) {
        let above = clip(&triangle, |p| p.z - (bottom + f64::from(k) * height));
        let slice = clip(&above, |p| bottom + f64::from(k + 1) * height - p.z);
        pieces.extend(slice.windows(2).skip(1).map(|w| (k, [slice[0], w[0], w[1]])));
    }
    pieces
}

/// The part of a convex polygon where `inside` is not negative (Sutherland and Hodgman).
fn clip(polygon: &[DVec3], inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (a, b) = (inside(p), inside(q));
        if a >= 0.0 {
            kept.push(p);
        }
        if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
            kept.push(p + (q - p) * (a / (a - b)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_keep_area_and_stay_in_their_bounds() {
        let triangle = [DVec3::new(0.0, 0.0, -0.3), DVec3::new(2.0, 0.1, 0.45), DVec3::new(0.3, 1.0, 0.95)];
        let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]);
        let pieces = layers(triangle, -0.3, 0.1);
        assert!(pieces.len() > 12);
        let sum: DVec3 = pieces.iter().map(|(_, t)| area(t)).sum();
        assert!((sum - area(&triangle)).length() < 1e-12, "same area, same side");
        for (k, t) in &pieces {
            let (low, high) = (-0.3 + 0.1 * f64::from(*k), -0.2 + 0.1 * f64::from(*k));
            assert!(t.iter().all(|p| p.z > low - 1e-9 && p.z < high + 1e-9));
        }
        assert_eq!(layers(triangle, -1.0, 5.0), [(0, triangle)]);
        assert_eq!(layers(triangle, -1.0, 0.0).len(), 1);
    }
}

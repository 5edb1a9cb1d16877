//! Acceleration structure for rays: obvhs' eight-wide compressed BVH, laid out for the shaders.

mod cast;

pub(crate) use cast::Caster;

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::{Boundable, BvhBuildParams};

/// Nodes and triangle order as `shaders/shared/bvh.wgsl` reads them.
#[derive(Debug, Clone)]
pub(crate) struct Bvh {
    /// 80-byte nodes (`obvhs::cwbvh::CwBvhNode`), five `vec4<u32>` each.
    pub nodes: Vec<[u32; 20]>,
    /// For each place in the leaves, the index of the triangle among those given.
    pub order: Vec<u32>,
}

/// Rounding of the slab test, relative to the largest coordinate: boxes are widened by it so that
/// no ray slips between a box and the triangle inside.
const BOX_MARGIN: f32 = 2e-6;

struct PaddedTriangle([Vec3; 3]);

impl Boundable for PaddedTriangle {
    fn aabb(&self) -> Aabb {
        let [a, b, c] = self.0;
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        let margin = Vec3::splat(BOX_MARGIN * (low.abs().max(high.abs()).max_element() + 0.5));
        Aabb::new(Vec3A::from(low - margin), Vec3A::from(high + margin))
    }
}

impl Bvh {
    /// Builds the structure. Coordinates should be of order 1 near the origin.
    ///
    /// # Panics
    /// If there are no triangles: callers add one where a scene has none.
    pub(crate) fn build(triangles: &[[Vec3; 3]]) -> Self {
        assert!(!triangles.is_empty(), "a BVH needs a triangle");
        let padded: Vec<PaddedTriangle> = triangles.iter().map(|&t| PaddedTriangle(t)).collect();
        let params = if triangles.len() > 500_000 { BvhBuildParams::fast_build() } else { BvhBuildParams::medium_build() };
        let bvh = obvhs::cwbvh::builder::build_cwbvh(&padded, params, &mut std::time::Duration::default());
        Self { nodes: bytemuck::cast_slice(&bvh.nodes).to_vec(), order: bvh.primitive_indices }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_triangle_has_its_place() {
        let triangles: Vec<[Vec3; 3]> = (0..500)
            .map(|i| {
                let p = Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32);
                [p, p + Vec3::X * 0.5, p + Vec3::Y * 0.5]
            })
            .collect();
        let bvh = Bvh::build(&triangles);
        let mut order = bvh.order.clone();
        order.sort_unstable();
        order.dedup();
        assert_eq!(order.len(), triangles.len());
        assert!(!bvh.nodes.is_empty());
        assert_eq!(Bvh::build(&triangles[..1]).order, [0]);
    }
}

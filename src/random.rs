//! Random numbers of the host: SplitMix64 (Steele et al. 2014).

use glam::DVec3;
use std::f64::consts::TAU;

/// Its state.
pub(crate) struct Random(pub u64);

impl Random {
    /// Evenly distributed in [0, 1).
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Distributed as the cosine to a normal of unit length.
    pub(crate) fn cosine_direction(&mut self, normal: DVec3) -> DVec3 {
        let (r2, phi) = (self.next(), TAU * self.next());
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        (x * (r2.sqrt() * phi.cos()) + y * (r2.sqrt() * phi.sin()) + normal * (1.0 - r2).sqrt()).normalize()
    }

    /// Evenly distributed over triangles.
    pub(crate) fn point_on(&mut self, triangles: &[[DVec3; 3]]) -> DVec3 {
        let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length();
        let mut pick = self.next() * triangles.iter().map(area).sum::<f64>();
        let mut chosen = triangles[triangles.len() - 1];
        for t in triangles {
            if pick < area(t) {
                chosen = *t;
                break;
            }
            pick -= area(t);
        }
        let (u, v) = (self.next().sqrt(), self.next());
        chosen[0] * (1.0 - u) + chosen[1] * (u * (1.0 - v)) + chosen[2] * (u * v)
    }
}

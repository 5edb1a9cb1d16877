//! f64 reference of a sample's BSDF, from its definition.

use crate::bins::AngleBasis;
use crate::kernels::trace::reference::{Estimate, Met, Random, meet, scatter};
use crate::scene::Scene;
use glam::DVec3;

/// One incident bin of a sample's BSDF: the share of its light (luminance) that leaves in each bin, to
/// the outside (-z) first and then to the room. Light starts on the face of the box at `face`
/// (x, y limits in `low` and `high`, and its z), travelling to +z if `to_room`.
#[allow(clippy::too_many_arguments, reason = "a definition, spelled out")]
pub(crate) fn bsdf_column(
    scene: &Scene,
    low: [f64; 2],
    high: [f64; 2],
    face: f64,
    to_room: bool,
    basis: &AngleBasis,
    bin: usize,
    samples: usize,
    seed: u64,
) -> Vec<Estimate> {
    let mut column = vec![Estimate::default(); 2 * basis.len()];
    let mut random = Random(seed);
    for _ in 0..samples {
        let mut origin = DVec3::new(low[0] + random.next() * (high[0] - low[0]), low[1] + random.next() * (high[1] - low[1]), face);
        let mut direction = basis.direction(bin, random.next(), random.next());
        if !to_room {
            direction.z = -direction.z;
        }
        let mut weight = [1.0; 3];
        for _ in 0..1000 {
            match meet(scene, &[], origin, direction) {
                Met::Surface { distance, normal, material } => {
                    let Some(s) = scatter(&material, direction, normal, &mut random) else { break };
                    origin += direction * distance;
                    direction = s.direction;
                    for c in 0..3 {
                        weight[c] *= s.weight[c];
                    }
                }
                _ => {
                    let side = if direction.z > 0.0 { basis.len() } else { 0 };
                    let luminance: f64 = weight.iter().zip(crate::units::BRIGHTNESS_WEIGHTS).map(|(a, b)| a * b).sum();
                    column[side + basis.bin_of(direction)].add(luminance);
                    break;
                }
            }
        }
    }
    column
}

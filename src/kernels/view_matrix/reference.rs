//! f64 reference of the view matrix, from its definition.

use crate::kernels::trace::reference::{Estimate, Met, Random, meet, scatter};
use crate::scene::{Scene, Window};
use glam::DVec3;
use std::f64::consts::PI;

/// One row of V: irradiance coefficients of all windows' bins, `[bin][rgb]`. `bounces` as `-ab`.
pub(crate) fn view_row(
    scene: &Scene,
    windows: &[Window],
    position: DVec3,
    normal: DVec3,
    bounces: u32,
    samples: usize,
    seed: u64,
) -> Vec<[Estimate; 3]> {
    let firsts: Vec<usize> = windows.iter().scan(0, |n, w| Some(std::mem::replace(n, *n + w.basis.len()))).collect();
    let bins = windows.iter().map(|w| w.basis.len()).sum();
    let mut row = vec![[Estimate::default(); 3]; bins];
    let mut random = Random(seed);
    for _ in 0..samples {
        let mut origin = position;
        let mut direction = random.cosine_direction(normal.normalize());
        let mut weight = [PI; 3];
        let mut reflections = 0;
        for _ in 0..1000 {
            match meet(scene, windows, origin, direction) {
                Met::Nothing => break,
                Met::Window(w) => {
                    let frame = windows[w].frame;
                    if direction.dot(frame.z) < 0.0 {
                        let bin = firsts[w] + windows[w].basis.bin_of(frame.to_local(-direction));
                        for c in 0..3 {
                            row[bin][c].add(weight[c]);
                        }
                    }
                    break;
                }
                Met::Surface { distance, normal, material } => {
                    let Some(s) = scatter(&material, direction, normal, &mut random) else { break };
                    reflections += u32::from(s.diffuse);
                    if reflections >= bounces {
                        break;
                    }
                    origin += direction * distance;
                    direction = s.direction;
                    for c in 0..3 {
                        weight[c] *= s.weight[c];
                    }
                }
            }
        }
    }
    row
}

//! f64 reference of the daylight coefficients, from their definition: a path from the sensor through everything,
//! panes being glass, until it meets the sky.

use super::GlazedWindow;
use crate::bins::ReinhartSky;
use crate::kernels::trace::reference::{Estimate, Met, Random, meet, scatter};
use crate::scene::{Material, MaterialIndex, MaterialKind, Scene, Triangle};
use glam::DVec3;
use std::f64::consts::PI;

/// The scene with the panes among its surfaces.
pub fn glazed(scene: &Scene, windows: &[GlazedWindow]) -> Scene {
    let mut scene = scene.clone();
    for glazed in windows {
        scene.materials.push(Material { name: "pane".into(), kind: glazed.pane.material() });
        let material = MaterialIndex(scene.materials.len() as u32 - 1);
        scene.triangles.extend(glazed.window.triangles.iter().map(|t| Triangle { vertices: *t, material, surface: 0 }));
    }
    scene
}

/// One row of C, `[patch][rgb]`, and its part that nothing reflected. `bounces` as `-ab`.
#[allow(clippy::too_many_arguments, reason = "each is a different thing")]
pub fn coefficient_row(
    scene: &Scene,
    windows: &[GlazedWindow],
    position: DVec3,
    normal: DVec3,
    sky: ReinhartSky,
    bounces: u32,
    samples: usize,
    seed: u64,
) -> [Vec<[Estimate; 3]>; 2] {
    let scene = glazed(scene, windows);
    let others: Vec<_> = scene.windows.iter().filter(|o| !windows.iter().any(|w| w.window.is_in_place_of(o))).cloned().collect();
    let mut rows = [vec![[Estimate::default(); 3]; sky.len()], vec![[Estimate::default(); 3]; sky.len()]];
    let mut random = Random(seed);
    for _ in 0..samples {
        let mut origin = position;
        let mut direction = random.cosine_direction(normal.normalize());
        let mut weight = [PI; 3];
        let (mut reflections, mut direct) = (0, true);
        for _ in 0..1000 {
            match meet(&scene, &others, origin, direction) {
                Met::Window(_) => break,
                Met::Nothing => {
                    let patch = sky.bin_of(direction);
                    for row in &mut rows[..1 + usize::from(direct)] {
                        (0..3).for_each(|c| row[patch][c].add(weight[c]));
                    }
                    break;
                }
                Met::Surface { distance, normal, material } => {
                    let Some(s) = scatter(&material, direction, normal, &mut random) else { break };
                    reflections += u32::from(s.diffuse);
                    if reflections >= bounces {
                        break;
                    }
                    direct &= matches!(material, MaterialKind::Glass { .. }) && s.direction == direction;
                    origin += direction * distance;
                    direction = s.direction;
                    (0..3).for_each(|c| weight[c] *= s.weight[c]);
                }
            }
        }
    }
    rows
}

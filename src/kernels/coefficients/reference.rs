//! f64 reference of the daylight coefficients, from their definition: a path from the sensor through everything,
//! panes being glass, until it meets the sky.

use super::GlazedWindow;
use crate::bins::ReinhartSky;
use crate::kernels::trace::reference::{Estimate, Met, Random, intersect, meet, scatter};
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

/// One row of C, `[patch][rgb]`, its part that nothing reflected, that which [`compute_suns`](super::compute_suns) finds if nothing
/// is near the sensor, and that which it finds without light paths: of diffuse surfaces that see the sky, panes aside. `bounces`
/// as `-ab`.
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
) -> [Vec<[Estimate; 3]>; 4] {
    light_row(scene, windows, (position, normal), (sky.len(), &|direction| Some(sky.bin_of(direction))), bounces, samples, seed)
}

/// The same of any parts of the sky: their number, and which of them holds a direction.
pub fn light_row(
    scene: &Scene,
    windows: &[GlazedWindow],
    (position, normal): (DVec3, DVec3),
    (parts, part_of): (usize, &dyn Fn(DVec3) -> Option<usize>),
    bounces: u32,
    samples: usize,
    seed: u64,
) -> [Vec<[Estimate; 3]>; 4] {
    let scene = glazed(scene, windows);
    let others: Vec<_> = scene.windows.iter().filter(|o| !windows.iter().any(|w| w.window.is_in_place_of(o))).cloned().collect();
    let mut rows: [_; 4] = std::array::from_fn(|_| vec![[Estimate::default(); 3]; parts]);
    let mut random = Random(seed);
    for _ in 0..samples {
        let mut origin = position;
        let mut direction = random.cosine_direction(normal.normalize());
        let mut weight = [PI; 3];
        let (mut reflections, mut direct) = (0, true);
        // Whether the first reflection was diffuse; then whether light enters the room, and comes there from the sky or by a
        // diffuse reflection.
        let (mut diffuse_first, mut enters, mut plain) = (false, false, true);
        // Whether the last surface, panes aside, was diffuse.
        let mut diffuse_last = false;
        for _ in 0..1000 {
            match meet(&scene, &others, origin, direction) {
                Met::Window(_) => break,
                Met::Nothing => {
                    if let Some(part) = part_of(direction) {
                        for (row, _) in rows
                            .iter_mut()
                            .zip([true, direct, diffuse_last || (enters && plain), diffuse_last])
                            .filter(|(_, counts)| *counts)
                        {
                            (0..3).for_each(|c| row[part][c].add(weight[c]));
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
                    let passes = matches!(material, MaterialKind::Glass { .. }) && s.direction == direction;
                    if !passes {
                        diffuse_first = if direct { s.diffuse } else { diffuse_first };
                        (plain, diffuse_last) = (s.diffuse, s.diffuse);
                    } else if windows.iter().any(|w| direction.dot(w.window.frame.z) < 0.0 && lies_on(w, origin)) {
                        (enters, plain) = (diffuse_first, true);
                    }
                    direct &= passes;
                    direction = s.direction;
                    (0..3).for_each(|c| weight[c] *= s.weight[c]);
                }
            }
        }
    }
    rows
}

fn lies_on(glazed: &GlazedWindow, point: DVec3) -> bool {
    let z = glazed.window.frame.z;
    glazed.window.triangles.iter().any(|t| intersect(t, point + z, -z).is_some_and(|d| (d - 1.0).abs() < 1e-7))
}

//! f64 reference of the daylight matrix, from its definition.

use crate::bins::ReinhartSky;
use crate::kernels::trace::reference::{Estimate, Met, Random, meet, scatter};
use crate::scene::{Scene, Window};

/// One row of D: `[patch][rgb]`. `bounces` as `-ab`. The window and all others of the scene absorb.
pub(crate) fn daylight_row(
    scene: &Scene,
    window: &Window,
    bin: usize,
    sky: ReinhartSky,
    bounces: u32,
    samples: usize,
    seed: u64,
) -> Vec<[Estimate; 3]> {
    let mut row = vec![[Estimate::default(); 3]; sky.len()];
    let windows: Vec<Window> = std::iter::once(window).chain(&scene.windows).cloned().collect();
    let mut random = Random(seed);
    for _ in 0..samples {
        let mut origin = random.point_on(&window.triangles);
        let mut direction = -window.frame.to_world(window.basis.direction(bin, random.next(), random.next()));
        let mut weight = [1.0; 3];
        let mut reflections = 0;
        for _ in 0..1000 {
            match meet(scene, &windows, origin, direction) {
                Met::Window(_) => break,
                Met::Surface { distance, normal, material } => {
                    let Some(s) = scatter(&material, direction, normal, &mut random) else { break };
                    reflections += u32::from(s.diffuse);
                    if reflections > bounces {
                        break;
                    }
                    origin += direction * distance;
                    direction = s.direction;
                    for c in 0..3 {
                        weight[c] *= s.weight[c];
                    }
                }
                Met::Nothing => {
                    for (c, estimate) in row[sky.bin_of(direction)].iter_mut().enumerate() {
                        estimate.add(weight[c]);
                    }
                    break;
                }
            }
        }
    }
    row
}

// The way outside a window, against the travel of light: from the window to the sky.

import package::generated::{FAR_AWAY, MATERIAL_GLASS, MOST_PATH_SEGMENTS};
import package::shared::random::{sample_pair};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{materials, scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::sky::{sky_bin};

const NO_PATCH: u32 = 0xffffffffu;

// What holds for all paths of a dispatch.
struct Outdoors {
    sky_rows: u32,
    row_height: f32,
    // Most diffuse reflections.
    most_bounces: u32,
    // Weight below which Russian roulette decides.
    roulette_weight: f32,
}

struct Outside {
    // Sky patch that it ends in, or NO_PATCH.
    patch_index: u32,
    // Neither scattered nor mirrored: panes only.
    direct: bool,
    // Share of the patch's radiance that arrives.
    weight: vec3<f32>,
    // Diffuse reflections.
    bounces: u32,
    segments: u32,
    // Whether it came to an end.
    ended: bool,
}

// Follows path `index` of the stream `seed` from a point outside a window; its random numbers begin
// with pair `first_pair`. A path that leaves a room through the pane of a window is dropped: that
// light is counted where it passes this pane.
fn follow_outside(start: vec3<f32>, towards: vec3<f32>, index: u32, first_pair: u32, seed: u32, outdoors: Outdoors) -> Outside {
    var position = start;
    var direction = towards;
    var weight = vec3<f32>(1.0);
    var bounces = 0u;
    var result = Outside(NO_PATCH, true, vec3<f32>(0.0), 0u, 0u, false);
    var segment = 0u;
    for (; segment < MOST_PATH_SEGMENTS; segment++) {
        let hit = closest_hit(position, direction, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            result.patch_index = sky_bin(direction, outdoors.row_height, outdoors.sky_rows);
            result.weight = weight;
            result.ended = true;
            break;
        }
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let choices = sample_pair(index, first_pair + segment * 3u, seed);
        let slope = sample_pair(index, first_pair + 1u + segment * 3u, seed);
        let material = materials[triangle_material(hit.triangle)];
        let event = scatter(material, direction, facing, front, choices.x, slope);
        let passed_pane = material.kind == MATERIAL_GLASS && event.transmitted;
        result.direct = result.direct && passed_pane;
        weight *= event.weight;
        if event.lobe == LOBE_NONE || largest(weight) <= 0.0 || (passed_pane && front && material.window > 0u) {
            result.ended = true;
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        direction = event.direction;
        if event.lobe == LOBE_DIFFUSE {
            bounces += 1u;
            if bounces > outdoors.most_bounces {
                result.ended = true;
                break;
            }
            direction = cosine_direction(side, slope);
        }
        let strength = largest(weight);
        if strength < outdoors.roulette_weight {
            if choices.y * outdoors.roulette_weight >= strength {
                result.ended = true;
                break;
            }
            weight *= outdoors.roulette_weight / strength;
        }
        position = leave_surface(hit, side);
    }
    result.bounces = bounces;
    result.segments = segment + 1u;
    result.ended = result.ended || segment == MOST_PATH_SEGMENTS;
    return result;
}

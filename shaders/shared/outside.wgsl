// The way outside a window, against the travel of light: from the window to the sky.

import package::generated::{FAR_AWAY, MATERIAL_GLASS, MOST_PATH_SEGMENTS};
import package::shared::random::{sample_pair};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::sky::{sky_bin};
import package::shared::scene::{material_at};

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
    // Nothing but panes between the sky and the last diffuse reflection, or the window.
    plain: bool,
    // Share of the patch's radiance that arrives.
    weight: vec3<f32>,
    // Diffuse reflections.
    bounces: u32,
    segments: u32,
    // Whether it came to an end.
    ended: bool,
}

// A path on its way.
struct Walk {
    position: vec3<f32>,
    direction: vec3<f32>,
    weight: vec3<f32>,
    direct: bool,
    plain: bool,
    bounces: u32,
    segment: u32,
}

const GOES_ON: u32 = 0u;
const MEETS_SKY: u32 = 1u;
const ENDS: u32 = 2u;

// What one segment of a path led to.
struct Step {
    // GOES_ON, MEETS_SKY or ENDS.
    next: u32,
    // Whether it met a surface that reflects diffusely, its unit normal on the side of the sky, a point beside it there,
    // and the path's weight behind it before roulette.
    diffuse: bool,
    side: vec3<f32>,
    position: vec3<f32>,
    weight: vec3<f32>,
}

// Follows path `index` of the stream `seed` by a segment; its random numbers begin with pair `first_pair`. A path that
// leaves a room through the pane of a window is dropped: that light is counted where it passes this pane.
fn step_outside(walk: ptr<function, Walk>, index: u32, first_pair: u32, seed: u32, outdoors: Outdoors) -> Step {
    var step = Step(GOES_ON, false, vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0));
    let direction = (*walk).direction;
    let hit = closest_hit((*walk).position, direction, FAR_AWAY);
    if hit.triangle == NO_TRIANGLE {
        step.next = MEETS_SKY;
        return step;
    }
    let normal = triangle_normal(hit.triangle);
    let front = dot(normal, direction) < 0.0;
    let facing = select(-normal, normal, front);
    let segment = (*walk).segment;
    let choices = sample_pair(index, first_pair + segment * 3u, seed);
    let slope = sample_pair(index, first_pair + 1u + segment * 3u, seed);
    let material = material_at(triangle_material(hit.triangle));
    let event = scatter(material, direction, facing, front, choices.x, slope);
    let passed_pane = material.kind == MATERIAL_GLASS && event.transmitted;
    (*walk).direct = (*walk).direct && passed_pane;
    (*walk).plain = select(event.lobe == LOBE_DIFFUSE, (*walk).plain, passed_pane);
    (*walk).weight *= event.weight;
    if event.lobe == LOBE_NONE || largest((*walk).weight) <= 0.0 || (passed_pane && front && material.window > 0u) {
        step.next = ENDS;
        return step;
    }
    let side = select(facing, -facing, event.transmitted);
    (*walk).position = leave_surface(hit, side);
    (*walk).direction = event.direction;
    if event.lobe == LOBE_DIFFUSE {
        (*walk).bounces += 1u;
        if (*walk).bounces > outdoors.most_bounces {
            step.next = ENDS;
            return step;
        }
        (*walk).direction = cosine_direction(side, slope);
        step.diffuse = true;
        step.side = side;
        step.position = (*walk).position;
        step.weight = (*walk).weight;
    }
    let strength = largest((*walk).weight);
    if strength < outdoors.roulette_weight {
        if choices.y * outdoors.roulette_weight >= strength {
            step.next = ENDS;
            return step;
        }
        (*walk).weight *= outdoors.roulette_weight / strength;
    }
    return step;
}

// Follows a path from a point outside a window to its end.
fn follow_outside(start: vec3<f32>, towards: vec3<f32>, index: u32, first_pair: u32, seed: u32, outdoors: Outdoors) -> Outside {
    var walk = Walk(start, towards, vec3<f32>(1.0), true, true, 0u, 0u);
    var result = Outside(NO_PATCH, true, true, vec3<f32>(0.0), 0u, 0u, false);
    for (; walk.segment < MOST_PATH_SEGMENTS; walk.segment++) {
        let step = step_outside(&walk, index, first_pair, seed, outdoors);
        if step.next == MEETS_SKY {
            result.patch_index = sky_bin(walk.direction, outdoors.row_height, outdoors.sky_rows);
            result.weight = walk.weight;
        }
        if step.next != GOES_ON {
            result.ended = true;
            break;
        }
    }
    result.direct = walk.direct;
    result.plain = walk.plain;
    result.bounces = walk.bounces;
    result.segments = walk.segment + 1u;
    result.ended = result.ended || walk.segment == MOST_PATH_SEGMENTS;
    return result;
}

// The way of a path from a sensor, against the travel of light, through panes and by surfaces to the sky.

import package::generated::{FAR_AWAY, MATERIAL_GLASS, PI};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::outside::{GOES_ON, MEETS_SKY, ENDS};
import package::shared::random::{sample_pair};
import package::shared::scene::{material_at};

struct SensorPath {
    position: vec3<f32>,
    direction: vec3<f32>,
    // Irradiance that the path stands for, sr.
    weight: vec3<f32>,
    // Part of the windows' light that is not left to light paths.
    near_share: f32,
    bounces: u32,
    // Before the first reflection or scattering, panes aside.
    first: bool,
    // Since the last diffuse vertex.
    mirrored: bool,
    // Whether the path left a window, and the last one in a way that no ray to a window stands for.
    crossed: bool,
    counts: bool,
    travelled: f32,
    segment: u32,
}

// What holds for all paths of a sensor.
struct SensorPaths {
    near_radius: f32,
    most_bounces: u32,
    roulette_weight: f32,
    // Whether light may come by no window.
    open: bool,
}

// What one segment of a path led to.
struct SensorStep {
    // GOES_ON, MEETS_SKY or ENDS.
    next: u32,
    // Whether it met a surface that reflects diffusely, its unit normal on the side of the light, and the path's weight
    // behind it before roulette.
    diffuse: bool,
    side: vec3<f32>,
    weight: vec3<f32>,
}

// Path `index` of the stream `seed`; cosine-distributed, so that every path stands for π sr.
fn start_at_sensor(position: vec3<f32>, normal: vec3<f32>, index: u32, seed: u32) -> SensorPath {
    let direction = cosine_direction(normal, sample_pair(index, 0u, seed));
    return SensorPath(position, direction, vec3<f32>(PI), 1.0, 0u, true, false, false, true, 0.0, 0u);
}

// Which part of the light counts that comes to the path straight from the sky.
fn share_of_sky(path: SensorPath) -> f32 {
    return select(0.0, select(1.0, path.near_share, path.crossed), path.counts);
}

// Follows a path by a segment. It ends where neither light of windows nor any other is looked for.
fn step_from_sensor(path: ptr<function, SensorPath>, index: u32, seed: u32, paths: SensorPaths) -> SensorStep {
    var step = SensorStep(GOES_ON, false, vec3<f32>(0.0), vec3<f32>(0.0));
    let direction = (*path).direction;
    let hit = closest_hit((*path).position, direction, FAR_AWAY);
    if hit.triangle == NO_TRIANGLE {
        step.next = MEETS_SKY;
        return step;
    }
    (*path).travelled += hit.distance;
    let normal = triangle_normal(hit.triangle);
    let front = dot(normal, direction) < 0.0;
    let facing = select(-normal, normal, front);
    let material = material_at(triangle_material(hit.triangle));
    let segment = (*path).segment;
    let choices = sample_pair(index, 1u + segment * 3u, seed);
    let slope = sample_pair(index, 2u + segment * 3u, seed);
    let event = scatter(material, direction, facing, front, choices.x, slope);
    (*path).weight *= event.weight;
    if event.lobe == LOBE_NONE || largest((*path).weight) <= 0.0 {
        step.next = ENDS;
        return step;
    }
    let side = select(facing, -facing, event.transmitted);
    (*path).position = leave_surface(hit, side);
    (*path).direction = event.direction;
    let passed_pane = material.kind == MATERIAL_GLASS && event.transmitted;
    if passed_pane && front && material.window > 0u {
        (*path).crossed = true;
        (*path).counts = (*path).mirrored;
    }
    if event.lobe == LOBE_DIFFUSE {
        if (*path).first {
            let ratio = (*path).travelled / paths.near_radius;
            (*path).near_share = max(1.0 - ratio * ratio, 0.0);
        }
        (*path).bounces += 1u;
        if (*path).bounces > paths.most_bounces || ((*path).near_share <= 0.0 && !paths.open) {
            step.next = ENDS;
            return step;
        }
        step.diffuse = true;
        step.side = side;
        step.weight = (*path).weight;
        (*path).direction = cosine_direction(side, slope);
        (*path).mirrored = false;
    } else if !passed_pane {
        (*path).mirrored = true;
    }
    (*path).first = (*path).first && passed_pane;
    let strength = largest((*path).weight);
    if strength < paths.roulette_weight {
        if choices.y * paths.roulette_weight >= strength {
            step.next = ENDS;
            return step;
        }
        (*path).weight *= paths.roulette_weight / strength;
    }
    return step;
}

// View matrix, first half: light paths from the windows' bins into the room, one diffuse vertex
// per dispatch.
//
// A path of bin k carries the flux of radiance 1 in that bin: window area × projected solid angle
// of the bin / paths. Where it meets a diffuse surface it leaves a virtual light (Keller 1997,
// instant radiosity), which `view_matrix/gather` connects to all sensors.

import package::generated::{LightPath, LightPathParams, VirtualLight, FAR_AWAY};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, offset_from_surface, NO_TRIANGLE};
import package::shared::material::{scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::window::{window_point, window_bin_direction, projected_solid_angle};
import package::shared::counters::{counters, count_finished};
import package::shared::scene::{material_at, window_at};

const MOST_SPECULAR: u32 = 64u;

@group(0) @binding(6) var<uniform> params: LightPathParams;
// [batch][bin][path]
@group(0) @binding(7) var<storage, read_write> paths: array<LightPath>;
@group(0) @binding(8) var<storage, read_write> lights: array<VirtualLight>;

// Largest value of dot(p, direction) over the box around the receivers.
fn farthest_receiver(direction: vec3<f32>) -> f32 {
    let corner = select(params.receivers_low, params.receivers_high, direction > vec3<f32>(0.0));
    return dot(corner, direction);
}

// Whether a light could reach any receiver with nothing in the way.
fn may_reach(position: vec3<f32>, normal: vec3<f32>) -> bool {
    if farthest_receiver(normal) <= dot(position, normal) {
        return false;
    }
    return params.common_normal == 0u || farthest_receiver(-params.normal) > -dot(position, params.normal);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let path_index = id.x;
    let bin = id.y;
    let batch = id.z;
    if path_index >= params.paths || bin >= params.bins || batch >= params.batches {
        return;
    }
    let slot = (batch * params.bins + bin) * params.paths + path_index;
    let seed = hash_combine(hash_combine(params.seed, batch), params.first_list + bin);
    let index = path_index;
    var light = VirtualLight(vec3<f32>(0.0), 0.0, vec3<f32>(0.0), 0u, vec3<f32>(0.0), 0u);
    var path: LightPath;
    if params.vertex == 0u && params.started == 0u {
        var w = 0u;
        while w + 1u < params.window_count && bin >= window_at(w + 1u).first_bin {
            w += 1u;
        }
        let window = window_at(w);
        let local_bin = bin - window.first_bin;
        let point = window_point(window, sample_pair(index, 0u, seed));
        let flux = window.area * projected_solid_angle(window.first_ring, window.rings, local_bin);
        path = LightPath(offset_from_surface(point, window.z), 1u, window_bin_direction(window, local_bin, sample_pair(index, 1u, seed)), 2u, vec3<f32>(flux), 0u);
    } else {
        path = paths[slot];
    }
    // Reflections outside, before the path was given, count as well.
    let last = params.last != 0u || ((path.label >> 16u) & 0x7fffu) + params.vertex + 2u > params.most_bounces;
    var ended = path.alive == 0u;
    var segment = 0u;
    for (; segment < MOST_SPECULAR && !ended; segment++) {
        let hit = closest_hit(path.position, path.direction, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            path.alive = 0u;
            ended = true;
            break;
        }
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, path.direction) < 0.0;
        let facing = select(-normal, normal, front);
        let choices = sample_pair(index, path.pairs, seed);
        let slope = sample_pair(index, path.pairs + 1u, seed);
        path.pairs += 2u;
        let event = scatter(material_at(triangle_material(hit.triangle)), path.direction, facing, front, choices.x, slope);
        if event.lobe == LOBE_NONE || largest(event.weight) <= 0.0 {
            path.alive = 0u;
            ended = true;
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        let before = largest(path.flux);
        path.flux *= event.weight;
        path.position = leave_surface(hit, side);
        path.direction = event.direction;
        if event.lobe == LOBE_DIFFUSE {
            if may_reach(path.position, side) {
                light = VirtualLight(path.position, path.flux.x + path.flux.y + path.flux.z, side, 0u, path.flux, path.label);
            }
            path.direction = cosine_direction(side, slope);
        }
        // Analog roulette: survivors keep their strength, so no virtual light is wasted on little. Not yet where few paths
        // begin.
        let survival = select(min(largest(path.flux) / before, 1.0), 1.0, params.vertex < params.certain);
        if choices.y >= survival {
            path.alive = 0u;
        } else {
            path.flux /= survival;
        }
        if event.lobe == LOBE_DIFFUSE || path.alive == 0u {
            ended = true;
        }
    }
    if last {
        path.alive = 0u;
    }
    if path.alive != 0u {
        atomicAdd(&counters.alive, 1u);
    }
    atomicAdd(&counters.segments, segment);
    light.goes_on = path.alive;
    lights[slot] = light;
    paths[slot] = path;
    count_finished(ended || segment == MOST_SPECULAR);
}

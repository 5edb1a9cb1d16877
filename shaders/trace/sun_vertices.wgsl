// Sun matrix, first half: paths from the receivers out through the windows to the surfaces that
// scatter sunlight. Every vertex is kept; `sun_gather` connects it to all suns.
//
// One path per invocation. `throughput` is what the receiver gets (as irradiance) of radiance that
// leaves the vertex towards it.

import package::shared::receiver::{Receiver, SunVertex};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE, FAR_AWAY};
import package::shared::material::{Material, materials, scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE, MATERIAL_SURFACE};
import package::shared::window::{windows, sample_windows};
import package::shared::counters::{counters, count_finished};

struct SunPathParams {
    seed: u32,
    receivers: u32,
    // Paths per receiver and batch that one sun uses.
    paths: u32,
    batches: u32,
    window_count: u32,
    // Slots per path.
    most_vertices: u32,
    roulette_weight: f32,
    // Receivers from one batch to the next; 0 if all batches share them.
    batch_stride: u32,
    // Sets of so many paths; suns take turns in using them.
    path_sets: u32,
    padding0: u32,
    padding1: u32,
    padding2: u32,
}

const MOST_SEGMENTS: u32 = 64u;

@group(0) @binding(6) var<uniform> params: SunPathParams;
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
// [batch][receiver][set][path][vertex], zero at the start.
@group(0) @binding(8) var<storage, read_write> vertices: array<SunVertex>;

fn scatters(material: Material) -> bool {
    if material.kind != MATERIAL_SURFACE {
        return false;
    }
    return largest(material.diffuse) + largest(material.diffuse_transmitted) + largest(material.specular) + largest(material.specular_transmitted) > 0.0;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x;
    let receiver_index = id.y;
    let batch = id.z;
    let all_paths = params.paths * params.path_sets;
    if index >= all_paths || receiver_index >= params.receivers || batch >= params.batches {
        return;
    }
    let receiver = receivers[batch * params.batch_stride + receiver_index];
    let first_slot = ((batch * params.receivers + receiver_index) * all_paths + index) * params.most_vertices;
    let seed = hash_combine(hash_combine(params.seed, batch), receiver.number);
    var position = receiver.position;
    var direction: vec3<f32>;
    var throughput: vec3<f32>;
    var ended = false;
    // Receivers between slats are lit from all around.
    if params.window_count > 0u && receiver.padding1 == 0u {
        let to_window = sample_windows(position, params.window_count, sample_pair(index, 0u, seed));
        direction = to_window.direction;
        let cosine = dot(direction, receiver.normal);
        throughput = vec3<f32>(max(cosine, 0.0) * to_window.weight / f32(params.paths));
        ended = !(to_window.weight > 0.0 && cosine > 0.0);
    } else {
        direction = cosine_direction(receiver.normal, sample_pair(index, 0u, seed));
        // Irradiance: every cosine-distributed path stands for π sr.
        throughput = vec3<f32>(3.141592653589793 / f32(params.paths));
    }
    let start = largest(throughput);
    var kept = 0u;
    var segment = 0u;
    for (; segment < MOST_SEGMENTS && !ended; segment++) {
        let hit = closest_hit(position, direction, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            ended = true;
            break;
        }
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let material_index = triangle_material(hit.triangle);
        let material = materials[material_index];
        if scatters(material) {
            let beside = leave_surface(hit, facing);
            let behind = leave_surface(hit, -facing);
            vertices[first_slot + kept] = SunVertex(beside, material_index + 1u, facing, distance(beside, behind), direction, 0u, throughput, 0u);
            kept += 1u;
            if kept == params.most_vertices {
                ended = true;
                break;
            }
        }
        let choices = sample_pair(index, 1u + segment * 2u, seed);
        let slope = sample_pair(index, 2u + segment * 2u, seed);
        let event = scatter(material, direction, facing, front, choices.x, slope);
        throughput *= event.weight;
        if event.lobe == LOBE_NONE || largest(throughput) <= 0.0 {
            ended = true;
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        direction = event.direction;
        if event.lobe == LOBE_DIFFUSE {
            direction = cosine_direction(side, slope);
        }
        let strength = largest(throughput);
        let least = params.roulette_weight * start;
        if strength < least {
            if choices.y * least >= strength {
                ended = true;
                break;
            }
            throughput *= least / strength;
        }
        position = leave_surface(hit, side);
    }
    atomicAdd(&counters.segments, segment);
    count_finished(ended || segment == MOST_SEGMENTS);
}

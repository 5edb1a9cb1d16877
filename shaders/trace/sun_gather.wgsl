// Sun matrix, second half: what a receiver gets of one sun, straight and by the vertices of its
// paths. One invocation per sun, receiver and batch.

import package::shared::receiver::{Receiver, SunVertex};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::material::{materials, largest};
import package::shared::sun::{SunRecord, sun_direction, sun_transmittance, Gate, passes_gate, leaves_through_window, surface_response};
import package::shared::counters::{counters, count_finished};

struct SunGatherParams {
    seed: u32,
    receivers: u32,
    suns: u32,
    batches: u32,
    // Polygons of windows that light must pass, or boxes in their place; it comes from anywhere if
    // there are neither.
    window_count: u32,
    // Points of the disc per batch.
    disc_samples: u32,
    // Paths per receiver and batch, and their slots; 0 for straight light only.
    paths: u32,
    most_vertices: u32,
    // Receivers from one batch to the next; 0 if all batches share them.
    batch_stride: u32,
    gates: u32,
    // Sets of so many paths; the suns take turns.
    path_sets: u32,
    padding0: u32,
}

@group(0) @binding(6) var<uniform> params: SunGatherParams;
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(8) var<storage, read> suns: array<SunRecord>;
// [batch][receiver][set][path][vertex]
@group(0) @binding(9) var<storage, read> vertices: array<SunVertex>;
// [batch][receiver][sun][straight rgb, scattered rgb]
@group(0) @binding(10) var<storage, read_write> sums: array<f32>;

@group(0) @binding(11) var<storage, read> gates: array<Gate>;

fn may_come_in(origin: vec3<f32>, direction: vec3<f32>) -> bool {
    if params.gates == 0u {
        return params.window_count == 0u || leaves_through_window(origin, direction, params.window_count);
    }
    for (var g = 0u; g < params.gates; g++) {
        if passes_gate(gates[g], origin, direction) {
            return true;
        }
    }
    return false;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let sun_index = id.x;
    let receiver_index = id.y;
    let batch = id.z;
    if sun_index >= params.suns || receiver_index >= params.receivers || batch >= params.batches {
        return;
    }
    let sun = suns[sun_index];
    let receiver = receivers[batch * params.batch_stride + receiver_index];
    let seed = hash_combine(hash_combine(hash_combine(params.seed, batch), receiver.number), sun.number);
    var rays = 0u;
    var straight = vec3<f32>(0.0);
    var cosines = 0.0;
    var risen = true;
    var sample = 0u;
    for (; sample < params.disc_samples; sample++) {
        let direction = sun_direction(sun, sample_pair(sample, 0u, seed));
        let cosine = dot(direction, receiver.normal);
        risen = risen && cosine > 0.0;
        if cosine > 0.0 {
            cosines += cosine;
            if may_come_in(receiver.position, direction) {
                straight += cosine * sun_transmittance(receiver.position, direction);
                rays += 1u;
            }
        }
    }
    if risen {
        // The visible share of the exact value: no noise where nothing is in the way.
        let mean_cosine = dot(sun.direction, receiver.normal) * (1.0 - 0.25 * sun.chord * sun.chord);
        straight *= sun.solid_angle * (mean_cosine / cosines);
    } else {
        straight *= sun.solid_angle / f32(params.disc_samples);
    }
    var scattered = vec3<f32>(0.0);
    var path = 0u;
    let own_set = sun.number % params.path_sets;
    let first_path = ((batch * params.receivers + receiver_index) * params.path_sets + own_set) * params.paths;
    for (; path < params.paths; path++) {
        let first_slot = (first_path + path) * params.most_vertices;
        for (var k = 0u; k < params.most_vertices; k++) {
            let vertex = vertices[first_slot + k];
            if vertex.material == 0u {
                break;
            }
            let direction = sun_direction(sun, sample_pair(path, 1u + k, seed));
            let response = surface_response(materials[vertex.material - 1u], vertex.incoming, vertex.facing, direction) * vertex.throughput;
            if largest(response) > 0.0 {
                let side = dot(direction, vertex.facing) > 0.0;
                let start = select(vertex.position - vertex.facing * vertex.thickness, vertex.position, side);
                scattered += response * sun_transmittance(start, direction);
                rays += 1u;
            }
        }
    }
    scattered *= sun.solid_angle;
    let cell = ((batch * params.receivers + receiver_index) * params.suns + sun_index) * 6u;
    sums[cell] = straight.x;
    sums[cell + 1u] = straight.y;
    sums[cell + 2u] = straight.z;
    sums[cell + 3u] = scattered.x;
    sums[cell + 4u] = scattered.y;
    sums[cell + 5u] = scattered.z;
    atomicAdd(&counters.segments, rays);
    count_finished(sample == params.disc_samples && path == params.paths);
}

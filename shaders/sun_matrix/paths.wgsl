// Paths from the receivers out through the windows to the surfaces that scatter sunlight. Every vertex is
// kept; `sun_matrix/scattered` connects it to all suns.
//
// One path per invocation. `throughput` is what the receiver gets (as irradiance) of radiance that
// leaves the vertex towards it.

import package::generated::{Receiver, SunPathParams, PI};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::material::{cosine_direction, largest};
import package::shared::window::{sample_windows};
import package::sun_matrix::follow_path::{vertices, SunPath, SunPathEnd, follow_sun_path};
import package::shared::counters::{counters, count_finished};

@group(0) @binding(6) var<uniform> params: SunPathParams;
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = id.y * groups.x * 64u + id.x;
    // Of all sets.
    let all_paths = params.paths * params.path_sets;
    let index = number % all_paths;
    let cell = number / all_paths;
    let batch = cell / params.receivers;
    if batch >= params.batches {
        return;
    }
    let receiver = receivers[batch * params.batch_stride + cell % params.receivers];
    let first_slot = number * params.most_vertices;
    let seed = hash_combine(hash_combine(params.seed, batch), receiver.number);
    let position = receiver.position;
    var direction: vec3<f32>;
    var throughput: vec3<f32>;
    var ended = false;
    // Receivers between slats are lit from all around.
    if params.window_count > 0u && receiver.role == 0u {
        let to_window = sample_windows(position, params.window_count, sample_pair(index, 0u, seed));
        direction = to_window.direction;
        let cosine = dot(direction, receiver.normal);
        throughput = vec3<f32>(max(cosine, 0.0) * to_window.weight / f32(params.paths));
        ended = !(to_window.weight > 0.0 && cosine > 0.0);
    } else {
        direction = cosine_direction(receiver.normal, sample_pair(index, 0u, seed));
        // Irradiance: every cosine-distributed path stands for π sr.
        throughput = vec3<f32>(PI / f32(params.paths));
    }
    // [batch][receiver][set][path][vertex]
    let path = SunPath(position, index, direction, seed, throughput, first_slot, 0u, params.most_vertices, params.roulette_weight * largest(throughput));
    var end = SunPathEnd(0u, true, 0u);
    if !ended {
        end = follow_sun_path(path);
        if end.kept == 0u {
            vertices[first_slot].throughput = throughput;
        }
    }
    atomicAdd(&counters.segments, end.segments);
    count_finished(end.ended);
}

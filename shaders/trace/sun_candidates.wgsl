// Sun picture, second step: lists the pairs of a surface point and a sun that may see each other
// through an opening. Most do not, and rays of the others then go side by side.

import package::shared::pairs::{params, receivers, suns, pair_direction};
import package::shared::gates::{may_come_in};
import package::shared::counters::{count_finished};

// Numbers of the pairs, in any order.
@group(0) @binding(9) var<storage, read_write> candidates: array<u32>;
@group(0) @binding(10) var<storage, read_write> candidate_count: atomic<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let receiver_index = id.x;
    let sun_index = id.y;
    let batch = id.z;
    if receiver_index >= params.receivers || sun_index >= params.suns || batch >= params.batches {
        return;
    }
    let cell = batch * params.receivers + receiver_index;
    let receiver = receivers[cell];
    let sun = suns[sun_index];
    var listed = false;
    var sample = 0u;
    for (; sample < params.disc_samples; sample++) {
        let direction = pair_direction(receiver, sun, batch, sample);
        listed = listed || (dot(direction, receiver.normal) > 0.0 && may_come_in(receiver.position, direction, params.gates, params.window_count));
    }
    if listed {
        candidates[atomicAdd(&candidate_count, 1u)] = cell * params.suns + sun_index;
    }
    count_finished(sample == params.disc_samples);
}

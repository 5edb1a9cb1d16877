// Direct light of suns, first step: lists the pairs of a receiver and a sun that may see each other through
// an opening. Most do not, and rays of the others then go side by side.

import package::generated::{Pair};
import package::sun_matrix::pairs::{params, receivers, suns, receiver_of, is_open, pair_direction};
import package::shared::counters::{count_finished};

// In any order.
@group(0) @binding(9) var<storage, read_write> candidates: array<Pair>;
@group(0) @binding(10) var<storage, read_write> candidate_count: atomic<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    let cells = params.receivers * params.batches;
    if index >= cells * params.suns {
        return;
    }
    let pair = Pair(index % cells, index / cells);
    let receiver = receiver_of(pair.cell);
    let sun = suns[pair.sun];
    let all = params.disc_samples + params.rim;
    var listed = false;
    var sample = 0u;
    for (; sample < all && !listed; sample++) {
        listed = is_open(receiver, pair_direction(receiver, sun, pair.cell / params.receivers, sample));
    }
    if listed {
        candidates[atomicAdd(&candidate_count, 1u)] = pair;
    }
    count_finished(listed || sample == all);
}

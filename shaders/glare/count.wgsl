// Counts the pixels above the threshold in each run of pixels and hour.

import package::generated::{COMPACT_WORKGROUP};
import package::glare::compact::{params, sums, count_pixels};

// [hour][run]
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(COMPACT_WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    count_pixels(group.x, group.y, lane);
    if lane == COMPACT_WORKGROUP - 1u {
        counts[group.y * params.runs + group.x] = sums[lane];
    }
}

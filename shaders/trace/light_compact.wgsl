// Appends the virtual lights of the last vertex that give light to their bin's list, keeping their
// order, and counts them. One invocation per bin and batch.

import package::generated::{CompactParams, VirtualLight};
import package::shared::counters::{count_finished};

@group(0) @binding(6) var<uniform> params: CompactParams;
// Of the last vertex, [batch][bin][path].
@group(0) @binding(7) var<storage, read> vertex_lights: array<VirtualLight>;
// [batch][bin][room]
@group(0) @binding(8) var<storage, read_write> lights: array<VirtualLight>;
// [batch][bin]
@group(0) @binding(9) var<storage, read_write> light_counts: array<u32>;
// Paths that go on to another vertex, [batch][bin].
@group(0) @binding(10) var<storage, read_write> going_on: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let bin = id.x;
    let batch = id.y;
    if bin >= params.bins || batch >= params.batches {
        return;
    }
    let row = batch * params.bins + bin;
    var kept = light_counts[row];
    var alive = 0u;
    var i = 0u;
    for (; i < params.paths; i++) {
        let light = vertex_lights[row * params.paths + i];
        alive += light.goes_on;
        if light.strength > 0.0 && kept < params.room {
            lights[row * params.room + kept] = light;
            kept += 1u;
        }
    }
    light_counts[row] = kept;
    going_on[row] = alive;
    count_finished(i == params.paths);
}

// Moves the virtual lights that give light to the front of their bin, keeping their order, and
// counts them. One invocation per bin and batch.

import package::shared::receiver::{VirtualLight};
import package::shared::counters::{count_finished};

struct CompactParams {
    bins: u32,
    // Lights per bin and batch.
    lights: u32,
    batches: u32,
    padding: u32,
}

@group(0) @binding(6) var<uniform> params: CompactParams;
// [batch][bin][path]
@group(0) @binding(7) var<storage, read_write> lights: array<VirtualLight>;
// [batch][bin]
@group(0) @binding(8) var<storage, read_write> light_counts: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let bin = id.x;
    let batch = id.y;
    if bin >= params.bins || batch >= params.batches {
        return;
    }
    let row = batch * params.bins + bin;
    var kept = 0u;
    var i = 0u;
    for (; i < params.lights; i++) {
        let light = lights[row * params.lights + i];
        if light.strength > 0.0 {
            lights[row * params.lights + kept] = light;
            kept += 1u;
        }
    }
    light_counts[row] = kept;
    count_finished(i == params.lights);
}

// How far does a loop run on this device? Some software drivers end every loop of an invocation
// silently after a fixed number of iterations.

import package::generated::{LoopLimitParams};

@group(0) @binding(0) var<uniform> params: LoopLimitParams;
@group(0) @binding(1) var<storage, read_write> counted: array<u32>;

@compute @workgroup_size(1)
fn main() {
    // The state depends on every earlier step, so that no compiler can leave the loop out.
    var state = params.iterations;
    var done = 0u;
    while done < params.iterations {
        state = state * 1664525u + 1013904223u;
        done = done + 1u;
    }
    counted[0] = done;
    counted[1] = state;
}

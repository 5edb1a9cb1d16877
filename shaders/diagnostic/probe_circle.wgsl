// For tests: cosine and sine of angles.

import package::shared::circle::{circle};

@group(0) @binding(6) var<storage, read> turns: array<f32>;
@group(0) @binding(8) var<storage, read_write> found: array<vec2<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&turns) {
        found[id.x] = circle(turns[id.x]);
    }
}

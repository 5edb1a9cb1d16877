// Adds light to single pixels of single hours.

import package::generated::{AddParams, ADD_WORKGROUP};

@group(0) @binding(0) var<uniform> params: AddParams;
// Place in the pictures, and bits of the luminance; no place twice.
@group(0) @binding(1) var<storage, read> additions: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read_write> luminance: array<f32>;

@compute @workgroup_size(ADD_WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let i = (group.y * groups.x + group.x) * ADD_WORKGROUP + lane;
    if i < params.count {
        let addition = additions[i];
        luminance[addition.x] += bitcast<f32>(addition.y);
    }
}

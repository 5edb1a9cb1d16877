// Takes a matrix with interleaved components apart: one plane per component, with the strides and
// the padding (zeros, left as they are) that the product kernels read.

import package::generated::{PackParams, PACK_WORKGROUP};

@group(0) @binding(0) var<uniform> params: PackParams;
// [row][column][component]
@group(0) @binding(1) var<storage, read> interleaved: array<f32>;
@group(0) @binding(2) var<storage, read_write> planes: array<f32>;

@compute @workgroup_size(PACK_WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let element = (group.y * groups.x + group.x) * PACK_WORKGROUP + lane;
    if element >= params.rows * params.columns {
        return;
    }
    let row = element / params.columns;
    let column = element % params.columns;
    let place = row * params.row_stride + column * params.column_stride;
    for (var component = 0u; component < params.components; component++) {
        planes[place + component * params.plane] = interleaved[element * params.components + component];
    }
}

// C = A·B, tuned for software devices, where a load costs as much as ten multiplications: one
// subgroup computes 4·LANES rows of 8·LANES columns of one component. Per term each lane loads a
// quad of rows of A and two quads of its own columns of B; the rows are broadcast to all lanes.
// `tile` is generated for the device's number of lanes, with a named variable for each quad of
// sums, because arrays indexed at run time live in memory.

import package::shared::gemm::{params, store_block};
import package::generated::{LANES, tile};

// [component][inner][row] and [component][inner][column], in quads
@group(0) @binding(1) var<storage, read> left: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> right: array<vec4<f32>>;

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(subgroup_invocation_id) lane: u32) {
    let row_quad = group.y * LANES;
    let column_quad = group.x * 2u * LANES + lane;
    let left_at = group.z * params.left_plane + row_quad + lane;
    let right_at = group.z * params.right_plane + params.first_column + column_quad;
    tile(left_at, right_at, 4u * row_quad, 4u * column_quad, group.z);
}

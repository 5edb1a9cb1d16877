// C = A·B for one component, for graphics cards: a workgroup computes 128 × 128 entries from tiles
// in workgroup memory, each invocation 8 × 8 of them in registers (two runs of four rows and of
// four columns, so that neighbours read neighbouring banks).

import package::generated::{TILE};
import package::shared::gemm::{params, store_block};

const DEPTH: u32 = 8u;
const QUADS: u32 = TILE / 4u;

// [component][inner][row] and [component][inner][column], in quads
@group(0) @binding(1) var<storage, read> left: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> right: array<vec4<f32>>;

var<workgroup> left_tile: array<vec4<f32>, 256>;
var<workgroup> right_tile: array<vec4<f32>, 256>;

@compute @workgroup_size(16, 16)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let row_quad = index / 16u;
    let column_quad = index % 16u;
    // Each invocation carries one quad of each factor: term index / 32 of the depth, quad index % 32.
    let depth = index / QUADS;
    let quad = index % QUADS;
    var left_at = group.z * params.left_plane + depth * params.left_stride + group.y * QUADS + quad;
    var right_at = group.z * params.right_plane + depth * params.right_stride + params.first_column + group.x * QUADS + quad;

    var s0a = vec4<f32>(); var s0b = vec4<f32>();
    var s1a = vec4<f32>(); var s1b = vec4<f32>();
    var s2a = vec4<f32>(); var s2b = vec4<f32>();
    var s3a = vec4<f32>(); var s3b = vec4<f32>();
    var s4a = vec4<f32>(); var s4b = vec4<f32>();
    var s5a = vec4<f32>(); var s5b = vec4<f32>();
    var s6a = vec4<f32>(); var s6b = vec4<f32>();
    var s7a = vec4<f32>(); var s7b = vec4<f32>();

    for (var term = 0u; term < params.inner; term += DEPTH) {
        left_tile[index] = left[left_at];
        right_tile[index] = right[right_at];
        left_at += DEPTH * params.left_stride;
        right_at += DEPTH * params.right_stride;
        workgroupBarrier();
        for (var k = 0u; k < DEPTH; k++) {
            let upper = left_tile[k * QUADS + row_quad];
            let lower = left_tile[k * QUADS + 16u + row_quad];
            let a = right_tile[k * QUADS + column_quad];
            let b = right_tile[k * QUADS + 16u + column_quad];
            s0a = fma(vec4<f32>(upper.x), a, s0a); s0b = fma(vec4<f32>(upper.x), b, s0b);
            s1a = fma(vec4<f32>(upper.y), a, s1a); s1b = fma(vec4<f32>(upper.y), b, s1b);
            s2a = fma(vec4<f32>(upper.z), a, s2a); s2b = fma(vec4<f32>(upper.z), b, s2b);
            s3a = fma(vec4<f32>(upper.w), a, s3a); s3b = fma(vec4<f32>(upper.w), b, s3b);
            s4a = fma(vec4<f32>(lower.x), a, s4a); s4b = fma(vec4<f32>(lower.x), b, s4b);
            s5a = fma(vec4<f32>(lower.y), a, s5a); s5b = fma(vec4<f32>(lower.y), b, s5b);
            s6a = fma(vec4<f32>(lower.z), a, s6a); s6b = fma(vec4<f32>(lower.z), b, s6b);
            s7a = fma(vec4<f32>(lower.w), a, s7a); s7b = fma(vec4<f32>(lower.w), b, s7b);
        }
        workgroupBarrier();
    }

    let row = group.y * TILE + row_quad * 4u;
    let column = group.x * TILE + column_quad * 4u;
    store_block(row, column, group.z, s0a, s1a, s2a, s3a);
    store_block(row, column + 64u, group.z, s0b, s1b, s2b, s3b);
    store_block(row + 64u, column, group.z, s4a, s5a, s6a, s7a);
    store_block(row + 64u, column + 64u, group.z, s4b, s5b, s6b, s7b);
}

// For tests: the points of one pair of dimensions of one stream.

import package::generated::{RandomProbeParams};
import package::shared::random::{sample_pair};

@group(0) @binding(6) var<uniform> params: RandomProbeParams;
@group(0) @binding(8) var<storage, read_write> points: array<vec2<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < params.count {
        points[id.x] = sample_pair(params.first + id.x, params.dimension_pair, params.seed);
    }
}

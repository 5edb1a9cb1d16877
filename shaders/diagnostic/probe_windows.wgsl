// For tests: directions towards the windows, and points on the first of them.

import package::generated::{WindowAnswer, WindowProbeParams};
import package::shared::random::{sample_pair};
import package::shared::window::{sample_windows, window_point};
import package::shared::scene::{window_at};

@group(0) @binding(6) var<uniform> params: WindowProbeParams;
@group(0) @binding(8) var<storage, read_write> answers: array<WindowAnswer>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.count {
        return;
    }
    let found = sample_windows(params.eye, params.window_count, sample_pair(id.x, 0u, params.seed));
    let point = window_point(window_at(0), sample_pair(id.x, 1u, params.seed));
    answers[id.x] = WindowAnswer(found.direction, found.distance, point, found.weight, found.total, found.window, vec2<u32>(0u));
}

// For tests: directions towards the windows, and points on the first of them.

import package::shared::random::{sample_pair};
import package::shared::window::{windows, sample_windows, window_point};

struct WindowProbeParams {
    eye: vec3<f32>,
    seed: u32,
    count: u32,
    window_count: u32,
    padding: vec2<u32>,
}

struct WindowAnswer {
    direction: vec3<f32>,
    distance: f32,
    point: vec3<f32>,
    weight: f32,
    total: f32,
    window: u32,
    padding: vec2<u32>,
}

@group(0) @binding(6) var<uniform> params: WindowProbeParams;
@group(0) @binding(8) var<storage, read_write> answers: array<WindowAnswer>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.count {
        return;
    }
    let found = sample_windows(params.eye, params.window_count, sample_pair(id.x, 0u, params.seed));
    let point = window_point(windows[0], sample_pair(id.x, 1u, params.seed));
    answers[id.x] = WindowAnswer(found.direction, found.distance, point, found.weight, found.total, found.window, vec2<u32>(0u));
}

// What single rays see of the sun: the straight transmittance of each.

import package::shared::gates::{passes_gates};
import package::shared::sun::{SunRecord, sun_transmittance};
import package::shared::window::{windows, rings, window_triangles};
import package::shared::counters::{count_finished};

struct SunRay {
    origin: vec3<f32>,
    padding0: u32,
    direction: vec3<f32>,
    padding1: u32,
}

struct SunRayParams {
    rays: u32,
    gates: u32,
    padding0: u32,
    padding1: u32,
}

@group(0) @binding(6) var<uniform> params: SunRayParams;
@group(0) @binding(7) var<storage, read> rays: array<SunRay>;
@group(0) @binding(8) var<storage, read_write> passed: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= params.rays {
        return;
    }
    let ray = rays[index];
    var result = vec3<f32>(0.0);
    if passes_gates(ray.origin, ray.direction, params.gates) {
        result = sun_transmittance(ray.origin, ray.direction);
    }
    passed[index] = vec4<f32>(result, 0.0);
    count_finished(true);
}

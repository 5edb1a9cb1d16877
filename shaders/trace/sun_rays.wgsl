// What single rays see of the sun, or of its image in flat mirrors: the straight transmittance of each.

import package::generated::{SunRay, SunRayParams};
import package::shared::gates::{passes_gates};
import package::shared::mirrored::{mirrored_transmittance};
import package::shared::sun::{sun_transmittance};
import package::shared::window::{windows, rings, window_triangles};
import package::shared::counters::{count_finished};

// Whether rays go to an image of the sun, not to the sun itself.
override MIRRORED: bool = false;

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
    if MIRRORED {
        let image = mat3x3<f32>(params.image_x, params.image_y, params.image_z);
        result = mirrored_transmittance(ray.origin, ray.direction, image, params.gates, 0u);
    } else if passes_gates(ray.origin, ray.direction, params.gates) {
        result = sun_transmittance(ray.origin, ray.direction);
    }
    passed[index] = vec4<f32>(result, 0.0);
    count_finished(true);
}

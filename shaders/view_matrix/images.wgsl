// View matrix: images of the windows in plane smooth surfaces, by one reflection.
//
// In a plane mirror a sensor sees what its own image behind the mirror would see through it. So the
// windows are sampled from that image, as `view_matrix/direct` does from the sensor, and each ray is followed
// from the sensor by the mirror to the window, through panes. `light_paths/near` leaves these paths out.

import package::generated::{ImageParams, ImageView, FAR_AWAY, MATERIAL_GLASS};
import package::shared::random::{sample_pair, hash_combine, unit_f32};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, triangle_plane, NO_TRIANGLE};
import package::shared::material::{materials, smooth_specular, largest};
import package::shared::window::{windows, window_triangles, window_bin, sample_windows, direct_transmittance};
import package::shared::counters::{counters, count_finished};

// Panes on the way to a mirror, at most.
const MOST_MET: u32 = 32u;

@group(0) @binding(6) var<uniform> params: ImageParams;
@group(0) @binding(7) var<storage, read> views: array<ImageView>;
// [batch][view][bin][rgb], shares of the windows' solid angle seen from the image, fixed point.
@group(0) @binding(8) var<storage, read_write> sums: array<atomic<u32>>;
// That solid angle, sr: [view].
@group(0) @binding(9) var<storage, read_write> solid_angles: array<f32>;

// What part arrives of the light that the image would see coming along `-towards` from a window at this
// distance.
fn arriving(view: ImageView, towards: vec3<f32>, distance: f32, window: u32) -> vec3<f32> {
    let rise = dot(towards, view.mirror);
    // Behind the mirror there is nothing to be seen in it.
    if !(rise > 0.0 && view.depth < distance * rise) {
        return vec3<f32>(0.0);
    }
    let along = towards - 2.0 * rise * view.mirror;
    var start = view.position;
    var passed = vec3<f32>(1.0);
    for (var met = 0u; met < MOST_MET; met++) {
        let hit = closest_hit(start, along, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            break;
        }
        let material = materials[triangle_material(hit.triangle)];
        let normal = triangle_normal(hit.triangle);
        let cosine = dot(normal, along);
        let facing = select(normal, -normal, cosine > 0.0);
        let parts = smooth_specular(material, max(abs(cosine), 1e-6), cosine < 0.0);
        if triangle_plane(hit.triangle) == view.plane {
            start = leave_surface(hit, facing);
            // Up to the window, from where the ray really starts.
            let to_window = window_triangles[windows[window].first_triangle * 3u].xyz - start;
            let rest = dot(to_window, windows[window].z) / dot(towards, windows[window].z);
            return passed * parts[1] * direct_transmittance(start, towards, rest * 0.99999);
        }
        if material.kind != MATERIAL_GLASS {
            break;
        }
        passed *= parts[0];
        start = leave_surface(hit, -facing);
    }
    return vec3<f32>(0.0);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x;
    let view_index = id.y;
    let batch = id.z;
    if index >= params.samples || view_index >= params.views || batch >= params.batches {
        return;
    }
    let view = views[view_index];
    let seed = hash_combine(hash_combine(hash_combine(params.seed, batch), view.number), view.plane);
    let to_window = sample_windows(view.eye, params.window_count, sample_pair(index, 0u, seed));
    if index == 0u && batch == 0u {
        solid_angles[view_index] = to_window.total;
    }
    let cosine = dot(to_window.direction, view.normal);
    if to_window.weight > 0.0 && cosine > 0.0 {
        let passed = arriving(view, to_window.direction, to_window.distance, to_window.window);
        if largest(passed) > 0.0 {
            let share = cosine * (to_window.weight / to_window.total) * params.unit;
            // Rounded up or down at random, as in `view_matrix/direct`.
            let value = passed * share + unit_f32(hash_combine(seed + 1u, index));
            let bin = window_bin(windows[to_window.window], -to_window.direction);
            let cell = ((batch * params.views + view_index) * params.bins + bin) * 3u;
            atomicAdd(&sums[cell], u32(value.x));
            atomicAdd(&sums[cell + 1u], u32(value.y));
            atomicAdd(&sums[cell + 2u], u32(value.z));
        }
        atomicAdd(&counters.segments, 2u);
    }
    count_finished(true);
}

// Images of the windows in plane smooth surfaces, by one reflection, for sensors and pixels.
//
// In a plane mirror a sensor, or the surface point behind a pixel, sees what its own image behind the
// mirror would see through it. So the windows are sampled from that image, and each ray is followed
// from the sensor by the mirror to the window, through panes. `light_paths/near` leaves these paths out.

import package::generated::{FAR_AWAY, ImageLight, ImageParams, ImageView, MATERIAL_GLASS, MISSED, WORKGROUPS_PER_ROW};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, triangle_plane, NO_TRIANGLE};
import package::shared::material::{smooth_specular, largest};
import package::shared::window::{window_bin, sample_windows, direct_transmittance};
import package::shared::counters::{counters, count_finished};
import package::shared::scene::{material_at, window_at, window_corner};

// Panes on the way to a mirror, at most.
const MOST_MET: u32 = 32u;

@group(0) @binding(6) var<uniform> params: ImageParams;
@group(0) @binding(7) var<storage, read> views: array<ImageView>;
// [view][sample]
@group(0) @binding(8) var<storage, read_write> found: array<ImageLight>;

// What part arrives of the light that the image would see coming along `-towards` from a window.
fn arriving(view: ImageView, towards: vec3<f32>, window: u32) -> vec3<f32> {
    let rise = dot(towards, view.mirror);
    let along = towards - 2.0 * rise * view.mirror;
    var start = view.position;
    var passed = vec3<f32>(1.0);
    for (var met = 0u; met < MOST_MET; met++) {
        let hit = closest_hit(start, along, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            break;
        }
        let material = material_at(triangle_material(hit.triangle));
        let normal = triangle_normal(hit.triangle);
        let cosine = dot(normal, along);
        let facing = select(normal, -normal, cosine > 0.0);
        let parts = smooth_specular(material, max(abs(cosine), 1e-6), cosine < 0.0);
        if triangle_plane(hit.triangle) == view.plane {
            start = leave_surface(hit, facing);
            // Up to the window, from where the ray really starts.
            let to_window = window_corner(window_at(window).first_triangle, 0u).xyz - start;
            let rest = dot(to_window, window_at(window).z) / dot(towards, window_at(window).z);
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
    // Samples of a view side by side, so that few of them fill whole workgroups too.
    let path = id.y * (WORKGROUPS_PER_ROW * 64u) + id.x;
    let view_index = path / params.samples;
    if view_index >= params.views {
        return;
    }
    let view = views[view_index];
    let seed = hash_combine(hash_combine(hash_combine(params.seed, view.batch), view.number), view.plane);
    let to_window = sample_windows(view.eye, params.window_count, sample_pair(path - view_index * params.samples, 0u, seed));
    let cosine = dot(to_window.direction, view.normal);
    // Behind the mirror there is nothing to be seen in it.
    var result = ImageLight(vec3<f32>(0.0), MISSED);
    let rise = dot(to_window.direction, view.mirror);
    if to_window.weight > 0.0 && cosine > 0.0 && view.depth < to_window.distance * rise {
        let weight = cosine * to_window.weight / f32(params.samples);
        let passed = arriving(view, to_window.direction, to_window.window);
        if largest(passed) > 0.0 {
            let bin = window_bin(window_at(to_window.window), -to_window.direction);
            result = ImageLight(passed * weight, bin);
        } else {
            let reflected = smooth_specular(material_at(view.material), max(rise, 1e-6), true)[1];
            result = ImageLight(reflected * weight, MISSED);
        }
        atomicAdd(&counters.segments, 2u);
    }
    found[path] = result;
    count_finished(true);
}

// Light that comes to a point straight from windows.

import package::coefficients::deposit::{params};
import package::shared::bvh::{offset_from_surface};
import package::shared::material::{glass_pane, largest};
import package::shared::outside::{follow_outside, Outdoors, NO_PATCH};
import package::shared::window::{sample_windows, direct_transmittance};
import package::shared::scene::{material_at, window_at};

struct Entering {
    // Where it comes from, or NO_PATCH.
    patch_index: u32,
    // No reflection on its way.
    direct: bool,
    // Irradiance that this sample stands for, sr.
    weight: vec3<f32>,
    // The same as if nothing were in the way and panes let everything through.
    possible: f32,
    segments: u32,
    ended: bool,
}

// One sample of the irradiance at a point, on the side of the unit normal `side`, by light that comes to it straight
// from the windows' outer sides, panes between included.
fn light_of_windows(position: vec3<f32>, side: vec3<f32>, random: vec2<f32>, index: u32, seed: u32, most_bounces: u32) -> Entering {
    var result = Entering(NO_PATCH, false, vec3<f32>(0.0), 0.0, 0u, true);
    let to_window = sample_windows(position, params.window_count, random);
    let cosine = dot(to_window.direction, side);
    if !(to_window.weight > 0.0 && cosine > 0.0) {
        return result;
    }
    result.possible = cosine * to_window.weight;
    let window = window_at(to_window.window);
    let pane = material_at(params.first_pane + to_window.window);
    let through = glass_pane(pane.specular, pane.roughness, max(-dot(to_window.direction, window.z), 1e-6))[0];
    let passed = direct_transmittance(position, to_window.direction, to_window.distance * 0.99999) * through;
    if largest(passed) <= 0.0 {
        return result;
    }
    let start = offset_from_surface(position + to_window.direction * to_window.distance, -window.z);
    let outdoors = Outdoors(params.sky_rows, params.row_height, most_bounces, params.roulette_weight);
    let path_outside = follow_outside(start, to_window.direction, index, 0u, seed, outdoors);
    result.patch_index = path_outside.patch_index;
    result.direct = path_outside.direct;
    result.weight = passed * path_outside.weight * result.possible;
    result.segments = 1u + path_outside.segments;
    result.ended = path_outside.ended;
    return result;
}

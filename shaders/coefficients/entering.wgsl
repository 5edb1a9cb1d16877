// Light that comes to a point straight from windows.

import package::coefficients::deposit::{params};
import package::coefficients::window_ray::{window_ray};
import package::shared::outside::{follow_outside, Outdoors, NO_PATCH};

struct Entering {
    // Where it comes from, or NO_PATCH.
    patch_index: u32,
    // No reflection on its way.
    direct: bool,
    // Nothing but panes between the sky and the last diffuse reflection, or the point.
    plain: bool,
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
    var result = Entering(NO_PATCH, false, false, vec3<f32>(0.0), 0.0, 0u, true);
    let ray = window_ray(position, side, random, params.window_count, params.first_pane);
    result.possible = ray.possible;
    if !ray.arrives {
        return result;
    }
    let outdoors = Outdoors(params.sky_rows, params.row_height, most_bounces, params.roulette_weight);
    let path_outside = follow_outside(ray.start, ray.direction, index, 0u, seed, outdoors);
    result.patch_index = path_outside.patch_index;
    result.direct = path_outside.direct;
    result.plain = path_outside.plain;
    result.weight = ray.weight * path_outside.weight;
    result.segments = 1u + path_outside.segments;
    result.ended = path_outside.ended;
    return result;
}

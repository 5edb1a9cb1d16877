// Daylight coefficients of suns: where light paths leave the windows, one per invocation.
//
// The first paths of a sun come straight from it, the others by way of surfaces outside. They carry the flux of a sun that
// lights a surface facing it with irradiance 1.

import package::generated::{CoefficientParams, LightPath, SunRecord, PI};
import package::coefficients::sunlight::{path_label, sun_outside, sunlight_outside};
import package::shared::bvh::{offset_from_surface};
import package::shared::counters::{counters, count_finished};
import package::shared::disc::{disc_direction};
import package::shared::material::{cosine_direction, glass_pane, largest};
import package::shared::outside::{Outdoors};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::window::{window_point};
import package::shared::scene::{material_at, window_at};

@group(0) @binding(6) var<uniform> params: CoefficientParams;
// [batch][sun][path]
@group(0) @binding(10) var<storage, read_write> paths: array<LightPath>;
@group(0) @binding(11) var<storage, read> suns: array<SunRecord>;

// Area of a window that light is looked for through: as the sun sees it, or all.
fn seen_area(w: u32, sun: SunRecord, reflected: bool) -> f32 {
    return window_at(w).area * select(max(-dot(sun.direction, window_at(w).z), 0.0), 1.0, reflected);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x;
    let list = id.y;
    let batch = id.z;
    if index >= params.samples || list >= params.bins || batch >= params.batches {
        return;
    }
    let sun = suns[list];
    let reflected = index >= params.straight;
    // Among those of its kind, and their number.
    let own = select(index, index - params.straight, reflected);
    let count = select(params.straight, params.samples - params.straight, reflected);
    let seed = hash_combine(hash_combine(hash_combine(params.seed, batch), sun.number), select(0u, 1u, reflected));
    let slot = (batch * params.bins + list) * params.samples + index;
    paths[slot] = LightPath(vec3<f32>(0.0), 0u, vec3<f32>(0.0), 2u, vec3<f32>(0.0), 0u);
    var total = 0.0;
    for (var w = 0u; w < params.window_count; w++) {
        total += seen_area(w, sun, reflected);
    }
    if !(total > 0.0) {
        count_finished(true);
        return;
    }
    var choice = sample_pair(own, 0u, seed);
    var rest = choice.x * total;
    var w = 0u;
    var area = seen_area(0u, sun, reflected);
    while w + 1u < params.window_count && rest >= area {
        rest -= area;
        w += 1u;
        area = seen_area(w, sun, reflected);
    }
    let window = window_at(w);
    choice.x = clamp(rest / max(area, 1e-20), 0.0, 0.99999994);
    let point = window_point(window, choice);
    let start = offset_from_surface(point, -window.z);
    let random = sample_pair(own, 1u, seed);
    var towards: vec3<f32>;
    if reflected {
        towards = cosine_direction(-window.z, random);
    } else {
        towards = disc_direction(sun.direction, sun.chord, random);
    }
    let cosine = -dot(towards, window.z);
    var flux = vec3<f32>(0.0);
    var bounces = 0u;
    var segments = 1u;
    var ended = true;
    if reflected {
        let outdoors = Outdoors(params.sky_rows, params.row_height, params.most_bounces - 1u, params.roulette_weight);
        let light = sunlight_outside(start, towards, sun, params.window_count, own, hash_combine(seed, 2u), outdoors);
        flux = light.weight * (total * PI);
        bounces = light.bounces;
        segments = light.segments;
        ended = light.ended;
    } else if cosine > 0.0 && area > 0.0 {
        // The point stands for the window's share of all that the sun's centre sees.
        flux = sun_outside(start, towards, params.window_count) * (cosine * window.area / area * total);
    }
    let pane = material_at(params.first_pane + w);
    flux *= glass_pane(pane.specular, pane.roughness, max(cosine, 1e-6))[0] * (f32(params.samples) / f32(count));
    if largest(flux) > 0.0 {
        paths[slot] = LightPath(offset_from_surface(point, window.z), 1u, -towards, 2u, flux, path_label(list, bounces, true));
    }
    atomicAdd(&counters.segments, segments);
    count_finished(ended);
}

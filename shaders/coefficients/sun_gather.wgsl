// Daylight coefficients of suns: the surfaces that `coefficients/sun_surfaces` found for a sensor, connected to a sun.
//
// Each ray goes to one of every `RAYS`th surface, drawn by what it would bring in full sun.

import package::generated::{CoefficientParams, SunRecord, SunSurface, FAR_AWAY};
import package::shared::counters::{count_finished};
import package::shared::disc::{disc_direction};
import package::shared::material::{largest};
import package::shared::random::{hash_combine, unit_f32};
import package::shared::window::{leaves_through_window, direct_transmittance};

// Rays per sensor, sun and batch.
override RAYS: u32 = 8u;

@group(0) @binding(6) var<uniform> params: CoefficientParams;
// [set][batch][sensor][path]
@group(0) @binding(10) var<storage, read> surfaces: array<SunSurface>;
@group(0) @binding(11) var<storage, read> suns: array<SunRecord>;
// [batch][sensor][sun]: what arrives, rgb; of all colours together: what the rays stand for, its squares, and those of what
// the surfaces stand for; rays that found the sun, and all.
@group(0) @binding(12) var<storage, read_write> found: array<f32>;

// What a surface would bring in full sun. The disc may be above its horizon in part.
fn expected(surface: SunSurface, sun: SunRecord) -> f32 {
    return surface.strength * max(dot(surface.normal, sun.direction) + sun.chord, 0.0);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let sun_index = id.x;
    let sensor_index = id.y;
    let batch = id.z;
    if sun_index >= params.bins || sensor_index >= params.sensors || batch >= params.batches {
        return;
    }
    let sun = suns[sun_index];
    let first = (((sun.number % params.sets) * params.batches + batch) * params.sensors + sensor_index) * params.samples;
    let seed = hash_combine(hash_combine(hash_combine(params.seed, batch), sun.number), params.first_list + sensor_index);
    var arrived = vec3<f32>(0.0);
    var possible = 0.0;
    var squares = 0.0;
    var squares_of_surfaces = 0.0;
    var hits = 0.0;
    var looks = 0.0;
    var ray = 0u;
    for (; ray < RAYS; ray++) {
        var whole = 0.0;
        for (var i = ray; i < params.samples; i += RAYS) {
            let value = expected(surfaces[first + i], sun);
            whole += value;
            squares_of_surfaces += value * value;
        }
        if !(whole > 0.0) {
            continue;
        }
        possible += whole;
        squares += whole * whole;
        looks += 1.0;
        let threshold = unit_f32(hash_combine(seed, ray)) * whole;
        var sum = 0.0;
        var last = first + ray;
        for (var i = ray; i < params.samples && sum <= threshold; i += RAYS) {
            let value = expected(surfaces[first + i], sun);
            sum += value;
            last = select(last, first + i, value > 0.0);
        }
        let surface = surfaces[last];
        let random = vec2<f32>(unit_f32(hash_combine(seed + 1u, ray)), unit_f32(hash_combine(seed + 2u, ray)));
        let to_sun = disc_direction(sun.direction, sun.chord, random);
        let cosine = dot(to_sun, surface.normal);
        if cosine > 0.0 {
            let passed = direct_transmittance(surface.position, to_sun, FAR_AWAY);
            let counted = select(surface.beside, surface.through, leaves_through_window(surface.position, to_sun, params.window_count));
            let light = passed * surface.flux * (counted * cosine * whole / expected(surface, sun));
            hits += select(0.0, 1.0, largest(light) > 0.0);
            arrived += light;
        }
    }
    let cell = ((batch * params.sensors + sensor_index) * params.bins + sun_index) * 8u;
    found[cell] = arrived.x;
    found[cell + 1u] = arrived.y;
    found[cell + 2u] = arrived.z;
    found[cell + 3u] = possible;
    found[cell + 4u] = squares;
    found[cell + 5u] = squares_of_surfaces;
    found[cell + 6u] = hits;
    found[cell + 7u] = looks;
    count_finished(ray == RAYS);
}

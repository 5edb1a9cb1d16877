// Daylight coefficients of suns: surfaces by which sunlight comes to a sensor in ways that no light path from a window
// has. One of those that a path from the sensor meets, per invocation.
//
// The first paths go through the sensor's windows to surfaces outside. The others are those of `coefficients/paths`: they
// find surfaces near the sensor or in the open, and what these see through windows.

import package::generated::{CoefficientParams, Receiver, SunSurface, FRAC_1_PI, MOST_PATH_SEGMENTS, WORKGROUPS_PER_ROW};
import package::coefficients::from_sensor::{SensorPaths, start_at_sensor, step_from_sensor, share_of_sky};
import package::coefficients::window_ray::{window_ray, WindowRay};
import package::shared::counters::{counters, count_finished};
import package::shared::outside::{step_outside, Outdoors, Walk, GOES_ON};
import package::shared::random::{sample_pair, hash_combine, unit_f32};

@group(0) @binding(6) var<uniform> params: CoefficientParams;
@group(0) @binding(11) var<storage, read> sensors: array<Receiver>;
// [set][batch][sensor][path]
@group(0) @binding(10) var<storage, read_write> surfaces: array<SunSurface>;

// How likely sun is by a hole that no path has found, beside sun by a window.
const UNLIKELY: f32 = 0.05;

// What a path has met so far.
var<private> chosen: SunSurface;
var<private> sum: f32;
var<private> met: u32;
var<private> all_ended: bool;
var<private> segments: u32;

// Offers a surface: the light that it would send to the sensor in full sun, of which these parts count if the sun shines
// through a window upon it, and beside windows. One of all is kept, drawn by its strength.
fn offer(position: vec3<f32>, side: vec3<f32>, light: vec3<f32>, through: f32, beside: f32, likely: bool, seed: u32) {
    let guess = max(through, select(UNLIKELY, 1.0, likely) * beside);
    let strength = (light.x + light.y + light.z) * guess;
    sum += strength;
    met += 1u;
    if strength > 0.0 && strength > unit_f32(hash_combine(seed, met)) * sum {
        chosen = SunSurface(position, strength, side, through, light, beside);
    }
}

// Offers the surfaces that a path meets outside a window.
fn follow(ray: WindowRay, weight: vec3<f32>, index: u32, seed: u32, most_bounces: u32) {
    let outdoors = Outdoors(params.sky_rows, params.row_height, most_bounces, params.roulette_weight);
    var walk = Walk(ray.start, ray.direction, weight, true, true, 0u, 0u);
    var ended = false;
    for (; walk.segment < MOST_PATH_SEGMENTS; walk.segment++) {
        let step = step_outside(&walk, index, 0u, seed, outdoors);
        if step.diffuse {
            offer(step.position, step.side, step.weight * FRAC_1_PI, 0.0, 1.0, true, hash_combine(seed, index));
        }
        if step.next != GOES_ON {
            ended = true;
            break;
        }
    }
    segments += walk.segment + 2u;
    all_ended = all_ended && (ended || walk.segment == MOST_PATH_SEGMENTS);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = id.y * (WORKGROUPS_PER_ROW * 64u) + id.x;
    let sensor_index = number / params.samples;
    let index = number - sensor_index * params.samples;
    if sensor_index >= params.sensors || id.z >= params.batches * params.sets {
        return;
    }
    let sensor = sensors[sensor_index];
    let seed = hash_combine(hash_combine(params.seed, id.z), sensor.number);
    chosen = SunSurface(vec3<f32>(0.0), 0.0, vec3<f32>(0.0), 0.0, vec3<f32>(0.0), 0.0);
    sum = 0.0;
    met = 0u;
    all_ended = true;
    segments = 0u;
    if index < params.straight {
        let ray = window_ray(sensor.position, sensor.normal, sample_pair(index, 0u, seed), params.window_count, params.first_pane);
        if ray.arrives {
            follow(ray, ray.weight / f32(params.straight), index, hash_combine(seed, 1u), params.most_bounces);
        }
    } else {
        let own = index - params.straight;
        let share = 1.0 / f32(params.samples - params.straight);
        let path_seed = hash_combine(seed, 2u);
        let near_radius = params.near_radius * max(bitcast<f32>(sensor.role), 1.0);
        let paths = SensorPaths(near_radius, params.most_bounces, params.roulette_weight, params.open != 0u);
        var path = start_at_sensor(sensor.position, sensor.normal, own, path_seed);
        var ended = false;
        for (; path.segment < MOST_PATH_SEGMENTS; path.segment++) {
            let step = step_from_sensor(&path, own, path_seed, paths);
            if step.diffuse {
                let weight = step.weight * (FRAC_1_PI * share);
                let likely = path.crossed || params.open != 0u;
                offer(path.position, step.side, weight, path.near_share, share_of_sky(path), likely, hash_combine(path_seed + 1u, own));
                if path.near_share > 0.0 {
                    let random = sample_pair(own, 3u + path.segment * 3u, path_seed);
                    let ray = window_ray(path.position, step.side, random, params.window_count, params.first_pane);
                    if ray.arrives {
                        let seed_outside = hash_combine(path_seed, 2u + path.segment);
                        follow(ray, ray.weight * weight * path.near_share, own, seed_outside, params.most_bounces - path.bounces);
                    }
                }
            }
            if step.next != GOES_ON {
                ended = true;
                break;
            }
        }
        segments += path.segment + 1u;
        all_ended = all_ended && (ended || path.segment == MOST_PATH_SEGMENTS);
    }
    if sum > 0.0 {
        chosen.flux *= sum / chosen.strength;
        chosen.strength = sum;
    }
    surfaces[(id.z * params.sensors + sensor_index) * params.samples + index] = chosen;
    atomicAdd(&counters.segments, segments);
    count_finished(all_ended);
}

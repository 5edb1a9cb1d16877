// Daylight coefficients: what a sensor gets other than straight from its windows. Paths from the sensor,
// one per invocation.
//
// Every path of light to the sensor that crosses windows into rooms has a first crossing, seen from the sky. The path
// from the sensor finds it in two ways, of which each path of light knows one: at each diffuse vertex a ray goes to
// a window if nothing but panes lies between, and a path outside begins there; if a mirror lies between, the
// path itself goes on through the pane to the sky. The sensor's own rays to its windows are those of
// `coefficients/direct`. Light that crosses no window into a room is found by the path as well, where it meets the sky.
//
// Light of windows by a first diffuse surface farther away than `near_radius` is left to light paths.

import package::generated::{Receiver, FRAC_1_PI, LOOK_UNITS, MOST_PATH_SEGMENTS, WORKGROUPS_PER_ROW};
import package::coefficients::deposit::{params, deposit, DIRECT, OTHER, SUNLIT};
import package::coefficients::entering::{light_of_windows};
import package::coefficients::from_sensor::{SensorPaths, start_at_sensor, step_from_sensor, share_of_sky};
import package::shared::random::{sample_pair, hash_combine, unit_f32};
import package::shared::material::{largest};
import package::shared::outside::{NO_PATCH, GOES_ON, MEETS_SKY};
import package::shared::sky::{sky_bin};
import package::shared::counters::{counters, count_finished};

@group(0) @binding(11) var<storage, read> sensors: array<Receiver>;
// [sensor]: light found of windows, its sum in `LOOK_UNITS`; of the sky by no window, its sum.
@group(0) @binding(10) var<storage, read_write> looks: array<atomic<u32>>;

fn count_look(sensor_index: u32, kind: u32, weight: vec3<f32>) {
    atomicAdd(&looks[sensor_index * 4u + kind], 1u);
    atomicAdd(&looks[sensor_index * 4u + kind + 1u], u32(largest(weight) * LOOK_UNITS + 0.5));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    // Paths of a sensor side by side, so that few paths per sensor fill whole workgroups too.
    let number = id.y * (WORKGROUPS_PER_ROW * 64u) + id.x;
    let sensor_index = number / params.samples;
    let index = number - sensor_index * params.samples;
    let batch = id.z;
    if sensor_index >= params.sensors || batch >= params.batches {
        return;
    }
    let sensor = sensors[sensor_index];
    let row = batch * params.sensors + sensor_index;
    let seed = hash_combine(hash_combine(params.seed, batch), sensor.number);
    let near_radius = params.near_radius * max(bitcast<f32>(sensor.role), 1.0);
    let paths = SensorPaths(near_radius, params.most_bounces, params.roulette_weight, params.open != 0u);
    var path = start_at_sensor(sensor.position, sensor.normal, index, seed);
    var segments = 0u;
    var ended = false;
    var all_ended = true;
    for (; path.segment < MOST_PATH_SEGMENTS; path.segment++) {
        let dither = unit_f32(hash_combine(seed + 1u, index * MOST_PATH_SEGMENTS + path.segment));
        let step = step_from_sensor(&path, index, seed, paths);
        if step.next == MEETS_SKY && path.counts {
            let light = path.weight * share_of_sky(path);
            let part = select(select(SUNLIT, OTHER, path.mirrored), DIRECT, path.first);
            deposit(row, part, sky_bin(path.direction, params.row_height, params.sky_rows), light, dither);
            count_look(sensor_index, select(2u, 0u, path.crossed), light);
        }
        if step.diffuse && path.near_share > 0.0 {
            let random = sample_pair(index, 3u + path.segment * 3u, seed);
            let most_outside = params.most_bounces - path.bounces;
            let found = light_of_windows(path.position, step.side, random, index, hash_combine(seed, 2u + path.segment), most_outside);
            if found.patch_index != NO_PATCH {
                let light = step.weight * found.weight * (path.near_share * FRAC_1_PI);
                deposit(row, select(OTHER, SUNLIT, found.plain), found.patch_index, light, dither);
                count_look(sensor_index, 0u, light);
            }
            segments += found.segments;
            all_ended = all_ended && found.ended;
        }
        if step.next != GOES_ON {
            ended = true;
            break;
        }
    }
    atomicAdd(&counters.segments, segments + path.segment + 1u);
    count_finished(all_ended && (ended || path.segment == MOST_PATH_SEGMENTS));
}

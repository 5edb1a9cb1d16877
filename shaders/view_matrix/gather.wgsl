// View matrix, second half: virtual lights of each bin connected to each sensor.
//
// One invocation sums the lights of one bin and batch for one sensor, and sends rays to a few. Where nothing is in
// the way the rays add no noise at all.
//
// Connections shorter than `near_radius` are weighted down to 1/near_radius²; `light_paths/near` adds what
// they lack (Kollig and Keller 2004), so the sum is unbiased and bounded.

import package::generated::{GatherParams, Receiver, FRAC_1_PI};
import package::shared::gathering::{choose_lights, squares_of_rays, arriving, RAYS};
import package::shared::random::{hash_combine, unit_f32};
import package::shared::counters::{count_finished};

@group(0) @binding(6) var<uniform> params: GatherParams;
@group(0) @binding(7) var<storage, read> sensors: array<Receiver>;
// Lights in use: [batch][bin].
@group(0) @binding(10) var<storage, read> light_counts: array<u32>;
// [batch][bin][sensor][rgb, and two of what may arrive], sr before division by the number of paths. These two
// tell what few hits leave open: the sum of what the rays stand for, all channels together, and of its squares.
@group(0) @binding(9) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let sensor_index = id.x;
    let bin = group.y;
    let batch = group.z;
    if sensor_index >= params.sensors || bin >= params.bins || batch >= params.batches {
        return;
    }
    let sensor = sensors[sensor_index];
    let first = (batch * params.bins + bin) * params.lights;
    let light_count = light_counts[batch * params.bins + bin];
    let seed = hash_combine(hash_combine(hash_combine(params.seed, batch), bin), sensor.number);
    let step = choose_lights(sensor, first, light_count, params.near_radius, unit_f32(seed));
    if step == 0.0 {
        count_finished(true);
        return;
    }
    var arrived = vec3<f32>(0.0);
    var ray = 0u;
    for (; ray < RAYS; ray++) {
        arrived += arriving(sensor, ray);
    }
    let squares = squares_of_rays();
    let cell = ((batch * params.bins + bin) * params.sensors + sensor_index) * 5u;
    let weight = step * FRAC_1_PI;
    let total = arrived * weight;
    sums[cell] += total.x;
    sums[cell + 1u] += total.y;
    sums[cell + 2u] += total.z;
    sums[cell + 3u] += weight * f32(RAYS);
    sums[cell + 4u] += weight * weight * squares;
    count_finished(ray == RAYS);
}

// Daylight coefficients: virtual lights of each bin connected to each sensor. What a ray brings belongs to the sky
// patch, or the sun, that the light's path came from.
//
// As `view_matrix/gather`: connections shorter than `near_radius` are weighted down, and `coefficients/paths` adds what
// they lack.

import package::generated::{Receiver, FRAC_1_PI};
import package::coefficients::deposit::{params, deposit, OTHER};
import package::shared::gathering::{choose_lights, squares_of_rays, arriving, lights, chosen, RAYS};
import package::shared::random::{hash_combine, unit_f32};
import package::shared::counters::{count_finished};

@group(0) @binding(11) var<storage, read> sensors: array<Receiver>;
// Lights in use: [batch][bin].
@group(0) @binding(12) var<storage, read> light_counts: array<u32>;
// [batch][bin][sensor]: sum of what arrived, of what the rays stand for, and of its squares, all colours together.
@group(0) @binding(10) var<storage, read_write> chances: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let sensor_index = id.x;
    let bin = group.y;
    let batch = group.z;
    if sensor_index >= params.sensors || bin >= params.bins || batch >= params.batches {
        return;
    }
    let sensor = sensors[sensor_index];
    let list = batch * params.bins + bin;
    let seed = hash_combine(hash_combine(hash_combine(params.seed, batch), params.first_list + bin), sensor.number);
    let step = choose_lights(sensor, list * params.room, light_counts[list], params.near_radius, unit_f32(seed));
    if step == 0.0 {
        count_finished(true);
        return;
    }
    let weight = step * FRAC_1_PI;
    var arrived = vec3<f32>(0.0);
    var ray = 0u;
    for (; ray < RAYS; ray++) {
        let share = arriving(sensor, ray);
        if any(share > vec3<f32>(0.0)) {
            arrived += share;
            let label = lights[chosen[ray]].label;
            let part = select(OTHER, params.sunlit, (label >> 31u) == 1u);
            deposit(batch * params.sensors + sensor_index, part, label & 0xffffu, share * weight, unit_f32(hash_combine(seed + 1u, ray)));
        }
    }
    let cell = (list * params.sensors + sensor_index) * 3u;
    chances[cell] += (arrived.x + arrived.y + arrived.z) * weight;
    chances[cell + 1u] += weight * f32(RAYS);
    chances[cell + 2u] += weight * weight * squares_of_rays();
    count_finished(ray == RAYS);
}

// View matrix, second half: virtual lights of each bin connected to each sensor.
//
// One invocation sums the lights of one bin and batch for one sensor. What all of them would give
// with nothing in the way is summed exactly; rays go only to a few of them, drawn systematically in
// proportion to what they would give, and find the part that arrives. Where nothing is in the way
// the rays add no noise at all.
//
// Connections shorter than `near_radius` are weighted down to 1/near_radius²; `light_paths/near` adds what
// they lack (Kollig and Keller 2004), so the sum is unbiased and bounded.

import package::generated::{GatherParams, Receiver, VirtualLight, FRAC_1_PI, MOST_VISIBILITY_RAYS};
import package::shared::connection::{connection};
import package::shared::random::{hash_combine, unit_f32};
import package::shared::window::{direct_transmittance};
import package::shared::counters::{count_finished};

// Rays per sensor, bin and batch.
override RAYS: u32 = 8u;

@group(0) @binding(6) var<uniform> params: GatherParams;
@group(0) @binding(7) var<storage, read> sensors: array<Receiver>;
// [batch][bin][path]
@group(0) @binding(8) var<storage, read> lights: array<VirtualLight>;
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
    var unobstructed = 0.0;
    for (var i = 0u; i < light_count; i++) {
        unobstructed += lights[first + i].strength * connection(sensor, lights[first + i], params.near_radius);
    }
    if !(unobstructed > 0.0) {
        count_finished(true);
        return;
    }
    // Systematic sampling in proportion to the connections.
    let step = unobstructed / f32(RAYS);
    let seed = hash_combine(hash_combine(hash_combine(params.seed, batch), bin), sensor.number);
    var threshold = step * unit_f32(seed);
    var chosen: array<u32, MOST_VISIBILITY_RAYS>;
    var found = 0u;
    var sum = 0.0;
    var last = first;
    for (var i = 0u; i < light_count; i++) {
        let value = lights[first + i].strength * connection(sensor, lights[first + i], params.near_radius);
        sum += value;
        if value > 0.0 {
            last = first + i;
        }
        while sum > threshold && found < RAYS {
            chosen[found] = first + i;
            found += 1u;
            threshold += step;
        }
    }
    // Rounding may leave the last threshold just above the sum.
    while found < RAYS {
        chosen[found] = last;
        found += 1u;
    }
    var arrived = vec3<f32>(0.0);
    var squares = 0.0;
    var alike = 0.0;
    var ray = 0u;
    for (; ray < RAYS; ray++) {
        // Rays to one light find it together.
        alike += 1.0;
        if ray + 1u == RAYS || chosen[min(ray + 1u, RAYS - 1u)] != chosen[ray] {
            squares += alike * alike;
            alike = 0.0;
        }
        let light = lights[chosen[ray]];
        let to_light = light.position - sensor.position;
        let distance = length(to_light);
        let passed = direct_transmittance(sensor.position, to_light / distance, distance * 0.999999);
        arrived += passed * light.flux / light.strength;
    }
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

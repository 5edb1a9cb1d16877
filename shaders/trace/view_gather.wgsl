// View matrix, second half: virtual lights of each bin connected to each sensor.
//
// One invocation sums a run of lights of one bin and batch for one sensor, in a fixed order.
// Connections shorter than `near_radius` are weighted down to 1/near_radius²; `view_near` adds what
// they lack (Kollig and Keller 2004), so the sum is unbiased and bounded.

import package::shared::receiver::{Receiver, VirtualLight};
import package::shared::window::{straight_transmittance};
import package::shared::counters::{count_finished};

struct GatherParams {
    sensors: u32,
    bins: u32,
    // Lights per bin and batch, and the run that is summed now.
    lights: u32,
    first_light: u32,
    light_count: u32,
    batches: u32,
    near_radius: f32,
    padding: u32,
}

@group(0) @binding(6) var<uniform> params: GatherParams;
@group(0) @binding(7) var<storage, read> sensors: array<Receiver>;
@group(0) @binding(8) var<storage, read> lights: array<VirtualLight>;
// [batch][bin][sensor][rgb], sr before division by the number of paths.
@group(0) @binding(9) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let sensor_index = id.x;
    let bin = id.y;
    let batch = id.z;
    if sensor_index >= params.sensors || bin >= params.bins || batch >= params.batches {
        return;
    }
    let sensor = sensors[sensor_index];
    let first = (batch * params.bins + bin) * params.lights + params.first_light;
    let near2 = params.near_radius * params.near_radius;
    var sum = vec3<f32>(0.0);
    var i = 0u;
    for (; i < params.light_count; i++) {
        let light = lights[first + i];
        let to_light = light.position - sensor.position;
        let distance2 = dot(to_light, to_light);
        let cos_sensor = dot(to_light, sensor.normal);
        let cos_light = -dot(to_light, light.normal);
        if cos_sensor > 0.0 && cos_light > 0.0 && light.flux.x + light.flux.y + light.flux.z > 0.0 {
            let distance = sqrt(distance2);
            let passed = straight_transmittance(sensor.position, to_light / distance, distance * 0.999999);
            sum += passed * light.flux * (cos_sensor * cos_light / (distance2 * max(distance2, near2)));
        }
    }
    let cell = ((batch * params.bins + bin) * params.sensors + sensor_index) * 3u;
    let total = sum * 0.3183098861837907;
    sums[cell] += total.x;
    sums[cell + 1u] += total.y;
    sums[cell + 2u] += total.z;
    count_finished(i == params.light_count);
}

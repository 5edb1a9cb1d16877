// Daylight coefficients: light that comes to a sensor straight from its windows, one sample per invocation.
//
// Windows are sampled uniformly in solid angle from the sensor; outside, the path goes on to the sky.

import package::generated::{Receiver, LOOK_UNITS};
import package::coefficients::deposit::{params, deposit, DIRECT, OTHER, SUNLIT};
import package::coefficients::entering::{light_of_windows};
import package::shared::outside::{NO_PATCH};
import package::shared::random::{sample_pair, hash_combine, unit_f32};
import package::shared::counters::{counters, count_finished};

@group(0) @binding(11) var<storage, read> sensors: array<Receiver>;
// [sensor]: samples before it, those of them that light came by, sum of what they may bring in `LOOK_UNITS`.
@group(0) @binding(10) var<storage, read_write> looks: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x;
    let sensor_index = id.y;
    let batch = id.z;
    if index >= params.samples || sensor_index >= params.sensors || batch >= params.batches {
        return;
    }
    let sensor = sensors[sensor_index];
    let seed = hash_combine(hash_combine(params.seed, batch), sensor.number);
    let found = light_of_windows(sensor.position, sensor.normal, sample_pair(index, 0u, seed), index, hash_combine(seed, 1u), params.most_bounces);
    if found.possible > 0.0 {
        atomicAdd(&looks[sensor_index * 3u], 1u);
        atomicAdd(&looks[sensor_index * 3u + 2u], u32(found.possible * LOOK_UNITS + 0.5));
    }
    if found.patch_index != NO_PATCH {
        atomicAdd(&looks[sensor_index * 3u + 1u], 1u);
        let part = select(select(OTHER, SUNLIT, found.plain), DIRECT, found.direct);
        deposit(batch * params.sensors + sensor_index, part, found.patch_index, found.weight, unit_f32(hash_combine(seed + 1u, index)));
    }
    atomicAdd(&counters.segments, found.segments);
    count_finished(found.ended);
}

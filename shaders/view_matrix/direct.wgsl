// Direct view matrix: which part of each bin of the windows a sensor sees.
//
// Windows are sampled uniformly in solid angle from the sensor. Each sample adds its cosine times
// solid angle to its bin twice: what arrives of it (rgb), and as if nothing were in the way. The
// host multiplies their ratio by the exact unobstructed value.

import package::generated::{DirectParams, Receiver};
import package::shared::random::{sample_pair, hash_combine, unit_f32};
import package::shared::window::{window_bin, sample_windows, direct_transmittance};
import package::shared::counters::{count_finished};
import package::shared::scene::{window_at};

@group(0) @binding(6) var<uniform> params: DirectParams;
@group(0) @binding(7) var<storage, read> sensors: array<Receiver>;
// [batch][sensor][bin][rgb and unobstructed], fixed point.
@group(0) @binding(8) var<storage, read_write> sums: array<atomic<u32>>;

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
    let to_window = sample_windows(sensor.position, params.window_count, sample_pair(index, 0u, seed));
    let cosine = dot(to_window.direction, sensor.normal);
    if to_window.weight > 0.0 && cosine > 0.0 {
        let passed = direct_transmittance(sensor.position, to_window.direction, to_window.distance * 0.99999);
        let share = cosine * (to_window.weight / to_window.total) * params.unit;
        // Rounded up or down at random: of many samples each has few units, and those of one triangle
        // of a window are nearly equal, so that rounding to the nearest would favour one of them.
        let dither = unit_f32(hash_combine(seed + 1u, index));
        let value = passed * share + dither;
        let bin = window_bin(window_at(to_window.window), -to_window.direction);
        let cell = ((batch * params.sensors + sensor_index) * params.bins + bin) * 4u;
        atomicAdd(&sums[cell], u32(value.x));
        atomicAdd(&sums[cell + 1u], u32(value.y));
        atomicAdd(&sums[cell + 2u], u32(value.z));
        atomicAdd(&sums[cell + 3u], u32(share + dither));
    }
    count_finished(true);
}

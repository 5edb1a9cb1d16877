// Sun picture, third step: what the listed surface points get straight from their suns.

import package::shared::pairs::{params, receivers, suns, pair_direction};
import package::shared::gates::{may_come_in};
import package::shared::sun::{sun_transmittance, hidden_by_one};
import package::shared::counters::{counters, count_finished};

@group(0) @binding(9) var<storage, read> candidates: array<u32>;
// [batch][receiver][sun][straight rgb, scattered rgb]. Zero at the start.
@group(0) @binding(10) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= params.candidates {
        return;
    }
    let pair = candidates[index];
    let sun = suns[pair % params.suns];
    let cell = pair / params.suns;
    let receiver = receivers[cell];
    let batch = cell / params.receivers;
    var straight = vec3<f32>(0.0);
    var cosines = 0.0;
    var risen = true;
    var rays = 0u;
    var sample = 0u;
    // One ray in place of many where a wall is in the way, or a slat that is wide enough.
    if params.disc_samples > 2u && hidden_by_one(receiver.position, sun.direction, sun.chord, true) {
        sample = params.disc_samples;
        risen = false;
        rays += 1u;
    }
    for (; sample < params.disc_samples; sample++) {
        let direction = pair_direction(receiver, sun, batch, sample);
        let cosine = dot(direction, receiver.normal);
        risen = risen && cosine > 0.0;
        if cosine > 0.0 && may_come_in(receiver.position, direction, params.gates, params.window_count) {
            straight += cosine * sun_transmittance(receiver.position, direction);
            rays += 1u;
        }
        cosines += max(cosine, 0.0);
    }
    if risen {
        // The visible share of the exact value: no noise where nothing is in the way.
        let mean_cosine = dot(sun.direction, receiver.normal) * (1.0 - 0.25 * sun.chord * sun.chord);
        straight *= sun.solid_angle * (mean_cosine / cosines);
    } else {
        straight *= sun.solid_angle / f32(params.disc_samples);
    }
    sums[pair * 6u] = straight.x;
    sums[pair * 6u + 1u] = straight.y;
    sums[pair * 6u + 2u] = straight.z;
    atomicAdd(&counters.segments, rays);
    count_finished(sample == params.disc_samples);
}

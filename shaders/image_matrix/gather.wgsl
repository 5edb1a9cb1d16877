// View matrix of a picture, third step: the light paths' vertices (virtual lights) of all bins
// connected to each receiver.
//
// As in `view_matrix/gather`, what arrives with nothing in the way is summed exactly; but a pixel has few
// rays for all bins together, drawn in proportion to the connections. A bin's share of rays that
// arrive is its own where it has rays, and that of the whole pixel where it has none; what the rays
// found of all bins together is kept.

import package::generated::{BinShare, FRAC_1_PI, MOST_VISIBILITY_RAYS, PixelPoint, Receiver, TileParams, VirtualLight};
import package::shared::pixel::{pixel_cell};
import package::shared::connection::{connection};
import package::shared::random::{hash_combine, unit_f32};
import package::shared::window::{direct_transmittance};
import package::shared::material::{largest};
import package::shared::counters::{count_finished};

// Rays per receiver.
override RAYS: u32 = 16u;

@group(0) @binding(6) var<uniform> params: TileParams;
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
// [bin][batch][pixel]
@group(0) @binding(9) var<storage, read_write> shares: array<BinShare>;
// Radiance coefficients [bin][batch][pixel][rgb].
@group(0) @binding(10) var<storage, read_write> sums: array<f32>;
// [batch][bin][light]
@group(0) @binding(11) var<storage, read> lights: array<VirtualLight>;
// [batch][bin]
@group(0) @binding(12) var<storage, read> light_counts: array<u32>;
// [batch][pixel]
@group(0) @binding(13) var<storage, read_write> points: array<PixelPoint>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let pixel = id.x;
    let batch = group.y;
    if pixel >= params.pixels || batch >= params.batches {
        return;
    }
    let weight = points[batch * params.pixels + pixel].weight;
    if weight.x + weight.y + weight.z <= 0.0 {
        count_finished(true);
        return;
    }
    let shape = vec3<u32>(params.bins, params.batches, params.pixels);
    let receiver = receivers[batch * params.pixels + pixel];
    var total = 0.0;
    for (var bin = 0u; bin < params.bins; bin++) {
        let first = (batch * params.bins + bin) * params.lights;
        let count = light_counts[batch * params.bins + bin];
        var flux = vec3<f32>(0.0);
        for (var i = 0u; i < count; i++) {
            flux += lights[first + i].flux * connection(receiver, lights[first + i], params.near_radius);
        }
        if flux.x + flux.y + flux.z > 0.0 {
            shares[pixel_cell(shape, bin, batch, pixel)].unobstructed = flux;
            total += flux.x + flux.y + flux.z;
        }
    }
    if !(total > 0.0) {
        count_finished(true);
        return;
    }
    // Systematic sampling over all bins; only bins in which a ray falls are read again.
    let step = total / f32(RAYS);
    let seed = hash_combine(hash_combine(params.seed, batch + 0x200u), receiver.number);
    var threshold = step * unit_f32(seed);
    var chosen: array<vec2<u32>, MOST_VISIBILITY_RAYS>;
    var found = 0u;
    var sum = 0.0;
    for (var bin = 0u; bin < params.bins; bin++) {
        let flux = shares[pixel_cell(shape, bin, batch, pixel)].unobstructed;
        let bin_sum = flux.x + flux.y + flux.z;
        if bin_sum > 0.0 {
            let end = sum + bin_sum;
            if end > threshold && found < RAYS {
                let first = (batch * params.bins + bin) * params.lights;
                let count = light_counts[batch * params.bins + bin];
                var inner = sum;
                for (var i = 0u; i < count; i++) {
                    let value = lights[first + i].strength * connection(receiver, lights[first + i], params.near_radius);
                    inner += value;
                    while value > 0.0 && inner > threshold && found < RAYS {
                        chosen[found] = vec2<u32>(bin, first + i);
                        found += 1u;
                        threshold += step;
                    }
                }
            }
            sum = end;
        }
    }
    var traced = 0.0;
    var arrived = vec3<f32>(0.0);
    var hits = 0.0;
    for (var ray = 0u; ray < found; ray++) {
        let light = lights[chosen[ray].y];
        let to_light = light.position - receiver.position;
        let distance = length(to_light);
        let passed = direct_transmittance(receiver.position, to_light / distance, distance * 0.999999);
        let cell = pixel_cell(shape, chosen[ray].x, batch, pixel);
        shares[cell].traced += 1.0;
        shares[cell].arrived += passed;
        traced += 1.0;
        arrived += passed;
        hits += select(0.0, 1.0, largest(passed) > 0.0);
    }
    // A channel's share of what one ray stands for.
    let each = step * (FRAC_1_PI / 3.0 / f32(params.paths));
    let place = batch * params.pixels + pixel;
    points[place].gathered += each * traced;
    points[place].gathered_squares += each * each * traced;
    points[place].gathered_hits += each * hits;
    let mean_share = select(vec3<f32>(1.0), arrived / max(traced, 1.0), traced > 0.0);
    var scale = weight * (FRAC_1_PI / f32(params.paths));
    if hits > 0.0 && hits < traced {
        // Bins with rays have shares of their own, one after the other.
        let one = vec3<f32>(1.0);
        let wanted = total * dot(mean_share, one);
        var sum = wanted;
        for (var ray = 0u; ray < found; ray++) {
            if ray + 1u == found || chosen[min(ray + 1u, MOST_VISIBILITY_RAYS - 1u)].x != chosen[ray].x {
                let share = shares[pixel_cell(shape, chosen[ray].x, batch, pixel)];
                let part = (share.arrived + mean_share) / (share.traced + 1.0);
                sum += dot(share.unobstructed, one) * dot(part - mean_share, one);
            }
        }
        scale *= wanted / sum;
    }
    for (var bin = 0u; bin < params.bins; bin++) {
        let cell = pixel_cell(shape, bin, batch, pixel);
        let share = shares[cell];
        if share.unobstructed.x + share.unobstructed.y + share.unobstructed.z > 0.0 {
            var part = mean_share;
            if share.traced > 0.0 {
                // One ray's worth of the pixel's mean steadies bins with few rays.
                part = (share.arrived + mean_share) / (share.traced + 1.0);
            }
            let value = scale * part * share.unobstructed;
            sums[cell * 3u] += value.x;
            sums[cell * 3u + 1u] += value.y;
            sums[cell * 3u + 2u] += value.z;
            shares[cell] = BinShare(vec3<f32>(0.0), 0.0, vec3<f32>(0.0), 0u);
        }
    }
    count_finished(true);
}

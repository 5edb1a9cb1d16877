// View matrix of a picture, second step: direct irradiance of each receiver from the windows.
//
// Many samples of the windows give what would arrive with nothing in the way; rays to some of them
// give the share that does, bin by bin. What they found of all bins together is kept.

import package::generated::{BinShare, PixelPoint, Receiver, TileParams};
import package::shared::pixel::{pixel_cell};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::window::{window_bin, sample_windows, direct_transmittance};
import package::shared::material::{largest};
import package::shared::counters::{count_finished};
import package::shared::scene::{window_at};

@group(0) @binding(6) var<uniform> params: TileParams;
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
// [bin][batch][pixel], zero at the start.
@group(0) @binding(9) var<storage, read_write> shares: array<BinShare>;
// Radiance coefficients [bin][batch][pixel][rgb].
@group(0) @binding(10) var<storage, read_write> sums: array<f32>;
// [batch][pixel], with weights alone at the start.
@group(0) @binding(11) var<storage, read_write> points: array<PixelPoint>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.x;
    let batch = id.y;
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
    let seed = hash_combine(hash_combine(params.seed, batch + 0x100u), receiver.number);
    var traced = 0.0;
    var chance = PixelPoint();
    chance.weight = weight;
    var arrived = vec3<f32>(0.0);
    var sample = 0u;
    for (; sample < params.window_samples; sample++) {
        let to_window = sample_windows(receiver.position, params.window_count, sample_pair(sample, 0u, seed));
        let cosine = dot(to_window.direction, receiver.normal);
        if to_window.weight > 0.0 && cosine > 0.0 {
            let value = cosine * to_window.weight;
            let bin = window_bin(window_at(to_window.window), -to_window.direction);
            let cell = pixel_cell(shape, bin, batch, pixel);
            shares[cell].unobstructed.x += value;
            chance.direct += value;
            if sample % params.traced_every == 0u {
                let passed = direct_transmittance(receiver.position, to_window.direction, to_window.distance * 0.99999) * value;
                shares[cell].traced += value;
                shares[cell].arrived += passed;
                traced += value;
                chance.rays += 1.0;
                chance.hits += select(0.0, 1.0, largest(passed) > 0.0);
                arrived += passed;
            }
        }
    }
    // Bins that no ray met take the share of all.
    let mean_share = arrived / max(traced, 1e-30);
    var scale = weight / f32(params.window_samples);
    if chance.hits > 0.0 && chance.hits < chance.rays {
        var sum = 0.0;
        for (var bin = 0u; bin < params.bins; bin++) {
            let share = shares[pixel_cell(shape, bin, batch, pixel)];
            let part = select(mean_share, share.arrived / max(share.traced, 1e-30), share.traced > 0.0);
            sum += share.unobstructed.x * dot(part, vec3<f32>(1.0));
        }
        scale *= chance.direct * dot(mean_share, vec3<f32>(1.0)) / sum;
    }
    for (var bin = 0u; bin < params.bins; bin++) {
        let cell = pixel_cell(shape, bin, batch, pixel);
        let share = shares[cell];
        if share.unobstructed.x > 0.0 {
            var part = mean_share;
            if share.traced > 0.0 {
                part = share.arrived / share.traced;
            }
            let value = scale * part * share.unobstructed.x;
            sums[cell * 3u] += value.x;
            sums[cell * 3u + 1u] += value.y;
            sums[cell * 3u + 2u] += value.z;
            shares[cell] = BinShare(vec3<f32>(0.0), 0.0, vec3<f32>(0.0), 0u);
        }
    }
    chance.direct /= f32(params.window_samples);
    points[batch * params.pixels + pixel] = chance;
    count_finished(sample == params.window_samples);
}

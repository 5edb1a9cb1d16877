// Daylight matrix: paths from a window's bins to the sky, one per invocation.
//
// Path `index` of bin b starts at a uniform point of the window and leaves against the direction
// of light through the bin, uniform in projected solid angle. What is left of it when it leaves
// the scene is added to the sky patch of its direction. The mean over a bin's paths is a row of D.

import package::generated::{DaylightParams};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{offset_from_surface};
import package::shared::outside::{follow_outside, Outdoors, NO_PATCH};
import package::shared::window::{window_point, window_bin_direction};
import package::shared::counters::{counters, count_finished};
import package::shared::scene::{window_at};

// 1 for grey scenes, 3 for coloured ones.
override COMPONENTS: u32 = 3u;

@group(0) @binding(6) var<uniform> params: DaylightParams;
// [direct or indirect][bin][patch][component], fixed point.
@group(0) @binding(8) var<storage, read_write> sums: array<atomic<u32>>;

fn deposit(bin: u32, direct: bool, patch_index: u32, weight: vec3<f32>) {
    let part = select(params.bins, 0u, direct);
    let cell = ((part + bin) * params.sky_bins + patch_index) * COMPONENTS;
    for (var c = 0u; c < COMPONENTS; c++) {
        atomicAdd(&sums[cell + c], u32(weight[c] * params.unit + 0.5));
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let path = id.x;
    let bin = id.y;
    if path >= params.paths || bin >= params.bins {
        return;
    }
    let index = params.first_path + path;
    let seed = hash_combine(params.seed, bin);
    let window = window_at(params.window);
    // The window itself absorbs what comes back to it.
    let position = offset_from_surface(window_point(window, sample_pair(index, 0u, seed)), -window.z);
    let direction = -window_bin_direction(window, bin, sample_pair(index, 1u, seed));
    let outdoors = Outdoors(params.sky_rows, params.row_height, params.most_bounces, params.roulette_weight);
    let path_outside = follow_outside(position, direction, index, 2u, seed, outdoors);
    if path_outside.patch_index != NO_PATCH {
        deposit(bin, path_outside.direct, path_outside.patch_index, path_outside.weight);
    }
    atomicAdd(&counters.segments, path_outside.segments);
    count_finished(path_outside.ended);
}

// Daylight coefficients: where light paths leave the windows, one per invocation.
//
// Path `index` of a window's bin comes through a uniform point of the pane, from a direction of the bin uniform in
// projected solid angle. It carries the flux of radiance 1 in the sky patch that its way outside leads to: bins only
// spread the paths evenly.

import package::generated::{CoefficientParams, LightPath};
import package::shared::bvh::{offset_from_surface};
import package::shared::counters::{counters, count_finished};
import package::shared::material::{glass_pane, largest};
import package::coefficients::sunlight::{path_label};
import package::shared::outside::{follow_outside, Outdoors, NO_PATCH};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::window::{window_point, window_bin_direction, projected_solid_angle};
import package::shared::scene::{material_at, window_at};

@group(0) @binding(6) var<uniform> params: CoefficientParams;
// [batch][bin][path]
@group(0) @binding(10) var<storage, read_write> paths: array<LightPath>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = id.x;
    let bin = id.y;
    let batch = id.z;
    if index >= params.samples || bin >= params.bins || batch >= params.batches {
        return;
    }
    let seed = hash_combine(hash_combine(params.seed, batch), bin);
    var w = 0u;
    while w + 1u < params.window_count && bin >= window_at(w + 1u).first_bin {
        w += 1u;
    }
    let window = window_at(w);
    let local_bin = bin - window.first_bin;
    let point = window_point(window, sample_pair(index, 0u, seed));
    let direction = window_bin_direction(window, local_bin, sample_pair(index, 1u, seed));
    let outdoors = Outdoors(params.sky_rows, params.row_height, params.most_bounces - 1u, params.roulette_weight);
    let path_outside = follow_outside(offset_from_surface(point, -window.z), -direction, index, 0u, hash_combine(seed, 1u), outdoors);
    let pane = material_at(params.first_pane + w);
    let through = glass_pane(pane.specular, pane.roughness, max(dot(direction, window.z), 1e-6))[0];
    let emitted = window.area * projected_solid_angle(window.first_ring, window.rings, local_bin);
    let flux = emitted * through * path_outside.weight;
    let arrives = path_outside.patch_index != NO_PATCH && largest(flux) > 0.0;
    let label = select(0u, path_label(path_outside.patch_index, path_outside.bounces, path_outside.plain), arrives);
    let slot = (batch * params.bins + bin) * params.samples + index;
    paths[slot] = LightPath(offset_from_surface(point, window.z), select(0u, 1u, arrives), direction, 2u, flux, label);
    atomicAdd(&counters.segments, path_outside.segments);
    count_finished(path_outside.ended);
}

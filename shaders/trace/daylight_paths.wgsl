// Daylight matrix: paths from a window's bins to the sky, one per invocation.
//
// Path `index` of bin b starts at a uniform point of the window and leaves against the direction
// of light through the bin, uniform in projected solid angle. What is left of it when it leaves
// the scene is added to the sky patch of its direction. The mean over a bin's paths is a row of D.

import package::generated::{DaylightParams, FAR_AWAY, MATERIAL_GLASS, MOST_PATH_SEGMENTS};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{closest_hit, leave_surface, offset_from_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{materials, scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::sky::{sky_bin};
import package::shared::window::{windows, window_point, window_bin_direction};
import package::shared::counters::{counters, count_finished};

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
    let window = windows[params.window];
    // The window itself absorbs what comes back to it.
    var position = offset_from_surface(window_point(window, sample_pair(index, 0u, seed)), -window.z);
    var direction = -window_bin_direction(window, bin, sample_pair(index, 1u, seed));
    var weight = vec3<f32>(1.0);
    var bounces = 0u;
    // Neither scattered nor mirrored so far: panes only.
    var straight = true;
    var ended = false;
    var segment = 0u;
    for (; segment < MOST_PATH_SEGMENTS; segment++) {
        let hit = closest_hit(position, direction, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            deposit(bin, straight, sky_bin(direction, params.row_height, params.sky_rows), weight);
            ended = true;
            break;
        }
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let choices = sample_pair(index, 2u + segment * 3u, seed);
        let slope = sample_pair(index, 3u + segment * 3u, seed);
        let material = materials[triangle_material(hit.triangle)];
        let event = scatter(material, direction, facing, front, choices.x, slope);
        straight = straight && material.kind == MATERIAL_GLASS && event.transmitted;
        weight *= event.weight;
        if event.lobe == LOBE_NONE || largest(weight) <= 0.0 {
            ended = true;
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        direction = event.direction;
        if event.lobe == LOBE_DIFFUSE {
            bounces += 1u;
            if bounces > params.most_bounces {
                ended = true;
                break;
            }
            direction = cosine_direction(side, slope);
        }
        let strength = largest(weight);
        if strength < params.roulette_weight {
            if choices.y * params.roulette_weight >= strength {
                ended = true;
                break;
            }
            weight *= params.roulette_weight / strength;
        }
        position = leave_surface(hit, side);
    }
    atomicAdd(&counters.segments, segment + 1u);
    count_finished(ended || segment == MOST_PATH_SEGMENTS);
}

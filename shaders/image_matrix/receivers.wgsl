// View matrix of a picture, first step: what every pixel shows. Windows seen directly (or in
// mirrors and through panes) go into their bins at once; for the first `batches` rays of a pixel
// the first diffuse surface becomes a receiver, whose irradiance the next steps find.

import package::generated::{PixelRay, Receiver, TileParams, FAR_AWAY, FRAC_1_PI, MATERIAL_ABSORBER};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{materials, scatter, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::window::{windows, window_bin};
import package::shared::counters::{count_finished};

const MOST_SPECULAR: u32 = 32u;

@group(0) @binding(6) var<uniform> params: TileParams;
// [subpixel][pixel]
@group(0) @binding(7) var<storage, read> rays: array<PixelRay>;
// [batch][pixel]
@group(0) @binding(8) var<storage, read_write> receivers: array<Receiver>;
// Radiance of a receiver per irradiance, rgb: [batch][pixel].
@group(0) @binding(9) var<storage, read_write> receiver_weights: array<vec4<f32>>;
// [pixel][group of subpixels][bin][rgb], fixed point; as many groups as batches.
@group(0) @binding(10) var<storage, read_write> seen: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.x;
    let subpixel = id.y;
    if pixel >= params.pixels || subpixel >= params.subpixels {
        return;
    }
    let ray = rays[subpixel * params.pixels + pixel];
    let seed = hash_combine(params.seed, ray.number);
    // A receiver that sees nothing, for rays that meet none.
    var receiver = Receiver(vec3<f32>(0.0, 0.0, 1e6), ray.number, vec3<f32>(0.0, 0.0, 1.0), 0u);
    var receiver_weight = vec3<f32>(0.0);
    var weight = vec3<f32>(1.0);
    var origin = ray.origin;
    var direction = ray.direction;
    var farthest = ray.length;
    var ended = false;
    for (var segment = 0u; segment < MOST_SPECULAR && !ended; segment++) {
        let hit = closest_hit(origin, direction, farthest);
        if !(farthest > 0.0) || hit.triangle == NO_TRIANGLE {
            ended = true;
            break;
        }
        farthest = FAR_AWAY;
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let material = materials[triangle_material(hit.triangle)];
        if material.kind == MATERIAL_ABSORBER {
            if material.window > 0u && front {
                let bin = window_bin(windows[material.window - 1u], -direction);
                let value = weight * params.unit + 0.5;
                let part = subpixel * params.batches / params.subpixels;
                let cell = ((pixel * params.batches + part) * params.bins + bin) * 3u;
                atomicAdd(&seen[cell], u32(value.x));
                atomicAdd(&seen[cell + 1u], u32(value.y));
                atomicAdd(&seen[cell + 2u], u32(value.z));
            }
            ended = true;
            break;
        }
        let choice = sample_pair(subpixel, segment * 2u, seed).x;
        let slope = sample_pair(subpixel, segment * 2u + 1u, seed);
        let event = scatter(material, direction, facing, front, choice, slope);
        weight *= event.weight;
        if event.lobe == LOBE_NONE || largest(weight) <= 0.0 {
            ended = true;
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        origin = leave_surface(hit, side);
        direction = event.direction;
        if event.lobe == LOBE_DIFFUSE {
            receiver = Receiver(origin, ray.number, side, 0u);
            receiver_weight = weight * FRAC_1_PI;
            ended = true;
        }
    }
    if subpixel < params.batches {
        receivers[subpixel * params.pixels + pixel] = receiver;
        receiver_weights[subpixel * params.pixels + pixel] = vec4<f32>(receiver_weight, 0.0);
    }
    count_finished(true);
}

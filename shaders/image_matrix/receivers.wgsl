// View matrix of a picture, first step: what every pixel shows. Windows seen directly (or in
// mirrors and through panes) go into their bins at once; for the first `batches` rays of a pixel
// the first diffuse surface becomes a receiver, whose irradiance the next steps find.
//
// Through panes and by one reflection in a smooth surface windows are followed in full; what else is
// specular is left to chance, as the receivers are.

import package::generated::{FAR_AWAY, FRAC_1_PI, LOOK_UNITS, MATERIAL_ABSORBER, MATERIAL_SURFACE, Material, PixelPoint, PixelRay, Receiver, TileParams};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{scatter, smooth_specular, is_smooth, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::window::{window_bin};
import package::shared::counters::{count_finished};
import package::shared::scene::{material_at, window_at};

// Whether anything reflects, or transmits, other than diffusely.
override HAS_SPECULAR: bool = true;
const MOST_SPECULAR: u32 = 32u;

@group(0) @binding(6) var<uniform> params: TileParams;
// [subpixel][pixel]
@group(0) @binding(7) var<storage, read> rays: array<PixelRay>;
// [batch][pixel]
@group(0) @binding(8) var<storage, read_write> receivers: array<Receiver>;
// [batch][pixel], zero at the start.
@group(0) @binding(9) var<storage, read_write> points: array<PixelPoint>;
// [pixel][group of subpixels][bin][rgb], fixed point; as many groups as batches.
@group(0) @binding(10) var<storage, read_write> seen: array<atomic<u32>>;
// [pixel]: rays left to chance that left a reflection, how many saw a window, the sum of their weights in
// `LOOK_UNITS`, and how many rays met a rough surface that might reflect or transmit.
@group(0) @binding(11) var<storage, read_write> looks: array<atomic<u32>>;

// Adds the light of a window to its bin in a row of `seen`.
fn show(row: u32, window: u32, direction: vec3<f32>, weight: vec3<f32>) {
    let value = weight * params.unit + 0.5;
    let cell = (row * params.bins + window_bin(window_at(window), -direction)) * 3u;
    atomicAdd(&seen[cell], u32(value.x));
    atomicAdd(&seen[cell + 1u], u32(value.y));
    atomicAdd(&seen[cell + 2u], u32(value.z));
}

// Whether a surface reflects as a mirror and transmits as a pane.
fn is_polished(material: Material) -> bool {
    return material.kind != MATERIAL_ABSORBER && (material.kind != MATERIAL_SURFACE || is_smooth(material));
}

// Shows the window ahead, through panes, and the windows that each surface on the way reflects.
fn show_windows(row: u32, origin: vec3<f32>, ahead: vec3<f32>, farthest: f32) {
    var start = origin;
    var direction = ahead;
    var weight = vec3<f32>(1.0);
    var reach = farthest;
    // While a reflection is followed: where the ray ahead goes on.
    var aside = false;
    var next_start = origin;
    var next_weight = vec3<f32>(0.0);
    for (var met = 0u; met < MOST_SPECULAR; met++) {
        var ended = largest(weight) <= 0.0;
        if !ended {
            let hit = closest_hit(start, direction, reach);
            reach = FAR_AWAY;
            ended = hit.triangle == NO_TRIANGLE;
            if !ended {
                let material = material_at(triangle_material(hit.triangle));
                let normal = triangle_normal(hit.triangle);
                let cosine = dot(normal, direction);
                if material.kind == MATERIAL_ABSORBER && material.window > 0u && cosine < 0.0 {
                    show(row, material.window - 1u, direction, weight);
                }
                ended = !is_polished(material);
                if !ended {
                    let facing = select(normal, -normal, cosine > 0.0);
                    let parts = smooth_specular(material, max(abs(cosine), 1e-6), cosine < 0.0);
                    start = leave_surface(hit, -facing);
                    if aside {
                        weight *= parts[0];
                    } else {
                        aside = true;
                        next_start = start;
                        next_weight = weight * parts[0];
                        start = leave_surface(hit, facing);
                        direction = normalize(direction - 2.0 * cosine * normal);
                        weight *= parts[1];
                    }
                }
            }
        }
        if ended {
            if !aside {
                return;
            }
            aside = false;
            start = next_start;
            direction = ahead;
            weight = next_weight;
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.x;
    let subpixel = id.y;
    if pixel >= params.pixels || subpixel >= params.subpixels {
        return;
    }
    let ray = rays[subpixel * params.pixels + pixel];
    let seed = hash_combine(params.seed, ray.number);
    let row = pixel * params.batches + subpixel * params.batches / params.subpixels;
    if HAS_SPECULAR && ray.length > 0.0 {
        show_windows(row, ray.origin, ray.direction, ray.length);
    }
    // A receiver that sees nothing, for rays that meet none.
    var receiver = Receiver(vec3<f32>(0.0, 0.0, 1e6), ray.number, vec3<f32>(0.0, 0.0, 1.0), 0u);
    var receiver_weight = vec3<f32>(0.0);
    var weight = vec3<f32>(1.0);
    var origin = ray.origin;
    var direction = ray.direction;
    var farthest = ray.length;
    var ended = false;
    // So far; what is seen by one at most has been shown already.
    var reflections = 0u;
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
        let material = material_at(triangle_material(hit.triangle));
        if material.kind == MATERIAL_ABSORBER {
            if material.window > 0u && front && (!HAS_SPECULAR || reflections > 1u) {
                show(row, material.window - 1u, direction, weight);
                if HAS_SPECULAR {
                    atomicAdd(&looks[pixel * 4u + 1u], 1u);
                }
            }
            ended = true;
            break;
        }
        if HAS_SPECULAR && !is_polished(material) && largest(material.specular + material.specular_transmitted) > 0.0 {
            atomicAdd(&looks[pixel * 4u + 3u], 1u);
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
        } else if HAS_SPECULAR && !(event.transmitted && is_polished(material)) {
            reflections += select(2u, 1u, is_polished(material));
            if reflections > 1u {
                atomicAdd(&looks[pixel * 4u], 1u);
                atomicAdd(&looks[pixel * 4u + 2u], u32(largest(weight) * LOOK_UNITS + 0.5));
            }
        }
    }
    if subpixel < params.batches {
        receivers[subpixel * params.pixels + pixel] = receiver;
        points[subpixel * params.pixels + pixel].weight = receiver_weight;
    }
    count_finished(true);
}

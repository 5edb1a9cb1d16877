// Daylight coefficients: what a sensor gets other than straight from its windows. Paths from the sensor,
// one per invocation.
//
// Every path of light to the sensor that crosses windows into rooms has a first crossing, seen from the sky. The path
// from the sensor finds it in two ways, of which each path of light knows one: at each diffuse vertex a ray goes to
// a window if nothing but panes lies between, and a path outside begins there; if a mirror lies between, the
// path itself goes on through the pane to the sky. The sensor's own rays to its windows are those of
// `coefficients/direct`. Light that crosses no window into a room is found by the path as well, where it meets the sky.
//
// Light of windows by a first diffuse surface farther away than `near_radius` is left to light paths.

import package::generated::{Receiver, FAR_AWAY, FRAC_1_PI, LOOK_UNITS, MATERIAL_GLASS, MOST_PATH_SEGMENTS, PI, WORKGROUPS_PER_ROW};
import package::coefficients::deposit::{params, deposit, DIRECT, OTHER};
import package::coefficients::entering::{light_of_windows};
import package::shared::random::{sample_pair, hash_combine, unit_f32};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::outside::{NO_PATCH};
import package::shared::sky::{sky_bin};
import package::shared::counters::{counters, count_finished};
import package::shared::scene::{material_at};

@group(0) @binding(11) var<storage, read> sensors: array<Receiver>;
// [sensor]: light found of windows, its sum in `LOOK_UNITS`; of the sky by no window, its sum.
@group(0) @binding(10) var<storage, read_write> looks: array<atomic<u32>>;

fn count_look(sensor_index: u32, kind: u32, weight: vec3<f32>) {
    atomicAdd(&looks[sensor_index * 4u + kind], 1u);
    atomicAdd(&looks[sensor_index * 4u + kind + 1u], u32(largest(weight) * LOOK_UNITS + 0.5));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    // Paths of a sensor side by side, so that few paths per sensor fill whole workgroups too.
    let path = id.y * (WORKGROUPS_PER_ROW * 64u) + id.x;
    let sensor_index = path / params.samples;
    let index = path - sensor_index * params.samples;
    let batch = id.z;
    if sensor_index >= params.sensors || batch >= params.batches {
        return;
    }
    let sensor = sensors[sensor_index];
    let row = batch * params.sensors + sensor_index;
    let seed = hash_combine(hash_combine(params.seed, batch), sensor.number);
    let near_radius = params.near_radius * max(bitcast<f32>(sensor.role), 1.0);
    var position = sensor.position;
    var direction = cosine_direction(sensor.normal, sample_pair(index, 0u, seed));
    // Irradiance: every cosine-distributed path stands for π sr.
    var weight = vec3<f32>(PI);
    // Part of the windows' light that is not left to light paths.
    var near_share = 1.0;
    var bounces = 0u;
    // Before the first reflection or scattering, panes aside.
    var first = true;
    // Since the last diffuse vertex.
    var mirrored = false;
    var crossed = false;
    // Whether the last window was left by a path that no ray to a window stands for.
    var counts = true;
    var travelled = 0.0;
    var segments = 0u;
    var ended = false;
    var all_ended = true;
    var segment = 0u;
    for (; segment < MOST_PATH_SEGMENTS; segment++) {
        let dither = unit_f32(hash_combine(seed + 1u, index * MOST_PATH_SEGMENTS + segment));
        let hit = closest_hit(position, direction, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            if counts {
                let light = weight * select(1.0, near_share, crossed);
                deposit(row, select(OTHER, DIRECT, first), sky_bin(direction, params.row_height, params.sky_rows), light, dither);
                count_look(sensor_index, select(2u, 0u, crossed), light);
            }
            ended = true;
            break;
        }
        travelled += hit.distance;
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let material = material_at(triangle_material(hit.triangle));
        let choices = sample_pair(index, 1u + segment * 3u, seed);
        let slope = sample_pair(index, 2u + segment * 3u, seed);
        let event = scatter(material, direction, facing, front, choices.x, slope);
        weight *= event.weight;
        if event.lobe == LOBE_NONE || largest(weight) <= 0.0 {
            ended = true;
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        position = leave_surface(hit, side);
        direction = event.direction;
        let passed_pane = material.kind == MATERIAL_GLASS && event.transmitted;
        if passed_pane && front && material.window > 0u {
            crossed = true;
            counts = mirrored;
        }
        if event.lobe == LOBE_DIFFUSE {
            if first {
                let ratio = travelled / near_radius;
                near_share = max(1.0 - ratio * ratio, 0.0);
            }
            bounces += 1u;
            if bounces > params.most_bounces {
                ended = true;
                break;
            }
            if near_share > 0.0 {
                let random = sample_pair(index, 3u + segment * 3u, seed);
                let found = light_of_windows(position, side, random, index, hash_combine(seed, 2u + segment), params.most_bounces - bounces);
                if found.patch_index != NO_PATCH {
                    let light = weight * found.weight * (near_share * FRAC_1_PI);
                    deposit(row, OTHER, found.patch_index, light, dither);
                    count_look(sensor_index, 0u, light);
                }
                segments += found.segments;
                all_ended = all_ended && found.ended;
            } else if params.open == 0u {
                ended = true;
                break;
            }
            direction = cosine_direction(side, slope);
            mirrored = false;
        } else if !passed_pane {
            mirrored = true;
        }
        first = first && passed_pane;
        let strength = largest(weight);
        if strength < params.roulette_weight {
            if choices.y * params.roulette_weight >= strength {
                ended = true;
                break;
            }
            weight *= params.roulette_weight / strength;
        }
    }
    atomicAdd(&counters.segments, segments + segment + 1u);
    count_finished(all_ended && (ended || segment == MOST_PATH_SEGMENTS));
}

// View matrix: what virtual lights cannot give. Paths from the sensor, one per invocation, that
// either start with a specular surface or meet a diffuse one nearer than `near_radius`, there
// weighted by what `view_matrix/gather` leaves out. Windows seen by one reflection in a plane may be left to
// `light_paths/images`.

import package::generated::{
    NearParams, Receiver, FAR_AWAY, FRAC_1_PI, LOOK_UNITS, MATERIAL_ABSORBER, MATERIAL_GLASS,
    MOST_PATH_SEGMENTS, PI, WORKGROUPS_PER_ROW,
};
import package::shared::random::{sample_pair, hash_combine, unit_f32};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, triangle_plane, NO_TRIANGLE};
import package::shared::material::{scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::window::{window_bin, sample_windows, direct_transmittance};
import package::shared::counters::{counters, count_finished};
import package::shared::scene::{material_at, window_at};

@group(0) @binding(6) var<uniform> params: NearParams;
@group(0) @binding(7) var<storage, read> sensors: array<Receiver>;
// [batch][sensor][bin][rgb], fixed point.
@group(0) @binding(8) var<storage, read_write> sums: array<atomic<u32>>;
// [batch][sensor]: rays that left a reflection by which a window may be seen, how many saw one, and the
// sum of their weights in `LOOK_UNITS`: what is known if few or none did.
@group(0) @binding(9) var<storage, read_write> looks: array<atomic<u32>>;

// `dither`, random in [0, 1), rounds up or down so that what is less than a unit is kept in the mean:
// light of small and distant windows.
fn deposit(row: u32, bin: u32, weight: vec3<f32>, dither: f32) {
    let value = weight * params.unit + dither;
    let cell = (row * params.bins + bin) * 3u;
    atomicAdd(&sums[cell], u32(value.x));
    atomicAdd(&sums[cell + 1u], u32(value.y));
    atomicAdd(&sums[cell + 2u], u32(value.z));
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
    let sensor = sensors[batch * params.batch_stride + sensor_index];
    let row = batch * params.sensors + sensor_index;
    let seed = hash_combine(hash_combine(params.seed, batch), sensor.number);
    let near_radius = params.near_radius * max(bitcast<f32>(sensor.role), 1.0);
    var position = sensor.position;
    var direction = cosine_direction(sensor.normal, sample_pair(index, 0u, seed));
    // Irradiance: every cosine-distributed path stands for π sr.
    var weight = vec3<f32>(PI);
    var bounces = 0u;
    // Before the first scattering, panes aside.
    var first = true;
    var specular_before = false;
    // By nothing but one reflection in a plane.
    var imaged = false;
    var travelled = 0.0;
    var ended = false;
    var segment = 0u;
    for (; segment < MOST_PATH_SEGMENTS; segment++) {
        let dither = unit_f32(hash_combine(seed + 1u, index * MOST_PATH_SEGMENTS + segment));
        if specular_before && !imaged {
            atomicAdd(&looks[row * 3u], 1u);
            atomicAdd(&looks[row * 3u + 2u], u32(largest(weight) * LOOK_UNITS + 0.5));
        }
        let hit = closest_hit(position, direction, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            ended = true;
            break;
        }
        travelled += hit.distance;
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let material = material_at(triangle_material(hit.triangle));
        if material.kind == MATERIAL_ABSORBER {
            if material.window > 0u && specular_before && !imaged && front {
                deposit(row, window_bin(window_at(material.window - 1u), -direction), weight, dither);
                atomicAdd(&looks[row * 3u + 1u], 1u);
            }
            ended = true;
            break;
        }
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
        if event.lobe == LOBE_DIFFUSE {
            if first {
                let ratio = travelled / near_radius;
                if ratio >= 1.0 {
                    ended = true;
                    break;
                }
                weight *= 1.0 - ratio * ratio;
            }
            bounces += 1u;
            if bounces > params.most_bounces {
                ended = true;
                break;
            }
            let to_window = sample_windows(position, params.window_count, sample_pair(index, 3u + segment * 3u, seed));
            let cosine = dot(to_window.direction, side);
            if to_window.weight > 0.0 && cosine > 0.0 {
                let passed = direct_transmittance(position, to_window.direction, to_window.distance * 0.99999);
                let share = passed * weight * (cosine * to_window.weight * FRAC_1_PI);
                deposit(row, window_bin(window_at(to_window.window), -to_window.direction), share, dither);
            }
            direction = cosine_direction(side, slope);
            specular_before = false;
        } else if !passed_pane {
            specular_before = true;
            imaged = first && params.images == 1u && !event.transmitted && triangle_plane(hit.triangle) > 0u;
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
    atomicAdd(&counters.segments, segment + 1u);
    count_finished(ended || segment == MOST_PATH_SEGMENTS);
}

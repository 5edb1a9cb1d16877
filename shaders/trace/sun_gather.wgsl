// Sun matrix, second half: what a receiver gets of one sun, straight and by the vertices of its
// paths. One invocation per sun, receiver and batch. Once more for every image of the sun in flat
// mirrors: the image is looked for where it stands, and counts where the mirrors met are those that
// make it.

import package::generated::{Receiver, SunGatherParams, SunRecord, SunVertex};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::material::{materials, largest};
import package::shared::gates::{may_come_in};
import package::shared::mirrored::{mirrored_transmittance};
import package::shared::sun::{sun_direction, sun_transmittance, vertex_light, hidden_by_one};
import package::shared::counters::{counters, count_finished};

// Whether the sun's image in mirrors is looked for, not the sun itself.
override MIRRORED: bool = false;
// Whether straight light is looked for, or was already (`sun_straight`).
override STRAIGHT: bool = true;
// Whether there are paths.
override SCATTERED: bool = true;

@group(0) @binding(6) var<uniform> params: SunGatherParams;
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(8) var<storage, read> suns: array<SunRecord>;
// [batch][receiver][set][path][vertex]
@group(0) @binding(9) var<storage, read> vertices: array<SunVertex>;
// [batch][receiver][sun][straight rgb, scattered rgb], then [batch][receiver][sun] the doubt: the
// variance that the straight part may have, by the number of points seen. Zero at the start.
@group(0) @binding(10) var<storage, read_write> sums: array<f32>;

// Where the sun is looked for.
fn image_of(direction: vec3<f32>) -> vec3<f32> {
    if !MIRRORED {
        return direction;
    }
    return direction.x * params.image_x + direction.y * params.image_y + direction.z * params.image_z;
}

fn arriving(origin: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    if MIRRORED {
        let image = mat3x3<f32>(params.image_x, params.image_y, params.image_z);
        return mirrored_transmittance(origin, direction, image, params.gates, params.window_count);
    }
    return sun_transmittance(origin, direction);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let receivers_first = params.receivers_first == 1u;
    let sun_index = select(id.x, id.y, receivers_first);
    let receiver_index = select(id.y, id.x, receivers_first);
    let batch = id.z;
    if sun_index >= params.suns || receiver_index >= params.receivers || batch >= params.batches {
        return;
    }
    let sun = suns[sun_index];
    let receiver = receivers[batch * params.batch_stride + receiver_index];
    let seed = hash_combine(hash_combine(hash_combine(params.seed, batch), receiver.number), sun.number);
    // Where every batch has receivers of its own, the points of a pixel, they share the disc's points out.
    let own_points = params.batch_stride == 0u;
    let disc_seed = select(hash_combine(hash_combine(params.seed, receiver.number), sun.number), seed, own_points);
    let first_point = select(batch * params.disc_samples, 0u, own_points);
    var rays = 0u;
    var straight = vec3<f32>(0.0);
    var cosines = 0.0;
    var risen = true;
    var sample = params.disc_samples;
    let centre = image_of(sun.direction);
    var doubt = 0.0;
    if (STRAIGHT || MIRRORED) && params.first_path == 0u {
        sample = 0u;
        // One ray in place of many where a wall is in the way, or a slat that is wide enough.
        let worth_it = params.disc_samples > 1u && dot(centre, receiver.normal) > 0.0 && (MIRRORED || may_come_in(receiver.position, centre, params.gates, params.window_count));
        if worth_it && hidden_by_one(receiver.position, centre, sun.chord, !MIRRORED) {
            sample = params.disc_samples;
            risen = false;
            rays += 1u;
        }
        var seen = 0u;
        var brightest = 0.0;
        for (; sample < params.disc_samples; sample++) {
            let direction = image_of(sun_direction(sun, sample_pair(first_point + sample, 0u, disc_seed)));
            let cosine = dot(direction, receiver.normal);
            risen = risen && cosine > 0.0;
            if cosine > 0.0 {
                cosines += cosine;
                if MIRRORED || may_come_in(receiver.position, direction, params.gates, params.window_count) {
                    let passed = arriving(receiver.position, direction);
                    straight += cosine * passed;
                    rays += 1u;
                    seen += u32(largest(passed) > 0.0);
                    brightest = max(brightest, cosine * largest(passed));
                }
            }
        }
        var doubtful = risen && sun.chord > 0.0;
        if doubtful && (seen == 0u || seen == params.disc_samples) {
            let turn = sample_pair(0u, 0x8000u, seed).x;
            doubtful = false;
            for (var k = 0u; k < params.rim && !doubtful; k++) {
                let direction = image_of(sun_direction(sun, vec2<f32>(1.0, (f32(k) + turn) / f32(params.rim))));
                var passed = vec3<f32>(0.0);
                if dot(direction, receiver.normal) > 0.0 && (MIRRORED || may_come_in(receiver.position, direction, params.gates, params.window_count)) {
                    passed = arriving(receiver.position, direction);
                    rays += 1u;
                }
                doubtful = (largest(passed) > 0.0) != (seen > 0u);
                brightest = max(brightest, largest(passed) * dot(direction, receiver.normal));
            }
        }
        if doubtful {
            // Half a point more on either side; an edge through the disc does less than chance would.
            let n = f32(params.disc_samples);
            let share = (f32(seen) + 0.5) / (n + 1.0);
            let whole = sun.solid_angle * brightest;
            doubt = whole * whole * min(share * (1.0 - share) / n, 0.2 / (n * sqrt(n)));
        }
        if risen {
            // The visible share of the exact value: no noise where nothing is in the way.
            let mean_cosine = dot(centre, receiver.normal) * (1.0 - 0.25 * sun.chord * sun.chord);
            straight *= sun.solid_angle * (mean_cosine / cosines);
        } else {
            straight *= sun.solid_angle / f32(params.disc_samples);
        }
    }
    var scattered = vec3<f32>(0.0);
    var path = params.first_path;
    if SCATTERED {
        let own_set = sun.number % params.path_sets;
        let first_path = ((batch * params.receivers + receiver_index) * params.path_sets + own_set) * params.paths;
        for (; path < params.end_path; path++) {
            let first_slot = (first_path + path) * params.most_vertices;
            for (var k = 0u; k < params.most_vertices; k++) {
                let vertex = vertices[first_slot + k];
                if vertex.material == 0u {
                    break;
                }
                let direction = image_of(sun_direction(sun, sample_pair(path, 1u + k, seed)));
                let light = vertex_light(vertex, direction);
                if largest(light.response) > 0.0 {
                    scattered += light.response * arriving(light.start, direction);
                    rays += 1u;
                }
            }
        }
    }
    scattered *= sun.solid_angle;
    let number = (batch * params.receivers + receiver_index) * params.suns + sun_index;
    let cell = number * 6u;
    sums[cell] += straight.x;
    sums[cell + 1u] += straight.y;
    sums[cell + 2u] += straight.z;
    sums[cell + 3u] += scattered.x;
    sums[cell + 4u] += scattered.y;
    sums[cell + 5u] += scattered.z;
    sums[params.batches * params.receivers * params.suns * 6u + number] += doubt;
    atomicAdd(&counters.segments, rays);
    count_finished(sample == params.disc_samples && path == params.end_path);
}

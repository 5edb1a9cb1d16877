// Light of one sun, or its image in flat mirrors, by way of a list of paths: what a receiver gets, or the
// radiance that a point of a shade sends to its front. One list and sun per invocation.

import package::generated::{ScatteredParams, SunRecord, SunVertex, VertexList};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::material::{largest};
import package::sun_matrix::mirrored::{image_of, arriving};
import package::sun_matrix::sun::{sun_direction, vertex_light};
import package::shared::counters::{counters, count_finished};

@group(0) @binding(6) var<uniform> params: ScatteredParams;
@group(0) @binding(7) var<storage, read> lists: array<VertexList>;
@group(0) @binding(8) var<storage, read> vertices: array<SunVertex>;
@group(0) @binding(9) var<storage, read> suns: array<SunRecord>;
// [list][value][sun of its set]: components; paths that found light, and those that would if nothing hid the
// sun; what all would bring then, and the sum of its squares.
@group(0) @binding(10) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= params.suns * params.lists {
        return;
    }
    let lists_first = params.lists_first == 1u;
    let list_index = select(index / params.suns, index % params.lists, lists_first);
    let of_set = select(index % params.suns, index / params.lists, lists_first);
    let list = lists[list_index];
    let sun_index = list.first_sun + of_set * params.stride;
    var sum = vec3<f32>(0.0);
    var hits = 0.0;
    var looks = 0.0;
    var open = 0.0;
    var squares = 0.0;
    var rays = 0u;
    var path = 0u;
    let image = mat3x3<f32>(params.image_x, params.image_y, params.image_z);
    if sun_index < params.all_suns {
        let sun = suns[sun_index];
        let seed = hash_combine(hash_combine(params.seed, list.stream), sun.number);
        for (; path < list.paths; path++) {
            var of_path = vec3<f32>(0.0);
            var most = 0.0;
            var faces = false;
            for (var slot = 0u; slot < params.path_slots; slot++) {
                let vertex = vertices[list.first + path * params.path_slots + slot];
                if vertex.material == 0u {
                    if slot == 0u {
                        most = largest(vertex.throughput) * params.brightest;
                    }
                    break;
                }
                let direction = image_of(sun_direction(sun, sample_pair(list.index + path, slot, seed)), image);
                let light = vertex_light(vertex, direction);
                let response = largest(light.response);
                if response > 0.0 {
                    of_path += light.response * arriving(light.start, direction, image, params.gates, params.window_count);
                    most += response;
                    faces = true;
                    rays += 1u;
                }
            }
            sum += of_path;
            hits += f32(largest(of_path) > 0.0);
            looks += f32(faces);
            open += most;
            squares += most * most;
        }
        sum *= sun.solid_angle;
        open *= sun.solid_angle;
        squares *= sun.solid_angle * sun.solid_angle;
    }
    let cell = list_index * (params.components + 4u) * params.suns + of_set;
    sums[cell] = sum.x;
    if params.components == 3u {
        sums[cell + params.suns] = sum.y;
        sums[cell + 2u * params.suns] = sum.z;
    }
    let rest = cell + params.components * params.suns;
    sums[rest] = hits;
    sums[rest + params.suns] = looks;
    sums[rest + 2u * params.suns] = open;
    sums[rest + 3u * params.suns] = squares;
    atomicAdd(&counters.segments, rays);
    // Some drivers end long loops silently.
    count_finished(path >= list.paths || sun_index >= params.all_suns);
}

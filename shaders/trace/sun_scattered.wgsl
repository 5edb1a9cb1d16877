// Light of one sun by way of a list of vertices, the radiance that a point of a shade sends to its front
// for one. One list and sun per invocation.

import package::generated::{ScatteredParams, SunRecord, SunVertex, VertexList};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::material::{materials, largest};
import package::shared::sun::{sun_direction, sun_transmittance, vertex_light};
import package::shared::window::{windows, rings, window_triangles};
import package::shared::counters::{counters, count_finished};

@group(0) @binding(6) var<uniform> params: ScatteredParams;
@group(0) @binding(7) var<storage, read> lists: array<VertexList>;
@group(0) @binding(8) var<storage, read> vertices: array<SunVertex>;
@group(0) @binding(9) var<storage, read> suns: array<SunRecord>;
// [list][component][sun of its set]
@group(0) @binding(10) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.suns || id.y >= params.lists {
        return;
    }
    let list = lists[id.y];
    let sun_index = list.first_sun + id.x * params.stride;
    var sum = vec3<f32>(0.0);
    var rays = 0u;
    var k = 0u;
    if sun_index < params.all_suns {
        let sun = suns[sun_index];
        let seed = hash_combine(hash_combine(params.seed, list.stream), sun.number);
        for (; k < list.count; k++) {
            let vertex = vertices[list.first + k];
            if vertex.material == 0u {
                k = (k / params.path_slots + 1u) * params.path_slots - 1u;
                continue;
            }
            let direction = sun_direction(sun, sample_pair(list.index, k, seed));
            let light = vertex_light(vertex, direction);
            if largest(light.response) > 0.0 {
                sum += light.response * sun_transmittance(light.start, direction);
                rays += 1u;
            }
        }
        sum *= sun.solid_angle;
    }
    let cell = id.y * params.components * params.suns + id.x;
    sums[cell] = sum.x;
    if params.components == 3u {
        sums[cell + params.suns] = sum.y;
        sums[cell + 2u * params.suns] = sum.z;
    }
    atomicAdd(&counters.segments, rays);
    // Some drivers end long loops silently.
    count_finished(k >= list.count || sun_index >= params.all_suns);
}

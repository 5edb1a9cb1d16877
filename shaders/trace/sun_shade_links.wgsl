// What receivers get, as irradiance, of radiance that leaves points of the shades: cosines over squared
// distance times area, where nothing is in the way. One pair of receiver and point per invocation.

import package::generated::{Receiver, ShadeLinkParams, SunVertex};
import package::shared::bvh::{light_passing, ANY, ANY_BUT_CLEAR};
import package::shared::sun::{HAS_PANES};
import package::shared::window::{windows, rings, window_triangles, leaves_through_window};
import package::shared::counters::{counters, count_finished};

@group(0) @binding(6) var<uniform> params: ShadeLinkParams;
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
// [point][path][vertex], the point itself first, with the area that it stands for.
@group(0) @binding(8) var<storage, read> vertices: array<SunVertex>;
// [receiver][point][component]
@group(0) @binding(9) var<storage, read_write> links: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.points || id.y >= params.receivers {
        return;
    }
    let receiver = receivers[id.y];
    let point = vertices[id.x * params.slots];
    let way = point.position - receiver.position;
    let distance = length(way);
    let direction = way / max(distance, 1e-20);
    let cosines = max(dot(direction, receiver.normal), 0.0) * max(-dot(direction, point.facing), 0.0);
    var link = vec3<f32>(0.0);
    var rays = 0u;
    if cosines > 0.0 && (params.window_count == 0u || leaves_through_window(receiver.position, direction, params.window_count)) {
        rays = 1u;
        link = light_passing(receiver.position, direction, distance, select(ANY, ANY_BUT_CLEAR, HAS_PANES)) * (cosines * point.area / (distance * distance));
    }
    let cell = (id.y * params.points + id.x) * params.components;
    links[cell] = link.x;
    if params.components == 3u {
        links[cell + 1u] = link.y;
        links[cell + 2u] = link.z;
    }
    atomicAdd(&counters.segments, rays);
    count_finished(true);
}

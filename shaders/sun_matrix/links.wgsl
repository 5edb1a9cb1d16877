// What passes between receivers and points that all of them share: points of shades (as irradiance of the
// radiance that leaves them: cosines over squared distance times area), or of panes, where geometry is known
// better later. 0 where something is in the way. One pair of receiver and point per invocation.

import package::generated::{LinkParams, Receiver, SunVertex};
import package::shared::bvh::{light_passing, ANY, ANY_BUT_CLEAR};
import package::sun_matrix::sun::{HAS_PANES};
import package::shared::window::{leaves_through_window};
import package::shared::counters::{counters, count_finished};

@group(0) @binding(6) var<uniform> params: LinkParams;
// [receiver], or [batch][receiver]
@group(0) @binding(7) var<storage, read> receivers: array<Receiver>;
// [point][path][vertex], the point itself first.
@group(0) @binding(8) var<storage, read> vertices: array<SunVertex>;
// [point][receiver][component]
@group(0) @binding(9) var<storage, read_write> links: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= params.points * params.receivers {
        return;
    }
    let point_index = index / params.receivers;
    let receiver = receivers[point_index / params.batch_points * params.batch_stride + index % params.receivers];
    let point = vertices[point_index * params.slots];
    let way = point.position - receiver.position;
    let distance = max(length(way), 1e-9);
    let direction = way / distance;
    let height = dot(way, receiver.normal);
    let slope = -dot(direction, point.facing);
    var link = vec3<f32>(0.0);
    var rays = 0u;
    // Of what reaches beyond its point a part may be before the receiver.
    if height > -point.reach && slope > 0.0 && (params.window_count == 0u || leaves_through_window(receiver.position, direction, params.window_count)) {
        rays = 1u;
        link = light_passing(receiver.position, direction, distance, select(ANY, ANY_BUT_CLEAR, HAS_PANES));
        if params.plain == 0u {
            link *= height / distance * slope * point.area / (distance * distance);
        }
    }
    let cell = index * params.components;
    links[cell] = link.x;
    if params.components == 3u {
        links[cell + 1u] = link.y;
        links[cell + 2u] = link.z;
    }
    atomicAdd(&counters.segments, rays);
    count_finished(true);
}

// Receivers and virtual lights.

import package::generated::{Receiver, VirtualLight};

// Geometric factor of a connection with nothing in the way, 1/area. Those shorter than `near_radius` count as if
// they were as long.
fn connection(receiver: Receiver, light: VirtualLight, near_radius: f32) -> f32 {
    let to_light = light.position - receiver.position;
    let cos_receiver = dot(to_light, receiver.normal);
    let cos_light = -dot(to_light, light.normal);
    let distance2 = dot(to_light, to_light);
    let near = near_radius * max(bitcast<f32>(receiver.role), 1.0);
    let near2 = near * near;
    return max(cos_receiver, 0.0) * max(cos_light, 0.0) / (distance2 * max(distance2, near2));
}

// What the halves of the view matrix and of the sun matrix exchange.

struct Receiver {
    position: vec3<f32>,
    // Number of the sensor or pixel: chooses its random numbers, whatever tile it is in.
    number: u32,
    // Unit length.
    normal: vec3<f32>,
    // Of receivers of a view matrix: bits of an f32, by which `near_radius` is multiplied if it is above 1.
    // Of surface points before a camera: 1 if they lie on a shade, where light comes from everywhere. Else 0.
    role: u32,
}

struct VirtualLight {
    position: vec3<f32>,
    // Sum of the flux's components.
    strength: f32,
    // Of the side that emits, unit length.
    normal: vec3<f32>,
    // Whether its path goes on to another vertex.
    goes_on: u32,
    // Flux that leaves diffusely; 0 where there is no light.
    flux: vec3<f32>,
    padding2: u32,
}

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

// Where a path from a receiver meets a surface that scatters sunlight, or a point that stands for a part of one.
struct SunVertex {
    // Beside the surface, on the side of arrival.
    position: vec3<f32>,
    // Index + 1; 0 after the last vertex of a path, whose first slot then holds the throughput of its beginning if
    // it has no vertex.
    material: u32,
    facing: vec3<f32>,
    // From `position` through the surface to the other side.
    thickness: f32,
    incoming: vec3<f32>,
    // How far what it stands for reaches, if it is a point of a pane.
    reach: f32,
    throughput: vec3<f32>,
    // That it stands for, if it is a point of a shade.
    area: f32,
}

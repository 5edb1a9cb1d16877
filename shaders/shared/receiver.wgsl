// What the halves of the view matrix and of the sun matrix exchange.

struct Receiver {
    position: vec3<f32>,
    // Number of the sensor or pixel: chooses its random numbers, whatever tile it is in.
    number: u32,
    // Unit length.
    normal: vec3<f32>,
    // Of sensors of the view matrix: bits of an f32, by which `near_radius` is multiplied if it is above 1.
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

// Where a path from a receiver meets a surface that scatters sunlight.
struct SunVertex {
    // Beside the surface, on the side of arrival.
    position: vec3<f32>,
    // Index + 1; 0 after the last vertex of a path.
    material: u32,
    facing: vec3<f32>,
    // From `position` through the surface to the other side.
    thickness: f32,
    incoming: vec3<f32>,
    padding0: u32,
    throughput: vec3<f32>,
    // That it stands for, if it is a point of a shade.
    area: f32,
}

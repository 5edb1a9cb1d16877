// Suns through panes that scatter: what the kernels of `sun_matrix/pane` exchange.

struct PaneParams {
    seed: u32,
    receivers: u32,
    suns: u32,
    // Cells of the panes, or points, per batch.
    cells: u32,
    batches: u32,
    panes: u32,
    // Directions to a sun's disc per point.
    disc_samples: u32,
    // Cells that one dispatch takes of each batch where light is gathered.
    first_cell: u32,
    end_cell: u32,
    // Receivers from one batch to the next; 0 if all batches share them.
    batch_stride: u32,
    // Size of a part of a cell seen from the receiver, radians.
    part_angle: f32,
    // Of what passes between receivers and cells.
    components: u32,
}

// A pane: its frame, and where its data begin.
struct Pane {
    x: vec3<f32>,
    // First word of its scattering function; NO_SCATTERING if it only lets light through directly.
    words: u32,
    y: vec3<f32>,
    first_triangle: u32,
    // Into the room.
    z: vec3<f32>,
    triangles: u32,
    // Factor on the scattering function.
    tint: vec3<f32>,
    padding: u32,
}

// A sun seen through a pane.
struct PaneSun {
    // Transmittance of the direct way.
    clear: vec3<f32>,
    // Squared radius within which scattered light meets the surround of a through-peak; 0: no peak.
    guard: f32,
    // Scattering function there, 1/sr.
    surround: f32,
    // Factor on the scattering function.
    scale: f32,
    padding0: u32,
    padding1: u32,
}

// A triangle of a pane's area: all points corner + u edge1 + v edge2 with u + v < 1.
struct PaneCell {
    corner: vec3<f32>,
    pane: u32,
    edge1: vec3<f32>,
    area: f32,
    edge2: vec3<f32>,
    padding0: u32,
    // A random point inside, where light is followed.
    position: vec3<f32>,
    padding1: u32,
}

// A point of a pane.
struct PanePoint {
    position: vec3<f32>,
    // Beyond all panes: no point.
    pane: u32,
    // Towards the eye that sees it, unit length; 0 if none does.
    outgoing: vec3<f32>,
    number: u32,
}

// A sun as a point of a pane sees it.
struct PaneEnd {
    // What evaluation needs to know of the incident direction.
    key: vec2<f32>,
    // x and y of the direction of travel in the pane's frame.
    direction: vec2<f32>,
    // Cosine times solid angle times transmittance of the way and tint of the pane, 0 if nothing arrives; by way of
    // the pane towards an eye if there is one.
    strength: vec3<f32>,
    padding: u32,
}

const NO_SCATTERING: u32 = 0xffffffffu;

// In the pane's frame.
fn pane_local(pane: Pane, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(direction, pane.x), dot(direction, pane.y), dot(direction, pane.z));
}

// A point moved off the pane to one of its sides.
fn off_pane(position: vec3<f32>, side: vec3<f32>) -> vec3<f32> {
    let largest = max(abs(position.x), max(abs(position.y), abs(position.z)));
    return position + side * (1e-5 * (largest + 0.5));
}

// Suns through panes that scatter: what the kernels of `sun_matrix/pane` exchange.

import package::shared::bins::{TAU};
import package::shared::frame::{tangent_frame};
import package::shared::random::{sample_pair, hash_combine};

struct PaneParams {
    seed: u32,
    receivers: u32,
    suns: u32,
    // Cells of the panes per batch.
    cells: u32,
    batches: u32,
    panes: u32,
    // Directions to a sun's disc per batch, where the disc itself is seen.
    disc_samples: u32,
    // Cells that one dispatch takes: of each batch where light is gathered, of all where ways are traced.
    first_cell: u32,
    end_cell: u32,
    // Receivers from one batch to the next; 0 if all batches share them.
    batch_stride: u32,
    // Size of a part of a cell seen from the receiver, radians.
    part_angle: f32,
    padding0: u32,
}

// A pane: its frame, and where its data begin.
struct Pane {
    x: vec3<f32>,
    // First word of its scattering function; NO_SCATTERING if it only transmits straight through.
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
struct PaneSunRecord {
    // Towards its centre.
    direction: vec3<f32>,
    // Angular radius as a chord.
    chord: f32,
    // Transmittance of the straight way.
    clear: vec3<f32>,
    // Solid angle, sr.
    solid_angle: f32,
    // Squared radius within which scattered light meets the surround of a through-peak; 0: no peak.
    guard: f32,
    // Scattering function there, 1/sr.
    surround: f32,
    // Factor on the scattering function.
    scale: f32,
    padding: u32,
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

// A point of the façade that an eye sees.
struct FacadePoint {
    position: vec3<f32>,
    // NO_PANE if there is none.
    pane: u32,
    // Towards the eye, unit length.
    outgoing: vec3<f32>,
    number: u32,
}

// A sun as a cell sees it.
struct PaneEnd {
    // What evaluation needs to know of the incident direction.
    key: vec2<f32>,
    // x and y of the direction of travel in the pane's frame.
    direction: vec2<f32>,
    // Cosine times solid angle times transmittance of the way; 0 if nothing arrives.
    strength: vec3<f32>,
    padding: u32,
}

const NO_SCATTERING: u32 = 0xffffffffu;
const NO_PANE: u32 = 0xffffffffu;

// In the pane's frame.
fn pane_local(pane: Pane, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(direction, pane.x), dot(direction, pane.y), dot(direction, pane.z));
}

// A direction towards the disc of a sun.
fn disc_direction(direction: vec3<f32>, chord: f32, random: vec2<f32>) -> vec3<f32> {
    let radius = chord * sqrt(random.x);
    let frame = tangent_frame(direction);
    return normalize(direction + frame[0] * (radius * cos(TAU * random.y)) + frame[1] * (radius * sin(TAU * random.y)));
}

// Random numbers of sample `index` of a batch.
fn pane_random(seed: u32, batch: u32, index: u32) -> vec2<f32> {
    return sample_pair(index, 0u, hash_combine(seed, batch));
}

// A point moved off the pane to one of its sides.
fn off_pane(position: vec3<f32>, side: vec3<f32>) -> vec3<f32> {
    let largest = max(abs(position.x), max(abs(position.y), abs(position.z)));
    return position + side * (1e-5 * (largest + 0.5));
}

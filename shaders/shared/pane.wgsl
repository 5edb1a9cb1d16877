// Suns through panes that scatter: what the kernels of `sun_matrix/pane` exchange.

import package::generated::{Pane, TAU};
import package::shared::frame::{tangent_frame};
import package::shared::random::{sample_pair, hash_combine};

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

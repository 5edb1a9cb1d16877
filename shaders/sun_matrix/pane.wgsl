// Suns through panes that scatter: what the kernels of `sun_matrix/pane` exchange.

import package::generated::{Pane};


// In the pane's frame.
fn pane_local(pane: Pane, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(direction, pane.x), dot(direction, pane.y), dot(direction, pane.z));
}

// A point moved off the pane to one of its sides.
fn off_pane(position: vec3<f32>, side: vec3<f32>) -> vec3<f32> {
    let largest = max(abs(position.x), max(abs(position.y), abs(position.z)));
    return position + side * (1e-5 * (largest + 0.5));
}

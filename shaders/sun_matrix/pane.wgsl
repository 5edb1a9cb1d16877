// Suns through panes that scatter: what the kernels of `sun_matrix/pane` exchange.

import package::generated::{Pane, PaneSun, pane_of, pane_sun_of};

// In quads of words: panes, four each; then what they are to the suns, [sun][pane], two each.
@group(0) @binding(7) var<storage, read> pane_words: array<vec4<u32>>;

fn pane_at(pane: u32) -> Pane {
    let at = pane * 4u;
    return pane_of(pane_words[at], pane_words[at + 1u], pane_words[at + 2u], pane_words[at + 3u]);
}

// A sun seen through a pane, one of so many.
fn pane_sun_at(sun: u32, pane: u32, panes: u32) -> PaneSun {
    let at = panes * 4u + (sun * panes + pane) * 2u;
    return pane_sun_of(pane_words[at], pane_words[at + 1u]);
}

// In the pane's frame.
fn pane_local(pane: Pane, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(direction, pane.x), dot(direction, pane.y), dot(direction, pane.z));
}

// A point moved off the pane to one of its sides.
fn off_pane(position: vec3<f32>, side: vec3<f32>) -> vec3<f32> {
    let largest = max(abs(position.x), max(abs(position.y), abs(position.z)));
    return position + side * (1e-5 * (largest + 0.5));
}

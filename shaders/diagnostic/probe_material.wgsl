// For tests: panes of glass and diffuse directions.

import package::shared::material::{glass_pane, cosine_direction};

struct MaterialProbe {
    // Of the glass.
    transmissivity: vec3<f32>,
    index: f32,
    // Around which diffuse directions are drawn.
    normal: vec3<f32>,
    // Of incidence on the glass.
    cosine: f32,
    random: vec2<f32>,
    padding: vec2<u32>,
}

struct MaterialAnswer {
    transmitted: vec3<f32>,
    padding0: u32,
    reflected: vec3<f32>,
    padding1: u32,
    direction: vec3<f32>,
    padding2: u32,
}

@group(0) @binding(6) var<storage, read> probes: array<MaterialProbe>;
@group(0) @binding(8) var<storage, read_write> answers: array<MaterialAnswer>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&probes) {
        return;
    }
    let probe = probes[id.x];
    let pane = glass_pane(probe.transmissivity, probe.index, probe.cosine);
    answers[id.x] = MaterialAnswer(pane[0], 0u, pane[1], 0u, cosine_direction(probe.normal, probe.random), 0u);
}

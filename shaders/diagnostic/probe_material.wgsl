// For tests: panes of glass and diffuse directions.

import package::generated::{MaterialAnswer, MaterialProbe};
import package::shared::material::{glass_pane, cosine_direction};

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

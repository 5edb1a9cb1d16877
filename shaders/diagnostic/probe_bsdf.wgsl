// For tests: values and samples of scattering functions.

import package::generated::{BsdfAnswer, BsdfProbe};
import package::bsdf::scattering::{bsdf_value, bsdf_component, bsdf_lobe};
import package::bsdf::scattering_sample::{bsdf_sample, bsdf_direct_hemispherical};

@group(0) @binding(8) var<storage, read> probes: array<BsdfProbe>;
@group(0) @binding(9) var<storage, read_write> answers: array<BsdfAnswer>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&probes) {
        return;
    }
    let probe = probes[id.x];
    let component = bsdf_component(probe.outgoing, probe.incident);
    let drawn = bsdf_sample(probe.pane, component, probe.incident, probe.random);
    let whole = bsdf_direct_hemispherical(bsdf_lobe(probe.pane, component), probe.incident);
    answers[id.x] = BsdfAnswer(drawn.direction, drawn.weight, bsdf_value(probe.pane, probe.outgoing, probe.incident), whole, 0u, 0u);
}

// Openings that sunlight must pass: polygons of windows, or boxes around windows and their shades.

import package::generated::{Gate};
import package::shared::window::{leaves_through_window};

@group(0) @binding(11) var<storage, read> gates: array<Gate>;

fn passes_gate(gate: Gate, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    if dot(direction, gate.z) >= 0.0 {
        return false;
    }
    let start = vec3<f32>(dot(origin, gate.x), dot(origin, gate.y), dot(origin, gate.z));
    var along = vec3<f32>(dot(direction, gate.x), dot(direction, gate.y), dot(direction, gate.z));
    along = select(along, vec3<f32>(1e-20), abs(along) < vec3<f32>(1e-20));
    let a = (gate.low - start) / along;
    let b = (gate.high - start) / along;
    let enter = min(a, b);
    let leave = max(a, b);
    return max(max(enter.x, enter.y), max(enter.z, 0.0)) <= min(leave.x, min(leave.y, leave.z));
}

// Whether a ray passes one of the first `count` boxes.
fn passes_gates(origin: vec3<f32>, direction: vec3<f32>, count: u32) -> bool {
    for (var g = 0u; g < count; g++) {
        if passes_gate(gates[g], origin, direction) {
            return true;
        }
    }
    return false;
}

// Whether light may come in along a ray: by a box, or by a window if there are no boxes; from
// anywhere if there are neither.
fn may_come_in(origin: vec3<f32>, direction: vec3<f32>, gate_count: u32, window_count: u32) -> bool {
    if gate_count > 0u {
        return passes_gates(origin, direction, gate_count);
    }
    return window_count == 0u || leaves_through_window(origin, direction, window_count);
}

// What share of light passes between every receiver and the cells of the panes.

import package::generated::{NO_SCATTERING, Pane, PaneCell, PaneParams, Receiver};
import package::shared::window::{straight_transmittance};
import package::shared::counters::{count_finished};

@group(0) @binding(6) var<uniform> params: PaneParams;
@group(0) @binding(7) var<storage, read> panes: array<Pane>;
@group(0) @binding(8) var<storage, read> cells: array<PaneCell>;
// [receiver], or [batch][receiver]
@group(0) @binding(9) var<storage, read> receivers: array<Receiver>;
// [batch][cell][receiver], with the pane's tint.
@group(0) @binding(10) var<storage, read_write> passed: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    // Of all batches.
    let index = params.first_cell + id.y;
    if id.x >= params.receivers || index >= params.end_cell {
        return;
    }
    let receiver = receivers[index / params.cells * params.batch_stride + id.x];
    let cell = cells[index];
    let pane = panes[cell.pane];
    let to_cell = cell.position - receiver.position;
    let distance = max(length(to_cell), 1e-9);
    let direction = to_cell / distance;
    // A cell that lies altogether behind the receiver.
    let reach = dot(cell.corner - receiver.position, receiver.normal)
        + max(max(dot(cell.edge1, receiver.normal), dot(cell.edge2, receiver.normal)), 0.0);
    var share = vec3<f32>(0.0);
    if dot(direction, pane.z) < 0.0 && reach > 0.0 && pane.words != NO_SCATTERING {
        share = straight_transmittance(receiver.position, direction, distance * 0.99999) * pane.tint;
    }
    passed[index * params.receivers + id.x] = vec4<f32>(share, 0.0);
    count_finished(true);
}

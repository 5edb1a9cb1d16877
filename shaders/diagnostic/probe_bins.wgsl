// For tests: bins of directions, and directions of bins.

import package::generated::{BinAnswer, BinProbe, BinProbeParams};
import package::shared::window::{window_bin, window_bin_direction};
import package::shared::sky::{sky_bin};
import package::shared::scene::{window_at};

@group(0) @binding(6) var<uniform> params: BinProbeParams;
@group(0) @binding(8) var<storage, read> probes: array<BinProbe>;
@group(0) @binding(9) var<storage, read_write> answers: array<BinAnswer>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.count {
        return;
    }
    let probe = probes[id.x];
    let window = window_at(params.window);
    answers[id.x] = BinAnswer(
        window_bin_direction(window, probe.bin, probe.random),
        window_bin(window, probe.direction) - window.first_bin,
        sky_bin(probe.direction, params.row_height, params.sky_rows),
        0u, 0u, 0u,
    );
}

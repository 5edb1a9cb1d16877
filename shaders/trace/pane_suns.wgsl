// Which cells of the panes every sun reaches, and what it brings there.

import package::generated::{NO_SCATTERING, Pane, PaneCell, PaneEnd, PaneParams, PaneSunRecord, TRANSMISSION_FRONT};
import package::shared::window::{sky_transmittance};
import package::shared::counters::{count_finished};
import package::shared::pane::{pane_local, disc_direction, pane_random, off_pane};
import package::bsdf::scattering::{incident_key, bsdf_lobe};

@group(0) @binding(6) var<uniform> params: PaneParams;
@group(0) @binding(7) var<storage, read> panes: array<Pane>;
@group(0) @binding(8) var<storage, read> cells: array<PaneCell>;
// [sun][pane]
@group(0) @binding(9) var<storage, read> suns: array<PaneSunRecord>;
// [sun][batch][cell]
@group(0) @binding(10) var<storage, read_write> ends: array<PaneEnd>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let all = params.cells * params.batches;
    if id.x >= all || id.y >= params.suns {
        return;
    }
    let cell = cells[id.x];
    let pane = panes[cell.pane];
    let sun = suns[id.y * params.panes + cell.pane];
    let towards = disc_direction(sun.direction, sun.chord, pane_random(params.seed, id.x / params.cells, id.x % params.cells));
    let incident = -pane_local(pane, towards);
    var end = PaneEnd(vec2<f32>(0.0), incident.xy, vec3<f32>(0.0), 0u);
    if incident.z > 0.0 && pane.words != NO_SCATTERING {
        end.key = incident_key(bsdf_lobe(pane.words, TRANSMISSION_FRONT), incident);
        end.strength = sky_transmittance(off_pane(cell.position, -pane.z), towards) * (incident.z * sun.solid_angle * sun.scale);
    }
    ends[id.y * all + id.x] = end;
    count_finished(true);
}

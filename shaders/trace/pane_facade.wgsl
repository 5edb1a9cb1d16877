// Radiance of points of the panes towards an eye, per sun.

import package::generated::{FacadePoint, NO_PANE, NO_SCATTERING, Pane, PaneParams, PaneSunRecord, TRANSMISSION_FRONT};
import package::shared::random::{hash_combine};
import package::shared::window::{sky_transmittance};
import package::shared::counters::{count_finished};
import package::shared::pane::{pane_local, disc_direction, pane_random, off_pane};
import package::bsdf::scattering::{incident_key, outgoing_key, bsdf_of_keys, bsdf_lobe};

@group(0) @binding(6) var<uniform> params: PaneParams;
@group(0) @binding(7) var<storage, read> panes: array<Pane>;
@group(0) @binding(8) var<storage, read> points: array<FacadePoint>;
// [sun][pane]
@group(0) @binding(9) var<storage, read> suns: array<PaneSunRecord>;
// [batch][sun][point][rgb]; points are [batch][point] where each batch has its own.
@group(0) @binding(12) var<storage, read_write> sums: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.receivers || id.y >= params.suns {
        return;
    }
    let cell = ((id.z * params.suns + id.y) * params.receivers + id.x) * 3u;
    let point = points[id.z * params.batch_stride + id.x];
    if point.pane == NO_PANE {
        sums[cell] = 0.0;
        sums[cell + 1u] = 0.0;
        sums[cell + 2u] = 0.0;
        count_finished(true);
        return;
    }
    let pane = panes[point.pane];
    let sun = suns[id.y * params.panes + point.pane];
    let outgoing = pane_local(pane, point.outgoing);
    let seed = select(params.seed, hash_combine(params.seed, point.number), params.batch_stride > 0u);
    var sum = vec3<f32>(0.0);
    if outgoing.z > 0.0 && pane.words != NO_SCATTERING {
        let lobe = bsdf_lobe(pane.words, TRANSMISSION_FRONT);
        let out_key = outgoing_key(lobe, outgoing);
        for (var i = 0u; i < params.disc_samples; i++) {
            let towards = disc_direction(sun.direction, sun.chord, pane_random(seed, id.z, i));
            let incident = -pane_local(pane, towards);
            if incident.z > 0.0 {
                let apart = outgoing.xy - incident.xy;
                var value = sun.surround;
                if !(sun.guard > 0.0 && dot(apart, apart) <= sun.guard) {
                    value = bsdf_of_keys(lobe, out_key, incident_key(lobe, incident));
                }
                sum += sky_transmittance(off_pane(point.position, -pane.z), towards) * (value * incident.z);
            }
        }
    }
    let value = sum * pane.tint * (sun.scale * sun.solid_angle / f32(params.disc_samples));
    sums[cell] = value.x;
    sums[cell + 1u] = value.y;
    sums[cell + 2u] = value.z;
    count_finished(true);
}

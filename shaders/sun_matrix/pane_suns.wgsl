// What every sun brings to points of the panes: to a point of each cell, or by way of a point towards an eye.

import package::generated::{
    PaneEnd, PaneParams, PanePoint, SunRecord, NO_SCATTERING, TRANSMISSION_FRONT,
};
import package::shared::random::{sample_pair, hash_combine};
import package::sun_matrix::sun::{sun_direction, sun_transmittance};
import package::shared::counters::{count_finished};
import package::sun_matrix::pane::{off_pane, pane_at, pane_local, pane_sun_at};
import package::bsdf_scattering::scattering::{incident_key, outgoing_key, bsdf_of_keys, bsdf_lobe};

@group(0) @binding(6) var<uniform> params: PaneParams;
@group(0) @binding(8) var<storage, read> suns: array<SunRecord>;
// [batch][point]
@group(0) @binding(10) var<storage, read> points: array<PanePoint>;
// [sun][batch][point]
@group(0) @binding(11) var<storage, read_write> ends: array<PaneEnd>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    let all = params.cells * params.batches;
    if index >= all * params.suns {
        return;
    }
    let point = points[index % all];
    let sun_index = index / all;
    var end = PaneEnd(vec2<f32>(0.0), vec2<f32>(0.0), vec3<f32>(0.0), 0u);
    if point.pane < params.panes && pane_at(point.pane).words != NO_SCATTERING {
        let pane = pane_at(point.pane);
        let sun = suns[sun_index];
        let through = pane_sun_at(sun_index, point.pane, params.panes);
        let lobe = bsdf_lobe(pane.words, TRANSMISSION_FRONT);
        let outgoing = pane_local(pane, point.outgoing);
        let to_eye = dot(outgoing, outgoing) > 0.0;
        let out_key = outgoing_key(lobe, outgoing);
        // Points of pixels have directions of their own, those of cells share them out.
        let own = params.batch_stride > 0u;
        let seed = hash_combine(select(params.seed, hash_combine(params.seed, point.number), own), index % all / params.cells);
        let first = select(point.number * params.disc_samples, 0u, own);
        if !to_eye || outgoing.z > 0.0 {
            for (var i = 0u; i < params.disc_samples; i++) {
                let towards = sun_direction(sun, sample_pair(first + i, 0u, seed));
                let incident = -pane_local(pane, towards);
                end.direction = incident.xy;
                if incident.z > 0.0 {
                    var value = 1.0;
                    end.key = incident_key(lobe, incident);
                    if to_eye {
                        let apart = outgoing.xy - incident.xy;
                        value = through.surround;
                        if !(through.guard > 0.0 && dot(apart, apart) <= through.guard) {
                            value = bsdf_of_keys(lobe, out_key, end.key);
                        }
                    }
                    end.strength += sun_transmittance(off_pane(point.position, -pane.z), towards) * (value * incident.z);
                }
            }
        }
        end.strength *= pane.tint * (through.scale * sun.solid_angle / f32(params.disc_samples));
    }
    ends[index] = end;
    count_finished(true);
}

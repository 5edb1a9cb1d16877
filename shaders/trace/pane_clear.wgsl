// What every receiver gets straight from every sun's disc through panes that let it pass.

import package::generated::{Pane, PaneParams, PaneSunRecord, Receiver};
import package::shared::random::{hash_combine};
import package::shared::window::{distance_through, sky_transmittance, straight_transmittance};
import package::shared::counters::{count_finished};
import package::shared::pane::{disc_direction, pane_random, off_pane};

@group(0) @binding(6) var<uniform> params: PaneParams;
@group(0) @binding(7) var<storage, read> panes: array<Pane>;
// [receiver], or [batch][receiver]
@group(0) @binding(8) var<storage, read> receivers: array<Receiver>;
// [sun][pane]
@group(0) @binding(9) var<storage, read> suns: array<PaneSunRecord>;
// [batch][sun][receiver][rgb]
@group(0) @binding(12) var<storage, read_write> sums: array<f32>;

// Transmittance of the way from a point along a direction, through the first pane it meets.
fn through_panes(origin: vec3<f32>, direction: vec3<f32>, sun_index: u32) -> vec3<f32> {
    for (var p = 0u; p < params.panes; p++) {
        let clear = suns[sun_index * params.panes + p].clear;
        let pane = panes[p];
        if max(clear.x, max(clear.y, clear.z)) > 0.0 && dot(direction, pane.z) < 0.0 {
            for (var t = pane.first_triangle; t < pane.first_triangle + pane.triangles; t++) {
                let distance = distance_through(t, pane.z, origin, direction);
                if distance > 0.0 {
                    let inside = straight_transmittance(origin, direction, distance * 0.99999);
                    if max(inside.x, max(inside.y, inside.z)) <= 0.0 {
                        return vec3<f32>(0.0);
                    }
                    let outside = sky_transmittance(off_pane(origin + direction * distance, -pane.z), direction);
                    return clear * inside * outside;
                }
            }
        }
    }
    return vec3<f32>(0.0);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.receivers || id.y >= params.suns {
        return;
    }
    let receiver = receivers[id.z * params.batch_stride + id.x];
    let sun = suns[id.y * params.panes];
    // In a picture the receivers' points differ, and so do their points of the disc, so that errors even out.
    let seed = select(params.seed, hash_combine(params.seed, receiver.number), params.batch_stride > 0u);
    var sum = vec3<f32>(0.0);
    for (var i = 0u; i < params.disc_samples; i++) {
        let direction = disc_direction(sun.direction, sun.chord, pane_random(seed, id.z, i));
        let cosine = dot(direction, receiver.normal);
        if cosine > 0.0 {
            sum += through_panes(receiver.position, direction, id.y) * cosine;
        }
    }
    let value = sum * (sun.solid_angle / f32(params.disc_samples));
    let cell = ((id.z * params.suns + id.y) * params.receivers + id.x) * 3u;
    sums[cell] = value.x;
    sums[cell + 1u] = value.y;
    sums[cell + 2u] = value.z;
    count_finished(true);
}

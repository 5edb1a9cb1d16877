// Direct light of suns, second step: what the listed pairs of a receiver and a sun, or its image in flat
// mirrors, have of each other.

import package::generated::{Pair, PaneSun, FAR_AWAY};
import package::sun_matrix::pairs::{params, receivers, suns, receiver_of, image, is_open, pair_direction};
import package::shared::material::{largest};
import package::sun_matrix::mirrored::{MIRRORED, image_of, arriving};
import package::sun_matrix::sun::{hidden_by_one};
import package::shared::window::{crossed_window, NO_WINDOW};
import package::shared::counters::{counters, count_finished};

// Whether the openings are panes of scattering data, of which the through-peak lets the disc be seen.
override THROUGH_PANES: bool = false;

@group(0) @binding(9) var<storage, read> pairs: array<Pair>;
// Light of each pair, sr, rgb, and the doubt: the variance that it may have, by the number of points seen.
@group(0) @binding(10) var<storage, read_write> light: array<vec4<f32>>;
// [sun][pane]
@group(0) @binding(12) var<storage, read> pane_suns: array<PaneSun>;

// What part of the light arrives along a direction that is open.
fn passing(origin: vec3<f32>, direction: vec3<f32>, sun: u32) -> vec3<f32> {
    var clear = vec3<f32>(1.0);
    if THROUGH_PANES {
        let pane = crossed_window(origin, direction, FAR_AWAY, params.window_count).window;
        if pane == NO_WINDOW {
            return vec3<f32>(0.0);
        }
        clear = pane_suns[sun * params.window_count + pane].clear;
        if largest(clear) <= 0.0 {
            return clear;
        }
    }
    return clear * arriving(origin, direction, image(), params.gates, params.window_count);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= params.pairs {
        return;
    }
    let pair = pairs[index];
    let sun = suns[pair.sun];
    let receiver = receiver_of(pair.cell);
    let batch = pair.cell / params.receivers;
    let centre = image_of(sun.direction, image());
    var sum = vec3<f32>(0.0);
    var cosines = 0.0;
    var risen = true;
    var rays = 0u;
    var seen = 0u;
    var brightest = 0.0;
    var sample = 0u;
    // One ray in place of many where a wall is in the way, or a slat that is wide enough.
    if params.disc_samples > 2u && hidden_by_one(receiver.position, centre, sun.chord, !MIRRORED) {
        sample = params.disc_samples;
        risen = false;
        rays += 1u;
    }
    for (; sample < params.disc_samples; sample++) {
        let direction = pair_direction(receiver, sun, batch, sample);
        let cosine = dot(direction, receiver.normal);
        risen = risen && cosine > 0.0;
        if is_open(receiver, direction) {
            let passed = passing(receiver.position, direction, pair.sun);
            sum += cosine * passed;
            rays += 1u;
            seen += u32(largest(passed) > 0.0);
            brightest = max(brightest, cosine * largest(passed));
        }
        cosines += max(cosine, 0.0);
    }
    var doubtful = risen && sun.chord > 0.0 && params.rim > 0u;
    if doubtful && (seen == 0u || seen == params.disc_samples) {
        doubtful = false;
        for (var k = 0u; k < params.rim && !doubtful; k++) {
            let direction = pair_direction(receiver, sun, batch, params.disc_samples + k);
            var passed = 0.0;
            if is_open(receiver, direction) {
                passed = largest(passing(receiver.position, direction, pair.sun));
                rays += 1u;
            }
            doubtful = (passed > 0.0) != (seen > 0u);
            brightest = max(brightest, passed * dot(direction, receiver.normal));
        }
    }
    var doubt = 0.0;
    if doubtful {
        // Half a point more on either side; an edge through the disc does less than chance would.
        let n = f32(params.disc_samples);
        let share = (f32(seen) + 0.5) / (n + 1.0);
        let whole = sun.solid_angle * brightest;
        doubt = whole * whole * min(share * (1.0 - share) / n, 0.2 / (n * sqrt(n)));
    }
    var unit = sun.solid_angle / f32(params.disc_samples);
    if risen {
        // The visible share of the exact value: no noise where nothing is in the way.
        unit = sun.solid_angle * (dot(centre, receiver.normal) * (1.0 - 0.25 * sun.chord * sun.chord) / cosines);
    }
    light[index] = vec4<f32>(sum * unit, doubt);
    atomicAdd(&counters.segments, rays);
    count_finished(sample == params.disc_samples);
}

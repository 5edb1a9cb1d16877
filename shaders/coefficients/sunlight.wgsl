// Sunlight that comes to a window by way of surfaces outside.

import package::generated::{FAR_AWAY, FRAC_1_PI, MOST_PATH_SEGMENTS, SunRecord};
import package::shared::disc::{disc_direction};
import package::shared::material::{largest};
import package::shared::outside::{step_outside, Outdoors, Walk, GOES_ON};
import package::shared::random::{sample_pair, hash_combine, unit_f32};
import package::shared::window::{direct_transmittance, leaves_through_window};

// Where a light path comes from: the number of its patch or sun, its diffuse reflections outside, and whether its way
// outside is one that light paths of suns have.
fn path_label(source: u32, bounces: u32, plain: bool) -> u32 {
    return source + (min(bounces, 0x7fffu) << 16u) + select(0u, 0x80000000u, plain);
}

// What part of a sun's light arrives at a point outside. Nothing through a room: that light is counted where it enters it.
fn sun_outside(start: vec3<f32>, towards: vec3<f32>, window_count: u32) -> vec3<f32> {
    if leaves_through_window(start, towards, window_count) {
        return vec3<f32>(0.0);
    }
    return direct_transmittance(start, towards, FAR_AWAY);
}

struct Sunlight {
    // Radiance that arrives where the sun alone lights a surface facing it with irradiance 1.
    weight: vec3<f32>,
    // Diffuse reflections on the way.
    bounces: u32,
    segments: u32,
    ended: bool,
}

// Follows path `index` of the stream `seed` from a point outside, and at every diffuse surface looks for the sun. One of what
// is found stands for all, drawn by its light.
fn sunlight_outside(start: vec3<f32>, towards: vec3<f32>, sun: SunRecord, window_count: u32, index: u32, seed: u32, outdoors: Outdoors) -> Sunlight {
    var walk = Walk(start, towards, vec3<f32>(1.0), true, true, 0u, 0u);
    var result = Sunlight(vec3<f32>(0.0), 0u, 0u, false);
    var sum = 0.0;
    var rays = 0u;
    for (; walk.segment < MOST_PATH_SEGMENTS; walk.segment++) {
        let step = step_outside(&walk, index, 0u, seed, outdoors);
        if step.diffuse {
            let to_sun = disc_direction(sun.direction, sun.chord, sample_pair(index, 2u + walk.segment * 3u, seed));
            let cosine = dot(to_sun, step.side);
            if cosine > 0.0 {
                rays += 1u;
                let light = step.weight * sun_outside(step.position, to_sun, window_count) * (cosine * FRAC_1_PI);
                let strength = largest(light);
                sum += strength;
                if strength > unit_f32(hash_combine(seed + 1u, index * MOST_PATH_SEGMENTS + walk.segment)) * sum {
                    result.weight = light / strength;
                    result.bounces = walk.bounces;
                }
            }
        }
        if step.next != GOES_ON {
            result.ended = true;
            break;
        }
    }
    result.weight *= sum;
    result.segments = walk.segment + 1u + rays;
    result.ended = result.ended || walk.segment == MOST_PATH_SEGMENTS;
    return result;
}

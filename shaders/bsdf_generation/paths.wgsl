// BSDF of a sample by paths: each starts on a face of the box in an incident cell and is followed
// until it leaves; one record (outgoing cell, what is left of it) per path.
//
// Without diffuse reflections (all surfaces are then smooth) light divides at the first surface that
// both reflects and transmits specularly: paths come in pairs, one for each way.
//
// Incident cells are counted over both sides: light from the outside (travelling to +z) first.
// Outgoing cells likewise: light that leaves to the outside (-z) first.

import package::generated::{DIRECTIONS_SLICES, MATERIAL_MIRROR, MOST_PATH_SEGMENTS, NOWHERE};
import package::shared::circle::{circle};
import package::shared::random::{sample_pair, sample_four, hash_combine};
import package::shared::bvh::{leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{scatter, smooth_specular, cosine_direction, largest, Scatter, LOBE_NONE, LOBE_DIFFUSE, LOBE_SPECULAR};
import package::shared::counters::{counters, count_finished};
import package::bsdf_generation::sample::{params, fly, in_period};
import package::bsdf_generation::directions::{sample_cell, cell_of, turned, DIRECTIONS};
import package::shared::scene::{material_at};

// Whether paths go on after a diffuse reflection; otherwise they end there without a record.
override FOLLOW_DIFFUSE: bool = true;
// 2 where paths come in pairs, else 1.
override WAYS: u32 = 1u;

// [way][incident cell][path]: outgoing cell and bits of the weight.
@group(0) @binding(7) var<storage, read_write> records: array<vec2<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let path = id.x;
    let cell = params.first_cell + id.y;
    if path >= params.samples || id.y >= params.cells {
        return;
    }
    let index = params.first_sample + path;
    let seed = hash_combine(params.seed, cell);
    let from_outside = cell < params.in_cells;
    // Place and direction.
    let numbers = sample_four(index, seed);
    let extra = sample_pair(index, 2u, seed);
    var turn = vec2<f32>(1.0, 0.0);
    if DIRECTIONS == DIRECTIONS_SLICES {
        turn = circle(extra.y);
    }
    let start = sample_cell(cell % params.in_cells, true, numbers.zw, extra.x, true);
    var direction = turned(vec3<f32>(start.direction.xy, select(-start.direction.z, start.direction.z, from_outside)), turn);
    var position = vec3<f32>(mix(params.low.xy, params.high.xy, numbers.xy), select(params.high.z, params.low.z, from_outside));
    var weight = vec3<f32>(1.0);
    var record = vec2<u32>(NOWHERE, 0u);
    var bounces = 0u;
    var divided = false;
    var ended = false;
    var segment = 0u;
    for (; segment < MOST_PATH_SEGMENTS; segment++) {
        let flight = fly(position, direction);
        let hit = flight.hit;
        if hit.triangle == NO_TRIANGLE {
            // What was never divided belongs to the first of the pair.
            if !flight.lost && (divided || id.z == 0u) {
                let out = cell_of(turned(direction, vec2<f32>(turn.x, -turn.y)));
                record = vec2<u32>(select(0u, params.out_cells, direction.z > 0.0) + out, bitcast<u32>(dot(weight, params.luminance)));
            }
            ended = true;
            break;
        }
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let choices = sample_pair(index, 3u + segment * 2u, seed);
        let slope = sample_pair(index, 4u + segment * 2u, seed);
        let material = material_at(triangle_material(hit.triangle));
        var event: Scatter;
        if WAYS == 2u && !divided {
            let ways = smooth_specular(material, max(-dot(facing, direction), 1e-6), front);
            let both = largest(ways[0]) > 0.0 && largest(ways[1]) > 0.0;
            if !both && id.z == 1u {
                ended = true;
                break;
            }
            let through = select(largest(ways[0]) > 0.0, id.z == 0u, both);
            let mirrored = direction - 2.0 * dot(facing, direction) * facing;
            event = Scatter(LOBE_SPECULAR, through, select(ways[1], ways[0], through), select(mirrored, direction, through));
            divided = both;
        } else {
            event = scatter(material, direction, facing, front, choices.x, slope);
        }
        weight *= event.weight;
        if event.lobe == LOBE_NONE || largest(weight) <= 0.0 {
            if material.kind == MATERIAL_MIRROR && !front {
                // Here: paths that ended on the back of a mirror.
                atomicAdd(&counters.alive, 1u);
            }
            ended = true;
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        direction = event.direction;
        if event.lobe == LOBE_DIFFUSE {
            bounces += 1u;
            if !FOLLOW_DIFFUSE || bounces > params.most_bounces {
                ended = true;
                break;
            }
            direction = cosine_direction(side, slope);
        }
        let strength = largest(weight);
        if strength < params.roulette_weight {
            if choices.y * params.roulette_weight >= strength {
                ended = true;
                break;
            }
            weight *= params.roulette_weight / strength;
        }
        position = in_period(leave_surface(hit, side));
    }
    records[(id.z * params.cells + id.y) * params.samples + path] = record;
    atomicAdd(&counters.segments, segment + 1u);
    count_finished(ended || segment == MOST_PATH_SEGMENTS);
}

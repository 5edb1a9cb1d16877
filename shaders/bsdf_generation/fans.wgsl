// Fans: one ray from a chain's point into every cell. INCOMING fans give the irradiance of the point
// by each incident cell, over the flux of the cell per area of the sample; the others what leaves
// into each outgoing cell, over the cell's projected solid angle.
//
// Rays pass specular surfaces and end at diffuse ones: what these reflect is the business of the
// chain's next points.

import package::generated::{DIRECTIONS_RINGS, DIRECTIONS_SLICES, TAU};
import package::shared::circle::{circle};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{leave_surface, offset_from_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{scatter, largest, diffuse_share, LOBE_SPECULAR};
import package::shared::counters::{counters, count_finished};
import package::bsdf_generation::sample::{params, fly, in_period, REPEAT_X, REPEAT_Y};
import package::bsdf_generation::directions::{sample_cell, cell_of, turned, DIRECTIONS};
import package::bsdf_generation::chain::{chains, PARALLEL};
import package::shared::scene::{material_at, window_at};
import package::shared::window::{ring_of_bin};

override INCOMING: bool = false;
override SPECULAR: bool = true;
override COMPONENTS: u32 = 3u;
const MOST_SEGMENTS: u32 = 64u;

@group(0) @binding(8) var<storage, read> listed: array<u32>;
// Incoming: [component][cell][chain]; outgoing: [component][chain][cell]; fixed point.
@group(0) @binding(9) var<storage, read_write> fans: array<atomic<u32>>;

// Of a ring's cell, relative to the hemisphere's.
fn projected_share(cell: u32) -> f32 {
    let ring = ring_of_bin(0u, window_at(0).rings, cell);
    return (ring.cos2_low - ring.cos2_high) / f32(ring.bins);
}

// Whether light that arrives at `position` against `direction` has come through the face of the box.
fn came_through_face(position: vec3<f32>, direction: vec3<f32>) -> bool {
    let z = select(params.low.z, params.high.z, direction.z > 0.0);
    let place = position + direction * ((z - position.z) / direction.z);
    return (REPEAT_X || (place.x >= params.low.x && place.x <= params.high.x)) && (REPEAT_Y || (place.y >= params.low.y && place.y <= params.high.y));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let side_cells = select(params.out_cells, params.in_cells, INCOMING);
    let cell = id.x;
    if cell >= 2u * side_cells {
        return;
    }
    let number = listed[group.y];
    let chain = chains[number];
    let index = params.first_sample + number;
    let seed = hash_combine(hash_combine(params.seed, chain.bounces * 2u + u32(INCOMING)), cell);
    let normal = select(chain.leaving, chain.arriving, INCOMING);
    var turn = vec2<f32>(1.0, 0.0);
    if DIRECTIONS == DIRECTIONS_SLICES {
        turn = circle(sample_pair(index, 3u, params.seed).x);
    }
    let projected = abs(normal.z) > PARALLEL;
    let chosen = sample_cell(cell % side_cells, INCOMING, sample_pair(index, 0u, seed), sample_pair(index, 1u, seed).x, projected);
    // Light from the outside travels to +z, light that leaves to the outside to -z.
    let upward = (cell < side_cells) == INCOMING;
    let travel = turned(vec3<f32>(chosen.direction.xy, select(-chosen.direction.z, chosen.direction.z, upward)), turn);
    var direction = select(travel, -travel, INCOMING);
    let cosine = dot(direction, normal);
    if cosine <= 0.0 {
        count_finished(true);
        return;
    }
    var position = in_period(offset_from_surface(chain.position, normal));
    var weight = vec3<f32>(cosine * chosen.weight);
    if INCOMING {
        weight *= diffuse_share(material_at(chain.material), cosine);
    } else {
        weight *= chain.weight / (0.5 * TAU);
    }
    var direct = true;
    var escaped = false;
    var segment = 0u;
    for (; segment < MOST_SEGMENTS; segment++) {
        let flight = fly(position, direction);
        let hit = flight.hit;
        if hit.triangle == NO_TRIANGLE {
            escaped = !flight.lost && (!INCOMING || came_through_face(flight.position, direction));
            break;
        }
        if !SPECULAR {
            break;
        }
        let surface = triangle_normal(hit.triangle);
        let front = dot(surface, direction) < 0.0;
        let facing = select(-surface, surface, front);
        let choice = sample_pair(index, 3u + segment, seed);
        let event = scatter(material_at(triangle_material(hit.triangle)), direction, facing, front, choice.x, vec2<f32>(0.0));
        weight *= event.weight;
        if event.lobe != LOBE_SPECULAR || largest(weight) <= 0.0 {
            break;
        }
        direct = direct && event.transmitted;
        direction = event.direction;
        position = in_period(leave_surface(hit, select(facing, -facing, event.transmitted)));
    }
    if escaped {
        var found = cell;
        if !direct {
            let local = turned(select(direction, -direction, INCOMING), vec2<f32>(turn.x, -turn.y));
            let within = cell_of(local);
            found = select(side_cells, 0u, (local.z > 0.0) == INCOMING) + within;
            if DIRECTIONS == DIRECTIONS_RINGS {
                weight *= projected_share(cell % side_cells) / projected_share(within);
            }
        }
        for (var c = 0u; c < COMPONENTS; c++) {
            let incoming_place = (c * 2u * side_cells + found) * params.capacity + number;
            let outgoing_place = (c * params.capacity + number) * 2u * side_cells + found;
            atomicAdd(&fans[select(outgoing_place, incoming_place, INCOMING)], u32(weight[c] * params.unit + 0.5));
        }
    }
    atomicAdd(&counters.segments, min(segment + 1u, MOST_SEGMENTS));
    count_finished(true);
}

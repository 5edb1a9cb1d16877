// One step of chains: to the next diffuse reflection, or to their end.

import package::generated::{MOST_PATH_SEGMENTS};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{leave_surface, offset_from_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{scatter, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::counters::{counters, count_finished};
import package::bsdf_generation::sample::{params, fly, in_period};
import package::bsdf_generation::directions::{turned};
import package::bsdf_generation::chain::{chains};
import package::shared::scene::{material_at};

@group(0) @binding(8) var<storage, read> listed: array<u32>;
// 1 where a listed chain goes on.
@group(0) @binding(9) var<storage, read_write> goes_on: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.samples {
        return;
    }
    let number = listed[id.x];
    var chain = chains[number];
    let index = params.first_sample + number;
    let seed = hash_combine(params.seed, 0x77616c6bu + chain.bounces);
    var alive = false;
    var position = in_period(offset_from_surface(chain.position, chain.leaving));
    var direction = cosine_direction(chain.leaving, sample_pair(index, 0u, seed));
    var weight = chain.weight;
    var segment = 0u;
    for (; segment < MOST_PATH_SEGMENTS && chain.bounces < params.most_bounces; segment++) {
        let flight = fly(position, direction);
        let hit = flight.hit;
        if hit.triangle == NO_TRIANGLE {
            break;
        }
        let surface = triangle_normal(hit.triangle);
        let front = dot(surface, direction) < 0.0;
        let facing = select(-surface, surface, front);
        let choices = sample_pair(index, 1u + segment * 2u, seed);
        let slope = sample_pair(index, 2u + segment * 2u, seed);
        let number_there = triangle_material(hit.triangle);
        let event = scatter(material_at(number_there), direction, facing, front, choices.x, slope);
        weight *= event.weight;
        if event.lobe == LOBE_NONE || largest(weight) <= 0.0 {
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        // A fan costs many rays: chains survive in proportion to their weight.
        let survival = min(largest(weight), 1.0);
        if choices.y >= survival {
            break;
        }
        weight /= survival;
        if event.lobe == LOBE_DIFFUSE {
            chain.position = in_period(leave_surface(hit, side));
            chain.material = number_there;
            chain.leaving = side;
            chain.weight = weight;
            chain.bounces += 1u;
            alive = true;
            break;
        }
        direction = event.direction;
        position = in_period(leave_surface(hit, side));
    }
    chains[number] = chain;
    goes_on[id.x] = u32(alive);
    atomicAdd(&counters.segments, segment + 1u);
    count_finished(true);
}

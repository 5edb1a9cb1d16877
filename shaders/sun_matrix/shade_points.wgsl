// Points of the surfaces that scatter sunlight, shared by all receivers, and paths from each to the
// surfaces that it is lit by in turn. One path per invocation. The first vertex of a point's first path is
// the point itself, the others carry what it sends to its front of radiance that leaves them towards it.

import package::generated::{ShadeCell, ShadePointParams, SunVertex, PROBABILITY_STEPS};
import package::shared::random::{sample_four, sample_pair, hash_combine};
import package::shared::bvh::{margin_at, extent};
import package::shared::material::{cosine_direction, largest};
import package::sun_matrix::follow_path::{vertices, SunPath, SunPathEnd, follow_sun_path};
import package::shared::counters::{counters, count_finished};
import package::shared::scene::{material_at};

@group(0) @binding(6) var<uniform> params: ShadePointParams;
@group(0) @binding(7) var<storage, read> cells: array<ShadeCell>;

fn cell_at(position: u32) -> u32 {
    var low = 0u;
    var high = params.cells - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if position < cells[middle].limit {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = id.y * groups.x * 64u + id.x;
    if number >= params.count * params.paths {
        return;
    }
    let point = number % params.count;
    let path = number / params.count;
    let index = (params.first + point) % params.points;
    let seed = hash_combine(params.seed, (params.first + point) / params.points);
    let random = sample_four(index, seed);
    let cell = cells[select(cell_at(u32(random.x * f32(PROBABILITY_STEPS))), index, params.each_cell == 1u)];
    let along = cell.low.x + cell.size.x * random.y;
    let across = cell.low.y + cell.size.y * random.z;
    var place = cell.corner + cell.edge1 * along + cell.edge2 * across;
    if cell.is_triangle == 1u {
        let high = cell.low.x + cell.size.x;
        let root = sqrt(mix(cell.low.x * cell.low.x, high * high, random.y));
        place = cell.corner + (cell.edge1 * (1.0 - across) + cell.edge2 * across) * root;
    }
    let margin = max(margin_at(place), extent(cell.corner) * 1e-6);
    let slot = (point * params.paths + path) * params.most_vertices;
    var kept = 0u;
    if path == 0u {
        vertices[slot] = SunVertex(place + cell.facing * margin, cell.material, cell.facing, 2.0 * margin, -cell.facing, 0.0, vec3<f32>(1.0), cell.weight);
        kept = 1u;
    }
    // Reflected from its front, or passed on from its back.
    let material = material_at(cell.material - 1u);
    let reflected = largest(material.diffuse);
    let transmitted = largest(material.diffuse_transmitted);
    let total = (reflected + transmitted) / f32(params.paths);
    var end = SunPathEnd(0u, true, kept);
    if params.most_vertices > 1u && total > 0.0 {
        let stream = index * params.paths + path;
        let through = sample_pair(stream, 1u, seed).x * (reflected + transmitted) >= reflected;
        let throughput = select(material.diffuse * (total / reflected), material.diffuse_transmitted * (total / transmitted), through);
        let side = select(cell.facing, -cell.facing, through);
        let direction = cosine_direction(side, sample_pair(stream, 0u, seed));
        let start = place + side * margin;
        let most = params.most_vertices - 1u + kept;
        let least = params.roulette_weight * largest(throughput);
        end = follow_sun_path(SunPath(start, stream, direction, hash_combine(seed, 1u), throughput, slot, kept, most, least));
    }
    atomicAdd(&counters.segments, end.segments);
    count_finished(end.ended);
}

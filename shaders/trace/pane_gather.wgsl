// What every receiver gets from every sun over the cells of the panes.
//
// Visibility is known per cell; within a cell as many points are evaluated as its size seen from the
// receiver asks for.

import package::shared::counters::{count_finished};
import package::shared::receiver::{Receiver};
import package::shared::random::{hash_u32, hash_combine, unit_f32};
import package::shared::pane::{PaneParams, Pane, PaneSunRecord, PaneCell, PaneEnd, pane_local};
import package::bsdf::scattering::{bsdf_of_keys, bsdf_lobe, outgoing_key, TRANSMISSION_FRONT};

@group(0) @binding(6) var<uniform> params: PaneParams;
@group(0) @binding(7) var<storage, read> panes: array<Pane>;
@group(0) @binding(8) var<storage, read> cells: array<PaneCell>;
// [sun][pane]
@group(0) @binding(9) var<storage, read> suns: array<PaneSunRecord>;
// [batch][cell][receiver]
@group(0) @binding(10) var<storage, read> passed: array<vec4<f32>>;
// [sun][batch][cell]
@group(0) @binding(11) var<storage, read> sun_ends: array<PaneEnd>;
// [batch][sun][receiver][rgb]
@group(0) @binding(12) var<storage, read_write> sums: array<f32>;
@group(0) @binding(13) var<storage, read> receivers: array<Receiver>;

// Size of a part of a cell seen from the receiver, radians, and most parts along an edge.
const PART_ANGLE: f32 = 0.05;
const MOST_PARTS: f32 = 12.0;

// A random point of part `index` of `side`² equal triangles.
fn part_point(index: u32, side: u32, seed: u32) -> vec2<f32> {
    var row = u32(sqrt(f32(index) + 0.5));
    if row * row > index {
        row -= 1u;
    }
    let place = index - row * row;
    let column = place / 2u;
    let bits = hash_combine(seed, index);
    var inside = vec2<f32>(unit_f32(bits), unit_f32(hash_u32(bits + 1u)));
    if inside.x + inside.y > 1.0 {
        inside = 1.0 - inside;
    }
    if place % 2u == 0u {
        return (vec2<f32>(f32(row - column), f32(column)) + inside) / f32(side);
    }
    return (vec2<f32>(f32(row - column), f32(column + 1u)) - inside) / f32(side);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.receivers || id.y >= params.suns {
        return;
    }
    let receiver = receivers[id.x];
    let first = id.z * params.cells;
    var total = vec3<f32>(0.0);
    for (var i = 0u; i < params.cells; i++) {
        let index = first + i;
        let sun_end = sun_ends[id.y * params.cells * params.batches + index];
        let strength = sun_end.strength * passed[index * params.receivers + id.x].xyz;
        if max(strength.x, max(strength.y, strength.z)) > 0.0 {
            let cell = cells[index];
            let pane = panes[cell.pane];
            let lobe = bsdf_lobe(pane.words, TRANSMISSION_FRONT);
            let sun = suns[id.y * params.panes + cell.pane];
            let away = length(cell.corner + (cell.edge1 + cell.edge2) / 3.0 - receiver.position);
            let side = u32(clamp(ceil(sqrt(2.0 * cell.area) / (PART_ANGLE * max(away, 1e-9))), 1.0, MOST_PARTS));
            let seed = hash_combine(params.seed, index);
            var sum = 0.0;
            for (var part = 0u; part < side * side; part++) {
                let place = part_point(part, side, seed);
                let to_point = cell.corner + cell.edge1 * place.x + cell.edge2 * place.y - receiver.position;
                let distance2 = max(dot(to_point, to_point), 1e-18);
                let direction = to_point * inverseSqrt(distance2);
                let outgoing = -pane_local(pane, direction);
                let cosine = dot(direction, receiver.normal);
                if outgoing.z > 0.0 && cosine > 0.0 {
                    let apart = outgoing.xy - sun_end.direction;
                    var value = sun.surround;
                    if !(sun.guard > 0.0 && dot(apart, apart) <= sun.guard) {
                        value = bsdf_of_keys(lobe, outgoing_key(lobe, outgoing), sun_end.key);
                    }
                    sum += value * outgoing.z * cosine / distance2;
                }
            }
            total += strength * (sum * cell.area / f32(side * side));
        }
    }
    let cell = ((id.z * params.suns + id.y) * params.receivers + id.x) * 3u;
    sums[cell] = total.x;
    sums[cell + 1u] = total.y;
    sums[cell + 2u] = total.z;
    count_finished(true);
}

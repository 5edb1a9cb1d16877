// What every receiver gets from every sun over the cells of the panes.
//
// Visibility is known per cell; within a cell as many points are evaluated as its size seen from the
// receiver asks for. One invocation takes four suns, which share these points, and the cells
// `first_cell` … `end_cell` of a batch: some drivers end loops early. Sums add up over dispatches.

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
// [receiver], or [batch][receiver]
@group(0) @binding(13) var<storage, read> receivers: array<Receiver>;

// Most parts of a cell along an edge.
const MOST_PARTS: f32 = 8.0;

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

// Suns of one invocation.
const SUNS: u32 = 4u;

// A sun at a cell, loaded once for all points of the cell.
struct Light {
    strength: vec3<f32>,
    lit: bool,
    key: vec2<f32>,
    direction: vec2<f32>,
    guard: f32,
    surround: f32,
}

// Light of a sun, if there is one of this number, at a cell of a pane that a share `seen` passes from.
fn light_at(sun: u32, index: u32, pane: u32, seen: vec3<f32>) -> Light {
    var light: Light;
    if sun < params.suns {
        let sun_end = sun_ends[sun * params.cells * params.batches + index];
        let record = suns[sun * params.panes + pane];
        light.strength = sun_end.strength * seen;
        light.lit = max(light.strength.x, max(light.strength.y, light.strength.z)) > 0.0;
        light.key = sun_end.key;
        light.direction = sun_end.direction;
        light.guard = record.guard;
        light.surround = record.surround;
    }
    return light;
}

// The scattering function for it.
fn scattered(light: Light, lobe: u32, outgoing: vec2<f32>, key: vec2<f32>) -> f32 {
    if !light.lit {
        return 0.0;
    }
    let apart = outgoing - light.direction;
    if light.guard > 0.0 && dot(apart, apart) <= light.guard {
        return light.surround;
    }
    return bsdf_of_keys(lobe, key, light.key);
}

fn add(batch: u32, sun: u32, receiver: u32, value: vec3<f32>) {
    if sun < params.suns {
        let cell = ((batch * params.suns + sun) * params.receivers + receiver) * 3u;
        sums[cell] += value.x;
        sums[cell + 1u] += value.y;
        sums[cell + 2u] += value.z;
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let sun = id.y * SUNS;
    if id.x >= params.receivers || sun >= params.suns {
        return;
    }
    let receiver = receivers[id.z * params.batch_stride + id.x];
    var a = vec3<f32>(0.0);
    var b = vec3<f32>(0.0);
    var c = vec3<f32>(0.0);
    var d = vec3<f32>(0.0);
    var i = params.first_cell;
    for (; i < params.end_cell; i++) {
        let index = id.z * params.cells + i;
        let seen = passed[index * params.receivers + id.x].xyz;
        if max(seen.x, max(seen.y, seen.z)) <= 0.0 {
            continue;
        }
        let cell = cells[index];
        let light_a = light_at(sun, index, cell.pane, seen);
        let light_b = light_at(sun + 1u, index, cell.pane, seen);
        let light_c = light_at(sun + 2u, index, cell.pane, seen);
        let light_d = light_at(sun + 3u, index, cell.pane, seen);
        if light_a.lit || light_b.lit || light_c.lit || light_d.lit {
            let pane = panes[cell.pane];
            let lobe = bsdf_lobe(pane.words, TRANSMISSION_FRONT);
            let away = length(cell.corner + (cell.edge1 + cell.edge2) / 3.0 - receiver.position);
            let side = u32(clamp(ceil(sqrt(2.0 * cell.area) / (params.part_angle * max(away, 1e-9))), 1.0, MOST_PARTS));
            // Neighbours in a picture take other points, so that their errors even out.
            let shared_seed = hash_combine(params.seed, index);
            let seed = select(shared_seed, hash_combine(shared_seed, receiver.number), params.batch_stride > 0u);
            var sum = vec4<f32>(0.0);
            for (var part = 0u; part < side * side; part++) {
                let place = part_point(part, side, seed);
                let to_point = cell.corner + cell.edge1 * place.x + cell.edge2 * place.y - receiver.position;
                let distance2 = max(dot(to_point, to_point), 1e-18);
                let direction = to_point * inverseSqrt(distance2);
                let outgoing = -pane_local(pane, direction);
                let cosine = dot(direction, receiver.normal);
                if outgoing.z > 0.0 && cosine > 0.0 {
                    let key = outgoing_key(lobe, outgoing);
                    let value = vec4<f32>(
                        scattered(light_a, lobe, outgoing.xy, key),
                        scattered(light_b, lobe, outgoing.xy, key),
                        scattered(light_c, lobe, outgoing.xy, key),
                        scattered(light_d, lobe, outgoing.xy, key)
                    );
                    sum += value * (outgoing.z * cosine / distance2);
                }
            }
            sum *= cell.area / f32(side * side);
            a += light_a.strength * sum.x;
            b += light_b.strength * sum.y;
            c += light_c.strength * sum.z;
            d += light_d.strength * sum.w;
        }
    }
    add(id.z, sun, id.x, a);
    add(id.z, sun + 1u, id.x, b);
    add(id.z, sun + 2u, id.x, c);
    add(id.z, sun + 3u, id.x, d);
    count_finished(i == params.end_cell);
}

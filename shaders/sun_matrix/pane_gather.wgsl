// What every receiver gets from every sun over the cells of the panes.
//
// What arrives is known at one random point of each cell. Near the receiver the scattering function and
// the geometry differ within a cell: there their mean over many points stands for the value at that one
// point, in the share that the other batches found the cell lit. E[w(x) g(x) + w' (m - g(x))] = E[w g]
// for any w' that does not depend on x: no bias where a shadow's edge crosses the cell.
//
// One invocation takes four suns, which share these points, and the cells `first_cell` … `end_cell` of a
// batch: some drivers end loops early. Sums add up over dispatches.

import package::generated::{
    Pane, PaneCell, PaneEnd, PaneParams, Receiver, GATHERED_SUNS, TRANSMISSION_FRONT,
};
import package::shared::counters::{count_finished};
import package::shared::random::{hash_u32, hash_combine, unit_f32};
import package::sun_matrix::pane::{pane_at, pane_local, pane_sun_at};
import package::bsdf_scattering::scattering::{bsdf_of_keys, bsdf_lobe, outgoing_key};

@group(0) @binding(6) var<uniform> params: PaneParams;
@group(0) @binding(8) var<storage, read> cells: array<PaneCell>;
// [batch][cell][receiver][component]
@group(0) @binding(10) var<storage, read> links: array<f32>;
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

// A sun at a cell, loaded once for all points of the cell.
struct Light {
    // What arrives at the cell's random point and passes on to the receiver.
    strength: vec3<f32>,
    // The same at the points of the other batches, on average.
    elsewhere: vec3<f32>,
    lit: bool,
    key: vec2<f32>,
    direction: vec2<f32>,
    guard: f32,
    surround: f32,
}

// What passes.
fn link_at(index: u32) -> vec3<f32> {
    if params.components == 1u {
        return vec3<f32>(links[index]);
    }
    return vec3<f32>(links[index * 3u], links[index * 3u + 1u], links[index * 3u + 2u]);
}

// Light of a sun, if there is one of this number, at cell `cell` of a batch.
fn light_at(sun: u32, batch: u32, cell: u32, pane: u32, receiver: u32) -> Light {
    var light: Light;
    if sun < params.suns {
        for (var k = 0u; k < params.batches; k++) {
            let index = k * params.cells + cell;
            let strength = sun_ends[sun * params.cells * params.batches + index].strength * link_at(index * params.receivers + receiver);
            if k == batch {
                light.strength = strength;
            } else {
                light.elsewhere += strength / f32(params.batches - 1u);
            }
        }
        let sun_end = sun_ends[sun * params.cells * params.batches + batch * params.cells + cell];
        let record = pane_sun_at(sun, pane, params.panes);
        let most = max(light.strength, light.elsewhere);
        light.lit = max(most.x, max(most.y, most.z)) > 0.0;
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

// Scattering function and geometry of four suns at a point of a pane.
fn carried(point: vec3<f32>, receiver: Receiver, pane: Pane, lobe: u32, a: Light, b: Light, c: Light, d: Light) -> vec4<f32> {
    let to_point = point - receiver.position;
    let distance2 = max(dot(to_point, to_point), 1e-18);
    let direction = to_point * inverseSqrt(distance2);
    let outgoing = -pane_local(pane, direction);
    let cosine = dot(direction, receiver.normal);
    if outgoing.z <= 0.0 || cosine <= 0.0 {
        return vec4<f32>(0.0);
    }
    let key = outgoing_key(lobe, outgoing);
    let value = vec4<f32>(
        scattered(a, lobe, outgoing.xy, key),
        scattered(b, lobe, outgoing.xy, key),
        scattered(c, lobe, outgoing.xy, key),
        scattered(d, lobe, outgoing.xy, key)
    );
    return value * (outgoing.z * cosine / distance2);
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
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = id.y * groups.x * 64u + id.x;
    let receiver_index = number % params.receivers;
    let quads = (params.suns + GATHERED_SUNS - 1u) / GATHERED_SUNS;
    let sun = number / params.receivers % quads * GATHERED_SUNS;
    let batch = number / params.receivers / quads;
    if batch >= params.batches {
        return;
    }
    let receiver = receivers[batch * params.batch_stride + receiver_index];
    var a = vec3<f32>(0.0);
    var b = vec3<f32>(0.0);
    var c = vec3<f32>(0.0);
    var d = vec3<f32>(0.0);
    var i = params.first_cell;
    for (; i < params.end_cell; i++) {
        let index = batch * params.cells + i;
        let cell = cells[index];
        let light_a = light_at(sun, batch, i, cell.pane, receiver_index);
        let light_b = light_at(sun + 1u, batch, i, cell.pane, receiver_index);
        let light_c = light_at(sun + 2u, batch, i, cell.pane, receiver_index);
        let light_d = light_at(sun + 3u, batch, i, cell.pane, receiver_index);
        if light_a.lit || light_b.lit || light_c.lit || light_d.lit {
            let pane = pane_at(cell.pane);
            let lobe = bsdf_lobe(pane.words, TRANSMISSION_FRONT);
            let away = length(cell.corner + (cell.edge1 + cell.edge2) / 3.0 - receiver.position);
            let side = u32(clamp(ceil(sqrt(2.0 * cell.area) / (params.part_angle * max(away, 1e-9))), 1.0, MOST_PARTS));
            let here = cell.area * carried(cell.position, receiver, pane, lobe, light_a, light_b, light_c, light_d);
            a += light_a.strength * here.x;
            b += light_b.strength * here.y;
            c += light_c.strength * here.z;
            d += light_d.strength * here.w;
            if side > 1u {
                // Neighbours in a picture take other points, so that their errors even out.
                let shared_seed = hash_combine(params.seed, index);
                let seed = select(shared_seed, hash_combine(shared_seed, receiver.number), params.batch_stride > 0u);
                var sum = vec4<f32>(0.0);
                for (var part = 0u; part < side * side; part++) {
                    let place = part_point(part, side, seed);
                    let point = cell.corner + cell.edge1 * place.x + cell.edge2 * place.y;
                    sum += carried(point, receiver, pane, lobe, light_a, light_b, light_c, light_d);
                }
                let apart = sum * (cell.area / f32(side * side)) - here;
                a += light_a.elsewhere * apart.x;
                b += light_b.elsewhere * apart.y;
                c += light_c.elsewhere * apart.z;
                d += light_d.elsewhere * apart.w;
            }
        }
    }
    add(batch, sun, receiver_index, a);
    add(batch, sun + 1u, receiver_index, b);
    add(batch, sun + 2u, receiver_index, c);
    add(batch, sun + 3u, receiver_index, d);
    count_finished(i == params.end_cell);
}

// Scattering functions of panes: Klems matrices and tensor trees.
//
// Directions are those in which light travels, in the window's frame (z into the room); the signs
// of z tell the sides. Values are those of the bin or cell. A direction is turned once into a key
// (bin, or place in the square), so that many pairs can be evaluated from keys.

import package::generated::{KIND_KLEMS, KIND_TREE3, KIND_TREE3_REVERSED, KIND_TREE4, LOBE_BINS_IN, LOBE_KIND, LOBE_LAMBERTIAN, LOBE_NODES, LOBE_RINGS_IN, LOBE_RINGS_OUT, LOBE_RING_COUNT_IN, LOBE_RING_COUNT_OUT, LOBE_VALUES, LOBE_WORDS, PACKED_BRANCH, REFLECTION_BACK, REFLECTION_FRONT, RING_WORDS, TRANSMISSION_BACK, TRANSMISSION_FRONT};
import package::bsdf::square::{square_from_disk, BELOW_ONE};
import package::shared::bins::{azimuth_bin};

// Everything is words: four lobes per pane, then tables. See kernels/bsdf_scattering.
@group(0) @binding(14) var<storage, read> bsdf_words: array<u32>;

const MOST_LEVELS: u32 = 32u;

fn bsdf_number(index: u32) -> f32 {
    return bitcast<f32>(bsdf_words[index]);
}

fn bsdf_component(outgoing: vec3<f32>, incident: vec3<f32>) -> u32 {
    if incident.z >= 0.0 {
        return select(REFLECTION_FRONT, TRANSMISSION_FRONT, outgoing.z > 0.0);
    }
    return select(TRANSMISSION_BACK, REFLECTION_BACK, outgoing.z > 0.0);
}

// First word of a component's lobe of the pane that begins at word `pane`.
fn bsdf_lobe(pane: u32, component: u32) -> u32 {
    return pane + component * LOBE_WORDS;
}

fn ring_bin(first: u32, count: u32, direction: vec3<f32>) -> u32 {
    let cos2 = min(direction.z * direction.z, 1.0);
    var ring = count - 1u;
    while ring > 0u && cos2 > bsdf_number(first + ring * RING_WORDS) {
        ring -= 1u;
    }
    let words = first + ring * RING_WORDS;
    let bins = bsdf_words[words + 3u];
    if bins <= 1u {
        return bsdf_words[words + 2u];
    }
    return bsdf_words[words + 2u] + azimuth_bin(atan2(direction.y, direction.x), bins);
}

// What the lobe needs to know of an incident direction.
fn incident_key(lobe: u32, incident: vec3<f32>) -> vec2<f32> {
    switch bsdf_words[lobe + LOBE_KIND] {
        case KIND_KLEMS: {
            return vec2<f32>(f32(ring_bin(bsdf_words[lobe + LOBE_RINGS_IN], bsdf_words[lobe + LOBE_RING_COUNT_IN], incident)), 0.0);
        }
        case KIND_TREE4: {
            return square_from_disk(incident.xy);
        }
        default: {
            return incident.xy;
        }
    }
}

// And of an outgoing one.
fn outgoing_key(lobe: u32, outgoing: vec3<f32>) -> vec2<f32> {
    switch bsdf_words[lobe + LOBE_KIND] {
        case KIND_KLEMS: {
            return vec2<f32>(f32(ring_bin(bsdf_words[lobe + LOBE_RINGS_OUT], bsdf_words[lobe + LOBE_RING_COUNT_OUT], outgoing)), 0.0);
        }
        case KIND_TREE4: {
            return square_from_disk(outgoing.xy);
        }
        default: {
            return outgoing.xy;
        }
    }
}

// Cosine and sine of an azimuth, 0 at the pole.
fn azimuth_of(p: vec2<f32>) -> vec2<f32> {
    let sine = length(p);
    return select(vec2<f32>(1.0, 0.0), p / max(sine, 1e-20), sine > 1e-6);
}

// Coordinate of the first dimension of rank 3.
fn slice_of(sine: f32) -> f32 {
    return clamp(0.499999 - 0.5 * min(sine, 1.0), 0.0, BELOW_ONE);
}

// The value in the cell around a point.
fn tree_value(lobe: u32, rank: u32, point: vec4<f32>) -> f32 {
    let nodes = bsdf_words[lobe + LOBE_NODES];
    let values = bsdf_words[lobe + LOBE_VALUES];
    var p = point;
    var node = nodes;
    for (var level = 0u; level < MOST_LEVELS; level++) {
        let first = bsdf_words[node];
        let size = bsdf_words[node + 1u];
        if size != PACKED_BRANCH {
            let side = 1u << size;
            var index = 0u;
            for (var i = 0u; i < rank; i++) {
                index = index * side + min(u32(p[i] * f32(side)), side - 1u);
            }
            return bsdf_number(values + first + index);
        }
        var child = 0u;
        for (var i = 0u; i < rank; i++) {
            p[i] *= 2.0;
            if p[i] >= 1.0 {
                p[i] -= 1.0;
                child |= 1u << i;
            }
        }
        node = nodes + (first + child) * 2u;
    }
    return 0.0;
}

fn isotropic_value(lobe: u32, outgoing: vec2<f32>, incident: vec2<f32>) -> f32 {
    let turn = azimuth_of(incident);
    let turned = vec2<f32>(outgoing.x * turn.x + outgoing.y * turn.y, outgoing.y * turn.x - outgoing.x * turn.y);
    return tree_value(lobe, 3u, vec4<f32>(slice_of(length(incident)), square_from_disk(turned), 0.0));
}

// The scattering function of a lobe, 1/sr.
fn bsdf_of_keys(lobe: u32, outgoing: vec2<f32>, incident: vec2<f32>) -> f32 {
    var value = bsdf_number(lobe + LOBE_LAMBERTIAN);
    switch bsdf_words[lobe + LOBE_KIND] {
        case KIND_KLEMS: {
            value += bsdf_number(bsdf_words[lobe + LOBE_VALUES] + u32(outgoing.x) * bsdf_words[lobe + LOBE_BINS_IN] + u32(incident.x));
        }
        case KIND_TREE4: {
            value += tree_value(lobe, 4u, vec4<f32>(incident, outgoing));
        }
        case KIND_TREE3: {
            value += isotropic_value(lobe, outgoing, incident);
        }
        case KIND_TREE3_REVERSED: {
            value += isotropic_value(lobe, -incident, -outgoing);
        }
        default: {
        }
    }
    return value;
}

// The scattering function of the pane that begins at word `pane`, 1/sr.
fn bsdf_value(pane: u32, outgoing: vec3<f32>, incident: vec3<f32>) -> f32 {
    let lobe = bsdf_lobe(pane, bsdf_component(outgoing, incident));
    return bsdf_of_keys(lobe, outgoing_key(lobe, outgoing), incident_key(lobe, incident));
}

// Importance sampling of scattering functions: density proportional to the function in projected
// solid angle, so that every sample weighs the direct-hemispherical value.

import package::generated::{
    KIND_BLACK, KIND_KLEMS, KIND_TREE3_REVERSED, KIND_TREE4, LOBE_BINS_OUT, LOBE_KIND, LOBE_LAMBERTIAN,
    LOBE_RINGS_OUT, LOBE_RING_COUNT_OUT, LOBE_SAMPLING, LOBE_SAMPLING_SIDE, PI, REFLECTION_BACK, RING_WORDS,
    TRANSMISSION_FRONT,
};
import package::shared::circle::{circle};
import package::bsdf_scattering::square::{square_from_disk, disk_from_square};
import package::bsdf_scattering::scattering::{bsdf_words, bsdf_number, bsdf_component, bsdf_lobe, bsdf_of_keys, incident_key, outgoing_key, azimuth_of, slice_of};

const MOST_STEPS: u32 = 32u;

struct BsdfSample {
    // Unit vector in the window's frame.
    direction: vec3<f32>,
    // Factor on the light's flux; 0 if nothing is scattered to this side.
    weight: f32,
}

// The places of outgoing light for one incident direction: first word, words per place, number.
struct Places {
    first: u32,
    count: u32,
    // Flux of all, without the Lambertian part.
    total: f32,
}

fn places_of(lobe: u32, key: vec2<f32>) -> Places {
    let table = bsdf_words[lobe + LOBE_SAMPLING];
    if bsdf_words[lobe + LOBE_KIND] == KIND_KLEMS {
        let count = bsdf_words[lobe + LOBE_BINS_OUT];
        let first = table + u32(key.x) * count;
        return Places(first, count, bsdf_number(first + count - 1u));
    }
    let side = bsdf_words[lobe + LOBE_SAMPLING_SIDE];
    var cell = min(u32(slice_of(length(key)) * f32(side)), side - 1u);
    if bsdf_words[lobe + LOBE_KIND] == KIND_TREE4 {
        cell = min(u32(key.x * f32(side)), side - 1u) * side + min(u32(key.y * f32(side)), side - 1u);
    }
    let words = table + cell * 3u;
    return Places(bsdf_words[words], bsdf_words[words + 1u], bsdf_number(words + 2u));
}

// Transmittance or reflectance of a lobe for light of this incident direction.
fn bsdf_direct_hemispherical(lobe: u32, incident: vec3<f32>) -> f32 {
    if bsdf_words[lobe + LOBE_KIND] == KIND_BLACK {
        return 0.0;
    }
    return bsdf_number(lobe + LOBE_LAMBERTIAN) * PI + places_of(lobe, incident_key(lobe, incident)).total;
}

// First place whose cumulative flux exceeds `target_sum`; each place has `words` words, its
// cumulative flux first.
fn find_place(places: Places, words: u32, target_sum: f32) -> u32 {
    var low = 0u;
    var high = places.count - 1u;
    for (var step = 0u; step < MOST_STEPS && low < high; step++) {
        let middle = (low + high) / 2u;
        if bsdf_number(places.first + middle * words) > target_sum {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    return low;
}

fn upward(p: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(p, sqrt(max(1.0 - dot(p, p), 0.0)));
}

fn in_bin(lobe: u32, bin: u32, random: vec2<f32>) -> vec3<f32> {
    let rings = bsdf_words[lobe + LOBE_RINGS_OUT];
    var ring = bsdf_words[lobe + LOBE_RING_COUNT_OUT] - 1u;
    while ring > 0u && bsdf_words[rings + ring * RING_WORDS + 2u] > bin {
        ring -= 1u;
    }
    let words = rings + ring * RING_WORDS;
    let cos2 = mix(bsdf_number(words), bsdf_number(words + 1u), random.x);
    let sine = sqrt(max(1.0 - cos2, 0.0));
    let turns = (f32(bin - bsdf_words[words + 2u]) + random.y - 0.5) / f32(bsdf_words[words + 3u]);
    return vec3<f32>(sine * circle(turns), sqrt(max(cos2, 0.0)));
}

fn in_cell(lobe: u32, packed: u32, incident: vec2<f32>, random: vec2<f32>) -> vec3<f32> {
    let width = 1.0 / f32(1u << (packed & 31u));
    let corner = vec2<f32>(f32((packed >> 5u) & 0x1fffu), f32(packed >> 18u));
    let p = disk_from_square((corner + random) * width);
    if bsdf_words[lobe + LOBE_KIND] == KIND_TREE4 {
        return upward(p);
    }
    let turn = azimuth_of(incident);
    return upward(vec2<f32>(p.x * turn.x - p.y * turn.y, p.x * turn.y + p.y * turn.x));
}

// Where light of the pane's component goes on that travels along `incident`.
fn bsdf_sample(pane: u32, component: u32, incident: vec3<f32>, random: vec3<f32>) -> BsdfSample {
    let lobe = bsdf_lobe(pane, component);
    let kind = bsdf_words[lobe + LOBE_KIND];
    // To the room.
    let up = component == TRANSMISSION_FRONT || component == REFLECTION_BACK;
    var result = BsdfSample(vec3<f32>(0.0, 0.0, 1.0), 0.0);
    if kind == KIND_BLACK {
        return result;
    }
    let key = incident_key(lobe, incident);
    let lambertian = bsdf_number(lobe + LOBE_LAMBERTIAN) * PI;
    if kind == KIND_TREE3_REVERSED {
        result.direction = upward(disk_from_square(random.yz));
        result.weight = PI * bsdf_of_keys(lobe, result.direction.xy, key);
    } else {
        let places = places_of(lobe, key);
        result.weight = lambertian + places.total;
        let flux = random.x * result.weight;
        if flux < lambertian || places.total <= 0.0 {
            result.direction = upward(disk_from_square(random.yz));
        } else if kind == KIND_KLEMS {
            result.direction = in_bin(lobe, find_place(places, 1u, flux - lambertian), random.yz);
        } else {
            let place = places.first + find_place(places, 2u, flux - lambertian) * 2u;
            result.direction = in_cell(lobe, bsdf_words[place + 1u], incident.xy, random.yz);
        }
    }
    if !up {
        result.direction.z = -result.direction.z;
    }
    return result;
}

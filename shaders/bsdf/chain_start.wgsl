// First points of chains: uniform on the diffuse surfaces, in proportion to their albedo.

import package::shared::random::{sample_pair};
import package::shared::material::{materials, largest};
import package::shared::counters::{count_finished};
import package::bsdf::sample::{params, GenerationParams, in_period};
import package::bsdf::directions::{turned};
import package::bsdf::chain::{chains, Chain};

// Three corners each; the first one's w is the upper limit of the triangle's share of the whole, the
// second's the bits of its material.
@group(0) @binding(8) var<storage, read> diffuse_triangles: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.samples {
        return;
    }
    let index = params.first_sample + id.x;
    // Triangle and side; place; lobe.
    let choice = sample_pair(index, 0u, params.seed);
    let place = sample_pair(index, 1u, params.seed);
    let lobe = sample_pair(index, 2u, params.seed).x;
    var low = 0u;
    var high = params.diffuse_count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if choice.x >= diffuse_triangles[middle * 3u].w {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    let a = diffuse_triangles[low * 3u].xyz;
    let b = diffuse_triangles[low * 3u + 1u].xyz;
    let c = diffuse_triangles[low * 3u + 2u].xyz;
    let root = sqrt(place.x);
    let position = a * (1.0 - root) + b * (root * (1.0 - place.y)) + c * (root * place.y);
    let normal = normalize(cross(b - a, c - a));
    let number = bitcast<u32>(diffuse_triangles[low * 3u + 1u].w);
    let material = materials[number];
    let reflected = largest(material.diffuse);
    let transmitted = largest(material.diffuse_transmitted);
    let arriving = select(-normal, normal, choice.y < 0.5);
    var chain = Chain(in_period(position), number, arriving, 1u, arriving, 0u, vec3<f32>(0.0), 0u);
    // The albedo is in the density of the points already.
    if lobe * (reflected + transmitted) < reflected {
        chain.weight = material.diffuse / reflected;
    } else {
        chain.leaving = -arriving;
        chain.weight = material.diffuse_transmitted / max(transmitted, 1e-20);
    }
    chains[id.x] = chain;
    count_finished(true);
}

// First points of chains on the sides of diffuse triangles, chosen by the shares of a table.

import package::generated::{Chain};
import package::shared::random::{sample_four};
import package::shared::material::{largest};
import package::shared::counters::{count_finished};
import package::bsdf_generation::sample::{params, in_period};
import package::bsdf_generation::directions::{turned};
import package::bsdf_generation::chain::{chains};
import package::shared::scene::{material_at};

// Three corners each, once for either side; the first one's w is the upper limit of the entry's share
// of all chains, the second's the bits of its material. Corners run counter-clockwise on the side of
// arrival.
@group(0) @binding(8) var<storage, read> diffuse_triangles: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= params.samples {
        return;
    }
    let index = params.first_sample + id.x;
    // Side, place on it, lobe.
    let numbers = sample_four(index, params.seed);
    var low = 0u;
    var high = params.diffuse_count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if numbers.x >= diffuse_triangles[middle * 3u].w {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    let a = diffuse_triangles[low * 3u].xyz;
    let b = diffuse_triangles[low * 3u + 1u].xyz;
    let c = diffuse_triangles[low * 3u + 2u].xyz;
    let root = sqrt(numbers.y);
    let position = a * (1.0 - root) + b * (root * (1.0 - numbers.z)) + c * (root * numbers.z);
    let arriving = normalize(cross(b - a, c - a));
    let number = bitcast<u32>(diffuse_triangles[low * 3u + 1u].w);
    let material = material_at(number);
    let reflected = largest(material.diffuse);
    let transmitted = largest(material.diffuse_transmitted);
    var chain = Chain(in_period(position), number, arriving, 1u, arriving, low, vec3<f32>(0.0), 0u);
    // The host knows the density of the points, and their albedo.
    if numbers.w * (reflected + transmitted) < reflected {
        chain.weight = material.diffuse / reflected;
    } else {
        chain.leaving = -arriving;
        chain.weight = material.diffuse_transmitted / max(transmitted, 1e-20);
    }
    chains[id.x] = chain;
    count_finished(true);
}

// Chains of diffuse reflections inside a sample. A chain starts at a random point of the diffuse
// surfaces. What every incident cell sends there, and what leaves from its points into every outgoing
// cell, is found by fans of rays: one ray per cell, so that one chain serves all entries of the BSDF.

import package::bsdf::sample::{params, GenerationParams};

struct Chain {
    // The latest point.
    position: vec3<f32>,
    // Material there.
    material: u32,
    // Unit normal of the side from which light leaves.
    leaving: vec3<f32>,
    // Diffuse reflections up to and at this point.
    bounces: u32,
    // Unit normal of the side on which light arrives at the first point.
    arriving: vec3<f32>,
    // Entry of the table from which the first point came.
    entry: u32,
    // Of light that leaves, relative to the irradiance of the first point.
    weight: vec3<f32>,
    padding: u32,
}

@group(0) @binding(7) var<storage, read_write> chains: array<Chain>;

// Normals closer than this to the sample's have cells sampled in projected solid angle, which is
// exact for surfaces parallel to the sample.
const PARALLEL: f32 = 0.99999;

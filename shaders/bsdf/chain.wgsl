// Chains of diffuse reflections inside a sample. A chain starts at a random point of the diffuse
// surfaces. What every incident cell sends there, and what leaves from its points into every outgoing
// cell, is found by fans of rays: one ray per cell, so that one chain serves all entries of the BSDF.

import package::generated::{Chain};
import package::bsdf::sample::{params};

@group(0) @binding(7) var<storage, read_write> chains: array<Chain>;

// Normals closer than this to the sample's have cells sampled in projected solid angle, which is
// exact for surfaces parallel to the sample.
const PARALLEL: f32 = 0.99999;

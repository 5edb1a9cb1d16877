// Directional bins: rings of a window basis, and Reinhart sky patches.

import package::shared::random::{unit_f32};

// One ring of a window's basis. Cosines squared, because acos is inexact on some devices.
struct Ring {
    cos2_low: f32,    // at the lower polar limit (1 at the pole)
    cos2_high: f32,   // at the upper polar limit (0 at the horizon)
    first: u32,
    bins: u32,
}

const TAU: f32 = 6.283185307179586;

// Position of an azimuth in a ring of `bins` bins, the first centred on azimuth 0.
fn azimuth_bin(azimuth: f32, bins: u32) -> u32 {
    let turns = azimuth / TAU * f32(bins) + 0.5 + f32(bins);
    return u32(floor(turns)) % bins;
}

// Altitude rows of a Reinhart sky: sines of their lower limits, first index, patches.
struct SkyRow {
    sin_low: f32,
    first: u32,
    patches: u32,
    padding: u32,
}

// Rings of directional bins: of a window's basis, of the sky.

const TAU: f32 = 6.283185307179586;

// One ring of a window's basis. Squared cosines, because acos is inexact on some devices.
struct Ring {
    // At the lower polar limit (1 at the pole).
    cos2_low: f32,
    // At the upper polar limit (0 at the horizon).
    cos2_high: f32,
    // First bin, counted within the window.
    first: u32,
    bins: u32,
}

// Position of an azimuth (radians) in a ring of `bins` bins, the first centred on azimuth 0.
fn azimuth_bin(azimuth: f32, bins: u32) -> u32 {
    let position = azimuth / TAU * f32(bins) + 0.5 + f32(bins);
    return u32(position) % bins;
}

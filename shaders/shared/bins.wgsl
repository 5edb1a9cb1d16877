// Rings of directional bins: of a window's basis, of the sky.

import package::generated::{TAU};

// Position of an azimuth (radians) in a ring of `bins` bins, the first centred on azimuth 0.
fn azimuth_bin(azimuth: f32, bins: u32) -> u32 {
    let position = azimuth / TAU * f32(bins) + 0.5 + f32(bins);
    return u32(position) % bins;
}

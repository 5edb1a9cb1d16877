// Cosine and sine, of which Vulkan lets a driver's own be wrong by 2^-11.

import package::generated::{TAU};

// Cosine and sine of an angle counted in turns (1 is 360 degrees), at most four million; errors below 1.2e-7.
fn circle(turns: f32) -> vec2<f32> {
    let quarters = floor(4.0 * turns + 0.5);
    // Taylor's series in at most π/4.
    let x = TAU * (turns - 0.25 * quarters);
    let x2 = x * x;
    let cosine = 1.0 - x2 * (1.0 / 2.0 - x2 * (1.0 / 24.0 - x2 * (1.0 / 720.0 - x2 * (1.0 / 40320.0))));
    let sine = x - x * x2 * (1.0 / 6.0 - x2 * (1.0 / 120.0 - x2 * (1.0 / 5040.0 - x2 * (1.0 / 362880.0))));
    let quarter = u32(i32(quarters)) & 3u;
    let odd = (quarter & 1u) == 1u;
    let a = select(cosine, sine, odd);
    let b = select(sine, cosine, odd);
    return vec2<f32>(select(a, -a, quarter == 1u || quarter == 2u), select(b, -b, quarter >= 2u));
}

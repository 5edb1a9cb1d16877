// Lists the pixels above the threshold, one run of pixels and hour after the other.

import package::generated::{COMPACT_WORKGROUP, PIXELS_EACH};
import package::glare::compact::{params, luminance, sums, is_glare, first_pixel, count_pixels};

// Where the list of each run begins, [hour][run].
@group(0) @binding(3) var<storage, read> places: array<u32>;
// Bits of the luminance and number of the pixel.
@group(0) @binding(4) var<storage, read_write> found: array<vec2<u32>>;

@compute @workgroup_size(COMPACT_WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let hour = group.y;
    let own = count_pixels(group.x, hour, lane);
    var place = places[hour * params.runs + group.x] + sums[lane] - own;
    for (var i = 0u; i < PIXELS_EACH; i++) {
        let pixel = first_pixel(group.x, lane) + i;
        if pixel < params.pixels {
            let value = luminance[hour * params.stride + pixel];
            if is_glare(value, hour) {
                found[place] = vec2<u32>(bitcast<u32>(value), pixel);
                place++;
            }
        }
    }
}

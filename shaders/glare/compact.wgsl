// The pixels above the threshold in a run of pixels of one hour: a workgroup takes one run; within it every
// invocation takes neighbouring pixels, so that they are counted and listed in their order.

import package::generated::{CompactParams, COMPACT_WORKGROUP, PIXELS_EACH};

// Exponent of infinities and NaN.
const NOT_FINITE: u32 = 0x7f800000u;

@group(0) @binding(0) var<uniform> params: CompactParams;
// [hour][pixel]
@group(0) @binding(1) var<storage, read> luminance: array<f32>;
@group(0) @binding(2) var<storage, read> thresholds: array<f32>;

var<workgroup> sums: array<u32, COMPACT_WORKGROUP>;

fn is_glare(value: f32, hour: u32) -> bool {
    // What is not finite is handed over too: the host refuses it.
    let threshold = thresholds[params.first_hour + hour];
    return value > threshold || (bitcast<u32>(value) & NOT_FINITE) == NOT_FINITE;
}

/// The invocation's first pixel.
fn first_pixel(run: u32, lane: u32) -> u32 {
    return (run * COMPACT_WORKGROUP + lane) * PIXELS_EACH;
}

/// The number of the invocation's glare pixels; `sums` has those of all invocations up to each.
fn count_pixels(run: u32, hour: u32, lane: u32) -> u32 {
    let first = first_pixel(run, lane);
    var own = 0u;
    for (var i = 0u; i < PIXELS_EACH; i++) {
        if first + i < params.pixels && is_glare(luminance[hour * params.stride + first + i], hour) {
            own++;
        }
    }
    sums[lane] = own;
    workgroupBarrier();
    for (var step = 1u; step < COMPACT_WORKGROUP; step *= 2u) {
        var before = 0u;
        if lane >= step {
            before = sums[lane - step];
        }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    return own;
}

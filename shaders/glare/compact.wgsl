// The pixels above the threshold: counts them in each run of pixels and hour, or with `list` writes
// their numbers and luminances one after the other. One workgroup takes one run; within it every
// invocation takes neighbouring pixels, so the list is in the order of the pixels.

struct CompactParams {
    // Pixels of an hour, and the distance between hours.
    pixels: u32,
    stride: u32,
    // The first hour's threshold in the list.
    first_hour: u32,
    // Runs of pixels per hour.
    runs: u32,
}

const WORKGROUP: u32 = 256u;
const EACH: u32 = 8u;
// Exponent of infinities and NaN.
const NOT_FINITE: u32 = 0x7f800000u;

@group(0) @binding(0) var<uniform> params: CompactParams;
// [hour][pixel]
@group(0) @binding(1) var<storage, read> luminance: array<f32>;
@group(0) @binding(2) var<storage, read> thresholds: array<f32>;
// [hour][run]
@if(list)
@group(0) @binding(3) var<storage, read> places: array<u32>;
@else
@group(0) @binding(3) var<storage, read_write> counts: array<u32>;
// Bits of the luminance and number of the pixel.
@if(list)
@group(0) @binding(4) var<storage, read_write> found: array<vec2<u32>>;

var<workgroup> sums: array<u32, 256>;

fn is_glare(value: f32, threshold: f32) -> bool {
    // What is not finite is handed over too: the host refuses it.
    return value > threshold || (bitcast<u32>(value) & NOT_FINITE) == NOT_FINITE;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let run = group.x;
    let hour = group.y;
    let first = (run * WORKGROUP + lane) * EACH;
    let threshold = thresholds[params.first_hour + hour];
    var own = 0u;
    for (var i = 0u; i < EACH; i++) {
        if first + i < params.pixels && is_glare(luminance[hour * params.stride + first + i], threshold) {
            own++;
        }
    }
    sums[lane] = own;
    workgroupBarrier();
    // Running sums over the workgroup.
    for (var step = 1u; step < WORKGROUP; step *= 2u) {
        var before = 0u;
        if lane >= step {
            before = sums[lane - step];
        }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    @if(list) {
        var place = places[hour * params.runs + run] + sums[lane] - own;
        for (var i = 0u; i < EACH; i++) {
            let pixel = first + i;
            if pixel < params.pixels {
                let value = luminance[hour * params.stride + pixel];
                if is_glare(value, threshold) {
                    found[place] = vec2<u32>(bitcast<u32>(value), pixel);
                    place++;
                }
            }
        }
    }
    @else {
        if lane == WORKGROUP - 1u {
            counts[hour * params.runs + run] = sums[lane];
        }
    }
}

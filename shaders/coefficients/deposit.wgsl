// Where the kernels of the daylight coefficients put the light that they find.

import package::generated::{CoefficientParams};

// 1 for grey scenes, 3 for coloured ones.
override COMPONENTS: u32 = 3u;

@group(0) @binding(6) var<uniform> params: CoefficientParams;
// [direct or other][batch][sensor][patch][component], fixed point.
@group(0) @binding(9) var<storage, read_write> sums: array<atomic<u32>>;

// `dither`, random in [0, 1), rounds up or down so that what is less than a unit is kept in the mean.
fn deposit(row: u32, direct: bool, patch_index: u32, weight: vec3<f32>, dither: f32) {
    let part = select(params.batches * params.sensors, 0u, direct);
    let value = weight * params.unit + dither;
    let cell = ((part + row) * params.patches + patch_index) * COMPONENTS;
    for (var c = 0u; c < COMPONENTS; c++) {
        atomicAdd(&sums[cell + c], u32(value[c]));
    }
}

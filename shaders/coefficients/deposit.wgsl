// Where the kernels of the daylight coefficients put the light that they find.

import package::generated::{CoefficientParams};

// 1 for grey scenes, 3 for coloured ones.
override COMPONENTS: u32 = 3u;

@group(0) @binding(6) var<uniform> params: CoefficientParams;
// [DIRECT, OTHER or SUNLIT][batch][sensor][patch][component], fixed point.
@group(0) @binding(9) var<storage, read_write> sums: array<atomic<u32>>;

// Parts of the light: what nothing has reflected; what light paths of suns find as well; the rest.
const DIRECT: u32 = 0u;
const OTHER: u32 = 1u;
const SUNLIT: u32 = 2u;

// `dither`, random in [0, 1), rounds up or down so that what is less than a unit is kept in the mean.
fn deposit(row: u32, part: u32, patch_index: u32, weight: vec3<f32>, dither: f32) {
    let value = weight * params.unit + dither;
    let cell = ((part * params.batches * params.sensors + row) * params.patches + patch_index) * COMPONENTS;
    for (var c = 0u; c < COMPONENTS; c++) {
        atomicAdd(&sums[cell + c], u32(value[c]));
    }
}

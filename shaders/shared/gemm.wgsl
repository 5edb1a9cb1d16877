// What the product kernels share: parameters, and where a result goes.

import package::generated::{GemmParams};

@group(0) @binding(0) var<uniform> params: GemmParams;
// Whether the tile is [component][column][row], not [component][row][column].
override COLUMNS: bool = false;

// The tile; both dimensions are padded, so no entry lies outside.
@group(0) @binding(3) var<storage, read_write> product: array<vec4<f32>>;

/// Stores four rows of four columns; `row` and `column` are multiples of 4.
fn store_block(row: u32, column: u32, component: u32, row0: vec4<f32>, row1: vec4<f32>, row2: vec4<f32>, row3: vec4<f32>) {
    if COLUMNS {
        let turned = transpose(mat4x4<f32>(row0, row1, row2, row3));
        let at = component * params.plane + column * params.stride + row / 4u;
        product[at] = turned[0];
        product[at + params.stride] = turned[1];
        product[at + 2u * params.stride] = turned[2];
        product[at + 3u * params.stride] = turned[3];
    } else {
        let at = component * params.plane + row * params.stride + column / 4u;
        product[at] = row0;
        product[at + params.stride] = row1;
        product[at + 2u * params.stride] = row2;
        product[at + 3u * params.stride] = row3;
    }
}

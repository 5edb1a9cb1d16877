// What the product kernels share: parameters, and where a result goes.

struct GemmParams {
    // Terms of each sum, padded with zeros to a multiple of 8.
    inner: u32,
    // All further numbers count quads of values.
    // First column of the tile in the right factor.
    first_column: u32,
    // Distance between the terms of a sum in the left and right factor.
    left_stride: u32,
    right_stride: u32,
    // Distance between components in the left and right factor.
    left_plane: u32,
    right_plane: u32,
    // Distance between rows (or columns) of the tile, and between its components.
    stride: u32,
    plane: u32,
}

@group(0) @binding(0) var<uniform> params: GemmParams;
// The tile: [component][row][column], or with `columns` [component][column][row]; both dimensions
// are padded, so no entry lies outside.
@group(0) @binding(3) var<storage, read_write> product: array<vec4<f32>>;

/// Stores four rows of four columns; `row` and `column` are multiples of 4.
fn store_block(row: u32, column: u32, component: u32, row0: vec4<f32>, row1: vec4<f32>, row2: vec4<f32>, row3: vec4<f32>) {
    @if(columns) {
        let turned = transpose(mat4x4<f32>(row0, row1, row2, row3));
        let at = component * params.plane + column * params.stride + row / 4u;
        product[at] = turned[0];
        product[at + params.stride] = turned[1];
        product[at + 2u * params.stride] = turned[2];
        product[at + 3u * params.stride] = turned[3];
    }
    @else {
        let at = component * params.plane + row * params.stride + column / 4u;
        product[at] = row0;
        product[at + params.stride] = row1;
        product[at + 2u * params.stride] = row2;
        product[at + 3u * params.stride] = row3;
    }
}

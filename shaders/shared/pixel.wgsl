// What the kernels of a picture's view matrix share. A tile of pixels is worked on at once; every
// pixel has one surface point per batch.

// Element of a [bin][batch][pixel] table.
fn pixel_cell(params_bins_batch_pixels: vec3<u32>, bin: u32, batch: u32, pixel: u32) -> u32 {
    return (bin * params_bins_batch_pixels.y + batch) * params_bins_batch_pixels.z + pixel;
}


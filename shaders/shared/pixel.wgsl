// What the kernels of a picture's view matrix share. A tile of pixels is worked on at once; every
// pixel has one surface point per batch.

struct TileParams {
    seed: u32,
    // Pixels of this tile.
    pixels: u32,
    // Light paths per bin and batch, all of which are summed.
    paths: u32,
    batches: u32,
    bins: u32,
    window_count: u32,
    // Rays per pixel through which the directly seen windows are found.
    subpixels: u32,
    // Window samples per surface point, and every how many one is traced.
    window_samples: u32,
    traced_every: u32,
    // Room for lights per bin and batch.
    lights: u32,
    near_radius: f32,
    // Fixed-point units of a whole pixel.
    unit: f32,
}

// Per bin while a row is built: unobstructed light, and of the traced part how much was sent and
// how much arrived.
struct BinShare {
    unobstructed: vec3<f32>,
    traced: f32,
    arrived: vec3<f32>,
    padding: u32,
}

// What few hits leave open, of a pixel's surface point in a batch; irradiance, sr.
struct PixelChances {
    // Straight from the windows: with nothing in the way; how many rays, and how many of them arrived.
    straight: f32,
    rays: f32,
    hits: f32,
    // By light paths: sum of what the rays stand for, of its squares, and of those that arrived.
    gathered: f32,
    gathered_squares: f32,
    gathered_hits: f32,
    padding0: f32,
    padding1: f32,
}

// Element of a [bin][batch][pixel] table.
fn pixel_cell(params_bins_batch_pixels: vec3<u32>, bin: u32, batch: u32, pixel: u32) -> u32 {
    return (bin * params_bins_batch_pixels.y + batch) * params_bins_batch_pixels.z + pixel;
}

// A camera ray.
struct PixelRay {
    origin: vec3<f32>,
    // How far it goes; 0 for pixels outside the view.
    length: f32,
    direction: vec3<f32>,
    // Number of the pixel in the picture.
    number: u32,
}

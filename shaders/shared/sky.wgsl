// Reinhart's sky patches with the ground first.

import package::generated::{SkyRow};
import package::shared::bins::{azimuth_bin};

@group(0) @binding(7) var<storage, read> sky_rows: array<SkyRow>;

// Patch of a direction towards the sky; 0 at and below the horizon. `rows` counts the cap.
fn sky_bin(direction: vec3<f32>, row_height: f32, rows: u32) -> u32 {
    if direction.z <= 0.0 {
        return 0u;
    }
    // asin is inexact on some devices: guess, then correct by the exact limits.
    var row = min(u32(asin(min(direction.z, 1.0)) / row_height), rows - 1u);
    if row > 0u && direction.z < sky_rows[row].sin_low {
        row -= 1u;
    } else if direction.z >= sky_rows[row + 1u].sin_low {
        row += 1u;
    }
    let found = sky_rows[row];
    var position = 0u;
    if found.patches > 1u {
        position = azimuth_bin(atan2(direction.x, direction.y), found.patches);
    }
    return found.first + position;
}

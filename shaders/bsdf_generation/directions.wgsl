// Cells of directions through a sample: where a direction falls, and directions inside a cell.
//
// Directions are those in which light travels; both sides of the sample share the cells, so only
// x and y and the size of z count. The sample's frame is the world: z into the room, y up.

import package::generated::{DIRECTIONS_RINGS, DIRECTIONS_SLICES, TAU};
import package::shared::circle::{circle};
import package::shared::window::{ring_of_bin, window_bin, window_bin_direction};
import package::shared::scene::{window_at};

override DIRECTIONS: u32 = 0u;
// Cells along a side of the square.
override SIDE: u32 = 2u;

struct CellSample {
    // z ≥ 0.
    direction: vec3<f32>,
    // Solid angle that the sample stands for over the projected solid angle of its cell.
    weight: f32,
}

// What the numbers of a square's row or column mean: distance from the middle, and the sign.
fn from_middle(index: u32) -> u32 {
    let half = SIDE / 2u;
    return select(half - 1u - index, index - half, index >= half);
}

// The polar angle whose sine is r (atan2 is more exact than asin on some devices).
fn polar_angle(r: f32) -> f32 {
    return atan2(r, sqrt(max(1.0 - r * r, 0.0)));
}

// Direction at the square's coordinates a, b in -1…1, whose larger one in size is sin θ.
fn square_direction(a: f32, b: f32, cosine: f32) -> vec3<f32> {
    var radius = a;
    var turns = 0.125 * b / select(a, 1.0, a == 0.0);
    if abs(b) >= abs(a) {
        radius = b;
        turns = 0.25 - 0.125 * a / select(b, 1.0, b == 0.0);
    }
    return vec3<f32>(radius * circle(turns), cosine);
}

fn sample_square(cell: u32, random: vec2<f32>, half: f32, projected: bool) -> CellSample {
    let width = 2.0 / f32(SIDE);
    let row = cell / SIDE;
    let column = cell % SIDE;
    if projected {
        let a = -1.0 + (f32(row) + random.x) * width;
        let b = -1.0 + (f32(column) + random.y) * width;
        let r = max(abs(a), abs(b));
        let cosine = sqrt(max(1.0 - r * r, 0.0));
        return CellSample(square_direction(a, b, cosine), 1.0 / max(cosine, 1e-6));
    }
    // Uniform in the polar angle and in the square's other coordinate: uniform in solid angle.
    let from_row = from_middle(row);
    let from_column = from_middle(column);
    let along_a = from_row > from_column || (from_row == from_column && half < 0.5);
    let low = f32(max(from_row, from_column)) * width;
    let theta_low = polar_angle(low);
    let theta_high = polar_angle(min(low + width, 1.0));
    let polar = circle(mix(theta_low, theta_high, random.x) / TAU);
    let r = polar.y;
    let side_low = f32(min(from_row, from_column)) * width;
    // On the diagonal the cell is cut into two triangles.
    let side_high = select(side_low + width, max(r, side_low), from_row == from_column);
    let side = mix(side_low, side_high, random.y);
    let halves = select(1.0, 2.0, from_row == from_column);
    let weight = halves * (theta_high - theta_low) * (side_high - side_low) / (width * width);
    let middle = SIDE / 2u;
    let a = select(-1.0, 1.0, row >= middle) * select(side, r, along_a);
    let b = select(-1.0, 1.0, column >= middle) * select(r, side, along_a);
    return CellSample(square_direction(a, b, polar.x), weight);
}

fn sample_slice(cell: u32, random: vec2<f32>, projected: bool) -> CellSample {
    let width = 2.0 / f32(SIDE);
    let high = 1.0 - f32(cell) * width;
    let low = max(high - width, 0.0);
    let area = 0.5 * (high * high - low * low);
    if projected {
        let r = sqrt(mix(low * low, high * high, random.x));
        let cosine = sqrt(max(1.0 - r * r, 0.0));
        return CellSample(vec3<f32>(r, 0.0, cosine), 1.0 / max(cosine, 1e-6));
    }
    let theta_low = polar_angle(low);
    let theta_high = polar_angle(high);
    let polar = circle(mix(theta_low, theta_high, random.x) / TAU);
    return CellSample(vec3<f32>(polar.y, 0.0, polar.x), polar.y * (theta_high - theta_low) / area);
}

fn sample_ring(cell: u32, random: vec2<f32>, projected: bool) -> CellSample {
    if projected {
        let direction = window_bin_direction(window_at(0), cell, random);
        return CellSample(direction, 1.0 / max(direction.z, 1e-6));
    }
    let r = ring_of_bin(0u, window_at(0).rings, cell);
    let low = sqrt(r.cos2_low);
    let high = sqrt(r.cos2_high);
    let cosine = mix(low, high, random.x);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    let across = sine * circle((f32(cell - r.first) + random.y - 0.5) / f32(r.bins));
    return CellSample(vec3<f32>(across, cosine), 2.0 / (low + high));
}

// A direction inside a cell: uniform in projected solid angle if `projected`, else in solid angle.
fn sample_cell(cell: u32, incident: bool, random: vec2<f32>, half: f32, projected: bool) -> CellSample {
    if DIRECTIONS == DIRECTIONS_RINGS {
        return sample_ring(cell, random, projected);
    }
    if DIRECTIONS == DIRECTIONS_SLICES && incident {
        return sample_slice(cell, random, projected);
    }
    return sample_square(cell, random, half, projected);
}

// Cell of light travelling along `direction`; with slices, of outgoing light only.
fn cell_of(direction: vec3<f32>) -> u32 {
    if DIRECTIONS == DIRECTIONS_RINGS {
        return window_bin(window_at(0), direction);
    }
    let r = min(length(direction.xy), 1.0);
    var phi = atan2(direction.y, direction.x);
    let quarter = TAU / 8.0;
    if phi < -quarter {
        phi += TAU;
    }
    var a = r;
    var b = phi * r / quarter;
    if phi >= 5.0 * quarter {
        a = (phi - 6.0 * quarter) * r / quarter;
        b = -r;
    } else if phi >= 3.0 * quarter {
        a = -r;
        b = -(phi - 4.0 * quarter) * r / quarter;
    } else if phi >= quarter {
        a = -(phi - 2.0 * quarter) * r / quarter;
        b = r;
    }
    let place = clamp(vec2<i32>(floor((vec2<f32>(a, b) + 1.0) * 0.5 * f32(SIDE))), vec2<i32>(0), vec2<i32>(i32(SIDE) - 1));
    return u32(place.x) * SIDE + u32(place.y);
}

// Turned about z by the angle with this cosine and sine.
fn turned(direction: vec3<f32>, turn: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(turn.x * direction.x - turn.y * direction.y, turn.y * direction.x + turn.x * direction.y, direction.z);
}

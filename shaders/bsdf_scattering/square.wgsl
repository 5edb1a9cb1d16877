// The Shirley-Chiu map between the unit disc of projected directions and the unit square.

import package::generated::{FRAC_PI_4};
import package::shared::circle::{circle};

// Keeps coordinates inside the square: the largest f32 below 1.
const BELOW_ONE: f32 = 0.99999994;

fn square_from_disk(p: vec2<f32>) -> vec2<f32> {
    let r = min(length(p), 1.0);
    var phi = atan2(p.y, p.x);
    if phi < -FRAC_PI_4 {
        phi += 8.0 * FRAC_PI_4;
    }
    var place = vec2<f32>(r, phi * r / FRAC_PI_4);
    if phi >= 5.0 * FRAC_PI_4 {
        place = vec2<f32>((phi - 6.0 * FRAC_PI_4) * r / FRAC_PI_4, -r);
    } else if phi >= 3.0 * FRAC_PI_4 {
        place = vec2<f32>(-r, -(phi - 4.0 * FRAC_PI_4) * r / FRAC_PI_4);
    } else if phi >= FRAC_PI_4 {
        place = vec2<f32>(-(phi - 2.0 * FRAC_PI_4) * r / FRAC_PI_4, r);
    }
    return clamp((place + 1.0) * 0.5, vec2<f32>(0.0), vec2<f32>(BELOW_ONE));
}

fn disk_from_square(square: vec2<f32>) -> vec2<f32> {
    let p = 2.0 * square - 1.0;
    if p.x == 0.0 && p.y == 0.0 {
        return p;
    }
    if abs(p.x) > abs(p.y) {
        return p.x * circle(0.125 * (p.y / p.x));
    }
    return p.y * circle(0.25 - 0.125 * (p.x / p.y));
}

// A sample of a window layer: its box, and flight through it, over the edges of a period if the
// sample repeats.

import package::generated::{FAR_AWAY, GenerationParams};
import package::shared::bvh::{closest_hit, Hit, NO_TRIANGLE};

@group(0) @binding(6) var<uniform> params: GenerationParams;

// Whether the box is a period along x and y; otherwise light leaves over its sides for good.
override REPEAT_X: bool = false;
override REPEAT_Y: bool = false;
// Ends light that travels on and on between the faces.
const MOST_PERIODS: u32 = 4096u;

struct Flight {
    // The first surface met, if any.
    hit: Hit,
    // Where light left the sample (somewhere on its way out if the sample does not repeat).
    position: vec3<f32>,
    // Given up after MOST_PERIODS.
    lost: bool,
}

// The same place in the first period.
fn in_period(position: vec3<f32>) -> vec3<f32> {
    let size = params.high - params.low;
    let periods = floor((position - params.low) / size);
    return position - vec3<f32>(select(0.0, periods.x * size.x, REPEAT_X), select(0.0, periods.y * size.y, REPEAT_Y), 0.0);
}

fn distance_to_face(position: f32, direction: f32, low: f32, high: f32) -> f32 {
    if abs(direction) < 1e-12 {
        return FAR_AWAY;
    }
    return max((select(low, high, direction > 0.0) - position) / direction, 0.0);
}

fn fly(start: vec3<f32>, direction: vec3<f32>) -> Flight {
    if !REPEAT_X && !REPEAT_Y {
        return Flight(closest_hit(start, direction, FAR_AWAY), start, false);
    }
    var position = start;
    var hit = Hit(FAR_AWAY, NO_TRIANGLE, vec2<f32>(0.0));
    for (var period = 0u; period < MOST_PERIODS; period++) {
        let to_z = distance_to_face(position.z, direction.z, params.low.z, params.high.z);
        let to_x = select(FAR_AWAY, distance_to_face(position.x, direction.x, params.low.x, params.high.x), REPEAT_X);
        let to_y = select(FAR_AWAY, distance_to_face(position.y, direction.y, params.low.y, params.high.y), REPEAT_Y);
        let nearest = min(to_z, min(to_x, to_y));
        // A little further than the edge, so that no surface on it is missed; copies of the
        // surfaces reach beyond the edges.
        hit = closest_hit(position, direction, nearest + 1e-5);
        if hit.triangle != NO_TRIANGLE {
            return Flight(hit, position, false);
        }
        position += direction * nearest;
        if to_z <= nearest {
            return Flight(hit, position, false);
        }
        if to_x <= nearest {
            position.x = select(params.high.x, params.low.x, direction.x > 0.0);
        }
        if to_y <= nearest {
            position.y = select(params.high.y, params.low.y, direction.y > 0.0);
        }
    }
    return Flight(hit, position, true);
}

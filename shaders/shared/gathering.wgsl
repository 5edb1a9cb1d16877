// Virtual lights connected to a sensor: what all of them would give with nothing in the way is summed exactly; rays
// go only to a few of them, drawn systematically in proportion to what they would give.

import package::generated::{Receiver, VirtualLight, MOST_VISIBILITY_RAYS};
import package::shared::connection::{connection};
import package::shared::window::{direct_transmittance};

// Rays per sensor, bin and batch.
override RAYS: u32 = 8u;

@group(0) @binding(8) var<storage, read> lights: array<VirtualLight>;

// Lights that rays go to.
var<private> chosen: array<u32, MOST_VISIBILITY_RAYS>;

// Chooses among `light_count` lights from `first` on, and gives what each ray stands for; 0 if there is no light.
fn choose_lights(sensor: Receiver, first: u32, light_count: u32, near_radius: f32, random: f32) -> f32 {
    var unobstructed = 0.0;
    for (var i = 0u; i < light_count; i++) {
        unobstructed += lights[first + i].strength * connection(sensor, lights[first + i], near_radius);
    }
    if !(unobstructed > 0.0) {
        return 0.0;
    }
    let step = unobstructed / f32(RAYS);
    var threshold = step * random;
    var found = 0u;
    var sum = 0.0;
    var last = first;
    for (var i = 0u; i < light_count; i++) {
        let value = lights[first + i].strength * connection(sensor, lights[first + i], near_radius);
        sum += value;
        if value > 0.0 {
            last = first + i;
        }
        while sum > threshold && found < RAYS {
            chosen[found] = first + i;
            found += 1u;
            threshold += step;
        }
    }
    // Rounding may leave the last threshold just above the sum.
    while found < RAYS {
        chosen[found] = last;
        found += 1u;
    }
    return step;
}

// Sum of the squares of how many rays go to one light: they find it together.
fn squares_of_rays() -> f32 {
    var squares = 0.0;
    var alike = 0.0;
    for (var ray = 0u; ray < RAYS; ray++) {
        alike += 1.0;
        if ray + 1u == RAYS || chosen[min(ray + 1u, RAYS - 1u)] != chosen[ray] {
            squares += alike * alike;
            alike = 0.0;
        }
    }
    return squares;
}

// The part of a chosen light that arrives, per colour, of all its colours together.
fn arriving(sensor: Receiver, ray: u32) -> vec3<f32> {
    let light = lights[chosen[ray]];
    let to_light = light.position - sensor.position;
    let distance = length(to_light);
    let passed = direct_transmittance(sensor.position, to_light / distance, distance * 0.999999);
    return passed * light.flux / light.strength;
}

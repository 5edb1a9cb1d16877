// Rays from a point to the outer sides of windows.

import package::shared::bvh::{offset_from_surface};
import package::shared::material::{glass_pane, largest};
import package::shared::scene::{material_at, window_at};
import package::shared::window::{sample_windows, direct_transmittance};

struct WindowRay {
    // Whether light would come along it, and where its way outside begins.
    arrives: bool,
    start: vec3<f32>,
    direction: vec3<f32>,
    // Irradiance that the ray stands for, sr, and the same as if nothing were in the way and panes let everything through.
    weight: vec3<f32>,
    possible: f32,
}

// From a point on the side of the unit normal `side`, panes between included.
fn window_ray(position: vec3<f32>, side: vec3<f32>, random: vec2<f32>, window_count: u32, first_pane: u32) -> WindowRay {
    var result = WindowRay(false, vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), 0.0);
    let to_window = sample_windows(position, window_count, random);
    let cosine = dot(to_window.direction, side);
    if !(to_window.weight > 0.0 && cosine > 0.0) {
        return result;
    }
    result.possible = cosine * to_window.weight;
    let window = window_at(to_window.window);
    let pane = material_at(first_pane + to_window.window);
    let through = glass_pane(pane.specular, pane.roughness, max(-dot(to_window.direction, window.z), 1e-6))[0];
    let passed = direct_transmittance(position, to_window.direction, to_window.distance * 0.99999) * through;
    result.arrives = largest(passed) > 0.0;
    result.start = offset_from_surface(position + to_window.direction * to_window.distance, -window.z);
    result.direction = to_window.direction;
    result.weight = passed * result.possible;
    return result;
}

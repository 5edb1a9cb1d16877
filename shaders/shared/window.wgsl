// Windows: their directional bins, points on them, and rays towards them.

import package::generated::{Ring, Window, FAR_AWAY, PI, TAU};
import package::shared::bins::{azimuth_bin};
import package::shared::circle::{circle};
import package::shared::bvh::{light_passing, NO_TRIANGLE, ANY, ANY_BUT_GLASS};
import package::shared::scene::{ring_at, scene_parts, window_at, window_corner};

// Whether the scene has panes of glass, which let direct connections through.
override HAS_GLASS: bool = true;

// Bin (among all windows' bins) of light travelling along `direction`.
fn window_bin(window: Window, direction: vec3<f32>) -> u32 {
    let local_z = dot(direction, window.z);
    let cos2 = min(local_z * local_z, 1.0);
    var ring = window.first_ring + window.rings - 1u;
    while ring > window.first_ring && cos2 > ring_at(ring).cos2_low {
        ring -= 1u;
    }
    let found = ring_at(ring);
    var position = 0u;
    if found.bins > 1u {
        position = azimuth_bin(atan2(dot(direction, window.y), dot(direction, window.x)), found.bins);
    }
    return window.first_bin + found.first + position;
}

// The ring of a bin. All neighbours go round as often: one that left early got no numbers on SwiftShader.
fn ring_of_bin(first_ring: u32, ring_count: u32, bin: u32) -> Ring {
    var found = first_ring;
    for (var ring = first_ring + 1u; ring < first_ring + ring_count; ring++) {
        found = select(found, ring, ring_at(ring).first <= bin);
    }
    return ring_at(found);
}

// Direction of light through bin `bin` (counted within the window), uniform in projected solid
// angle.
fn window_bin_direction(window: Window, bin: u32, random: vec2<f32>) -> vec3<f32> {
    let r = ring_of_bin(window.first_ring, window.rings, bin);
    let cos2 = mix(r.cos2_low, r.cos2_high, random.x);
    let sine = sqrt(max(1.0 - cos2, 0.0));
    let across = sine * circle((f32(bin - r.first) + random.y - 0.5) / f32(r.bins));
    return normalize(window.x * across.x + window.y * across.y + window.z * sqrt(max(cos2, 0.0)));
}

// Projected solid angle of a bin, sr.
fn projected_solid_angle(first_ring: u32, ring_count: u32, bin: u32) -> f32 {
    let ring = ring_of_bin(first_ring, ring_count, bin);
    return PI * (ring.cos2_low - ring.cos2_high) / f32(ring.bins);
}

// Point on a window, uniform in area.
fn window_point(window: Window, random: vec2<f32>) -> vec3<f32> {
    var triangle = window.first_triangle;
    let last = window.first_triangle + window.triangles - 1u;
    var low = 0.0;
    while triangle < last && random.x >= window_corner(triangle, 0u).w {
        low = window_corner(triangle, 0u).w;
        triangle += 1u;
    }
    let high = window_corner(triangle, 0u).w;
    let u = clamp((random.x - low) / max(high - low, 1e-20), 0.0, 1.0);
    let root = sqrt(u);
    let a = window_corner(triangle, 0u).xyz;
    let b = window_corner(triangle, 1u).xyz;
    let c = window_corner(triangle, 2u).xyz;
    return a * (1.0 - root) + b * (root * (1.0 - random.y)) + c * (root * random.y);
}

// Solid angle of a triangle with corners a, b, c relative to the eye (van Oosterom and Strackee
// 1983).
fn triangle_solid_angle(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    let la = length(a);
    let lb = length(b);
    let lc = length(c);
    let numerator = abs(dot(a, cross(b, c)));
    let denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    return 2.0 * atan2(numerator, denominator);
}

// Largest solid angle that is sampled by area instead: the spherical formulas lose their digits.
const SMALL_SOLID_ANGLE: f32 = 0.01;

struct WindowSample {
    direction: vec3<f32>,
    distance: f32,
    // Solid angle that this sample stands for, sr; 0 if there is none.
    weight: f32,
    // Solid angle of all windows, blocked or not, sr.
    total: f32,
    window: u32,
}

// A direction from `eye` to one of the windows. Windows are chosen by the solid angle of their
// triangles, which are then sampled uniformly in solid angle (Arvo 1995).
fn sample_windows(eye: vec3<f32>, window_count: u32, random: vec2<f32>) -> WindowSample {
    var result = WindowSample(vec3<f32>(0.0), 0.0, 0.0, 0.0, 0u);
    var total = 0.0;
    for (var w = 0u; w < window_count; w++) {
        let window = window_at(w);
        // Only the side that gives light to the room counts.
        for (var t = window.first_triangle; t < window.first_triangle + window.triangles; t++) {
            let a = window_corner(t, 0u).xyz - eye;
            if dot(a, window.z) < 0.0 {
                total += triangle_solid_angle(a, window_corner(t, 1u).xyz - eye, window_corner(t, 2u).xyz - eye);
            }
        }
    }
    if !(total > 0.0) {
        return result;
    }
    result.total = total;
    let target_sum = random.x * total;
    var sum = 0.0;
    var chosen = NO_TRIANGLE;
    var share = 0.0;
    var omega = 0.0;
    for (var w = 0u; w < window_count; w++) {
        let window = window_at(w);
        for (var t = window.first_triangle; t < window.first_triangle + window.triangles; t++) {
            let a = window_corner(t, 0u).xyz - eye;
            if dot(a, window.z) < 0.0 && (chosen == NO_TRIANGLE || sum <= target_sum) {
                let angle = triangle_solid_angle(a, window_corner(t, 1u).xyz - eye, window_corner(t, 2u).xyz - eye);
                if angle > 0.0 {
                    chosen = t;
                    result.window = w;
                    omega = angle;
                    share = clamp((target_sum - sum) / angle, 0.0, 1.0);
                    sum += angle;
                }
            }
        }
    }
    let a = window_corner(chosen, 0u).xyz - eye;
    let b = window_corner(chosen, 1u).xyz - eye;
    let c = window_corner(chosen, 2u).xyz - eye;
    let normal = window_at(result.window).z;
    if omega < SMALL_SOLID_ANGLE {
        let root = sqrt(share);
        let to = a * (1.0 - root) + b * (root * (1.0 - random.y)) + c * (root * random.y);
        result.distance = length(to);
        result.direction = to / result.distance;
        let area = window_corner(chosen, 1u).w;
        // `omega / total` was the probability of this triangle.
        result.weight = area * abs(dot(result.direction, normal)) / (result.distance * result.distance) * (total / omega);
        return result;
    }
    let ua = normalize(a);
    let ub = normalize(b);
    let uc = normalize(c);
    let n_ab = normalize(cross(ua, ub));
    let n_ca = normalize(cross(uc, ua));
    let cos_alpha = clamp(-dot(n_ab, n_ca), -1.0, 1.0);
    let sin_alpha = max(length(cross(n_ab, n_ca)), 1e-7);
    let part = circle(share * omega / TAU);
    let s = part.y * cos_alpha - part.x * sin_alpha;
    let t = part.x * cos_alpha + part.y * sin_alpha;
    let p = t - cos_alpha;
    let q = s + sin_alpha * dot(ua, ub);
    let below = (q * s + p * t) * sin_alpha;
    var cos_b = select(((q * t - p * s) * cos_alpha - q) / below, 1.0, abs(below) < 1e-20);
    cos_b = clamp(cos_b, -1.0, 1.0);
    let towards_c = normalize(uc - dot(uc, ua) * ua);
    let c_new = cos_b * ua + sqrt(max(1.0 - cos_b * cos_b, 0.0)) * towards_c;
    let z = 1.0 - random.y * (1.0 - dot(c_new, ub));
    let across = c_new - dot(c_new, ub) * ub;
    let across_length = length(across);
    result.direction = ub;
    if across_length > 1e-7 {
        result.direction = normalize(z * ub + sqrt(max(1.0 - z * z, 0.0)) * (across / across_length));
    }
    result.distance = dot(a, normal) / dot(result.direction, normal);
    result.weight = total;
    return result;
}

// Distance at which a ray passes triangle `t` of a window whose normal is `z`; not above 0 if it does not.
fn distance_through(t: u32, z: vec3<f32>, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let a = window_corner(t, 0u).xyz - origin;
    let b = window_corner(t, 1u).xyz - origin;
    let c = window_corner(t, 2u).xyz - origin;
    // Volumes on the three sides of the ray (Plücker); all of one sign inside.
    let u = dot(direction, cross(b, c));
    let v = dot(direction, cross(c, a));
    let s = dot(direction, cross(a, b));
    let inside = (u >= 0.0 && v >= 0.0 && s >= 0.0) || (u <= 0.0 && v <= 0.0 && s <= 0.0);
    return select(-1.0, dot(a, z) / dot(direction, z), inside);
}

const NO_WINDOW: u32 = 0xffffffffu;

// A window that a ray leaves through.
struct Crossing {
    window: u32,
    distance: f32,
}

// The nearest of the first `count` windows that a ray leaves the room through before a distance.
fn crossed_window(origin: vec3<f32>, direction: vec3<f32>, most: f32, count: u32) -> Crossing {
    var found = Crossing(NO_WINDOW, most);
    for (var w = 0u; w < count; w++) {
        let window = window_at(w);
        if dot(direction, window.z) >= 0.0 {
            continue;
        }
        for (var t = window.first_triangle; t < window.first_triangle + window.triangles; t++) {
            let distance = distance_through(t, window.z, origin, direction);
            if distance > 0.0 && distance < found.distance {
                found = Crossing(w, distance);
            }
        }
    }
    return found;
}

// Whether a ray leaves the room through the polygon of one of the first `count` windows.
fn leaves_through_window(origin: vec3<f32>, direction: vec3<f32>, count: u32) -> bool {
    return crossed_window(origin, direction, FAR_AWAY, count).window != NO_WINDOW;
}

// Whether there are suns that could shine into a room's window from outside, seen from another one.
override MAY_ENTER: bool = true;

// Whether a ray enters a room from outside through the polygon of a window, which absorbs it.
fn enters_window(origin: vec3<f32>, direction: vec3<f32>) -> bool {
    if !MAY_ENTER {
        return false;
    }
    for (var w = 0u; w < scene_parts.window_count; w++) {
        let window = window_at(w);
        if dot(direction, window.z) <= 0.0 {
            continue;
        }
        for (var t = window.first_triangle; t < window.first_triangle + window.triangles; t++) {
            if distance_through(t, window.z, origin, direction) > 0.0 {
                return true;
            }
        }
    }
    return false;
}

// What part of light passes directly from `origin` along `direction` over `distance`: 0 where a
// surface is in the way, otherwise the transmittance of the panes passed.
fn direct_transmittance(origin: vec3<f32>, direction: vec3<f32>, distance: f32) -> vec3<f32> {
    return light_passing(origin, direction, distance, select(ANY, ANY_BUT_GLASS, HAS_GLASS));
}

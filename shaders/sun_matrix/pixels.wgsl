// Sun picture, first step: the surface behind each pixel that suns light, or the point of a pane of
// scattering data that it shows. Surfaces of the room, and the slats of shades; what stands outside
// belongs to other phases.

import package::generated::{
    PanePoint, PixelRay, Receiver, SunPixelParams, FAR_AWAY, FRAC_1_PI, MATERIAL_ABSORBER,
};
import package::shared::random::{sample_pair, hash_combine};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{scatter, largest, LOBE_NONE, LOBE_DIFFUSE};
import package::shared::window::{crossed_window, leaves_through_window, NO_WINDOW};
import package::shared::counters::{count_finished};
import package::shared::scene::{material_at};

const MOST_SPECULAR: u32 = 32u;

@group(0) @binding(6) var<uniform> params: SunPixelParams;
// [batch][pixel]
@group(0) @binding(7) var<storage, read> rays: array<PixelRay>;
// [batch][pixel]
@group(0) @binding(8) var<storage, read_write> receivers: array<Receiver>;
// Radiance of a receiver per irradiance, rgb: [batch][pixel]. Where the pixel shows a pane (w is 1),
// the share of the pane's radiance that it shows.
@group(0) @binding(9) var<storage, read_write> receiver_weights: array<vec4<f32>>;
// [batch][pixel]
@group(0) @binding(10) var<storage, read_write> facade: array<PanePoint>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.x;
    let batch = id.y;
    if pixel >= params.pixels || batch >= params.batches {
        return;
    }
    let cell = batch * params.pixels + pixel;
    let ray = rays[cell];
    let seed = hash_combine(params.seed, ray.number);
    // A receiver that no sun reaches, for rays that meet none.
    var receiver = Receiver(vec3<f32>(0.0, 0.0, 1e6), ray.number, vec3<f32>(0.0, 0.0, -1.0), 0u);
    var receiver_weight = vec4<f32>(0.0);
    var point = PanePoint(vec3<f32>(0.0), NO_WINDOW, vec3<f32>(0.0, 0.0, 1.0), ray.number);
    var weight = vec3<f32>(1.0);
    var origin = ray.origin;
    var direction = ray.direction;
    var farthest = ray.length;
    var outside = false;
    for (var segment = 0u; segment < MOST_SPECULAR; segment++) {
        let hit = closest_hit(origin, direction, farthest);
        if !(farthest > 0.0) {
            break;
        }
        if params.panes == 1u {
            let pane = crossed_window(origin, direction, select(hit.distance, farthest, hit.triangle == NO_TRIANGLE), params.window_count);
            if pane.window != NO_WINDOW {
                point = PanePoint(origin + direction * pane.distance, pane.window, -direction, ray.number);
                receiver_weight = vec4<f32>(weight, 1.0);
                break;
            }
        }
        if hit.triangle == NO_TRIANGLE {
            break;
        }
        farthest = FAR_AWAY;
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let material_index = triangle_material(hit.triangle);
        let material = material_at(material_index);
        let beside = leave_surface(hit, facing);
        // The window lies between where the ray began and where it ended.
        outside = outside || (leaves_through_window(origin, direction, params.window_count) && !leaves_through_window(beside, direction, params.window_count));
        let shade = material_index >= params.first_shade;
        if material.kind == MATERIAL_ABSORBER {
            break;
        }
        let choice = sample_pair(batch, segment * 2u, seed).x;
        let slope = sample_pair(batch, segment * 2u + 1u, seed);
        let event = scatter(material, direction, facing, front, choice, slope);
        weight *= event.weight;
        if event.lobe == LOBE_NONE || largest(weight) <= 0.0 {
            break;
        }
        let side = select(facing, -facing, event.transmitted);
        origin = leave_surface(hit, side);
        direction = event.direction;
        if event.lobe == LOBE_DIFFUSE {
            if shade || !outside {
                // Around slats light comes from everywhere, not through the window's polygon.
                receiver = Receiver(origin, ray.number, side, u32(shade));
                receiver_weight = vec4<f32>(weight * FRAC_1_PI, 0.0);
            }
            break;
        }
    }
    receivers[cell] = receiver;
    receiver_weights[cell] = receiver_weight;
    facade[cell] = point;
    count_finished(true);
}

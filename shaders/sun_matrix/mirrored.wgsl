// Light of suns and of their images in flat mirrors. An image is looked for where it stands, and counts where
// the mirrors met are those that make it.

import package::generated::{FAR_AWAY};
import package::shared::bvh::{closest_hit, leave_surface, triangle_material, triangle_normal, NO_TRIANGLE};
import package::shared::material::{largest, smooth_specular};
import package::sun_matrix::gates::{may_come_in};
import package::sun_matrix::sun::{is_clear, is_mirror, sun_transmittance};
import package::shared::window::{enters_window};
import package::shared::scene::{material_at};

// Whether the suns' images are looked for, not the suns themselves.
override MIRRORED: bool = false;

// Where a sun is looked for. The matrix of these columns takes a direction to the sun to that of its image.
fn image_of(direction: vec3<f32>, image: mat3x3<f32>) -> vec3<f32> {
    if !MIRRORED {
        return direction;
    }
    return direction.x * image[0] + direction.y * image[1] + direction.z * image[2];
}

// What part of the light arrives from there.
fn arriving(origin: vec3<f32>, direction: vec3<f32>, image: mat3x3<f32>, gate_count: u32, window_count: u32) -> vec3<f32> {
    if MIRRORED {
        return mirrored_transmittance(origin, direction, image, gate_count, window_count);
    }
    return sun_transmittance(origin, direction);
}

// Mirrors and panes that light of an image may meet.
const MOST_MET: u32 = 32u;
// Mirrors are taken for parallel within half of this.
const SAME_IMAGE: f32 = 1e-3;

// What part of the light of an image arrives. Light must meet mirrors on its way that, together, undo the
// image, and come in through an opening on one of its legs (as `may_come_in`).
fn mirrored_transmittance(origin: vec3<f32>, direction: vec3<f32>, image: mat3x3<f32>, gate_count: u32, window_count: u32) -> vec3<f32> {
    var result = vec3<f32>(1.0);
    var start = origin;
    var along = direction;
    var entered = false;
    var reflected = false;
    // The image, reflection by reflection taken back.
    var x = image[0];
    var y = image[1];
    var z = image[2];
    for (var met = 0u; met < MOST_MET; met++) {
        entered = entered || may_come_in(start, along, gate_count, window_count);
        let hit = closest_hit(start, along, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            let rest = abs(x - vec3<f32>(1.0, 0.0, 0.0)) + abs(y - vec3<f32>(0.0, 1.0, 0.0)) + abs(z - vec3<f32>(0.0, 0.0, 1.0));
            return select(vec3<f32>(0.0), result, entered && reflected && largest(rest) < SAME_IMAGE && !enters_window(start, along));
        }
        let material = material_at(triangle_material(hit.triangle));
        let normal = triangle_normal(hit.triangle);
        let cosine = dot(normal, along);
        let parts = smooth_specular(material, max(abs(cosine), 1e-6), cosine < 0.0);
        let behind = select(-normal, normal, cosine > 0.0);
        if is_mirror(material) {
            result *= parts[1];
            start = leave_surface(hit, -behind);
            along = normalize(along - 2.0 * cosine * normal);
            x -= 2.0 * dot(x, normal) * normal;
            y -= 2.0 * dot(y, normal) * normal;
            z -= 2.0 * dot(z, normal) * normal;
            reflected = true;
        } else if is_clear(material) {
            result *= parts[0];
            start = leave_surface(hit, behind);
        } else {
            return vec3<f32>(0.0);
        }
        if largest(result) <= 0.0 {
            return vec3<f32>(0.0);
        }
    }
    return vec3<f32>(0.0);
}

// Ways of light to images of the sun in flat mirrors, leg by leg.

import package::shared::bvh::{closest_hit, leave_surface, triangle_material, triangle_normal, NO_TRIANGLE, FAR_AWAY};
import package::shared::material::{materials, largest, smooth_specular};
import package::shared::sun::{is_clear, is_mirror};

// Mirrors and panes that light of an image may meet.
const MOST_MET: u32 = 32u;
// Mirrors are taken for parallel within half of this.
const SAME_IMAGE: f32 = 1e-3;

// A way that is followed from where it is seen.
struct MirroredWay {
    // The next leg.
    start: vec3<f32>,
    along: vec3<f32>,
    // What part of the light passes so far.
    passed: vec3<f32>,
    // Columns of the matrix that takes a direction to the sun to that of its image, reflection by
    // reflection taken back.
    x: vec3<f32>,
    y: vec3<f32>,
    z: vec3<f32>,
    reflected: bool,
    ended: bool,
    // Whether it ended in the sky, and the mirrors met are those that make the image.
    reached: bool,
}

fn mirrored_way(origin: vec3<f32>, direction: vec3<f32>, x: vec3<f32>, y: vec3<f32>, z: vec3<f32>) -> MirroredWay {
    return MirroredWay(origin, direction, vec3<f32>(1.0), x, y, z, false, false, false);
}

// The way after its next leg.
fn next_leg(before: MirroredWay) -> MirroredWay {
    var way = before;
    let hit = closest_hit(way.start, way.along, FAR_AWAY);
    if hit.triangle == NO_TRIANGLE {
        let rest = abs(way.x - vec3<f32>(1.0, 0.0, 0.0)) + abs(way.y - vec3<f32>(0.0, 1.0, 0.0)) + abs(way.z - vec3<f32>(0.0, 0.0, 1.0));
        way.reached = way.reflected && largest(rest) < SAME_IMAGE;
        way.ended = true;
        return way;
    }
    let material = materials[triangle_material(hit.triangle)];
    let normal = triangle_normal(hit.triangle);
    let cosine = dot(normal, way.along);
    let parts = smooth_specular(material, max(abs(cosine), 1e-6), cosine < 0.0);
    let behind = select(-normal, normal, cosine > 0.0);
    if is_mirror(material) {
        way.passed *= parts[1];
        way.start = leave_surface(hit, -behind);
        way.along = normalize(way.along - 2.0 * cosine * normal);
        way.x -= 2.0 * dot(way.x, normal) * normal;
        way.y -= 2.0 * dot(way.y, normal) * normal;
        way.z -= 2.0 * dot(way.z, normal) * normal;
        way.reflected = true;
    } else if is_clear(material) {
        way.passed *= parts[0];
        way.start = leave_surface(hit, behind);
    } else {
        way.passed = vec3<f32>(0.0);
    }
    way.ended = largest(way.passed) <= 0.0;
    return way;
}

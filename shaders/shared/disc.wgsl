// Discs in the sky.

import package::shared::circle::{circle};
import package::shared::frame::{tangent_frame};

// A direction to a disc around `centre`, uniform in solid angle; `chord` reaches from its centre to its rim on the unit
// sphere.
fn disc_direction(centre: vec3<f32>, chord: f32, random: vec2<f32>) -> vec3<f32> {
    if chord == 0.0 {
        return centre;
    }
    let from_centre = sqrt(random.x) * chord;
    let sine = from_centre * sqrt(max(1.0 - 0.25 * from_centre * from_centre, 0.0));
    let local = vec3<f32>(sine * circle(random.y), 1.0 - 0.5 * from_centre * from_centre);
    return normalize(tangent_frame(centre) * local);
}

// How surfaces answer to light: Radiance's plastic, metal, trans, glass and mirror.
//
// Light paths may be followed in either direction: every model here is reciprocal and none refracts.

import package::generated::{
    Material, FRESNEL_DECAY, FRESNEL_GRAZING, FRESNEL_THRESHOLD, MATERIAL_GLASS, MATERIAL_MIRROR,
    MATERIAL_SURFACE, SMOOTH_ROUGHNESS2,
};
import package::shared::circle::{circle};
import package::shared::frame::{tangent_frame};

const LOBE_NONE: u32 = 0u;
const LOBE_DIFFUSE: u32 = 1u;
const LOBE_SPECULAR: u32 = 2u;

struct Scatter {
    // LOBE_NONE: absorbed.
    lobe: u32,
    // Whether the path goes on on the other side of the surface.
    transmitted: bool,
    // Factor on the path's weight.
    weight: vec3<f32>,
    // Specular only; a diffuse direction is drawn by the caller when it needs one.
    direction: vec3<f32>,
}

fn largest(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

// Cosine-distributed direction around the unit vector n.
fn cosine_direction(n: vec3<f32>, random: vec2<f32>) -> vec3<f32> {
    let radius = sqrt(random.x);
    let local = vec3<f32>(radius * circle(random.y), sqrt(max(1.0 - random.x, 0.0)));
    return normalize(tangent_frame(n) * local);
}

// Transmittance and reflectance of a pane, all internal reflections included, both polarisations
// averaged (Radiance glass).
fn glass_pane(transmissivity: vec3<f32>, index: f32, cosine: f32) -> array<vec3<f32>, 2> {
    let inside = sqrt(max(1.0 - (1.0 - cosine * cosine) / (index * index), 0.0));
    let one_pass = pow(transmissivity, vec3<f32>(1.0 / inside));
    let s = (cosine - index * inside) / (cosine + index * inside);
    let p = (inside - index * cosine) / (inside + index * cosine);
    var transmitted = vec3<f32>(0.0);
    var reflected = vec3<f32>(0.0);
    for (var polarisation = 0u; polarisation < 2u; polarisation++) {
        let amplitude = select(p, s, polarisation == 0u);
        let r = amplitude * amplitude;
        let losses = 1.0 - r * r * one_pass * one_pass;
        transmitted += 0.5 * (1.0 - r) * (1.0 - r) * one_pass / losses;
        reflected += 0.5 * r * (1.0 + (1.0 - 2.0 * r) * one_pass * one_pass) / losses;
    }
    return array<vec3<f32>, 2>(transmitted, reflected);
}

// Whether a surface reflects and transmits as a mirror and a pane do.
fn is_smooth(material: Material) -> bool {
    return material.roughness * material.roughness <= SMOOTH_ROUGHNESS2;
}

// What smooth surfaces add to their specular reflection at this angle of incidence, as a share of
// the rest (Radiance's approximation to Fresnel). Vanishes at normal incidence: exp(-5.85) is
// subtracted.
fn smooth_fresnel(material: Material, cosine: f32) -> f32 {
    if is_smooth(material) && largest(material.specular) >= FRESNEL_THRESHOLD {
        return exp(-FRESNEL_DECAY * cosine) - FRESNEL_GRAZING;
    }
    return 0.0;
}

// Share of its diffuse reflectance and transmittance that a surface has at this angle of incidence.
fn diffuse_share(material: Material, cosine: f32) -> f32 {
    return 1.0 - smooth_fresnel(material, cosine);
}

// What a smooth surface lets through directly, and what it reflects as a mirror.
fn smooth_specular(material: Material, cosine: f32, front: bool) -> array<vec3<f32>, 2> {
    if material.kind == MATERIAL_GLASS {
        return glass_pane(material.specular, material.roughness, cosine);
    }
    if material.kind == MATERIAL_MIRROR {
        return array<vec3<f32>, 2>(vec3<f32>(0.0), select(vec3<f32>(0.0), material.specular, front));
    }
    if material.kind != MATERIAL_SURFACE {
        return array<vec3<f32>, 2>(vec3<f32>(0.0), vec3<f32>(0.0));
    }
    let fresnel = smooth_fresnel(material, cosine);
    return array<vec3<f32>, 2>(material.specular_transmitted * (1.0 - fresnel), material.specular + fresnel * (1.0 - material.specular));
}

// Draws what happens to light travelling along `incoming` at a surface with unit normal `facing`
// (on the side of arrival). `front` tells whether that is the front side.
fn scatter(material: Material, incoming: vec3<f32>, facing: vec3<f32>, front: bool, choice: f32, slope: vec2<f32>) -> Scatter {
    var result = Scatter(LOBE_NONE, false, vec3<f32>(0.0), incoming);
    let cosine = max(-dot(incoming, facing), 1e-6);
    let mirrored = incoming + 2.0 * cosine * facing;
    if material.kind == MATERIAL_MIRROR {
        if front {
            result = Scatter(LOBE_SPECULAR, false, material.specular, mirrored);
        }
        return result;
    }
    if material.kind == MATERIAL_GLASS {
        let pane = glass_pane(material.specular, material.roughness, cosine);
        let share = largest(pane[0]) / max(largest(pane[0]) + largest(pane[1]), 1e-20);
        if choice < share {
            result = Scatter(LOBE_SPECULAR, true, pane[0] / share, incoming);
        } else {
            result = Scatter(LOBE_SPECULAR, false, pane[1] / (1.0 - share), mirrored);
        }
        return result;
    }
    if material.kind != MATERIAL_SURFACE {
        return result;
    }
    let smooth_surface = is_smooth(material);
    let fresnel = smooth_fresnel(material, cosine);
    let specular = material.specular + fresnel * (1.0 - material.specular);
    let rest = 1.0 - fresnel;
    let diffuse = material.diffuse * rest;
    let diffuse_transmitted = material.diffuse_transmitted * rest;
    let specular_transmitted = material.specular_transmitted * rest;
    // Analog choice among four lobes, each in proportion to its strongest channel.
    let p_diffuse = largest(diffuse);
    let p_diffuse_transmitted = largest(diffuse_transmitted);
    let p_specular = largest(specular);
    let p_through = largest(specular_transmitted);
    let total = p_diffuse + p_diffuse_transmitted + p_specular + p_through;
    if total <= 0.0 {
        return result;
    }
    var pick = choice * total;
    if pick < p_diffuse {
        return Scatter(LOBE_DIFFUSE, false, diffuse * (total / p_diffuse), incoming);
    }
    pick -= p_diffuse;
    if pick < p_diffuse_transmitted {
        return Scatter(LOBE_DIFFUSE, true, diffuse_transmitted * (total / p_diffuse_transmitted), incoming);
    }
    pick -= p_diffuse_transmitted;
    if pick < p_specular {
        var direction = mirrored;
        if !smooth_surface {
            // Half vector by Ward's Gaussian of slopes.
            let tan2 = -material.roughness * material.roughness * log(max(1.0 - slope.x, 1e-12));
            let tan_h = sqrt(tan2);
            let half_vector = normalize(tangent_frame(facing) * vec3<f32>(tan_h * circle(slope.y), 1.0));
            direction = incoming - 2.0 * dot(incoming, half_vector) * half_vector;
            if dot(direction, facing) <= 0.0 {
                return result;
            }
        }
        return Scatter(LOBE_SPECULAR, false, specular * (total / p_specular), normalize(direction));
    }
    if p_through <= 0.0 {
        return result;
    }
    var direction = incoming;
    if !smooth_surface {
        // Gaussian spread around the through direction (Radiance trans).
        let spread = material.roughness * sqrt(-log(max(1.0 - slope.x, 1e-12)));
        let across = spread * circle(slope.y);
        let frame = tangent_frame(incoming);
        direction = normalize(incoming + frame[0] * across.x + frame[1] * across.y);
        if dot(direction, facing) >= 0.0 {
            return result;
        }
    }
    return Scatter(LOBE_SPECULAR, true, specular_transmitted * (total / max(p_through, 1e-20)), direction);
}

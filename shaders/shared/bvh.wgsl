// Rays against triangles: eight-wide compressed bounding volume hierarchy (Ylitie, Karras, Laine,
// HPG 2017) as built by the obvhs crate, and a triangle test without gaps along shared edges.
//
// A node is five quads of words: (origin xyz, exponents and inner mask), (first child, first triangle,
// child meta 0-3, 4-7), then per axis the quantised child limits (min 0-3, min 4-7, max 0-3, max 4-7).
// A triangle is three quads: corners, the first with the material index in w, the second with what
// lets light through directly: 1 for glass, 2 for smooth translucent surfaces, 0 for all others; the
// third with the number of its plane if it is a smooth surface, else 0.

import package::generated::{FAR_AWAY, MATERIAL_GLASS};
import package::shared::counters::{traversal_failed};
import package::shared::frame::{tangent_frame};
import package::shared::material::{glass_pane, smooth_fresnel};
import package::shared::scene::{material_at, node_quad, triangle_corner, triangle_quad};

const NO_TRIANGLE: u32 = 0xffffffffu;
const STACK_SIZE: u32 = 24u;

// What a traversal looks for: the nearest triangle, any triangle, any that is no glass, or any that
// lets no light through directly (glass and smooth translucent surfaces do).
const NEAREST: u32 = 0u;
const ANY: u32 = 1u;
const ANY_BUT_GLASS: u32 = 2u;
const ANY_BUT_CLEAR: u32 = 3u;

struct Hit {
    distance: f32,
    triangle: u32,
    // Barycentric coordinates of the second and third corner.
    barycentric: vec2<f32>,
}

struct TriangleHit {
    distance: f32,
    barycentric: vec2<f32>,
}

// Four times the area of the triangle of the ray and an edge, seen along the ray. Exactly opposite,
// in every bit, when the ends change places, also where a device fuses a product and a sum: which is
// why the same is said twice.
fn edge_area(to: vec3<f32>, start: vec3<f32>) -> f32 {
    return (to.x * start.y - to.y * start.x) - (start.x * to.y - start.y * to.x);
}

// Distance along the ray, or FAR_AWAY. `frame` holds two directions across the ray and its own.
// Every corner is first projected along the ray, to the same point for all triangles that share
// it; on which side of an edge the ray passes is then the same for both triangles at this edge, and
// no ray slips between them, nor past a corner (Woop, Benthin, Wald, JCGT 2013).
fn intersect_triangle(triangle: u32, origin: vec3<f32>, frame: mat3x3<f32>, nearest: f32) -> TriangleHit {
    let a = (triangle_corner(triangle, 0u).xyz - origin) * frame;
    let b = (triangle_corner(triangle, 1u).xyz - origin) * frame;
    let c = (triangle_corner(triangle, 2u).xyz - origin) * frame;
    let u = edge_area(c, b);
    let v = edge_area(a, c);
    let w = edge_area(b, a);
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let determinant = u + v + w;
    if !inside || determinant == 0.0 {
        return TriangleHit(FAR_AWAY, vec2<f32>(0.0));
    }
    let scale = 1.0 / determinant;
    // The shares of long or thin triangles are rounded to a place beside the ray, in the plane all the
    // same: from there along the plane to the ray. A ray that leaves a large plane at a low angle would
    // else meet it again.
    let beside = a * (u * scale) + b * (v * scale) + c * (w * scale);
    let normal = cross(b - a, c - a);
    let distance = beside.z + dot(normal.xy, beside.xy) / normal.z;
    if !(distance > 0.0 && distance < nearest) {
        return TriangleHit(FAR_AWAY, vec2<f32>(0.0));
    }
    return TriangleHit(distance, vec2<f32>(v * scale, w * scale));
}

fn bytes_to_f32(packed: u32) -> vec4<f32> {
    return vec4<f32>(unpack4xU8(packed));
}

// Bits of the children hit among four: inner nodes in the high byte in order of traversal,
// triangles in the low 24 bits.
fn hit_four(
    meta_bytes: u32, octant: u32,
    near_x: vec4<f32>, far_x: vec4<f32>, near_y: vec4<f32>, far_y: vec4<f32>, near_z: vec4<f32>, far_z: vec4<f32>,
    nearest: f32,
) -> u32 {
    let inner = ((meta_bytes & (meta_bytes << 1u)) & 0x10101010u) >> 4u;
    let inner_mask = inner * 0xffu;
    let shift = unpack4xU8((meta_bytes ^ (octant & inner_mask)) & 0x1f1f1f1fu);
    let bits = unpack4xU8((meta_bytes >> 5u) & 0x07070707u);
    let enter = max(max(near_x, near_y), max(near_z, vec4<f32>(0.0)));
    let leave = min(min(far_x, far_y), min(far_z, vec4<f32>(nearest)));
    let mask = select(vec4<u32>(0u), bits << shift, enter <= leave);
    return mask.x | mask.y | mask.z | mask.w;
}

fn intersect_node(node: u32, origin: vec3<f32>, inverse: vec3<f32>, octant: u32, nearest: f32, n0: vec4<u32>, n1: vec4<u32>) -> u32 {
    let n2 = node_quad(node, 2u);
    let n3 = node_quad(node, 3u);
    let n4 = node_quad(node, 4u);
    let exponents = n0.w;
    let cell = vec3<f32>(
        bitcast<f32>((exponents & 0xffu) << 23u),
        bitcast<f32>(((exponents >> 8u) & 0xffu) << 23u),
        bitcast<f32>(((exponents >> 16u) & 0xffu) << 23u),
    );
    let step = cell * inverse;
    let start = (bitcast<vec3<f32>>(n0.xyz) - origin) * inverse;
    let x = select(n2.xyzw, n2.zwxy, inverse.x < 0.0);
    let y = select(n3.xyzw, n3.zwxy, inverse.y < 0.0);
    let z = select(n4.xyzw, n4.zwxy, inverse.z < 0.0);
    let low = hit_four(
        n1.z, octant,
        bytes_to_f32(x.x) * step.x + start.x, bytes_to_f32(x.z) * step.x + start.x,
        bytes_to_f32(y.x) * step.y + start.y, bytes_to_f32(y.z) * step.y + start.y,
        bytes_to_f32(z.x) * step.z + start.z, bytes_to_f32(z.z) * step.z + start.z, nearest,
    );
    let high = hit_four(
        n1.w, octant,
        bytes_to_f32(x.y) * step.x + start.x, bytes_to_f32(x.w) * step.x + start.x,
        bytes_to_f32(y.y) * step.y + start.y, bytes_to_f32(y.w) * step.y + start.y,
        bytes_to_f32(z.y) * step.z + start.z, bytes_to_f32(z.w) * step.z + start.z, nearest,
    );
    return low | high;
}

// Inverse of a direction without zeros, so that slabs give no NaN.
fn safe_inverse(direction: vec3<f32>) -> vec3<f32> {
    let tiny = vec3<f32>(1e-20);
    let d = select(direction, select(-tiny, tiny, direction >= vec3<f32>(0.0)), abs(direction) < tiny);
    return 1.0 / d;
}

// Panes that one ray may pass; more are a wall.
const MOST_PASSED: u32 = 16u;
// Those that the last traversal passed.
var<private> panes_passed: array<u32, MOST_PASSED>;
var<private> panes_count: u32;

// The triangle that was `sought`, see NEAREST and its fellows.
fn traverse(origin: vec3<f32>, direction: vec3<f32>, farthest: f32, sought: u32) -> Hit {
    panes_count = 0u;
    // Kinds of panes from 1 to this one are let pass.
    let clearest = f32(sought) - 1.0;
    var hit = Hit(farthest, NO_TRIANGLE, vec2<f32>(0.0));
    let frame = tangent_frame(direction);
    let inverse = safe_inverse(direction);
    let octant = select(0x04040404u, 0u, inverse.x < 0.0) | select(0x02020202u, 0u, inverse.y < 0.0) | select(0x01010101u, 0u, inverse.z < 0.0);
    var stack: array<vec2<u32>, STACK_SIZE>;
    var stack_size = 0u;
    var nodes = vec2<u32>(0u, 0x80000000u);
    var finished = false;
    loop {
        var triangles = vec2<u32>(0u, 0u);
        if (nodes.y & 0xff000000u) != 0u {
            let child_bit = firstLeadingBit(nodes.y);
            let hits = nodes.y;
            nodes.y &= ~(1u << child_bit);
            if (nodes.y & 0xff000000u) != 0u {
                if stack_size == STACK_SIZE {
                    break;
                }
                stack[stack_size] = nodes;
                stack_size += 1u;
            }
            let slot = (child_bit - 24u) ^ (octant & 0xffu);
            let node = nodes.x + countOneBits(hits & ~(0xffffffffu << slot));
            let n0 = node_quad(node, 0u);
            let n1 = node_quad(node, 1u);
            let mask = intersect_node(node, origin, inverse, octant, hit.distance, n0, n1);
            nodes = vec2<u32>(n1.x, (mask & 0xff000000u) | (n0.w >> 24u));
            triangles = vec2<u32>(n1.y, mask & 0x00ffffffu);
        }
        while triangles.y != 0u {
            let bit = firstLeadingBit(triangles.y);
            triangles.y &= ~(1u << bit);
            let index = triangles.x + bit;
            let found = intersect_triangle(index, origin, frame, hit.distance);
            if found.distance < hit.distance {
                if sought >= ANY_BUT_GLASS {
                    let pane = triangle_corner(index, 1u).w;
                    if pane > 0.0 && pane <= clearest && panes_count < MOST_PASSED {
                        panes_passed[panes_count] = index;
                        panes_count += 1u;
                        continue;
                    }
                }
                hit = Hit(found.distance, index, found.barycentric);
                if sought != NEAREST {
                    triangles.y = 0u;
                }
            }
        }
        if sought != NEAREST && hit.triangle != NO_TRIANGLE {
            finished = true;
            break;
        }
        if (nodes.y & 0xff000000u) == 0u {
            if stack_size == 0u {
                finished = true;
                break;
            }
            stack_size -= 1u;
            nodes = stack[stack_size];
        }
    }
    if !finished {
        traversal_failed = true;
    }
    return hit;
}

// The nearest triangle within `farthest`.
fn closest_hit(origin: vec3<f32>, direction: vec3<f32>, farthest: f32) -> Hit {
    return traverse(origin, direction, farthest, NEAREST);
}

// What a pane lets through directly.
fn pane_transmittance(triangle: u32, slope: f32) -> vec3<f32> {
    let material = material_at(triangle_material(triangle));
    if material.kind == MATERIAL_GLASS {
        return glass_pane(material.specular, material.roughness, slope)[0];
    }
    return material.specular_transmitted * (1.0 - smooth_fresnel(material, slope));
}

// What part of light arrives directly: 0 where a surface is in the way, otherwise the
// transmittance of what it passes. `sought` is ANY, or what else than panes ends the ray.
fn light_passing(origin: vec3<f32>, direction: vec3<f32>, farthest: f32, sought: u32) -> vec3<f32> {
    if traverse(origin, direction, farthest, sought).triangle != NO_TRIANGLE {
        return vec3<f32>(0.0);
    }
    var result = vec3<f32>(1.0);
    if sought < ANY_BUT_GLASS {
        return result;
    }
    // Distances of the latest: two triangles of a pane met at the edge that they share are one.
    var met = vec4<f32>(FAR_AWAY);
    for (var i = 0u; i < panes_count; i++) {
        let triangle = panes_passed[i];
        let normal = triangle_normal(triangle);
        let cosine = dot(normal, direction);
        let slope = max(abs(cosine), 1e-6);
        let distance = dot(normal, triangle_corner(triangle, 0u).xyz - origin) / select(slope, -slope, cosine < 0.0);
        let margin = margin_at(origin + direction * distance) / slope;
        if !any(abs(met - distance) < vec4<f32>(margin)) {
            result *= pane_transmittance(triangle, slope);
            met = vec4<f32>(distance, met.xyz);
        }
    }
    return result;
}

// Unit normal of a triangle's front side.
fn triangle_normal(triangle: u32) -> vec3<f32> {
    let a = triangle_corner(triangle, 0u).xyz;
    let b = triangle_corner(triangle, 1u).xyz;
    let c = triangle_corner(triangle, 2u).xyz;
    return normalize(cross(b - a, c - a));
}

fn triangle_material(triangle: u32) -> u32 {
    return triangle_quad(triangle, 0u).w;
}

fn triangle_plane(triangle: u32) -> u32 {
    return triangle_quad(triangle, 2u).w;
}

// Largest coordinate, without its sign.
fn extent(p: vec3<f32>) -> f32 {
    return max(max(abs(p.x), abs(p.y)), abs(p.z));
}

// How far beside a surface near `point` a ray must start so that rounding cannot meet the surface
// again. Coordinates are in units of the window's size with the origin near it.
fn margin_at(point: vec3<f32>) -> f32 {
    return (extent(point) + 0.5) * 4e-6;
}

// A start beside a surface. `side` is the unit normal of the side on which the ray goes on.
fn offset_from_surface(point: vec3<f32>, side: vec3<f32>) -> vec3<f32> {
    return point + side * margin_at(point);
}

// The point of a hit, found from the corners: more exact than origin + distance · direction, but no
// more exact than these.
fn hit_point(hit: Hit) -> vec3<f32> {
    let a = triangle_corner(hit.triangle, 0u).xyz;
    let b = triangle_corner(hit.triangle, 1u).xyz;
    let c = triangle_corner(hit.triangle, 2u).xyz;
    return a + (b - a) * hit.barycentric.x + (c - a) * hit.barycentric.y;
}

// Where a ray goes on that has met a surface, on the side of the unit normal `side`. The point is
// found from the corners, more exact than origin + distance · direction, but no more exact than
// these; it is moved off the surface, and off the triangle's edges so that at a corner of the room
// it is not beyond the neighbour.
fn leave_surface(hit: Hit, side: vec3<f32>) -> vec3<f32> {
    let a = triangle_corner(hit.triangle, 0u).xyz;
    let b = triangle_corner(hit.triangle, 1u).xyz;
    let c = triangle_corner(hit.triangle, 2u).xyz;
    let margin = max(margin_at(hit_point(hit)), max(max(extent(a), extent(b)), extent(c)) * 1e-6);
    // A barycentric coordinate is the distance from an edge in units of the height over it.
    let edges = vec3<f32>(length(c - b), length(c - a), length(b - a));
    let least = min(edges * (margin / max(length(cross(b - a, c - a)), 1e-30)), vec3<f32>(0.1));
    let inside = max(vec3<f32>(1.0 - hit.barycentric.x - hit.barycentric.y, hit.barycentric), least);
    let shares = inside / (inside.x + inside.y + inside.z);
    return a + (b - a) * shares.y + (c - a) * shares.z + side * margin;
}

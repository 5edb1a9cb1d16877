// For tests: chains of rays inside a closed convex room around the origin, whose surfaces face inwards. A ray that
// meets nothing, or a surface from behind, has leaked.

import package::generated::{LeakCounts, LeakProbeParams, FAR_AWAY};
import package::shared::random::{hash_combine, hash_u32, unit_f32};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, NO_TRIANGLE};
import package::shared::material::{cosine_direction};
import package::shared::counters::{count_finished};
import package::shared::scene::{triangle_corner};

@group(0) @binding(6) var<uniform> params: LeakProbeParams;
@group(0) @binding(8) var<storage, read_write> leaks: LeakCounts;

var<private> state: u32;

fn next() -> f32 {
    state = hash_u32(state + 0x9e3779b9u);
    return unit_f32(state);
}

// A corner, a point of an edge or a point of a triangle's inside.
fn target_point(kind: u32) -> vec3<f32> {
    let triangle = min(u32(next() * f32(params.triangles)), params.triangles - 1u);
    let a = triangle_corner(triangle, 0u).xyz;
    let b = triangle_corner(triangle, 1u).xyz;
    let c = triangle_corner(triangle, 2u).xyz;
    if kind == 0u {
        return a;
    }
    let along = next();
    if kind == 1u {
        return a + (b - a) * along;
    }
    return a + ((b - a) + (c - b) * next()) * along;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let chain = id.y * groups.x * 64u + id.x;
    if chain >= params.chains {
        return;
    }
    state = hash_combine(params.seed, chain);
    // Between the origin, which is well inside the room, and a wall.
    var position = target_point(2u) * (0.9 * next());
    var facing = vec3<f32>(0.0, 0.0, 1.0);
    // Every other chain aims at corners and edges; the others go on as diffuse light does.
    let aimed = (chain & 1u) == 0u;
    var met = 0u;
    var ended = false;
    for (var ray = 0u; ray < params.rays_per_chain; ray++) {
        var direction = cosine_direction(facing, vec2<f32>(next(), next()));
        if aimed || ray == 0u {
            direction = normalize(target_point((chain >> 1u) % 3u) - position);
        }
        let hit = closest_hit(position, direction, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            atomicAdd(&leaks.missed, 1u);
            ended = true;
            break;
        }
        facing = triangle_normal(hit.triangle);
        // The normal of a long thin triangle is no more exact than this.
        if dot(facing, direction) > 1e-5 {
            atomicAdd(&leaks.from_behind, 1u);
            ended = true;
            break;
        }
        met += 1u;
        position = leave_surface(hit, facing);
    }
    atomicAdd(&leaks.met, met);
    count_finished(ended || met == params.rays_per_chain);
}

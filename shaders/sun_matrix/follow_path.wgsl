// Paths to the surfaces that scatter sunlight. Every vertex is kept; suns are connected to it later.

import package::generated::{Material, SunVertex, FAR_AWAY, MATERIAL_GLASS, MATERIAL_SURFACE};
import package::shared::random::{sample_pair};
import package::shared::bvh::{closest_hit, leave_surface, triangle_normal, triangle_material, NO_TRIANGLE};
import package::shared::material::{Scatter, scatter, smooth_specular, cosine_direction, largest, LOBE_NONE, LOBE_DIFFUSE, LOBE_SPECULAR};
import package::shared::scene::{material_at};

// Whether only those vertices are wanted that a path meets by way of a reflection in a pane: points
// of the surfaces stand for the others.
override REFLECTED_ONLY: bool = false;
// Share of the paths that panes then reflect, whatever their reflectance.
const REFLECTED: f32 = 0.75;
const MOST_SEGMENTS: u32 = 64u;

// [path][vertex], zero at the start.
@group(0) @binding(8) var<storage, read_write> vertices: array<SunVertex>;

// A path that has begun.
struct SunPath {
    position: vec3<f32>,
    // Chooses its random numbers.
    index: u32,
    direction: vec3<f32>,
    seed: u32,
    throughput: vec3<f32>,
    // Its place among the vertices, how many are kept and how many there is room for.
    first_slot: u32,
    kept: u32,
    most_vertices: u32,
    // Throughput below which roulette ends it.
    least: f32,
}

struct SunPathEnd {
    segments: u32,
    ended: bool,
    kept: u32,
}

fn scatters(material: Material) -> bool {
    if material.kind != MATERIAL_SURFACE {
        return false;
    }
    return largest(material.diffuse) + largest(material.diffuse_transmitted) + largest(material.specular) + largest(material.specular_transmitted) > 0.0;
}

fn follow_sun_path(path: SunPath) -> SunPathEnd {
    var position = path.position;
    var direction = path.direction;
    var throughput = path.throughput;
    var kept = path.kept;
    var wanted = !REFLECTED_ONLY;
    var segment = 0u;
    for (; segment < MOST_SEGMENTS; segment++) {
        let hit = closest_hit(position, direction, FAR_AWAY);
        if hit.triangle == NO_TRIANGLE {
            return SunPathEnd(segment, true, kept);
        }
        let normal = triangle_normal(hit.triangle);
        let front = dot(normal, direction) < 0.0;
        let facing = select(-normal, normal, front);
        let material_index = triangle_material(hit.triangle);
        let material = material_at(material_index);
        if wanted && scatters(material) {
            let beside = leave_surface(hit, facing);
            let behind = leave_surface(hit, -facing);
            vertices[path.first_slot + kept] = SunVertex(beside, material_index + 1u, facing, distance(beside, behind), direction, 0.0, throughput, 0.0);
            kept += 1u;
            if kept == path.most_vertices {
                return SunPathEnd(segment, true, kept);
            }
        }
        let choices = sample_pair(path.index, 1u + segment * 2u, path.seed);
        let slope = sample_pair(path.index, 2u + segment * 2u, path.seed);
        var event = scatter(material, direction, facing, front, choices.x, slope);
        if !wanted && material.kind == MATERIAL_GLASS {
            let pane = smooth_specular(material, max(-dot(direction, facing), 1e-6), front);
            let through = choices.x >= REFLECTED;
            let mirrored = direction - 2.0 * dot(direction, facing) * facing;
            event = Scatter(LOBE_SPECULAR, through, select(pane[1] / REFLECTED, pane[0] / (1.0 - REFLECTED), through), select(mirrored, direction, through));
        }
        throughput *= event.weight;
        if event.lobe == LOBE_NONE || largest(throughput) <= 0.0 || (event.lobe == LOBE_DIFFUSE && !wanted) {
            return SunPathEnd(segment, true, kept);
        }
        wanted = wanted || !event.transmitted;
        let side = select(facing, -facing, event.transmitted);
        direction = event.direction;
        if event.lobe == LOBE_DIFFUSE {
            direction = cosine_direction(side, slope);
        }
        let strength = largest(throughput);
        if strength < path.least && (!REFLECTED_ONLY || event.lobe == LOBE_DIFFUSE) {
            if choices.y * path.least >= strength {
                return SunPathEnd(segment, true, kept);
            }
            throughput *= path.least / strength;
        }
        position = leave_surface(hit, side);
    }
    // Some drivers end long loops silently.
    return SunPathEnd(segment, segment == MOST_SEGMENTS, kept);
}

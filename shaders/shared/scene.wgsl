// The scene and its tables, all in one buffer: devices bind few buffers at once. In quads of words: nodes of the
// hierarchy, five each; then triangles, three each; materials, windows and rings; the windows' triangles, three each.

import package::generated::{Material, Ring, SceneParts, Window, material_of, ring_of, window_of};

@group(0) @binding(0) var<storage, read> scene_words: array<vec4<u32>>;
@group(0) @binding(1) var<uniform> scene_parts: SceneParts;

fn node_quad(node: u32, quad: u32) -> vec4<u32> {
    return scene_words[node * 5u + quad];
}

fn triangle_quad(triangle: u32, corner: u32) -> vec4<u32> {
    return scene_words[scene_parts.triangles + triangle * 3u + corner];
}

// A corner of a triangle, see `shared/bvh.wgsl`.
fn triangle_corner(triangle: u32, corner: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(triangle_quad(triangle, corner));
}

fn material_at(index: u32) -> Material {
    let at = scene_parts.materials + index * 4u;
    return material_of(scene_words[at], scene_words[at + 1u], scene_words[at + 2u], scene_words[at + 3u]);
}

fn window_at(index: u32) -> Window {
    let at = scene_parts.windows + index * 4u;
    return window_of(scene_words[at], scene_words[at + 1u], scene_words[at + 2u], scene_words[at + 3u]);
}

fn ring_at(index: u32) -> Ring {
    return ring_of(scene_words[scene_parts.rings + index]);
}

// A corner of a window's triangle. The first one's w is the upper limit of the triangle's share of its window's
// area, the second's w its area.
fn window_corner(triangle: u32, corner: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(scene_words[scene_parts.window_triangles + triangle * 3u + corner]);
}

// For tests: what each ray meets first.

import package::generated::{FAR_AWAY, Ray, RayAnswer};
import package::shared::bvh::{closest_hit, traverse, ANY};
import package::shared::counters::{count_finished};

@group(0) @binding(6) var<storage, read> rays: array<Ray>;
@group(0) @binding(8) var<storage, read_write> answers: array<RayAnswer>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) {
        return;
    }
    let ray = rays[id.x];
    let hit = closest_hit(ray.origin, ray.direction, FAR_AWAY);
    let any = traverse(ray.origin, ray.direction, FAR_AWAY, ANY);
    answers[id.x] = RayAnswer(hit.distance, hit.triangle, hit.barycentric, u32(any.distance < FAR_AWAY), 0u);
    count_finished(true);
}

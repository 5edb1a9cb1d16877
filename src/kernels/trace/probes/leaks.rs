//! Closed rooms let no ray out.

use super::{LeakCounts, LeakProbeParams, run};
use crate::bins::KlemsBasis;
use crate::gpu::Device;
use crate::kernels::trace::rooms::{Builder, window};
use crate::kernels::trace::{TraceTables, WindowSurfaces};
use crate::scene::{MaterialIndex, Scene, Triangle};
use glam::{DMat3, DVec3};

const RAYS_PER_CHAIN: u32 = 8;
/// Chains per dispatch.
const CHAINS: u32 = 1 << 17;

/// A convex room as a list of inward-facing triangles, in units of a window of unit size.
fn tables_of(mut scene: Scene, turn: DMat3) -> TraceTables {
    for p in scene.triangles.iter_mut().flat_map(|t| &mut t.vertices) {
        *p = turn * *p;
    }
    let w = window([[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]], DVec3::Z, DVec3::Y, KlemsBasis::Quarter);
    TraceTables::new(&scene, &[w], WindowSurfaces::Open).unwrap()
}

/// Cuts every triangle into four, corners pushed out to the sphere of this radius if given.
fn refined(scene: &Scene, radius: Option<f64>) -> Scene {
    let place = |p: DVec3| radius.map_or(p, |r| p.normalize() * r);
    let mut fine = Scene { materials: scene.materials.clone(), ..Scene::default() };
    for t in &scene.triangles {
        let [a, b, c] = t.vertices.map(place);
        let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0].map(place);
        for vertices in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            fine.triangles.push(Triangle { vertices, ..*t });
        }
    }
    fine
}

fn box_room(low: [f64; 3], high: [f64; 3]) -> Scene {
    let mut b = Builder::default();
    let wall = b.grey(0.5);
    b.room(low, high, wall, &[]);
    let _: MaterialIndex = wall;
    b.scene
}

/// A refined octahedron is convex; a refined cube is not: its sides are cut along diagonals, some of
/// which stand out into the room, and a ray aimed at such an edge may meet either side of it.
fn octahedron() -> Scene {
    let mut b = Builder::default();
    let material = b.grey(0.5);
    for k in 0..8 {
        let sign = |bit: i32| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let [x, y, z] = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
        let inwards = (y - x).cross(z - x).dot(x + y + z) < 0.0;
        b.scene.triangles.push(Triangle { vertices: if inwards { [x, y, z] } else { [x, z, y] }, material, surface: 0 });
    }
    b.scene
}

/// Rays traced without a leak in all rooms together, as many as asked for.
fn assert_tight(device: &Device, rays: u64) {
    // Inward-facing faces first: the corners of `Builder::room` run so.
    let oblique = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(0.7) * DMat3::from_rotation_y(1.1);
    let sphere = (0..4).fold(octahedron(), |s, _| refined(&s, Some(3.0)));
    let rooms = [
        ("a box along the axes", tables_of(box_room([-2.0, -3.0, -1.2], [2.0, 3.0, 1.5]), DMat3::IDENTITY)),
        ("an oblique box", tables_of(box_room([-2.1, -3.3, -1.2], [2.2, 3.1, 1.5]), oblique)),
        (
            "an oblique box of many triangles",
            tables_of((0..4).fold(box_room([-2.0, -3.0, -1.2], [2.0, 3.0, 1.5]), |s, _| refined(&s, None)), oblique),
        ),
        ("an oblique corridor", tables_of(box_room([-30.0, -0.7, -0.9], [28.0, 0.8, 1.1]), oblique)),
        ("a sphere", tables_of(sphere, oblique)),
    ];
    let dispatches = rays.div_ceil(u64::from(CHAINS * RAYS_PER_CHAIN) * rooms.len() as u64);
    let mut leaks = Vec::new();
    for (what, tables) in &rooms {
        let scene = tables.upload(device).unwrap();
        let counts = device.zeros::<LeakCounts>("leaks", 1).unwrap();
        let mut total = [0u64; 3];
        for seed in 0..dispatches {
            let params = LeakProbeParams {
                seed: seed as u32,
                chains: CHAINS,
                rays_per_chain: RAYS_PER_CHAIN,
                triangles: tables.triangles.len() as u32,
            };
            let params = device.uniform("params", &params).unwrap();
            device.write(&counts, &[LeakCounts::default()]).unwrap();
            run(
                device,
                &super::LEAKS,
                Some(&scene),
                &[("params", &params), ("leaks", &counts)],
                [CHAINS / 64, 1, 1],
                Some(u64::from(CHAINS)),
            );
            let found = device.read::<LeakCounts>(&counts).unwrap()[0];
            for (sum, n) in total.iter_mut().zip([found.missed, found.from_behind, found.met]) {
                *sum += u64::from(n);
            }
        }
        println!(
            "{what}: {} triangles, {} rays, {} got out, {} met a surface from behind",
            tables.triangles.len(),
            total[2],
            total[0],
            total[1]
        );
        if total[0] + total[1] > 0 {
            leaks.push(format!("{what}: {} got out, {} met a surface from behind, of {}", total[0], total[1], total[2]));
        }
    }
    assert!(leaks.is_empty(), "{}", leaks.join("\n"));
}

#[test]
fn closed_rooms_leak_no_ray() {
    let Some(device) = Device::for_tests("watertightness") else { return };
    // 10⁷ unless told: LUCARNE_LEAK_RAYS=1e8 is the number promised.
    let rays = std::env::var("LUCARNE_LEAK_RAYS").ok().and_then(|v| v.parse::<f64>().ok()).unwrap_or(1e7);
    assert_tight(&device, rays as u64);
}

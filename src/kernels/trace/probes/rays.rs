//! Rays against triangles: traversal and intersection against brute force in f64.

use super::{Ray, RayAnswer, run};
use crate::bins::KlemsBasis;
use crate::bvh::Bvh;
use crate::gpu::Device;
use crate::kernels::trace::reference::Random;
use crate::kernels::trace::rooms::{Builder, window};
use crate::kernels::trace::{TraceTables, WindowSurfaces};
use crate::scene::Triangle;
use glam::DVec3;

/// What a ray has to do with a triangle.
struct Relation {
    /// Where it meets the plane.
    distance: f64,
    /// How far inside the triangle it passes, seen along the ray; negative outside.
    clearance: f64,
    /// Rounding that f32 may add to `distance`.
    tolerance: f64,
}

/// Möller and Trumbore 1997, in f64. `None` if the ray runs along the plane.
fn relation(t: &[DVec3; 3], origin: DVec3, direction: DVec3) -> Option<Relation> {
    let (e1, e2) = (t[1] - t[0], t[2] - t[0]);
    let p = direction.cross(e2);
    let determinant = e1.dot(p);
    let area2 = e1.cross(e2).length();
    let cosine = determinant.abs() / area2;
    if cosine < 1e-5 {
        return None;
    }
    let s = origin - t[0];
    let q = s.cross(e1);
    let (u, v) = (s.dot(p) / determinant, direction.dot(q) / determinant);
    // Each barycentric coordinate times the height over its edge, foreshortened.
    let height = |edge: DVec3| area2 / edge.length() * cosine;
    let clearance = (u * height(e2)).min(v * height(e1)).min((1.0 - u - v) * height(t[2] - t[1]));
    let size = t.iter().map(|p| (*p - origin).length()).fold(origin.length(), f64::max);
    let thinness = height(e1).min(height(e2)).min(height(t[2] - t[1]));
    // Corners relative to the origin carry 6e-8 of `size`; slanted and thin triangles magnify it.
    Some(Relation { distance: e2.dot(q) / determinant, clearance, tolerance: 2e-6 * size / cosine * (1.0 + size / thinness * 1e-2) })
}

/// Checks every ray of a mesh. Rays that pass within rounding of an edge may go either way; the
/// number of these is returned.
fn check(device: &Device, what: &str, exact: &[[DVec3; 3]], tables: &TraceTables, rays: &[Ray]) {
    let order = Bvh::build(&tables.triangles).order;
    let scene = tables.upload(device).unwrap();
    let questions = device.upload("rays", rays).unwrap();
    let answers = device.upload("answers", &vec![RayAnswer { distance: f32::NAN, ..RayAnswer::default() }; rays.len()]).unwrap();
    let groups = [(rays.len() as u32).div_ceil(64), 1, 1];
    run(device, &super::RAYS, Some(&scene), &[("rays", &questions), ("answers", &answers)], groups, Some(rays.len() as u64));
    let (mut hits, mut doubtful) = (0, 0);
    for (ray, answer) in rays.iter().zip(device.read::<RayAnswer>(&answers).unwrap()) {
        let [origin, direction] = [ray.origin, ray.direction].map(|v| glam::Vec3::from_array(v).as_dvec3());
        let near = 3e-6 * (1.0 + origin.length());
        let sure: Vec<(usize, Relation)> = exact
            .iter()
            .enumerate()
            .filter_map(|(i, t)| relation(t, origin, direction).map(|r| (i, r)))
            .filter(|(_, r)| r.clearance > -near && r.distance > -r.tolerance)
            .collect();
        // The nearest of those that no rounding can miss.
        let nearest = sure
            .iter()
            .filter(|(_, r)| r.clearance > near && r.distance > r.tolerance)
            .map(|(_, r)| r.distance + r.tolerance)
            .fold(f64::INFINITY, f64::min);
        assert_eq!(answer.blocked == 1, answer.triangle != u32::MAX, "{what}: any hit and closest hit differ: {ray:?} {answer:?}");
        if answer.triangle == u32::MAX {
            assert!(nearest == f64::INFINITY, "{what}: {ray:?} missed a triangle at {nearest}");
        } else {
            hits += 1;
            let hit = order[answer.triangle as usize] as usize;
            let Some((_, r)) = sure.iter().find(|(i, _)| *i == hit) else {
                panic!("{what}: {ray:?} met triangle {hit}, which is elsewhere: {answer:?}");
            };
            let distance = f64::from(answer.distance);
            assert!((distance - r.distance).abs() < r.tolerance, "{what}: {ray:?} at {distance}, not {} ± {}", r.distance, r.tolerance);
            assert!(distance < nearest + r.tolerance, "{what}: {ray:?} passed through a triangle at {nearest}");
            let [a, b, c] = exact[hit];
            let [v, w] = answer.barycentric.map(f64::from);
            let point = a + (b - a) * v + (c - a) * w;
            let off = (point - origin).cross(direction).length();
            assert!(off < r.tolerance, "{what}: {ray:?}: the point is {off} beside the ray");
        }
        doubtful += u32::from(sure.iter().any(|(_, r)| r.clearance.abs() <= near));
    }
    println!("{what}: {} rays, {hits} hits, {doubtful} passed within rounding of an edge", rays.len());
    assert!(hits * 10 > rays.len() && (doubtful as usize) < rays.len() / 10);
}

fn direction(random: &mut Random) -> DVec3 {
    let (z, phi) = (2.0 * random.next() - 1.0, std::f64::consts::TAU * random.next());
    DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z)
}

fn point(random: &mut Random) -> DVec3 {
    DVec3::new(random.next(), random.next(), random.next()) * 2.0 - 1.0
}

/// Triangles in the tracer's units, around a window of unit size at the origin.
fn tables_of(triangles: &[[DVec3; 3]], origin: DVec3, scale: f64) -> TraceTables {
    let mut b = Builder::default();
    let material = b.grey(0.5);
    b.scene.triangles = triangles.iter().map(|&t| Triangle { vertices: t.map(|p| origin + p * scale), material, surface: 0 }).collect();
    let corners = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]];
    let w = window(corners.map(|p| (origin + DVec3::from_array(p) * scale).to_array()), DVec3::Z, DVec3::Y, KlemsBasis::Quarter);
    TraceTables::new(&b.scene, &[w], WindowSurfaces::Open).unwrap()
}

fn rays(random: &mut Random, n: usize, spread: f64) -> Vec<Ray> {
    (0..n)
        .map(|i| {
            let mut d = direction(random);
            if i % 8 == 0 {
                // Along an axis or nearly so.
                d = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::new(1.0, 1e-7, 0.0)][i / 8 % 4];
            }
            let origin = point(random) * spread;
            Ray { origin: origin.as_vec3().to_array(), direction: d.normalize().as_vec3().to_array(), ..Ray::default() }
        })
        .collect()
}

#[test]
fn rays_meet_the_nearest_triangle_of_random_meshes() {
    let Some(device) = Device::for_tests("rays and triangles") else { return };
    let mut random = Random(3);
    let compact: Vec<[DVec3; 3]> = (0..300)
        .map(|_| {
            let p = point(&mut random);
            [p, p + point(&mut random) * 0.3, p + point(&mut random) * 0.3]
        })
        .collect();
    // Slats, wires and large walls, one of them cut into a fan of slivers.
    let mut long: Vec<[DVec3; 3]> = (0..200)
        .map(|i| {
            let (p, along) = (point(&mut random), direction(&mut random));
            let across = direction(&mut random).cross(along).normalize();
            let (length, width) = if i % 2 == 0 { (4.0, 0.02) } else { (20.0, 0.002) };
            [p - along * length, p + along * length, p + across * width]
        })
        .collect();
    for k in 0..64 {
        let at = |k: i32| DVec3::new(-3.0, 6.0 * (f64::from(k) / 64.0 - 0.5), 3.0);
        long.push([DVec3::new(-3.0, 0.0, -3.0), at(k), at(k + 1)]);
    }
    for (what, mesh, spread) in [("compact", &compact, 1.5), ("long and thin", &long, 2.5)] {
        let tables = tables_of(mesh, DVec3::ZERO, 1.0);
        // The very triangles the device has.
        let exact: Vec<[DVec3; 3]> = tables.triangles.iter().map(|t| t.map(|p| p.as_dvec3())).collect();
        check(&device, what, &exact, &tables, &rays(&mut random, 8192, spread));
    }
}

#[test]
fn survey_coordinates_and_unusual_units_lose_nothing() {
    let Some(device) = Device::for_tests("survey coordinates") else { return };
    let mut random = Random(4);
    let mesh: Vec<[DVec3; 3]> = (0..200)
        .map(|_| {
            let p = point(&mut random);
            [p, p + point(&mut random) * 0.3, p + point(&mut random) * 0.3]
        })
        .collect();
    for (what, origin, scale) in [
        ("kilometres from the origin", DVec3::new(683_241.37, 4_506_117.81, 131.2), 1.3),
        ("a millimetre", DVec3::new(0.1, 0.0, 0.0), 1e-3),
        ("a thousand kilometres", DVec3::ZERO, 1e6),
    ] {
        let tables = tables_of(&mesh, origin, scale);
        let n = tables.normalization;
        let exact: Vec<[DVec3; 3]> = mesh.iter().map(|t| t.map(|p| (origin + p * scale - n.origin) * n.scale)).collect();
        check(&device, what, &exact, &tables, &rays(&mut random, 4096, 1.5));
    }
}

//! f64 reference of the sun matrix: every triangle is met, the disc is covered by a dense spiral, the
//! scattered part follows from its definition by plain sampling.

use super::Sun;
use crate::bsdf::evaluate::Scattering;
use crate::kernels::trace::reference::intersect;
use crate::kernels::trace::reference::{Estimate, Random, glass_pane};
use crate::kernels::trace::{FRESNEL_THRESHOLD, smooth_fresnel};
use crate::scene::points::Sensor;
use crate::scene::{MaterialKind, Scene, Window};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Share of light that passes every surface in its way.
pub fn transmittance(scene: &Scene, origin: DVec3, direction: DVec3) -> [f64; 3] {
    let mut passed = [1.0; 3];
    for t in &scene.triangles {
        if intersect(&t.vertices, origin, direction).is_none() {
            continue;
        }
        let [a, b, c] = t.vertices;
        let cosine = (b - a).cross(c - a).normalize().dot(direction).abs();
        let through = match scene.materials[t.material.0 as usize].kind {
            MaterialKind::Glass { transmissivity, refraction_index } => glass_pane(transmissivity, refraction_index, cosine).0,
            MaterialKind::Trans { color, specularity, roughness: 0.0, transmissivity, transmitted_specularity } => {
                let fresnel = if specularity >= FRESNEL_THRESHOLD { smooth_fresnel(cosine) } else { 0.0 };
                color.map(|c| c * transmissivity * (1.0 - specularity) * transmitted_specularity * (1.0 - fresnel))
            }
            MaterialKind::Lobes(l) if l.roughness == 0.0 => {
                let fresnel = if l.specular.iter().any(|s| *s >= FRESNEL_THRESHOLD) { smooth_fresnel(cosine) } else { 0.0 };
                l.specular_transmitted.map(|c| c * (1.0 - fresnel))
            }
            MaterialKind::Void => [1.0; 3],
            _ => [0.0; 3],
        };
        for (p, t) in passed.iter_mut().zip(through) {
            *p *= t;
        }
    }
    passed
}

/// Whether a window absorbs light on its way: one of `windows` that it enters from outside, or any other one
/// of the scene.
fn is_absorbed(scene: &Scene, windows: &[Window], origin: DVec3, direction: DVec3) -> bool {
    let meets = |w: &Window| w.triangles.iter().any(|t| intersect(t, origin, direction).is_some());
    let mut others = scene.windows.iter().filter(|w| !windows.iter().any(|own| own.is_in_place_of(w)));
    windows.iter().any(|w| direction.dot(w.frame.z) > 0.0 && meets(w)) || others.any(meets)
}

fn leaves(windows: &[Window], origin: DVec3, direction: DVec3) -> bool {
    windows.is_empty()
        || windows.iter().any(|w| direction.dot(w.frame.z) < 0.0 && w.triangles.iter().any(|t| intersect(t, origin, direction).is_some()))
}

/// Points of a sun's disc, evenly spread (golden spiral).
pub fn disc(sun: &Sun, points: usize) -> Vec<DVec3> {
    let x = sun.direction.any_orthonormal_vector();
    let y = sun.direction.cross(x);
    (0..points)
        .map(|i| {
            let radius = sun.radius * ((i as f64 + 0.5) / points as f64).sqrt();
            let phi = TAU * 0.618_033_988_749_895 * i as f64;
            (sun.direction + (x * phi.cos() + y * phi.sin()) * radius.tan()).normalize()
        })
        .collect()
}

/// Direct coefficient of one sun, sr.
pub fn direct(scene: &Scene, windows: &[Window], position: DVec3, normal: DVec3, sun: &Sun, points: usize) -> [f64; 3] {
    let normal = normal.normalize();
    let mut sum = [0.0; 3];
    for direction in disc(sun, points) {
        let cosine = direction.dot(normal);
        if cosine > 0.0 && leaves(windows, position, direction) && !is_absorbed(scene, windows, position, direction) {
            let passed = transmittance(scene, position, direction);
            for (s, p) in sum.iter_mut().zip(passed) {
                *s += p * cosine * sun.solid_angle() / points as f64;
            }
        }
    }
    sum
}

/// Whether a surface lies on a ray before a distance.
pub(crate) fn is_blocked(scene: &Scene, from: DVec3, direction: DVec3, most: f64) -> bool {
    scene.triangles.iter().any(|t| intersect(&t.vertices, from, direction).is_some_and(|d| d > 1e-7 && d < most))
}

/// Coefficient of a sun through a pane that scatters once, sr: a fine grid over the window of the pane's room (`n`
/// columns) and the sun's disc.
pub(crate) fn through_pane(scene: &Scene, w: &Window, s: &Scattering, sensor: &Sensor, sun: &Sun, n: usize) -> f64 {
    let normal = sensor.direction.normalize();
    let mut random = Random(3);
    let mut sum = 0.0;
    for k in 0..n * n / 2 {
        let (u, v) = (((k % n) as f64 + random.next()) / n as f64, ((k / n) as f64 + random.next()) / (n / 2) as f64);
        let x = DVec3::new(-1.0 + 2.0 * u, 0.0, 1.0 + v);
        let (radius, phi) = (sun.chord() * random.next().sqrt(), TAU * random.next());
        let a = sun.direction.any_orthonormal_vector();
        let towards = (sun.direction + (a * phi.cos() + sun.direction.cross(a) * phi.sin()) * radius).normalize();
        let (incident, to) = (-w.frame.to_local(towards), sensor.position - x);
        let (distance, direction) = (to.length(), to.normalize());
        let outgoing = w.frame.to_local(direction);
        let cosine = -direction.dot(normal);
        if incident.z <= 0.0 || outgoing.z <= 0.0 || cosine <= 0.0 {
            continue;
        }
        if is_blocked(scene, x, towards, f64::INFINITY) || is_blocked(scene, x, direction, distance) {
            continue;
        }
        sum += s.evaluate(outgoing, incident) * incident.z * sun.solid_angle() * outgoing.z * cosine / (distance * distance);
    }
    sum * w.area() / (n * n / 2) as f64
}

/// A point of the windows, uniform in area; the normal there, and the area of all.
fn point_on(windows: &[Window], random: &mut Random) -> (DVec3, DVec3, f64) {
    let all: Vec<(&[DVec3; 3], DVec3)> = windows.iter().flat_map(|w| w.triangles.iter().map(|t| (t, w.frame.z))).collect();
    let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0;
    let total: f64 = all.iter().map(|(t, _)| area(t)).sum();
    let mut pick = random.next() * total;
    let mut chosen = all[all.len() - 1];
    for candidate in &all {
        if pick < area(candidate.0) {
            chosen = *candidate;
            break;
        }
        pick -= area(candidate.0);
    }
    let (u, v) = (random.next().sqrt(), random.next());
    let [a, b, c] = chosen.0;
    (*a * (1.0 - u) + *b * (u * (1.0 - v)) + *c * (u * v), chosen.1, total)
}

/// Scattered coefficient of one sun by diffuse surfaces, sr: paths from the receiver through points of
/// the windows.
#[allow(clippy::too_many_arguments, reason = "a definition, spelled out")]
pub fn scattered(
    scene: &Scene,
    windows: &[Window],
    position: DVec3,
    normal: DVec3,
    sun: &Sun,
    bounces: u32,
    samples: usize,
    seed: u64,
) -> Estimate {
    let mut estimate = Estimate::default();
    let mut random = Random(seed);
    for _ in 0..samples {
        let (mut origin, mut facing) = (position, normal.normalize());
        let mut weight = 0.0;
        let mut value = 0.0;
        for bounce in 0..bounces {
            let direction;
            if bounce == 0 {
                // Irradiance through the window: an integral over its area.
                let (point, inward, area) = point_on(windows, &mut random);
                let to = point - origin;
                direction = to.normalize();
                let cosines = direction.dot(facing).max(0.0) * (-direction.dot(inward)).max(0.0);
                weight = cosines * area / to.length_squared();
            } else {
                let (r2, phi) = (random.next(), TAU * random.next());
                let x = facing.any_orthonormal_vector();
                let y = facing.cross(x);
                direction = (x * (r2.sqrt() * phi.cos()) + y * (r2.sqrt() * phi.sin()) + facing * (1.0 - r2).sqrt()).normalize();
            }
            if weight <= 0.0 {
                break;
            }
            let mut nearest = (f64::INFINITY, None);
            for t in &scene.triangles {
                if let Some(distance) = intersect(&t.vertices, origin, direction).filter(|d| *d < nearest.0) {
                    nearest = (distance, Some(t));
                }
            }
            let (distance, Some(t)) = nearest else { break };
            let MaterialKind::Plastic { color, specularity: 0.0, .. } = scene.materials[t.material.0 as usize].kind else { break };
            let [a, b, c] = t.vertices;
            let n = (b - a).cross(c - a).normalize();
            facing = if n.dot(direction) < 0.0 { n } else { -n };
            origin += direction * distance + facing * 1e-6;
            weight *= color[0];
            let towards = disc(sun, 64)[(random.next() * 64.0) as usize];
            let cosine = towards.dot(facing);
            if cosine > 0.0 && !is_absorbed(scene, windows, origin, towards) {
                value += weight / PI * cosine * sun.solid_angle() * transmittance(scene, origin, towards)[0];
            }
        }
        estimate.add(value);
    }
    estimate
}

/// Coefficient of a sun that flat mirrors throw to a receiver, sr: from its definition, over the area of
/// the mirrors. Each point of a grid of this pitch is looked at; the way goes on by reflections, and
/// counts if it ends in the sun's disc.
pub fn mirrored(scene: &Scene, position: DVec3, normal: DVec3, sun: &Sun, pitch: f64) -> f64 {
    let reflectance = |t: &crate::scene::Triangle| match scene.materials[t.material.0 as usize].kind {
        MaterialKind::Mirror { color } => color[0],
        _ => 0.0,
    };
    let nearest = |origin: DVec3, direction: DVec3| {
        let hits = scene.triangles.iter().filter_map(|t| Some((intersect(&t.vertices, origin, direction)?, t)));
        hits.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let follow = |mut origin: DVec3, mut direction: DVec3| {
        let mut passed = 1.0;
        for reflections in 0..16 {
            let Some((distance, t)) = nearest(origin, direction) else {
                let within = direction.dot(sun.direction) >= sun.radius.cos();
                return if within && reflections > 0 { passed } else { 0.0 };
            };
            let [a, b, c] = t.vertices;
            let n = (b - a).cross(c - a).normalize();
            // Mirrors have one side.
            if n.dot(direction) >= 0.0 {
                return 0.0;
            }
            passed *= reflectance(t);
            if passed <= 0.0 {
                return 0.0;
            }
            origin += direction * distance + n * 1e-7;
            direction -= n * (2.0 * direction.dot(n));
        }
        0.0
    };
    let mut sum = 0.0;
    for t in scene.triangles.iter().filter(|t| reflectance(t) > 0.0) {
        let [a, b, c] = t.vertices;
        let across = (b - a).cross(c - a);
        let (nu, nv) = (((b - a).length() / pitch).ceil() as usize, ((c - a).length() / pitch).ceil() as usize);
        // Every point of the grid in the triangle stands for as much of it.
        let inside = |i: usize, k: usize| (i as f64 + 0.5) / nu as f64 + (k as f64 + 0.5) / (nv as f64) < 1.0;
        let points: Vec<(usize, usize)> = (0..nu).flat_map(|i| (0..nv).map(move |k| (i, k))).filter(|&(i, k)| inside(i, k)).collect();
        for &(i, k) in &points {
            let (u, v) = ((i as f64 + 0.5) / nu as f64, (k as f64 + 0.5) / nv as f64);
            let to = a + (b - a) * u + (c - a) * v - position;
            let direction = to.normalize();
            let (cosine, slope) = (direction.dot(normal.normalize()), -direction.dot(across.normalize()));
            if cosine <= 0.0 || slope <= 0.0 {
                continue;
            }
            // The point itself must be what the receiver sees.
            if nearest(position, direction).is_some_and(|(distance, _)| (distance - to.length()).abs() < 1e-6) {
                let area = across.length() / 2.0 / points.len() as f64;
                sum += follow(position, direction) * cosine * slope / to.length_squared() * area;
            }
        }
    }
    sum
}

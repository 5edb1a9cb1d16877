//! Small scenes for the tests of the tracing kernels.

use super::smooth_fresnel;
use crate::bins::{Frame, KlemsBasis};
use crate::scene::points::Sensor;
use crate::scene::{Material, MaterialIndex, MaterialKind, Scene, SurfaceOrigin, Triangle, Window};
use glam::DVec3;

/// Builds scenes from quadrilaterals.
#[derive(Default)]
pub(crate) struct Builder {
    pub scene: Scene,
}

impl Builder {
    pub fn material(&mut self, kind: MaterialKind) -> MaterialIndex {
        self.scene.materials.push(Material { name: format!("m{}", self.scene.materials.len()), kind });
        MaterialIndex(self.scene.materials.len() as u32 - 1)
    }

    pub fn grey(&mut self, reflectance: f64) -> MaterialIndex {
        self.material(MaterialKind::Plastic { color: [reflectance; 3], specularity: 0.0, roughness: 0.0 })
    }

    pub fn quad(&mut self, corners: [[f64; 3]; 4], material: MaterialIndex) {
        let [a, b, c, d] = corners.map(DVec3::from_array);
        for vertices in [[a, b, c], [a, c, d]] {
            self.scene.triangles.push(Triangle { vertices, material, surface: 0 });
        }
    }

    /// The inside of a box from `low` to `high`, without the faces named in `without`
    /// (0…5 = x low, x high, y low, y high, z low, z high).
    pub fn room(&mut self, low: [f64; 3], high: [f64; 3], material: MaterialIndex, without: &[usize]) {
        let ([x0, y0, z0], [x1, y1, z1]) = (low, high);
        let faces = [
            [[x0, y0, z0], [x0, y1, z0], [x0, y1, z1], [x0, y0, z1]],
            [[x1, y0, z0], [x1, y0, z1], [x1, y1, z1], [x1, y1, z0]],
            [[x0, y0, z0], [x0, y0, z1], [x1, y0, z1], [x1, y0, z0]],
            [[x0, y1, z0], [x1, y1, z0], [x1, y1, z1], [x0, y1, z1]],
            [[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0]],
            [[x0, y0, z1], [x0, y1, z1], [x1, y1, z1], [x1, y0, z1]],
        ];
        for (i, face) in faces.into_iter().enumerate() {
            if !without.contains(&i) {
                self.quad(face, material);
            }
        }
    }
}

/// A sensor.
pub fn sensor(position: [f64; 3], direction: [f64; 3]) -> Sensor {
    Sensor { position: DVec3::from_array(position), direction: DVec3::from_array(direction), line: 0 }
}

/// Irradiance from a polygon of radiance 1 (Lambert 1760), all of it above the sensor's horizon.
pub fn polygon_irradiance(corners: &[DVec3], eye: DVec3, normal: DVec3) -> f64 {
    let mut sum = 0.0;
    for (i, &a) in corners.iter().enumerate() {
        let (a, b) = ((a - eye).normalize(), (corners[(i + 1) % corners.len()] - eye).normalize());
        let across = a.cross(b);
        sum += across.length().atan2(a.dot(b)) * across.normalize_or_zero().dot(normal);
    }
    (sum / 2.0).abs()
}

/// Moves and scales a scene and its window: p becomes origin + scale · p.
pub(crate) fn placed(scene: &Scene, window: &Window, origin: DVec3, scale: f64) -> (Scene, Window) {
    let (mut scene, mut window) = (scene.clone(), window.clone());
    for p in scene.triangles.iter_mut().flat_map(|t| &mut t.vertices).chain(window.triangles.iter_mut().flatten()) {
        *p = origin + *p * scale;
    }
    (scene, window)
}

/// A rectangular window from corners, normal into the room.
pub fn window(corners: [[f64; 3]; 4], normal: DVec3, up: DVec3, basis: KlemsBasis) -> Window {
    let [a, b, c, d] = corners.map(DVec3::from_array);
    Window {
        name: "window".into(),
        triangles: vec![[a, b, c], [a, c, d]],
        frame: Frame::new(normal, up).unwrap(),
        basis: basis.into(),
        origin: SurfaceOrigin { name: "window".into(), file: "made-by-a-test.rad".into(), line: 1 },
    }
}

/// A left-right asymmetric side-lit room: window in the south wall off centre, dark west wall,
/// bright east wall with a pillar, coloured floor.
pub fn asymmetric() -> (Scene, Window) {
    let mut b = Builder::default();
    let walls = b.grey(0.6);
    let dark = b.grey(0.1);
    let floor = b.material(MaterialKind::Plastic { color: [0.5, 0.3, 0.2], specularity: 0.0, roughness: 0.0 });
    // South wall (y = 0) around the window x 0.5…2, z 1…2.5.
    b.room([0.0, 0.0, 0.0], [4.0, 5.0, 3.0], walls, &[0, 2, 4]);
    b.quad([[0.0, 0.0, 0.0], [0.0, 5.0, 0.0], [0.0, 5.0, 3.0], [0.0, 0.0, 3.0]], dark);
    b.quad([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 5.0, 0.0], [0.0, 5.0, 0.0]], floor);
    for q in [
        [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 0.0, 1.0], [0.0, 0.0, 1.0]],
        [[0.0, 0.0, 2.5], [4.0, 0.0, 2.5], [4.0, 0.0, 3.0], [0.0, 0.0, 3.0]],
        [[0.0, 0.0, 1.0], [0.5, 0.0, 1.0], [0.5, 0.0, 2.5], [0.0, 0.0, 2.5]],
        [[2.0, 0.0, 1.0], [4.0, 0.0, 1.0], [4.0, 0.0, 2.5], [2.0, 0.0, 2.5]],
    ] {
        b.quad(q, walls);
    }
    b.room([3.0, 1.5, 0.0], [3.4, 1.9, 3.0], dark, &[4, 5]);
    let w = window([[0.5, 0.0, 1.0], [0.5, 0.0, 2.5], [2.0, 0.0, 2.5], [2.0, 0.0, 1.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    (b.scene, w)
}

/// What a window in a south wall looks at: coloured ground, a black box to the east, a mirror
/// façade to the west, a translucent canopy above and a pane of glass before the lower half. Left
/// and right, up and down all differ.
pub(crate) fn street() -> (Scene, Window) {
    let mut b = Builder::default();
    let ground = b.material(MaterialKind::Plastic { color: [0.4, 0.5, 0.3], specularity: 0.0, roughness: 0.0 });
    let facade = b.grey(0.5);
    let brick = b.material(MaterialKind::Plastic { color: [0.6, 0.3, 0.2], specularity: 0.05, roughness: 0.0 });
    let mirror = b.material(MaterialKind::Mirror { color: [0.8, 0.75, 0.7] });
    let glass = b.material(MaterialKind::Glass { transmissivity: [0.9, 0.8, 0.7], refraction_index: 1.52 });
    let canopy = b.material(MaterialKind::Trans {
        color: [0.7, 0.7, 0.6],
        specularity: 0.04,
        roughness: 0.0,
        transmissivity: 0.5,
        transmitted_specularity: 0.3,
    });
    b.quad([[-20.0, -30.0, 0.0], [20.0, -30.0, 0.0], [20.0, 0.2, 0.0], [-20.0, 0.2, 0.0]], ground);
    // The facade with a hole for the window x 0.5…2, z 1…2.5.
    for (x0, x1, z0, z1) in [(-6.0, 6.0, 0.0, 1.0), (-6.0, 6.0, 2.5, 5.0), (-6.0, 0.5, 1.0, 2.5), (2.0, 6.0, 1.0, 2.5)] {
        b.quad([[x0, 0.0, z0], [x1, 0.0, z0], [x1, 0.0, z1], [x0, 0.0, z1]], facade);
    }
    // A house to the south-east, its outside.
    let ([x0, y0, z0], [x1, y1, z1]) = ([2.5, -8.0, 0.0], [8.0, -4.0, 6.0]);
    b.quad([[x0, y1, z0], [x1, y1, z0], [x1, y1, z1], [x0, y1, z1]], brick);
    b.quad([[x0, y0, z0], [x0, y1, z0], [x0, y1, z1], [x0, y0, z1]], brick);
    b.quad([[x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]], brick);
    // Its front faces east.
    b.quad([[-2.0, -6.0, 0.0], [-2.0, -0.5, 0.0], [-2.0, -0.5, 4.0], [-2.0, -6.0, 4.0]], mirror);
    b.quad([[0.0, -1.2, 2.7], [2.2, -1.2, 2.7], [2.2, 0.0, 2.9], [0.0, 0.0, 2.9]], canopy);
    b.quad([[0.2, -0.4, 0.8], [2.3, -0.4, 0.8], [2.3, -0.4, 1.6], [0.2, -0.4, 1.6]], glass);
    let w = window([[0.5, 0.0, 1.0], [0.5, 0.0, 2.5], [2.0, 0.0, 2.5], [2.0, 0.0, 1.0]], DVec3::Y, DVec3::Z, KlemsBasis::Full);
    (b.scene, w)
}

/// A plane mirror: a point of it, its unit normal, and what it reflects by the cosine of incidence.
pub(crate) struct PlaneMirror<'a> {
    pub point: DVec3,
    pub normal: DVec3,
    pub reflectance: &'a (dyn Fn(f64) -> f64 + Sync),
}

/// Irradiance from a rectangular window of radiance 1 by way of mirrors, in the order in which the eye meets
/// them, by the midpoint rule over the window. `passes` tells what part of the light along a leg from one point
/// to the next arrives.
pub(crate) fn mirrored_irradiance(
    w: &Window,
    eye: &Sensor,
    mirrors: &[PlaneMirror<'_>],
    passes: &(dyn Fn(DVec3, DVec3) -> f64 + Sync),
) -> f64 {
    const STEPS: usize = 200;
    let [[a, b, c], _] = [w.triangles[0], w.triangles[1]];
    let reflect = |p: DVec3, m: &PlaneMirror<'_>| p - m.normal * (2.0 * (p - m.point).dot(m.normal));
    let normal = eye.direction.normalize();
    let cell = (b - a).cross(c - b).length() / (STEPS * STEPS) as f64;
    let mut sum = 0.0;
    for i in 0..STEPS * STEPS {
        let (u, v) = (((i / STEPS) as f64 + 0.5) / STEPS as f64, ((i % STEPS) as f64 + 0.5) / STEPS as f64);
        let target = a + (b - a) * u + (c - b) * v;
        // Images of the target as seen past the first, second … mirror.
        let mut images = vec![target];
        for m in mirrors.iter().rev() {
            images.push(reflect(images[images.len() - 1], m));
        }
        let distance = (images[mirrors.len()] - eye.position).length();
        let first = (images[mirrors.len()] - eye.position) / distance;
        let (mut from, mut along, mut part) = (eye.position, first, 1.0);
        for (k, m) in mirrors.iter().enumerate() {
            let towards = images[mirrors.len() - k] - from;
            let share = (m.point - from).dot(m.normal) / towards.dot(m.normal);
            if !(share > 1e-12 && share < 1.0) {
                part = 0.0;
                break;
            }
            let met = from + towards * share;
            along = towards.normalize();
            part *= passes(from, met) * (m.reflectance)(along.dot(m.normal).abs());
            along -= m.normal * (2.0 * along.dot(m.normal));
            from = met;
        }
        if part > 0.0 {
            part *= passes(from, target);
        }
        sum += part * first.dot(normal).max(0.0) * (-along.dot(w.frame.z)).max(0.0) / (distance * distance) * cell;
    }
    sum
}

/// What smooth plastic of this specularity reflects as a mirror.
pub(crate) fn polish(specularity: f64) -> impl Fn(f64) -> f64 {
    move |cosine| specularity + (1.0 - specularity) * smooth_fresnel(cosine)
}

//! Small scenes for the tests of the tracing kernels.

use crate::bins::{Frame, KlemsBasis};
use crate::scene::{Material, MaterialIndex, MaterialKind, Scene, SurfaceOrigin, Triangle, Window};
use glam::DVec3;

/// Builds scenes from quadrilaterals.
#[derive(Default)]
pub struct Builder {
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

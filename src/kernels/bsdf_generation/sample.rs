//! The sample whose BSDF is generated: geometry in its box.

use crate::bins::Frame;
use crate::error::{Error, Result, Warnings};
use crate::kernels::trace::{TraceTables, WindowSurfaces};
use crate::scene::{MaterialKind, Scene, SurfaceOrigin, Triangle, Window};
use glam::{DVec3, Vec3};

/// Most triangles after copying the neighbours of a repeating sample.
const MOST_TRIANGLES: usize = 20_000_000;

/// A shade, device or layer in genBSDF's position: +z into the room, +y up, at z ≤ 0.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Geometry. Neighbours of a repeating sample are not part of it.
    pub scene: Scene,
    /// Corner of the box with the lowest coordinates.
    pub low: DVec3,
    /// Corner of the box with the highest coordinates.
    pub high: DVec3,
    /// Whether the box is one period of an endless sample along x and y.
    pub repeats: [bool; 2],
}

impl Sample {
    /// A sample in the box `dim` (`xmin xmax ymin ymax zmin zmax`, genBSDF's `-dim`), by default
    /// that of its geometry.
    ///
    /// # Errors
    /// If there is no geometry and no box, if the box has no area, and if geometry lies before or
    /// behind it or altogether outside.
    pub fn new(scene: Scene, dim: Option<[f64; 6]>, repeats: [bool; 2], warnings: &mut Warnings) -> Result<Self> {
        let corners = || scene.triangles.iter().filter(|t| solid(&scene, t)).flat_map(|t| t.vertices);
        if corners().any(|p| !p.is_finite()) {
            return Err(Error::new("the geometry has coordinates that are not finite"));
        }
        let (found_low, found_high) = corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let empty = scene.triangles.is_empty() || found_low.x > found_high.x;
        let (low, high) = match dim {
            Some(d) => (DVec3::new(d[0], d[2], d[4]), DVec3::new(d[1], d[3], d[5])),
            None if empty => {
                return Err(Error::new("there is no geometry").help("give the files of the device, materials first, or a box with -dim"));
            }
            None => (found_low, found_high),
        };
        let named = |e: Error| if dim.is_some() { e.field("-dim") } else { e.field("geometry") };
        if !(low.is_finite() && high.is_finite()) || high.x < low.x || high.y < low.y || high.z < low.z {
            return Err(named(
                Error::new(format!("the box {} is not in ascending order", words(low, high))).help("give xmin xmax ymin ymax zmin zmax"),
            ));
        }
        let extent = (high - low).max_element().max(1e-12);
        for (axis, size) in [("x", high.x - low.x), ("y", high.y - low.y)] {
            if !(size > 1e-6 * extent) {
                return Err(named(
                    Error::new(format!("the box {} has no extent along {axis}", words(low, high)))
                        .help("the device lies in the xy-plane with the room at +z: turn it with xform, for instance -rx 90"),
                ));
            }
        }
        let sample = Self { scene, low, high, repeats };
        if empty {
            warnings.push(Error::new("there is no geometry: the box is an open hole").field("geometry"));
        } else {
            sample.check_place(found_low, found_high, warnings)?;
        }
        Ok(sample)
    }

    /// Area of the box seen from the room.
    pub fn area(&self) -> f64 {
        (self.high.x - self.low.x) * (self.high.y - self.low.y)
    }

    /// Thickness in genBSDF's sense: how far the device reaches behind z = 0.
    pub fn thickness(&self) -> f64 {
        (-self.low.z).max(0.0)
    }

    /// Whether most of the geometry lies in front of or behind the box's face, rather than beside it.
    pub(super) fn fills_its_box(&self) -> bool {
        let (low, high) = self.corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        (0..2).all(|axis| self.repeats[axis] || high[axis] - low[axis] < 2.0 * (self.high[axis] - self.low[axis]))
    }

    /// How many of the tables' triangles are the sample's own; those of its neighbours follow.
    pub(super) fn own_triangles(&self, tables: &TraceTables) -> usize {
        if self.repeats == [false, false] {
            return tables.triangles.len();
        }
        let point = |p: DVec3| tables.normalization.point(p);
        // The tables leave out what has no extent.
        let kept = |t: &Triangle| {
            let [a, b, c] = t.vertices.map(point);
            solid(&self.scene, t) && (b - a).cross(c - a).length_squared() > 0.0
        };
        self.scene.triangles.iter().filter(|t| kept(t)).count()
    }

    fn corners(&self) -> impl Iterator<Item = DVec3> {
        self.scene.triangles.iter().filter(|t| solid(&self.scene, t)).flat_map(|t| t.vertices)
    }

    fn check_place(&self, found_low: DVec3, found_high: DVec3, warnings: &mut Warnings) -> Result<()> {
        let size = self.area().sqrt();
        let tolerance = 1e-6 * (size + found_low.abs().max_element().max(found_high.abs().max_element()));
        let at = |message: String| Error::new(message).field("geometry");
        if found_low.z > tolerance {
            return Err(at(format!("the device lies in the room (z from {} to {})", found_low.z, found_high.z))
                .help(format!("the room is at +z and the device behind z = 0: move it with xform -t 0 0 {:.6}", -found_high.z)));
        }
        if found_low.z < self.low.z - tolerance || found_high.z > self.high.z + tolerance {
            return Err(at(format!(
                "geometry from z = {} to {} reaches out of the box, whose z is {} to {}; light would start inside it",
                found_low.z, found_high.z, self.low.z, self.high.z
            ))
            .help("give a box that holds the whole depth of the device with -dim"));
        }
        let apart = |low: f64, high: f64, a: f64, b: f64| a > high || b < low;
        if apart(self.low.x, self.high.x, found_low.x, found_high.x) || apart(self.low.y, self.high.y, found_low.y, found_high.y) {
            return Err(at(format!("all geometry lies outside the box {}", words(self.low, self.high)))
                .help("compare -dim with the geometry's own box, which is used without -dim"));
        }
        if found_high.z > tolerance {
            warnings.push(
                at(format!("the device reaches {} into the room (z > 0)", found_high.z))
                    .help("its thickness counts from z = 0; move it behind with xform"),
            );
        } else if found_high.z < -0.1 * size - tolerance {
            warnings.push(at(format!("the device lies far behind z = 0 (its nearest point is at z = {})", found_high.z)));
        }
        if self.high.z - self.low.z > (self.high.x - self.low.x).min(self.high.y - self.low.y) && self.repeats != [true, true] {
            warnings.push(at(format!("the box {} is deeper than it is wide or high", words(self.low, self.high)))
                .help("the room is at +z: a device that stands upright in the xz-plane needs xform -rx 90 or -rx -90; much light leaves over the sides of a deep box"));
        }
        Ok(())
    }

    /// Tables for the tracer, and the box in its units. The faces on which light starts stand a
    /// little off the device.
    pub(super) fn tables(&self, basis: crate::bins::AngleBasis) -> Result<(TraceTables, [Vec3; 2])> {
        let (low, high) = (self.low, self.high);
        let z = (low.z + high.z) / 2.0;
        let [a, b, c, d] = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)].map(|(x, y)| DVec3::new(x, y, z));
        let window = Window {
            name: "sample".into(),
            triangles: vec![[a, b, c], [a, c, d]],
            frame: Frame::new(DVec3::Z, DVec3::Y)?,
            basis,
            origin: SurfaceOrigin { name: "sample".into(), file: "sample".into(), line: 0 },
        };
        let scene = self.with_neighbours()?;
        let tables = TraceTables::new(&scene, std::slice::from_ref(&window), WindowSurfaces::Open)?;
        let gap = Vec3::Z * 1e-5;
        let ends = [tables.normalization.point(low) - gap, tables.normalization.point(high) + gap];
        Ok((tables, ends))
    }

    /// The geometry with the copies of a repeating sample that reach into its box.
    fn with_neighbours(&self) -> Result<Scene> {
        if self.repeats == [false, false] {
            return Ok(self.scene.clone());
        }
        let size = self.high - self.low;
        // Rays look a little beyond the edges.
        let margin = 1e-3 * size.x.max(size.y);
        let copies = |axis: usize, vertices: &[DVec3; 3]| {
            if !self.repeats[axis] {
                return 0..=0;
            }
            let (least, most) = vertices.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p[axis]), b.max(p[axis])));
            let first = ((self.low[axis] - margin - most) / size[axis]).ceil() as i64;
            let last = ((self.high[axis] + margin - least) / size[axis]).floor() as i64;
            first..=last
        };
        // The sample's own come first, also those that lie outside the first period.
        let mut scene = self.scene.clone();
        for triangle in &self.scene.triangles {
            for i in copies(0, &triangle.vertices) {
                for j in copies(1, &triangle.vertices) {
                    if (i, j) == (0, 0) {
                        continue;
                    }
                    if scene.triangles.len() >= MOST_TRIANGLES {
                        return Err(Error::new("the geometry is too large compared with the period")
                            .field("-dim")
                            .help("repeat a larger box"));
                    }
                    let shift = DVec3::new(i as f64 * size.x, j as f64 * size.y, 0.0);
                    scene.triangles.push(Triangle { vertices: triangle.vertices.map(|p| p + shift), ..*triangle });
                }
            }
        }
        Ok(scene)
    }
}

fn solid(scene: &Scene, triangle: &Triangle) -> bool {
    scene.materials.get(triangle.material.0 as usize).is_some_and(|m| m.kind != MaterialKind::Void)
}

fn words(low: DVec3, high: DVec3) -> String {
    format!("x {} to {}, y {} to {}, z {} to {}", low.x, high.x, low.y, high.y, low.z, high.z)
}

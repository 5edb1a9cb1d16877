//! Honeybee's planar faces and meshes as outlines and triangles, in metres.

use super::json::Node;
use crate::error::{Error, Result};
use crate::scene::polygon::{Triangulation, triangulate};
use glam::DVec3;

/// A planar face with holes. Its normal is that of the boundary, counter-clockwise seen from the front.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Face3d {
    pub boundary: Vec<DVec3>,
    pub holes: Vec<Vec<DVec3>>,
}

impl Face3d {
    /// The `geometry` of an object (or what else the key is called), in metres. Where its plane is given, that
    /// says which side is the front, as in Honeybee.
    ///
    /// # Errors
    /// Missing or wrong parts, fewer than three corners.
    pub fn read(object: &Node<'_>, key: &str, scale: f64) -> Result<Self> {
        let Some(face) = object.object(key)? else { return Err(object.missing(key)) };
        match face.text("type")? {
            None | Some("Face3D") => {}
            Some(other) => return Err(object.error(format!("'{key}' is of type '{other}', not Face3D")).help("export the model again")),
        }
        let scaled = |points: Vec<DVec3>| points.into_iter().map(|p| p * scale).collect::<Vec<_>>();
        let mut boundary = scaled(face.points("boundary")?);
        let holes: Vec<Vec<DVec3>> = face.outlines("holes")?.into_iter().map(scaled).collect();
        if boundary.len() < 3 || holes.iter().any(|h| h.len() < 3) {
            return Err(object.error(format!("an outline of '{key}' has fewer than three corners")).help("repair the face in Honeybee"));
        }
        if let Some(plane) = face.object("plane")?
            && let Some(normal) = plane.vector("n")?
            && area_vector(&boundary).dot(normal) < 0.0
        {
            boundary.reverse();
        }
        Ok(Self { boundary, holes })
    }

    /// Area times normal of the whole, holes taken out.
    pub fn area_vector(&self) -> DVec3 {
        let own = area_vector(&self.boundary);
        let unit = own.normalize_or_zero();
        own - self.holes.iter().map(|h| unit * area_vector(h).length()).sum::<DVec3>()
    }

    /// Unit normal; zero if there is no area.
    pub fn normal(&self) -> DVec3 {
        area_vector(&self.boundary).normalize_or_zero()
    }

    /// The same with further holes, pressed into its plane.
    pub fn with_holes(&self, others: &[&Self]) -> Self {
        let (origin, normal) = (self.boundary[0], self.normal());
        let flat = |p: &DVec3| *p - (*p - origin).dot(normal) * normal;
        let more = others.iter().map(|o| o.boundary.iter().map(flat).collect());
        Self { boundary: self.boundary.clone(), holes: self.holes.iter().cloned().chain(more).collect() }
    }

    /// The face moved.
    pub fn moved(&self, by: DVec3) -> Self {
        let all = |points: &[DVec3]| points.iter().map(|p| *p + by).collect();
        Self { boundary: all(&self.boundary), holes: self.holes.iter().map(|h| all(h)).collect() }
    }

    /// One outline with seams from the first corner to each hole, as Radiance takes holes, cut into triangles.
    pub fn triangles(&self) -> Triangulation {
        let normal = self.normal();
        let mut outline = self.boundary.clone();
        for hole in &self.holes {
            outline.push(self.boundary[0]);
            let turned = area_vector(hole).dot(normal) > 0.0;
            if turned {
                outline.extend(hole.iter().rev());
                outline.extend(hole.last());
            } else {
                outline.extend(hole);
                outline.extend(hole.first());
            }
        }
        if self.holes.is_empty() {
            return triangulate(&outline);
        }
        outline.push(self.boundary[0]);
        triangulate(&outline)
    }

    /// Largest distance of another face's corners from this one's plane.
    pub fn distance(&self, other: &Self) -> f64 {
        let (origin, normal) = (self.boundary[0], self.normal());
        other.boundary.iter().map(|p| (*p - origin).dot(normal).abs()).fold(0.0, f64::max)
    }
}

/// Area times unit normal of an outline.
pub(super) fn area_vector(outline: &[DVec3]) -> DVec3 {
    let origin = outline[0];
    outline.windows(2).map(|w| (w[0] - origin).cross(w[1] - origin)).sum::<DVec3>() / 2.0
}

/// The faces of a mesh, each an outline of three or four corners, in metres.
///
/// # Errors
/// Missing or wrong parts, faces that name corners that are not there.
pub(super) fn mesh(object: &Node<'_>, key: &str, scale: f64) -> Result<Vec<Vec<DVec3>>> {
    let Some(mesh) = object.object(key)? else { return Err(object.missing(key)) };
    let vertices = mesh.points("vertices")?;
    let corner = |i: &usize| vertices.get(*i).map(|p| *p * scale);
    let face = |(number, face): (usize, Vec<usize>)| {
        let corners = face.iter().map(corner).collect::<Option<Vec<DVec3>>>();
        corners.filter(|c| c.len() >= 3).ok_or_else(|| -> Error {
            object
                .error(format!("face {number} of the mesh names {face:?}, of {} corners", vertices.len()))
                .help("a face is three or four numbers of corners, from 0")
        })
    };
    mesh.indices("faces")?.into_iter().enumerate().map(face).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, size: f64) -> Vec<DVec3> {
        [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].iter().map(|p| DVec3::new(x + size * p[0], y + size * p[1], 2.0)).collect()
    }

    fn area(face: &Face3d) -> f64 {
        face.triangles().triangles.iter().map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
    }

    #[test]
    fn holes_are_cut_out_whichever_way_they_are_wound_and_wherever_they_lie() {
        let mut turned = square(2.0, 2.0, 1.0);
        turned.reverse();
        for second in [turned, square(2.0, 2.0, 1.0)] {
            let face = Face3d { boundary: square(0.0, 0.0, 4.0), holes: vec![square(0.5, 0.5, 1.0), second] };
            assert!((area(&face) - 14.0).abs() < 1e-12 && (face.area_vector() - DVec3::Z * 14.0).length() < 1e-12);
            assert!(face.triangles().triangles.iter().all(|[a, b, c]| (b - a).cross(c - a).z > 0.0));
        }
        // At the edge, and beside each other.
        let face = Face3d { boundary: square(0.0, 0.0, 4.0), holes: vec![square(0.0, 0.0, 1.0), square(1.0, 0.0, 1.0)] };
        assert!((area(&face) - 14.0).abs() < 1e-12);
        // A grid of 400 openings.
        let holes = (0..400).map(|i| square(0.1 + f64::from(i % 20) * 0.19, 0.1 + f64::from(i / 20) * 0.19, 0.1)).collect();
        let face = Face3d { boundary: square(0.0, 0.0, 4.0), holes };
        assert!((area(&face) - 12.0).abs() < 1e-9);
    }
}

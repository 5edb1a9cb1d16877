//! Surfaces of `.rad` files in world coordinates, as triangles or distant sources.

use super::syntax::Object;
use super::types::Surface;
use super::xform::Placement;
use crate::error::{Error, Result, Warnings};
use crate::scene::{polygon, shapes};
use glam::DVec3;
use std::path::Path;

/// Geometry of one surface.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Geometry {
    /// Triangles, counter-clockwise seen from the front. Empty for degenerate surfaces, of which a
    /// warning tells.
    Triangles(Vec<[DVec3; 3]>),
    /// Distant source: direction towards it (unit length), full opening angle in degrees.
    Distant(DVec3, f64),
}

/// Places a surface and cuts it into triangles.
///
/// Degenerate surfaces are left out with a warning, as Radiance does.
///
/// # Errors
/// Wrong numbers of arguments; coordinates that overflow.
pub(super) fn geometry(surface: Surface, object: &Object, placement: &Placement, file: &Path, warnings: &mut Warnings) -> Result<Geometry> {
    let at = |e: Error| object.at(e, file);
    let mut warn = |message: String, help: &str| warnings.push(at(Error::new(message).help(help)));
    let r = object.reals.as_slice();
    check_counts(surface, object).map_err(at)?;
    let point = |i: usize| placement.point(DVec3::new(r[i], r[i + 1], r[i + 2]));
    let vector = |i: usize| placement.vector(DVec3::new(r[i], r[i + 1], r[i + 2]));
    let mut inward = placement.inverted ^ matches!(surface, Surface::Bubble | Surface::Tube | Surface::Cup);
    // Lengths that are zero but for rounding, as Radiance's FTINY.
    const TINY: f64 = 1e-6;
    let degenerate = "it is left out, as in Radiance; delete it or correct its arguments";
    let made = match surface {
        Surface::Source => {
            let Some(direction) = vector(0).try_normalize() else {
                return Err(at(Error::new("the direction of the source is zero").help("give the direction towards the source")));
            };
            if !(r[3] > 0.0 && r[3] <= 360.0) {
                return Err(at(
                    Error::new(format!("the opening angle is {}", r[3])).help("give the full angle in degrees, above 0 and up to 360")
                ));
            }
            return Ok(Geometry::Distant(direction, r[3]));
        }
        Surface::Polygon => {
            let mut corners: Vec<DVec3> = (0..r.len() / 3).map(|i| point(3 * i)).collect();
            if placement.is_mirrored() != placement.inverted {
                corners.reverse();
            }
            inward = false;
            let cut = polygon::triangulate(&corners);
            if cut.triangles.is_empty() {
                warn("the polygon has no area".to_string(), degenerate);
            } else if cut.flattened {
                warn(
                    format!("the polygon is not plane: corners are up to {:.3e} off; it is flattened into its mean plane", cut.departure),
                    "divide it into triangles",
                );
            }
            Ok(cut.triangles)
        }
        Surface::Sphere | Surface::Bubble => {
            let radius = r[3] * placement.scale;
            if radius == 0.0 {
                warn("the radius is zero".to_string(), degenerate);
                return Ok(Geometry::Triangles(Vec::new()));
            }
            if radius < 0.0 {
                warn(
                    "the radius is negative".to_string(),
                    "it is turned inside out, as in Radiance; write `bubble` for `sphere` and a positive radius",
                );
                inward = !inward;
            }
            Ok(shapes::sphere(point(0), radius.abs()))
        }
        Surface::Ring => {
            let radii = [r[6], r[7]].map(|v| v * placement.scale);
            let (inner, outer) = (radii[0].min(radii[1]), radii[0].max(radii[1]));
            if inner < 0.0 || outer - inner <= TINY * outer {
                warn(format!("radii of {inner} and {outer} make no ring"), degenerate);
                return Ok(Geometry::Triangles(Vec::new()));
            }
            let normal = if placement.inverted { -vector(3) } else { vector(3) };
            inward = false;
            shapes::ring(point(0), normal, inner, outer)
        }
        Surface::Cylinder | Surface::Tube | Surface::Cone | Surface::Cup => {
            let [mut r0, mut r1] = [r[6], *r.get(7).unwrap_or(&r[6])].map(|v| v * placement.scale);
            if r0.min(r1) < 0.0 && r0.max(r1) <= 0.0 {
                warn(
                    "the radius is negative".to_string(),
                    "it is turned inside out, as in Radiance; write `tube` or `cup` and positive radii",
                );
                (r0, r1) = (-r0, -r1);
                inward = !inward;
            }
            if r0.min(r1) < 0.0 || r0.max(r1) == 0.0 {
                warn(format!("radii of {r0} and {r1} make no surface"), degenerate);
                return Ok(Geometry::Triangles(Vec::new()));
            }
            shapes::cone(point(0), point(3), r0, r1)
        }
    };
    let mut triangles = match made {
        Ok(triangles) => triangles,
        // Without a direction: Radiance leaves such a surface out, too.
        Err(e) => {
            warn(e.message().to_string(), degenerate);
            Vec::new()
        }
    };
    if inward {
        for t in &mut triangles {
            t.swap(1, 2);
        }
    }
    if triangles.iter().flatten().any(|v| !v.is_finite()) {
        return Err(at(Error::new("its coordinates are too large").help("check the units and the scale factors of xform")));
    }
    Ok(Geometry::Triangles(triangles))
}

fn check_counts(surface: Surface, object: &Object) -> Result<()> {
    let n = object.reals.len();
    let (right, meaning) = match surface {
        Surface::Polygon => (n >= 9 && n.is_multiple_of(3), "three coordinates for each of three or more corners"),
        Surface::Sphere | Surface::Bubble => (n == 4, "the centre (3) and the radius"),
        Surface::Ring => (n == 8, "the centre (3), the normal (3) and two radii"),
        Surface::Cylinder | Surface::Tube => (n == 7, "two ends (3 each) and the radius"),
        Surface::Cone | Surface::Cup => (n == 8, "two ends (3 each) and two radii"),
        Surface::Source => (n == 4, "the direction (3) and the full angle in degrees"),
    };
    if !right {
        return Err(Error::new(format!("{n} real arguments do not make a {}", object.kind.word())).help(format!("it needs {meaning}")));
    }
    if !object.strings.is_empty() {
        return Err(Error::new(format!("a {} has no string arguments", object.kind.word())).help("write 0 as the first count"));
    }
    Ok(())
}

//! Panes that stand for geometry: Radiance's `BSDF` with a thickness.
//!
//! Rays from the eye and to the sun pass such a surface as if it were not there and meet the geometry
//! behind it (at most its thickness away, before it if the thickness is negative); all other rays meet the
//! scattering data instead. In a shade the geometry is what counts, so these surfaces only tell where it
//! has to lie.

use super::xform::Placement;
use crate::bins::Frame;
use crate::error::{Error, Result};
use crate::scene::SurfaceOrigin;
use glam::DVec3;

/// The arguments of a `BSDF` that matter here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ThickBsdf {
    thickness: f64,
    up: Option<DVec3>,
}

impl ThickBsdf {
    /// From the string arguments `thickness file ux uy uz functions …`; nothing if the thickness is 0.
    ///
    /// # Errors
    /// If there are too few, or the thickness is no number.
    pub(super) fn read(strings: &[String], scale: f64) -> Result<Option<Self>> {
        let arguments = "its string arguments are: thickness file up-x up-y up-z functions [transform]";
        let [thickness, _, up @ ..] = strings else {
            return Err(Error::new(format!("{} string arguments are too few", strings.len())).help(arguments));
        };
        if up.len() < 4 {
            return Err(Error::new(format!("{} string arguments are too few", strings.len())).help(arguments));
        }
        let thickness: f64 = thickness.parse().map_err(|_| {
            Error::new(format!("the thickness '{thickness}' is no number"))
                .help("thicknesses from function files are not known here; write the number")
        })?;
        if !thickness.is_finite() {
            return Err(Error::new(format!("the thickness is {thickness}")).help(arguments));
        }
        // An up vector from a function file is Radiance's concern.
        let up = match [0, 1, 2].map(|i| up[i].parse::<f64>()) {
            [Ok(x), Ok(y), Ok(z)] => Some(DVec3::new(x, y, z)),
            _ => None,
        };
        Ok((thickness != 0.0).then_some(Self { thickness: thickness * scale, up }))
    }
}

/// A surface that stands for geometry.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ProxiedPane {
    /// Where it was read from.
    pub origin: SurfaceOrigin,
    /// A point of it.
    pub point: DVec3,
    /// Unit normal of its front.
    pub normal: DVec3,
    /// How far behind it (before it, if negative) its geometry reaches.
    pub thickness: f64,
}

impl ProxiedPane {
    /// # Errors
    /// If the up vector is zero or parallel to the normal.
    pub(super) fn new(bsdf: &ThickBsdf, triangles: Vec<[DVec3; 3]>, placement: &Placement, origin: SurfaceOrigin) -> Result<Self> {
        let normal: DVec3 = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a)).sum::<DVec3>().normalize();
        if let Some(up) = bsdf.up {
            Frame::new(normal, placement.linear * up).map_err(|_| {
                Error::new(format!("the up vector {} {} {} of its BSDF is zero or parallel to the surface's normal", up.x, up.y, up.z))
                    .help("an upright pane has 0 0 1; one that lies, 0 1 0")
            })?;
        }
        Ok(Self { origin, point: triangles[0][0], normal, thickness: bsdf.thickness })
    }

    /// How far a point lies outside the slab of this pane, in the scene's unit; 0 inside.
    pub fn outside(&self, point: DVec3) -> f64 {
        let depth = (self.point - point).dot(self.normal) * self.thickness.signum();
        (depth - self.thickness.abs()).max(-depth).max(0.0)
    }
}

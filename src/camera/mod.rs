//! Radiance views: from pixels to rays and back.
//!
//! A [`View`] is what the options say; [`View::camera`] checks it and gives a [`Camera`], which
//! maps image positions (0…1 from left and from **bottom**, as in Radiance's `viewray`) to rays and
//! directions to positions. A [`Raster`] adds a resolution: pixels (column from the left, row from
//! the **top**), samples within a pixel, solid angles and masks.

mod parse;
mod raster;

pub(crate) use raster::PixelSamples;
pub use raster::Raster;
pub(crate) use raster::triangle_solid_angle;

use crate::error::{Error, Result};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Below this, lengths and sines are zero (Radiance's `FTINY`).
const TINY: f64 = 1e-6;

/// Largest coordinate, clipping distance and size of a parallel view, in units of length.
const MAX_LENGTH: f64 = 1e9;

/// Largest component of a direction: its square is finite.
const MAX_VECTOR: f64 = 1e100;

/// Largest shift and lift, in pictures: the squares of image positions stay far from overflow.
const MAX_SHIFT: f64 = 1e6;

/// How directions are spread over the picture (`-vt`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Projection {
    /// `-vtv`: perspective.
    Perspective,
    /// `-vtl`: parallel; horizontal and vertical sizes are lengths.
    Parallel,
    /// `-vth`: hemispherical (orthographic) fisheye: distance from the centre ∝ sin θ.
    Hemispherical,
    /// `-vta`: angular (equidistant) fisheye: distance from the centre ∝ θ.
    Angular,
    /// `-vts`: planispheric (stereographic) fisheye: distance from the centre ∝ tan(θ/2).
    Planispheric,
    /// `-vtc`: cylindrical panorama.
    Cylindrical,
}

impl Projection {
    /// All projections.
    pub const ALL: [Self; 6] =
        [Self::Perspective, Self::Parallel, Self::Hemispherical, Self::Angular, Self::Planispheric, Self::Cylindrical];

    /// Radiance's letter.
    pub const fn letter(self) -> char {
        match self {
            Self::Perspective => 'v',
            Self::Parallel => 'l',
            Self::Hemispherical => 'h',
            Self::Angular => 'a',
            Self::Planispheric => 's',
            Self::Cylindrical => 'c',
        }
    }

    /// Whether it is one of the three fisheyes.
    pub(crate) const fn is_fisheye(self) -> bool {
        matches!(self, Self::Hemispherical | Self::Angular | Self::Planispheric)
    }
}

/// View parameters as Radiance's options give them, not yet checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// `-vt`
    pub projection: Projection,
    /// `-vp`: view point.
    pub point: DVec3,
    /// `-vd`: view direction, any length.
    pub direction: DVec3,
    /// `-vu`: up vector, any length.
    pub up: DVec3,
    /// `-vh`: horizontal size, degrees (a length for parallel views).
    pub horizontal: f64,
    /// `-vv`: vertical size, degrees (a length for parallel views).
    pub vertical: f64,
    /// `-vo`: distance of the fore clipping plane.
    pub fore: f64,
    /// `-va`: distance of the aft clipping plane; 0 is none.
    pub aft: f64,
    /// `-vs`: shift to the right, in picture widths.
    pub shift: f64,
    /// `-vl`: lift, in picture heights.
    pub lift: f64,
}

impl Default for View {
    /// Radiance's standard view: perspective of 45°, from the origin to +Y, +Z up.
    fn default() -> Self {
        Self {
            projection: Projection::Perspective,
            point: DVec3::ZERO,
            direction: DVec3::Y,
            up: DVec3::Z,
            horizontal: 45.0,
            vertical: 45.0,
            fore: 0.0,
            aft: 0.0,
            shift: 0.0,
            lift: 0.0,
        }
    }
}

/// A ray through a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts: the view point, moved to the fore clipping plane.
    pub origin: DVec3,
    /// Its direction, unit length.
    pub direction: DVec3,
    /// How far it goes (aft clipping plane); 0 is without end.
    pub length: f64,
}

/// A checked view: maps image positions to rays and directions to image positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    view: View,
    /// View direction, unit length.
    pub direction: DVec3,
    /// To the right in the picture, unit length.
    pub right: DVec3,
    /// Upwards in the picture, unit length.
    pub up: DVec3,
    /// Size of the whole picture in the projection's own plane, horizontal and vertical:
    /// 2 tan(h/2) perspective, lengths parallel, 2 sin(h/2) hemispherical, h in radians angular,
    /// 2 tan(h/4) planispheric; cylindrical h in radians and 2 tan(v/2).
    pub size: DVec2,
}

impl View {
    /// Checks the view and prepares its vectors.
    ///
    /// # Errors
    /// Zero direction or up vector, both parallel, sizes the projection does not allow, clipping
    /// planes in the wrong order: the cases that Radiance's `setview` refuses.
    pub fn camera(&self) -> Result<Camera> {
        let limits = [
            ("-vp", self.point.abs().max_element(), MAX_LENGTH),
            ("-vd", self.direction.abs().max_element(), MAX_VECTOR),
            ("-vu", self.up.abs().max_element(), MAX_VECTOR),
            ("-vh", self.horizontal, MAX_LENGTH),
            ("-vv", self.vertical, MAX_LENGTH),
            ("-vo", self.fore, MAX_LENGTH),
            ("-va", self.aft, MAX_LENGTH),
            ("-vs", self.shift.abs(), MAX_SHIFT),
            ("-vl", self.lift.abs(), MAX_SHIFT),
        ];
        if let Some((option, value, limit)) = limits.into_iter().find(|(_, value, limit)| value.is_nan() || value > limit) {
            return Err(Error::new(format!("{value:e} is out of range"))
                .field(option)
                .help(format!("numbers up to {limit:e} are possible")));
        }
        if !self.point.is_finite() || !self.direction.is_finite() || !self.up.is_finite() {
            return Err(Error::new("a view vector is not finite"));
        }
        let unit = |v: DVec3, option: &str, name: &str| {
            v.try_normalize()
                .ok_or_else(|| Error::new(format!("the {name} has no length")).field(option).help("give a vector that is not zero"))
        };
        let direction = unit(self.direction, "-vd", "view direction")?;
        let up = unit(self.up, "-vu", "up vector")?;
        let across = direction.cross(up);
        if across.length() < TINY {
            return Err(Error::new("the up vector is parallel to the view direction")
                .field("-vu")
                .help("looking straight up or down needs a horizontal up vector, for instance -vu 0 1 0"));
        }
        let right = across.normalize();
        if self.fore < 0.0 || self.aft < 0.0 || (self.aft > 0.0 && self.aft <= self.fore) {
            return Err(Error::new(format!("clipping planes at {} and {} m are not in front of each other", self.fore, self.aft))
                .field("-vo, -va")
                .help("0 ≤ fore < aft, or aft 0 for none"));
        }
        let size = DVec2::new(self.size_of(self.horizontal, true)?, self.size_of(self.vertical, false)?);
        Ok(Camera { view: *self, direction, right, up: right.cross(direction), size })
    }

    fn size_of(&self, angle: f64, is_horizontal: bool) -> Result<f64> {
        use Projection::{Angular, Cylindrical, Hemispherical, Parallel, Perspective, Planispheric};
        // Largest angle and whether it is itself allowed.
        let (limit, inclusive) = match (self.projection, is_horizontal) {
            (Parallel, _) => (f64::MAX, true),
            (Perspective, _) | (Cylindrical, false) => (180.0, false),
            (Hemispherical, _) => (180.0, true),
            (Angular, _) | (Cylindrical, true) => (360.0, true),
            (Planispheric, _) => (360.0, false),
        };
        let too_large = if inclusive { angle > limit + TINY } else { angle >= limit - TINY };
        if angle <= TINY || too_large {
            let sign = if inclusive { '≤' } else { '<' };
            let range = if self.projection == Parallel { "> 0".to_owned() } else { format!("> 0 and {sign} {limit}°") };
            return Err(Error::new(format!("a size of {angle} is impossible for the projection -vt{}", self.projection.letter()))
                .field(if is_horizontal { "-vh" } else { "-vv" })
                .help(format!("it must be {range}")));
        }
        let radians = angle.to_radians();
        Ok(match (self.projection, is_horizontal) {
            (Parallel, _) => angle,
            (Perspective, _) | (Cylindrical, false) => 2.0 * (radians / 2.0).tan(),
            (Hemispherical, _) => 2.0 * (radians / 2.0).sin(),
            (Angular, _) | (Cylindrical, true) => radians,
            (Planispheric, _) => 2.0 * (radians / 4.0).tan(),
        })
    }
}

impl Camera {
    /// The view it was made from.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Height by width of the picture with square pixels (Radiance's `viewaspect`).
    pub fn aspect(&self) -> f64 {
        self.size.y / self.size.x
    }

    /// The ray through an image position: (0, 0) is the lower left corner, (1, 1) the upper right.
    /// `None` outside the projection (beyond the rim of a hemispherical, or 180° of an angular
    /// fisheye).
    pub fn ray(&self, x: f64, y: f64) -> Option<Ray> {
        let plane = DVec2::new(x - 0.5 + self.view.shift, y - 0.5 + self.view.lift) * self.size;
        let View { projection, point, fore, aft, .. } = self.view;
        if projection == Projection::Parallel {
            let origin = point + self.direction * fore + self.right * plane.x + self.up * plane.y;
            return Some(Ray { origin, direction: self.direction, length: if aft > 0.0 { aft - fore } else { 0.0 } });
        }
        let (forward, aside) = match projection {
            Projection::Perspective | Projection::Parallel => (1.0, plane),
            Projection::Hemispherical => {
                let squared = 1.0 - plane.length_squared();
                if squared < 0.0 {
                    return None;
                }
                (squared.sqrt(), plane)
            }
            Projection::Angular => {
                let angle = plane.length();
                if angle > PI {
                    return None;
                }
                (angle.cos(), plane * if angle > 1e-8 { angle.sin() / angle } else { 1.0 })
            }
            Projection::Planispheric => {
                let squared = plane.length_squared();
                let forward = (1.0 - squared) / (1.0 + squared);
                (forward, plane * (1.0 + forward))
            }
            Projection::Cylindrical => (plane.x.cos(), DVec2::new(plane.x.sin(), plane.y)),
        };
        let along = self.direction * forward + self.right * aside.x + self.up * aside.y;
        // For perspective and cylinder, clipping distances are measured along the axis; `along` is
        // then longer than 1 and carries the slope.
        let scale = along.length();
        let length = if aft > 0.0 { (aft - fore) * scale } else { 0.0 };
        Some(Ray { origin: point + along * fore, direction: along / scale, length })
    }

    /// Image position of a direction from the view point (of any length), which may lie outside
    /// 0…1. `None` where the projection shows nothing: behind a perspective or hemispherical view,
    /// the poles of a cylinder, the antipode of a fisheye, and always for parallel views (see
    /// [`Self::locate_point`]).
    pub(crate) fn locate(&self, direction: DVec3) -> Option<DVec2> {
        if self.view.projection == Projection::Parallel {
            return None;
        }
        let d = direction.try_normalize()?;
        let forward = d.dot(self.direction);
        let aside = DVec2::new(d.dot(self.right), d.dot(self.up));
        let plane = match self.view.projection {
            Projection::Perspective | Projection::Parallel => {
                if forward <= TINY {
                    return None;
                }
                aside / forward
            }
            Projection::Hemispherical => {
                if forward < 0.0 {
                    return None;
                }
                aside
            }
            Projection::Angular => {
                let sine = aside.length();
                if sine < 1e-9 {
                    if forward < 0.0 {
                        return None;
                    }
                    aside
                } else {
                    aside * (sine.atan2(forward) / sine)
                }
            }
            Projection::Planispheric => {
                if forward <= -1.0 + 1e-12 {
                    return None;
                }
                aside / (1.0 + forward)
            }
            Projection::Cylindrical => {
                let radius = aside.x.hypot(forward);
                if radius < TINY {
                    return None;
                }
                DVec2::new(aside.x.atan2(forward), aside.y / radius)
            }
        };
        Some(self.position(plane))
    }

    /// Image position of a point in the scene, as `Self::locate`; parallel views see every point.
    pub fn locate_point(&self, point: DVec3) -> Option<DVec2> {
        let from_here = point - self.view.point;
        if self.view.projection == Projection::Parallel {
            return Some(self.position(DVec2::new(from_here.dot(self.right), from_here.dot(self.up))));
        }
        self.locate(from_here)
    }

    fn position(&self, plane: DVec2) -> DVec2 {
        plane / self.size + 0.5 - DVec2::new(self.view.shift, self.view.lift)
    }

    /// Solid angle per unit of image area at an image position, sr: the whole picture has area 1.
    /// 0 outside the projection and for parallel views.
    pub(crate) fn solid_angle_density(&self, x: f64, y: f64) -> f64 {
        let plane = DVec2::new(x - 0.5 + self.view.shift, y - 0.5 + self.view.lift) * self.size;
        let squared = plane.length_squared();
        // Solid angle per area of the projection's own plane.
        let density = match self.view.projection {
            Projection::Parallel => 0.0,
            Projection::Perspective => (1.0 + squared).powf(-1.5),
            Projection::Hemispherical if squared < 1.0 => 1.0 / (1.0 - squared).sqrt(),
            Projection::Hemispherical => 0.0,
            Projection::Angular => {
                let angle = squared.sqrt();
                if angle > PI {
                    0.0
                } else if angle > 1e-8 {
                    angle.sin() / angle
                } else {
                    1.0
                }
            }
            Projection::Planispheric => 4.0 / (1.0 + squared).powi(2),
            Projection::Cylindrical => (1.0 + plane.y * plane.y).powf(-1.5),
        };
        density * self.size.x * self.size.y
    }
}

#[cfg(test)]
mod tests;

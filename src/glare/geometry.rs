//! Where each pixel of a view looks and how large it is.

use crate::camera::{Projection, Raster, triangle_solid_angle};
use crate::error::{Error, Result};
use glam::DVec2;
use rayon::prelude::*;

/// Orthonormal axes of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewFrame {
    /// View direction.
    pub forward: [f64; 3],
    /// Upwards in the picture.
    pub up: [f64; 3],
    /// To the right in the picture.
    pub right: [f64; 3],
    /// Length of the view's up vector (a unit vector, not always across the view direction) seen
    /// along the view direction: 1 for a level view with a vertical up vector. Only
    /// [`Convention::Evalglare`] makes use of it.
    ///
    /// [`Convention::Evalglare`]: super::Convention::Evalglare
    pub up_length: f64,
}

impl ViewFrame {
    /// Axes from a view direction and an up vector of any length.
    ///
    /// # Errors
    /// If a vector has no length or the two are parallel.
    pub fn new(forward: [f64; 3], up: [f64; 3]) -> Result<Self> {
        let f = normalise(forward).ok_or_else(|| Error::new(format!("the view direction {forward:?} has no length")))?;
        let right = normalise(cross(f, up)).ok_or_else(|| {
            Error::new(format!("the up vector {up:?} is parallel to the view direction {forward:?}"))
                .help("a view straight up or down needs another up vector, for instance `-vu 0 1 0`")
        })?;
        let up = normalise(up).unwrap_or(up);
        let across = cross(f, up);
        Ok(Self { forward: f, up: cross(right, f), right, up_length: dot(across, across).sqrt().min(1.0) })
    }

    /// The same axes with an up vector across the view direction.
    pub(crate) fn squared(self) -> Self {
        Self { up_length: 1.0, ..self }
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Unit vector, or `None` where the length is (nearly) zero or not finite.
pub(crate) fn normalise(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length.is_finite() && length > 1e-9).then(|| a.map(|x| x / length))
}

/// Directions and solid angles of the pixels of a view, `[y * width + x]`, row 0 on top.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelGeometry {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Axes of the view.
    pub frame: ViewFrame,
    /// Unit vectors through the pixels' centres; zero outside the view.
    pub directions: Vec<[f64; 3]>,
    /// Solid angles, sr; 0 outside the view and behind the viewer.
    pub solid_angles: Vec<f64>,
    /// Solid angles times the cosine to the view direction: the row that turns luminance into
    /// vertical illuminance.
    pub projected_solid_angles: Vec<f64>,
    total_solid_angle: f64,
    total_projected_solid_angle: f64,
}

/// Sums over all pixels of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Totals {
    /// Vertical illuminance, lx.
    pub vertical_illuminance: f64,
    /// Mean luminance weighted by solid angle, cd/m².
    pub average_luminance: f64,
    /// Solid angle of all pixels, sr.
    pub solid_angle: f64,
}

impl PixelGeometry {
    /// Geometry of the pixels of a raster.
    ///
    /// A pixel's solid angle is that of the spherical quadrilateral between its corners' directions
    /// (as [`Raster::solid_angle`]); a pixel with a corner outside the projection, or with its centre
    /// behind the viewer, is outside the view.
    ///
    /// # Errors
    /// A parallel view, or no pixel inside the view.
    pub fn new(raster: &Raster) -> Result<Self> {
        let camera = raster.camera();
        if camera.view().projection == Projection::Parallel {
            return Err(Error::new("a parallel view (-vtl) has no directions to judge glare by")
                .help("use a fisheye, for instance `-vta -vh 180 -vv 180`"));
        }
        let (width, height) = (raster.width(), raster.height());
        let direction = |column, row, offset| raster.sample(column, row, offset).map(|ray| ray.direction);
        // The corners above a row of pixels; those above row `height` are the lower ones of the last.
        let corners = |row: usize| {
            let (row, y) = if row < height { (row, 0.5) } else { (height - 1, -0.5) };
            let right = direction(width - 1, row, DVec2::new(0.5, y));
            (0..width).map(|x| direction(x, row, DVec2::new(-0.5, y))).chain([right]).collect::<Vec<_>>()
        };
        let mut pixels = vec![([0.0; 3], 0.0); raster.len()];
        const ROWS: usize = 16;
        pixels.par_chunks_mut(ROWS * width).enumerate().for_each(|(chunk, pixels)| {
            let mut above = corners(chunk * ROWS);
            for (row, pixels) in (chunk * ROWS..).zip(pixels.chunks_mut(width)) {
                let below = corners(row + 1);
                for (x, pixel) in pixels.iter_mut().enumerate() {
                    let (Some(a), Some(b), Some(c), Some(d)) = (above[x], above[x + 1], below[x + 1], below[x]) else { continue };
                    let Some(centre) = direction(x, row, DVec2::ZERO) else { continue };
                    if centre.dot(camera.direction) >= 0.0 {
                        let solid_angle = triangle_solid_angle(a, b, c) + triangle_solid_angle(a, c, d);
                        *pixel = (centre.to_array(), solid_angle.abs());
                    }
                }
                above = below;
            }
        });
        let frame = ViewFrame::new(camera.view().direction.to_array(), camera.view().up.to_array())?;
        Self::from_pixels(width, height, frame, pixels)
    }

    /// Geometry from directions (unit vectors) and solid angles (sr) of the pixels; a solid angle of
    /// 0 marks a pixel outside the view.
    ///
    /// # Errors
    /// If the numbers do not fit the size, are not finite, or no pixel lies inside the view.
    pub(crate) fn from_pixels(width: usize, height: usize, frame: ViewFrame, pixels: Vec<([f64; 3], f64)>) -> Result<Self> {
        let (directions, mut solid_angles): (Vec<_>, Vec<_>) = pixels.into_iter().unzip();
        if width == 0 || height == 0 || width.checked_mul(height) != Some(directions.len()) {
            return Err(Error::new(format!("{} pixels do not fill a view of {width} × {height}", directions.len())));
        }
        let mut projected_solid_angles = vec![0.0; directions.len()];
        for (i, (d, w)) in directions.iter().zip(&mut solid_angles).enumerate() {
            let cosine = dot(*d, frame.forward);
            if !cosine.is_finite() || !w.is_finite() {
                return Err(Error::new(format!("pixel {} in row {} of the view has no direction", i % width, i / width)));
            }
            if cosine < 0.0 || *w <= 0.0 {
                *w = 0.0;
            } else {
                projected_solid_angles[i] = *w * cosine;
            }
        }
        let total_solid_angle: f64 = solid_angles.iter().sum();
        if total_solid_angle <= 0.0 {
            return Err(
                Error::new("no pixel lies inside the view").help("check the view type and angles: `-vta -vh 180 -vv 180` for a fisheye")
            );
        }
        let total_projected_solid_angle = projected_solid_angles.iter().sum();
        Ok(Self { width, height, frame, directions, solid_angles, projected_solid_angles, total_solid_angle, total_projected_solid_angle })
    }

    /// Number of pixels, those outside the view included.
    pub fn pixel_count(&self) -> usize {
        self.directions.len()
    }

    /// Whether a pixel belongs to the view.
    pub fn is_inside(&self, pixel: usize) -> bool {
        self.solid_angles[pixel] > 0.0
    }

    /// Solid angle of the view, sr.
    pub(crate) fn total_solid_angle(&self) -> f64 {
        self.total_solid_angle
    }

    /// Share of the hemisphere's projected solid angle π the view covers. Below 1 the vertical
    /// illuminance lacks what lies outside.
    pub fn hemisphere_coverage(&self) -> f64 {
        self.total_projected_solid_angle / std::f64::consts::PI
    }

    /// Sums over a luminance image.
    ///
    /// # Errors
    /// If a luminance inside the view is negative or not finite.
    pub fn totals(&self, luminance: &[f32]) -> Result<Totals> {
        let (mut illuminance, mut average) = (0.0, 0.0);
        // Row by row: rounding errors stay small, and no row's sum depends on another's.
        for y in 0..self.height {
            let row = y * self.width..(y + 1) * self.width;
            let (mut e, mut a, mut least) = (0.0, 0.0, 0.0f32);
            for ((&l, &w), &p) in luminance[row.clone()].iter().zip(&self.solid_angles[row.clone()]).zip(&self.projected_solid_angles[row])
            {
                e += f64::from(l) * p;
                a += f64::from(l) * w;
                least = least.min(l);
            }
            if least < 0.0 || !e.is_finite() || !a.is_finite() {
                return Err(Error::new(format!("row {y} of the luminance image has a value that is negative or not finite")));
            }
            illuminance += e;
            average += a;
        }
        Ok(Totals {
            vertical_illuminance: illuminance,
            average_luminance: average / self.total_solid_angle,
            solid_angle: self.total_solid_angle,
        })
    }

    /// Mean luminance of some pixels, weighted by solid angle; 0 for none.
    pub(crate) fn mean_luminance(&self, luminance: &[f32], pixels: &[u32]) -> f64 {
        let (sum, solid_angle) = pixels.iter().fold((0.0, 0.0), |(sum, total), &i| {
            let w = self.solid_angles[i as usize];
            (sum + f64::from(luminance[i as usize]) * w, total + w)
        });
        if solid_angle > 0.0 { sum / solid_angle } else { 0.0 }
    }

    /// Angle between neighbouring pixels near the middle of the view, rad: the larger of the pitches
    /// along rows and columns.
    pub(crate) fn pixel_pitch(&self) -> f64 {
        let (x, y) = (self.width / 2, self.height / 2);
        let middle = y * self.width + x;
        let neighbours = [(x > 0).then(|| middle - 1), (y > 0).then(|| middle - self.width)];
        let pitch = neighbours
            .into_iter()
            .flatten()
            .filter(|&n| self.is_inside(middle) && self.is_inside(n))
            .map(|n| dot(self.directions[middle], self.directions[n]).clamp(-1.0, 1.0).acos())
            .fold(0.0, f64::max);
        if pitch > 0.0 { pitch } else { (self.total_solid_angle / self.pixel_count() as f64).sqrt() }
    }
}

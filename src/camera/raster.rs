//! A camera with a resolution: pixels, samples, solid angles, masks.

use super::{Camera, Ray};
use crate::error::{Error, Result};
use crate::limits::PICTURE_SIDE;
use glam::{DVec2, DVec3};

/// The pixels of a picture: column 0 on the left, row 0 on **top**, as in
/// [`crate::image::Picture`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Raster {
    camera: Camera,
    width: usize,
    height: usize,
}

impl Raster {
    /// A picture of exactly this size; pixels need not be square (`vwrays -pa 0`).
    ///
    /// # Errors
    /// If the size is zero or absurd.
    pub fn new(camera: Camera, width: usize, height: usize) -> Result<Self> {
        if width == 0 || height == 0 || width > PICTURE_SIDE || height > PICTURE_SIDE {
            return Err(Error::new(format!("a picture of {width} × {height} pixels is not possible"))
                .field("-x, -y")
                .help(format!("give sizes between 1 and {PICTURE_SIDE}")));
        }
        Ok(Self { camera, width, height })
    }

    /// The largest picture within `width` × `height` whose pixels have the given height:width
    /// (`-pa`, 1 for square pixels), as `vwrays -d` reports it. An aspect of 0 keeps the size.
    ///
    /// # Errors
    /// If the size is zero or absurd, or nothing is left of it.
    pub fn fit(camera: Camera, width: usize, height: usize, pixel_aspect: f64) -> Result<Self> {
        if !(0.0..=1e6).contains(&pixel_aspect) {
            return Err(Error::new(format!("{pixel_aspect} is no pixel aspect")).field("-pa").help("1 for square pixels, 0 for any"));
        }
        Self::new(camera, width, height)?;
        if pixel_aspect <= super::TINY {
            return Self::new(camera, width, height);
        }
        let aspect = camera.aspect();
        let (w, h) = (width as f64, height as f64);
        // Rounding as Radiance's `normaspect`.
        if aspect * w > pixel_aspect * h {
            Self::new(camera, (h / aspect * pixel_aspect + 0.5) as usize, height)
        } else {
            Self::new(camera, width, (w * aspect / pixel_aspect + 0.5) as usize)
        }
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Pixels per row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Number of pixels.
    #[expect(clippy::len_without_is_empty, reason = "a raster is never empty")]
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// The ray through the centre of a pixel; `None` outside the projection.
    pub fn ray(&self, column: usize, row: usize) -> Option<Ray> {
        self.sample(column, row, DVec2::ZERO)
    }

    /// The ray through a pixel at an offset from its centre in pixels, to the right and upwards;
    /// ±0.5 is the edge. `None` outside the projection.
    pub fn sample(&self, column: usize, row: usize, offset: DVec2) -> Option<Ray> {
        let position = self.position(column as f64 + 0.5 + offset.x, row as f64 + 0.5 - offset.y);
        self.camera.ray(position.x, position.y)
    }

    /// Image position of a place measured in pixels from the upper left corner.
    fn position(&self, x: f64, y: f64) -> DVec2 {
        DVec2::new(x / self.width as f64, 1.0 - y / self.height as f64)
    }

    /// Column and row of the pixel that shows a direction; `None` outside the picture.
    pub fn pixel_of(&self, direction: DVec3) -> Option<(usize, usize)> {
        let position = self.camera.locate(direction)?;
        let (x, y) = (position.x * self.width as f64, (1.0 - position.y) * self.height as f64);
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then_some((x as usize, y as usize))
    }

    /// Exact solid angle of a pixel bounded by great circles through its corners, sr. 0 if a corner
    /// is outside the projection, as `evalglare` has it.
    pub fn solid_angle(&self, column: usize, row: usize) -> f64 {
        let corner = |dx: f64, dy: f64| self.sample(column, row, DVec2::new(dx, dy)).map(|r| r.direction);
        let corners = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return 0.0 };
        (triangle_solid_angle(a, b, c) + triangle_solid_angle(a, c, d)).abs()
    }

    /// Solid angles of all pixels ([`Self::solid_angle`]), in the order of a picture. Shared corners
    /// are computed once.
    pub fn solid_angles(&self) -> Vec<f64> {
        let corner_row = |y: usize| -> Vec<Option<DVec3>> {
            (0..=self.width)
                .map(|x| {
                    let p = self.position(x as f64, y as f64);
                    self.camera.ray(p.x, p.y).map(|r| r.direction)
                })
                .collect()
        };
        let mut angles = Vec::with_capacity(self.len());
        let mut above = corner_row(0);
        for y in 0..self.height {
            let below = corner_row(y + 1);
            angles.extend((0..self.width).map(|x| match [below[x], below[x + 1], above[x + 1], above[x]] {
                [Some(a), Some(b), Some(c), Some(d)] => (triangle_solid_angle(a, b, c) + triangle_solid_angle(a, c, d)).abs(),
                _ => 0.0,
            }));
            above = below;
        }
        angles
    }

    /// Solid angle of a pixel from the projection's density at its centre, sr.
    pub(crate) fn plain_solid_angle(&self, column: usize, row: usize) -> f64 {
        let position = self.position(column as f64 + 0.5, row as f64 + 0.5);
        self.camera.solid_angle_density(position.x, position.y) / self.len() as f64
    }

    /// Whether a pixel needs to be computed: its centre is inside the projection and, in a whole
    /// fisheye (of 180° or more, neither shifted nor lifted), within the circle of half the larger
    /// angle. `vwrays` knows only the first rule: it sends rays into the corners of an angular or
    /// planispheric fisheye, which `evalglare` then ignores.
    pub fn is_seen(&self, column: usize, row: usize) -> bool {
        let Some(ray) = self.ray(column, row) else { return false };
        let view = self.camera.view();
        let angle = view.horizontal.max(view.vertical);
        if !view.projection.is_fisheye() || angle < 180.0 - super::TINY || view.shift != 0.0 || view.lift != 0.0 {
            return true;
        }
        // By the angle, not its cosine, so that 360° means everything.
        ray.direction.angle_between(self.camera.direction) <= (angle / 2.0).to_radians() + 1e-9
    }

    /// [`Self::is_seen`] of all pixels, in the order of a picture.
    pub fn mask(&self) -> Vec<bool> {
        (0..self.len()).map(|i| self.is_seen(i % self.width, i / self.width)).collect()
    }
}

/// Solid angle of a spherical triangle, signed: positive if the corners run counter-clockwise seen
/// from outside (Van Oosterom and Strackee 1983; exact and stable for the smallest pixels).
pub(crate) fn triangle_solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    // Differences keep the digits that the triple product of nearly equal vectors would lose.
    let numerator = a.dot((b - a).cross(c - a));
    2.0 * numerator.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Offsets of the samples within each pixel (`vwrays -c count -pj jitter`), in pixels from the
/// centre: deterministic and evenly spread (the first two dimensions of Sobol's sequence, a
/// (0, 2)-sequence in base 2, with its digits scrambled by a hash of the pixel).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PixelSamples {
    count: usize,
    jitter: f64,
    seed: u64,
}

impl PixelSamples {
    /// `count` samples per pixel over `jitter` of its width (0: all through the centre; 1: all over
    /// the pixel).
    ///
    /// # Errors
    /// If the count is zero or the jitter not within 0…1.
    pub fn new(count: usize, jitter: f64, seed: u64) -> Result<Self> {
        if count == 0 {
            return Err(Error::new("a pixel needs at least one sample").field("-c"));
        }
        if !(0.0..=1.0).contains(&jitter) {
            return Err(Error::new(format!("a pixel jitter of {jitter} is not between 0 and 1")).field("-pj"));
        }
        Ok(Self { count, jitter, seed })
    }

    /// Offset of a sample, to the right and upwards, within ±jitter/2.
    pub fn offset(&self, pixel: usize, sample: usize) -> DVec2 {
        let bits = hash(self.seed ^ hash(pixel as u64));
        let x = (sample as u32).reverse_bits() ^ (bits >> 32) as u32;
        let mut y = bits as u32;
        let mut column = 1u32 << 31;
        let mut rest = sample as u32;
        while rest != 0 {
            if rest & 1 == 1 {
                y ^= column;
            }
            column ^= column >> 1;
            rest >>= 1;
        }
        // The middle of the finest cell, so that the mean has no bias.
        let place = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / 4_294_967_296.0;
        (place - 0.5) * self.jitter
    }
}

/// Finaliser of SplitMix64.
fn hash(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

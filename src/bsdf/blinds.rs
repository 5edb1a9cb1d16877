//! Parametric venetian blinds: the geometry of one period.

use crate::error::{Error, Result};
use glam::DVec3;

/// Horizontal slats, all lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Venetian {
    /// Width of a slat along its chord.
    pub width: f64,
    /// Vertical distance of neighbouring slats.
    pub spacing: f64,
    /// Tilt in degrees, -90 to 90; 0 is horizontal. Positive angles lower the outer edge and raise
    /// the inner one, so that somebody in the room sees the ground and no sky (WINDOW).
    pub angle: f64,
    /// Height of the slat's arc over its chord, upwards; 0 is flat.
    pub rise: f64,
    /// Thickness; 0 is a sheet.
    pub thickness: f64,
}

/// Facets of a curved slat: its normals depart from the arc's by less than 1/16 of its opening.
const FACETS: usize = 16;
/// Length of the period along the slats, in slat widths or spacings: long, because light that travels
/// along the slats crosses it again and again.
const PERIOD_LENGTH: f64 = 8.0;

/// One period of a shade, at z ≤ 0 with the room at +z, repeating along x and y.
#[derive(Debug, Clone, PartialEq)]
pub struct Period {
    /// Surfaces; on closed bodies the front sides are outside.
    pub triangles: Vec<[DVec3; 3]>,
    /// Corner of the box with the lowest coordinates.
    pub low: DVec3,
    /// Corner of the box with the highest coordinates.
    pub high: DVec3,
}

impl Venetian {
    /// The geometry of one slat and its period.
    ///
    /// # Errors
    /// If a length is not positive or not finite, the arc is more than a half circle, or neighbouring
    /// slats would cut each other.
    pub fn period(&self) -> Result<Period> {
        self.check()?;
        let outline = self.outline();
        let top = outline.iter().map(|p| p[0]).fold(f64::MIN, f64::max);
        let bottom = outline.iter().map(|p| p[0]).fold(f64::MAX, f64::min);
        let length = PERIOD_LENGTH * self.width.max(self.spacing);
        let middle = self.spacing / 2.0;
        let at = |x: f64, [z, y]: [f64; 2]| DVec3::new(x, y + middle, z - top);
        let closed = self.thickness > 0.0;
        let edges = if closed { outline.len() } else { outline.len() - 1 };
        let mut triangles = Vec::with_capacity(2 * edges);
        for i in 0..edges {
            let (p, q) = (outline[i], outline[(i + 1) % outline.len()]);
            let [a, b, c, d] = [at(0.0, p), at(length, p), at(length, q), at(0.0, q)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let (low, high) = (DVec3::new(0.0, 0.0, bottom - top), DVec3::new(length, self.spacing, 0.0));
        Ok(Period { triangles, low, high })
    }

    /// The cross-section as (z, y): a line along the slat, or a closed outline that runs along its
    /// upper side to the outside and back below, so that its right side is outside.
    fn outline(&self) -> Vec<[f64; 2]> {
        let facets = if self.rise == 0.0 { 1 } else { FACETS };
        let (sin, cos) = self.angle.to_radians().sin_cos();
        let half = self.width / 2.0;
        // Radius and opening of the arc.
        let radius = if self.rise == 0.0 { 0.0 } else { (half * half + self.rise * self.rise) / (2.0 * self.rise) };
        let opening = if self.rise == 0.0 { 0.0 } else { 2.0 * (self.rise.abs()).atan2(half) * 2.0 };
        let point = |k: usize, offset: f64| {
            let t = k as f64 / facets as f64 * 2.0 - 1.0;
            let (u, v) = if self.rise == 0.0 {
                (half * t, offset)
            } else {
                let a = t * opening / 2.0;
                let up = self.rise.signum();
                let r = radius.abs() + up * offset;
                (r * a.sin(), up * (r * a.cos() - radius.abs() + self.rise.abs()))
            };
            [u * cos - v * sin, u * sin + v * cos]
        };
        if self.thickness == 0.0 {
            return (0..=facets).rev().map(|k| point(k, 0.0)).collect();
        }
        let upper = (0..=facets).rev().map(|k| point(k, self.thickness / 2.0));
        let lower = (0..=facets).map(|k| point(k, -self.thickness / 2.0));
        upper.chain(lower).collect()
    }

    fn check(&self) -> Result<()> {
        let fault = |field: &str, message: String| Err(Error::new(message).field(field));
        for (name, value) in [("width", self.width), ("spacing", self.spacing)] {
            if !(value > 1e-6 && value < 1e3) {
                return fault(name, format!("{value} m is no length of a slat"))
                    .map_err(|e| e.help("give a length with its unit, for instance 25mm"));
            }
        }
        if !(self.angle.abs() <= 90.0) {
            return fault("angle", format!("{}° is not between -90 and 90", self.angle));
        }
        if !(self.rise.abs() <= self.width / 2.0) {
            return fault("rise", format!("an arc of {} m over a chord of {} m is more than a half circle", self.rise, self.width));
        }
        if !(self.thickness >= 0.0 && self.thickness < self.width / 4.0) {
            return fault("thickness", format!("{} m is no thickness of a slat {} m wide", self.thickness, self.width));
        }
        if self.thickness > 0.0 && self.thickness < 1e-5 {
            return fault("thickness", format!("{} m is less than the tracer can resolve", self.thickness))
                .map_err(|e| e.help("leave it out: the slat is then a sheet"));
        }
        if self.thickness / 2.0 + self.rise.abs() > 0.0 && self.rise != 0.0 {
            let radius = (self.width * self.width / 4.0 + self.rise * self.rise) / (2.0 * self.rise.abs());
            if self.thickness / 2.0 >= radius {
                return fault("thickness", "the slat is thicker than the radius of its arc".into());
            }
        }
        if self.cut_each_other() {
            return fault(
                "angle",
                format!("slats {} m wide, {} m apart and tilted by {}° touch or cut each other", self.width, self.spacing, self.angle),
            )
            .map_err(|e| e.help("tilt them less, or increase the spacing"));
        }
        Ok(())
    }

    /// Whether a slat meets its upper neighbour, the same outline a spacing higher.
    fn cut_each_other(&self) -> bool {
        let outline = self.outline();
        let n = outline.len();
        let edges = if self.thickness > 0.0 { n } else { n - 1 };
        let segment = |i: usize, up: f64| [outline[i], outline[(i + 1) % n]].map(|[z, y]| [z, y + up]);
        let side = |[p, q]: [[f64; 2]; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let eps = 1e-9 * self.width * self.width;
        (0..edges).any(|i| {
            (0..edges).any(|j| {
                let (s, t) = (segment(i, 0.0), segment(j, self.spacing));
                let (a, b, c, d) = (side(s, t[0]), side(s, t[1]), side(t, s[0]), side(t, s[1]));
                // Collinear ones overlap if their heights do.
                let heights = |s: [[f64; 2]; 2]| (s[0][1].min(s[1][1]), s[0][1].max(s[1][1]));
                let ((s0, s1), (t0, t1)) = (heights(s), heights(t));
                let collinear = [a, b, c, d].iter().all(|v| v.abs() <= eps);
                let touching = s0 <= t1 && t0 <= s1;
                if collinear { touching } else { a * b < 0.0 && c * d < 0.0 }
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLIND: Venetian = Venetian { width: 0.025, spacing: 0.02, angle: 20.0, rise: 0.0, thickness: 0.0 };

    fn area(p: &Period) -> f64 {
        p.triangles.iter().map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
    }

    #[test]
    fn slats_have_their_width_and_lie_behind_zero() {
        let flat = BLIND.period().unwrap();
        let length = flat.high.x;
        assert!((area(&flat) / length - 0.025).abs() < 1e-12);
        assert_eq!((flat.high.y, flat.high.z), (0.02, 0.0));
        assert!((flat.low.z + 0.025 * 20f64.to_radians().cos()).abs() < 1e-12);
        // The inner edge is the higher one.
        let inner = flat.triangles.iter().flatten().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        let outer = flat.triangles.iter().flatten().min_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        assert!(inner.y > outer.y);
        let sheet = Venetian { rise: 0.003, ..BLIND }.period().unwrap();
        // Length of an arc: radius times opening.
        let radius: f64 = (0.0125f64.powi(2) + 0.003f64.powi(2)) / 0.006;
        let arc = 2.0 * radius * (0.0125 / radius).asin();
        assert!((area(&sheet) / length - arc).abs() < 1e-3 * arc);
    }

    #[test]
    fn thick_slats_are_closed_and_face_outwards() {
        for rise in [0.0, 0.003, -0.003] {
            let slat = Venetian { rise, thickness: 0.001, ..BLIND }.period().unwrap();
            let length = slat.high.x;
            // Volume by the divergence theorem, without the open ends: in the cross-section.
            let flux: f64 = slat
                .triangles
                .iter()
                .map(|[a, b, c]| {
                    let n = (*b - *a).cross(*c - *a) / 2.0;
                    let m = (*a + *b + *c) / 3.0;
                    (n.y * m.y + n.z * m.z) / 2.0
                })
                .sum();
            let expected = 0.025 * 0.001 * length;
            assert!((flux / expected - 1.0).abs() < 0.05, "{rise}: {flux} {expected}");
        }
    }

    #[test]
    fn impossible_slats_are_refused_by_field() {
        let cases = [
            (Venetian { width: 0.0, ..BLIND }, "width"),
            (Venetian { spacing: f64::NAN, ..BLIND }, "spacing"),
            (Venetian { angle: 91.0, ..BLIND }, "angle"),
            (Venetian { angle: 90.0, ..BLIND }, "angle"),
            (Venetian { rise: 0.02, ..BLIND }, "rise"),
            (Venetian { thickness: 0.01, ..BLIND }, "thickness"),
            (Venetian { thickness: 1e-7, ..BLIND }, "thickness"),
        ];
        for (blind, field) in cases {
            let error = blind.period().unwrap_err().to_string();
            assert!(error.starts_with(&format!("{field}:")), "{error}");
        }
        assert!(Venetian { angle: 90.0, spacing: 0.03, ..BLIND }.period().is_ok(), "closed, but not touching");
    }
}

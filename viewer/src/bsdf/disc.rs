//! A hemisphere of directions as a disc: projections, patches, pictures.

use eframe::egui::{Color32, ColorImage, Pos2, vec2};
use glam::DVec3;
use lucarne::bins::AngleBasis;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2, TAU};

/// How the angle to the normal becomes a distance from the centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    /// ∝ θ: rings of equal width.
    Equidistant,
    /// ∝ sin θ: areas are projected solid angles.
    Orthographic,
    /// ∝ tan(θ/2): shapes are kept.
    Stereographic,
    /// ∝ sin(θ/2): areas are solid angles (Lambert).
    EqualArea,
}

impl Projection {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Equidistant, Self::Orthographic, Self::Stereographic, Self::EqualArea];

    /// Name, and what the projection keeps.
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Equidistant => ("Equidistant", "Distance from the centre is proportional to θ"),
            Self::Orthographic => ("Orthographic", "Areas are projected solid angles: what counts for flux"),
            Self::Stereographic => ("Stereographic", "Shapes and angles are kept"),
            Self::EqualArea => ("Equal area", "Areas are solid angles"),
        }
    }

    /// Distance from the centre, 0…1, of an angle 0…π/2.
    pub fn radius(self, theta: f64) -> f64 {
        match self {
            Self::Equidistant => theta / FRAC_PI_2,
            Self::Orthographic => theta.sin(),
            Self::Stereographic => (theta / 2.0).tan(),
            Self::EqualArea => SQRT_2 * (theta / 2.0).sin(),
        }
    }

    /// The angle at a distance 0…1.
    pub fn theta(self, radius: f64) -> f64 {
        let r = radius.clamp(0.0, 1.0);
        match self {
            Self::Equidistant => r * FRAC_PI_2,
            Self::Orthographic => r.asin(),
            Self::Stereographic => 2.0 * r.atan(),
            Self::EqualArea => 2.0 * (r / SQRT_2).asin(),
        }
        .min(2.0 * FRAC_PI_4)
    }
}

/// A disc on the screen.
#[derive(Debug, Clone, Copy)]
pub struct Disc {
    /// Its centre.
    pub center: Pos2,
    /// Its radius, points.
    pub radius: f32,
    /// Its projection.
    pub projection: Projection,
}

impl Disc {
    /// Place of a direction given as θ, φ in degrees; φ counter-clockwise from the right.
    pub fn place(&self, theta: f64, phi: f64) -> Pos2 {
        let r = self.projection.radius(theta.to_radians()) as f32 * self.radius;
        let phi = phi.to_radians() as f32;
        self.center + vec2(r * phi.cos(), -r * phi.sin())
    }

    /// θ, φ in degrees at a place, if it is on the disc.
    pub fn angles(&self, at: Pos2) -> Option<[f64; 2]> {
        let d = (at - self.center) / self.radius;
        let r = f64::from(d.length());
        (r <= 1.0).then(|| [self.projection.theta(r).to_degrees(), f64::from(-d.y).atan2(f64::from(d.x)).to_degrees().rem_euclid(360.0)])
    }

    /// Outline of a patch between two θ and two φ, degrees.
    pub fn outline(&self, theta: [f64; 2], phi: [f64; 2]) -> Vec<Pos2> {
        let steps = ((phi[1] - phi[0]).abs() / 3.0).ceil().max(1.0) as usize;
        let arc = |theta: f64, reverse: bool| {
            (0..=steps).map(move |i| {
                let t = i as f64 / steps as f64;
                let t = if reverse { 1.0 - t } else { t };
                self.place(theta, phi[0] + t * (phi[1] - phi[0]))
            })
        };
        let mut points: Vec<Pos2> = arc(theta[1], false).collect();
        if theta[0] > 0.0 {
            points.extend(arc(theta[0], true));
        } else if phi[1] - phi[0] < 359.0 {
            points.push(self.center);
        }
        points
    }
}

/// The direction of θ, φ in degrees, in the window's frame.
pub fn direction([theta, phi]: [f64; 2]) -> DVec3 {
    let (sin, cos) = theta.to_radians().sin_cos();
    let (y, x) = phi.to_radians().sin_cos();
    DVec3::new(sin * x, sin * y, cos)
}

/// θ, φ in degrees of a direction.
pub fn angles_of(d: DVec3) -> [f64; 2] {
    [d.z.abs().min(1.0).acos().to_degrees(), d.y.atan2(d.x).to_degrees().rem_euclid(360.0)]
}

/// Limits of a patch of a basis, degrees: θ and φ.
pub fn limits(basis: &AngleBasis, bin: usize) -> ([f64; 2], [f64; 2]) {
    let (ring, position) = basis.ring_of(bin);
    let width = 360.0 / ring.bins as f64;
    let from = (position as f64 - 0.5) * width;
    ([ring.theta_min, ring.theta_max], [from, from + width])
}

/// Middle of a patch, θ and φ in degrees; the pole cap's is the normal.
pub fn middle(basis: &AngleBasis, bin: usize) -> [f64; 2] {
    let (theta, phi) = limits(basis, bin);
    if theta[0] == 0.0 && phi[1] - phi[0] > 359.0 {
        [0.0, 0.0]
    } else {
        [(theta[0] + theta[1]) / 2.0, ((phi[0] + phi[1]) / 2.0).rem_euclid(360.0)]
    }
}

/// A disc's picture of `size` pixels: `color` of every direction, transparent outside.
pub fn disc_image(size: usize, projection: Projection, color: impl Fn(DVec3) -> Color32 + Sync) -> ColorImage {
    let mut pixels = vec![Color32::TRANSPARENT; size * size];
    let half = size as f64 / 2.0;
    pixels.par_chunks_mut(size).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let (u, v) = ((x as f64 + 0.5 - half) / half, (half - y as f64 - 0.5) / half);
            let r = u.hypot(v);
            let edge = ((1.0 - r) * half + 0.5).clamp(0.0, 1.0);
            if edge > 0.0 {
                let theta = projection.theta(r);
                let (sin, cos) = theta.sin_cos();
                let d = if r > 0.0 { DVec3::new(sin * u / r, sin * v / r, cos) } else { DVec3::Z };
                *pixel = color(d).gamma_multiply(edge as f32);
            }
        }
    });
    ColorImage::new([size, size], pixels)
}

/// Evenly spread directions of the unit circle for rims and grids: φ in degrees.
pub fn full_circle(steps: usize) -> impl Iterator<Item = f64> {
    (0..=steps).map(move |i| (TAU * i as f64 / steps as f64).to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::pos2;
    use lucarne::bins::KlemsBasis;

    #[test]
    fn projections_are_inverted_by_the_pointer_and_end_at_the_rim() {
        for projection in Projection::ALL {
            assert!((projection.radius(FRAC_PI_2) - 1.0).abs() < 1e-12 && projection.radius(0.0) == 0.0, "{projection:?}");
            let disc = Disc { center: pos2(300.0, 200.0), radius: 150.0, projection };
            for (theta, phi) in [(12.0, 33.0), (47.0, 271.0), (80.0, 150.0)] {
                let [t, p] = disc.angles(disc.place(theta, phi)).unwrap();
                assert!((t - theta).abs() < 0.02 && (p - phi).abs() < 0.02, "{projection:?} {t} {p}");
            }
            assert!(disc.angles(pos2(300.0, 351.0)).is_none());
        }
        // Above the centre is φ 90: up for somebody inside who looks out.
        let disc = Disc { center: pos2(0.0, 0.0), radius: 1.0, projection: Projection::Equidistant };
        assert_eq!(disc.angles(pos2(0.0, -0.5)).unwrap(), [45.0, 90.0]);
    }

    #[test]
    fn areas_are_what_the_projection_promises() {
        let area = |p: Projection, a: f64, b: f64| p.radius(b).powi(2) - p.radius(a).powi(2);
        let ratio = |p| area(p, 0.2, 0.3) / area(p, 1.2, 1.3);
        let solid = (0.2f64.cos() - 0.3f64.cos()) / (1.2f64.cos() - 1.3f64.cos());
        assert!((ratio(Projection::EqualArea) - solid).abs() < 1e-12);
        let projected = (0.3f64.sin().powi(2) - 0.2f64.sin().powi(2)) / (1.3f64.sin().powi(2) - 1.2f64.sin().powi(2));
        assert!((ratio(Projection::Orthographic) - projected).abs() < 1e-12);
    }

    #[test]
    fn the_middle_of_every_patch_lies_in_it() {
        for basis in KlemsBasis::ALL.map(AngleBasis::from) {
            for bin in 0..basis.len() {
                assert_eq!(basis.bin_of(direction(middle(&basis, bin))), bin);
                let [theta, _] = angles_of(direction(middle(&basis, bin)));
                assert!((theta - middle(&basis, bin)[0]).abs() < 1e-9);
            }
        }
    }
}

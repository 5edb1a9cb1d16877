//! Scattering between measured incident directions: lobes that move.
//!
//! After Ward, Kurt and Bonneel, "A practical framework for sharing and rendering real-world bidirectional scattering
//! distribution functions" (LBNL-5954E, 2012; EGSR 2014 "Reducing anisotropic BSDF measurement to common practice"):
//!
//! 1. What is scattered of one incident direction becomes a sum of Gaussian lobes on the sphere ([`fit`](fit()));
//!    a lobe of radius σ, direction c is `exp((c·ω − 1)/σ²)`, its sum a DSF (BSDF · cos θ).
//! 2. Incident directions are joined by a spherical Delaunay mesh; where the sample has a symmetry, mirror images of
//!    measured directions fill the rest.
//! 3. Along every edge of the mesh mass transport says which lobes become which, so that a peak **moves** from one
//!    measured direction to the next in place of fading here and appearing there.
//!
//! Where this differs from the paper: after the first guess the lobes are sharpened until their sum meets the samples
//! (Richardson-Lucy), and transport is unbalanced (Chizat et al. 2018) and kept as one target per lobe, the mean of
//! where its mass goes. So a distribution between three measured ones has as many lobes as these together, its energy is
//! linear between theirs, and a peak may grow along an edge without taking mass from what surrounds it.
//!
//! Beyond the last measured polar angle the distribution of the nearest measured direction stands in; lobes near the
//! direct direction (that of a mirror, in reflection) move on with it.

mod file;
mod fit;
mod lobes;
mod mesh;
mod output;
mod transport;

pub use file::{is_interpolant, read, read_from, write, write_to};
pub use fit::{FitOptions, fit};
pub use output::{Peak, peak, to_klems, to_tree};

use super::Component;
use crate::error::{Error, Result};
use glam::DVec3;
use mesh::Mesh;
use std::f64::consts::TAU;

/// A Gaussian lobe on the sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// Where its middle is; z ≥ 0.
    pub direction: DVec3,
    /// Radius σ, radians.
    pub radius: f64,
    /// Share of the incident light that it scatters above the sample's plane.
    pub mass: f64,
}

impl Lobe {
    /// The largest DSF, 1/sr: the mass over the lobe's solid angle above the plane.
    pub fn amplitude(&self) -> f64 {
        self.mass / (TAU * self.radius * self.radius * above(self.direction.z / self.radius))
    }
}

/// Share of a Gaussian above a plane that is so many standard deviations below its middle.
fn above(distance: f64) -> f64 {
    0.5 * libm::erfc(-distance.max(-2.0) / std::f64::consts::SQRT_2)
}

/// What is scattered of one incident direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Where the light travels; z > 0.
    pub incident: DVec3,
    /// The lobes.
    pub lobes: Vec<Lobe>,
}

/// In what the sample looks the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symmetry {
    /// Turned by any angle.
    Isotropic,
    /// In a mirror, left-right and up-down.
    Quadrilateral,
    /// In one mirror; the other half is the measured one.
    Bilateral,
    /// Turned by 180°.
    Up,
    /// In nothing.
    Anisotropic,
}

impl Symmetry {
    /// By its name or the beginning of it, in any case.
    ///
    /// # Errors
    /// If no symmetry begins like this.
    pub fn by_name(name: &str) -> Result<Self> {
        let lower = name.to_ascii_lowercase();
        let all = [Self::Isotropic, Self::Quadrilateral, Self::Bilateral, Self::Up, Self::Anisotropic];
        all.into_iter().find(|s| !lower.is_empty() && s.name().starts_with(&lower)).ok_or_else(|| {
            Error::new(format!("'{name}' is no symmetry")).help("isotropic, quadrilateral, bilateral, up and anisotropic are known")
        })
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::Quadrilateral => "quadrilateral",
            Self::Bilateral => "bilateral",
            Self::Up => "up",
            Self::Anisotropic => "anisotropic",
        }
    }
}

/// Mirrors x.
pub(crate) const MIRROR_X: u8 = 1;
/// Mirrors y.
pub(crate) const MIRROR_Y: u8 = 2;

/// A direction in the mirrors of the bits.
pub(crate) fn mirrored(d: DVec3, bits: u8) -> DVec3 {
    let sign = |bit: u8| if bits & bit != 0 { -1.0 } else { 1.0 };
    DVec3::new(sign(MIRROR_X) * d.x, sign(MIRROR_Y) * d.y, d.z)
}

/// Where a lobe goes along an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Target {
    pub direction: DVec3,
    pub radius: f64,
}

/// Transport between a distribution and a mirror image of another (or itself).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edge {
    pub first: usize,
    pub second: usize,
    /// Mirrors of the second.
    pub mirror: u8,
    /// Per lobe of the first.
    pub forward: Vec<Target>,
    /// Per lobe of the second, as mirrored.
    pub backward: Vec<Target>,
    /// The plan (lobe of the first, of the second, share of all mass), without what is negligible; kept for Radiance's
    /// part of the file only.
    pub plan: Vec<(u32, u32, f32)>,
}

/// Scattering of one component of a sample, for any two directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolant {
    /// The sample's name, empty if unknown.
    pub name: String,
    /// Who makes it, empty if unknown.
    pub manufacturer: String,
    /// From which side to which.
    pub component: Component,
    /// In what it looks the same.
    pub symmetry: Symmetry,
    /// What was measured.
    pub distributions: Vec<Distribution>,
    /// Lines of text about how it was made.
    pub notes: Vec<String>,
    pub(crate) mesh: Mesh,
    pub(crate) edges: Vec<Edge>,
}

/// Below this cosine a DSF is divided by it in place of the true one, so that a BSDF stays finite.
pub(crate) const LEAST_COSINE: f64 = 0.02;
/// Lobes end where they have fallen to exp(−CUT²/2).
pub(crate) const CUT: f64 = 3.7;

impl Interpolant {
    /// The lobes of light that travels along `incident` (a unit vector; only x and y count).
    pub fn at(&self, incident: DVec3) -> Vec<Lobe> {
        let incident = DVec3::new(incident.x, incident.y, incident.z.abs());
        if !self.mesh.is_chain() {
            return self.between(incident);
        }
        // Turned so that the light travels along +x, and back.
        let sin = incident.x.hypot(incident.y);
        let (c, s) = if sin > 1e-9 { (incident.x / sin, incident.y / sin) } else { (1.0, 0.0) };
        let mut lobes = self.between(DVec3::new(sin, 0.0, incident.z));
        for lobe in &mut lobes {
            let d = lobe.direction;
            lobe.direction = DVec3::new(c * d.x - s * d.y, s * d.x + c * d.y, d.z);
        }
        lobes
    }

    fn between(&self, incident: DVec3) -> Vec<Lobe> {
        let place = self.mesh.locate(incident);
        let mut found = Vec::new();
        let corners: Vec<(mesh::Vertex, f64)> =
            place.corners.iter().map(|(v, w)| (self.mesh.vertices()[*v], *w)).filter(|c| c.1 > 1e-9).collect();
        for (k, (vertex, weight)) in corners.iter().enumerate() {
            let others: Vec<(&[Target], u8, f64)> = corners
                .iter()
                .enumerate()
                .filter(|(o, _)| *o != k)
                .filter_map(|(_, (other, w))| self.targets(*vertex, *other).map(|(t, m)| (t, m, *w)))
                .collect();
            for (i, lobe) in self.distributions[vertex.distribution].lobes.iter().enumerate() {
                let mut direction = *weight * mirrored(lobe.direction, vertex.mirror);
                let mut square = *weight * lobe.radius * lobe.radius;
                for (targets, mirror, w) in &others {
                    direction += *w * mirrored(targets[i].direction, *mirror);
                    square += *w * targets[i].radius * targets[i].radius;
                }
                found.push(Lobe { direction: upper(direction), radius: square.sqrt(), mass: lobe.mass * weight });
            }
        }
        if let Some(from) = place.beyond {
            // The direct direction is the incident one in both senses: only x and y count.
            const NEAR: f64 = 0.2;
            for lobe in &mut found {
                let away = (lobe.direction - from).length_squared() / (NEAR * NEAR);
                let share = (-0.5 * away).exp() * (NEAR / lobe.radius.max(NEAR)).powi(2);
                lobe.direction = upper(lobe.direction + share * (incident - from));
            }
        }
        found
    }

    /// Per lobe of a vertex's distribution its target at another one, to be mirrored by the bits.
    fn targets(&self, vertex: mesh::Vertex, other: mesh::Vertex) -> Option<(&[Target], u8)> {
        let mirror = vertex.mirror ^ other.mirror;
        let (first, second) = (vertex.distribution.min(other.distribution), vertex.distribution.max(other.distribution));
        let edge = &self.edges[self.edges.binary_search_by_key(&(first, second, mirror), |e| (e.first, e.second, e.mirror)).ok()?];
        // Between a distribution and its own image either end may be the first.
        let is_first = if first == second { vertex.mirror < other.mirror } else { vertex.distribution == first };
        Some(if is_first { (&edge.forward, vertex.mirror) } else { (&edge.backward, other.mirror) })
    }

    /// The BSDF in 1/sr for light that travels along `incident` and leaves along `outgoing`.
    pub fn evaluate(&self, outgoing: DVec3, incident: DVec3) -> f64 {
        let out = DVec3::new(outgoing.x, outgoing.y, outgoing.z.abs());
        dsf(&self.at(incident), out) / out.z.max(LEAST_COSINE)
    }

    /// Direct-hemispherical value of light that travels along `incident`.
    pub fn direct_hemispherical(&self, incident: DVec3) -> f64 {
        self.at(incident).iter().map(|l| l.mass).sum()
    }

    /// The largest polar angle of a measured incident direction, degrees.
    pub fn last_theta(&self) -> f64 {
        self.distributions.iter().map(|d| d.incident.z.clamp(0.0, 1.0).acos().to_degrees()).fold(0.0, f64::max)
    }

    /// Number of lobes of all measured directions.
    pub fn lobes(&self) -> usize {
        self.distributions.iter().map(|d| d.lobes.len()).sum()
    }
}

/// The sum of lobes, 1/sr.
pub(crate) fn dsf(lobes: &[Lobe], outgoing: DVec3) -> f64 {
    lobes
        .iter()
        .map(|l| {
            let exponent = (l.direction.dot(outgoing) - 1.0) / (l.radius * l.radius);
            if exponent < -0.5 * CUT * CUT { 0.0 } else { l.amplitude() * exponent.exp() }
        })
        .sum()
}

/// A unit vector that does not point below the plane.
fn upper(d: DVec3) -> DVec3 {
    DVec3::new(d.x, d.y, d.z.max(0.0)).normalize_or(DVec3::Z)
}

#[cfg(test)]
mod tests;

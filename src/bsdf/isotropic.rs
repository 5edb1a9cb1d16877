//! BSDF of isotropic materials (glass, films, diffusing panes) from measured direct and diffuse
//! values over the angle of incidence, as Radiance's `iso2klems` makes it.
//!
//! The specular part of a bin lies on the diagonal: f = Ts/Λ. The diffuse part is separable,
//! f = Td(θᵢ) Td(θₒ) / (π Thh) with the hemispherical value Thh, so that it is reciprocal and its
//! direct-hemispherical value is Td(θᵢ) exactly. Every ring receives the mean of the table over
//! the ring, weighted by projected solid angle, so that hemispherical values are those of the table.

use super::{Block, Blocks, KlemsMatrix, projected_solid_angles};
use crate::bins::AngleBasis;
use crate::error::{Error, Result, Warnings};
use rows::rows;
use std::f64::consts::PI;

mod rows;

/// Specular and diffuse transmittance and reflectance at one angle of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Angle of incidence, degrees from the normal, 0…90.
    pub theta: f64,
    /// Direct-direct transmittance.
    pub specular_transmittance: f64,
    /// Direct-hemispherical transmittance of the scattered part.
    pub diffuse_transmittance: f64,
    /// Mirror reflectance.
    pub specular_reflectance: f64,
    /// Direct-hemispherical reflectance of the scattered part.
    pub diffuse_reflectance: f64,
}

impl Sample {
    fn values(&self) -> [f64; 4] {
        [self.specular_transmittance, self.diffuse_transmittance, self.specular_reflectance, self.diffuse_reflectance]
    }

    fn transmittance(&self) -> f64 {
        self.specular_transmittance + self.diffuse_transmittance
    }

    /// With reflectances that follow those at the normal, where absorptance and diffuse reflectance
    /// are this share of theirs.
    fn reflecting(self, normal: &Self, share: f64) -> Self {
        let absorbed = (1.0 - normal.values().iter().sum::<f64>()) * share;
        let diffuse_reflectance = normal.diffuse_reflectance * share;
        let specular_reflectance = (1.0 - absorbed - self.transmittance() - diffuse_reflectance).max(0.0);
        Self { specular_reflectance, diffuse_reflectance, ..self }
    }
}

/// Values over the angle of incidence for light from either side.
#[derive(Debug, Clone, PartialEq)]
pub struct AngularTable {
    front: Vec<Sample>,
    back: Vec<Sample>,
}

impl AngularTable {
    /// A table from samples of light from the outside (front) and from the room (back), by
    /// ascending angle. An empty back means that both sides are alike.
    ///
    /// # Errors
    /// Values outside 0…1 or that sum to more than 1; angles that do not ascend within 0…90° or
    /// leave out more than the last 30°. Missing ends are completed, with a warning: flat to 0°;
    /// nothing transmitted and all reflected at 90°.
    pub fn new(front: Vec<Sample>, back: Vec<Sample>, warnings: &mut Warnings) -> Result<Self> {
        let front = completed(front, "front", warnings)?;
        let back = if back.is_empty() { front.clone() } else { completed(back, "back", warnings)? };
        Ok(Self { front, back })
    }

    /// Reads a text table: lines of `θ Ts Td Rs Rd`, angles 0…90° for light from the outside and,
    /// if present, 90…180° for light from the room (180° is the normal). `#` starts a comment. A
    /// first line without numbers is a header: columns stand where it names Ts, Td, Rs and Rd.
    /// Warns of a mirror reflectance that is the same at all angles, as dummy values are.
    ///
    /// # Errors
    /// As [`new`](Self::new), with the line; a header that names some of the columns only.
    pub fn parse(text: &str, warnings: &mut Warnings) -> Result<Self> {
        let [front, back] = rows(text, true)?;
        let table = Self::new(front, back, warnings)?;
        let mirror = |s: &Sample| s.specular_reflectance;
        if let [first, .., last] = table.front.as_slice()
            && mirror(first) > 0.0
            && table.front.iter().all(|s| mirror(s) == mirror(first))
            && last.transmittance() < 0.5 * first.transmittance()
        {
            warnings.push(
                Error::new(format!("Rs is {} at all angles, as dummy values are; mirror reflection rises towards 90°", mirror(first)))
                    .help("layers that reflect to each other need real values: give them, at normal incidence at least"),
            );
        }
        Ok(table)
    }

    /// Reads the transmittances of such a table, whose columns Rs and Rd count for nothing and may
    /// be missing, and takes reflectances `[Rs, Rd]` at normal incidence for light from the outside
    /// and from the room; over the angle they follow [`roos`](Self::roos)' rule.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn parse_transmittance(text: &str, front: [f64; 2], back: [f64; 2], warnings: &mut Warnings) -> Result<Self> {
        let [outside, room] = rows(text, false)?;
        let outside = completed(outside, "front", warnings)?;
        let room = if room.is_empty() { outside.clone() } else { completed(room, "back", warnings)? };
        let side = |samples: Vec<Sample>, [rs, rd]: [f64; 2]| -> Result<Vec<Sample>> {
            let normal = Sample { specular_reflectance: rs, diffuse_reflectance: rd, ..samples[0] };
            check(&normal)?;
            let of_normal = |tau: f64| if normal.transmittance() > 0.0 { tau / normal.transmittance() } else { 1.0 };
            let reflecting = |s: &Sample| s.reflecting(&normal, of_normal(s.transmittance()).min(1.0));
            Ok(samples.iter().map(reflecting).collect())
        };
        Self::new(side(outside, front)?, side(room, back)?, warnings)
    }

    /// A table from values at normal incidence by the angular model of Roos et al. 2001 (Solar
    /// Energy 69 suppl. 6, "Angular-dependent optical properties of low-e and solar control
    /// windows"): τ(θ) = τ₀ (1 − a zᵅ − b zᵝ − c zᵞ), z = θ/90°, a = 8, b = 0.25/q, c = 1 − a − b,
    /// α = 5.2 + 0.7 q, β = 2, γ = (5.26 + 0.06 p) + (0.73 + 0.04 p) q, with p panes and the
    /// category q (1…10; 4 for uncoated glass). p = 0 leaves the terms of the panes out, as
    /// published tables of PDLC films do.
    ///
    /// The model says nothing about reflection. Here the absorptance falls like the transmittance,
    /// A(θ) = A₀ τ(θ)/τ₀, the diffuse reflectance too, and mirror reflection takes the rest.
    ///
    /// # Errors
    /// Impossible values, q outside 1…10.
    pub fn roos(front: Sample, back: Sample, panes: u32, category: f64, warnings: &mut Warnings) -> Result<Self> {
        if !(1.0..=10.0).contains(&category) {
            return Err(Error::new(format!("the Roos model needs 1 ≤ q ≤ 10, not q = {category}"))
                .help("p is the number of panes; q is 4 for clear glass, lower or higher for coated glass"));
        }
        let side = |normal: Sample| {
            check(&normal)?;
            let at = |degrees: u32| {
                let (theta, share) = (f64::from(degrees), roos_share(f64::from(degrees), panes, category));
                let [ts, td] = [normal.specular_transmittance, normal.diffuse_transmittance].map(|v| v * share);
                Sample { theta, specular_transmittance: ts, diffuse_transmittance: td, ..normal }.reflecting(&normal, share)
            };
            Ok((0..=90).map(at).collect::<Vec<_>>())
        };
        Self::new(side(front)?, side(back)?, warnings)
    }

    /// The four scattering blocks over a basis.
    ///
    /// Warns if front and back transmittance contradict reciprocity.
    pub fn to_blocks(&self, basis: &AngleBasis, warnings: &mut Warnings) -> Blocks {
        let front = RingMeans::new(&self.front, basis);
        let back = RingMeans::new(&self.back, basis);
        let hemispherical = [&front, &back].map(|side| side.hemispherical(1));
        if (hemispherical[0] - hemispherical[1]).abs() > 1e-3 * hemispherical[0].max(hemispherical[1]) {
            warnings.push(
                Error::new(format!(
                    "diffuse transmittance is {:.4} from the front and {:.4} from the back; the two must be equal by reciprocity",
                    hemispherical[0], hemispherical[1]
                ))
                .help("each side keeps its own values; have the sample measured again"),
            );
        }
        if (0..basis.rings().len()).any(|ring| (front.means[ring][0] - back.means[ring][0]).abs() > 1e-3) {
            warnings.push(
                Error::new("direct transmittance differs between front and back; the two must be equal by reciprocity")
                    .help("each side keeps its own values; have the sample measured again"),
            );
        }
        Blocks {
            transmission_front: Some(Block::Klems(matrix(basis, &front, &back, 0))),
            transmission_back: Some(Block::Klems(matrix(basis, &back, &front, 0))),
            reflection_front: Some(Block::Klems(matrix(basis, &front, &front, 2))),
            reflection_back: Some(Block::Klems(matrix(basis, &back, &back, 2))),
        }
    }
}

/// τ(θ)/τ₀ of the Roos model.
fn roos_share(theta: f64, panes: u32, q: f64) -> f64 {
    let p = f64::from(panes);
    let (a, b) = (8.0, 0.25 / q);
    let c = 1.0 - a - b;
    let (alpha, beta, gamma) = (5.2 + 0.7 * q, 2.0, (5.26 + 0.06 * p) + (0.73 + 0.04 * p) * q);
    let z = theta / 90.0;
    (1.0 - a * z.powf(alpha) - b * z.powf(beta) - c * z.powf(gamma)).clamp(0.0, 1.0)
}

fn check(sample: &Sample) -> Result<()> {
    let values = sample.values();
    let sum: f64 = values.iter().sum();
    if values.iter().any(|v| !(0.0..=1.0).contains(v)) {
        return Err(Error::new(format!("at {}°: transmittance and reflectance must lie within 0…1", sample.theta)));
    }
    if sum > 1.0 + 1e-6 {
        return Err(Error::new(format!("at {}°: transmittance and reflectance sum to {sum:.4}, more than 1", sample.theta)));
    }
    Ok(())
}

fn completed(mut samples: Vec<Sample>, side: &str, warnings: &mut Warnings) -> Result<Vec<Sample>> {
    samples.iter().try_for_each(check)?;
    if samples.windows(2).any(|w| w[0].theta >= w[1].theta) || samples.iter().any(|s| !(0.0..=90.0).contains(&s.theta)) {
        return Err(Error::new(format!("the angles of the {side} side do not ascend within 0…90° from the normal")));
    }
    let (Some(first), Some(last)) = (samples.first().copied(), samples.last().copied()) else {
        return Err(Error::new(format!("the table has no row for light from the {side}")));
    };
    if first.theta > 0.0 {
        if first.theta > 30.0 {
            return Err(Error::new(format!("the {side} side starts at {}°", first.theta)).help("give values for normal incidence (0°)"));
        }
        warnings.push(Error::new(format!("the {side} side starts at {}°; its values are used from 0° on", first.theta)));
        samples.insert(0, Sample { theta: 0.0, ..first });
    }
    if last.theta < 90.0 {
        if last.theta < 60.0 {
            return Err(Error::new(format!("the {side} side ends at {}°", last.theta)).help("give values up to 60° at least"));
        }
        warnings.push(Error::new(format!("the {side} side ends at {}°; at 90° all light is taken as mirrored", last.theta)));
        samples.push(Sample { theta: 90.0, specular_reflectance: 1.0, ..Sample::default() });
    }
    Ok(samples)
}

/// Means of the four columns of a table over the rings of a basis.
struct RingMeans {
    means: Vec<[f64; 4]>,
    shares: Vec<f64>,
}

impl RingMeans {
    fn new(samples: &[Sample], basis: &AngleBasis) -> Self {
        const STEPS: usize = 1024;
        let curves: [Curve; 4] = std::array::from_fn(|k| Curve::new(samples, k));
        let sin2 = |deg: f64| if deg >= 90.0 { 1.0 } else { deg.to_radians().sin().powi(2) };
        let mean = |ring: &crate::bins::Ring| {
            let theta = |step: usize| ring.theta_min + (ring.theta_max - ring.theta_min) * (step as f64 + 0.5) / STEPS as f64;
            let weight = |step: usize| (2.0 * theta(step).to_radians()).sin();
            let total: f64 = (0..STEPS).map(weight).sum();
            std::array::from_fn(|k| (0..STEPS).map(|s| curves[k].at(theta(s)) * weight(s)).sum::<f64>() / total)
        };
        let rings = basis.rings();
        Self { means: rings.iter().map(mean).collect(), shares: rings.iter().map(|r| sin2(r.theta_max) - sin2(r.theta_min)).collect() }
    }

    fn hemispherical(&self, column: usize) -> f64 {
        self.means.iter().zip(&self.shares).map(|(m, s)| m[column] * s).sum()
    }
}

/// Specular column `column` on the diagonal, and the separable diffuse column after it: light comes
/// to the side of `incident` and goes as if it came backwards to the side of `leaving`.
fn matrix(basis: &AngleBasis, incident: &RingMeans, leaving: &RingMeans, column: usize) -> KlemsMatrix {
    let lambda = projected_solid_angles(basis);
    let ring_of: Vec<usize> = (0..basis.len()).map(|b| basis.rings().iter().rposition(|r| r.first <= b).unwrap_or(0)).collect();
    let hemispherical = leaving.hemispherical(column + 1);
    KlemsMatrix::from_fn(basis, |o, i| {
        let scattered = if hemispherical > 0.0 {
            incident.means[ring_of[i]][column + 1] * leaving.means[ring_of[o]][column + 1] / (PI * hemispherical)
        } else {
            // Nothing is known of how it leaves: Lambertian.
            incident.means[ring_of[i]][column + 1] / PI
        };
        scattered + if o == i { incident.means[ring_of[i]][column] / lambda[i] } else { 0.0 }
    })
}

/// Monotone cubic through the samples of one column (Fritsch and Carlson 1980), level at normal
/// incidence because the properties are even functions of the angle.
struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Curve {
    fn new(samples: &[Sample], column: usize) -> Self {
        let x: Vec<f64> = samples.iter().map(|s| s.theta).collect();
        let y: Vec<f64> = samples.iter().map(|s| s.values()[column]).collect();
        let n = x.len();
        let secant: Vec<f64> = (1..n).map(|i| (y[i] - y[i - 1]) / (x[i] - x[i - 1])).collect();
        let mut slope = vec![0.0; n];
        for i in 1..n.saturating_sub(1) {
            let (a, b) = (secant[i - 1], secant[i]);
            // The weighted harmonic mean never overshoots.
            if a * b > 0.0 {
                let (left, right) = (x[i] - x[i - 1], x[i + 1] - x[i]);
                let (w1, w2) = (2.0 * right + left, right + 2.0 * left);
                slope[i] = (w1 + w2) / (w1 / a + w2 / b);
            }
        }
        if n >= 2 {
            slope[n - 1] = secant[n - 2];
        }
        Self { x, y, slope }
    }

    fn at(&self, x: f64) -> f64 {
        let Some(i) = self.x.iter().rposition(|v| *v <= x) else { return self.y[0] };
        if i + 1 >= self.x.len() {
            return self.y[i];
        }
        let width = self.x[i + 1] - self.x[i];
        let t = (x - self.x[i]) / width;
        let (t2, t3) = (t * t, t * t * t);
        (2.0 * t3 - 3.0 * t2 + 1.0) * self.y[i]
            + (t3 - 2.0 * t2 + t) * width * self.slope[i]
            + (3.0 * t2 - 2.0 * t3) * self.y[i + 1]
            + (t3 - t2) * width * self.slope[i + 1]
    }
}

#[cfg(test)]
mod tests;

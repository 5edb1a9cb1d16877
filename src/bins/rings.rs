//! Hemispheres divided into rings of constant polar angle, each cut into equal azimuths: the Klems
//! bases and any basis that a BSDF file defines.
//!
//! Numbering (Klems 1994; Radiance `bsdf_m.c`): bin 0 is the pole cap, rings follow outward; inside
//! a ring the first bin is *centred* on azimuth 0 (local +x) and azimuth runs counter-clockwise
//! towards local +y.
//!
//! **Every bin, incident or outgoing, transmitted or reflected, is indexed by the direction in
//! which light travels**, projected to the surface: straight-through transmission and mirror
//! reflection both lie on the diagonal of a BSDF matrix.

use crate::error::{Error, Result};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// The three named bases of WINDOW and Radiance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum KlemsBasis {
    /// 145 bins.
    Full,
    /// 77 bins (Radiance's table since 2022; older texts say 73).
    Half,
    /// 41 bins.
    Quarter,
}

impl KlemsBasis {
    /// All named bases.
    pub const ALL: [KlemsBasis; 3] = [KlemsBasis::Full, KlemsBasis::Half, KlemsBasis::Quarter];

    /// The name in WINDOW's XML files.
    pub fn xml_name(self) -> &'static str {
        match self {
            KlemsBasis::Full => "LBNL/Klems Full",
            KlemsBasis::Half => "LBNL/Klems Half",
            KlemsBasis::Quarter => "LBNL/Klems Quarter",
        }
    }

    /// Polar limits in degrees, one more than there are rings, and bins per ring.
    fn table(self) -> (&'static [f64], &'static [usize]) {
        match self {
            KlemsBasis::Full => (&[0., 5., 15., 25., 35., 45., 55., 65., 75., 90.], &[1, 8, 16, 20, 24, 24, 24, 16, 12]),
            KlemsBasis::Half => (&[0., 6.5, 19.5, 32.5, 45.5, 58.5, 71.5, 90.], &[1, 8, 12, 16, 20, 12, 8]),
            KlemsBasis::Quarter => (&[0., 9., 27., 45., 63., 90.], &[1, 8, 12, 12, 8]),
        }
    }
}

/// One ring of an [`AngleBasis`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Lower polar limit, degrees.
    pub theta_min: f64,
    /// Upper polar limit, degrees.
    pub theta_max: f64,
    /// Number of azimuthal bins.
    pub bins: usize,
    /// Index of the first bin.
    pub first: usize,
}

/// A hemisphere cut into rings and azimuths.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleBasis {
    name: String,
    rings: Vec<Ring>,
}

impl From<KlemsBasis> for AngleBasis {
    fn from(basis: KlemsBasis) -> Self {
        let (limits, counts) = basis.table();
        Self::from_rings(basis.xml_name(), limits, counts).expect("the built-in tables are sound")
    }
}

impl AngleBasis {
    /// A basis from polar limits (degrees, ascending from 0 to 90, one more than rings) and the
    /// number of bins per ring.
    ///
    /// # Errors
    /// If the limits do not ascend from 0 to 90° or a ring has no bins.
    pub(crate) fn from_rings(name: &str, limits: &[f64], counts: &[usize]) -> Result<Self> {
        let ascending = limits.windows(2).all(|w| w[0] < w[1]);
        let spans = limits.first().is_some_and(|l| l.abs() < 1e-6) && limits.last().is_some_and(|l| (l - 90.0).abs() < 1e-6);
        if counts.is_empty() || limits.len() != counts.len() + 1 || !ascending || !spans || counts.contains(&0) {
            return Err(Error::new(format!(
                "angle basis '{name}' is not a division of the hemisphere: limits {limits:?}°, bins per ring {counts:?}"
            ))
            .help("polar limits must ascend from 0 to 90° and every ring needs at least one bin"));
        }
        let mut first = 0;
        let mut rings = Vec::with_capacity(counts.len());
        for (w, &bins) in limits.windows(2).zip(counts) {
            rings.push(Ring { theta_min: w[0], theta_max: w[1], bins, first });
            first += bins;
        }
        Ok(Self { name: name.to_string(), rings })
    }

    /// The named basis this text means, ignoring case and the spaces or underscores between words.
    pub(crate) fn by_name(name: &str) -> Option<Self> {
        let plain = |s: &str| s.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect::<String>();
        KlemsBasis::ALL.into_iter().find(|b| plain(b.xml_name()) == plain(name)).map(Self::from)
    }

    /// Name as in the XML file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The rings from the pole outward.
    pub fn rings(&self) -> &[Ring] {
        &self.rings
    }

    /// Number of bins.
    #[allow(clippy::len_without_is_empty, reason = "a basis always has bins")]
    pub fn len(&self) -> usize {
        self.rings.last().map_or(0, |r| r.first + r.bins)
    }

    /// Ring and position inside the ring of a bin.
    ///
    /// # Panics
    /// If `bin` is not below [`len`](Self::len).
    pub fn ring_of(&self, bin: usize) -> (&Ring, usize) {
        let ring = self.rings.iter().rev().find(|r| r.first <= bin && bin < r.first + r.bins).expect("bin outside its basis");
        (ring, bin - ring.first)
    }

    /// The bin of light travelling along `direction` (local coordinates, unit length, either side).
    /// A direction exactly on a limit belongs to the outer ring.
    pub fn bin_of(&self, direction: DVec3) -> usize {
        let cos2 = (direction.z * direction.z).min(1.0);
        let ring = self.rings.iter().rev().find(|r| cos2 <= cos_squared(r.theta_min)).unwrap_or(&self.rings[0]);
        if ring.bins == 1 {
            return ring.first;
        }
        let phi = direction.y.atan2(direction.x).rem_euclid(TAU);
        ring.first + (phi / TAU * ring.bins as f64 + 0.5).floor() as usize % ring.bins
    }

    /// Projected solid angle of a bin, sr: π (cos²θ₀ − cos²θ₁) / n. The sum over the basis is π.
    pub fn projected_solid_angle(&self, bin: usize) -> f64 {
        let (ring, _) = self.ring_of(bin);
        PI * (cos_squared(ring.theta_min) - cos_squared(ring.theta_max)) / ring.bins as f64
    }

    /// Solid angle of a bin, sr. The sum over the basis is 2π.
    pub fn solid_angle(&self, bin: usize) -> f64 {
        let (ring, _) = self.ring_of(bin);
        TAU * (ring.theta_min.to_radians().cos() - ring.theta_max.to_radians().cos()) / ring.bins as f64
    }

    /// The direction at fractions `u` (polar, uniform in projected solid angle) and `v` (azimuth)
    /// of a bin, local coordinates, z ≥ 0. Uniform `u`, `v` give a uniform distribution in
    /// *projected* solid angle.
    pub fn direction(&self, bin: usize, u: f64, v: f64) -> DVec3 {
        let (ring, position) = self.ring_of(bin);
        let (c0, c1) = (cos_squared(ring.theta_min), cos_squared(ring.theta_max));
        let cos2 = c0 + u * (c1 - c0);
        let phi = TAU * (position as f64 + v - 0.5) / ring.bins as f64;
        let sin = (1.0 - cos2).max(0.0).sqrt();
        DVec3::new(sin * phi.cos(), sin * phi.sin(), cos2.max(0.0).sqrt())
    }

    /// The centre of a bin: middle azimuth, and half of the projected solid angle on either side.
    /// The pole for bin 0.
    pub fn centre(&self, bin: usize) -> DVec3 {
        if bin == 0 && self.rings[0].bins == 1 { DVec3::Z } else { self.direction(bin, 0.5, 0.5) }
    }

    /// The bin on the other side of the pole: light that travels the same line the other way.
    /// Rings of odd size other than the cap have no exact opposite; the nearest lower is given.
    pub fn opposite(&self, bin: usize) -> usize {
        let (ring, position) = self.ring_of(bin);
        ring.first + (position + ring.bins / 2) % ring.bins
    }
}

fn cos_squared(degrees: f64) -> f64 {
    // Exactly 0 and 1 at the ends, so that no direction falls outside the hemisphere.
    if degrees >= 90.0 { 0.0 } else { degrees.to_radians().cos().powi(2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_follow_from_the_tables() {
        let sizes: Vec<usize> = KlemsBasis::ALL.iter().map(|&b| AngleBasis::from(b).len()).collect();
        assert_eq!(sizes, [145, 77, 41]);
    }

    #[test]
    fn projected_solid_angles_sum_to_pi_and_solid_angles_to_two_pi() {
        for b in KlemsBasis::ALL {
            let basis = AngleBasis::from(b);
            let projected: f64 = (0..basis.len()).map(|i| basis.projected_solid_angle(i)).sum();
            let plain: f64 = (0..basis.len()).map(|i| basis.solid_angle(i)).sum();
            assert!((projected - PI).abs() < 1e-12);
            assert!((plain - TAU).abs() < 1e-12);
        }
        // Klems 1994, table 1 (first and last ring of the full basis).
        let full = AngleBasis::from(KlemsBasis::Full);
        assert!((full.projected_solid_angle(0) - 0.0238639).abs() < 1e-7);
        assert!((full.projected_solid_angle(144) - 0.0175372).abs() < 1e-7);
    }

    #[test]
    fn directions_inside_a_bin_map_back_to_it() {
        for b in KlemsBasis::ALL {
            let basis = AngleBasis::from(b);
            for bin in 0..basis.len() {
                assert_eq!(basis.bin_of(basis.centre(bin)), bin);
                for (u, v) in [(0.01, 0.01), (0.99, 0.01), (0.01, 0.99), (0.99, 0.99), (0.3, 0.7)] {
                    let d = basis.direction(bin, u, v);
                    assert_eq!(basis.bin_of(d), bin, "{b:?} {bin} {u} {v}");
                    assert_eq!(basis.bin_of(DVec3::new(d.x, d.y, -d.z)), bin, "both sides share the index");
                    assert_eq!(basis.bin_of(-d), basis.opposite(bin));
                }
            }
        }
    }

    #[test]
    fn light_travelling_along_plus_x_is_the_first_bin_of_its_ring() {
        let full = AngleBasis::from(KlemsBasis::Full);
        let d = |theta: f64, phi: f64| {
            let (t, p) = (theta.to_radians(), phi.to_radians());
            DVec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos())
        };
        assert_eq!(full.bin_of(d(20.0, 0.0)), 9);
        assert_eq!(full.bin_of(d(20.0, 180.0)), 17);
        assert_eq!(full.bin_of(d(20.0, 90.0)), 13);
        assert_eq!(full.bin_of(DVec3::Z), 0);
        assert_eq!(full.bin_of(DVec3::X), 133);
    }

    #[test]
    fn names_are_recognised_in_every_spelling_and_nonsense_is_refused() {
        assert_eq!(AngleBasis::by_name("LBNL/Klems_Full").unwrap().len(), 145);
        assert_eq!(AngleBasis::by_name("lbnl/klems quarter").unwrap().len(), 41);
        assert!(AngleBasis::by_name("IEA").is_none());
        assert!(AngleBasis::from_rings("x", &[0.0, 10.0], &[1]).is_err());
        assert!(AngleBasis::from_rings("x", &[0.0, 50.0, 40.0, 90.0], &[1, 4, 4]).is_err());
        assert!(AngleBasis::from_rings("x", &[0.0, 50.0, 90.0], &[1, 0]).is_err());
        assert!(AngleBasis::from_rings("x", &[0.0, f64::NAN, 90.0], &[1, 3]).is_err());
    }
}

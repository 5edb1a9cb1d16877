//! Woven shades and perforated screens by WINDOW's models: what passes the openings straight, and
//! what the material scatters.
//!
//! | | straight through | scattered forward | reflected |
//! |---|---|---|---|
//! | perforated (ISO 15099, perforated screens) | overlap of the two ends of the hole | transmittance of the sheet × rest | reflectance × rest |
//! | woven (EnergyPlus Engineering Reference, window screens) | gaps between two sets of round threads | empirical, by reflectance and openness | reflectance × rest, less what is scattered forward |
//!
//! WINDOW sends scattered light out evenly. Here it leaves as `S(in) S(out) / (π mean S)`, which keeps
//! the share S of every incident direction and is reciprocal (Helmholtz).

use super::{Block, Blocks, Component, KlemsMatrix, projected_solid_angles};
use crate::bins::AngleBasis;
use crate::error::{Error, Result};
use glam::DVec3;
use std::f64::consts::PI;

/// The openings of a screen; lengths in any one unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Openings {
    /// Round holes at distances `spacing` (x, y) through a sheet.
    Round {
        /// Diameter of a hole.
        diameter: f64,
        /// Distance of holes along x and y.
        spacing: [f64; 2],
        /// Thickness of the sheet.
        thickness: f64,
    },
    /// Rectangular holes.
    Rectangular {
        /// Size of a hole along x and y.
        size: [f64; 2],
        /// Distance of holes along x and y.
        spacing: [f64; 2],
        /// Thickness of the sheet.
        thickness: f64,
    },
    /// Two crossing sets of threads.
    Woven {
        /// Diameter of a thread.
        diameter: f64,
        /// Distance of neighbouring threads.
        spacing: f64,
    },
}

/// A screen of diffusing material, the same on both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    /// Geometry.
    pub openings: Openings,
    /// Reflectance of the sheet or thread.
    pub reflectance: f64,
    /// Transmittance of the sheet; 0 for threads, whose transmission is not modelled.
    pub transmittance: f64,
}

/// Points per bin and dimension over which direction-dependent shares are averaged.
const POINTS: usize = 16;

impl Screen {
    /// The openings' share for light at normal incidence.
    pub fn openness(&self) -> f64 {
        self.straight(DVec3::Z)
    }

    /// Share of light travelling along `d` (unit length, either side) that passes the openings.
    pub fn straight(&self, d: DVec3) -> f64 {
        let z = d.z.abs();
        if z < 1e-9 {
            return 0.0;
        }
        let slope = [d.x.abs() / z, d.y.abs() / z];
        match self.openings {
            Openings::Round { diameter, spacing, thickness } => {
                // Two circles, shifted against each other by what light moves sideways in the hole.
                let shift = thickness * slope[0].hypot(slope[1]);
                if shift >= diameter {
                    return 0.0;
                }
                let lens =
                    diameter * diameter / 2.0 * (shift / diameter).acos() - shift / 2.0 * (diameter * diameter - shift * shift).sqrt();
                lens / (spacing[0] * spacing[1])
            }
            Openings::Rectangular { size, spacing, thickness } => {
                (0..2).map(|k| (size[k] - thickness * slope[k]).max(0.0) / spacing[k]).product()
            }
            // A thread's shadow on the screen is its diameter over the cosine of the profile angle.
            Openings::Woven { diameter, spacing } => slope.iter().map(|s| (1.0 - diameter / spacing * s.hypot(1.0)).max(0.0)).product(),
        }
    }

    /// Share that is scattered forward.
    pub fn scattered(&self, d: DVec3) -> f64 {
        let rest = 1.0 - self.straight(d);
        match self.openings {
            // The correlation may exceed what meets the threads.
            Openings::Woven { diameter, spacing } => woven_scatter(diameter / spacing, self.reflectance, d).min(self.reflectance * rest),
            _ => self.transmittance * rest,
        }
    }

    /// Share that is reflected.
    pub fn reflected(&self, d: DVec3) -> f64 {
        let all = self.reflectance * (1.0 - self.straight(d));
        match self.openings {
            Openings::Woven { .. } => (all - self.scattered(d)).max(0.0),
            _ => all,
        }
    }

    /// All four components over a basis.
    ///
    /// # Errors
    /// If a length or share is impossible.
    pub fn blocks(&self, basis: &AngleBasis) -> Result<Blocks> {
        self.check()?;
        let lambda = projected_solid_angles(basis);
        let mean = |f: &dyn Fn(DVec3) -> f64| -> Vec<f64> {
            let at = |k: usize| (k as f64 + 0.5) / POINTS as f64;
            let over_bin = |bin: usize| {
                let points = (0..POINTS * POINTS).map(|k| f(basis.direction(bin, at(k / POINTS), at(k % POINTS))));
                points.sum::<f64>() / (POINTS * POINTS) as f64
            };
            (0..basis.len()).map(over_bin).collect()
        };
        let straight = mean(&|d| self.straight(d));
        let transmitted = matrix(basis, &lambda, &mean(&|d| self.scattered(d)), &straight);
        let reflected = matrix(basis, &lambda, &mean(&|d| self.reflected(d)), &vec![0.0; basis.len()]);
        let mut blocks = Blocks::default();
        for component in Component::ALL {
            let m = if component.is_transmission() { &transmitted } else { &reflected };
            *blocks.slot(component) = Some(Block::Klems(m.clone()));
        }
        Ok(blocks)
    }

    fn check(&self) -> Result<()> {
        let fault = |field: &str, message: String| Err(Error::new(message).field(field));
        let positive = |v: f64| v.is_finite() && v > 0.0;
        for (name, share) in [("reflectance", self.reflectance), ("transmittance", self.transmittance)] {
            if !(0.0..=1.0).contains(&share) {
                return fault(name, format!("{share} is not between 0 and 1"));
            }
        }
        if self.reflectance + self.transmittance > 1.0 {
            return fault(
                "reflectance",
                format!("reflectance {} and transmittance {} together exceed 1", self.reflectance, self.transmittance),
            );
        }
        let (sizes, spacing, thickness) = match self.openings {
            Openings::Round { diameter, spacing, thickness } => ([diameter; 2], spacing, thickness),
            Openings::Rectangular { size, spacing, thickness } => (size, spacing, thickness),
            Openings::Woven { diameter, spacing } => ([diameter; 2], [spacing; 2], 0.0),
        };
        if !sizes.into_iter().chain(spacing).all(positive) {
            return fault("spacing", format!("sizes {sizes:?} and spacings {spacing:?} must be positive"));
        }
        if !(thickness.is_finite() && thickness >= 0.0) {
            return fault("thickness", format!("{thickness} is no thickness"));
        }
        if (0..2).any(|k| sizes[k] > spacing[k]) {
            let what = if matches!(self.openings, Openings::Woven { .. }) { "threads" } else { "holes" };
            return fault("spacing", format!("{what} of {sizes:?} overlap at spacings of {spacing:?}"));
        }
        if self.transmittance > 0.0 && matches!(self.openings, Openings::Woven { .. }) {
            return Err(Error::new("the model of woven shades knows no transmittance of the threads")
                .field("transmittance")
                .help("leave it out; light scattered forward follows from the reflectance"));
        }
        Ok(())
    }
}

/// Scattering with the given shares per incident bin, and what goes straight on the diagonal.
fn matrix(basis: &AngleBasis, lambda: &[f64], share: &[f64], straight: &[f64]) -> KlemsMatrix {
    let mean = share.iter().zip(lambda).map(|(s, l)| s * l).sum::<f64>() / PI;
    KlemsMatrix::from_fn(basis, |o, i| {
        let diffuse = if mean > 0.0 { share[i] * share[o] / (PI * mean) } else { 0.0 };
        diffuse + if o == i { straight[i] / lambda[i] } else { 0.0 }
    })
}

/// Light that threads of this diameter over spacing scatter forward: the correlation of the EnergyPlus
/// Engineering Reference ("Beam Scattered Transmittance"), as WINDOW continues it beyond its peak.
fn woven_scatter(gamma: f64, reflectance: f64, d: DVec3) -> f64 {
    if reflectance <= 0.0 || gamma >= 1.0 {
        return 0.0;
    }
    let peak = 0.0229 * gamma + 0.2971 * reflectance - 0.03624 * gamma * gamma + 0.04763 * reflectance * reflectance
        - 0.44416 * gamma * reflectance;
    let altitude = d.y.abs().min(1.0).asin().to_degrees();
    let azimuth = d.x.abs().atan2(d.z.abs()).to_degrees();
    let (delta, delta_peak) = (altitude.hypot(azimuth), 89.7 - 10.0 * gamma / 0.16);
    let plateau = 0.2 * reflectance * (1.0 - gamma);
    let away = (delta - delta_peak).abs();
    let exponent = if delta > delta_peak { away.powf(2.5) } else { away.powi(2) } / -600.0;
    let beyond = if delta > delta_peak { away / (90.0 - delta_peak) } else { 0.0 };
    (peak * plateau * (1.0 + (1.0 / plateau - 1.0) * exponent.exp() - beyond)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bins::KlemsBasis;

    fn direction(theta: f64, phi: f64) -> DVec3 {
        let (t, p) = (theta.to_radians(), phi.to_radians());
        DVec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos())
    }

    /// Share of rays along `d`, from a grid of points over one period, that enter a hole and leave the
    /// sheet inside the same hole; a ray that comes out in the next hole has passed the sheet between.
    fn counted(d: DVec3, spacing: [f64; 2], thickness: f64, hole: impl Fn(f64, f64) -> bool) -> f64 {
        let n = 700;
        let shift = [d.x / d.z * thickness, d.y / d.z * thickness];
        let free = (0..n * n).filter(|k| {
            let [x, y] = [(k % n, spacing[0]), (k / n, spacing[1])].map(|(i, s)| ((i as f64 + 0.5) / n as f64 - 0.5) * s);
            hole(x, y) && hole(x + shift[0], y + shift[1])
        });
        free.count() as f64 / (n * n) as f64
    }

    #[test]
    fn openings_are_what_rays_find() {
        let round = Screen {
            openings: Openings::Round { diameter: 0.6, spacing: [1.0, 0.8], thickness: 0.3 },
            reflectance: 0.5,
            transmittance: 0.0,
        };
        let slots = Screen { openings: Openings::Rectangular { size: [0.6, 0.5], spacing: [1.0, 0.8], thickness: 0.3 }, ..round };
        for d in [direction(0.0, 0.0), direction(30.0, 20.0), direction(50.0, 100.0), direction(80.0, 45.0)] {
            // Convex holes: light that enters and leaves inside passes.
            let by_count = counted(d, [1.0, 0.8], 0.3, |x, y| x.hypot(y) <= 0.3);
            assert!((round.straight(d) - by_count).abs() < 2e-3, "{d} {} {by_count}", round.straight(d));
            let by_count = counted(d, [1.0, 0.8], 0.3, |x, y| x.abs() <= 0.3 && y.abs() <= 0.25);
            assert!((slots.straight(d) - by_count).abs() < 4e-3, "{d} {} {by_count}", slots.straight(d));
        }
        assert!((round.openness() - PI * 0.09 / 0.8).abs() < 1e-12);
    }

    #[test]
    fn threads_leave_the_gaps_that_cylinders_leave() {
        let woven = Screen { openings: Openings::Woven { diameter: 0.3, spacing: 1.0 }, reflectance: 0.5, transmittance: 0.0 };
        for d in [direction(0.0, 0.0), direction(40.0, 30.0), direction(65.0, 80.0)] {
            // A ray misses all threads along y if its distance from their axes is large in the xz plane.
            let gap = |slope: f64| {
                let n = 4000;
                let free = |x: f64| (-20..=20).all(|k| (x - f64::from(k)).abs() / slope.hypot(1.0) > 0.15);
                (0..n).filter(|&k| free((k as f64 + 0.5) / n as f64)).count() as f64 / n as f64
            };
            let expected = gap(d.x / d.z) * gap(d.y / d.z);
            assert!((woven.straight(d) - expected).abs() < 1e-3, "{d} {} {expected}", woven.straight(d));
        }
    }

    #[test]
    fn blocks_keep_energy_and_reciprocity() {
        let screens = [
            Screen {
                openings: Openings::Round { diameter: 2.0, spacing: [4.0, 4.0], thickness: 1.0 },
                reflectance: 0.5,
                transmittance: 0.2,
            },
            Screen { openings: Openings::Woven { diameter: 0.5, spacing: 1.0 }, reflectance: 0.6, transmittance: 0.0 },
        ];
        for screen in screens {
            let basis = AngleBasis::from(KlemsBasis::Full);
            let blocks = screen.blocks(&basis).unwrap();
            let t = blocks.get(Component::TransmissionFront).unwrap().as_klems().unwrap();
            let r = blocks.get(Component::ReflectionBack).unwrap().as_klems().unwrap();
            for i in 0..basis.len() {
                let sum = t.direct_hemispherical(i) + r.direct_hemispherical(i);
                assert!(sum <= 1.0 + 1e-12);
                let back = t.reversed();
                assert!((0..basis.len()).all(|o| (t.at(o, i) - back.at(o, i)).abs() < 1e-9));
            }
        }
    }

    #[test]
    fn impossible_screens_are_refused() {
        let good = Screen { openings: Openings::Woven { diameter: 0.5, spacing: 1.0 }, reflectance: 0.6, transmittance: 0.0 };
        let basis = AngleBasis::from(KlemsBasis::Quarter);
        assert!(good.blocks(&basis).is_ok());
        let bad = [
            (Screen { reflectance: 1.2, ..good }, "reflectance"),
            (Screen { transmittance: 0.1, ..good }, "transmittance"),
            (Screen { openings: Openings::Woven { diameter: 2.0, spacing: 1.0 }, ..good }, "spacing"),
            (Screen { openings: Openings::Woven { diameter: f64::NAN, spacing: 1.0 }, ..good }, "spacing"),
            (Screen { openings: Openings::Round { diameter: 0.5, spacing: [1.0; 2], thickness: -1.0 }, ..good }, "thickness"),
        ];
        for (screen, field) in bad {
            let error = screen.blocks(&basis).unwrap_err().to_string();
            assert!(error.starts_with(field), "{error}");
        }
    }

    #[test]
    fn window_finds_the_same_screens() {
        let script = "
import pywincalc as w, numpy as np
hemisphere = w.BSDFHemisphere.create(w.BSDFBasisType.QUARTER)
solid = np.array(hemisphere.get_directions(w.BSDFDirection.Outgoing).lambda_vector())
def system(maker, geometry, tau, rho, thickness):
    optical = w.ProductDataOpticalDualBandHemispheric(tau, tau, rho, rho, tau, tau, rho, rho, thickness)
    layer = maker(geometry, optical, w.ProductDataThermal(1, thickness))
    s = w.GlazingSystem(solid_layers=[layer], bsdf_hemisphere=hemisphere)
    f = s.optical_method_results('PHOTOPIC').system_results.front
    direct = solid @ np.array(f.transmittance.matrix)
    print(f.transmittance.diffuse_diffuse, f.reflectance.diffuse_diffuse, *[direct[k] for k in (0, 1, 9, 10)])
system(w.create_perforated_screen, w.PerforatedGeometry(.004, .004, .001, .001, w.PerforatedGeometry.Type.CIRCULAR), .1, .6, .0005)
system(w.create_woven_shade, w.WovenGeometry(.0005, .001, .001), 0, .6, .001)";
        let Some(out) = crate::testing::pywincalc(script) else { return };
        let text = String::from_utf8(out).unwrap();
        let theirs: Vec<Vec<f64>> = text.lines().map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect();
        // WINDOW's dimension is the radius of a round hole.
        let ours = [
            Screen {
                openings: Openings::Round { diameter: 0.002, spacing: [0.004; 2], thickness: 0.0005 },
                reflectance: 0.6,
                transmittance: 0.1,
            },
            Screen { openings: Openings::Woven { diameter: 0.0005, spacing: 0.001 }, reflectance: 0.6, transmittance: 0.0 },
        ];
        let basis = AngleBasis::from(KlemsBasis::Quarter);
        for (screen, theirs) in ours.iter().zip(&theirs) {
            let blocks = screen.blocks(&basis).unwrap();
            let t = blocks.get(Component::TransmissionFront).unwrap();
            let r = blocks.get(Component::ReflectionFront).unwrap();
            // WINDOW evaluates at the bins' central directions, here bins are averaged.
            assert!((t.hemispherical() - theirs[0]).abs() < 0.01, "{} {theirs:?}", t.hemispherical());
            assert!((r.hemispherical() - theirs[1]).abs() < 0.01, "{} {theirs:?}", r.hemispherical());
            for (bin, theirs) in [0, 1, 9, 10].into_iter().zip(&theirs[2..]) {
                let ours = t.as_klems().unwrap().direct_hemispherical(bin);
                assert!((ours - theirs).abs() < 0.015, "{bin}: {ours} {theirs}");
            }
        }
    }
}

//! Sky patches: Tregenza's 145 and Reinhart's finer subdivisions, with the ground first.
//!
//! Order of rows and columns everywhere: index 0 is the ground, then the Reinhart rows from the
//! horizon up, in each row clockwise from north (bins *centred* on north), the zenith cap last
//! (Radiance `reinsrc.cal`, `gendaymtx`).

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Patches in each of Tregenza's seven rows, from the horizon up; the zenith cap follows.
const TREGENZA_ROW_PATCHES: [usize; 7] = [30, 30, 24, 24, 18, 12, 6];

/// Reinhart's subdivision MF:n of the sky (n = 1 is Tregenza's), with the ground as index 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReinhartSky {
    subdivision: usize,
}

impl ReinhartSky {
    /// The sky of subdivision MF:`subdivision`.
    ///
    /// # Errors
    /// If the subdivision is not in 1…6.
    pub fn new(subdivision: usize) -> crate::error::Result<Self> {
        if !(1..=6).contains(&subdivision) {
            return Err(crate::error::Error::new(format!("Reinhart subdivision MF:{subdivision} does not exist")).help("choose 1 to 6"));
        }
        Ok(Self { subdivision })
    }

    /// The subdivision whose number of bins, the ground included, is `bins`.
    pub fn from_bins(bins: usize) -> Option<Self> {
        (1..=6).map(|subdivision| Self { subdivision }).find(|s| s.len() == bins)
    }

    /// n of MF:n.
    pub fn subdivision(&self) -> usize {
        self.subdivision
    }

    /// Number of bins: patches and the ground (146, 578, 1298, 2306, 3602, 5186).
    #[allow(clippy::len_without_is_empty, reason = "a sky always has patches")]
    pub fn len(&self) -> usize {
        TREGENZA_ROW_PATCHES.iter().sum::<usize>() * self.subdivision * self.subdivision + 2
    }

    /// Height of a row, radians. The zenith cap has half of it as its opening half-angle.
    pub(crate) fn row_height(&self) -> f64 {
        FRAC_PI_2 / (7.0 * self.subdivision as f64 + 0.5)
    }

    /// First index and number of patches of each row from the horizon up, without the zenith cap.
    pub fn rows(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let n = self.subdivision;
        let mut first = 1;
        (0..7 * n).map(move |row| {
            let patches = TREGENZA_ROW_PATCHES[row / n] * n;
            let start = first;
            first += patches;
            (start, patches)
        })
    }

    /// The bin of a direction towards the sky (world coordinates, unit length); 0 at and below the
    /// horizon.
    pub fn bin_of(&self, direction: DVec3) -> usize {
        if direction.z <= 0.0 {
            return 0;
        }
        let row = (direction.z.min(1.0).asin() / self.row_height()) as usize;
        match self.rows().nth(row) {
            None => self.len() - 1,
            Some((first, patches)) => {
                let azimuth = direction.x.atan2(direction.y).rem_euclid(TAU);
                first + (azimuth / TAU * patches as f64 + 0.5).floor() as usize % patches
            }
        }
    }

    /// Altitude (radians) limits of a patch, and its azimuth limits (radians from north, clockwise;
    /// the lower one may be negative). The ground is the whole lower hemisphere.
    ///
    /// # Panics
    /// If `bin` is not below [`len`](Self::len).
    pub fn limits(&self, bin: usize) -> ([f64; 2], [f64; 2]) {
        assert!(bin < self.len(), "sky bin {bin} outside a sky of {}", self.len());
        if bin == 0 {
            return ([-FRAC_PI_2, 0.0], [0.0, TAU]);
        }
        let height = self.row_height();
        for (row, (first, patches)) in self.rows().enumerate() {
            if bin < first + patches {
                let width = TAU / patches as f64;
                let middle = (bin - first) as f64 * width;
                return ([row as f64 * height, (row + 1) as f64 * height], [middle - width / 2.0, middle + width / 2.0]);
            }
        }
        ([FRAC_PI_2 - height / 2.0, FRAC_PI_2], [0.0, TAU])
    }

    /// Solid angle of a bin, sr (2π for the ground).
    pub fn solid_angle(&self, bin: usize) -> f64 {
        let ([low, high], [from, to]) = self.limits(bin);
        (high.sin() - low.sin()) * (to - from)
    }

    /// The centre of a patch: middle altitude and azimuth; the zenith for the cap, the nadir for
    /// the ground.
    pub fn centre(&self, bin: usize) -> DVec3 {
        if bin == 0 {
            return DVec3::NEG_Z;
        }
        if bin == self.len() - 1 {
            return DVec3::Z;
        }
        let ([low, high], [from, to]) = self.limits(bin);
        let (altitude, azimuth) = ((low + high) / 2.0, (from + to) / 2.0);
        DVec3::new(altitude.cos() * azimuth.sin(), altitude.cos() * azimuth.cos(), altitude.sin())
    }

    /// A direction inside a patch, uniform in solid angle for uniform `u` (altitude) and `v`
    /// (azimuth).
    pub fn direction(&self, bin: usize, u: f64, v: f64) -> DVec3 {
        let ([low, high], [from, to]) = self.limits(bin);
        let sin = low.sin() + u * (high.sin() - low.sin());
        let azimuth = from + v * (to - from);
        let cos = (1.0 - sin * sin).max(0.0).sqrt();
        DVec3::new(cos * azimuth.sin(), cos * azimuth.cos(), sin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_of_radiance() {
        let sizes: Vec<usize> = (1..=6).map(|n| ReinhartSky::new(n).unwrap().len()).collect();
        assert_eq!(sizes, [146, 578, 1298, 2306, 3602, 5186]);
        assert!(ReinhartSky::new(0).is_err() && ReinhartSky::new(7).is_err());
        assert_eq!(ReinhartSky::from_bins(2306).unwrap().subdivision(), 4);
        assert!(ReinhartSky::from_bins(145).is_none());
    }

    #[test]
    fn solid_angles_fill_the_sphere_and_bins_map_back() {
        for n in 1..=6 {
            let sky = ReinhartSky::new(n).unwrap();
            let total: f64 = (0..sky.len()).map(|i| sky.solid_angle(i)).sum();
            assert!((total - 2.0 * TAU).abs() < 1e-9, "MF:{n} {total}");
            for bin in 0..sky.len() {
                assert_eq!(sky.bin_of(sky.centre(bin)), bin);
                for (u, v) in [(0.01, 0.01), (0.99, 0.99), (0.02, 0.98)] {
                    assert_eq!(sky.bin_of(sky.direction(bin, u, v)), bin, "MF:{n} {bin}");
                }
            }
        }
    }

    #[test]
    fn the_first_patch_looks_north_and_the_next_is_east_of_it() {
        let sky = ReinhartSky::new(1).unwrap();
        let north = sky.centre(1);
        assert!(north.x.abs() < 1e-12 && north.y > 0.9);
        assert!(sky.centre(2).x > 0.0);
        assert_eq!(sky.bin_of(DVec3::new(0.0, 1.0, 0.0)), 0, "the horizon belongs to the ground");
    }
}

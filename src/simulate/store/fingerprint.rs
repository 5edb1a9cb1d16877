//! Fingerprints of what a matrix was computed from, so that a repeated run reuses what is still
//! valid.

use std::fmt::{self, Write};

/// FNV-1a of 128 bits over the readable form of everything that determines a matrix. It guards
/// against mistakes, not against malice. Rust prints each float so that it reads back to the same
/// bits, so no change of an input is too small.
#[derive(Debug, Clone, Copy)]
pub struct Fingerprint(u128);

impl Fingerprint {
    /// The fingerprint of nothing but the kind of matrix and the program's version.
    pub fn new(kind: &str) -> Self {
        // Offset basis of FNV-1a, 128 bits (Fowler, Noll, Vo; IETF draft-eastlake-fnv).
        let mut new = Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        new.add(&(kind, env!("CARGO_PKG_VERSION")));
        new
    }

    /// Adds an input.
    pub fn add(&mut self, input: &impl fmt::Debug) -> &mut Self {
        // Writing into this struct cannot fail; the end mark keeps neighbours apart.
        let _ = write!(self, "{input:?}\0");
        self
    }
}

impl Write for Fingerprint {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u128::from(byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        }
        Ok(())
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_fnv_1a() {
        // Known answers of FNV-1a 128 for "a" and "foobar".
        let hash = |text: &str| {
            let mut f = Fingerprint(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
            f.write_str(text).unwrap();
            f.to_string()
        };
        assert_eq!(hash("a"), "d228cb696f1a8caf78912b704e4a8964");
        assert_eq!(hash("foobar"), "343e1662793c64bf6f0d3597ba446f18");
    }

    #[test]
    fn every_input_and_its_place_count() {
        let of = |parts: &[&str]| {
            let mut f = Fingerprint::new("V");
            for p in parts {
                f.add(p);
            }
            f.to_string()
        };
        assert_eq!(of(&["a", "b"]), of(&["a", "b"]));
        assert_ne!(of(&["a", "b"]), of(&["b", "a"]));
        assert_ne!(of(&["ab", ""]), of(&["a", "b"]));
        assert_ne!(Fingerprint::new("V").to_string(), Fingerprint::new("D").to_string());
        assert_ne!(Fingerprint::new("V").add(&1.0f64).to_string(), Fingerprint::new("V").add(&(1.0f64 + f64::EPSILON)).to_string());
    }
}

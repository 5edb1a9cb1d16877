//! Fingerprints of what a matrix was computed from, so that a repeated run reuses what is still
//! valid.

use bytemuck::NoUninit;
use std::fmt::{self, Write};

/// A hash (BLAKE3, 256 bits) of everything that determines a matrix. Each input is hashed together with
/// the fingerprint of those before it, so that a long common part, the scene, is hashed once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint(blake3::Hash);

impl Fingerprint {
    /// The fingerprint of nothing but the kind of matrix, the program's version and its sources (`build.rs`).
    pub fn new(kind: &str) -> Self {
        let mut new = Self(blake3::hash(b"Lucarne"));
        new.add(&(kind, env!("CARGO_PKG_VERSION"), env!("LUCARNE_SOURCES")));
        new
    }

    /// Adds an input by its readable form, for settings. Rust prints each float so that it reads back
    /// to the same bits, so no change of an input is too small.
    pub fn add(&mut self, input: &impl fmt::Debug) -> &mut Self {
        struct Text(blake3::Hasher);
        impl Write for Text {
            fn write_str(&mut self, text: &str) -> fmt::Result {
                self.0.update(text.as_bytes());
                Ok(())
            }
        }
        let mut text = Text(self.follow(b't'));
        // Writing into a hasher cannot fail.
        let _ = write!(text, "{input:?}");
        self.0 = text.0.finalize();
        self
    }

    /// Adds plain numbers by their bytes, for geometry, matrices and files.
    pub(crate) fn add_values<T: NoUninit>(&mut self, values: &[T]) -> &mut Self {
        self.0 = self.follow(b'v').update(bytemuck::cast_slice(values)).finalize();
        self
    }

    /// Adds all inputs of another fingerprint.
    pub(crate) fn add_all_of(&mut self, other: Self) -> &mut Self {
        self.0 = self.follow(b'f').update(other.0.as_bytes()).finalize();
        self
    }

    /// A hash that goes on from here; `kind` keeps text, numbers and fingerprints apart.
    fn follow(&self, kind: u8) -> blake3::Hasher {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.0.as_bytes()).update(&[kind]);
        hasher
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.to_hex())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_input_and_its_place_count() {
        let of = |parts: &[&str]| {
            let mut f = Fingerprint::new("V");
            for p in parts {
                f.add(p);
            }
            f
        };
        assert_eq!(of(&["a", "b"]), of(&["a", "b"]));
        assert_ne!(of(&["a", "b"]), of(&["b", "a"]));
        assert_ne!(of(&["ab", ""]), of(&["a", "b"]));
        assert_ne!(of(&["a", ""]), of(&["a"]));
        assert_ne!(Fingerprint::new("V"), Fingerprint::new("D"));
        assert_ne!(Fingerprint::new("V").add(&1.0f64), Fingerprint::new("V").add(&(1.0f64 + f64::EPSILON)));
    }

    #[test]
    fn numbers_count_to_the_last_bit_and_stay_apart_from_text() {
        let of = |values: &[f32]| *Fingerprint::new("V").add_values(values);
        assert_eq!(of(&[1.0, 2.0]), of(&[1.0, 2.0]));
        assert_ne!(of(&[1.0, 2.0]), of(&[1.0, 2.0_f32.next_up()]));
        assert_ne!(of(&[1.0, 2.0]), *Fingerprint::new("V").add_values(&[1.0f32]).add_values(&[2.0f32]));
        assert_ne!(*Fingerprint::new("V").add_values(b"\"a\""), *Fingerprint::new("V").add(&"a"));
        let scene = *Fingerprint::new("scene").add(&1);
        assert_ne!(*Fingerprint::new("V").add_all_of(scene), *Fingerprint::new("V").add_all_of(*Fingerprint::new("scene").add(&2)));
        // As hexadecimal digits in files.
        let text = scene.to_string();
        assert!(text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit()), "{text}");
    }
}

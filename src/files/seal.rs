//! A checksum in a file, so that one whose bytes have changed is never taken for whole.
//!
//! The file has a line `LUCARNE_CHECKSUM=` among its first bytes, followed by 64 hexadecimal digits: the BLAKE3
//! hash of the whole file with zeros in their place.

use super::write_seekable_atomically;
use crate::error::{Error, Result};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

const KEY: &str = "LUCARNE_CHECKSUM=";
const DIGITS: usize = 64;
/// The line stands among so many bytes from the beginning.
const HEAD: usize = 1 << 16;

/// The line for the file's header, before the checksum is known.
pub fn line() -> String {
    format!("{KEY}{}", "0".repeat(DIGITS))
}

/// Writes a file as [`write_atomically`](super::write_atomically) does, and the checksum into its [`line()`], which
/// `write` writes among the first 64 KiB.
///
/// # Errors
/// As `write_atomically`, and a file without its line.
pub fn write_sealed(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    write_seekable_atomically(path, |out| {
        let mut hashing = Hashing { out, hasher: blake3::Hasher::new(), head: Vec::new() };
        write(&mut hashing)?;
        let digest = hashing.hasher.finalize().to_hex();
        let place = digits(&hashing.head).ok_or_else(|| Error::new("no line for the checksum was written").file(path))?;
        let fault = |e: std::io::Error| Error::io(path, &e);
        out.seek(SeekFrom::Start(place as u64)).map_err(fault)?;
        out.write_all(digest.as_bytes()).map_err(fault)
    })
}

/// What a file's checksum says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seal {
    /// The file is what was written.
    Whole,
    /// It is not.
    Broken,
    /// There is none: somebody else wrote the file.
    Absent,
}

/// Whether a file is what was written: it has a checksum, and that is right.
pub fn is_whole(path: &Path) -> bool {
    state(path).is_ok_and(|seal| seal == Seal::Whole)
}

/// Refuses a file that has changed since it was written. Files of others have no checksum, and pass.
///
/// # Errors
/// A wrong checksum, and a file that cannot be read.
pub(crate) fn check(path: &Path) -> Result<()> {
    match state(path).map_err(|e| Error::io(path, &e))? {
        Seal::Broken => Err(Error::new("the file has changed since it was written").file(path).help("run the project again")),
        Seal::Whole | Seal::Absent => Ok(()),
    }
}

fn state(path: &Path) -> std::io::Result<Seal> {
    let mut file = File::open(path)?;
    let mut block = vec![0u8; 1 << 20];
    let mut hasher = blake3::Hasher::new();
    let mut stated = None;
    loop {
        let mut filled = 0;
        while filled < block.len() {
            match file.read(&mut block[filled..])? {
                0 => break,
                count => filled += count,
            }
        }
        let bytes = &mut block[..filled];
        if stated.is_none() {
            let Some(place) = digits(&bytes[..filled.min(HEAD)]) else { return Ok(Seal::Absent) };
            let Some(found) = bytes.get_mut(place..place + DIGITS) else { return Ok(Seal::Broken) };
            stated = Some(found.to_vec());
            found.fill(b'0');
        }
        hasher.update(bytes);
        if filled < block.len() {
            let fits = stated.as_deref() == Some(hasher.finalize().to_hex().as_bytes());
            return Ok(if fits { Seal::Whole } else { Seal::Broken });
        }
    }
}

/// Where the digits of the checksum begin.
fn digits(head: &[u8]) -> Option<usize> {
    head.windows(KEY.len()).position(|w| w == KEY.as_bytes()).map(|at| at + KEY.len())
}

struct Hashing<'a> {
    out: &'a mut dyn Write,
    hasher: blake3::Hasher,
    head: Vec<u8>,
}

impl Write for Hashing<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.out.write(bytes)?;
        let written = &bytes[..count];
        self.hasher.update(written);
        let room = HEAD.saturating_sub(self.head.len());
        self.head.extend_from_slice(&written[..count.min(room)]);
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed(folder: &Path, values: usize) -> std::path::PathBuf {
        let path = folder.join(format!("{values}.mtx"));
        write_sealed(&path, |out| {
            let fault = |e: std::io::Error| Error::io(&path, &e);
            writeln!(out, "#?RADIANCE\n{}\nNROWS=1\n", line()).map_err(fault)?;
            (0..values).try_for_each(|v| out.write_all(&(v as f32).to_le_bytes()).map_err(fault))
        })
        .unwrap();
        path
    }

    #[test]
    fn every_flipped_bit_and_every_cut_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = sealed(folder.path(), 20);
        let bytes = std::fs::read(&path).unwrap();
        assert!(is_whole(&path));
        for place in 0..bytes.len() {
            for bit in [0, 7] {
                let mut changed = bytes.clone();
                changed[place] ^= 1 << bit;
                std::fs::write(&path, &changed).unwrap();
                assert!(!is_whole(&path), "byte {place}, bit {bit}");
            }
            std::fs::write(&path, &bytes[..place]).unwrap();
            assert!(!is_whole(&path), "cut at {place}");
        }
        std::fs::write(&path, [&bytes[..], b"more"].concat()).unwrap();
        assert!(!is_whole(&path));
    }

    #[test]
    fn files_of_any_size_are_whole_and_those_without_a_checksum_are_not() {
        let folder = tempfile::tempdir().unwrap();
        // Around the size of the blocks that are read.
        let header = std::fs::metadata(sealed(folder.path(), 0)).unwrap().len() as usize;
        for values in [0, 1, ((1 << 20) - header) / 4, ((1 << 20) - header) / 4 + 1, 600_000] {
            assert!(is_whole(&sealed(folder.path(), values)), "{values}");
        }
        let plain = folder.path().join("plain");
        std::fs::write(&plain, b"#?RADIANCE\n\n").unwrap();
        assert!(!is_whole(&plain) && !is_whole(&folder.path().join("none")) && !is_whole(folder.path()));
        assert!(check(&plain).is_ok() && check(&folder.path().join("none")).is_err());
        let error = write_sealed(&plain, |out| out.write_all(b"x").map_err(|e| Error::io(&plain, &e))).unwrap_err().to_string();
        assert!(error.contains("checksum"), "{error}");
        assert_eq!(std::fs::read(&plain).unwrap(), b"#?RADIANCE\n\n");
    }
}

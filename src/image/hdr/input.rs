//! Buffered bytes that know their position.

use crate::error::{Error, Result};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Reads bytes and counts them. Errors name the path; an empty path stands for bytes in memory.
pub(super) struct Input<R> {
    source: R,
    path: PathBuf,
    buffer: Box<[u8]>,
    at: usize,
    end: usize,
    before: u64,
}

impl<R: Read> Input<R> {
    pub(super) fn new(source: R, path: &Path) -> Self {
        Self { source, path: path.to_path_buf(), buffer: vec![0; 1 << 16].into_boxed_slice(), at: 0, end: 0, before: 0 }
    }

    /// As [`Self::new`], for a source that has already given `offset` bytes.
    pub(super) fn resume(source: R, path: &Path, offset: u64) -> Self {
        Self { before: offset, ..Self::new(source, path) }
    }

    /// Number of bytes taken so far.
    pub(super) fn offset(&self) -> u64 {
        self.before + self.at as u64
    }

    /// The next byte, or `None` at the end.
    #[inline]
    pub(super) fn byte(&mut self) -> Result<Option<u8>> {
        if self.at == self.end && !self.refill()? {
            return Ok(None);
        }
        let byte = self.buffer[self.at];
        self.at += 1;
        Ok(Some(byte))
    }

    /// Fills `target` completely; false if the input ends first.
    pub(super) fn fill(&mut self, target: &mut [u8]) -> Result<bool> {
        let mut done = 0;
        while done < target.len() {
            if self.at == self.end && !self.refill()? {
                return Ok(false);
            }
            let n = (self.end - self.at).min(target.len() - done);
            target[done..done + n].copy_from_slice(&self.buffer[self.at..self.at + n]);
            self.at += n;
            done += n;
        }
        Ok(true)
    }

    /// Adds the file's name to an error, if there is one.
    pub(super) fn named(&self, error: Error) -> Error {
        if self.path.as_os_str().is_empty() { error } else { error.file(&self.path) }
    }

    fn refill(&mut self) -> Result<bool> {
        self.before += self.end as u64;
        self.at = 0;
        self.end = 0;
        loop {
            match self.source.read(&mut self.buffer) {
                Ok(n) => {
                    self.end = n;
                    return Ok(n > 0);
                }
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(Error::io(&self.path, &e)),
            }
        }
    }
}

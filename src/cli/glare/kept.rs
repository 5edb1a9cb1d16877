//! Results of pictures that an interrupted run has analysed.

use super::Job;
use lucarne::Result;
use lucarne::files::{self, journal::Journal};
use lucarne::simulate::Fingerprint;
use std::path::Path;

/// Lines of the tables, of some pictures or of all.
#[derive(Default)]
pub(super) struct Lines {
    pub table: String,
    pub sources: String,
    pub parts: String,
    /// Pictures that could not be analysed.
    pub failed: u64,
}

impl Lines {
    pub fn append(&mut self, other: Self) {
        self.table += &other.table;
        self.sources += &other.sources;
        self.parts += &other.parts;
        self.failed += other.failed;
    }

    fn from_bytes(mut bytes: &[u8]) -> Option<Self> {
        let mut lines = Self { failed: number(&mut bytes)?, ..Self::default() };
        for text in [&mut lines.table, &mut lines.sources, &mut lines.parts] {
            let length = usize::try_from(number(&mut bytes)?).ok()?;
            let (own, rest) = bytes.split_at_checked(length)?;
            *text = std::str::from_utf8(own).ok()?.to_string();
            bytes = rest;
        }
        Some(lines)
    }
}

fn number(bytes: &mut &[u8]) -> Option<u64> {
    let (own, rest) = bytes.split_at_checked(8)?;
    *bytes = rest;
    Some(u64::from_le_bytes(own.try_into().ok()?))
}

/// A record beside the output, of the pictures that were analysed.
pub(super) struct AnalysedPictures(Journal);

impl AnalysedPictures {
    pub fn open(output: &Path) -> Self {
        let mut name = output.as_os_str().to_os_string();
        name.push(".units");
        let arguments: Vec<_> = std::env::args_os().skip(1).collect();
        Self(Journal::open(Path::new(&name), &Fingerprint::new("glare of pictures").add(&arguments).to_string()))
    }

    /// What an earlier run of the same command found in these pictures, if they are still the same.
    ///
    /// # Errors
    /// Failures of the file system.
    pub fn known(&self, some: &[Job]) -> Result<Option<Lines>> {
        let hash = hash(some);
        let bytes = self.0.known_if(&|bytes| bytes.starts_with(&hash))?;
        Ok(bytes.and_then(|bytes| Lines::from_bytes(&bytes[hash.len()..])))
    }

    /// # Errors
    /// Failures of the file system.
    pub fn add(&self, some: &[Job], lines: &Lines) -> Result<()> {
        let mut bytes = hash(some).to_vec();
        bytes.extend(lines.failed.to_le_bytes());
        for text in [&lines.table, &lines.sources, &lines.parts] {
            bytes.extend((text.len() as u64).to_le_bytes());
            bytes.extend(text.as_bytes());
        }
        self.0.add(&bytes)
    }

    pub fn finish(self) {
        self.0.finish();
    }
}

/// Of what the files hold; one that cannot be read is at fault each time.
fn hash(some: &[Job]) -> [u8; blake3::OUT_LEN] {
    let mut hasher = blake3::Hasher::new();
    for job in some {
        match files::read(&job.path) {
            Ok(bytes) => hasher.update(blake3::hash(&bytes).as_bytes()),
            Err(error) => hasher.update(error.to_string().as_bytes()),
        };
    }
    *hasher.finalize().as_bytes()
}

//! Pictures that an interrupted multiplication finished, so that it can go on behind them.

use super::Args;
use lucarne::files::journal::Journal;
use lucarne::image::series::Pattern;
use lucarne::simulate::Fingerprint;
use lucarne::simulate::results::pictures::Output;
use lucarne::{Error, Result};
use std::collections::HashSet;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A record beside the pictures, of those that are complete.
pub(super) struct Finished {
    journal: Journal,
    pattern: Pattern,
    known: HashSet<usize>,
}

/// Bytes of a picture in the record: its number and the hash of its file.
const ENTRY: usize = 8 + blake3::OUT_LEN;

impl Finished {
    /// The pictures of an earlier run of the same command on the same files; nothing where a run cannot go on: all
    /// pictures in one file, and standard input.
    ///
    /// # Errors
    /// Factors that cannot be read.
    pub fn of(args: &Args, output: &Output, header: &[String]) -> Result<Option<Self>> {
        let (Output::Hdr(pattern) | Output::Exr(pattern, _)) = output else { return Ok(None) };
        if args.factors.iter().any(|f| f == "-") {
            return Ok(None);
        }
        let mut inputs = Fingerprint::new("pictures of a product");
        inputs.add(&(header, matches!(output, Output::Exr(..)), args.half, args.luminance, args.width, args.height));
        for factor in &args.factors {
            for path in files_of(factor)? {
                inputs.add(&hash(&path)?);
            }
        }
        let mut name = pattern.path(0).into_os_string();
        name.push(".units");
        let journal = Journal::open(Path::new(&name), &inputs.to_string());
        let mut known = HashSet::new();
        while let Some(unit) = journal.known()? {
            for entry in unit.as_chunks::<ENTRY>().0 {
                let (number, stated) = entry.split_at(8);
                let number = number.iter().rev().fold(0, |n, byte| n << 8 | usize::from(*byte));
                // As it was written, nobody else's.
                if hash(&pattern.path(number)).is_ok_and(|found| found.as_bytes() == stated) {
                    known.insert(number);
                }
            }
        }
        Ok(Some(Self { journal, pattern: pattern.clone(), known }))
    }

    /// Whether the picture of this number is there.
    pub fn has(&self, number: usize) -> bool {
        self.known.contains(&number)
    }

    /// Notes pictures that are complete.
    ///
    /// # Errors
    /// Failures of the file system.
    pub fn add(&self, numbers: &[usize]) -> Result<()> {
        let mut unit = Vec::with_capacity(numbers.len() * ENTRY);
        for number in numbers {
            unit.extend((*number as u64).to_le_bytes());
            unit.extend(hash(&self.pattern.path(*number))?.as_bytes());
        }
        self.journal.add(&unit)
    }

    /// All pictures are there.
    pub fn end(self) {
        self.journal.finish();
    }
}

fn files_of(factor: &str) -> Result<Vec<PathBuf>> {
    if !Pattern::is_pattern(factor) {
        return Ok(vec![PathBuf::from(factor)]);
    }
    let pattern = Pattern::parse(factor)?;
    Ok(pattern.existing()?.into_iter().map(|n| pattern.path(n)).collect())
}

fn hash(path: &Path) -> Result<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    let fault = |e: std::io::Error| Error::io(path, &e);
    let mut file = std::fs::File::open(path).map_err(fault)?;
    let mut block = vec![0; 1 << 20];
    loop {
        match file.read(&mut block).map_err(fault)? {
            0 => return Ok(hasher.finalize()),
            count => hasher.update(&block[..count]),
        };
    }
}

//! What long work has done so far, so that a killed program need not do it again.
//!
//! The work is cut into units whose results are bytes, in an order that never changes. Each is appended to a file
//! with a checksum over all that stands before it; the next run takes what is whole, in the same order, and goes on
//! behind it. Work that takes no longer than some seconds leaves no file at all.

use crate::error::{Error, Result};
use std::fs::{File, OpenOptions};
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Units wait so long for being written together.
const WRITE_AFTER: Duration = Duration::from_secs(5);
const HASH: usize = blake3::OUT_LEN;

/// A file of units that were finished.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    /// Hash of what the work depends on.
    inputs: [u8; HASH],
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// Units of an earlier run, as far as they are not taken yet.
    earlier: Option<BufReader<File>>,
    /// Where the whole units end.
    end: u64,
    /// Over everything before the end.
    hash: [u8; HASH],
    /// Units that wait for being written.
    pending: Vec<u8>,
    pending_since: Instant,
    file: Option<File>,
}

impl Journal {
    /// The journal of work that depends on `inputs` alone. What other work left at the path is forgotten.
    pub fn open(path: &Path, inputs: &str) -> Self {
        let inputs = *blake3::hash(inputs.as_bytes()).as_bytes();
        if std::fs::symlink_metadata(path).is_ok_and(|m| m.is_symlink()) {
            // What it leads to is not ours.
            let _ = std::fs::remove_file(path);
        }
        let mut earlier = File::open(path).ok().map(|file| BufReader::with_capacity(1 << 16, file));
        let mut found = [0; HASH];
        let fits = earlier.as_mut().is_some_and(|file| file.read_exact(&mut found).is_ok()) && found == inputs;
        let (earlier, end) = if fits { (earlier, HASH as u64) } else { (None, 0) };
        let state = State { earlier, end, hash: inputs, pending: Vec::new(), pending_since: Instant::now(), file: None };
        Self { path: path.to_path_buf(), inputs, state: Mutex::new(state) }
    }

    /// The next unit: of an earlier run that called it the same, or what `make` gives. Where the work is cut otherwise
    /// now, its units have other names, and are made anew.
    ///
    /// # Errors
    /// What `make` returns, and failures of the file system.
    pub fn unit(&self, name: &str, make: &mut dyn FnMut() -> Result<Vec<u8>>) -> Result<Vec<u8>> {
        let name = [&(name.len() as u64).to_le_bytes(), name.as_bytes()].concat();
        if let Some(mut known) = self.known_if(&|unit| unit.starts_with(&name))? {
            return Ok(known.split_off(name.len()));
        }
        let bytes = make()?;
        self.add(&[name.as_slice(), &bytes].concat())?;
        Ok(bytes)
    }

    /// The next unit, if an earlier run has finished it.
    ///
    /// # Errors
    /// Failures of the file system.
    pub fn known(&self) -> Result<Option<Vec<u8>>> {
        self.known_if(&|_| true)
    }

    /// The same if it fits; else it is forgotten with all behind it.
    ///
    /// # Errors
    /// As [`known`](Self::known).
    pub fn known_if(&self, fits: &dyn Fn(&[u8]) -> bool) -> Result<Option<Vec<u8>>> {
        let mut guard = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let state = &mut *guard;
        let Some(file) = &mut state.earlier else { return Ok(None) };
        let Some((bytes, hash)) = next(file, &self.path, state.hash, state.end)?.filter(|(bytes, _)| fits(bytes)) else {
            state.earlier = None;
            return Ok(None);
        };
        state.end += (HASH + 8 + bytes.len()) as u64;
        state.hash = hash;
        Ok(Some(bytes))
    }

    /// Adds a unit behind those that are known.
    ///
    /// # Errors
    /// Failures of the file system.
    pub fn add(&self, bytes: &[u8]) -> Result<()> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.earlier = None;
        state.hash = hash_of(state.hash, bytes);
        let hash = state.hash;
        state.pending.extend((bytes.len() as u64).to_le_bytes());
        state.pending.extend(hash);
        state.pending.extend(bytes);
        if state.pending_since.elapsed() < WRITE_AFTER { Ok(()) } else { self.write(&mut state) }
    }

    fn write(&self, state: &mut State) -> Result<()> {
        let failed = |e: std::io::Error| Error::io(&self.path, &e);
        if state.file.is_none() {
            let mut file = OpenOptions::new().write(true).create(true).truncate(false).open(&self.path).map_err(failed)?;
            if state.end == 0 {
                file.write_all(&self.inputs).map_err(failed)?;
                state.end = HASH as u64;
            }
            // What is not whole goes.
            file.set_len(state.end).and_then(|()| file.seek(SeekFrom::Start(state.end))).map_err(failed)?;
            state.file = Some(file);
        }
        let pending = std::mem::take(&mut state.pending);
        if let Some(file) = &mut state.file {
            file.write_all(&pending).map_err(failed)?;
        }
        state.end += pending.len() as u64;
        state.pending_since = Instant::now();
        Ok(())
    }

    /// Ends it: what it was kept for is stored elsewhere.
    pub fn finish(self) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.pending.clear();
        (state.file, state.earlier) = (None, None);
        drop(state);
        let _ = std::fs::remove_file(&self.path);
    }
}

impl Drop for Journal {
    /// Work that was stopped or failed: the next run goes on from here.
    fn drop(&mut self) {
        let state = self.state.get_mut().unwrap_or_else(PoisonError::into_inner);
        if state.pending.is_empty() {
            return;
        }
        let mut state = std::mem::replace(
            state,
            State { earlier: None, end: 0, hash: [0; HASH], pending: Vec::new(), pending_since: Instant::now(), file: None },
        );
        // There is nobody to tell, and nothing is lost but time.
        let _ = self.write(&mut state);
    }
}

fn hash_of(before: [u8; HASH], bytes: &[u8]) -> [u8; HASH] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&before).update(bytes);
    *hasher.finalize().as_bytes()
}

/// The unit that begins at `at`, and the hash behind it; nothing if it is not whole.
fn next(file: &mut BufReader<File>, path: &Path, before: [u8; HASH], at: u64) -> Result<Option<(Vec<u8>, [u8; HASH])>> {
    let failed = |e: std::io::Error| Error::io(path, &e);
    let left = file.get_ref().metadata().map_err(failed)?.len().saturating_sub(at);
    let (mut length, mut hash) = ([0; 8], [0; HASH]);
    if left < (8 + HASH) as u64 {
        return Ok(None);
    }
    file.read_exact(&mut length).and_then(|()| file.read_exact(&mut hash)).map_err(failed)?;
    let length = u64::from_le_bytes(length);
    if length > left - (8 + HASH) as u64 {
        return Ok(None);
    }
    let mut bytes = vec![0; length as usize];
    file.read_exact(&mut bytes).map_err(failed)?;
    Ok((hash_of(before, &bytes) == hash).then_some((bytes, hash)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs units until one of them fails; which were made now.
    fn run(path: &Path, inputs: &str, fail_at: usize) -> (Vec<Vec<u8>>, Vec<usize>, bool) {
        let journal = Journal::open(path, inputs);
        let (mut found, mut made) = (Vec::new(), Vec::new());
        for number in 0..6 {
            let unit = journal.unit(&format!("unit {number}"), &mut || {
                if number == fail_at {
                    return Err(Error::new("killed"));
                }
                made.push(number);
                Ok(vec![number as u8; 100 * number])
            });
            match unit {
                Ok(unit) => found.push(unit),
                Err(_) => return (found, made, false),
            }
        }
        journal.finish();
        (found, made, true)
    }

    #[test]
    fn work_goes_on_where_it_was_stopped_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("V.units");
        let (whole, _, _) = run(&path, "a", 9);
        assert!(!path.exists() && whole.len() == 6);
        assert_eq!(run(&path, "a", 3).1, [0, 1, 2]);
        assert!(path.exists());
        assert_eq!(run(&path, "a", 5).1, [3, 4]);
        let (found, made, finished) = run(&path, "a", 9);
        assert_eq!((found, made, finished), (whole.clone(), vec![5], true));
        assert!(!path.exists());
        // Work that is cut otherwise goes on behind what is the same.
        run(&path, "a", 4);
        let journal = Journal::open(&path, "a");
        let mut made = 0;
        for name in ["unit 0", "unit 1", "units 2 to 5", "unit 2"] {
            journal
                .unit(name, &mut || {
                    made += 1;
                    Ok(vec![7])
                })
                .unwrap();
        }
        journal.finish();
        assert_eq!(made, 2);
        // Other work does not take it.
        run(&path, "a", 3);
        assert_eq!(run(&path, "b", 9), (whole, vec![0, 1, 2, 3, 4, 5], true));
    }

    #[test]
    fn no_flipped_bit_and_no_cut_changes_what_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("V.units");
        let (whole, _, _) = run(&path, "a", 9);
        run(&path, "a", 4);
        let kept = std::fs::read(&path).unwrap();
        for place in 0..kept.len() {
            let mut changed = kept.clone();
            changed[place] ^= 1 << (place % 8);
            std::fs::write(&path, &changed).unwrap();
            let (found, made, _) = run(&path, "a", 9);
            assert!(found == whole && made.len() >= 2 && made.len() <= 6, "byte {place}: {made:?}");
            std::fs::write(&path, &kept[..place]).unwrap();
            assert!(run(&path, "a", 9).0 == whole, "cut at {place}");
        }
    }
}

//! Folders of a year: one that goes with it, and copies.

use crate::error::{Error, Result};
use crate::simulate::store::LOCK;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A folder for results that nobody asked a folder for: it is deleted with the last year in it.
#[derive(Debug)]
pub(crate) struct TemporaryFolder(PathBuf);

impl TemporaryFolder {
    /// Makes one among the system's temporary files.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn new() -> Result<Self> {
        static NUMBER: AtomicUsize = AtomicUsize::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("lucarne-{}-{number}", std::process::id()));
        // Not one that is there: it may be somebody else's.
        std::fs::create_dir(&path).map_err(|e| Error::io(&path, &e))?;
        Ok(Self(path))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        // What the system does not let go it deletes itself some day.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Copies a folder with all that is in it; files become links where the system can.
pub(super) fn copy(from: &Path, to: &Path) -> Result<()> {
    std::fs::create_dir_all(to).map_err(|e| Error::io(to, &e))?;
    let same = |path: &Path| std::fs::canonicalize(path).map_err(|e| Error::io(path, &e));
    if same(from)? == same(to)? {
        return Ok(());
    }
    for entry in std::fs::read_dir(from).map_err(|e| Error::io(from, &e))? {
        let entry = entry.map_err(|e| Error::io(from, &e))?;
        let (source, target) = (entry.path(), to.join(entry.file_name()));
        if source.is_dir() {
            copy(&source, &target)?;
            continue;
        }
        // Each folder has a lock of its own.
        if entry.file_name() == LOCK {
            continue;
        }
        // Files are only ever replaced, never written into: two names for one are safe.
        let _ = std::fs::remove_file(&target);
        if std::fs::hard_link(&source, &target).is_err() {
            std::fs::copy(&source, &target).map_err(|e| Error::io(&target, &e))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copied_folder_outlives_the_temporary_one() {
        let there = tempfile::tempdir().unwrap();
        let folder = TemporaryFolder::new().unwrap();
        std::fs::create_dir(folder.path().join("glare")).unwrap();
        std::fs::write(folder.path().join("glare/a.csv"), "1").unwrap();
        std::fs::write(folder.path().join(LOCK), "process 1").unwrap();
        let to = there.path().join("deep/out");
        for _ in 0..2 {
            copy(folder.path(), &to).unwrap();
        }
        copy(&to, &to).unwrap();
        let path = folder.path().to_path_buf();
        drop(folder);
        assert!(!path.exists() && !to.join(LOCK).exists());
        assert_eq!(std::fs::read_to_string(to.join("glare/a.csv")).unwrap(), "1");
    }
}

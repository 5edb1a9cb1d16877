//! Partial files: what is being written, and what a killed program left of it.

use std::collections::HashSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

const PARTIAL: &str = ".partial";

/// Where the bytes of a file go until it is complete: beside it, named after it and the process.
pub(super) fn partial_path(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}{PARTIAL}", std::process::id()));
    path.with_file_name(name)
}

/// Whether a file has the name of a partial one: `NAME.PROCESS.partial`.
fn is_partial(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let Some((_, process)) = name.strip_suffix(PARTIAL).and_then(|rest| rest.rsplit_once('.')) else { return false };
    !process.is_empty() && process.bytes().all(|b| b.is_ascii_digit())
}

/// Removes partial files of a folder that nobody writes any more: a program that was killed left them.
/// Whoever writes one holds a lock on it, which ends with the process.
pub(crate) fn remove_leftovers(folder: &Path) {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|e| e.path()).filter(|p| is_partial(p)) {
        // A link may lead anywhere.
        let is_file = std::fs::symlink_metadata(&path).is_ok_and(|m| m.is_file());
        if is_file && File::open(&path).is_ok_and(|f| f.try_lock().is_ok()) {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// The same, once for each folder and process.
pub(super) fn remove_once(folder: &Path) {
    static SEEN: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    let whole = std::path::absolute(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    if whole.is_ok_and(|path| seen.get_or_insert_default().insert(path)) {
        remove_leftovers(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::AtomicFile;

    #[test]
    fn what_nobody_writes_any_more_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let others = ["V.mtx", "notes.partial", "V.mtx.12x.partial", "V.mtx..partial"];
        for name in others.into_iter().chain(["V.mtx.123.partial"]) {
            std::fs::write(path(name), b"x").unwrap();
        }
        let held = AtomicFile::create(&path("D.mtx"), 10).unwrap();
        remove_leftovers(folder.path());
        assert!(others.iter().all(|name| path(name).exists()));
        assert!(!path("V.mtx.123.partial").exists());
        held.commit().unwrap();
        assert!(path("D.mtx").exists());
    }
}

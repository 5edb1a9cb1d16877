//! Writing files so that nothing half-written is ever left behind.

use crate::error::{Error, Result};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file by writing beside it and renaming when finished, so that readers see either the
/// old file or the complete new one. The partial file is removed on any error.
///
/// # Errors
/// Anything `write` returns, and failures of the file system with the path named.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    write_seekable_atomically(path, |out| write(out))
}

/// As [`write_atomically`], for formats whose writer goes back in the file.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_seekable_atomically(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let partial = partial_path(path);
    let result = (|| {
        let file = File::create(&partial).map_err(|e| Error::io(path, &e))?;
        let mut out = BufWriter::with_capacity(1 << 20, file);
        write(&mut out)?;
        out.flush().map_err(|e| Error::io(path, &e))?;
        drop(out);
        std::fs::rename(&partial, path).map_err(|e| Error::io(path, &e))
    })();
    if result.is_err() {
        // The first error is the one worth reporting; the partial file may not even exist.
        let _ = std::fs::remove_file(&partial);
    }
    result
}

fn partial_path(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.partial", std::process::id()));
    path.with_file_name(name)
}

/// Reads a whole file, naming it in the error.
///
/// # Errors
/// Failures of the file system with the path named.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| Error::io(path, &e))
}

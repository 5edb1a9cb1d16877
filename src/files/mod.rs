//! Writing files so that nothing half-written is ever left behind.

pub mod journal;
mod leftover;
pub mod seal;

pub(crate) use leftover::remove_leftovers;

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
pub(crate) fn write_seekable_atomically(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let mut file = AtomicFile::create(path, 1 << 20)?;
    write(file.writer())?;
    file.commit()
}

/// A file that appears under its name only when it is complete ([`Self::commit`]); dropped before,
/// it leaves nothing behind. For several files written in turns; otherwise [`write_atomically`].
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    partial: PathBuf,
    /// `None` after a commit.
    out: Option<BufWriter<File>>,
}

impl AtomicFile {
    /// Starts a file, with a buffer of so many bytes.
    ///
    /// # Errors
    /// Failures of the file system with the path named.
    pub fn create(path: &Path, buffer: usize) -> Result<Self> {
        let partial = leftover::partial_path(path);
        leftover::remove_once(partial.parent().unwrap_or(Path::new("")));
        // A file of its own: what a link of this name leads to is not written into.
        let _ = std::fs::remove_file(&partial);
        let file = File::create_new(&partial).map_err(|e| Error::io(path, &e))?;
        // Held until it is complete: what nobody holds is left over. A file system without locks has none.
        let _ = file.try_lock();
        Ok(Self { path: path.to_path_buf(), partial, out: Some(BufWriter::with_capacity(buffer, file)) })
    }

    /// Where it will appear.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where its bytes go.
    pub fn writer(&mut self) -> &mut BufWriter<File> {
        self.out.as_mut().expect("committed files are gone")
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// Failures of the file system with the path named; nothing is left behind then.
    pub fn commit(mut self) -> Result<()> {
        let path = self.path.clone();
        let failed = |e: std::io::Error| Error::io(&path, &e);
        self.writer().flush().map_err(failed)?;
        // Windows renames only closed files; dropping the buffer has nothing more to write.
        self.out = None;
        std::fs::rename(&self.partial, &self.path).map_err(|e| {
            let _ = std::fs::remove_file(&self.partial);
            failed(e)
        })
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.writer().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.writer().flush()
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some(out) = self.out.take() {
            // What is in the buffer need not reach the disk.
            drop(out.into_parts().0);
            let _ = std::fs::remove_file(&self.partial);
        }
    }
}

/// Reads a whole file, naming it in the error.
///
/// # Errors
/// Failures of the file system with the path named.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|e| Error::io(path, &e))
}

/// The path that leads from a folder to a file, by way of what both have in common; absolute where
/// that is nothing but the root.
pub fn relative(folder: &Path, file: &Path) -> PathBuf {
    let whole = |p: &Path| std::fs::canonicalize(p).unwrap_or_else(|_| p.to_path_buf());
    let (folder, file) = (whole(folder), whole(file));
    let common = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    if common < 2 {
        return file;
    }
    let up = folder.components().skip(common).map(|_| std::path::Component::ParentDir);
    up.chain(file.components().skip(common)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_lead_back() {
        let root = tempfile::tempdir().unwrap();
        let (out, scene) = (root.path().join("out/office"), root.path().join("scenes"));
        std::fs::create_dir_all(&out).unwrap();
        std::fs::create_dir_all(&scene).unwrap();
        std::fs::write(scene.join("p.toml"), b"x").unwrap();
        let path = relative(&out, &scene.join("p.toml"));
        assert_eq!(path, Path::new("../../scenes/p.toml"));
        assert_eq!(std::fs::read(out.join(path)).unwrap(), b"x");
        assert!(relative(Path::new("/"), &scene.join("p.toml")).is_absolute());
    }
}

//! What is remembered from one start to the next: a small JSON file in the user's configuration folder.

use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Most recent files kept.
const RECENT: usize = 10;

/// The remembered state.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Remembered {
    /// Files opened, the newest first.
    pub recent: Vec<PathBuf>,
    /// `light`, `dark` or empty for the system's choice.
    pub theme: String,
    /// Name of the palette.
    pub palette: String,
    /// Enlargement of text and controls; 0 for the system's.
    pub zoom: f32,
    /// Size of the window, points.
    pub window: Option<[f32; 2]>,
}

impl Remembered {
    /// Where the file lies: `$XDG_CONFIG_HOME/lucarne/viewer.json` and its counterparts.
    pub fn path() -> Option<PathBuf> {
        let folder = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        let base = if cfg!(windows) {
            folder("APPDATA")
        } else if cfg!(target_os = "macos") {
            folder("HOME").map(|h| h.join("Library/Application Support"))
        } else {
            folder("XDG_CONFIG_HOME").or_else(|| folder("HOME").map(|h| h.join(".config")))
        };
        base.map(|b| b.join("lucarne").join("viewer.json"))
    }

    /// Reads the file; anything wrong with it gives a fresh start.
    pub fn read(path: &Path) -> Self {
        std::fs::read(path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
    }

    /// Writes the file. A failure is not worth a message: nothing but comfort is lost.
    pub fn write(&self, path: &Path) {
        if let Some(folder) = path.parent() {
            let _ = std::fs::create_dir_all(folder);
        }
        let _ = lucarne::files::write_atomically(path, |out| {
            serde_json::to_writer_pretty(&mut *out, self).map_err(|e| lucarne::Error::new(e.to_string()))
        });
    }

    /// Puts a file at the head of the recent ones.
    pub fn opened(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        self.recent.retain(|p| *p != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_garbage_is_a_fresh_start() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/viewer.json");
        let mut r = Remembered { theme: "dark".into(), ..Remembered::default() };
        for i in 0..30 {
            r.opened(Path::new(&format!("/files/{}", i % 12)));
        }
        assert_eq!((r.recent.len(), r.recent[0].as_path()), (RECENT, Path::new("/files/5")));
        r.write(&path);
        assert_eq!(Remembered::read(&path), r);
        std::fs::write(&path, b"{\"theme\": 7").unwrap();
        assert_eq!(Remembered::read(&path), Remembered::default());
    }
}

//! The output folder: matrices that remember what they were computed from, and results.

pub(crate) mod fingerprint;
mod sun_coding;
pub(crate) mod sun_pictures;
mod units;

use self::fingerprint::Fingerprint;
use crate::error::{Error, Result, Warnings};
use crate::files::remove_leftovers;
use crate::files::seal::{self, write_sealed};
use crate::matrix::Matrix;
use crate::matrix::file::{Format, MatrixFile, read_matrix, write_matrix_to};
use crate::matrix::rows::MatrixRows;
use crate::simulate::project::Quantity;
use std::collections::{BTreeSet, HashSet};
use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Header key under which a matrix file keeps its [`Fingerprint`].
pub(crate) const INPUTS: &str = "LUCARNE_INPUTS";

/// Folder of what states the façade is in.
const CONTROL: &str = "control";

/// An output folder: `matrices/`, and `illuminance/` or `irradiance/`.
pub struct Store {
    folder: PathBuf,
    /// Name of the folder of the sensors' results.
    results: &'static str,
    /// Other output folders, whose matrices may be taken over.
    others: Vec<PathBuf>,
    /// Nobody else writes into the folder as long as this is held.
    _lock: Option<File>,
    files: Mutex<Files>,
}

/// What is known of the folder's files.
#[derive(Default)]
struct Files {
    /// Those whose checksum was found right.
    whole: HashSet<PathBuf>,
    /// Those whose checksum was not.
    damaged: BTreeSet<PathBuf>,
}

impl Store {
    /// Makes the folders and makes sure that they can be written to, so that a fault is found
    /// before the work and not after it. What a killed run left half-written is removed.
    ///
    /// # Errors
    /// If a folder cannot be made or written to, or another run writes into it.
    #[cfg(test)]
    pub fn open(folder: &Path) -> Result<Self> {
        Self::of(folder, Quantity::Illuminance)
    }

    /// The same for results of a quantity, which have a folder of their own.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn of(folder: &Path, quantity: Quantity) -> Result<Self> {
        for sub in ["matrices", quantity.name()] {
            let path = folder.join(sub);
            let named = |e: std::io::Error| {
                Error::io(&path, &e).field("output folder").help("choose a folder that can be made and written to with -o")
            };
            std::fs::create_dir_all(&path).map_err(named)?;
            let probe = path.join(format!(".{}.partial", std::process::id()));
            let _ = std::fs::remove_file(&probe);
            File::create_new(&probe).map_err(named)?;
            std::fs::remove_file(&probe).map_err(named)?;
        }
        let lock = lock(folder)?;
        remove_leftovers(folder);
        for sub in ["matrices", "illuminance", "illuminance/terms", "irradiance", "irradiance/terms", "glare", "metrics"] {
            remove_leftovers(&folder.join(sub));
        }
        for entry in std::fs::read_dir(folder.join("images")).into_iter().flatten().flatten() {
            remove_leftovers(&entry.path());
        }
        let (folder, results) = (folder.to_path_buf(), quantity.name());
        Ok(Self { folder, results, others: Vec::new(), _lock: lock, files: Mutex::default() })
    }

    /// The same folder, beside others whose files are taken over where they fit.
    #[must_use]
    pub fn beside(mut self, others: Vec<PathBuf>) -> Self {
        self.others = others;
        self
    }

    /// Whether a file of this folder fits, or one of the same name in another folder, which then
    /// becomes this folder's too.
    pub fn has(&self, path: &Path, fits: &dyn Fn(&Path) -> bool) -> bool {
        if fits(path) && self.is_whole(path) {
            return true;
        }
        let Ok(name) = path.strip_prefix(&self.folder) else { return false };
        let Some(other) = self.others.iter().map(|f| f.join(name)).find(|p| fits(p) && self.is_whole(p)) else { return false };
        // Files are only ever replaced, never written into: two names for one are safe.
        let _ = std::fs::remove_file(path);
        std::fs::hard_link(&other, path).is_ok() || std::fs::copy(&other, path).is_ok()
    }

    /// Whether a file is what was written into it. It is read once only: nobody else writes here meanwhile.
    fn is_whole(&self, path: &Path) -> bool {
        let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        if files.whole.contains(path) {
            return true;
        }
        let whole = seal::is_whole(path);
        if whole {
            files.whole.insert(path.to_path_buf())
        } else {
            files.damaged.insert(path.to_path_buf())
        };
        whole
    }

    /// Warns of the files that were damaged since they were written, and had to be made again.
    pub(crate) fn warn_of_damage(&self, warnings: &mut Warnings) {
        let damaged = std::mem::take(&mut self.files.lock().unwrap_or_else(PoisonError::into_inner).damaged);
        for path in damaged {
            let message = "the file has changed since it was written: it was not used, but computed again";
            warnings.push(Error::new(message).file(path).help("if this happens often, check the disk"));
        }
    }

    /// Name of the file with the summary.
    pub(crate) const SUMMARY: &str = "summary.json";

    /// Path of a matrix in an output folder.
    pub(crate) fn matrix_in(folder: &Path, name: &str) -> PathBuf {
        folder.join("matrices").join(format!("{name}.mtx"))
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Path of a matrix.
    pub(crate) fn matrix_path(&self, name: &str) -> PathBuf {
        Self::matrix_in(&self.folder, name)
    }

    /// Path of a file of illuminance (or irradiance), `.mtx` or `.csv`.
    pub(crate) fn results_path(&self, sensors: &str, extension: &str) -> PathBuf {
        self.folder.join(self.results).join(format!("{sensors}.{extension}"))
    }

    /// Path of a table of metrics, in a folder made if need be.
    ///
    /// # Errors
    /// If the folder cannot be made.
    pub(crate) fn metrics_path(&self, name: &str) -> Result<PathBuf> {
        let folder = self.folder.join("metrics");
        std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, &e))?;
        Ok(folder.join(format!("{name}.csv")))
    }

    /// Path of one term of an illuminance, in a folder made if need be.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(crate) fn term_path(&self, sensors: &str, term: &str) -> Result<PathBuf> {
        let folder = self.folder.join(self.results).join("terms");
        std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, &e))?;
        Ok(folder.join(format!("{sensors}_{term}.mtx")))
    }

    /// Folder for the light of a group of windows in a state, or of those without states, made if need be.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(crate) fn states_folder(&self, whose: Option<(&str, &str)>) -> Result<PathBuf> {
        let states = self.folder.join(self.results).join("states");
        let folder = whose.map_or(states.clone(), |(group, state)| states.join(group).join(state));
        std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, &e))?;
        Ok(folder)
    }

    /// Removes the light of states that an earlier run left: its project may have had others.
    pub(crate) fn remove_states(&self) {
        let _ = std::fs::remove_dir_all(self.folder.join(self.results).join("states"));
        let _ = std::fs::remove_dir_all(self.folder.join(CONTROL));
    }

    /// Path of the table of states through the year, in a folder made if need be.
    ///
    /// # Errors
    /// If the folder cannot be made.
    pub(crate) fn schedule_path(&self) -> Result<PathBuf> {
        let folder = self.folder.join(CONTROL);
        std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, &e))?;
        Ok(folder.join("schedule.csv"))
    }

    /// Path of the suns' pictures of a view.
    pub(crate) fn sun_pictures_path(&self, view: &str) -> PathBuf {
        self.folder.join("matrices").join(format!("C_{view}.suns"))
    }

    /// Path of the Radiance file with the suns that were traced.
    pub(crate) fn suns_path(&self) -> PathBuf {
        self.folder.join("matrices").join("suns.rad")
    }

    /// Folder for the pictures of a view, made if need be.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(crate) fn image_folder(&self, view: &str) -> Result<PathBuf> {
        let path = self.folder.join("images").join(view);
        std::fs::create_dir_all(&path).map_err(|e| Error::io(&path, &e))?;
        Ok(path)
    }

    /// Folder for the glare of a state of the façade (empty: of all), made if need be.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(crate) fn glare_folder(&self, state: &str) -> Result<PathBuf> {
        let path = if state.is_empty() { self.folder.join("glare") } else { self.folder.join("glare").join(state) };
        std::fs::create_dir_all(&path).map_err(|e| Error::io(&path, &e))?;
        Ok(path)
    }

    /// Path of the summary.
    pub(crate) fn summary_path(&self) -> PathBuf {
        self.folder.join(Self::SUMMARY)
    }

    /// A matrix of an earlier run, if it was computed from the same inputs and has this shape.
    /// Anything else there is simply computed again.
    pub fn load(&self, name: &str, inputs: Fingerprint, shape: (usize, usize, usize)) -> Option<Matrix<f32>> {
        let path = self.matrix_path(name);
        if !self.has(&path, &|path| is_of(path, inputs, shape)) {
            return None;
        }
        let matrix = self.load_file(name, inputs)?.matrix;
        ((matrix.rows(), matrix.cols(), matrix.components()) == shape).then_some(matrix)
    }

    /// The same with its header, whatever its shape.
    pub(crate) fn load_file(&self, name: &str, inputs: Fingerprint) -> Option<MatrixFile> {
        if !self.has_matrix(name, inputs) {
            return None;
        }
        let file = read_matrix(&self.matrix_path(name)).ok()?;
        (file.value(INPUTS) == Some(inputs.to_string().as_str())).then_some(file)
    }

    /// Whether a matrix of these inputs is there (or in another folder), by its header alone.
    pub(crate) fn has_matrix(&self, name: &str, inputs: Fingerprint) -> bool {
        let line = format!("{INPUTS}={inputs}");
        self.has(&self.matrix_path(name), &|path| MatrixRows::open(path).is_ok_and(|f| f.is_some_and(|f| f.header().contains(&line))))
    }

    /// Keeps a matrix; `about` is a line for its header that says what it is.
    ///
    /// # Errors
    /// Failures of the file system with the path named.
    pub fn save(&self, name: &str, matrix: &Matrix<f32>, inputs: Fingerprint, about: &str) -> Result<()> {
        self.save_with(name, matrix, inputs, about, &[])
    }

    /// The same with further lines of the header.
    ///
    /// # Errors
    /// As [`save`](Self::save).
    pub(crate) fn save_with(&self, name: &str, matrix: &Matrix<f32>, inputs: Fingerprint, about: &str, more: &[String]) -> Result<()> {
        let path = self.matrix_path(name);
        write_sealed(&path, |out| write_matrix_to(out, matrix, Format::Float, &header(inputs, about, more)).map_err(|e| e.file(&path)))
    }
}

/// Writes a matrix that is a result; `about` says what it is.
///
/// # Errors
/// Failures of the file system with the path named.
pub(crate) fn write_stored(path: &Path, matrix: &Matrix<f32>, about: &str) -> Result<()> {
    let header = [software(), format!("CONTENT={about}"), seal::line()];
    write_sealed(path, |out| write_matrix_to(out, matrix, Format::Float, &header).map_err(|e| e.file(path)))
}

/// A matrix of a result folder, or one that somebody else made.
///
/// # Errors
/// A file that cannot be read, or has changed since it was written.
pub(crate) fn read_stored(path: &Path) -> Result<MatrixFile> {
    seal::check(path)?;
    read_matrix(path)
}

/// Whether a matrix file of these inputs and shape is there, by its header alone.
pub(crate) fn is_of(path: &Path, inputs: Fingerprint, shape: (usize, usize, usize)) -> bool {
    let Ok(Some(file)) = MatrixRows::open(path) else { return false };
    file.header().contains(&format!("{INPUTS}={inputs}")) && (file.rows(), file.cols(), file.components()) == shape
}

/// The header line that names the program.
pub(crate) fn software() -> String {
    format!("SOFTWARE=lucarne {}", env!("CARGO_PKG_VERSION"))
}

/// The header of a stored matrix: program, content, inputs, checksum, and what else is to be told.
pub(crate) fn header(inputs: Fingerprint, about: &str, more: &[String]) -> Vec<String> {
    [&[software(), format!("CONTENT={about}"), format!("{INPUTS}={inputs}"), seal::line()], more].concat()
}

/// Name of the file that a run holds a lock on, with its process in it.
pub(crate) const LOCK: &str = ".lock";

/// Keeps other runs out of a folder until the file that it gives is closed; nothing on a file system without locks.
pub(crate) fn lock(folder: &Path) -> Result<Option<File>> {
    let path = folder.join(LOCK);
    let fault = |e: std::io::Error| Error::io(&path, &e).field("output folder");
    // What a link leads to is nobody's lock.
    if std::fs::symlink_metadata(&path).is_ok_and(|m| m.is_symlink()) {
        std::fs::remove_file(&path).map_err(fault)?;
    }
    let mut file = File::options().create(true).read(true).write(true).truncate(false).open(&path).map_err(fault)?;
    match file.try_lock() {
        Ok(()) => {
            let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
            file.set_len(0).and_then(|()| writeln!(file, "process {} {}", std::process::id(), host.trim())).map_err(fault)?;
            Ok(Some(file))
        }
        Err(TryLockError::WouldBlock) => {
            let holder = std::fs::read_to_string(&path).unwrap_or_default();
            Err(Error::new(format!("another run writes into this folder ({})", holder.trim()))
                .file(folder)
                .field("output folder")
                .help("wait until it has ended, or choose another folder with -o"))
        }
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_reused_only_with_the_same_inputs_and_shape() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(&folder.path().join("deep/out")).unwrap();
        let m = Matrix::from_data(2, 3, 1, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        let inputs = *Fingerprint::new("V").add(&1);
        assert!(store.load("V", inputs, (2, 3, 1)).is_none());
        store.save("V", &m, inputs, "a test").unwrap();
        assert_eq!(store.load("V", inputs, (2, 3, 1)), Some(m));
        assert!(store.load("V", inputs, (3, 2, 1)).is_none());
        assert!(store.load("V", *Fingerprint::new("V").add(&2), (2, 3, 1)).is_none());
        std::fs::write(store.matrix_path("V"), b"garbage").unwrap();
        assert!(store.load("V", inputs, (2, 3, 1)).is_none());
    }

    #[test]
    fn a_fitting_matrix_of_another_folder_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        let m = Matrix::from_data(1, 2, 1, vec![1.0, 2.0]).unwrap();
        let inputs = *Fingerprint::new("V").add(&1);
        Store::open(&a).unwrap().save("V", &m, inputs, "a test").unwrap();
        let store = Store::open(&b).unwrap().beside(vec![a.clone()]);
        assert!(store.load("V", *Fingerprint::new("V").add(&2), (1, 2, 1)).is_none());
        assert!(!store.matrix_path("V").exists());
        assert_eq!(store.load("V", inputs, (1, 2, 1)), Some(m.clone()));
        // Now it is this folder's own; a new one leaves the other as it is.
        let other = Matrix::from_data(1, 2, 1, vec![3.0, 4.0]).unwrap();
        store.save("V", &other, inputs, "a test").unwrap();
        drop(store);
        assert_eq!(Store::open(&a).unwrap().load("V", inputs, (1, 2, 1)), Some(m));
        assert_eq!(Store::open(&b).unwrap().load("V", inputs, (1, 2, 1)), Some(other));
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, b"").unwrap();
        let error = Store::open(&file).err().unwrap().to_string();
        assert!(error.contains("output folder") && error.contains("file/matrices") && error.contains("-o"), "{error}");
    }
}

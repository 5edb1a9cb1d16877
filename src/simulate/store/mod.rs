//! The output folder: matrices that remember what they were computed from, and results.

pub(crate) mod fingerprint;
mod sun_coding;
pub(crate) mod sun_pictures;

use self::fingerprint::Fingerprint;
use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::matrix::file::{Format, MatrixFile, read_matrix, write_matrix};
use crate::matrix::rows::MatrixRows;
use crate::simulate::project::Quantity;
use std::path::{Path, PathBuf};

/// Header key under which a matrix file keeps its [`Fingerprint`].
pub(crate) const INPUTS: &str = "LUCARNE_INPUTS";

/// An output folder: `matrices/`, and `illuminance/` or `irradiance/`.
pub struct Store {
    folder: PathBuf,
    /// Name of the folder of the sensors' results.
    results: &'static str,
    /// Other output folders, whose matrices may be taken over.
    others: Vec<PathBuf>,
}

impl Store {
    /// Makes the folders and makes sure that they can be written to, so that a fault is found
    /// before the work and not after it.
    ///
    /// # Errors
    /// If a folder cannot be made or written to.
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
            std::fs::write(&probe, b"").map_err(named)?;
            std::fs::remove_file(&probe).map_err(named)?;
        }
        Ok(Self { folder: folder.to_path_buf(), others: Vec::new(), results: quantity.name() })
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
        if fits(path) {
            return true;
        }
        let Ok(name) = path.strip_prefix(&self.folder) else { return false };
        let Some(other) = self.others.iter().map(|f| f.join(name)).find(|p| fits(p)) else { return false };
        // Files are only ever replaced, never written into: two names for one are safe.
        let _ = std::fs::remove_file(path);
        std::fs::hard_link(&other, path).is_ok() || std::fs::copy(&other, path).is_ok()
    }

    /// Name of the file with the summary.
    pub const SUMMARY: &str = "summary.json";

    /// Path of a matrix in an output folder.
    pub fn matrix_in(folder: &Path, name: &str) -> PathBuf {
        folder.join("matrices").join(format!("{name}.mtx"))
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Path of a matrix.
    pub fn matrix_path(&self, name: &str) -> PathBuf {
        Self::matrix_in(&self.folder, name)
    }

    /// Path of a file of illuminance (or irradiance), `.mtx` or `.csv`.
    pub fn results_path(&self, sensors: &str, extension: &str) -> PathBuf {
        self.folder.join(self.results).join(format!("{sensors}.{extension}"))
    }

    /// Path of one term of an illuminance, in a folder made if need be.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn term_path(&self, sensors: &str, term: &str) -> Result<PathBuf> {
        let folder = self.folder.join(self.results).join("terms");
        std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, &e))?;
        Ok(folder.join(format!("{sensors}_{term}.mtx")))
    }

    /// Path of the suns' pictures of a view.
    pub fn sun_pictures_path(&self, view: &str) -> PathBuf {
        self.folder.join("matrices").join(format!("C_{view}.suns"))
    }

    /// Path of the Radiance file with the suns that were traced.
    pub fn suns_path(&self) -> PathBuf {
        self.folder.join("matrices").join("suns.rad")
    }

    /// Folder for the pictures of a view, made if need be.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn image_folder(&self, view: &str) -> Result<PathBuf> {
        let path = self.folder.join("images").join(view);
        std::fs::create_dir_all(&path).map_err(|e| Error::io(&path, &e))?;
        Ok(path)
    }

    /// Folder for the glare of a state of the façade (empty: of all), made if need be.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn glare_folder(&self, state: &str) -> Result<PathBuf> {
        let path = if state.is_empty() { self.folder.join("glare") } else { self.folder.join("glare").join(state) };
        std::fs::create_dir_all(&path).map_err(|e| Error::io(&path, &e))?;
        Ok(path)
    }

    /// Path of the summary.
    pub fn summary_path(&self) -> PathBuf {
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
    pub fn load_file(&self, name: &str, inputs: Fingerprint) -> Option<MatrixFile> {
        if !self.has_matrix(name, inputs) {
            return None;
        }
        let file = read_matrix(&self.matrix_path(name)).ok()?;
        (file.value(INPUTS) == Some(inputs.to_string().as_str())).then_some(file)
    }

    /// Whether a matrix of these inputs is there (or in another folder), by its header alone.
    pub fn has_matrix(&self, name: &str, inputs: Fingerprint) -> bool {
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
    pub fn save_with(&self, name: &str, matrix: &Matrix<f32>, inputs: Fingerprint, about: &str, more: &[String]) -> Result<()> {
        let own = [software(), format!("CONTENT={about}"), format!("{INPUTS}={inputs}")];
        write_matrix(Some(&self.matrix_path(name)), matrix, Format::Float, &[&own, more].concat())
    }
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

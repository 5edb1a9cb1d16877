//! The year as arrays, and where its files are.

use super::files::{self, TemporaryFolder};
use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::scene::points::faces_up;
use crate::simulate::project::Quantity;
use crate::simulate::results::glare::read::{GlareYear, read_years};
use crate::simulate::results::illuminance::read_table;
use crate::simulate::results::metrics::{self, SensorTable};
use crate::simulate::results::pictures::PictureView;
use crate::simulate::store::{Store, lock, read_stored};
use crate::simulate::summary::Summary;
use crate::weather::time::Time;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A year of light.
#[derive(Debug, Clone)]
pub struct Year {
    /// What was computed, how, and how well it is known.
    pub summary: Summary,
    /// Local standard time of each step: columns of the illuminances.
    pub times: Vec<Time>,
    /// One per `[[sensors]]`.
    pub sensors: Vec<Sensors>,
    /// Views whose pictures can be computed; see [`picture`](Self::picture).
    pub views: Vec<ViewFile>,
    /// Glare of every view, and of every state of the façade.
    pub glare: Vec<GlareYear>,
    /// What is missing of the folder, in words.
    pub notes: Vec<String>,
    folder: PathBuf,
    /// Keeps a folder that nobody asked for as long as its year.
    temporary: Option<Arc<TemporaryFolder>>,
}

/// A group of sensors over the year.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensors {
    /// Its name.
    pub name: String,
    /// Positions, m; empty if the folder does not tell.
    pub positions: Vec<DVec3>,
    /// Directions they face, of unit length; empty if the project is not known.
    pub directions: Vec<DVec3>,
    /// Illuminance `[sensor][step]`, lx.
    pub illuminance: Arc<Matrix<f32>>,
    /// Its standard error, lx, if the folder has it.
    pub standard_error: Option<Matrix<f32>>,
    /// What metrics count of each sensor; empty if the folder does not have it.
    pub metrics: SensorTable,
}

impl Sensors {
    /// Sensors of which the illuminance alone is known.
    pub fn new(name: &str, illuminance: Matrix<f32>) -> Self {
        Self {
            name: name.into(),
            positions: Vec::new(),
            directions: Vec::new(),
            illuminance: Arc::new(illuminance),
            standard_error: None,
            metrics: SensorTable::default(),
        }
    }

    /// Number of sensors.
    pub fn count(&self) -> usize {
        self.illuminance.rows()
    }

    /// Whether a sensor measures the plan: it faces up, or nothing tells where it faces.
    pub fn is_of_plan(&self, sensor: usize) -> bool {
        self.directions.get(sensor).is_none_or(|d| faces_up(*d))
    }
}

/// A view whose pictures can be computed.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewFile {
    /// Its name.
    pub name: String,
    /// File of its view matrix: rows pixels from the top left, columns bins, RGB.
    pub matrix: PathBuf,
    /// Pixels per row.
    pub width: usize,
    /// Rows of pixels.
    pub height: usize,
    /// Columns of the matrix.
    pub bins: usize,
    /// The view as Radiance options.
    pub options: Option<String>,
}

impl ViewFile {
    fn open(folder: &Path, name: &str) -> Result<Self> {
        let matrix = Store::matrix_in(folder, &format!("V_{name}"));
        let view = PictureView::open_matrix(&matrix, None)?;
        Ok(Self { name: name.into(), width: view.width, height: view.height, bins: view.bins, options: view.view, matrix })
    }

    /// File of the part of the view matrix without diffuse reflection.
    pub fn direct_matrix(&self) -> PathBuf {
        self.matrix.with_file_name(format!("V_{}_direct.mtx", self.name))
    }

    /// File of the suns' pictures.
    pub fn suns(&self) -> PathBuf {
        self.matrix.with_file_name(format!("C_{}.suns", self.name))
    }
}

impl Year {
    /// Reads the folder of an earlier run.
    ///
    /// # Errors
    /// A folder without results, and illuminances that cannot be read. Views that cannot be shown are
    /// [`notes`](Self::notes).
    pub fn open(folder: &Path) -> Result<Self> {
        let summary = Summary::read(folder)?;
        let mut times = Vec::new();
        let mut sensors = Vec::new();
        let solar = summary.quantity == Quantity::Irradiance.name();
        for name in summary.sensors.iter().map(|s| s.name.as_str()).filter(|_| !solar) {
            let (group, own) = read_sensors(folder, name)?;
            if own.len() == group.illuminance.cols() {
                times = own;
            }
            sensors.push(group);
        }
        let steps = sensors.first().map_or_else(|| summary.steps(), |g| g.illuminance.cols());
        if times.len() != steps {
            times = Time::common_year(steps);
        }
        let (mut views, mut notes) = (Vec::new(), Vec::new());
        if solar {
            notes.push("the sensors' results are irradiance, in the folder irradiance/; only illuminance is shown".into());
        }
        for name in summary.views.iter().map(|v| v.name.as_str()) {
            match ViewFile::open(folder, name) {
                Ok(view) => views.push(view),
                Err(e) => notes.push(format!("view '{name}' cannot be shown: {e}")),
            }
        }
        let glare = read_years(&folder.join("glare"), steps, &mut notes);
        Ok(Self { summary, times, sensors, views, glare, notes, folder: folder.to_path_buf(), temporary: None })
    }

    /// A year of illuminance from a matrix alone, with the table beside it if there is one.
    pub fn of_illuminance(path: &Path, illuminance: Matrix<f32>) -> Self {
        let steps = illuminance.cols();
        let mut sensors = Sensors::new(&path.file_stem().unwrap_or_default().to_string_lossy(), illuminance);
        let (positions, times) = read_table(&path.with_extension("csv")).unwrap_or_default();
        if positions.len() == sensors.count() {
            sensors.positions = positions;
        }
        Self {
            summary: Summary::default(),
            times: if times.len() == steps { times } else { Time::common_year(steps) },
            sensors: vec![sensors],
            views: Vec::new(),
            glare: Vec::new(),
            notes: Vec::new(),
            folder: path.to_path_buf(),
            temporary: None,
        }
    }

    /// The same year, whose folder goes with it.
    pub(in crate::simulate) fn in_temporary(mut self, folder: TemporaryFolder) -> Self {
        self.temporary = Some(Arc::new(folder));
        self
    }

    /// The folder it is in.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Path of a matrix by its name, `V_desk` or `S`.
    pub fn matrix(&self, name: &str) -> PathBuf {
        Store::matrix_in(&self.folder, name)
    }

    /// Writes all files into another folder, which a later run can go on in. Files there of the same
    /// name are replaced.
    ///
    /// # Errors
    /// Failures of the file system with the path named, and a folder that a run writes into.
    pub fn write(&self, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, &e))?;
        let _lock = lock(folder)?;
        files::copy(&self.folder, folder)
    }
}

/// A group of sensors from its files, and the times its table has.
fn read_sensors(folder: &Path, name: &str) -> Result<(Sensors, Vec<Time>)> {
    let file = |name: &str, extension: &str| folder.join("illuminance").join(format!("{name}.{extension}"));
    let mut sensors = Sensors::new(name, read_stored(&file(name, "mtx"))?.matrix);
    let (positions, times) = read_table(&file(name, "csv")).unwrap_or_default();
    if positions.len() == sensors.count() {
        sensors.positions = positions;
    }
    let error = file(&format!("{name}_standard_error"), "mtx");
    let error = if error.exists() { Some(read_stored(&error)?.matrix) } else { None };
    sensors.standard_error = error.filter(|e| (e.rows(), e.cols()) == (sensors.illuminance.rows(), sensors.illuminance.cols()));
    let metrics = metrics::read_sensors(&file(&format!("{name}_annual"), "csv")).unwrap_or_default();
    if metrics.rows.len() == sensors.count() {
        sensors.metrics = metrics;
    }
    Ok((sensors, times))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eyes_and_ceilings_are_not_of_the_plan() {
        let mut group = Sensors::new("desks", Matrix::zeros(3, 1, 1));
        group.directions = vec![DVec3::Z, DVec3::Y, DVec3::NEG_Z];
        assert_eq!([0, 1, 2].map(|s| group.is_of_plan(s)), [true, false, false]);
        group.directions.clear();
        assert!(group.is_of_plan(1), "without the project nothing tells where they face");
    }

    #[test]
    fn a_folder_without_results_is_told_so() {
        let folder = tempfile::tempdir().unwrap();
        let error = Year::open(folder.path()).err().unwrap().to_string();
        assert!(error.contains("summary.json") && error.contains("lucarne run"), "{error}");
    }
}

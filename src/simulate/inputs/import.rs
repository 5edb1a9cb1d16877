//! Matrices made elsewhere – by Radiance, or by an earlier run – in place of those traced here.
//!
//! | key | section | matrix | made by |
//! |---|---|---|---|
//! | `view`, `view_matrix/direct` | `[[sensors]]` | V, Vd: rows sensors, columns the bins of all windows in the project's order | `rfluxmtx -I+`; the same in a black room with `-ab 1` |
//! | `sun` | `[[sensors]]` | Cds: rows sensors, columns the ground and all suns of MF:n, or the suns of an earlier run's `suns.rad` | `rcontrib -I+ -m solar` |
//! | `daylight`, `daylight_direct` | `[[window]]` | D, Dd: rows bins, columns patches, the ground first | `rfluxmtx`; the same with `-ab 0` |
//!
//! They have no standard error of their own: the results' counts them as exact.

use crate::error::{Error, Result};
use crate::kernels::sun_matrix::SunMatrix;
use crate::matrix::Matrix;
use crate::matrix::file::read_matrix;
use crate::simulate::inputs::suns::SunSet;
use crate::simulate::project::given::ImportSection;
use crate::simulate::store::fingerprint::Fingerprint;
use std::path::Path;

/// A matrix made elsewhere, RGB.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The whole.
    pub total: Matrix<f32>,
    /// Its direct part.
    pub direct: Option<Matrix<f32>>,
}

impl Imported {
    /// Reads both.
    ///
    /// # Errors
    /// What is wrong in which file; another shape than `rows` × `columns`.
    pub fn load(section: &ImportSection, rows: usize, columns: usize, shape: &str) -> Result<Self> {
        let total = read(&section.total, rows, Some(columns), shape)?;
        let direct = section.direct.as_deref().map(|file| read(file, rows, Some(columns), shape)).transpose()?;
        Ok(Self { total, direct })
    }

    /// Tells what is computed from it from what is traced.
    pub fn mark(&self, inputs: &mut Fingerprint) {
        inputs.add(&"imported").add_values(self.total.data()).add_values(self.direct.as_ref().map_or(&[], Matrix::data));
    }
}

/// A matrix file as RGB; all columns are right if none are named.
fn read(file: &Path, rows: usize, columns: Option<usize>, shape: &str) -> Result<Matrix<f32>> {
    let matrix = read_matrix(file)?.matrix;
    if matrix.rows() != rows || columns.is_some_and(|c| matrix.cols() != c) {
        let wanted = columns.map_or_else(|| rows.to_string(), |c| format!("{rows} x {c}"));
        return Err(Error::new(format!("the matrix has {} rows and {} columns, the project needs {wanted}", matrix.rows(), matrix.cols()))
            .file(file)
            .help(format!("{shape}; rfluxmtx and rcontrib write the number of rows with -y")));
    }
    if let Some(i) = matrix.data().iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        let (row, column) = (i / matrix.components() / matrix.cols(), i / matrix.components() % matrix.cols());
        return Err(Error::new(format!("row {}, column {} holds {}", row + 1, column + 1, matrix.data()[i]))
            .file(file)
            .help("coefficients are finite and not negative"));
    }
    match matrix.components() {
        3 => Ok(matrix),
        1 => Matrix::from_data(matrix.rows(), matrix.cols(), 3, matrix.data().iter().flat_map(|v| [*v; 3]).collect()),
        n => Err(Error::new(format!("the matrix has {n} components")).file(file).help("matrices have one component or three (RGB)")),
    }
}

/// A sun matrix made elsewhere for sensors of one group: columns of the suns of `set`, in its order.
///
/// # Errors
/// What is wrong in the file; columns that are neither all suns of the scheme nor those traced.
pub(crate) fn sun_matrix(file: &Path, sensors: usize, set: &SunSet) -> Result<Matrix<f32>> {
    let all = read(file, sensors, None, "a sun matrix has a row per sensor")?;
    let columns: Vec<usize> = match all.cols() {
        n if n == set.suns.len() => (0..n).collect(),
        n if n == set.all_columns => set.columns.clone(),
        n => {
            return Err(Error::new(format!(
                "the sun matrix has {n} columns, one per sun; suns {} need {}",
                set.census.scheme, set.all_columns
            ))
            .file(file)
            .help(format!("or {}, the suns that an earlier run of this project lists in suns.rad", set.suns.len())));
        }
    };
    let data = (0..sensors).flat_map(|row| columns.iter().flat_map(|c| all.at(row, *c).to_vec()).collect::<Vec<_>>()).collect();
    Matrix::from_data(sensors, columns.len(), 3, data)
}

/// The sun matrix of all groups, if their project names one; direct and without error.
///
/// # Errors
/// As [`sun_matrix`]; files for some groups only.
pub(crate) fn sun_matrices<'a>(
    groups: impl Iterator<Item = (&'a str, Option<&'a Path>, usize)>,
    set: &SunSet,
) -> Result<Option<SunMatrix>> {
    let groups: Vec<_> = groups.collect();
    if groups.iter().all(|(_, file, _)| file.is_none()) {
        return Ok(None);
    }
    let (mut data, mut rows) = (Vec::new(), 0);
    for (name, file, sensors) in groups {
        let file = file.ok_or_else(|| partly(name, "sun"))?;
        data.extend(sun_matrix(file, sensors, set)?.into_data());
        rows += sensors;
    }
    let total = Matrix::from_data(rows, set.suns.len(), 3, data)?;
    Ok(Some(SunMatrix { direct: total.clone(), total, ..SunMatrix::zeros(rows, set.suns.len()) }))
}

/// V of all groups, if their project names files for it.
///
/// # Errors
/// Files for some groups only.
pub(crate) fn view<'a>(groups: impl Iterator<Item = (&'a str, Option<&'a Imported>)>, bins: usize) -> Result<Option<Imported>> {
    let groups: Vec<_> = groups.collect();
    if groups.iter().all(|(_, given)| given.is_none()) {
        return Ok(None);
    }
    let (mut total, mut direct, mut rows) = (Vec::new(), Some(Vec::new()), 0);
    for (name, given) in groups {
        let given = given.ok_or_else(|| partly(name, "view"))?;
        rows += given.total.rows();
        total.extend_from_slice(given.total.data());
        direct = direct.zip(given.direct.as_ref()).map(|(mut all, part)| {
            all.extend_from_slice(part.data());
            all
        });
    }
    let matrix = |data| Matrix::from_data(rows, bins, 3, data);
    Ok(Some(Imported { total: matrix(total)?, direct: direct.map(matrix).transpose()? }))
}

fn partly(name: &str, key: &str) -> Error {
    Error::new(format!("other sensors have a matrix '{key}', '{name}' has none"))
        .field(format!("sensors '{name}'"))
        .help(format!("give '{key}' to all [[sensors]] or to none"))
}

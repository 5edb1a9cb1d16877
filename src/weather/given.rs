//! A sky made elsewhere: measured, or by another program, in place of Perez' sky of the records.

use crate::matrix::Matrix;
use std::fmt;
use std::sync::Arc;

/// Matrices of a sky, columns the time steps, in the order of gendaymtx: the ground, then Reinhart's patches, RGB,
/// W/m²sr. Copies share them.
#[derive(Clone, PartialEq)]
pub struct GivenSky {
    /// S `[patch][step]`.
    pub whole: Arc<Matrix<f32>>,
    /// Sds `[patch][step]`, the sun's share of S; nothing if it was not given.
    pub direct: Option<Arc<Matrix<f32>>>,
    /// Subdivision of the suns, and per step the sun's patch and the radiance of its disc, W/m²sr.
    pub suns: Option<(usize, Vec<Option<(usize, f64)>>)>,
    /// Hash of the contents.
    pub hash: String,
}

/// The hash stands for the values.
impl fmt::Debug for GivenSky {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sky {} of {} steps", self.hash, self.whole.cols())
    }
}

impl GivenSky {
    /// The sky of some of the steps.
    pub(super) fn columns(&self, kept: &[usize]) -> Self {
        let of = |m: &Matrix<f32>| {
            let n = m.components();
            let row = |r: usize| kept.iter().flat_map(move |c| m.row(r)[c * n..(c + 1) * n].iter().copied());
            let data = (0..m.rows()).flat_map(row).collect();
            Arc::new(Matrix::from_data(m.rows(), kept.len(), n, data).expect("whole columns"))
        };
        let suns = self.suns.as_ref().map(|(mf, all)| (*mf, kept.iter().map(|c| all[*c]).collect()));
        let hash = blake3::hash(format!("{} {kept:?}", self.hash).as_bytes()).to_hex().to_string();
        Self { whole: of(&self.whole), direct: self.direct.as_deref().map(of), suns, hash }
    }
}

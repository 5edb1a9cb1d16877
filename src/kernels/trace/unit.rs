//! Units of long work as bytes, so that what was finished before a stop is taken from there
//! ([`Progress::unit`]).

use super::{TraceStatistics, TracedMatrix};
use crate::error::{Error, Result};
use crate::matrix::Matrix;
use crate::progress::Progress;
use std::ops::Range;

/// The values that a unit of work leaves behind: they are put into bytes, or taken from them, by the same code.
pub(crate) enum Values {
    /// Bytes so far.
    Put(Vec<u8>),
    /// Bytes, and how many of them were taken.
    Taken(Vec<u8>, usize),
}

impl Values {
    /// # Errors
    /// If there are no such values left.
    pub fn pass<T: bytemuck::AnyBitPattern + bytemuck::NoUninit>(&mut self, values: &mut [T]) -> Result<()> {
        match self {
            Self::Put(bytes) => bytes.extend_from_slice(bytemuck::cast_slice(values)),
            Self::Taken(bytes, at) => {
                let place = bytemuck::cast_slice_mut::<T, u8>(values);
                let found = bytes.get(*at..*at + place.len());
                place.copy_from_slice(found.ok_or_else(|| Error::new("a kept unit of work has another size than the work"))?);
                *at += place.len();
            }
        }
        Ok(())
    }

    /// # Errors
    /// As [`pass`](Self::pass).
    pub fn pass_work(&mut self, work: &mut TraceStatistics) -> Result<()> {
        let mut counts = [work.paths, work.segments];
        self.pass(&mut counts)?;
        *work = TraceStatistics { paths: counts[0], segments: counts[1] };
        Ok(())
    }

    /// Some rows of a matrix.
    ///
    /// # Errors
    /// As [`pass`](Self::pass).
    pub fn pass_rows(&mut self, matrix: &mut Matrix<f32>, rows: Range<usize>) -> Result<()> {
        let width = matrix.cols() * matrix.components();
        self.pass(&mut matrix.data_mut()[rows.start * width..rows.end * width])
    }

    /// The same of a traced matrix, and the work done for it so far.
    ///
    /// # Errors
    /// As [`pass`](Self::pass).
    pub fn pass_traced(&mut self, traced: &mut TracedMatrix, rows: &Range<usize>) -> Result<()> {
        self.pass_work(&mut traced.statistics)?;
        let batches = traced.batches.iter_mut().flat_map(|b| [&mut b.total, &mut b.direct].into_iter().chain(b.sunlit.as_mut()));
        let all = [&mut traced.total, &mut traced.direct, &mut traced.standard_error].into_iter().chain(batches);
        all.into_iter().try_for_each(|part| self.pass_rows(part, rows.clone()))
    }
}

/// Does a unit of work on `state`, or takes what it left there in an earlier run: all that `values` passes. Its name
/// tells how the work is cut.
///
/// # Errors
/// Those of `make` and of [`Progress::unit`].
pub(crate) fn unit<T>(
    progress: &dyn Progress,
    name: &str,
    state: &mut T,
    make: &mut dyn FnMut(&mut T) -> Result<()>,
    values: &dyn Fn(&mut T, &mut Values) -> Result<()>,
) -> Result<()> {
    let mut made = false;
    let bytes = progress.unit(name, &mut || {
        make(state)?;
        made = true;
        let mut put = Values::Put(Vec::new());
        values(state, &mut put)?;
        let Values::Put(bytes) = put else { unreachable!("it was made so") };
        Ok(bytes)
    })?;
    if made { Ok(()) } else { values(state, &mut Values::Taken(bytes, 0)) }
}

//! Keys that name matrices and pictures made elsewhere, in place of those that a run would trace.

use super::table::Table;
use crate::error::Result;
use crate::image::series::Pattern;
use std::path::PathBuf;

/// Files of a matrix and of its direct part.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportSection {
    /// The whole.
    pub total: PathBuf,
    /// Its direct part; five phases need it.
    pub direct: Option<PathBuf>,
}

impl ImportSection {
    /// The section's keys for the whole and for its direct part.
    ///
    /// # Errors
    /// Values that are no files; a direct part alone.
    pub(super) fn read(table: &mut Table<'_, '_>, whole: &'static str, direct_key: &'static str) -> Result<Option<Self>> {
        let (total, direct) = (table.path(whole)?, table.path(direct_key)?);
        match (total, direct) {
            (None, Some(_)) => Err(table
                .error(direct_key, format!("'{direct_key}' is part of a matrix '{whole}', which is not given"))
                .help("give both, or neither: they are then traced together")),
            (total, direct) => Ok(total.map(|total| Self { total, direct })),
        }
    }
}

/// Pictures made elsewhere.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GivenPictures {
    /// V.
    pub view: Option<Pattern>,
    /// Vd.
    pub view_direct: Option<Pattern>,
    /// C.
    pub sun: Option<Pattern>,
}

impl GivenPictures {
    /// The keys of a `[[view]]`.
    pub(super) fn read(table: &mut Table<'_, '_>) -> Result<Self> {
        let given = Self { view: table.pattern("view")?, view_direct: table.pattern("view_direct")?, sun: table.pattern("sun")? };
        if given.view.is_none() && given.view_direct.is_some() {
            return Err(table
                .error("view_direct", "'view_direct' is part of pictures 'view', which are not given")
                .help("give both, or neither: they are then traced together"));
        }
        Ok(given)
    }
}

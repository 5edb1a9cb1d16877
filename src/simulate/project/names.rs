//! Names that become parts of file names.

use super::table::Table;
use crate::error::Result;

/// A name that can be part of a file name on every system.
pub(super) fn name(table: &mut Table<'_, '_>, help: &str) -> Result<String> {
    let name = table.required_string("name", help)?;
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
    if name.starts_with('.') || name.len() > 100 || !name.chars().all(allowed) {
        return Err(table
            .error("name", format!("'{name}' cannot be part of a file name"))
            .help("use letters, digits, '-', '_', '.' and blanks, at most 100"));
    }
    Ok(name)
}

//! Names that become parts of file names.

use super::table::Table;
use crate::error::Result;

/// What is put behind names to call further files of their results.
pub(super) const ENDINGS: [&str; 9] =
    ["_direct", "_standard_error", "_own_standard_error", "_shared_standard_error", "_batches", "_annual", "_sky", "_eye", "_windows"];

/// Names of devices, which no file on Windows can have, whatever its ending.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// A name that can be part of a file name on every system.
pub(super) fn name(table: &mut Table<'_, '_>, help: &str) -> Result<String> {
    let name = table.required_string("name", help)?;
    check(table, "name", &name)?;
    Ok(name)
}

/// Whether a text can be such a name.
pub(super) fn check(table: &Table<'_, '_>, key: &str, name: &str) -> Result<()> {
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
    let ends_well = !name.starts_with(['.', ' ']) && !name.ends_with(['.', ' ']);
    if !ends_well || name.len() > 100 || !name.chars().all(allowed) || is_device(name) {
        return Err(table
            .error(key, format!("'{name}' cannot be part of a file name on every system"))
            .help("use letters, digits, '-', '_', and '.' or blanks within, at most 100; no name of a device (con, nul, com1)"));
    }
    Ok(())
}

/// Whether two names are the same: capitals do not count.
pub(crate) fn alike(a: &str, b: &str) -> bool {
    a.to_lowercase() == b.to_lowercase()
}

fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().to_lowercase();
    let numbered = |port: &str| stem.strip_prefix(port).is_some_and(|n| n.len() == 1 && n.as_bytes()[0].is_ascii_digit());
    DEVICES.contains(&stem.as_str()) || numbered("com") || numbered("lpt")
}

//! `parts` of a `[[window]]`: over what V and D are averaged.

use super::table::Table;
use crate::error::Result;

/// Most parts of a window.
pub(in crate::simulate) const MOST_PARTS: usize = 256;

/// Into how many parts a window is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parts {
    /// As many as a first look at the scene says.
    Auto,
    /// So many, as square as they can be.
    Number(usize),
    /// Columns and rows over the rectangle that holds the window.
    Grid([usize; 2]),
}

impl Default for Parts {
    /// The whole window.
    fn default() -> Self {
        Self::Number(1)
    }
}

impl Parts {
    pub(super) fn read(table: &mut Table<'_, '_>) -> Result<Self> {
        const HELP: &str = "write \"auto\", a number from 1 (the whole window) to 256, or [columns, rows] of no more parts together";
        const KEY: &str = "parts";
        let limits = 1..=MOST_PARTS as u64;
        if !table.is_list(KEY) {
            let found = table.integer_or_choice(KEY, limits, &["auto"]).map_err(|e| e.help(HELP))?;
            return Ok(found.map_or_else(Self::default, |n| n.map_or(Self::Auto, |n| Self::Number(n as usize))));
        }
        let numbers = table.integers(KEY, limits).map_err(|e| e.help(HELP))?.unwrap_or_default();
        match numbers[..] {
            [columns, rows] if columns * rows <= MOST_PARTS as u64 => Ok(Self::Grid([columns as usize, rows as usize])),
            [columns, rows] => {
                Err(table.error(KEY, format!("{columns} × {rows} are {} parts, more than {MOST_PARTS}", columns * rows)).help(HELP))
            }
            _ => Err(table.error(KEY, format!("a list of parts has two numbers, columns and rows, not {}", numbers.len())).help(HELP)),
        }
    }
}

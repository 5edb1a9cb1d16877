//! A project file as text, and places in it.

use crate::error::{Error, Result};
use crate::text;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A whole TOML file as text, kept for line numbers.
pub(super) struct Document<'a> {
    pub(super) file: &'a Path,
    text: &'a str,
}

impl<'a> Document<'a> {
    /// A document around its text; `file` is named in errors and is what paths are relative to.
    pub(super) fn new(file: &'a Path, text: &'a str) -> Self {
        Self { file, text }
    }

    /// Parses the text into its top table.
    ///
    /// # Errors
    /// If it is not TOML.
    pub(super) fn parse(&self) -> Result<DeTable<'a>> {
        DeTable::parse(self.text).map(Spanned::into_inner).map_err(|e| {
            let error = self.error_at(e.span().map_or(0, |s| s.start), e.message().trim().replace('\n', " "));
            let line = self.text.lines().nth(e.span().map_or(0, |s| self.line_at(s.start) - 1)).unwrap_or_default();
            let value = line.split_once('=').map_or("", |(_, value)| value.trim());
            if text::why_no_number(value).is_empty() {
                return error.help("see https://toml.io for how such files are written");
            }
            error.help(format!("write a point in place of the comma: {}", value.replacen(',', ".", 1)))
        })
    }

    pub(super) fn error_at(&self, offset: usize, message: impl Into<String>) -> Error {
        Error::new(message).file(self.file).line(self.line_at(offset))
    }

    pub(super) fn line_at(&self, offset: usize) -> usize {
        1 + self.text.as_bytes()[..offset.min(self.text.len())].iter().filter(|&&b| b == b'\n').count()
    }
}

/// Where a key of a project file stands: for faults of its value that show only later.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    pub(super) file: PathBuf,
    pub(super) line: usize,
    pub(super) field: String,
}

impl Place {
    /// The error with this place, unless it names one.
    pub fn of(&self, error: Error) -> Error {
        error.file(&self.file).line(self.line).field(&self.field)
    }
}

/// Where the sections of a project stand, or the first of several; the file's first line for those left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Places {
    pub(super) window: Place,
    pub(super) sensors: Place,
    pub(super) view: Place,
    pub(super) images: Place,
}

/// What a value is, in words.
pub(super) fn kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a section",
    }
}

//! Reading TOML tables so that every complaint names the file, the line and the key, and a
//! misspelt key is answered with the one that was probably meant.

#[cfg(test)]
pub(super) mod asked;
mod lists;

pub(super) use lists::Named;

use super::document::kind;
pub(super) use super::document::{Document, Place};
use crate::error::{Error, Result};
use crate::image::series::Pattern;
use crate::scene::{Format, split_part};
use crate::text::nearest;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// One table being read. Every key that is asked for is remembered as known; [`finish`](Self::finish)
/// refuses the rest. Their texts stand in [`keys`](super::keys), which a test holds to what is asked for.
pub(super) struct Table<'d, 'a> {
    document: &'d Document<'a>,
    /// `weather`, `window 2`, … for messages; empty for the top.
    name: String,
    entries: &'d DeTable<'a>,
    /// Where the table starts, for complaints about what it lacks.
    offset: usize,
    known: Vec<&'static str>,
}

impl<'d, 'a> Table<'d, 'a> {
    /// The top table of a document.
    pub(super) fn top(document: &'d Document<'a>, entries: &'d DeTable<'a>) -> Self {
        Self { document, name: String::new(), entries, offset: 0, known: Vec::new() }
    }

    fn get(&mut self, key: &'static str) -> Option<&'d Spanned<DeValue<'a>>> {
        #[cfg(test)]
        asked::note(&self.name, key);
        if !self.known.contains(&key) {
            self.known.push(key);
        }
        self.entries.get(key)
    }

    /// Whether a key has a list.
    pub(super) fn is_list(&mut self, key: &'static str) -> bool {
        matches!(self.get(key).map(Spanned::get_ref), Some(DeValue::Array(_)))
    }

    fn field(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_string() } else { format!("{}.{key}", self.name) }
    }

    /// An error about the value of a key, with its place.
    pub(super) fn error(&self, key: &str, message: impl Into<String>) -> Error {
        self.place(key).of(Error::new(message))
    }

    /// Where a key stands, or its table if it is left out.
    pub(super) fn place(&self, key: &str) -> Place {
        let offset = self.entries.get(key).map_or(self.offset, |v| v.span().start);
        Place { file: self.document.file.to_path_buf(), line: self.document.line_at(offset), field: self.field(key) }
    }

    fn wrong_type(&self, key: &str, value: &DeValue<'_>, wanted: &str) -> Error {
        self.error(key, format!("this is {}, not {wanted}", kind(value)))
    }

    fn missing(&self, key: &'static str, help: &str) -> Error {
        // A misspelt key looks like a missing one; the slip is what the user wants to hear of.
        let slip = self.entries.keys().find(|k| !self.known.contains(&k.get_ref().as_ref()) && nearest(k.get_ref(), &[key]).is_some());
        if let Some(slip) = slip {
            return self.unknown(slip, &[key]);
        }
        let place = if self.name.is_empty() { "the project".to_string() } else { format!("[{}]", self.name) };
        self.document.error_at(self.offset, format!("{place} has no '{key}'")).help(help)
    }

    /// A text.
    pub(super) fn string(&mut self, key: &'static str) -> Result<Option<String>> {
        match self.get(key).map(Spanned::get_ref) {
            None => Ok(None),
            Some(DeValue::String(s)) if s.trim().is_empty() => Err(self.error(key, "this text is empty")),
            Some(DeValue::String(s)) => Ok(Some(s.to_string())),
            Some(other) => Err(self.wrong_type(key, other, "a text in quotes")),
        }
    }

    /// A text that must be there.
    pub(super) fn required_string(&mut self, key: &'static str, help: &str) -> Result<String> {
        self.string(key)?.ok_or_else(|| self.missing(key, help))
    }

    /// One of several words.
    pub(super) fn choice<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)]) -> Result<Option<T>> {
        self.choice_beside(key, choices, "")
    }

    /// The same where something else than a word may stand too.
    fn choice_beside<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)], beside: &str) -> Result<Option<T>> {
        let Some(word) = self.string(key)? else { return Ok(None) };
        choices.iter().find(|(name, _)| *name == word).map(|&(_, value)| Some(value)).ok_or_else(|| {
            let names: Vec<String> = choices.iter().map(|(name, _)| format!("\"{name}\"")).collect();
            self.error(key, format!("'{word}' is not known here")).help(format!("choose {}{beside}", names.join(", ")))
        })
    }

    /// A path, relative to the document's folder. The file must exist.
    pub(super) fn path(&mut self, key: &'static str) -> Result<Option<PathBuf>> {
        let text = self.string(key)?;
        text.map(|t| self.existing_file(key, &t)).transpose()
    }

    /// Whether a key is there.
    pub(super) fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// A path (`Ok`) or a word in its place (`Err`).
    #[allow(clippy::type_complexity, reason = "one of two kinds of value, or none")]
    pub(super) fn path_or_word<W: Default>(&mut self, key: &'static str, word: &str) -> Result<Option<std::result::Result<PathBuf, W>>> {
        match self.string(key)? {
            Some(text) if text == word => Ok(Some(Err(W::default()))),
            _ => Ok(self.path(key)?.map(Ok)),
        }
    }

    /// A pattern of numbered files (`v%03d.hdr`), relative to the document's folder.
    pub(super) fn pattern(&mut self, key: &'static str) -> Result<Option<Pattern>> {
        let Some(text) = self.string(key)? else { return Ok(None) };
        let parsed = Pattern::inside(self.document.file.parent().unwrap_or(Path::new("")), &text);
        let help = "write v%03d.hdr or the like";
        parsed.map(Some).map_err(|_| self.error(key, format!("'{text}' has no place for the number of a picture")).help(help))
    }

    /// A path that must be there.
    pub(super) fn required_path(&mut self, key: &'static str, help: &str) -> Result<PathBuf> {
        self.path(key)?.ok_or_else(|| self.missing(key, help))
    }

    /// A non-empty list of paths.
    pub(super) fn required_paths(&mut self, key: &'static str, help: &str) -> Result<Vec<PathBuf>> {
        if self.get(key).is_none() {
            return Err(self.missing(key, help));
        }
        let paths = self.paths(key)?;
        if paths.is_empty() {
            return Err(self.error(key, "this list is empty").help(help));
        }
        Ok(paths)
    }

    /// A list of paths of files that exist, empty if the key is absent.
    pub(super) fn paths(&mut self, key: &'static str) -> Result<Vec<PathBuf>> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong_type(key, value.get_ref(), "a list of files like [\"a.rad\", \"b.rad\"]"));
        };
        let mut paths = Vec::new();
        for item in items.iter() {
            match item.get_ref() {
                DeValue::String(s) => paths.push(self.existing_file(key, s)?),
                other => return Err(self.wrong_type(key, other, "the name of a file in quotes")),
            }
        }
        Ok(paths)
    }

    fn existing_file(&self, key: &str, text: &str) -> Result<PathBuf> {
        let folder = self.document.file.parent().unwrap_or(Path::new(""));
        let path = folder.join(text);
        // Of `room.hbjson#south` the file has to be there.
        match std::fs::metadata(split_part(&path).0) {
            // A model may be the folder that Honeybee writes for Radiance.
            Ok(m) if m.is_dir() && Format::of(&split_part(&path).0) != Format::Honeybee => {
                Err(self.error(key, format!("'{text}' is a folder, not a file")))
            }
            Ok(_) => Ok(path),
            Err(e) => {
                let wanted = path.display();
                let message = match e.kind() {
                    std::io::ErrorKind::NotFound => format!("there is no file '{wanted}'"),
                    _ => format!("cannot use '{wanted}': {e}"),
                };
                Err(self.error(key, message).help("paths are relative to the folder of the project file"))
            }
        }
    }

    /// A whole number within limits.
    pub(super) fn integer(&mut self, key: &'static str, limits: std::ops::RangeInclusive<u64>) -> Result<Option<u64>> {
        let value = match self.get(key).map(Spanned::get_ref) {
            None => return Ok(None),
            Some(DeValue::Integer(i)) => i64::from_str_radix(i.as_str(), i.radix()).ok().and_then(|v| u64::try_from(v).ok()),
            Some(other) => return Err(self.wrong_type(key, other, "a whole number")),
        };
        match value.filter(|v| limits.contains(v)) {
            Some(v) => Ok(Some(v)),
            None => Err(self.error(key, "this number is out of range").help(format!(
                "choose a whole number from {} to {}",
                limits.start(),
                limits.end()
            ))),
        }
    }

    /// A whole number within limits (`Ok`) or one of several words (`Err`).
    #[allow(clippy::type_complexity, reason = "one of two kinds of value, or none")]
    pub(super) fn integer_or_choice(
        &mut self,
        key: &'static str,
        limits: std::ops::RangeInclusive<u64>,
        words: &[&'static str],
    ) -> Result<Option<std::result::Result<u64, &'static str>>> {
        if let Some(DeValue::String(_)) = self.get(key).map(Spanned::get_ref) {
            let choices: Vec<(&str, &'static str)> = words.iter().map(|&w| (w, w)).collect();
            let numbers = format!(", or a whole number from {} to {}", limits.start(), limits.end());
            return Ok(self.choice_beside(key, &choices, &numbers)?.map(Err));
        }
        Ok(self.integer(key, limits)?.map(Ok))
    }

    /// True or false.
    pub(super) fn boolean(&mut self, key: &'static str) -> Result<Option<bool>> {
        match self.get(key).map(Spanned::get_ref) {
            None => Ok(None),
            Some(DeValue::Boolean(value)) => Ok(Some(*value)),
            Some(other) => Err(self.wrong_type(key, other, "true or false")),
        }
    }

    /// A number, whole or not, within limits.
    pub(super) fn number(&mut self, key: &'static str, limits: std::ops::RangeInclusive<f64>) -> Result<Option<f64>> {
        match self.get(key).map(Spanned::get_ref) {
            None => Ok(None),
            Some(value) => self.number_of(key, value, &limits).map(Some),
        }
    }

    /// A number within limits (`Ok`) or one of several words (`Err`).
    #[allow(clippy::type_complexity, reason = "one of two kinds of value, or none")]
    pub(super) fn number_or_choice(
        &mut self,
        key: &'static str,
        limits: std::ops::RangeInclusive<f64>,
        words: &[&'static str],
    ) -> Result<Option<std::result::Result<f64, &'static str>>> {
        if let Some(DeValue::String(_)) = self.get(key).map(Spanned::get_ref) {
            let choices: Vec<(&str, &'static str)> = words.iter().map(|&w| (w, w)).collect();
            let numbers = format!(", or a number from {} to {}, without quotes", limits.start(), limits.end());
            return Ok(self.choice_beside(key, &choices, &numbers)?.map(Err));
        }
        Ok(self.number(key, limits)?.map(Ok))
    }

    fn number_of(&self, key: &str, value: &DeValue<'_>, limits: &std::ops::RangeInclusive<f64>) -> Result<f64> {
        let number = match value {
            DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).ok().map(|v| v as f64),
            DeValue::Float(f) => f.as_str().parse().ok(),
            other => return Err(self.wrong_type(key, other, "a number")),
        };
        number.filter(|v| limits.contains(v)).ok_or_else(|| {
            self.error(key, "this number is out of range").help(format!("choose a number from {} to {}", limits.start(), limits.end()))
        })
    }

    /// A table inside this one.
    pub(super) fn table(&mut self, key: &'static str) -> Result<Option<Table<'d, 'a>>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let DeValue::Table(entries) = value.get_ref() else {
            return Err(self.wrong_type(key, value.get_ref(), &format!("a section [{key}]")));
        };
        Ok(Some(Table {
            document: self.document,
            name: self.field(key),
            entries,
            offset: section_start(value, entries),
            known: Vec::new(),
        }))
    }

    /// A table that must be there.
    pub(super) fn required_table(&mut self, key: &'static str, help: &str) -> Result<Table<'d, 'a>> {
        self.table(key)?.ok_or_else(|| self.missing(key, help))
    }

    /// An array of tables (`[[key]]`), possibly absent.
    pub(super) fn tables(&mut self, key: &'static str) -> Result<Vec<Table<'d, 'a>>> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        let wanted = format!("a section [[{key}]] (in double brackets: there may be several)");
        let DeValue::Array(items) = value.get_ref() else { return Err(self.wrong_type(key, value.get_ref(), &wanted)) };
        let mut tables = Vec::new();
        for (i, item) in items.iter().enumerate() {
            let DeValue::Table(entries) = item.get_ref() else { return Err(self.wrong_type(key, item.get_ref(), &wanted)) };
            tables.push(Table {
                document: self.document,
                name: format!("{} {}", self.field(key), i + 1),
                entries,
                offset: section_start(item, entries),
                known: Vec::new(),
            });
        }
        Ok(tables)
    }

    /// Refuses a misspelt form of a key that may be left out.
    ///
    /// # Errors
    /// Names the slip, and the key that is meant.
    pub(super) fn refuse_slips(&self, key: &str) -> Result<()> {
        let slip = self.entries.keys().find(|k| !self.known.contains(&k.get_ref().as_ref()) && nearest(k.get_ref(), &[key]).is_some());
        slip.map_or(Ok(()), |slip| Err(self.unknown(slip, &[key])))
    }

    /// An error that the table has none of some keys; a misspelt one is answered.
    pub(super) fn missing_all(&self, keys: &[&str], what: &str, help: &str) -> Error {
        let slip = self.entries.keys().find(|k| !self.known.contains(&k.get_ref().as_ref()) && nearest(k.get_ref(), keys).is_some());
        match slip {
            Some(slip) => self.unknown(slip, keys),
            None => self.document.error_at(self.offset, format!("[{}] {what}", self.name)).help(help),
        }
    }

    /// An error that the table as a whole lacks something.
    pub(super) fn missing_section(&self, key: &'static str, help: &str) -> Error {
        self.missing(key, help)
    }

    /// Refuses keys that nobody asked for.
    ///
    /// # Errors
    /// The first unknown key, with the nearest known one.
    pub(super) fn finish(self) -> Result<()> {
        // The map is sorted by name; the user wants the first in the file.
        let unknown = self.entries.iter().filter(|(k, _)| !self.known.contains(&k.get_ref().as_ref())).min_by_key(|(k, _)| k.span().start);
        match unknown {
            Some((key, _)) => Err(self.unknown(key, &self.known)),
            None => Ok(()),
        }
    }

    fn unknown(&self, key: &Spanned<DeString<'_>>, known: &[&str]) -> Error {
        let place = if self.name.is_empty() { "in a project file".to_string() } else { format!("in [{}]", self.name) };
        let help = match nearest(key.get_ref(), known) {
            Some(near) => format!("did you mean '{near}'?"),
            None => format!("known here: {}", known.join(", ")),
        };
        self.document.error_at(key.span().start, format!("there is no key '{}' {place}", key.get_ref())).help(help)
    }
}

/// Where a section starts: the span of a table may be empty, then its first key serves.
fn section_start(value: &Spanned<DeValue<'_>>, entries: &DeTable<'_>) -> usize {
    if value.span().is_empty() { entries.keys().map(|k| k.span().start).min().unwrap_or(0) } else { value.span().start }
}

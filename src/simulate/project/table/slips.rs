//! Keys that are missing, misspelt or unknown.

use super::Table;
use crate::error::{Error, Result};
use crate::simulate::project::spelling::nearest;
use toml::Spanned;
use toml::de::DeString;

impl<'d, 'a> Table<'d, 'a> {
    /// A misspelt one of these keys.
    pub(super) fn slip(&self, keys: &[&str]) -> Option<&'d Spanned<DeString<'a>>> {
        self.entries.keys().find(|k| !self.known.contains(&k.get_ref().as_ref()) && nearest(k.get_ref(), keys).is_some())
    }

    /// Refuses a misspelt form of a key that may be left out.
    ///
    /// # Errors
    /// Names the slip, and the key that is meant.
    pub(in crate::simulate::project) fn refuse_slips(&self, key: &str) -> Result<()> {
        self.slip(&[key]).map_or(Ok(()), |slip| Err(self.unknown(slip, &[key])))
    }

    /// An error that the table has none of some keys; a misspelt one is answered.
    pub(in crate::simulate::project) fn missing_all(&self, keys: &[&str], what: &str, help: &str) -> Error {
        match self.slip(keys) {
            Some(slip) => self.unknown(slip, keys),
            None => self.document.error_at(self.offset, format!("[{}] {what}", self.name)).help(help),
        }
    }

    /// An error that the table as a whole lacks something.
    pub(in crate::simulate::project) fn missing_section(&self, key: &'static str, help: &str) -> Error {
        self.missing(key, help)
    }

    /// Refuses keys that nobody asked for.
    ///
    /// # Errors
    /// The first unknown key, with the nearest known one.
    pub(in crate::simulate::project) fn finish(self) -> Result<()> {
        // The map is sorted by name; the user wants the first in the file.
        let unknown = self.entries.iter().filter(|(k, _)| !self.known.contains(&k.get_ref().as_ref())).min_by_key(|(k, _)| k.span().start);
        match unknown {
            Some((key, _)) => Err(self.unknown(key, &self.known)),
            None => Ok(()),
        }
    }

    pub(super) fn unknown(&self, key: &Spanned<DeString<'_>>, known: &[&str]) -> Error {
        let place = if self.name.is_empty() { "in a project file".to_string() } else { format!("in [{}]", self.name) };
        let help = match nearest(key.get_ref(), known) {
            Some(near) => format!("did you mean '{near}'?"),
            None => format!("known here: {}", known.join(", ")),
        };
        self.document.error_at(key.span().start, format!("there is no key '{}' {place}", key.get_ref())).help(help)
    }
}

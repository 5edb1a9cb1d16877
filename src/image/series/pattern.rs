//! Names of numbered files.

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// A file name with a place for a number, as in C's `printf`: `%d`, `%4d` or `%04d`; `%%` is a
/// percent sign.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    /// What stands before `before`; of any bytes.
    folder: PathBuf,
    before: String,
    after: String,
    digits: usize,
    fill: char,
    text: String,
}

impl Pattern {
    /// Whether a name has a place for a number, and thus stands for a set of pictures.
    pub fn is_pattern(text: &str) -> bool {
        split(text).is_ok_and(|parts| parts.1.is_some())
    }

    /// Takes a name apart.
    ///
    /// # Errors
    /// If it has no place for a number, more than one, or a conversion of another kind.
    pub fn parse(text: &str) -> Result<Self> {
        let (before, conversion, after) = split(text)?;
        let Some(conversion) = conversion else {
            return Err(Error::new(format!("'{text}' has no place for a number")).help("write for instance img_%04d.hdr"));
        };
        let zero = conversion.starts_with('0');
        let digits = if conversion.is_empty() { 0 } else { conversion.parse().unwrap_or(usize::MAX) };
        if digits > 20 {
            return Err(Error::new(format!("'%{conversion}d' asks for too many digits")).help("write for instance %04d"));
        }
        Ok(Self { folder: PathBuf::new(), before, after, digits, fill: if zero { '0' } else { ' ' }, text: text.to_owned() })
    }

    /// The pattern `name` in a folder, in whose own name a percent sign is one. An absolute name is in no folder.
    ///
    /// # Errors
    /// As [`parse`](Self::parse) of the name.
    pub fn inside(folder: &Path, name: &str) -> Result<Self> {
        let named = Self::parse(name)?;
        let shown = folder.display().to_string().replace('%', "%%");
        Ok(Self { folder: folder.to_path_buf(), text: Path::new(&shown).join(name).display().to_string(), ..named })
    }

    /// The file of a number.
    pub fn path(&self, number: usize) -> PathBuf {
        let digits = number.to_string();
        let fill: String = std::iter::repeat_n(self.fill, self.digits.saturating_sub(digits.len())).collect();
        self.folder.join(format!("{}{fill}{digits}{}", self.before, self.after))
    }

    /// Numbers for which files exist, rising.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn existing(&self) -> Result<Vec<usize>> {
        let sample = self.path(0);
        let folder = match sample.parent() {
            Some(p) if !p.as_os_str().is_empty() => p.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let name_of = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        // The number is normally in the name; in a folder's name, files are tried one by one.
        let (Some(start), true) = (self.before.rsplit(['/', '\\']).next(), !self.after.contains(['/', '\\'])) else {
            return Ok((0..).take_while(|&n| self.path(n).exists()).collect());
        };
        let entries = std::fs::read_dir(&folder).map_err(|e| Error::io(&folder, &e))?;
        let mut numbers = Vec::new();
        for entry in entries {
            let name = name_of(&entry.map_err(|e| Error::io(&folder, &e))?.path());
            let number = name.strip_prefix(start).and_then(|n| n.strip_suffix(&*self.after)).and_then(|n| n.trim_start().parse().ok());
            if let Some(number) = number.filter(|&n| name_of(&self.path(n)) == name) {
                numbers.push(number);
            }
        }
        numbers.sort_unstable();
        Ok(numbers)
    }
}

impl std::fmt::Display for Pattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

/// What stands before the number, its conversion without `%` and `d` if there is one, and what
/// stands after.
fn split(text: &str) -> Result<(String, Option<String>, String)> {
    let mut parts = [String::new(), String::new()];
    let mut conversion = None;
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        let part = &mut parts[usize::from(conversion.is_some())];
        if c != '%' {
            part.push(c);
            continue;
        }
        if rest.as_str().starts_with('%') {
            rest.next();
            part.push('%');
            continue;
        }
        let width: String = rest.as_str().chars().take_while(char::is_ascii_digit).collect();
        let kind = rest.nth(width.len());
        if !matches!(kind, Some('d' | 'i' | 'u')) {
            return Err(Error::new(format!("'{text}' has a % that is not followed by a number of digits and d"))
                .help("write for instance %04d, or %% for a percent sign"));
        }
        if conversion.replace(width).is_some() {
            return Err(Error::new(format!("'{text}' has two places for numbers")).help("leave one of them, as in img_%04d.hdr"));
        }
    }
    let [before, after] = parts;
    Ok((before, conversion, after))
}

//! One error type for everything that can go wrong with a user's input or machine.
//!
//! An [`Error`] says what is wrong, where (file, line, field) and what to do about it. Functions
//! that know only *what* return `Error::new`; callers that know *where* add it on the way up.
//! Broken invariants of the program itself are `assert!`s, never an `Error`.

use std::fmt;
use std::path::{Path, PathBuf};

/// Result of every fallible public function.
pub type Result<T> = std::result::Result<T, Error>;

/// What is wrong, where, and the remedy. Displays as `file:line: field: message` with the help on
/// a second line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error(Box<Details>);

#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Details {
    message: String,
    file: Option<PathBuf>,
    line: Option<usize>,
    field: Option<String>,
    help: Option<String>,
}

impl Error {
    /// An error with a message: what was found and what was expected, in one sentence.
    pub fn new(message: impl Into<String>) -> Self {
        Self(Box::new(Details { message: message.into(), ..Details::default() }))
    }

    /// Failure of the operating system on a file.
    pub fn io(path: impl AsRef<Path>, error: &std::io::Error) -> Self {
        let help = match error.kind() {
            std::io::ErrorKind::NotFound => Some("check the spelling and the folder the path is relative to"),
            std::io::ErrorKind::PermissionDenied => Some("check the permissions of the file and its folder"),
            std::io::ErrorKind::StorageFull => Some("free some disk space, or write to another disk"),
            _ => None,
        };
        let e = Self::new(error.to_string()).file(path);
        match help {
            Some(h) => e.help(h),
            None => e,
        }
    }

    /// Adds the file, unless an inner caller already named one.
    #[must_use]
    pub fn file(mut self, path: impl AsRef<Path>) -> Self {
        self.0.file.get_or_insert_with(|| path.as_ref().to_path_buf());
        self
    }

    /// Adds the line (from 1), unless an inner caller already named one.
    #[must_use]
    pub fn line(mut self, line: usize) -> Self {
        self.0.line.get_or_insert(line);
        self
    }

    /// Adds the field, element or option at fault, unless an inner caller already named one.
    #[must_use]
    pub fn field(mut self, field: impl Into<String>) -> Self {
        self.0.field.get_or_insert_with(|| field.into());
        self
    }

    /// Adds what the user can do, unless an inner caller already said so.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help.get_or_insert_with(|| help.into());
        self
    }

    /// The message alone, without place and remedy.
    pub fn message(&self) -> &str {
        &self.0.message
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let d = &self.0;
        if let Some(file) = &d.file {
            write!(f, "{}:", file.display())?;
            if let Some(line) = d.line {
                write!(f, "{line}:")?;
            }
            write!(f, " ")?;
        } else if let Some(line) = d.line {
            write!(f, "line {line}: ")?;
        }
        if let Some(field) = &d.field {
            write!(f, "{field}: ")?;
        }
        write!(f, "{}", d.message)?;
        if let Some(help) = &d.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

/// Collects what is suspicious but not fatal. Passed as a parameter, so that it is hard to ignore;
/// the command line prints it, tests inspect it.
#[derive(Debug, Default, Clone)]
pub struct Warnings {
    all: Vec<Error>,
    /// How many have been taken for display.
    shown: usize,
}

impl Warnings {
    /// An empty collection.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a warning; the same text is kept once.
    pub fn push(&mut self, warning: Error) {
        if !self.all.contains(&warning) {
            self.all.push(warning);
        }
    }

    /// All warnings in the order they arose.
    pub fn iter(&self) -> impl Iterator<Item = &Error> {
        self.all.iter()
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Those that have not been taken before, to be shown before long work.
    pub fn take_new(&mut self) -> &[Error] {
        let first = std::mem::replace(&mut self.shown, self.all.len());
        &self.all[first..]
    }
}

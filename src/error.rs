//! One error type for everything that can go wrong with a user's input or machine.
//!
//! An [`Error`] says what is wrong, where (file, line, field) and what to do about it. Functions
//! that know only *what* return `Error::new`; callers that know *where* add it on the way up.
//! [`Error::kind`] tells programs apart what a user can mend, what the device could not do, and what was
//! stopped. Broken invariants of the program itself are `assert!`s, never an `Error`.

use std::collections::{HashMap, HashSet};
use std::fmt;
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
use std::path::{Path, PathBuf};

/// Result of every fallible public function.
pub type Result<T> = std::result::Result<T, Error>;

/// What is wrong, where, and the remedy. Displays as `file:line: field: message` with the help on
/// a second line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error(Box<Details>);

/// What kind of fault an error is, for programs that react to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum ErrorKind {
    /// What was asked for, or a file that was given, is wrong: the user can mend it.
    #[default]
    Input,
    /// There is no device, or it could not do its work.
    Device,
    /// The work was stopped on request; what was finished before is kept.
    Stopped,
    /// The operating system refused a file or folder.
    Io,
    /// Whoever read the output has closed it.
    Closed,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
struct Details {
    kind: ErrorKind,
    message: String,
    file: Option<PathBuf>,
    line: Option<usize>,
    field: Option<String>,
    help: Option<String>,
    /// Of a warning: how many more of its kind were left out after it.
    more: usize,
}

impl Error {
    /// An error with a message: what was found and what was expected, in one sentence.
    pub fn new(message: impl Into<String>) -> Self {
        Self(Box::new(Details { message: message.into(), ..Details::default() }))
    }

    /// A failure of the device that kernels run on, or the lack of one.
    pub fn device(message: impl Into<String>) -> Self {
        Self::new(message).of_kind(ErrorKind::Device)
    }

    /// The same of another kind.
    #[must_use]
    pub(crate) fn of_kind(mut self, kind: ErrorKind) -> Self {
        self.0.kind = kind;
        self
    }

    /// Failure of the operating system on a file.
    pub fn io(path: impl AsRef<Path>, error: &std::io::Error) -> Self {
        Self::stream(error).file(path)
    }

    /// Failure of the operating system on a stream that has no name here.
    pub fn stream(error: &std::io::Error) -> Self {
        let help = match error.kind() {
            std::io::ErrorKind::NotFound => Some("check the spelling and the folder the path is relative to"),
            std::io::ErrorKind::PermissionDenied => Some("check the permissions of the file and its folder"),
            std::io::ErrorKind::StorageFull => Some("free some disk space, or write to another disk"),
            _ => None,
        };
        let e = Self::new(error.to_string()).of_kind(kind_of(error));
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

    /// What kind of fault it is.
    ///
    /// ```
    /// use lucarne::{ErrorKind, simulate::Project};
    /// let error = Project::read("no/such/project.toml".as_ref()).unwrap_err();
    /// assert_eq!(error.kind(), ErrorKind::Io);
    /// ```
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// What warnings have in common that differ only in numbers and in names within quotes.
    fn pattern(&self) -> String {
        let d = &self.0;
        let (mut quoted, mut before) = (false, ' ');
        let plain = d.message.chars().filter(|&c| {
            // Not the apostrophe of "the window's".
            quoted ^= c == '\'' && (quoted || !before.is_alphanumeric());
            before = c;
            !quoted && !c.is_ascii_digit() && c != '-'
        });
        format!(
            "{}|{}|{}",
            d.file.as_deref().unwrap_or(Path::new("")).display(),
            d.help.as_deref().unwrap_or(""),
            plain.collect::<String>()
        )
    }

    /// The message alone, without place and remedy.
    pub fn message(&self) -> &str {
        &self.0.message
    }
}

fn kind_of(error: &std::io::Error) -> ErrorKind {
    if error.kind() == std::io::ErrorKind::BrokenPipe { ErrorKind::Closed } else { ErrorKind::Io }
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
        if d.more > 0 {
            write!(f, " (and {} more like it)", d.more)?;
        }
        if let Some(help) = &d.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

/// Warnings of one kind that are kept in full; the last of them says how many more there were.
pub const WARNINGS_OF_A_KIND: usize = 20;
/// Warnings that are remembered in order not to be counted twice.
const REMEMBERED: usize = 1 << 20;

/// Collects what is suspicious but not fatal. Passed as a parameter, so that it is hard to ignore;
/// the command line prints it, tests inspect it.
///
/// Of warnings that differ only in numbers and names, the first [`WARNINGS_OF_A_KIND`] are kept; the
/// last of these says how many more there were.
#[derive(Debug, Default, Clone)]
pub struct Warnings {
    kept: Vec<Error>,
    /// Of every warning so far, also those that are counted only.
    seen: HashSet<u64>,
    /// How many of each kind are kept, and which came last.
    kinds: HashMap<String, (usize, usize)>,
    /// How many of those kept have been taken for display.
    shown: usize,
}

impl Warnings {
    /// An empty collection.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a warning; the same text is kept once.
    pub fn push(&mut self, warning: Error) {
        let hash = BuildHasherDefault::<DefaultHasher>::default().hash_one(&warning.0);
        if self.seen.contains(&hash) {
            return;
        }
        if self.seen.len() < REMEMBERED {
            self.seen.insert(hash);
        }
        let (number, last) = self.kinds.entry(warning.pattern()).or_default();
        if *number < WARNINGS_OF_A_KIND {
            (*number, *last) = (*number + 1, self.kept.len());
            self.kept.push(warning);
        } else {
            self.kept[*last].0.more += 1 + warning.0.more;
        }
    }

    /// All warnings that are kept, in the order they arose.
    pub fn iter(&self) -> impl Iterator<Item = &Error> {
        self.kept.iter()
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Those that have not been taken before, to be shown before long work.
    pub fn take_new(&mut self) -> &[Error] {
        let first = std::mem::replace(&mut self.shown, self.kept.len());
        &self.kept[first..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_kept_once_and_a_kind_of_warnings_in_twenty() {
        let mut warnings = Warnings::new();
        let polygon = |i: usize| Error::new(format!("corners are {i}.5 off")).file("a.rad").line(i).field(format!("polygon 'p.{i}'"));
        for _ in 0..3 {
            warnings.push(polygon(1));
        }
        assert_eq!(warnings.iter().count(), 1);
        for i in 0..200_000 {
            warnings.push(polygon(i));
        }
        warnings.push(Error::new("something else"));
        warnings.push(Error::new("something else").line(3));
        warnings.push(Error::new("something else").help("a remedy makes it another kind"));
        let texts: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(texts.len(), 20 + 3);
        assert!(texts[18].ends_with("18.5 off"), "{}", texts[18]);
        assert!(texts[19].ends_with("19.5 off (and 199980 more like it)"), "{}", texts[19]);
        // Handed on to another collection nothing is lost.
        let mut others = Warnings::new();
        warnings.iter().for_each(|w| others.push(w.clone()));
        assert_eq!(others.iter().map(ToString::to_string).collect::<Vec<_>>(), texts);
        // A fault of another file is another kind.
        others.push(polygon(7).file("b.rad"));
        others.push(Error::new("corners are 7.5 off").file("b.rad"));
        assert_eq!(others.iter().count(), 20 + 4);
    }
}

//! View options, view files and VIEW lines.

use super::{Projection, View};
use crate::error::{Error, Result};
use crate::{files, text};
use glam::DVec3;
use std::path::Path;

/// What a line of a picture's header that states a view starts with: the names of Radiance's
/// `isview`, to which `evalglare` adds its own.
const VIEW_PROGRAMS: [&str; 8] = ["VIEW=", "rpict", "rvu", "rview", "rpiece", "rxpiece", "pinterp", "evalglare"];

/// Further starts of such lines in view files: programs that write them, and no program at all.
const VIEW_FILE_STARTS: [&str; 3] = ["rad", "vwrays", "-v"];

impl View {
    /// A view from options, starting from Radiance's standard view; nothing else may be among them.
    ///
    /// # Errors
    /// Unknown options or projections, missing or wrong numbers.
    pub fn parse(options: &str) -> Result<Self> {
        let words: Vec<&str> = options.split_whitespace().collect();
        let mut view = Self::default();
        view.apply(&words)?;
        Ok(view)
    }

    /// Sets what the options say (`-vta`, `-vp 1 2 3`, …) and leaves the rest as it is. A double
    /// dash is taken for a single one.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn apply(&mut self, words: &[&str]) -> Result<()> {
        let mut rest = words;
        while let Some(&option) = rest.first() {
            match self.take_option(rest)? {
                Some(count) => rest = &rest[count..],
                None => {
                    return Err(Error::new(format!("'{option}' is no view option"))
                        .help("view options are -vt? -vp -vd -vu -vh -vv -vo -va -vs -vl"));
                }
            }
        }
        Ok(())
    }

    /// Reads a view file, or the view of a picture: lines that start with `VIEW=`, with a rendering
    /// program's name (`rvu -vta …`) or with `-v`. Later lines override earlier ones; words that are
    /// no view options are skipped.
    ///
    /// # Errors
    /// If the file cannot be read, has no view, or a view option in it is wrong (with its line).
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = files::read(path)?;
        // A picture's pixels follow an empty line.
        let lines = bytes.split(|b| *b == b'\n').take_while(|line| !line.is_empty() && *line != b"\r");
        let end: usize = lines.map(|line| line.len() + 1).sum();
        let text = text::decode(&bytes[..end.min(bytes.len())], "a view file");
        text.and_then(|text| Self::from_lines(&text)).map_err(|e| e.file(path))
    }

    /// As [`Self::read`], from text.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(crate) fn from_lines(text: &str) -> Result<Self> {
        let mut view = Self::default();
        let mut options = 0;
        for (number, line) in text.lines().enumerate() {
            if !states_view(line, &VIEW_FILE_STARTS) {
                continue;
            }
            for option in view_options(line) {
                view.apply(&option).map_err(|e| e.line(number + 1))?;
                options += 1;
            }
        }
        if options == 0 {
            return Err(Error::new("there is no view in this file")
                .help("a view file has a line like 'rvu -vta -vp 1 2 1.2 -vd 0 1 0 -vh 180 -vv 180'"));
        }
        Ok(view)
    }

    /// The view options in a line of a picture's header, each with its values (`-vp 1 2 3`): lines
    /// that start with `VIEW=` or with a program that draws views (`/usr/bin/rpict -vta …`). As in
    /// Radiance, an indented line tells of a picture that this one was made from and does not count,
    /// and words that are no view options (`-x 96`, `-ld-`, `-vf file`) are skipped. Values are not
    /// checked: [`Self::parse`] refuses an option without its numbers.
    pub(crate) fn options_in_header(line: &str) -> Vec<String> {
        if !states_view(line, &[]) {
            return Vec::new();
        }
        let with_one_dash = |words: Vec<&str>| words.join(" ").replacen("--v", "-v", 1);
        view_options(line).map(with_one_dash).collect()
    }

    /// Takes one option from the front; the number of words it has, or `None` if it is none.
    fn take_option(&mut self, words: &[&str]) -> Result<Option<usize>> {
        let Some(name) = words.first().and_then(|w| option_name(w)) else {
            return Ok(None);
        };
        let option = words[0];
        if let Some(kind) = name.strip_prefix('t') {
            let (kind, count) = if kind.is_empty() { (words.get(1).copied().unwrap_or(""), 2) } else { (kind, 1) };
            self.projection = Projection::ALL.into_iter().find(|p| kind.len() == 1 && kind.starts_with(p.letter())).ok_or_else(|| {
                Error::new(format!("unknown projection '{kind}'"))
                    .field(option)
                    .help("v perspective, l parallel, h hemispherical, a angular, s planispheric fisheye, c cylindrical")
            })?;
            return Ok(Some(count));
        }
        let number = |index: usize| -> Result<f64> {
            let word = words.get(index).copied().unwrap_or("nothing");
            word.parse()
                .ok()
                .filter(|v: &f64| v.is_finite())
                .ok_or_else(|| Error::new(format!("expected a number, found '{word}'{}", text::why_no_number(word))).field(option))
        };
        let vector = || Ok::<_, Error>(DVec3::new(number(1)?, number(2)?, number(3)?));
        match name {
            "p" => self.point = vector()?,
            "d" => self.direction = vector()?,
            "u" => self.up = vector()?,
            "h" => self.horizontal = number(1)?,
            "v" => self.vertical = number(1)?,
            "o" => self.fore = number(1)?,
            "a" => self.aft = number(1)?,
            "s" => self.shift = number(1)?,
            "l" => self.lift = number(1)?,
            _ => return Ok(None),
        }
        Ok(Some(if matches!(name, "p" | "d" | "u") { 4 } else { 2 }))
    }

    /// All parameters as options, for a VIEW line or another program: `-vta -vp 1 2 3 …`. Parsing
    /// gives the same view again, to the last bit.
    pub fn to_options(&self) -> String {
        let v = |a: DVec3| format!("{} {} {}", a.x, a.y, a.z);
        format!(
            "-vt{} -vp {} -vd {} -vu {} -vh {} -vv {} -vo {} -va {} -vs {} -vl {}",
            self.projection.letter(),
            v(self.point),
            v(self.direction),
            v(self.up),
            self.horizontal,
            self.vertical,
            self.fore,
            self.aft,
            self.shift,
            self.lift
        )
    }
}

/// Whether a line starts with a word that announces a view; a leading path is skipped. The first
/// word of an indented line is empty.
fn states_view(line: &str, more: &[&str]) -> bool {
    let first = line.split(char::is_whitespace).next().unwrap_or("");
    let program = first.rsplit(['/', '\\']).next().unwrap_or("");
    VIEW_PROGRAMS.iter().chain(more).any(|p| program.starts_with(p))
}

/// The view options among the words of a line, each with as many values as it should have.
fn view_options(line: &str) -> impl Iterator<Item = Vec<&str>> {
    let words: Vec<&str> = line.strip_prefix("VIEW=").unwrap_or(line).split_whitespace().collect();
    let mut at = 0;
    std::iter::from_fn(move || {
        while at < words.len() {
            let count = option_length(&words[at..]).min(words.len() - at);
            let option = words[at..at + count].to_vec();
            at += count.max(1);
            if count > 0 {
                return Some(option);
            }
        }
        None
    })
}

/// `h` of `-vh`.
fn option_name(word: &str) -> Option<&str> {
    word.strip_prefix("--v").or_else(|| word.strip_prefix("-v"))
}

/// Number of words of the view option at the front; 0 if it is none.
fn option_length(words: &[&str]) -> usize {
    match option_name(words[0]) {
        Some("p" | "d" | "u") => 4,
        Some("h" | "v" | "o" | "a" | "s" | "l") => 2,
        // `-vt a`, a way of writing it that the command line knows.
        Some("t") if words.get(1).is_some_and(|kind| kind.len() == 1) => 2,
        Some(name) if name.len() == 2 && name.starts_with('t') => 1,
        _ => 0,
    }
}

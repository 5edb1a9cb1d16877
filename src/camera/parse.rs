//! View options, view files and VIEW lines.

use super::{Projection, View};
use crate::error::{Error, Result};
use crate::{files, text};
use glam::DVec3;
use std::path::Path;

/// Programs whose command line in a header or view file counts as a view (Radiance's `isview`).
const VIEW_PROGRAMS: [&str; 8] = ["VIEW=", "rpict", "rvu", "rview", "rpiece", "rad", "pinterp", "vwrays"];

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
        let end = (0..bytes.len()).find(|&i| bytes[i..].starts_with(b"\n\n") || bytes[i..].starts_with(b"\n\r\n"));
        let text = text::decode(&bytes[..end.unwrap_or(bytes.len())], "a view file");
        text.and_then(|text| Self::from_lines(&text)).map_err(|e| e.file(path))
    }

    /// As [`Self::read`], from text.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_lines(text: &str) -> Result<Self> {
        let mut view = Self::default();
        let mut options = 0;
        for (number, line) in text.lines().enumerate() {
            if !is_view(line) {
                continue;
            }
            let line = line.strip_prefix("VIEW=").unwrap_or(line);
            let words: Vec<&str> = line.split_whitespace().collect();
            let mut rest = &words[..];
            while !rest.is_empty() {
                match view.take_option(rest).map_err(|e| e.line(number + 1))? {
                    Some(count) => {
                        rest = &rest[count..];
                        options += 1;
                    }
                    None => rest = &rest[1..],
                }
            }
        }
        if options == 0 {
            return Err(Error::new("there is no view in this file")
                .help("a view file has a line like 'rvu -vta -vp 1 2 1.2 -vd 0 1 0 -vh 180 -vv 180'"));
        }
        Ok(view)
    }

    /// Takes one option from the front; the number of words it has, or `None` if it is none.
    fn take_option(&mut self, words: &[&str]) -> Result<Option<usize>> {
        let Some(name) = words.first().and_then(|w| w.strip_prefix("--v").or_else(|| w.strip_prefix("-v"))) else {
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

fn is_view(line: &str) -> bool {
    if line.starts_with("-v") {
        return true;
    }
    // Indented lines were inherited from the pictures a program read.
    let first = line.split(' ').next().unwrap_or("");
    let program = first.rsplit(['/', '\\']).next().unwrap_or("");
    VIEW_PROGRAMS.iter().any(|p| program.starts_with(p))
}

//! Lines of an OBJ file: corners, faces and what names them.

use crate::error::{Error, Result};
use crate::limits;
use crate::scene::rad::shortened;
use crate::text::why_no_number;
use glam::DVec3;
use std::borrow::Cow;

/// A polygon.
pub(super) struct Face {
    pub corners: Vec<DVec3>,
    /// Its line, from 1.
    pub line: usize,
}

/// Words that are known and have no effect here.
const WITHOUT_EFFECT: [&str; 10] = ["vt", "vn", "vp", "s", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj"];

/// Reads face by face.
pub(super) struct Reader<'t> {
    lines: std::iter::Enumerate<std::str::Lines<'t>>,
    vertices: Vec<DVec3>,
    group: String,
    /// Whether the name is that of an object, which a group replaces.
    material: Option<String>,
    libraries: Vec<String>,
    left_out: Option<(usize, String)>,
}

impl<'t> Reader<'t> {
    pub fn new(text: &'t str) -> Self {
        Self {
            lines: text.lines().enumerate(),
            vertices: Vec::new(),
            group: "default".into(),
            material: None,
            libraries: Vec::new(),
            left_out: None,
        }
    }

    /// The group, or else object, of the last face.
    pub fn group(&self) -> &str {
        &self.group
    }

    /// The material of the last face.
    pub fn material(&self) -> Option<&str> {
        self.material.as_deref()
    }

    /// Files of materials.
    pub fn libraries(&self) -> &[String] {
        &self.libraries
    }

    /// The first line that is left out, if there is one.
    pub fn left_out(&self) -> Option<(usize, &str)> {
        self.left_out.as_ref().map(|(line, word)| (*line, word.as_str()))
    }

    /// The next line with those that a backslash joins to it, and its number.
    fn line(&mut self) -> Option<(usize, Cow<'t, str>)> {
        let (number, first) = self.lines.next()?;
        let Some(part) = first.trim_end().strip_suffix('\\') else { return Some((number + 1, Cow::Borrowed(first))) };
        let mut whole = part.to_string();
        for (_, next) in self.lines.by_ref() {
            whole.push(' ');
            match next.trim_end().strip_suffix('\\') {
                Some(part) => whole.push_str(part),
                None => {
                    whole.push_str(next);
                    break;
                }
            }
        }
        Some((number + 1, Cow::Owned(whole)))
    }

    /// The next polygon.
    ///
    /// # Errors
    /// Numbers that are none, corners that are not there, unknown words.
    pub fn next_face(&mut self) -> Result<Option<Face>> {
        while let Some((line, text)) = self.line() {
            let content = text.split('#').next().unwrap_or("").trim();
            let (word, rest) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
            let rest = rest.trim();
            match word {
                "" => {}
                "v" => self.vertex(rest).map_err(|e| e.line(line))?,
                "f" | "fo" => return self.face(rest, line).map(Some).map_err(|e| e.line(line)),
                "g" | "o" => self.group = if rest.is_empty() { "default".into() } else { rest.to_string() },
                "usemtl" => self.material = Some(rest.to_string()).filter(|m| !m.is_empty()),
                "mtllib" => self.libraries.push(rest.to_string()),
                "call" | "csh" => {
                    return Err(Error::new(format!("'{word}' would run or read something else, which is not done"))
                        .line(line)
                        .help("put the parts together into one file"));
                }
                _ if WITHOUT_EFFECT.contains(&word) => {}
                _ if word.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') && word.as_bytes()[0].is_ascii_alphabetic() => {
                    _ = self.left_out.get_or_insert_with(|| (line, shortened(word)));
                }
                _ => {
                    return Err(Error::new(format!("'{}' begins no line of an OBJ file", shortened(word)))
                        .line(line)
                        .help("look whether the right file is named; lines begin with v, f, g, usemtl and the like"));
                }
            }
        }
        Ok(None)
    }

    fn vertex(&mut self, rest: &str) -> Result<()> {
        let mut numbers = [0.0; 3];
        let mut words = rest.split_whitespace();
        for number in &mut numbers {
            let word = words.next().ok_or_else(|| Error::new("a corner has fewer than three coordinates").help("write v x y z"))?;
            *number =
                word.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
                    Error::new(format!("'{}' is no number{}", shortened(word), why_no_number(word))).help("write v x y z")
                })?;
        }
        if self.vertices.len() >= limits::VERTICES {
            return Err(limits::exceeded("the file has", limits::VERTICES, "corners").help("simplify the meshes"));
        }
        self.vertices.push(DVec3::from_array(numbers));
        Ok(())
    }

    fn face(&self, rest: &str, line: usize) -> Result<Face> {
        let count = self.vertices.len();
        let corner = |word: &str| {
            let index = word.split('/').next().unwrap_or("");
            let wrong = || {
                Error::new(format!("a face names corner '{}', but {count} corners stand before it", shortened(word)))
                    .help("corners count from 1, and back from -1; they stand before the faces that use them")
            };
            let index: i64 = index.parse().map_err(|_| wrong())?;
            let place = match index {
                1.. => index - 1,
                0 => return Err(wrong()),
                _ => count as i64 + index,
            };
            usize::try_from(place).ok().and_then(|p| self.vertices.get(p)).copied().ok_or_else(wrong)
        };
        let corners = rest.split_whitespace().map(corner).collect::<Result<Vec<_>>>()?;
        if corners.len() < 3 {
            return Err(Error::new(format!("a face has {} corners", corners.len())).help("a face has three or more corners: f 1 2 3"));
        }
        Ok(Face { corners, line })
    }
}

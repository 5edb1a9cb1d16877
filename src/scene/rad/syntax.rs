//! Statements of a `.rad` file: objects, aliases, commands and `#@rfluxmtx` comments.
//!
//! Only the shape of the text is known here; what the words mean is the business of the modules
//! that use them.

use super::types::{MaterialType, ObjectType};
use crate::error::{Error, Result};
use crate::text;
use std::path::Path;

/// `modifier type identifier`, then counted string, integer (always none) and real arguments.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Object {
    /// Identifier of the modifier, or `void`.
    pub modifier: String,
    /// Type.
    pub kind: ObjectType,
    /// Identifier.
    pub name: String,
    /// String arguments.
    pub strings: Vec<String>,
    /// Real arguments; all finite.
    pub reals: Vec<f64>,
    /// Line of the modifier, from 1.
    pub line: usize,
}

impl Object {
    /// Arguments that name other definitions.
    pub(super) fn named(&self) -> impl Iterator<Item = &str> {
        let places: &[usize] = match self.kind {
            ObjectType::Material(MaterialType::Mirror | MaterialType::Illum) => &[0],
            ObjectType::Material(MaterialType::MixFunc) => &[0, 1],
            ObjectType::Material(MaterialType::WgmdFunc) => &[0, 4, 8],
            _ => &[],
        };
        places.iter().filter_map(|&i| self.strings.get(i)).map(String::as_str)
    }

    /// The error with this object's place and name.
    pub(super) fn at(&self, error: Error, file: &Path) -> Error {
        error.file(file).line(self.line).field(format!("{} '{}'", self.kind.word(), self.name))
    }
}

/// One statement.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Statement {
    /// A surface, material, texture or mixture.
    Object(Object),
    /// `modifier alias name target`.
    Alias {
        /// Modifier that replaces those of the target, or `void`.
        modifier: String,
        /// New identifier.
        name: String,
        /// Identifier of an earlier material.
        target: String,
        /// Line, from 1.
        line: usize,
    },
    /// What follows `!`, with continued lines joined.
    Command {
        /// Command line.
        text: String,
        /// Line, from 1.
        line: usize,
    },
    /// What follows `#@rfluxmtx`.
    Parameters {
        /// Parameters.
        text: String,
        /// Line, from 1.
        line: usize,
    },
}

/// Cuts a file's text into statements.
///
/// # Errors
/// Binary data, unknown object types, wrong or missing counts and arguments, with their line.
pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Vec<Statement>> {
    let help = "give `.rad` files";
    if bytes.starts_with(b"#?RADIANCE") && text::Other::of(bytes).is_none() {
        let help = "give the `.rad` files that an octree was made from, the OBJ file of a compiled mesh (obj2mesh)";
        return Err(Error::new("this is an octree, a compiled mesh, a picture or a matrix, not a scene description").file(file).help(help));
    }
    let text = text::decode(bytes, "a scene description").map_err(|e| e.file(file).help(help))?;
    let text = text.as_bytes();
    let mut words = Words { text, position: 0, line: 1 };
    let mut statements = Vec::new();
    loop {
        words.skip_space();
        match words.peek() {
            None => return Ok(statements),
            Some(b'#') => {
                let line = words.line;
                let comment = words.rest_of_line(false);
                if let Some(parameters) = comment.strip_prefix("#@rfluxmtx").filter(|p| p.is_empty() || p.starts_with(char::is_whitespace))
                {
                    statements.push(Statement::Parameters { text: parameters.trim().to_string(), line });
                }
            }
            Some(b'!') => {
                let line = words.line;
                let command = words.rest_of_line(true);
                statements.push(Statement::Command { text: command[1..].trim().to_string(), line });
            }
            Some(_) => statements.push(statement(&mut words).map_err(|e| e.file(file))?),
        }
    }
}

fn statement(words: &mut Words) -> Result<Statement> {
    let line = words.line_of_next();
    let modifier = words.required("a modifier")?;
    if modifier.starts_with("<?xml") || modifier.starts_with("<WindowElement") {
        return Err(Error::new("this is an XML file, not a Radiance scene file")
            .line(line)
            .help("a BSDF belongs to `bsdf` or `tensor_tree` of a window; surfaces are in .rad or .gltf files"));
    }
    let kind = words.required(&format!("an object type after the modifier '{modifier}'")).map_err(|e| e.line(line))?;
    let type_line = words.line;
    if kind == "alias" {
        let name = words.required("the name of an alias").map_err(|e| e.line(line))?;
        let target = words.required(&format!("the material that alias '{name}' stands for")).map_err(|e| e.line(line))?;
        return Ok(Statement::Alias { modifier, name, target, line });
    }
    let Some(object_type) = ObjectType::from_word(&kind) else {
        let help = match ObjectType::nearest_word(&kind) {
            Some(word) => format!("did you mean `{word}`?"),
            None => "objects read `modifier type identifier`, then the counts and values of their arguments; look at the end of the object before".to_string(),
        };
        return Err(Error::new(format!("'{}' is not an object type", shortened(&kind))).line(type_line).help(help));
    };
    let name = words.required(&format!("the identifier of a {kind}")).map_err(|e| e.line(line))?;
    let field = |e: Error| e.field(format!("{kind} '{}'", shortened(&name)));
    let (strings, reals) = arguments(words).map_err(|e| field(e).line(line))?;
    Ok(Statement::Object(Object { modifier, kind: object_type, name, strings, reals, line }))
}

fn arguments(words: &mut Words) -> Result<(Vec<String>, Vec<f64>)> {
    let string_count = count(words, "string")?;
    let mut strings = Vec::new();
    for i in 0..string_count {
        let part = |e: Error| e.help(format!("{string_count} string arguments were announced"));
        strings.push(words.required(&format!("string argument {} of {string_count}", i + 1)).map_err(part)?);
    }
    let integer_count = count(words, "integer")?;
    if integer_count != 0 {
        return Err(Error::new(format!("{integer_count} integer arguments are announced, but no object type has any"))
            .line(words.line)
            .help("the second count must be 0"));
    }
    let real_count = count(words, "real")?;
    let mut reals = Vec::new();
    for i in 0..real_count {
        let which = format!("real argument {} of {real_count}", i + 1);
        let word = words.required(&which)?;
        let problem = match word.parse::<f64>() {
            Ok(v) if v.is_finite() => {
                reals.push(v);
                continue;
            }
            Ok(_) => "not a finite number".to_string(),
            Err(_) if word.starts_with('#') => "a comment; Radiance reads none among the arguments".to_string(),
            Err(_) => format!("not a number{}", text::why_no_number(&word)),
        };
        return Err(Error::new(format!("{which} is '{}': {problem}", shortened(&word)))
            .line(words.line)
            .help(format!("give {real_count} finite numbers, or correct the count")));
    }
    Ok((strings, reals))
}

fn count(words: &mut Words, what: &str) -> Result<usize> {
    let word = words.required(&format!("the number of {what} arguments"))?;
    word.parse().map_err(|_| {
        Error::new(format!("the number of {what} arguments is '{}', not a whole number", shortened(&word)))
            .line(words.line)
            .help("after the identifier come three counts: strings (each count is followed by its values), integers (always 0), reals")
    })
}

struct Words<'a> {
    text: &'a [u8],
    position: usize,
    line: usize,
}

impl Words<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.position).copied()
    }

    fn skip_space(&mut self) {
        while let Some(b) = self.peek().filter(|&b| b.is_ascii_whitespace() || b == 0x0b) {
            self.line += usize::from(b == b'\n');
            self.position += 1;
        }
    }

    fn line_of_next(&mut self) -> usize {
        self.skip_space();
        self.line
    }

    /// The rest of the line; with `joined`, a backslash before the line's end continues it.
    fn rest_of_line(&mut self, joined: bool) -> String {
        let mut bytes = Vec::new();
        while let Some(b) = self.peek() {
            self.position += 1;
            if b == b'\n' {
                self.line += 1;
                if bytes.last() == Some(&b'\r') {
                    bytes.pop();
                }
                if !(joined && bytes.last() == Some(&b'\\')) {
                    break;
                }
                bytes.pop();
                bytes.push(b' ');
            } else {
                bytes.push(b);
            }
        }
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// The next word; quotes hold blanks together.
    fn next(&mut self) -> Option<String> {
        self.skip_space();
        let quote = self.peek().filter(|&b| b == b'"' || b == b'\'');
        self.position += usize::from(quote.is_some());
        let start = self.position;
        let ends = |b: u8| quote.map_or(b.is_ascii_whitespace() || b == 0x0b, |q| b == q || b == b'\n');
        while self.peek().is_some_and(|b| !ends(b)) {
            self.position += 1;
        }
        let word = String::from_utf8_lossy(&self.text[start..self.position]).into_owned();
        if quote.is_some() && self.peek() == quote {
            self.position += 1;
        }
        (quote.is_some() || !word.is_empty()).then_some(word)
    }

    fn required(&mut self, what: &str) -> Result<String> {
        self.next().ok_or_else(|| Error::new(format!("the file ends where {what} should stand")).line(self.line))
    }
}

/// A word fit for a message.
pub(crate) fn shortened(word: &str) -> String {
    let mut text: String = word.chars().take(40).map(|c| if c.is_control() { '?' } else { c }).collect();
    if word.chars().nth(40).is_some() {
        text.push('…');
    }
    text
}

//! Statements of a `.rad` file: objects, aliases, commands and `#@rfluxmtx` comments.
//!
//! Only the shape of the text is known here; what the words mean is the business of the modules
//! that use them.

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

/// What the second word of an object says it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ObjectType {
    /// A shape this program cuts into triangles, or a distant source.
    Surface(Surface),
    /// A material this program knows.
    Material(MaterialType),
    /// A pattern or texture: varies a material, which stays usable without it.
    Texture(&'static str),
    /// Part of Radiance, but not of this program: (word, what to do instead).
    Unsupported(&'static str, &'static str),
}

/// Surface types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as in the files")]
pub(super) enum Surface {
    Polygon,
    Ring,
    Sphere,
    Bubble,
    Cylinder,
    Tube,
    Cone,
    Cup,
    Source,
}

/// Material types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "named as in the files")]
pub(super) enum MaterialType {
    Plastic,
    Metal,
    Trans,
    Glass,
    Mirror,
    Light,
    Glow,
}

const SURFACES: [(&str, Surface); 9] = [
    ("polygon", Surface::Polygon),
    ("ring", Surface::Ring),
    ("sphere", Surface::Sphere),
    ("bubble", Surface::Bubble),
    ("cylinder", Surface::Cylinder),
    ("tube", Surface::Tube),
    ("cone", Surface::Cone),
    ("cup", Surface::Cup),
    ("source", Surface::Source),
];

const MATERIALS: [(&str, MaterialType); 7] = [
    ("plastic", MaterialType::Plastic),
    ("metal", MaterialType::Metal),
    ("trans", MaterialType::Trans),
    ("glass", MaterialType::Glass),
    ("mirror", MaterialType::Mirror),
    ("light", MaterialType::Light),
    ("glow", MaterialType::Glow),
];

const TEXTURES: [&str; 14] = [
    "texfunc",
    "texdata",
    "colorfunc",
    "brightfunc",
    "colordata",
    "brightdata",
    "colorpict",
    "colortext",
    "brighttext",
    "spectrum",
    "specfile",
    "specfunc",
    "specdata",
    "specpict",
];

const ANISOTROPIC: &str = "replace it by `plastic`, `metal` or `trans` with a roughness between the two";
const FUNCTION: &str = "replace it by a `plastic`, `metal` or `trans` that fits its mean behaviour";
const REFRACTING: &str = "replace panes by one polygon of `glass`, or make the surface a window with a BSDF file";
const SCATTERING: &str = "make the surface a window with its BSDF file, or replace it by its geometry or a `trans`";
const MIXTURE: &str = "replace it by one material of mean reflectance";
const UNSUPPORTED: [(&str, &str); 28] = [
    ("plastic2", ANISOTROPIC),
    ("metal2", ANISOTROPIC),
    ("trans2", ANISOTROPIC),
    ("ashik2", ANISOTROPIC),
    ("plasfunc", FUNCTION),
    ("metfunc", FUNCTION),
    ("transfunc", FUNCTION),
    ("BRTDfunc", FUNCTION),
    ("plasdata", FUNCTION),
    ("metdata", FUNCTION),
    ("transdata", FUNCTION),
    ("WGMDfunc", FUNCTION),
    ("dielectric", REFRACTING),
    ("interface", REFRACTING),
    ("prism1", REFRACTING),
    ("prism2", REFRACTING),
    ("BSDF", SCATTERING),
    ("aBSDF", SCATTERING),
    ("illum", "replace it by `glow`, or take the surface out of the scene"),
    ("spotlight", "replace it by `light`"),
    ("mist", "take the volume out of the scene"),
    ("antimatter", "cut the opening into the polygons themselves"),
    ("mixfunc", MIXTURE),
    ("mixdata", MIXTURE),
    ("mixpict", MIXTURE),
    ("mixtext", MIXTURE),
    ("instance", "give the `.rad` files the octree was made from, placed with `!xform`"),
    ("mesh", "give the geometry as polygons (`obj2rad` makes them) or as glTF"),
];

impl ObjectType {
    /// The type a word names.
    pub(super) fn from_word(word: &str) -> Option<Self> {
        let surface = SURFACES.iter().find(|(w, _)| *w == word).map(|&(_, s)| Self::Surface(s));
        let material = || MATERIALS.iter().find(|(w, _)| *w == word).map(|&(_, m)| Self::Material(m));
        let texture = || TEXTURES.iter().find(|w| **w == word).map(|w| Self::Texture(w));
        let unsupported = || UNSUPPORTED.iter().find(|(w, _)| *w == word).map(|&(w, help)| Self::Unsupported(w, help));
        surface.or_else(material).or_else(texture).or_else(unsupported)
    }

    /// Its word in the files.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Surface(s) => SURFACES.iter().find(|(_, t)| *t == s).map_or("", |(w, _)| w),
            Self::Material(m) => MATERIALS.iter().find(|(_, t)| *t == m).map_or("", |(w, _)| w),
            Self::Texture(w) | Self::Unsupported(w, _) => w,
        }
    }

    /// Whether other objects can name it as their modifier.
    pub(super) fn is_modifier(self) -> bool {
        !matches!(self, Self::Surface(_) | Self::Unsupported("instance" | "mesh", _))
    }
}

/// Cuts a file's text into statements.
///
/// # Errors
/// Binary data, unknown object types, wrong or missing counts and arguments, with their line.
pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Vec<Statement>> {
    let help = "give `.rad` files";
    if bytes.starts_with(b"#?RADIANCE") && text::Other::of(bytes).is_none() {
        return Err(Error::new("this is an octree, a picture or a matrix, not a scene description").file(file).help(help));
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
        let known = SURFACES
            .iter()
            .map(|(w, _)| *w)
            .chain(MATERIALS.iter().map(|(w, _)| *w))
            .chain(TEXTURES)
            .chain(UNSUPPORTED.iter().map(|(w, _)| *w));
        let nearest = known.map(|w| (edit_distance(w, &kind), w)).min().filter(|(d, _)| *d <= 2);
        let help = match nearest {
            Some((_, word)) => format!("did you mean `{word}`?"),
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

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(40).flat_map(char::to_lowercase).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().flat_map(char::to_lowercase).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

//! The shader linker: a strict subset of WESL's imports.
//!
//! `import package::shared::bvh::{intersect, Ray};` includes `shaders/shared/bvh.wgsl` whole, once,
//! before the file that asks for it, and fails unless that file declares the named items. Names are
//! global: naga reports clashes. `package::generated` is made of what the shader's host declares in
//! Rust: see [`Shader`].

use super::shader::{GENERATED, Shader};
use crate::error::{Error, Result};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// A linked shader: one WGSL text and the way back to its files.
#[derive(Debug, Clone)]
pub struct Linked {
    path: String,
    text: String,
    /// First line (from 1) in `text` of each included file, with its path.
    files: Vec<(usize, String)>,
}

impl Linked {
    /// The path that was linked.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The WGSL text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// File (`shaders/….wgsl`) and line (from 1) from which a line (from 1) of the text came.
    pub fn origin(&self, line: usize) -> (String, usize) {
        let (first, path) = self.files.iter().rev().find(|(first, _)| *first <= line).unwrap_or(&self.files[0]);
        (file_name(path), (line + 1).saturating_sub(*first).max(1))
    }

    /// Parses and validates the text.
    ///
    /// # Errors
    /// naga's message with the file and line of the source it concerns.
    pub fn validate(&self) -> Result<(naga::Module, naga::valid::ModuleInfo)> {
        let place = |message: String, location: Option<naga::SourceLocation>| {
            let error = Error::new(message);
            match location {
                Some(l) => {
                    let (file, line) = self.origin(l.line_number as usize);
                    error.file(file).line(line)
                }
                None => error.file(file_name(&self.path)),
            }
        };
        let module = naga::front::wgsl::parse_str(&self.text).map_err(|e| {
            let label = e.labels().next().map(|(_, l)| format!(": {l}")).unwrap_or_default();
            place(format!("{}{label}", e.message()), e.location(&self.text))
        })?;
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all());
        let info = validator.validate(&module).map_err(|e| {
            let mut message = e.as_inner().to_string();
            let mut source = std::error::Error::source(e.as_inner());
            while let Some(inner) = source {
                message.push_str(&format!(": {inner}"));
                source = inner.source();
            }
            if let Some((_, label)) = e.spans().next() {
                message.push_str(&format!(" ({label})"));
            }
            place(message, e.location(&self.text))
        })?;
        Ok((module, info))
    }
}

fn file_name(path: &str) -> String {
    if path == GENERATED { "package::generated (made from Rust)".to_string() } else { format!("shaders/{path}.wgsl") }
}

/// Links a shader.
///
/// # Errors
/// Unknown files or items, circular imports; with file and line.
pub fn link(shader: &Shader) -> Result<Linked> {
    link_from(shader.path(), &|path| shader.file(path))
}

/// Links the shader at `path` (below `shaders/`, without `.wgsl`) with the texts that `files` gives.
pub(super) fn link_from(path: &str, files: &dyn Fn(&str) -> Option<Cow<'static, str>>) -> Result<Linked> {
    let mut linker = Linker { source: files, done: Vec::new(), open: Vec::new(), parts: Vec::new() };
    linker.include(path)?;
    let mut text = String::new();
    let mut files = Vec::new();
    let mut line = 1;
    for (path, part) in linker.parts {
        files.push((line, path));
        line += part.lines().count();
        text.push_str(&part);
        if !part.ends_with('\n') {
            text.push('\n');
        }
    }
    Ok(Linked { path: path.to_string(), text, files })
}

struct Linker<'a> {
    source: &'a dyn Fn(&str) -> Option<Cow<'static, str>>,
    /// Included files with the names they declare.
    done: Vec<(String, BTreeSet<String>)>,
    open: Vec<String>,
    parts: Vec<(String, String)>,
}

struct Import {
    path: String,
    items: Vec<String>,
    line: usize,
}

impl Linker<'_> {
    fn include(&mut self, path: &str) -> Result<()> {
        if self.done.iter().any(|(p, _)| p == path) {
            return Ok(());
        }
        if self.open.iter().any(|p| p == path) {
            return Err(Error::new(format!("circular import: {} → {path}", self.open.join(" → "))));
        }
        let text = (self.source)(path).ok_or_else(|| {
            Error::new(format!("there is no shader 'shaders/{path}.wgsl'")).help("check the path, and the table in src/gpu/sources.rs")
        })?;
        self.open.push(path.to_string());
        let named = |e: Error| e.file(file_name(path));
        let (imports, plain) = take_imports(&blank_comments(&text)).map_err(named)?;
        for import in imports {
            let place = |e: Error| e.file(file_name(path)).line(import.line);
            self.include(&import.path).map_err(place)?;
            let declared = self.done.iter().find(|(p, _)| *p == import.path).map(|(_, d)| d).expect("just included");
            if let Some(missing) = import.items.iter().find(|i| !declared.contains(*i)) {
                return Err(place(Error::new(format!("'{}' declares no '{missing}'", file_name(&import.path)))));
            }
        }
        self.open.pop();
        self.done.push((path.to_string(), declarations(&plain)));
        self.parts.push((path.to_string(), plain));
        Ok(())
    }
}

/// Replaces comments by blanks; line ends stay, so positions keep their meaning.
fn blank_comments(text: &str) -> String {
    let mut out = text.as_bytes().to_vec();
    let (mut i, mut depth, mut in_line) = (0, 0usize, false);
    while i < out.len() {
        let pair = [out[i], *out.get(i + 1).unwrap_or(&0)];
        if out[i] == b'\n' {
            in_line = false;
        } else if !in_line && pair == *b"/*" {
            depth += 1;
            out[i] = b' ';
            i += 1;
            out[i] = b' ';
        } else if !in_line && depth > 0 && pair == *b"*/" {
            depth -= 1;
            out[i] = b' ';
            i += 1;
            out[i] = b' ';
        } else if depth == 0 && !in_line && pair == *b"//" {
            in_line = true;
            out[i] = b' ';
        } else if in_line || depth > 0 {
            out[i] = b' ';
        }
        i += 1;
    }
    // Only whole comments were replaced, byte by byte, by ASCII blanks.
    String::from_utf8(out).expect("comments end at character boundaries")
}

fn is_word(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b == b'_'
}

/// Reads the word at a position: its end.
fn word_end(bytes: &[u8], mut at: usize) -> usize {
    while bytes.get(at).is_some_and(|b| is_word(*b)) {
        at += 1;
    }
    at
}

/// Cuts the import statements out of a text (they become blanks).
fn take_imports(text: &str) -> Result<(Vec<Import>, String)> {
    let mut out = text.as_bytes().to_vec();
    let mut imports = Vec::new();
    for (start, end) in statements(text, "import") {
        let line = 1 + text[..start].matches('\n').count();
        let statement: String = text[start + "import".len()..end].trim_end_matches(';').split_whitespace().collect();
        let malformed = || {
            Error::new(format!("'import {statement};' is not understood"))
                .line(line)
                .help("write 'import package::folder::file::item;' or 'import package::folder::file::{item, item};'")
        };
        let inner = statement.strip_prefix("package::").ok_or_else(malformed)?;
        let (path, items) = inner.rsplit_once("::").ok_or_else(malformed)?;
        let items: Vec<String> = match items.strip_prefix('{') {
            Some(list) => {
                let list = list.strip_suffix('}').ok_or_else(malformed)?;
                list.split(',').filter(|i| !i.is_empty()).map(str::to_string).collect()
            }
            None => vec![items.to_string()],
        };
        let sound = |name: &str| !name.is_empty() && name.bytes().all(is_word);
        if items.is_empty() || !items.iter().all(|i| sound(i)) || !path.split("::").all(sound) {
            return Err(malformed());
        }
        imports.push(Import { path: path.replace("::", "/"), items, line });
        for b in &mut out[start..end] {
            if *b != b'\n' {
                *b = b' ';
            }
        }
    }
    Ok((imports, String::from_utf8(out).expect("whole statements were replaced")))
}

/// Byte ranges of the top-level statements that begin with a word and end with a semicolon.
fn statements(text: &str, word: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    for (at, name) in top_level_words(text) {
        if name == word {
            let end = text[at..].find(';').map_or(text.len(), |i| at + i + 1);
            found.push((at, end));
        }
    }
    found
}

/// Words outside all braces and parentheses, with their positions.
fn top_level_words(text: &str) -> Vec<(usize, &str)> {
    let bytes = text.as_bytes();
    let (mut depth, mut i, mut words) = (0usize, 0, Vec::new());
    while i < bytes.len() {
        match bytes[i] {
            b'{' | b'(' => depth += 1,
            b'}' | b')' => depth = depth.saturating_sub(1),
            b if is_word(b) => {
                let end = word_end(bytes, i);
                if depth == 0 {
                    words.push((i, &text[i..end]));
                }
                i = end;
                continue;
            }
            _ => {}
        }
        i += 1;
    }
    words
}

/// Names declared at the top level: functions, structs, constants, overrides, aliases, variables.
fn declarations(text: &str) -> BTreeSet<String> {
    let words = top_level_words(text);
    let mut names = BTreeSet::new();
    for (n, (at, word)) in words.iter().enumerate() {
        match *word {
            "fn" | "struct" | "const" | "override" | "alias" => {
                if let Some((_, name)) = words.get(n + 1) {
                    names.insert((*name).to_string());
                }
            }
            "var" => {
                // The name stands before the colon or the equals sign, after an optional <…>.
                let rest = &text[at + 3..];
                let rest = if rest.trim_start().starts_with('<') { rest.split_once('>').map_or("", |(_, r)| r) } else { rest };
                let name: String = rest.trim_start().chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
                names.insert(name);
            }
            _ => {}
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Links `t/main` from these files.
    fn link_texts(files: &[(&str, &str)]) -> Result<Linked> {
        link_from("t/main", &|path| files.iter().find(|(p, _)| *p == path).map(|(_, t)| t.to_string().into()))
    }

    const A: (&str, &str) = ("t/a", "struct Ray { origin: vec3<f32> }\nfn trace(ray: Ray) -> f32 { return ray.origin.x; }\n");
    const B: (&str, &str) =
        ("t/b", "import package::t::a::Ray;\nconst SCALE: f32 = 2.0;\nfn scaled(ray: Ray) -> f32 { return SCALE * ray.origin.y; }");

    fn main(body: &str) -> String {
        format!(
            "{body}\n@group(0) @binding(0) var<storage, read_write> result: array<f32>;\n@compute @workgroup_size(1) fn main() {{ let ray = Ray(vec3<f32>(1.0)); result[0] = trace(ray) + scaled(ray); }}\n"
        )
    }

    #[test]
    fn imports_are_included_once_in_order_and_validate() {
        let text = main("import package::t::b::{scaled, SCALE};\nimport package::t::a::{Ray, trace};");
        let linked = link_texts(&[A, B, ("t/main", &text)]).unwrap();
        assert_eq!(linked.text().matches("struct Ray").count(), 1);
        assert!(linked.text().find("struct Ray") < linked.text().find("fn scaled"));
        linked.validate().unwrap();
        assert!(declarations(linked.text()).contains("result"));
    }

    #[test]
    fn errors_name_the_file_and_line_they_come_from() {
        let text = main("import package::t::a::{Ray, trace};\nimport package::t::b::scaled;");
        let broken = ("t/b", "import package::t::a::Ray;\n\nfn scaled(ray: Ray) -> f32 { return nonsense * ray.origin.y; }");
        let error = link_texts(&[A, broken, ("t/main", &text)]).unwrap().validate().unwrap_err().to_string();
        assert!(error.starts_with("shaders/t/b.wgsl:3:") && error.contains("nonsense"), "{error}");
        // A type error is found by validation, not by the parser.
        let broken = ("t/b", "import package::t::a::Ray;\nfn scaled(ray: Ray) -> f32 {\n  let x = vec2<f32>(1.0);\n  return x;\n}");
        let error = link_texts(&[A, broken, ("t/main", &text)]).unwrap().validate().unwrap_err().to_string();
        assert!(error.starts_with("shaders/t/b.wgsl:"), "{error}");
    }

    #[test]
    fn unknown_files_items_and_circles_are_refused() {
        let run = |text: &str| link_texts(&[A, B, ("t/main", text)]).unwrap_err().to_string();
        assert!(run("\nimport package::t::c::x;").contains("shaders/t/main.wgsl:2: there is no shader 'shaders/t/c.wgsl'"));
        assert!(run("import package::t::a::{Ray, missing};").contains("declares no 'missing'"));
        assert!(run("import t::a::Ray;").contains("not understood"));
        assert!(run("import package::t::a;").contains("there is no shader 'shaders/t.wgsl'"));
        assert!(run("import package::t::a::{};").contains("not understood"));
        assert!(run("import package::t::main::main;\nfn main() {}").contains("circular"));
        assert!(run("import package::generated::x;").contains("there is no"));
        assert!(link(&Shader::new("no/such", &[])).is_err());
    }

    #[test]
    fn comments_nest_as_in_wgsl() {
        assert_eq!(blank_comments("a /* b /* c */ d */ e // f\ng"), format!("a{}e     \ng", " ".repeat(19)));
        assert_eq!(blank_comments("a // /* b\nc"), "a        \nc");
    }

    #[test]
    fn garbage_never_panics() {
        let soup = ["import", "package::", "{", "}", "(", ")", ";", "fn f", "/*", "*/", "//", "\n", "é", "var<", "::", ","];
        let mut state = 1u32;
        for _ in 0..2000 {
            let mut text = String::new();
            for _ in 0..12 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                text.push_str(soup[(state >> 16) as usize % soup.len()]);
            }
            if let Ok(linked) = link_texts(&[("t/main", &text)]) {
                let _ = linked.validate();
            }
        }
    }
}

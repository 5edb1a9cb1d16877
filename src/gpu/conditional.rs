//! Conditional text in shaders: `@if`, `@elif` and `@else` of WESL, in a strict subset.
//!
//! The attribute stands first on its line and applies to the item that follows it (on the same or
//! the next line): an import, a declaration, a struct member or parameter, a statement or a `{}`
//! block. The condition is made of feature names, `!`, `&&`, `||` and parentheses. What is left
//! out becomes blanks, so that line numbers stay.
//!
//! ```wgsl
//! @if(rgb) alias Value = vec3<f32>;
//! @else    alias Value = f32;
//! ```

use crate::error::{Error, Result};
use std::collections::BTreeSet;

/// Replaces comments by blanks; line ends stay, so positions keep their meaning.
pub(super) fn blank_comments(text: &str) -> String {
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

/// Resolves the conditions in `text` (comments already blanked). Names met in conditions are added
/// to `known`.
///
/// # Errors
/// Malformed conditions, `@else` without `@if`, an item without end; with the line.
pub(super) fn resolve(text: &str, features: &[&str], known: &mut BTreeSet<String>) -> Result<String> {
    let mut out = text.as_bytes().to_vec();
    let mut at = 0;
    // State of the chain that ended at this position: (end, whether a branch was already taken).
    let mut chain: Option<(usize, bool)> = None;
    while let Some((start, word, after)) = next_condition(&out, at) {
        let line = line_of(&out, start);
        let fail = |message: &str| Error::new(message).line(line);
        if !out[..start].iter().rev().take_while(|b| **b != b'\n').all(u8::is_ascii_whitespace) {
            return Err(fail("a condition must stand first on its line").help("break the line before '@if'"));
        }
        let continues = word != "if" && chain.is_some_and(|(end, _)| out[end..start].iter().all(u8::is_ascii_whitespace));
        let taken_before = continues && chain.is_some_and(|(_, taken)| taken);
        if word != "if" && !continues {
            return Err(fail(&format!("'@{word}' does not follow the item of an '@if'")));
        }
        let (holds, body) = if word == "else" {
            (true, after)
        } else {
            let open = skip_blanks(&out, after);
            if out.get(open) != Some(&b'(') {
                return Err(fail(&format!("'@{word}' needs a condition in parentheses")));
            }
            let close = matching(&out, open).ok_or_else(|| fail("the condition's parenthesis is not closed"))?;
            let condition = String::from_utf8_lossy(&out[open + 1..close]).into_owned();
            (evaluate(&condition, features, known).map_err(|e| e.line(line))?, close + 1)
        };
        let keep = holds && !taken_before;
        let end = item_end(&out, body).ok_or_else(|| fail("the item after the condition has no end"))?;
        let blank = if keep { start..body } else { start..end };
        for b in &mut out[blank] {
            if *b != b'\n' {
                *b = b' ';
            }
        }
        if keep {
            // Conditions inside the kept item are resolved on their own before the chain goes on.
            let inner = resolve_part(&out[body..end], features, known).map_err(|e| shift(e, line_of(&out, body)))?;
            out.splice(body..end, inner);
        }
        chain = Some((end, taken_before || holds));
        at = end;
    }
    Ok(String::from_utf8(out).expect("whole items were replaced by blanks"))
}

fn resolve_part(bytes: &[u8], features: &[&str], known: &mut BTreeSet<String>) -> Result<Vec<u8>> {
    // The item may begin in the middle of a line; what stands before it was blanked by the caller.
    let text = std::str::from_utf8(bytes).map_err(|_| Error::new("the item splits a character"))?;
    resolve(text, features, known).map(String::into_bytes)
}

/// Turns a line within a part into a line of the file.
fn shift(error: Error, first: usize) -> Error {
    let text = error.to_string();
    let line = text.strip_prefix("line ").and_then(|t| t.split(':').next()).and_then(|n| n.parse::<usize>().ok()).unwrap_or(1);
    Error::new(error.message()).line(first + line - 1)
}

fn line_of(bytes: &[u8], position: usize) -> usize {
    1 + bytes[..position].iter().filter(|b| **b == b'\n').count()
}

fn skip_blanks(bytes: &[u8], mut at: usize) -> usize {
    while bytes.get(at).is_some_and(u8::is_ascii_whitespace) {
        at += 1;
    }
    at
}

pub(super) fn is_word(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b == b'_'
}

/// Reads the word at a position: its end.
pub(super) fn word_end(bytes: &[u8], mut at: usize) -> usize {
    while bytes.get(at).is_some_and(|b| is_word(*b)) {
        at += 1;
    }
    at
}

fn next_condition(bytes: &[u8], mut at: usize) -> Option<(usize, &'static str, usize)> {
    while at < bytes.len() {
        if bytes[at] == b'@' {
            let begin = skip_blanks(bytes, at + 1);
            let end = word_end(bytes, begin);
            for word in ["if", "elif", "else"] {
                if &bytes[begin..end] == word.as_bytes() {
                    return Some((at, word, end));
                }
            }
        }
        at += 1;
    }
    None
}

/// The closing bracket that belongs to the opening one at `open`.
fn matching(bytes: &[u8], open: usize) -> Option<usize> {
    let mut depth = 0usize;
    for (i, b) in bytes.iter().enumerate().skip(open) {
        match b {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => {
                depth = depth.checked_sub(1)?;
                if depth == 0 {
                    return Some(i);
                }
            }
            _ => {}
        }
    }
    None
}

/// One past the last byte of the item that begins at `at`.
fn item_end(bytes: &[u8], at: usize) -> Option<usize> {
    let mut begin = skip_blanks(bytes, at);
    // Further attributes belong to the item: @group(0) @binding(1) @compute @workgroup_size(64).
    while bytes.get(begin) == Some(&b'@') {
        let name = skip_blanks(bytes, begin + 1);
        begin = skip_blanks(bytes, word_end(bytes, name));
        if bytes.get(begin) == Some(&b'(') {
            begin = skip_blanks(bytes, matching(bytes, begin)? + 1);
        }
    }
    let first = &bytes[begin..word_end(bytes, begin)];
    let after = skip_blanks(bytes, begin + first.len());
    let is_member = !first.is_empty() && first != b"default" && first != b"case" && bytes.get(after) == Some(&b':');
    let is_import = first == b"import";
    let (mut i, mut angle) = (begin, 0usize);
    while i < bytes.len() {
        match bytes[i] {
            b'(' | b'[' => i = matching(bytes, i)?,
            b'{' => {
                i = matching(bytes, i)?;
                let next = skip_blanks(bytes, i + 1);
                let next_word = &bytes[next..word_end(bytes, next)];
                // An import's list ends at its semicolon; an `if` goes on with its `else`.
                if !is_import && next_word != b"else" {
                    return Some(i + 1);
                }
            }
            b'<' if is_member => angle += 1,
            b'>' if is_member => angle = angle.saturating_sub(1),
            b',' if is_member && angle == 0 => return Some(i + 1),
            b'}' | b')' if is_member => return Some(i),
            b';' => return Some(i + 1),
            _ => {}
        }
        i += 1;
    }
    None
}

/// Evaluates `a && !(b || c)`.
fn evaluate(condition: &str, features: &[&str], known: &mut BTreeSet<String>) -> Result<bool> {
    let mut parser = Condition { bytes: condition.as_bytes(), at: 0, features, known };
    let value = parser.or()?;
    if skip_blanks(parser.bytes, parser.at) != condition.len() {
        return Err(parser.malformed());
    }
    Ok(value)
}

struct Condition<'a> {
    bytes: &'a [u8],
    at: usize,
    features: &'a [&'a str],
    known: &'a mut BTreeSet<String>,
}

impl Condition<'_> {
    fn malformed(&self) -> Error {
        Error::new(format!("'{}' is not a condition", String::from_utf8_lossy(self.bytes)))
            .help("use feature names, '!', '&&', '||' and parentheses")
    }

    fn eat(&mut self, token: &[u8]) -> bool {
        self.at = skip_blanks(self.bytes, self.at);
        let found = self.bytes[self.at..].starts_with(token);
        if found {
            self.at += token.len();
        }
        found
    }

    fn or(&mut self) -> Result<bool> {
        let mut value = self.and()?;
        while self.eat(b"||") {
            value |= self.and()?;
        }
        Ok(value)
    }

    fn and(&mut self) -> Result<bool> {
        let mut value = self.not()?;
        while self.eat(b"&&") {
            value &= self.not()?;
        }
        Ok(value)
    }

    fn not(&mut self) -> Result<bool> {
        if self.eat(b"!") {
            return Ok(!self.not()?);
        }
        if self.eat(b"(") {
            let value = self.or()?;
            return if self.eat(b")") { Ok(value) } else { Err(self.malformed()) };
        }
        let end = word_end(self.bytes, self.at);
        if end == self.at {
            return Err(self.malformed());
        }
        let name = String::from_utf8_lossy(&self.bytes[self.at..end]).into_owned();
        self.at = end;
        let value = self.features.contains(&name.as_str());
        self.known.insert(name);
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(text: &str, features: &[&str]) -> Result<String> {
        resolve(&blank_comments(text), features, &mut BTreeSet::new())
    }

    fn squeezed(text: &str, features: &[&str]) -> String {
        run(text, features).unwrap().split_whitespace().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn conditions_choose_declarations_members_statements_and_blocks() {
        let text = "@if(rgb) alias V = vec3<f32>;\n@elif(half) alias V = f16;\n@else alias V = f32;\nstruct P {\n a: u32,\n @if(rgb && !half)\n b: array<vec4<f32>, 4>,\n c: f32,\n @if(half) d: f32\n}\nfn f() {\n @if(rgb) { x(); { y(); } }\n @else if (a) { g(); } else { h(); }\n}\n";
        assert_eq!(
            squeezed(text, &["rgb"]),
            "alias V = vec3<f32>; struct P { a: u32, b: array<vec4<f32>, 4>, c: f32, } fn f() { { x(); { y(); } } }"
        );
        assert_eq!(
            squeezed(text, &["half"]),
            "alias V = f16; struct P { a: u32, c: f32, d: f32 } fn f() { if (a) { g(); } else { h(); } }"
        );
        assert_eq!(squeezed(text, &[]), "alias V = f32; struct P { a: u32, c: f32, } fn f() { if (a) { g(); } else { h(); } }");
    }

    #[test]
    fn lines_stay_where_they_are() {
        let text = "// one\n@if(a) fn f() {\n}\n@if(b)\n@group(0) @binding(1) var<storage, read> x: array<u32>;\nfn last() {}\n";
        for features in [&[][..], &["a"], &["b"], &["a", "b"]] {
            let out = run(text, features).unwrap();
            assert_eq!(out.len(), text.len());
            assert_eq!(out.lines().position(|l| l.contains("last")), Some(5));
            assert_eq!(out.contains("storage"), features.contains(&"b"));
        }
    }

    #[test]
    fn nested_conditions_are_resolved_inside_what_is_kept() {
        let text = "@if(a) fn f() {\n @if(b) x();\n @else y();\n}\n@else fn g() {}";
        assert_eq!(squeezed(text, &["a"]), "fn f() { y(); }");
        assert_eq!(squeezed(text, &["a", "b"]), "fn f() { x(); }");
        assert_eq!(squeezed(text, &["b"]), "fn g() {}");
    }

    #[test]
    fn malformed_conditions_are_refused_with_their_line() {
        for (text, line) in [
            ("\n@else fn f() {}", 2),
            ("@if(a fn f() {}", 1),
            ("@if fn f() {}", 1),
            ("\n\n@if(a &&) fn f() {}", 3),
            ("@if(a b) fn f() {}", 1),
            ("fn f() { @if(a) x(); }", 1),
            ("@if(a) fn f(", 1),
            ("@if(a) fn f() {\n\n@else x(); }", 3),
        ] {
            let error = run(text, &["a"]).unwrap_err().to_string();
            assert!(error.starts_with(&format!("line {line}:")), "{text:?}: {error}");
        }
    }

    #[test]
    fn comments_nest_as_in_wgsl() {
        assert_eq!(blank_comments("a /* b /* c */ d */ e // f\ng"), format!("a{}e     \ng", " ".repeat(19)));
        assert_eq!(blank_comments("a // /* b\nc"), "a        \nc");
    }
}

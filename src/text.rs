//! Opening text that people and other programs wrote.
//!
//! All readers of text take their characters from here: a byte order mark is dropped, UTF-16 (as
//! spreadsheets write it) and the single bytes of older systems (Windows-1252, which holds Latin-1)
//! become UTF-8. What is no text at all is called by its name: a web page that was saved in place of
//! the file it shows, an archive, a spreadsheet, a picture.

mod spelling;

pub(crate) use spelling::nearest;

use crate::error::{Error, Result};
use crate::files;
use std::borrow::Cow;
use std::path::Path;

/// Reads a file as text; `what` it should be ("a points file") stands in messages.
///
/// # Errors
/// With the file: if it cannot be read, or is no text.
pub fn read(path: &Path, what: &str) -> Result<String> {
    let bytes = files::read(path)?;
    decode(&bytes, what).map(Cow::into_owned).map_err(|e| e.file(path))
}

/// The text of a file's bytes; `what` it should be stands in messages.
///
/// # Errors
/// If it is no text: what it is instead, or the line of a zero byte.
pub fn decode<'b>(bytes: &'b [u8], what: &str) -> Result<Cow<'b, str>> {
    if let Some(found) = Other::of(bytes) {
        return Err(found.instead_of(what));
    }
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => Cow::Owned(utf16(rest, u16::from_le_bytes)),
        [0xfe, 0xff, rest @ ..] => Cow::Owned(utf16(rest, u16::from_be_bytes)),
        [0xef, 0xbb, 0xbf, rest @ ..] => bytes_as_text(rest),
        _ => bytes_as_text(bytes),
    };
    if let Some(zero) = text.find('\0') {
        let line = 1 + text[..zero].matches('\n').count();
        return Err(Error::new(format!("this is binary data, not {what}")).line(line).help("look whether the right file is named"));
    }
    Ok(text)
}

/// UTF-8 where it is, otherwise one character per byte as Windows-1252 has them.
fn bytes_as_text(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => {
            Cow::Owned(bytes.iter().map(|&b| if let 0x80..=0x9f = b { WINDOWS[usize::from(b) - 0x80] } else { char::from(b) }).collect())
        }
    }
}

/// Windows-1252 from 0x80 to 0x9f, where it differs from Latin-1.
const WINDOWS: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}', '\u{90}', '‘', '’', '“', '”', '•', '–',
    '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// What a file is that is not the text it should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Other {
    name: &'static str,
    help: &'static str,
}

const UNPACK: &str = "unpack it and give the file inside";
const EXPORT: &str = "export it as plain text (CSV or tab-separated) and give that file";
const NO_TEXT: &str = "look whether the right file is named";

/// First bytes of files that are no text.
const SIGNATURES: [(&[u8], Other); 17] = [
    (b"PK\x03\x04", Other { name: "a zip archive (or a spreadsheet or document, which are such archives)", help: UNPACK }),
    (b"PK\x05\x06", Other { name: "an empty zip archive", help: UNPACK }),
    (b"\x1f\x8b", Other { name: "a gzip archive", help: UNPACK }),
    (b"BZh", Other { name: "a bzip2 archive", help: UNPACK }),
    (b"\xfd7zXZ\0", Other { name: "an xz archive", help: UNPACK }),
    (b"7z\xbc\xaf\x27\x1c", Other { name: "a 7z archive", help: UNPACK }),
    (b"Rar!", Other { name: "a rar archive", help: UNPACK }),
    (b"\x28\xb5\x2f\xfd", Other { name: "a zstd archive", help: UNPACK }),
    (b"%PDF-", Other { name: "a PDF document", help: EXPORT }),
    (b"\xd0\xcf\x11\xe0", Other { name: "a spreadsheet or document of older Office programs", help: EXPORT }),
    (b"{\\rtf", Other { name: "a document in rich text format", help: "save it as plain text" }),
    (b"\x89PNG", Other { name: "a PNG picture", help: NO_TEXT }),
    (b"\xff\xd8\xff", Other { name: "a JPEG picture", help: NO_TEXT }),
    (b"\x76\x2f\x31\x01", Other { name: "an OpenEXR picture", help: NO_TEXT }),
    (b"glTF", Other { name: "a binary glTF scene", help: "name it .glb where a scene is asked for" }),
    (b"\x7fELF", Other { name: "a program", help: NO_TEXT }),
    (
        b"version https://git-lfs.github.com/spec/",
        Other {
            name: "a pointer of Git LFS, in place of the file itself",
            help: "fetch the file with `git lfs pull`, or download it itself",
        },
    ),
];

/// Text that belongs elsewhere, by what stands in its first lines.
pub(crate) const GONIOPHOTOMETER: Other = Other {
    name: "a table of a goniophotometer, as pabopto2bsdf reads it",
    help: "fit all files of the measurement together: lucarne bsdf fit *.dat -o sample.sir, then lucarne bsdf convert sample.sir --to t4:6 -o sample.xml",
};
const INTERPOLANT: Other = Other {
    name: "an interpolant of measurements (.sir)",
    help: "turn it into XML: lucarne bsdf convert sample.sir --to t4:6 -o sample.xml",
};
const WEB_PAGE: Other = Other {
    name: "a web page (HTML)",
    help: "the browser saved the page that shows the file: download the file itself (on GitHub the button \"Raw\" leads to it)",
};

impl Other {
    /// What bytes are, if they are nothing that a reader of text or XML takes.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        if let Some((_, found)) = SIGNATURES.iter().find(|(signature, _)| bytes.starts_with(signature)) {
            return Some(*found);
        }
        let head = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let head = bytes_as_text(&head[..head.len().min(4096)]);
        // A page may begin with a comment or the declaration of XML.
        let mut page = head.trim_start();
        while let Some((_, rest)) = ["<!--", "<?"].iter().find(|s| page.starts_with(**s)).and_then(|_| page.split_once('>')) {
            page = rest.trim_start();
        }
        let tag: String = page.chars().take(14).flat_map(char::to_lowercase).collect();
        if tag.starts_with("<!doctype html") || ["<html", "<head", "<body"].iter().any(|t| tag.starts_with(t)) {
            return Some(WEB_PAGE);
        }
        if head.starts_with("#?") && head.lines().any(|l| l.starts_with("FORMAT=BSDF_RBFmesh")) {
            return Some(INTERPOLANT);
        }
        let comments = || head.lines().map_while(|l| l.strip_prefix('#')).map(str::trim_start);
        if comments().any(|l| l.starts_with("format: theta phi")) {
            return Some(GONIOPHOTOMETER);
        }
        None
    }

    /// The error where something else was asked for.
    pub fn instead_of(self, what: &str) -> Error {
        Error::new(format!("this is {}, not {what}", self.name)).help(self.help)
    }
}

/// The words of a line of a table. Blanks and tabs separate them, or semicolons, or commas; a comma
/// within a word is a decimal one where other things separate the words and none of them has a point.
///
/// `1,5;2;0` and `1,5 2 0` give `1.5 2 0`; `1.5,2,0` and `1.5, 2, 0` too.
///
/// # Errors
/// `1,250 2 0` could mean 1.25 or 1250: if nothing else in the line tells which.
pub fn words(line: &str) -> Result<Vec<Cow<'_, str>>> {
    let all = || line.split(|c: char| c.is_whitespace() || c == ';').filter(|w| !w.is_empty());
    let parts = |w: &str| w.split_once(',').map(|(a, b)| (a.trim_start_matches(['-', '+']).to_string(), b.to_string()));
    let digits = |w: &str| !w.is_empty() && w.bytes().all(|b| b.is_ascii_digit());
    // An exponent may follow the fraction.
    let fraction = |w: &str| digits(w.split(['e', 'E']).next().unwrap_or_default());
    let decimal = |w: &str| parts(w).is_none_or(|(a, b)| digits(&a) && fraction(&b));
    if !line.contains(',') || line.contains('.') || all().count() < 2 || !all().all(decimal) {
        return Ok(all().flat_map(|w| w.split(',')).filter(|w| !w.is_empty()).map(Cow::Borrowed).collect());
    }
    let thousands = |w: &str| parts(w).is_some_and(|(a, b)| a.len() <= 3 && !a.starts_with('0') && b.len() == 3 && digits(&b));
    let mut with_comma = all().filter(|w| w.contains(',')).peekable();
    if let Some(first) = with_comma.peek().copied()
        && !line.contains(';')
        && with_comma.all(thousands)
    {
        return Err(Error::new(format!("'{first}' may mean {} or {}", first.replace(',', "."), first.replace(',', "")))
            .help("write decimal points, and no commas between thousands"));
    }
    Ok(all().map(|w| if w.contains(',') { Cow::Owned(w.replace(',', ".")) } else { Cow::Borrowed(w) }).collect())
}

/// Why a word is no number, for messages: a comma where a point should be, or nothing to say.
pub(crate) fn why_no_number(word: &str) -> &'static str {
    let comma = word.replacen(',', ".", 1);
    if word.contains(',') && comma.parse::<f64>().is_ok() { " (write a point in place of the comma)" } else { "" }
}

#[cfg(test)]
mod tests;

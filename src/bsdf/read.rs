//! Reading the XML files of WINDOW 6/7, genBSDF, wrapBSDF and their relatives.
//!
//! The file is read as a stream: memory is that of the data kept, whatever the file's size. Text
//! is taken from the stream directly, so that neither a huge text nor an entity is ever expanded
//! by the XML reader; document type definitions are refused.

mod bases;
mod document;
mod embedded;

use super::Bsdf;
use crate::error::{Error, Result, Warnings};
use crate::limits::{XML_JUNK, XML_MARKUP};
use crate::text;
use document::Document;
use quick_xml::events::Event;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Reads a BSDF file, or what `model.hbjson#modifier` names in a Honeybee model.
///
/// Values are kept as they are, negative ones included. Missing or contradictory headers that can
/// be understood all the same are warnings.
///
/// # Errors
/// File, line and element of what is wrong: not a BSDF file, damaged XML, unknown basis, wrong
/// number of values, values that are not finite numbers, broken trees.
pub fn read(path: &Path, warnings: &mut Warnings) -> Result<Bsdf> {
    if let Some((model, name)) = embedded::split(path) {
        return embedded::read(&model, &name, warnings);
    }
    let file = File::open(path).map_err(|e| Error::io(path, &e))?;
    if file.metadata().is_ok_and(|m| m.is_dir()) {
        return Err(Error::new("this is a folder, not a BSDF file").file(path));
    }
    let mut found = Warnings::new();
    let result = read_from(file, &mut found).map_err(|e| e.file(path));
    for warning in found.iter() {
        warnings.push(warning.clone().file(path));
    }
    result
}

/// Reads a BSDF file from a stream.
///
/// # Errors
/// As [`read`], without the file's name.
pub fn read_from(mut stream: impl Read, warnings: &mut Warnings) -> Result<Bsdf> {
    let (line, beginning) = skip_junk(&mut stream)?;
    let inner = BufReader::with_capacity(1 << 16, io::Cursor::new(beginning).chain(stream));
    let mut xml = quick_xml::Reader::from_reader(Source { inner, line, taken: 0 });
    let mut document = Document::new(warnings);
    let mut buffer = Vec::new();
    loop {
        let line = xml.get_ref().line;
        let at = |e: Error, document: &Document| e.line(line).field(document.place());
        take_text(&mut xml, &mut document).map_err(|e| at(e, &document))?;
        let line = xml.get_ref().line;
        buffer.clear();
        xml.get_mut().taken = 0;
        let event = xml.read_event_into(&mut buffer).map_err(|e| damaged(&e).line(line).field(document.place()))?;
        let end = matches!(event, Event::Eof);
        document.take_event(event, line).map_err(|e| e.line(line).field(document.place()))?;
        if end {
            return document.finish();
        }
    }
}

fn damaged(error: &quick_xml::Error) -> Error {
    match error {
        quick_xml::Error::Io(e) => Error::stream(e),
        e => Error::new(format!("damaged XML: {e}")).help("the file is cut off or was changed by hand; get it again from its source"),
    }
}

/// Reads up to the first XML, drops what stands before it and gives the number of its line and
/// the bytes read from there on.
fn skip_junk(stream: &mut impl Read) -> Result<(usize, Vec<u8>)> {
    let mut head = Vec::new();
    loop {
        let before = head.len();
        stream.take(1 << 16).read_to_end(&mut head).map_err(|e| Error::stream(&e))?;
        if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
            return Err(Error::new("this file is in UTF-16, only UTF-8 is read").help("save it in UTF-8"));
        }
        if let Some(other) = text::Other::of(&head) {
            return Err(other.instead_of("a BSDF file"));
        }
        if let Some(start) = ["<?xml", "<WindowElement", "<!"].iter().filter_map(|tag| find(&head, tag.as_bytes())).min() {
            let line = 1 + head[..start].iter().filter(|b| **b == b'\n').count();
            head.drain(..start);
            return Ok((line, head));
        }
        if head.len() == before || head.len() > XML_JUNK {
            return Err(Error::new("this is not a BSDF file: no <?xml or <WindowElement> at its beginning")
                .help("give the XML file of WINDOW, genBSDF or wrapBSDF"));
        }
    }
}

fn find(text: &[u8], tag: &[u8]) -> Option<usize> {
    text.windows(tag.len()).position(|w| w == tag)
}

/// The file as quick-xml reads it: counts lines and refuses markup without end.
struct Source<R> {
    inner: BufReader<R>,
    line: usize,
    taken: usize,
}

impl<R: Read> Read for Source<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(buffer)?;
        self.consume(n);
        Ok(n)
    }
}

impl<R: Read> BufRead for Source<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken > XML_MARKUP {
            return Err(io::Error::other(format!("a tag or comment longer than {XML_MARKUP} bytes")));
        }
        self.inner.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        let n = amount.min(self.inner.buffer().len());
        self.line += self.inner.buffer()[..n].iter().filter(|b| **b == b'\n').count();
        self.taken += amount;
        self.inner.consume(amount);
    }
}

/// Feeds the text up to the next `<` to the document, in pieces.
fn take_text<R: Read>(xml: &mut quick_xml::Reader<Source<R>>, document: &mut Document) -> Result<()> {
    loop {
        let line = xml.get_ref().line;
        xml.get_mut().taken = 0;
        let mut stream = xml.stream();
        let buffer = stream.fill_buf().map_err(|e| Error::stream(&e))?;
        if buffer.is_empty() {
            return Ok(());
        }
        let end = buffer.iter().position(|b| *b == b'<');
        let piece = &buffer[..end.unwrap_or(buffer.len())];
        document.take_text(piece, line)?;
        let used = piece.len();
        stream.consume(used);
        if end.is_some() {
            return Ok(());
        }
    }
}

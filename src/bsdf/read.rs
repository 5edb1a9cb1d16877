//! Reading the XML files of WINDOW 6/7, genBSDF, wrapBSDF and their relatives.
//!
//! The file is read as a stream: memory is that of the data kept, whatever the file's size. Text
//! is taken from the stream directly, so that neither a huge text nor an entity is ever expanded
//! by the XML reader; document type definitions are refused.

use super::klems::KlemsMatrix;
use super::numbers::NumberList;
use super::tree::TreeParser;
use super::{Block, Bsdf, Component, Geometry};
use crate::bins::AngleBasis;
use crate::error::{Error, Result, Warnings};
use crate::text;
use quick_xml::events::Event;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Deepest nesting of elements; real files have 9 levels.
const DEPTH_LIMIT: usize = 64;
/// Longest tag, comment or processing instruction.
const MARKUP_LIMIT: usize = 1 << 20;
/// Longest text of an element other than data and geometry.
const TEXT_LIMIT: usize = 1 << 16;
/// Longest geometry text that is kept.
const GEOMETRY_LIMIT: usize = 64 << 20;
/// Most values of a matrix, when the bases are not known before the values: 2048 × 2048.
const VALUE_LIMIT: usize = 1 << 22;
/// Most properties of the material that are kept.
const PROPERTY_LIMIT: usize = 64;
/// Most bins of a basis that a file defines.
const BIN_LIMIT: usize = 1 << 14;
/// Most text before the first element (`Recover using: …` of genBSDF).
const JUNK_LIMIT: usize = 1 << 20;

/// Reads a BSDF file.
///
/// Values are kept as they are, negative ones included. Missing or contradictory headers that can
/// be understood all the same are warnings.
///
/// # Errors
/// File, line and element of what is wrong: not a BSDF file, damaged XML, unknown basis, wrong
/// number of values, values that are not finite numbers, broken trees.
pub fn read(path: &Path, warnings: &mut Warnings) -> Result<Bsdf> {
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
        if head.len() == before || head.len() > JUNK_LIMIT {
            return Err(Error::new("this is not a BSDF file: no <?xml or <WindowElement> at its beginning")
                .help("give the XML file of WINDOW, genBSDF or wrapBSDF"));
        }
    }
}

/// The file as quick-xml reads it: counts lines and refuses markup without end.
struct Source<R> {
    inner: BufReader<R>,
    line: usize,
    taken: usize,
}

fn find(text: &[u8], tag: &[u8]) -> Option<usize> {
    text.windows(tag.len()).position(|w| w == tag)
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
        if self.taken > MARKUP_LIMIT {
            return Err(io::Error::other(format!("a tag or comment longer than {MARKUP_LIMIT} bytes")));
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

/// What is known so far.
struct Document<'w> {
    warnings: &'w mut Warnings,
    bsdf: Bsdf,
    /// Names of the open elements.
    path: Vec<String>,
    layers: usize,
    is_window_element: bool,
    structure: Option<String>,
    bases: Vec<Definition>,
    wavelength: Wavelength,
    text: Text,
    /// Unit attribute of the open element.
    unit: String,
}

/// Where the text of the open element goes.
enum Text {
    Ignored,
    Short(String),
    Geometry(Vec<u8>),
    Matrix(NumberList),
    Tree(Box<TreeParser>),
    /// Values of a wavelength that is not kept.
    Skipped,
    /// Data whose first character has not come yet.
    Undecided,
}

/// An angle basis as the file defines it.
#[derive(Default)]
struct Definition {
    name: String,
    lower: Vec<f64>,
    upper: Vec<f64>,
    counts: Vec<usize>,
    line: usize,
}

/// A `WavelengthData` element.
#[derive(Default)]
struct Wavelength {
    name: Option<String>,
    blocks: Vec<Pending>,
}

/// A `WavelengthDataBlock` whose parts come in any order.
#[derive(Default)]
struct Pending {
    component: Option<Component>,
    columns: Option<String>,
    rows: Option<String>,
    data: Option<Data>,
    line: usize,
}

enum Data {
    Numbers(NumberList),
    Tree(Box<TreeParser>),
}

impl<'w> Document<'w> {
    fn new(warnings: &'w mut Warnings) -> Self {
        Self {
            warnings,
            bsdf: Bsdf::default(),
            path: Vec::new(),
            layers: 0,
            is_window_element: false,
            structure: None,
            bases: Vec::new(),
            wavelength: Wavelength::default(),
            text: Text::Ignored,
            unit: String::new(),
        }
    }

    /// The open element, with the component it belongs to, for messages.
    fn place(&self) -> String {
        let element = self.path.last().map_or("the file", String::as_str);
        match self.wavelength.blocks.last().and_then(|b| b.component) {
            Some(component) if self.path.iter().any(|p| p == "WavelengthDataBlock") => format!("{} {element}", component.xml_name()),
            _ => element.to_string(),
        }
    }

    fn parent(&self) -> &str {
        self.path.len().checked_sub(2).map_or("", |i| &self.path[i])
    }

    fn take_event(&mut self, event: Event, line: usize) -> Result<()> {
        match event {
            Event::Start(tag) => self.open(tag.local_name().as_ref(), &tag, line),
            Event::Empty(tag) => {
                self.open(tag.local_name().as_ref(), &tag, line)?;
                self.close(line)
            }
            Event::End(_) => self.close(line),
            Event::CData(text) => self.take_text(text.as_bytes(), line),
            Event::DocType(_) => Err(Error::new("a document type definition (<!DOCTYPE …>) has no place in a BSDF file")
                .help("remove it; entities are not expanded")),
            _ => Ok(()),
        }
    }

    fn open(&mut self, name: impl AsRef<[u8]>, tag: &quick_xml::events::BytesStart, line: usize) -> Result<()> {
        let name = String::from_utf8_lossy(name.as_ref()).into_owned();
        if self.path.len() >= DEPTH_LIMIT {
            return Err(Error::new(format!("elements are nested deeper than {DEPTH_LIMIT} levels")));
        }
        self.path.push(name.clone());
        let attribute = |key: &str| {
            tag.try_get_attribute(key)
                .ok()
                .flatten()
                .map_or_else(String::new, |a| String::from_utf8_lossy(a.value.as_ref().as_ref()).into_owned())
        };
        self.unit = attribute("unit");
        self.text = match name.as_str() {
            "WindowElement" => {
                self.is_window_element = true;
                Text::Ignored
            }
            "Layer" => {
                self.layers += 1;
                if self.layers == 2 {
                    self.warnings.push(Error::new("the file has several layers; the first one is read").line(line).field("Layer"));
                }
                Text::Ignored
            }
            _ if self.layers > 1 => Text::Ignored,
            "Geometry" => {
                self.bsdf.geometry = Some(Geometry { format: attribute("format"), unit: String::new(), text: String::new() });
                Text::Ignored
            }
            "MGFblock" => Text::Geometry(Vec::new()),
            // A block's AngleBasis only names the square of a tree.
            "AngleBasis" if self.parent() != "WavelengthDataBlock" => {
                self.bases.push(Definition { line, ..Definition::default() });
                Text::Ignored
            }
            "WavelengthData" => {
                self.wavelength = Wavelength::default();
                Text::Ignored
            }
            "WavelengthDataBlock" => {
                self.wavelength.blocks.push(Pending { line, ..Pending::default() });
                Text::Ignored
            }
            "ScatteringData" => {
                if self.wavelength.name.as_deref().is_some_and(|n| self.bsdf.band_mut(n).is_none()) {
                    Text::Skipped
                } else {
                    Text::Undecided
                }
            }
            _ if self.parent() == "Material" => Text::Short(String::new()),
            "IncidentDataStructure"
            | "AngleBasisName"
            | "nPhis"
            | "LowerTheta"
            | "UpperTheta"
            | "Wavelength"
            | "WavelengthDataDirection"
            | "ColumnAngleBasis"
            | "RowAngleBasis" => Text::Short(String::new()),
            _ => Text::Ignored,
        };
        Ok(())
    }

    fn take_text(&mut self, piece: &[u8], line: usize) -> Result<()> {
        if let Text::Undecided = self.text {
            let Some(first) = piece.iter().find(|b| !b.is_ascii_whitespace()) else { return Ok(()) };
            self.text = if *first == b'{' {
                let rank = match self.structure.as_deref().unwrap_or_default() {
                    s if s.eq_ignore_ascii_case("TensorTree3") => 3,
                    s if s.eq_ignore_ascii_case("TensorTree4") => 4,
                    other => {
                        return Err(Error::new(format!("the data are a tensor tree, but IncidentDataStructure is '{other}'"))
                            .help("it should be TensorTree3 or TensorTree4"));
                    }
                };
                Text::Tree(Box::new(TreeParser::new(rank)))
            } else {
                Text::Matrix(NumberList::new(VALUE_LIMIT))
            };
        }
        match &mut self.text {
            Text::Ignored | Text::Skipped | Text::Undecided => Ok(()),
            Text::Short(text) => {
                if text.len() + piece.len() > TEXT_LIMIT {
                    return Err(Error::new(format!("more than {TEXT_LIMIT} bytes of text")));
                }
                text.push_str(&String::from_utf8_lossy(piece));
                Ok(())
            }
            Text::Geometry(text) => {
                if text.len() + piece.len() <= GEOMETRY_LIMIT {
                    text.extend_from_slice(piece);
                    return Ok(());
                }
                self.warnings.push(Error::new("the embedded geometry is too large and is left out").line(line).field("MGFblock"));
                self.bsdf.geometry = None;
                self.text = Text::Ignored;
                Ok(())
            }
            Text::Matrix(list) => list.feed(piece, line),
            Text::Tree(tree) => tree.feed(piece, line),
        }
    }

    fn close(&mut self, line: usize) -> Result<()> {
        let text = std::mem::replace(&mut self.text, Text::Ignored);
        let name = self.path.last().cloned().unwrap_or_default();
        let short = match &text {
            Text::Short(s) => unescape(s.trim()),
            _ => String::new(),
        };
        if self.layers <= 1 {
            self.close_known(&name, short, text, line)?;
        }
        self.path.pop();
        Ok(())
    }

    fn close_known(&mut self, name: &str, short: String, text: Text, line: usize) -> Result<()> {
        let in_material = self.parent() == "Material";
        match name {
            "Name" if in_material => self.bsdf.name = short,
            "Manufacturer" if in_material => self.bsdf.manufacturer = short,
            "DeviceType" if in_material => self.bsdf.device_type = short,
            "Thickness" if in_material => self.bsdf.thickness = self.length(&short, line),
            "Width" if in_material => self.bsdf.width = self.length(&short, line),
            "Height" if in_material => self.bsdf.height = self.length(&short, line),
            _ if in_material && !short.is_empty() && self.bsdf.properties.len() < PROPERTY_LIMIT => {
                self.bsdf.properties.push((name.to_string(), short));
            }
            "MGFblock" => {
                if let (Text::Geometry(mgf), Some(geometry)) = (text, &mut self.bsdf.geometry) {
                    geometry.text = unescape(&String::from_utf8_lossy(&mgf));
                    geometry.unit = std::mem::take(&mut self.unit);
                }
            }
            "Geometry" if self.bsdf.geometry.as_ref().is_some_and(|g| g.text.trim().is_empty()) => self.bsdf.geometry = None,
            "IncidentDataStructure" => {
                if !["Columns", "Rows", "TensorTree3", "TensorTree4"].iter().any(|s| s.eq_ignore_ascii_case(&short)) {
                    return Err(
                        Error::new(format!("unknown data structure '{short}'")).help("Columns, Rows, TensorTree3 and TensorTree4 are read")
                    );
                }
                self.structure = Some(short);
            }
            "AngleBasisName" | "nPhis" | "LowerTheta" | "UpperTheta" => self.define_basis(name, short)?,
            "Wavelength" => self.wavelength.name = Some(short),
            "WavelengthDataDirection" | "ColumnAngleBasis" | "RowAngleBasis" | "ScatteringData" => {
                let Some(block) = self.wavelength.blocks.last_mut() else {
                    return Err(Error::new("this element must stand inside a WavelengthDataBlock"));
                };
                match name {
                    "ColumnAngleBasis" => block.columns = Some(short),
                    "RowAngleBasis" => block.rows = Some(short),
                    "WavelengthDataDirection" => {
                        block.component = Some(Component::by_xml_name(&short).ok_or_else(|| {
                            Error::new(format!("unknown direction '{short}'"))
                                .help("it is one of Transmission Front, Transmission Back, Reflection Front, Reflection Back")
                        })?);
                    }
                    _ => {
                        block.data = match text {
                            Text::Matrix(list) => Some(Data::Numbers(list)),
                            Text::Tree(tree) => Some(Data::Tree(tree)),
                            Text::Undecided => {
                                return Err(Error::new("there are no values").help("generate the file again, or take this block out"));
                            }
                            _ => None,
                        };
                    }
                }
            }
            // Resolved at once, so that no more than one block waits as a raw list.
            "WavelengthDataBlock" if self.wavelength.name.is_some() => self.resolve_blocks()?,
            "WavelengthData" => {
                if self.wavelength.name.is_none() && !self.wavelength.blocks.is_empty() {
                    return Err(Error::new("this element has no Wavelength").help("add <Wavelength unit=\"Integral\">Visible</Wavelength>"));
                }
                self.resolve_blocks()?;
            }
            _ => {}
        }
        Ok(())
    }

    fn length(&mut self, text: &str, line: usize) -> Option<f64> {
        if text.is_empty() {
            return None;
        }
        let unit = self.unit.to_ascii_lowercase();
        let metres = match unit.trim() {
            "" | "m" | "meter" | "meters" | "metre" => 1.0,
            "mm" | "millimeter" | "millimeters" => 1e-3,
            "cm" | "centimeter" | "centimeters" => 1e-2,
            "in" | "inch" | "inches" => 0.0254,
            "ft" | "foot" | "feet" => 0.3048,
            _ => f64::NAN,
        };
        let value = text.replacen(',', ".", 1).parse::<f64>().unwrap_or(f64::NAN) * metres;
        if value.is_finite() && value >= 0.0 {
            return Some(value);
        }
        self.warnings.push(Error::new(format!("'{text}' {unit} is not a length; it is ignored")).line(line).field(self.place()));
        None
    }

    fn define_basis(&mut self, element: &str, text: String) -> Result<()> {
        let Some(basis) = self.bases.last_mut() else {
            return Err(Error::new("this element must stand inside an AngleBasis"));
        };
        let number = || {
            text.replacen(',', ".", 1)
                .parse::<f64>()
                .ok()
                .filter(|v| v.is_finite())
                .ok_or_else(|| Error::new(format!("'{text}' is not a number")))
        };
        match element {
            "AngleBasisName" => basis.name = text,
            "LowerTheta" => basis.lower.push(number()?),
            "UpperTheta" => basis.upper.push(number()?),
            _ => {
                let count = text.parse::<usize>().map_err(|_| Error::new(format!("'{text}' is not a number of azimuths")))?;
                basis.counts.push(count);
                if basis.counts.iter().try_fold(0usize, |sum, n| sum.checked_add(*n)).is_none_or(|n| n > BIN_LIMIT) {
                    return Err(Error::new(format!("angle basis '{}' has more than {BIN_LIMIT} bins", basis.name)));
                }
            }
        }
        Ok(())
    }

    /// The basis of this name: the built-in table for known names, else as the file defines it.
    fn basis(&mut self, name: &str) -> Result<Option<AngleBasis>> {
        let definition = self.bases.iter().find(|d| d.name.eq_ignore_ascii_case(name));
        if let Some(known) = AngleBasis::by_name(name) {
            if let Some(d) = definition
                && !d.counts.is_empty()
                && d.build().ok().is_none_or(|b| b.rings() != known.rings())
            {
                let text = format!("the file defines '{name}' otherwise than its name says; the standard table is used");
                self.warnings.push(Error::new(text).line(d.line).field("AngleBasis"));
            }
            return Ok(Some(known));
        }
        match definition {
            Some(d) => d.build().map(Some).map_err(|e| e.line(d.line).field("AngleBasis")),
            None => Ok(None),
        }
    }

    /// Puts the waiting blocks where they belong.
    fn resolve_blocks(&mut self) -> Result<()> {
        let wavelength = self.wavelength.name.clone().unwrap_or_default();
        for block in std::mem::take(&mut self.wavelength.blocks) {
            let line = block.line;
            let at = |e: Error| e.line(line).field("WavelengthDataBlock");
            if self.bsdf.band_mut(&wavelength).is_none() {
                if !self.bsdf.skipped.contains(&wavelength) && self.bsdf.skipped.len() < 1000 {
                    self.bsdf.skipped.push(wavelength.clone());
                }
                continue;
            }
            let component = block
                .component
                .ok_or_else(|| at(Error::new("this block has no WavelengthDataDirection").help("add for instance Transmission Front")))?;
            let place = format!("{wavelength} {}", component.xml_name());
            let data = match block.data {
                None => return Err(at(Error::new("this block has no ScatteringData")).field(place)),
                Some(Data::Tree(tree)) => Block::Tree(tree.finish().map_err(|e| e.line(line).field(place.clone()))?),
                Some(Data::Numbers(list)) => {
                    Block::Klems(self.matrix(list, block.columns, block.rows, line, &place).map_err(|e| e.line(line).field(place.clone()))?)
                }
            };
            let slot = self.bsdf.band_mut(&wavelength).expect("checked above").slot(component);
            if slot.replace(data).is_some() {
                self.warnings.push(Error::new("this block comes twice; the last one is used").line(line).field(place));
            }
        }
        Ok(())
    }

    fn matrix(&mut self, list: NumberList, columns: Option<String>, rows: Option<String>, line: usize, place: &str) -> Result<KlemsMatrix> {
        if self.structure.is_none() {
            self.warnings.push(Error::new("IncidentDataStructure is missing; Columns is assumed").field("DataDefinition"));
            self.structure = Some("Columns".into());
        }
        let mut resolved = [None, None];
        let mut unknown = Vec::new();
        for (slot, name) in resolved.iter_mut().zip([&columns, &rows]) {
            if let Some(name) = name.as_deref().filter(|n| !n.is_empty()) {
                *slot = self.basis(name)?;
                if slot.is_none() {
                    unknown.push(name.to_string());
                }
            }
        }
        // Guessed from the file's only basis, else from the number of values.
        let mut candidates = Vec::new();
        if self.bases.len() == 1 {
            let name = self.bases[0].name.clone();
            candidates.extend(self.basis(&name)?);
        }
        candidates.extend(crate::bins::KlemsBasis::ALL.map(AngleBasis::from));
        let pair = |count: usize| -> Option<(AngleBasis, AngleBasis)> {
            let choices = |known: &Option<AngleBasis>| known.as_ref().map_or_else(|| candidates.clone(), |b| vec![b.clone()]);
            let (c, r) = (choices(&resolved[0]), choices(&resolved[1]));
            c.iter().flat_map(|c| r.iter().map(move |r| (c.clone(), r.clone()))).find(|(c, r)| c.len() * r.len() == count)
        };
        let known = resolved[0].as_ref().zip(resolved[1].as_ref());
        let (values, decimal_commas) = match list.finish(|n| pair(n).is_some())? {
            Ok(found) => found,
            Err(count) => {
                let wanted = match known {
                    Some((c, r)) => {
                        format!("{} × {} = {} values are needed for {} × {}", r.len(), c.len(), c.len() * r.len(), r.name(), c.name())
                    }
                    None if unknown.is_empty() => "no Klems basis has this number of bins".to_string(),
                    None => format!("the basis '{}' is not defined in the file", unknown.join("', '")),
                };
                return Err(Error::new(format!("there are {count} values; {wanted}"))
                    .help("the file is cut off, or its basis does not belong to its data"));
            }
        };
        let (incident, outgoing) = pair(values.len()).expect("the count was accepted");
        if known.is_none() {
            let why = if unknown.is_empty() { "is missing".into() } else { format!("'{}' is not defined", unknown.join("', '")) };
            let text = format!("the basis {why}; {} is assumed from the number of values", incident.name());
            self.warnings.push(Error::new(text).line(line).field(place));
        }
        if decimal_commas {
            self.warnings.push(Error::new("commas are read as decimal points").line(line).field(place));
        }
        let by_rows = self.structure.as_deref().is_some_and(|s| s.eq_ignore_ascii_case("Rows"));
        let values = if by_rows {
            // Text rows are incident directions: transpose.
            let (n_in, n_out) = (incident.len(), outgoing.len());
            (0..n_out * n_in).map(|k| values[k % n_in * n_out + k / n_in]).collect()
        } else {
            values
        };
        KlemsMatrix::new(incident, outgoing, values)
    }

    fn finish(self) -> Result<Bsdf> {
        if let Some(open) = self.path.last() {
            return Err(
                Error::new(format!("the file ends inside the element {open}")).help("the file is cut off; get it again from its source")
            );
        }
        if !self.is_window_element {
            return Err(Error::new("this is not a BSDF file: it has no element WindowElement"));
        }
        let b = &self.bsdf;
        if b.bands().iter().all(|(_, blocks)| blocks.is_empty()) {
            let what = if b.skipped.is_empty() { "no WavelengthData" } else { "neither Visible nor Solar data" };
            return Err(Error::new(format!("the file holds {what}")).help("a BSDF file needs at least one block of wavelength Visible"));
        }
        Ok(self.bsdf)
    }
}

impl Definition {
    fn build(&self) -> Result<AngleBasis> {
        if self.upper.len() != self.counts.len() || (!self.lower.is_empty() && self.lower.len() != self.counts.len()) {
            return Err(Error::new(format!("angle basis '{}' has incomplete blocks", self.name))
                .help("every AngleBasisBlock needs nPhis, LowerTheta and UpperTheta"));
        }
        let mut limits = vec![self.lower.first().copied().unwrap_or(0.0)];
        limits.extend(&self.upper);
        if self.lower.iter().zip(&limits).any(|(lower, limit)| (lower - limit).abs() > 0.01) {
            return Err(Error::new(format!("angle basis '{}': rings do not join ({:?}° up to {:?}°)", self.name, self.lower, self.upper)));
        }
        AngleBasis::from_rings(&self.name, &limits, &self.counts)
    }
}

/// The five entities of XML itself; any other stays as it is written.
fn unescape(text: &str) -> String {
    if !text.contains('&') {
        return text.to_string();
    }
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'").replace("&amp;", "&")
}

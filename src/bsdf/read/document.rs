//! The elements of a BSDF file: what each of them says, and where it belongs.

use super::bases::Bases;
use crate::bsdf::numbers::NumberList;
use crate::bsdf::tree::TreeParser;
use crate::bsdf::{Block, Bsdf, Component, Geometry};
use crate::error::{Error, Result, Warnings};
use crate::limits::{BSDF_GEOMETRY, BSDF_PROPERTIES, BSDF_VALUES, NESTED_ELEMENTS, XML_TEXT};
use quick_xml::events::Event;

/// What is known so far.
pub(super) struct Document<'w> {
    warnings: &'w mut Warnings,
    bsdf: Bsdf,
    /// Names of the open elements.
    path: Vec<String>,
    layers: usize,
    is_window_element: bool,
    structure: Option<String>,
    bases: Bases,
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
    pub fn new(warnings: &'w mut Warnings) -> Self {
        Self {
            warnings,
            bsdf: Bsdf::default(),
            path: Vec::new(),
            layers: 0,
            is_window_element: false,
            structure: None,
            bases: Bases::default(),
            wavelength: Wavelength::default(),
            text: Text::Ignored,
            unit: String::new(),
        }
    }

    /// The open element, with the component it belongs to, for messages.
    pub fn place(&self) -> String {
        let element = self.path.last().map_or("the file", String::as_str);
        match self.wavelength.blocks.last().and_then(|b| b.component) {
            Some(component) if self.path.iter().any(|p| p == "WavelengthDataBlock") => format!("{} {element}", component.xml_name()),
            _ => element.to_string(),
        }
    }

    fn parent(&self) -> &str {
        self.path.len().checked_sub(2).map_or("", |i| &self.path[i])
    }

    pub(crate) fn take_event(&mut self, event: Event, line: usize) -> Result<()> {
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
        if self.path.len() >= NESTED_ELEMENTS {
            return Err(Error::new(format!("elements are nested deeper than {NESTED_ELEMENTS} levels")));
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
                self.bases.begin(line);
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

    pub(crate) fn take_text(&mut self, piece: &[u8], line: usize) -> Result<()> {
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
                Text::Matrix(NumberList::new(BSDF_VALUES))
            };
        }
        match &mut self.text {
            Text::Ignored | Text::Skipped | Text::Undecided => Ok(()),
            Text::Short(text) => {
                if text.len() + piece.len() > XML_TEXT {
                    return Err(Error::new(format!("more than {XML_TEXT} bytes of text")));
                }
                text.push_str(&String::from_utf8_lossy(piece));
                Ok(())
            }
            Text::Geometry(text) => {
                if text.len() + piece.len() <= BSDF_GEOMETRY {
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
            _ if in_material && !short.is_empty() && self.bsdf.properties.len() < BSDF_PROPERTIES => {
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
            "AngleBasisName" | "nPhis" | "LowerTheta" | "UpperTheta" => self.bases.define(name, short)?,
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
                    let by_rows = self.is_by_rows();
                    let mut found = Warnings::new();
                    let matrix = self.bases.matrix(list, [block.columns, block.rows], by_rows, &mut found);
                    found.iter().for_each(|w| self.warnings.push(w.clone().line(line).field(place.clone())));
                    Block::Klems(matrix.map_err(|e| e.line(line).field(place.clone()))?)
                }
            };
            let slot = self.bsdf.band_mut(&wavelength).expect("checked above").slot(component);
            if slot.replace(data).is_some() {
                self.warnings.push(Error::new("this block comes twice; the last one is used").line(line).field(place));
            }
        }
        Ok(())
    }

    /// Whether the rows of the data's text are incident directions.
    fn is_by_rows(&mut self) -> bool {
        let structure = self.structure.get_or_insert_with(|| {
            self.warnings.push(Error::new("IncidentDataStructure is missing; Columns is assumed").field("DataDefinition"));
            "Columns".into()
        });
        structure.eq_ignore_ascii_case("Rows")
    }

    pub fn finish(self) -> Result<Bsdf> {
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

/// The five entities of XML itself; any other stays as it is written.
fn unescape(text: &str) -> String {
    if !text.contains('&') {
        return text.to_string();
    }
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'").replace("&amp;", "&")
}
